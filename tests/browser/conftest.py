"""Chromium and JupyterLab for tests that a person starts: `make browser`."""

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from chromium import NAMES, Browser, found, wait
from lab import Lab

from report.sources import ROOT


def pytest_collection_modifyitems(items):
    """Say why nothing is tested where there is no browser."""
    if found() is None:
        why = f"There is no {', '.join(NAMES[:-1])} or {NAMES[-1]}: Debian's package is chromium."
        for item in items:
            item.add_marker(pytest.mark.skip(reason=why))


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    started = Browser(tmp_path_factory.mktemp("profile"))
    yield started
    started.close()


@pytest.fixture(scope="session")
def lab(browser, tmp_path_factory):
    """Return JupyterLab as `make lab` starts it, on a copy of what the notebooks need."""
    root = tmp_path_factory.mktemp("study")
    for folder in ("notebooks", "tests/references", "report/numbers"):
        shutil.copytree(ROOT / folder, root / folder)
    (root / ".venv").symlink_to(ROOT / ".venv")
    environment = {k: v for k, v in os.environ.items() if k != "PYVISTA_JUPYTER_BACKEND"}
    environment |= {"TUNNELLER_RESULTS": str(root), "JUPYTERLAB_WORKSPACES_DIR": str(root / "w")}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    asked = ["make", "--no-print-directory", "--dry-run", "lab"]
    told = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True)
    lines = told.stdout.replace("\\\n", "").splitlines()
    (command,) = (line for line in lines if "jupyter lab" in line)
    options = (f"--no-browser --port={port} --IdentityProvider.token= "
               "--LabApp.expose_app_in_browser=True")  # fmt: skip
    began = time.monotonic()
    server = subprocess.Popen(f"exec env {command} {options}", shell=True, cwd=root,
                              env=environment, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)  # fmt: skip
    address = f"http://localhost:{port}"
    wait(lambda: server.poll() is not None or answers(f"{address}/api"))
    assert server.poll() is None, f"JupyterLab ended at once: {command} {options}"
    yield Lab(browser, f"{address}/lab/tree/notebooks/00_index.ipynb", began)
    server.terminate()
    server.wait()


def answers(address):
    try:
        return urlopen(address).status == 200
    except URLError:
        return False
