"""Repeat the tests that have a longer form, in that form: `make long`; the results are kept.

A test asks `many(usual, long)` how many cases to try: `make test` tries the usual number. A
property (`@given`) is tried on as many examples as conftest.py says. Each file of tests runs by
itself, and its row of tests/audit/long.md says what came of it, when, and at which commit;
`make long TESTS=tests/test_rod.py` renews that row alone.
"""

import ast
import os
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "tests" / "audit" / "long.md"
LONG = "TUNNELLER_LONG"
HEAD = """\
# Tests in their long form

Cases: how many `make test` tries, and how many `make long` does, for each test or set of cases that
has a long form. Each row is of the day and commit it names.

| tests | cases | result, of a processor | date, commit |
| --- | --- | --- | --- |
"""


def many(usual, long):
    """Return how many cases a test is to try."""
    return long if LONG in os.environ else usual


def asked(path, examples=()):
    """Yield how many cases a file's tests try, usually and here; properties, the `examples`."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        for call in ast.walk(node):
            if isinstance(call, ast.Call) and ast.unparse(call.func) == "many":
                given = map(ast.literal_eval, call.args)
                yield tuple(len(one) if isinstance(one, tuple) else one for one in given)
        around = " ".join(map(ast.unparse, getattr(node, "decorator_list", [])))
        if "given(" in around and "max_examples" not in around:
            yield from examples


def forms():
    """Return, by name, the cases that each file with a longer form tries, usually and here."""
    examples = list(asked(ROOT / "conftest.py"))
    paths = sorted((ROOT / "tests").glob("test_*.py"))
    found = {f"tests/{path.name}": list(dict.fromkeys(asked(path, examples))) for path in paths}
    return {name: cases for name, cases in found.items() if cases}


def repeated(name):
    """Run a file's tests in their long form; return whether they passed, and what came of it."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [sys.executable, "-m", "pytest", "-n", "auto", "--dist", "load", "-q", name]
    run = subprocess.run(command, cwd=ROOT, env=os.environ | {LONG: "1"}, text=True,
                         stdout=subprocess.PIPE)  # fmt: skip
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if run.returncode:
        print(run.stdout)
    said = run.stdout.strip().splitlines()[-1].strip("= ").partition(" in ")[0]
    return not run.returncode, f"{said}, {seconds:.0f} s"


def git(*words, folder=ROOT):
    done = subprocess.run(["git", *words], cwd=folder, text=True, capture_output=True)
    return done.stdout.strip()


def judged():
    """Return the line of a table's head that says when it was made, and of which commit."""
    return f"judged {time.strftime('%F')} at {git('describe', '--always', '--dirty')}"


def main(*names):
    wanted = forms()
    if unknown := set(names) - wanted.keys():
        sys.exit(f"TESTS: must name files with a long form; got {min(unknown)}.")
    before = TABLE.read_text(encoding="utf-8")
    rows = {name: row for row, name in re.findall(r"^(\| (tests/\w+\.py) \|.*)$", before, re.M)}
    _, mark, notes = before.partition("\n## Notes\n")
    commit = git("describe", "--always")
    if git("diff", "--name-only", "HEAD", "--", f":!{TABLE.relative_to(ROOT)}"):
        commit += "-dirty"
    passed = True
    for name in names or wanted:
        passing, said = repeated(name)
        passed &= passing
        cases = "; ".join(f"{usual:,} or {long:,}" for usual, long in wanted[name])
        rows[name] = f"| {name} | {cases} | {said} | {time.strftime('%F')}, {commit} |"
        print(rows[name], flush=True)
        lines = [rows[name] for name in wanted if name in rows]
        TABLE.write_text(HEAD + "\n".join(lines) + "\n" + mark + notes, encoding="utf-8")
    return not passed


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
