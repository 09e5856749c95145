"""Repeat the tests that have a longer form, in that form: `make long`; the result is kept.

A test asks `many(usual, long)` how many cases to try: `make test` tries the usual number. Which
tests ran, how many cases and how long they took goes to tests/long.md.
"""

import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tests" / "long.md"
LONG = "TUNNELLER_LONG"


def many(usual, long):
    """Return how many cases a test is to try."""
    return long if LONG in os.environ else usual


def main():
    tests = sorted((ROOT / "tests").glob("test_*.py"))
    texts = {
        f"tests/{path.name}": path.read_text(encoding="utf-8")
        for path in [ROOT / "tests" / "conftest.py", *tests]
    }
    asked = {
        name: re.findall(r"\bmany\(([\d_]+), ([\d_]+)\)", text) for name, text in texts.items()
    }
    # Properties (`@given`) are tried on as many examples as conftest.py says.
    names = [name for name in texts if name != "tests/conftest.py"
             and (asked[name] or "@given(" in texts[name])]  # fmt: skip
    begun = time.monotonic()
    command = [sys.executable, "-m", "pytest", "-n", "auto", "--dist", "load", "-q", *names]
    process = subprocess.run(command, cwd=ROOT, env=os.environ | {LONG: "1"}, text=True,
                             stdout=subprocess.PIPE)  # fmt: skip
    print(process.stdout)
    minutes = (time.monotonic() - begun) / 60
    commit = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.run(commit, cwd=ROOT, text=True, capture_output=True).stdout.strip()
    said = process.stdout.strip().splitlines()[-1].strip("= ")
    lines = [
        "# Tests in their long form",
        "",
        f"`make long` on {time.strftime('%F')} at {commit}, Python {platform.python_version()}, "
        f"{len(os.sched_getaffinity(0))} cores, {minutes:.0f} min: {said}.",
        "",
        "| tests | cases in `make test` | cases here |",
        "| --- | --- | --- |",
    ]
    for name in texts:
        lines += [f"| {name} | {usual.replace('_', ',')} | {long.replace('_', ',')} |"
                  for usual, long in asked[name]]  # fmt: skip
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
