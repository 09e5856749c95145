"""What all tests share: the same random examples in every run, and files that they say they read.

Hypothesis draws the same examples, so that a test passes or fails for good. A test's module lists
the files of the checkout that it reads, other than modules, as patterns in `READS`: by it
`make check` knows what a change of such a file reaches. A test that reads another one fails.
"""

import gc
import os
import sys
from fnmatch import fnmatch
from pathlib import Path

import pytest
from hypothesis import settings

from report.sources import draws_scenes
from report.tests.check import STUDY
from tests.audit.long import many
from tests.verdicts import judge  # noqa: F401 - a fixture of all tests

ROOT = Path(__file__).parent
SHELVES = ROOT / "tests", ROOT / "report" / "tests"
OURS = tuple(f"{folder}/" for folder in STUDY)  # elsewhere lie a visitor's and tools' files
OWN = (".py", ".pyc", ".nbi", ".nbc")  # followed by imports, and compiled
DATA = "tunneller_lib/"  # of the library, which come with the modules that read them
TOOLS = (".", "pyproject.toml")  # what tools read and keep

settings.register_profile("study", derandomize=True, deadline=None, max_examples=many(20, 200))
settings.load_profile("study")

opened = set()


def _note(event, arguments):
    if event == "open" and isinstance(arguments[0], str | os.PathLike):
        opened.add(os.fspath(arguments[0]))


sys.addaudithook(_note)


def unsaid(module):
    """Return the files opened lately that the tests of a module don't say they read."""
    names = []
    for path in map(Path, filter(lambda path: isinstance(path, str), opened)):
        path = Path(os.path.abspath(path))
        if path.is_relative_to(ROOT) and path.suffix not in OWN:
            name = str(path.relative_to(ROOT))
            ours = name.startswith(OURS) or ("/" not in name and not name.startswith(TOOLS))
            ours = ours and not name.startswith(DATA)
            said = any(fnmatch(name, pattern) for pattern in getattr(module, "READS", []))
            if ours and not said and os.path.isfile(path):
                names.append(name)
    opened.clear()
    return sorted(names)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    opened.clear()
    report = yield
    if isinstance(collector, pytest.Module) and collector.path.parent in SHELVES:
        if report.passed and (names := unsaid(collector.obj)):
            raise pytest.UsageError(f"{collector.path.name}: READS doesn't name {names[0]}.")
    return report


@pytest.fixture(autouse=True)
def _reads_what_it_says(request):
    opened.clear()
    yield
    if request.path.parent in SHELVES and request.path.name.startswith("test_"):
        assert unsaid(request.module) == [], "READS, the list of what the module reads, lacks these"


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Let Python look for no garbage among what is collected, which stays to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items):
    """Leave out what draws scenes where there is no GL library, saying so."""
    paths = dict.fromkeys(item.path for item in items)
    if any(map(draws_scenes, paths)):
        from kit import gl  # here, for the core's tests do without matplotlib

        if not (said := gl.problem()):
            return
        drawing = set(filter(draws_scenes, paths))
        for item in items:
            if item.path in drawing:
                item.add_marker(pytest.mark.skip(reason=said))
