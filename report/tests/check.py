"""Test what the working tree's changes can reach: `make check`.

A changed module reaches the tests and notebooks that import it, directly or through others, and
its own doctests. A changed file, or module, reaches the tests that say that they read it, in a list
`READS`, and a table the notebooks that name it. Where only docstrings, comments or form of a module
changed, nothing is reached through imports. A notebook of which only text changed isn't run: it
counts as the file "NAME.ipynb text", which "notebooks/*" matches, and "notebooks/*.ipynb", the list
of tests that read its code, doesn't. Changes count against the last commit, or against another:
`make check SINCE=main`.
"""

import ast
import fnmatch
import json
import re
import subprocess
import sys
import time

import pytest

from report.reach import meaning, needed
from report.sources import ROOT, code, notebook_sources, notebooks

# New files elsewhere are a visitor's own: an environment, notes.
STUDY = ("figures", "notebooks", "report", "tests", "tunneller_lib")
# Workers take some seconds to start, which so few files, without a notebook, don't win back.
FEW = 8
# What every test depends on: then all of them are meant.
GROUND = ("environment.txt", "pyproject.toml", "conftest.py", "report/tests/notebook_results.py")


def git(*arguments):
    """Return what git prints, or None where it fails."""
    run = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return run.stdout if run.returncode == 0 else None


def changed(since):
    """Return the names of the files that differ from a commit, and of new ones in the study."""
    if git("rev-parse") is None:
        sys.exit("`make check` compares with a commit of git, and here is none: use `make test`.")
    known = git("diff", "--name-only", since)
    new = git("ls-files", "-o", "--exclude-standard", "--", *STUDY)
    if known is None:
        sys.exit(f"SINCE: must name a commit; got {since!r}.")
    return set(known.splitlines()) | set(new.splitlines())


def other_code(names, since):
    """Return the names of the modules whose code, their `meaning`, isn't that of a commit."""

    def differs(name):
        before = git("show", f"{since}:{name}")
        if before is None or not (ROOT / name).exists():
            return True
        try:
            return meaning(before) != meaning((ROOT / name).read_text(encoding="utf-8"))
        except SyntaxError:
            return True

    return {name for name in names if differs(name)}


def only_text(name, since):
    """Tell whether of a notebook only text changed since a commit: its code and outputs didn't."""

    def code(content):
        return [cell for cell in json.loads(content)["cells"] if cell["cell_type"] != "markdown"]

    before = git("show", f"{since}:{name}")
    try:
        return bool(before) and code(before) == code((ROOT / name).read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError):  # gone, or no notebook
        return False


def reads(text):
    """Return the patterns of the files that a file of tests says it reads."""
    said = re.search(r"^READS = (\[.*?\])(?:  # fmt: skip)?$", text, re.M | re.S)
    return ast.literal_eval(said[1]) if said else []


def reached(names, since="HEAD"):
    """Return the tests, doctests and notebooks that changes of files reach, as pytest's arguments.

    Parameters
    ----------
    names : set of str
        Of the changed files, from the checkout's folder.
    since : str
        The commit that they are compared with.
    """
    if names & set(GROUND):
        return ["notebooks", "report/tests", "tests", "tunneller_lib"]
    python = {name for name in names if name.endswith(".py")}
    code_changed = other_code(python, since)
    prose = {name for name in names if name.endswith(".ipynb") and only_text(name, since)}
    names = names - prose | {f"{name} text" for name in prose}
    # Data of the library come with the modules that read them.
    code_changed |= {name for name in names - python if name.startswith("tunneller_lib/")}

    def reaches(text):  # imports are followed only if there is something to meet
        files = needed(text, ROOT) if code_changed else ()
        return any(str(file.relative_to(ROOT)) in code_changed for file in files)

    tables = {name for name in names if name.endswith(".csv")}
    found = []
    for notebook in notebooks():
        name = str(notebook.relative_to(ROOT))
        data = tables and tables & notebook_sources(notebook).keys()
        if name in names or data or reaches(code(notebook)):
            found.append(name)
    shelves = "report/tests", "tests"
    tests = [test for shelf in shelves for test in sorted((ROOT / shelf).glob("test_*.py"))]
    for test in tests:
        name, text = str(test.relative_to(ROOT)), test.read_text(encoding="utf-8")
        read = any(fnmatch.filter(names, pattern) for pattern in reads(text))
        if name in names or read or reaches(text):
            found.append(name)
    library = [name for name in sorted(python) if name.startswith("tunneller_lib/")]
    found += [name for name in library if (ROOT / name).exists()]
    return found


def main(since="HEAD"):
    begun = time.monotonic()
    names = changed(since)
    chosen = reached(names, since)
    print(f"{len(names)} files changed since {since}; they reach {len(chosen)} files of tests.")
    exit_code = subprocess.run(["ruff", "check", "--quiet"], cwd=ROOT).returncode
    if chosen:
        workers = ["-n", "auto", "--dist", "loadfile", "--no-loadscope-reorder"]
        few = len(chosen) <= FEW and not any(name.endswith(".ipynb") for name in chosen)
        workers = [] if few else workers
        exit_code = pytest.main(["-q", *workers, *chosen]) or exit_code
    print(f"{time.monotonic() - begun:.0f} s")
    return int(exit_code)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
