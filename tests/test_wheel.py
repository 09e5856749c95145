"""What `pip install .` brings does a whole cut with nothing beside it but what it asks for."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.test_command import FILES, write_job

READS = ["tunneller_lib/*"]

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGE = ROOT / "tunneller_lib"
DATA = PROJECT["tool"]["setuptools"]["package-data"]
# Runs the installed command with only those packages to be found that the wheel requires.
COMMAND = """
import sys

class Bare:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        known = {"tunneller_lib", *WANTED, *sys.stdlib_module_names}
        if top not in known and not top.startswith("_"):
            raise ModuleNotFoundError(f"No module named {top!r}", name=top)

sys.meta_path.insert(0, Bare())
sys.path.insert(0, sys.argv.pop(1))
from tunneller_lib import __main__
assert __main__.__file__.startswith(sys.path[0])
sys.exit(__main__.main())
"""


@pytest.fixture
def installed(tmp_path):
    """Return a folder with the library alone."""
    package = tmp_path / "site" / PACKAGE.name
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    return package.parent


def test_wheel_has_all_of_the_library():
    """Setuptools packs the modules of folders with an __init__, and data that is declared."""
    files = {p for p in PACKAGE.rglob("*") if p.is_file() and "__pycache__" not in p.parts}
    declared = {
        file
        for package, patterns in DATA.items()
        for pattern in patterns
        for file in ROOT.joinpath(*package.split(".")).glob(pattern)
    }
    assert declared == {file for file in files if file.suffix != ".py"}
    assert {file.parent for file in files} == {file.parent for file in PACKAGE.rglob("__init__.py")}


def test_installed_command_writes_all_of_a_cut_but_the_picture(installed, tmp_path):
    wanted = [re.match(r"\w+", line)[0] for line in PROJECT["project"]["dependencies"]]
    code = f"WANTED = {wanted}\n{COMMAND}"
    command = [
        sys.executable,
        "-c",
        code,
        str(installed),
        "cut",
        write_job(tmp_path),
        "--out",
        "cut",
    ]
    done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert re.search(
        r"^wall\.png is left out: the package \w+ is missing; pip install", done.stderr, re.M
    )
    files = {file.name for file in (tmp_path / "cut").iterdir() if file.stat().st_size}
    assert files == FILES - {"wall.png", "laps.png"}
