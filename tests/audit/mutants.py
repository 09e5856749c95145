"""Plant faults in the library, one at a time, and see whether the tests notice: `make mutants`.

A mutant is the library with one thing changed, of a kind of mutant_kinds.py. Which ones is
drawn from the syntax trees with a seed, for each module by itself, so that an edit of one module
leaves the others' draw alone. Each is judged in a copy of the checkout under build/mutants, by the
tests whose imports lead to its module, the nearest first, and by the notebooks that need it. A test
that fails is run again, so that what failed by chance doesn't count. What was judged before isn't
judged again. The result is mutants.csv, with the score of each room in its head, and what
survivors met: where the nearest tests alone notice 95 % (`--near`), they needn't meet the others.

Mutants that can't be noticed stand in mutants.toml with the reason, count as survivors, and
meet the nearest tests only.

Of some modules: `--of` names them, `--new` takes those that the table has no fault of, and
`--each 5` draws more in each; their rows take the place of those that the table has of them.

In parts: `--shard 1/4` judges every fourth fault and keeps what it found in
build/mutants/judged-1-of-4.json. Such files of other machines, copied there, count as one's own.
Tests that can't run for want of a package are left out; what survives the others is judged where
they can.
"""

import argparse
import ast
import csv
import fcntl
import gc
import hashlib
import importlib
import io
import itertools
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # run as a script
from report.reach import package_of, steps
from report.sources import code
from report.tests.check import reads
from tests.audit.long import judged
from tests.audit.mutant_kinds import FORMULAS, KINDS, LOGIC, Places, draws, rules_in

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "mutants"
COPY = BUILD / "copy"  # all is read here, so that edits of the checkout don't disturb a run
TABLE = ROOT / "tests" / "audit" / "mutants.csv"
REASONS = ROOT / "tests" / "audit" / "mutants.toml"
COLUMNS = ["file", "line", "kind", "before", "after", "killed by"]
SEED = "tunneller"
LENGTHS = 60, 120, 200  # lines from which on a module has one fault more

NEAR, CHUNK = 3, 8  # files of tests that run together: the nearest, then the others
NEAREST, TESTS, NOTEBOOKS = range(3)  # how far a fault has got
MET = ["the nearest tests only", "all tests", "all tests and notebooks"]
FEW = 0.05  # share of survivors of the nearest tests that needn't meet the others
PATIENCE = 60, 10  # s of processor time, and more by the time that tests take on what is unaltered
MEMORY = 12 * 2**30  # bytes a run may ask for, lest a fault fill the machine

HEAVY = (
    "scipy.optimize scipy.integrate scipy.linalg sympy mpmath hypothesis matplotlib.pyplot pyvista "
    "IPython.display nbval"
).split()


@dataclass(frozen=True)
class Mutant:
    """One place of a module changed; `line` and `column` say where it stands."""

    file: str
    line: int
    column: int
    kind: str
    old: str
    new: str

    def lines(self):
        """Return the module's lines, unchanged and changed."""
        before = (COPY / self.file).read_text(encoding="utf-8").splitlines(keepends=True)
        line, after = before[self.line - 1], list(before)
        head, tail = line[: self.column], line[self.column :]
        if not tail.startswith(self.old):
            raise LookupError(f"{self.file}:{self.line} doesn't say {self.old!r}.")
        after[self.line - 1] = head + self.new + tail.removeprefix(self.old)
        return before, after

    def row(self, by):
        """Return the table's row."""
        before, after = (lines[self.line - 1].strip() for lines in self.lines())
        return dict(zip(COLUMNS, [self.file, self.line, self.kind, before, after, by], strict=True))

    def key(self):
        """Return a digest of the module as the fault makes it."""
        return hashlib.sha256("".join([self.file, *self.lines()[1]]).encode()).hexdigest()

    def __str__(self):
        return f"{self.file}:{self.line} {self.kind}"


# ---- what is drawn --------------------------------------------------------------------------


def modules():
    """Return the names of the library's modules and of what notebooks share."""
    files = [*COPY.glob("tunneller_lib/**/*.py"), *COPY.glob("notebooks/*/*.py")]
    every = sorted(str(path.relative_to(COPY)) for path in files)
    return [file for file in every if not file.endswith("__init__.py")]


@cache
def rules():
    """Return the rules of arguments that the library has."""
    for file in modules():
        text = (COPY / file).read_text(encoding="utf-8")
        if re.search(r"^def checked\(", text, re.M):
            return rules_in(text)
    return {}


def draw(file, seed=SEED, each=None):
    """Return a module's mutants: at random, of as many kinds as there are.

    The first of them are the same, however many of `each` module are wanted.
    """
    choice = random.Random(f"{seed} {file}")
    source = (COPY / file).read_text(encoding="utf-8")
    wanted = each or 1 + sum(source.count("\n") >= length for length in LENGTHS)
    places = Places(source, rules())
    found = sorted(set(places.found) - set(places.idle))
    if draws(source):
        found = [place for place in found if place[2] in LOGIC]
    kinds = sorted({place[2] for place in found})
    choice.shuffle(kinds)
    # What holds around formulas has its turn as often as they.
    turns = [kind for kind in kinds if kind in FORMULAS], [k for k in kinds if k not in FORMULAS]
    kinds = [kind for turn in itertools.zip_longest(*turns[::choice.choice((1, -1))])
             for kind in turn if kind]  # fmt: skip
    chosen = []
    for kind in itertools.cycle(kinds):
        if not found or len(chosen) == wanted:
            return chosen
        place = choice.choice([p for p in found if p[2] == kind] or found)
        mutant = Mutant(file, *place)
        if compiles("".join(mutant.lines()[1])):
            chosen.append(mutant)
            found = [p for p in found if p[0] != place[0]]  # another line next
        else:
            found.remove(place)
    return chosen


def compiles(source):
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


# ---- who judges -----------------------------------------------------------------------------


def library_in(text):
    """Yield the modules that a text names in quotes, as what it imports or runs: "tunneller_lib.x".

    A name of a package, or one that goes on, stands for all modules of it.
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if re.fullmatch(r"(tunneller_lib|tests)(\.\w+)*\.?", node.value):
                place = COPY.joinpath(*node.value.strip(".").split("."))
                yield from place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]


@cache
def reach():
    """Return how far each test's imports are from modules: {test: {module: steps}}.

    Tests that read the library's sources look at its form, and those that need the report's own
    programs at the study's build: they judge no fault.
    """
    known = {f"{function.__module__.replace('.', '/')}.py" for function in (steps, code)}
    found = {}
    shelves = COPY / "tests", COPY / "report" / "tests"
    for path in sorted(path for shelf in shelves for path in shelf.glob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        if any(pattern.startswith("tunneller_lib") for pattern in reads(text)):
            continue
        away = steps(text, COPY, package_of(path, COPY))
        for file in library_in(text):
            if file.is_file() and not file.name.startswith("test_"):
                inside = package_of(file, COPY)
                further = steps(file.read_text(encoding="utf-8"), COPY, inside)
                for there, more in {file: 0, **further}.items():
                    away[there] = min(away.get(there, 99), more + 2)
        away = by_name(away)
        programs = {file for file in away if re.match(r"report/.*\.py", file)}
        if programs <= known:
            found[str(path.relative_to(COPY))] = away
    return found


@cache
def reach_of_notebooks():
    found = {}
    for path in sorted((COPY / "notebooks").glob("[0-9]*.ipynb")):
        found[f"notebooks/{path.name}"] = by_name(steps(code(path), COPY))
    return found


def by_name(away):
    return {str(file.relative_to(COPY)): many for file, many in away.items()}


@cache
def public(file):
    """Return the names that a module gives to others."""
    tree = ast.parse((COPY / file).read_text(encoding="utf-8"))
    defined = [n for n in ast.walk(tree) if isinstance(n, (ast.FunctionDef, ast.ClassDef))]
    return {node.name for node in defined if not node.name.startswith("_")}


@cache
def tests_of(file, kind=""):
    """Return the files of tests whose imports lead to a module, the nearest first.

    A test of the module's name comes first; where as many imports lead there, the one that speaks
    of the module's functions more often. What arguments may be is judged early by those that know
    the rules themselves, and an argument's rule by them first, by the contract's before all.
    """
    words = re.compile(rf"\b({'|'.join(sorted(public(file)) or ['-'])})\b")
    about = [other for other in modules() if rules() and "checked" in public(other)]

    def nearness(test):
        away = reach()[test]
        named = re.search(rf"(_|\b){Path(file).stem.strip('_')}(_|\b)", Path(test).stem)
        early = {"rule": 9, "guard": 1, "range": 1}.get(kind, 0)
        knows = early * any(away.get(o) == 1 for o in about)
        spoken = len(words.findall((COPY / test).read_text(encoding="utf-8")))
        contract = kind == "rule" and Path(test).stem == "test_contract"
        return not contract, away[file] - 3 * bool(named) - knows, -spoken, test

    return sorted((test for test in reach() if file in reach()[test]), key=nearness)


def notebooks_of(file):
    found = reach_of_notebooks()
    return sorted((n for n in found if file in found[n]), key=lambda n: (found[n][file], n))


def chunks(file, kind):
    """Return a module's tests as lists that run together, the doctests with the nearest."""
    tests = tests_of(file, kind)
    rest = tests[NEAR:]
    return [[file, *tests[:NEAR]], *(rest[i : i + CHUNK] for i in range(0, len(rest), CHUNK))]


def tests_in(lot, mutant):
    """Return what judges a fault in one of three lots."""
    if lot == NOTEBOOKS:
        return [notebooks_of(mutant.file)]
    every = chunks(mutant.file, mutant.kind)
    return every[:1] if lot == NEAREST else every[1:]


# ---- how tests run --------------------------------------------------------------------------


class First:
    """Notes the first test that fails, and what was said."""

    name = why = ""

    def pytest_runtest_logreport(self, report):
        if report.failed and not self.name:
            self.name, self.why = report.nodeid, str(report.longrepr)[-2000:]

    pytest_collectreport = pytest_runtest_logreport


def run(tree, tests, limit, *, bare, passing=()):
    """Return what failed first in a copy of the checkout, and what was said: or nothing.

    Parameters
    ----------
    tree : pathlib.Path
        The copy.
    tests : list of str
        What pytest is to run.
    limit : float
        Most seconds of processor time.
    bare : bool
        Whether pytest is to do without what notebooks need.
    passing : iterable of str
        Tests that are left out.
    """
    verdict = tree.with_suffix(".verdict")
    verdict.unlink(missing_ok=True)
    fork = multiprocessing.get_context("fork")
    child = fork.Process(target=report, args=(tree, tests, limit, verdict, bare, passing))
    child.start()
    child.join(timeout=600 + 10 * limit)  # for what waits, and takes no processor time
    if child.is_alive():
        child.kill()
        child.join()
        return "(no end)", ""
    if verdict.exists():
        return json.loads(verdict.read_text())
    # ended by a signal, or by a fault that leaves the interpreter
    return "(no end)" if child.exitcode == -signal.SIGXCPU else "(crash)", ""


def report(tree, tests, limit, verdict, bare, passing):
    """Run tests in a copy, in a process of its own, and write down what failed first."""
    # Not by the clock, which also counts what others do on the machine, and its pauses.
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 10))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    gc.freeze()  # pytest collects garbage five times at its end: not in what is shared
    os.chdir(tree)
    ours = [str(tree), str(tree / "notebooks")]
    os.environ["PYTHONPATH"] = os.pathsep.join(ours)  # what tests start, and notebooks, import
    sys.path[:] = [*ours, *(one for one in sys.path if Path(one) not in (ROOT, ROOT / "notebooks"))]
    for name in list(sys.modules):  # ours are those of the copy
        if name.split(".")[0] in ("tunneller_lib", "kit", "exhibits", "tests", "report"):
            del sys.modules[name]
    sys.stdout = sys.stderr = said = io.StringIO()
    first = First()
    # A traceback of pytest's own looks through every module that is imported.
    options = ["-x", "-q", "--tb=native", "-p", "no:cacheprovider"]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # for what is warm
    if bare:
        options += ["-o", "addopts=--doctest-modules --strict-markers"]
    options += [word for test in passing for word in ("--deselect", test)]
    exit_code = pytest.main([*options, *tests], plugins=[first])
    if not first.name and exit_code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        first.name, first.why = "(no test ran)", said.getvalue()[-2000:]
    replace(verdict, json.dumps([first.name, first.why]))


def warm_up():
    """Import what tests need but the library itself, so that each run needn't."""
    settings = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "LP_NUM_THREADS"), "1")
    settings |= {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    # Compiled files are told apart by time and size, which a mutant may share with the next.
    settings |= {"PYVISTA_JUPYTER_BACKEND": "static", "PYTHONDONTWRITEBYTECODE": "1"}
    os.environ.update(settings)
    sys.dont_write_bytecode = True
    for name in HEAVY:
        with suppress(ModuleNotFoundError):
            importlib.import_module(name)


_tree = None


def own_tree():
    """Give a worker a copy of its own."""
    global _tree
    _tree = BUILD / f"copy-{os.getpid()}"
    shutil.copytree(COPY, _tree)


def time_of(test, bare):
    """Return how long a file of tests takes on what is unaltered, what fails, and why."""
    begun = time.process_time() + sum(os.times()[2:4])
    failed, why = run(_tree, [test], 3000, bare=bare)
    return test, time.process_time() + sum(os.times()[2:4]) - begun, failed, why


def judge(mutant, lots, bare):
    """Return the test that notices a fault, or nothing.

    Parameters
    ----------
    mutant : Mutant
    lots : list of (list of str, float)
        Tests that run together, and the processor time that they take on what is unaltered.
    bare : bool
        Whether pytest is to do without what notebooks need.
    """
    target = _tree / mutant.file
    before, after = mutant.lines()
    try:
        target.write_text("".join(after), encoding="utf-8")
        for tests, seconds in lots:
            if by := notice(tests, PATIENCE[0] + PATIENCE[1] * seconds, bare):
                return by
        return ""
    finally:
        target.write_text("".join(before), encoding="utf-8")


def notice(tests, limit, bare):
    """Return the test that fails, and does so again, or nothing."""
    passing = []
    while True:
        by, _ = run(_tree, tests, limit, bare=bare, passing=passing)
        if not by or by.startswith("("):
            return by
        again = by.partition("::")[0] if ".ipynb" in by else by
        if run(_tree, [again], limit, bare=bare)[0]:
            return by
        if len(passing) > 2:
            return ""
        passing.append(by)  # by chance


# ---- what is known --------------------------------------------------------------------------


def copy():
    """Make the copy of the checkout anew."""
    for old in BUILD.glob("copy*"):
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, text=True,
                            capture_output=True)  # fmt: skip
    names = listed.stdout.splitlines()
    if listed.returncode:  # the files alone, without git
        aside = re.compile(r"(\.|build/|.*/?__pycache__/)")
        every = (str(path.relative_to(ROOT)) for path in ROOT.rglob("*"))
        names = [name for name in every if not aside.match(name)]
    for name in names:
        if (ROOT / name).is_file():
            (COPY / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, COPY / name)


def everything():
    """Return one digest of the library and its tests."""
    folders = "tunneller_lib", "notebooks", "tests"
    paths = sorted(path for folder in folders for path in (COPY / folder).rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


@dataclass
class Verdict:
    """What is known of a fault: the test that noticed it, or how far it got.

    `of` is the digest of what it survived, `left` the tests that couldn't run.
    """

    by: str = ""
    of: str = ""
    lot: int = -1
    left: tuple = ()

    def final(self, everything, lot):
        """Return whether there is nothing left to try. After any change survivors are."""
        return bool(self.by) or (self.of == everything and self.lot >= lot and not self.left)


class Known:
    """What was judged before, here and on other machines."""

    def __init__(self, own):
        self.file = BUILD / own
        self.entries = {}
        for file in sorted(BUILD.glob("judged*.json"), key=lambda file: file == self.file):
            for key, entry in json.loads(file.read_text()).items():
                if not self.get(key).by:
                    self.entries[key] = Verdict(**entry)

    def get(self, key):
        return self.entries.get(key, Verdict())

    def put(self, key, verdict):
        self.entries[key] = verdict
        entries = {key: asdict(verdict) for key, verdict in self.entries.items()}
        replace(self.file, json.dumps(entries, indent=0))


def replace(path, text):
    beside = path.with_name(f".{path.name}.new")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


# ---- the table ------------------------------------------------------------------------------


def room(file):
    """Return the room that a module is in."""
    return file.split("/")[1].removesuffix(".py")


def head(rows, seed, met, when):
    """Return what stands above the table: the seed, what survivors `met`, scores, and `when`.

    Of all faults, of those in each room and of those of each kind.
    """

    def score(rows):
        noticed = sum(bool(row["killed by"]) for row in rows)
        return f"{noticed} of {len(rows)}, {100 * noticed / len(rows):.1f} %"

    lines = [f"seed {seed}", f"survivors met {met}", f"all: {score(rows)}"]
    for name in sorted({room(row["file"]) for row in rows}):
        lines.append(f"room {name}: {score([row for row in rows if room(row['file']) == name])}")
    for kind in sorted({row["kind"] for row in rows}):
        lines.append(f"kind {kind}: {score([row for row in rows if row['kind'] == kind])}")
    return "".join(f"# {line}\n" for line in [*lines, when])


def table(rows, seed, met, when):
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return head(rows, seed, met, when) + text.getvalue()


def read_table(text):
    """Return the lines above a table, without their mark, and its rows."""
    lines = text.splitlines(keepends=True)
    above = [line[2:].rstrip("\n") for line in lines if line.startswith("# ")]
    return above, list(csv.DictReader(line for line in lines if not line.startswith("# ")))


# ---- a run ----------------------------------------------------------------------------------


def say(text):
    print(text, file=sys.stderr, flush=True)


def options():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", action="store_true", help="only show what would be planted")
    parser.add_argument("--of", default="", help="only modules with this in their path")
    parser.add_argument("--new", action="store_true", help="only modules that the table has not")
    parser.add_argument("--each", type=int, help="faults in a module, by its length unless told")
    parser.add_argument("--kind", choices=sorted(KINDS), help="only faults of this kind")
    parser.add_argument("--seed", default=SEED, help=f"of the draw, {SEED!r} unless told")
    parser.add_argument("--near", action="store_true", help="only the tests nearest to a module")
    parser.add_argument("--no-notebooks", action="store_true", help="only tests and doctests")
    parser.add_argument("--without", action="append", default=[], metavar="TEST",
                        help="a file of tests that judges nothing")  # fmt: skip
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--shard", default="1/1", help="I/N: the I-th part of N of the faults")
    given = parser.parse_args()
    part = re.fullmatch(r"(\d+)/(\d+)", given.shard)
    if not part or not 1 <= int(part[1]) <= int(part[2]):
        parser.error("--shard: must be I/N with I from 1 to N")
    given.part = int(part[1]), int(part[2])
    return given


def state_of(test):
    """Return a digest of a file of tests, of what it says it reads and of all that it reaches."""
    text = (COPY / test).read_text(encoding="utf-8")
    away = reach().get(test) or reach_of_notebooks().get(test)
    if away is None:  # a module with its examples
        away = by_name(steps(text, COPY, Path(test).parts[:-1]))
    told = {path for pattern in reads(text) for path in COPY.glob(pattern) if path.is_file()}
    every = {COPY / test, *(COPY / file for file in away), *told}
    digest = hashlib.sha256()
    for path in sorted(every):
        digest.update(str(path.relative_to(COPY)).encode() + path.read_bytes())
    return digest.hexdigest()


def times(pool, wanted, bare):
    """Return how long tests take on what is unaltered: {test: seconds}.

    They pass, which is known until something changes that they reach. Those that can't run for
    want of a package aren't there.
    """
    file = BUILD / "times.json"
    kept = json.loads(file.read_text()) if file.exists() else {}
    now = {test: state_of(test) for test in wanted}
    found = {test: kept[test]["seconds"] for test in wanted
             if test in kept and kept[test]["of"] == now[test]}  # fmt: skip
    jobs = [pool.submit(time_of, test, bare) for test in wanted if test not in found]
    if jobs:
        say(f"{len(jobs)} files of tests run on what is unaltered.")
    wrong = []
    for done in as_completed(jobs):
        test, seconds, failed, why = done.result()
        missing = re.search(r"No module named '\w+|could not import '\w+", why)
        if failed and not missing:
            wrong.append(f"{failed}\n{why}")
            continue
        found[test] = None if failed else seconds
        if failed:
            say(f"left out: {test}, {missing[0]}'")
        kept[test] = {"of": now[test], "seconds": found[test]}
        replace(file, json.dumps(kept, indent=0))
    if wrong:
        rule = "Tests must pass before a fault is planted, or be left out by --without:"
        sys.exit("\n".join([rule, *wrong]))
    return {test: found[test] for test in wanted if found[test] is not None}


def last_lot(given):
    """Return how far faults are to get that nothing notices."""
    return NEAREST if given.near else TESTS if given.no_notebooks else NOTEBOOKS


def try_all(mutants, known, given, explained):
    """Judge the mutants that aren't yet, and keep what came out."""
    last = last_lot(given)
    now = everything()

    def lot_of(mutant):
        return NEAREST if (mutant.file, mutant.row("")["after"]) in explained else last

    waiting = [m for m in mutants if not known.get(m.key()).final(now, lot_of(m))]
    if not waiting:
        return
    warm_up()
    bare = "nbval" not in sys.modules
    if bare and last == NOTEBOOKS:
        sys.exit("Notebooks need nbval, which isn't here; without them: --no-notebooks.")
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(given.workers, mp_context=fork, initializer=own_tree) as pool:
        for lot in range(last + 1):
            plans = {}
            for mutant in waiting:
                was = known.get(mutant.key())
                if was.by or lot > lot_of(mutant):
                    continue
                if was.of != now:
                    was = Verdict(of=now)
                wanted = tests_in(lot, mutant)
                if was.lot >= lot:  # what couldn't run where it was judged
                    wanted = [[test for test in tests if test in was.left] for tests in wanted]
                wanted = [[t for t in tests if t not in given.without] for tests in wanted]
                plans[mutant] = was, [tests for tests in wanted if tests]
            every = sorted({t for _, lots in plans.values() for tests in lots for t in tests})
            seconds = times(pool, every, bare)
            jobs = {}
            for mutant, (was, wanted) in plans.items():
                lots = [[test for test in tests if test in seconds] for tests in wanted]
                lots = [(tests, sum(seconds[t] for t in tests)) for tests in lots if tests]
                tried = {test for tests in wanted for test in tests}
                left = (set(was.left) - tried) | (tried - seconds.keys())
                job = pool.submit(judge, mutant, lots, bare)
                jobs[job] = mutant, max(lot, was.lot), tuple(sorted(left))
            for count, done in enumerate(as_completed(jobs), start=1):
                mutant, reached, left = jobs[done]
                try:
                    by = done.result()
                except Exception as problem:  # of the judges, not of the fault: tried next time
                    say(f"{lot + 1}: {count}/{len(jobs)} {mutant}: not judged, {problem!r}")
                    continue
                known.put(mutant.key(), Verdict(by, now, reached, () if by else left))
                say(f"{lot + 1}: {count}/{len(jobs)} {mutant}: {by or 'not noticed'}")


def main():
    given = options()
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / "lock").open("w") as alone:
        try:
            fcntl.flock(alone, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sys.exit("Another run is using build/mutants.")
        plant(given)


def plant(given):
    """Draw faults, have them judged, and say what came out."""
    copy()
    above, before = read_table(TABLE.read_text(encoding="utf-8") if TABLE.exists() else "")
    old = {row["file"] for row in before}
    files = [file for file in modules() if given.of in file and not (given.new and file in old)]
    drawn = [draw(file, given.seed, given.each) for file in files]
    # Each module's first, then the second ones.
    every = [mutant for turn in itertools.zip_longest(*drawn) for mutant in turn if mutant]
    part, parts = given.part
    mutants = [m for m in every if given.kind in (None, m.kind)][part - 1 :: parts]
    if given.list:
        rows = [mutant.row("") for mutant in mutants]
        print(table(rows, given.seed, "nothing yet", "not judged"), end="")
        return
    known = Known("judged.json" if parts == 1 else f"judged-{part}-of-{parts}.json")
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8")) if REASONS.exists() else {}
    explained = {(entry["file"], entry["after"]) for entry in reasons.values()}
    try_all(mutants, known, given, explained)

    verdicts = {mutant: known.get(mutant.key()) for mutant in mutants}
    rows = [mutant.row(verdict.by) for mutant, verdict in verdicts.items()]
    met = MET[last_lot(given)]
    say(head(rows, given.seed, met, judged()))
    for mutant, verdict in verdicts.items():
        if not verdict.by:
            row = mutant.row("")
            why = "" if (row["file"], row["after"]) in explained else ", unexplained"
            why += f", {len(verdict.left)} files of tests couldn't run" if verdict.left else ""
            say(f"survived{why}: {row['file']}:{row['line']} {row['before']}  ->  {row['after']}")
    if others := [row for row in before if row["file"] in set(modules()) - set(files)]:
        if above[0] != f"seed {given.seed}":
            sys.exit("No table: its other faults are of another seed.")
        rows += others
        met = min(met, above[1].removeprefix("survivors met "), key=MET.index)  # all met these
    if given.near and sum(not row["killed by"] for row in rows) > FEW * len(rows):
        say("No table: more than a twentieth survived the nearest tests, and has to meet all.")
    elif mutants == every:
        left = Counter(test for verdict in verdicts.values() for test in verdict.left)
        if left:
            sys.exit("No table: some survivors wait for tests that need other packages.")
        rows = sorted(rows, key=lambda row: (row["file"], int(row["line"])))
        replace(TABLE, table(rows, given.seed, met, judged()))


if __name__ == "__main__":
    main()
