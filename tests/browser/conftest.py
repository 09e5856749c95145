"""Chromium and JupyterLab for tests that a person starts: `make browser`."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import firefox
from chromium import NAMES, Browser, found
from lab import started


def pytest_collection_modifyitems(items):
    """Say why nothing is tested where there is no browser."""
    if found() is None:
        why = f"There is no {', '.join(NAMES[:-1])} or {NAMES[-1]}: Debian's package is chromium."
        for item in items:
            item.add_marker(pytest.mark.skip(reason=why))


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture
def screen(browser):
    """Return what gives the browser another screen, for one test."""
    yield browser.screen
    browser.plain_screen()


@pytest.fixture(scope="module")
def fox(tmp_path_factory):
    if firefox.found() is None:
        pytest.skip("There is no firefox: Debian's package is firefox-esr.")
    opened = firefox.Firefox(tmp_path_factory.mktemp("fox"))
    yield opened
    opened.close()


@pytest.fixture(scope="session")
def lab(browser, tmp_path_factory):
    with started(browser, tmp_path_factory.mktemp("study")) as lab:
        yield lab
