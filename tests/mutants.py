"""Plant faults in the library, one at a time, and see whether the tests notice: `make mutants`.

A mutant is the library with one token changed: a sign, an exponent, a factor, an index, a
comparison or a constant. Which ones is drawn from the syntax trees with a fixed seed, for each
module by itself, so that an edit of one module leaves the others' draw alone. Each is judged in a
copy of the checkout under build/mutants: by the tests that speak of its module, then by all others,
then by the notebooks. What was judged before is not judged again. The result is tests/mutants.csv.
Mutants that can't be noticed stand in tests/mutants.toml with the reason, count as survivors, and
meet the nearest tests only.
"""

import argparse
import ast
import csv
import fcntl
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
import tokenize
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "mutants"
COPY = BUILD / "copy"  # all is read here, so that edits of the checkout don't disturb a run
TABLE = ROOT / "tests" / "mutants.csv"
REASONS = ROOT / "tests" / "mutants.toml"
COLUMNS = ["file", "line", "kind", "before", "after", "killed by"]
SEED = "tunneller"
EACH, SHORT = 2, 130  # mutants of a module; only one where it has fewer lines
LIMITS = 300, 3000, 3000  # s of processor time for each lot; what doesn't end is noticed too

HEAVY = (
    "scipy.optimize scipy.integrate scipy.linalg sympy mpmath hypothesis matplotlib.pyplot pyvista "
    "IPython.display nbval"
).split()
# Pictures, pages and files are looked at or compared, and hold no formula; of that room only the
# way of the numbers into the report is altered.
LEFT_OUT = re.compile(r".*/__\w+__\.py|.*/reporting/(?!number_format|record|sweep).*")
# Tests of the study's form, of its build and of this script: none runs a formula.
FORM = {
    f"tests/test_{name}.py"
    for name in "build layout ledger mutants planted report site style".split()
}
OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "==", "and": "or",
            "or": "and", "+": "-", "-": "+", "+=": "-=", "-=": "+="}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One token of a module changed; `line` and `column` say where it stands."""

    file: str
    line: int
    column: int
    kind: str
    old: str
    new: str

    def lines(self):
        """Return the module's lines, unchanged and changed."""
        before = (COPY / self.file).read_text().splitlines(keepends=True)
        line, after = before[self.line - 1], list(before)
        head, tail = line[: self.column], line[self.column :]
        after[self.line - 1] = head + self.new + tail.removeprefix(self.old)
        return before, after

    def row(self, by):
        """Return the table's row."""
        before, after = (lines[self.line - 1].strip() for lines in self.lines())
        return dict(zip(COLUMNS, [self.file, self.line, self.kind, before, after, by], strict=True))


def more(number):
    """Return a constant with its last printed digit one greater."""
    digits = int(number.replace(".", "")) + 1
    decimals = len(number.partition(".")[2])
    text = str(digits).zfill(decimals + 1)
    return f"{text[:-decimals]}.{text[-decimals:]}" if decimals else text


class Places(ast.NodeVisitor):
    """Collect the mutants of a module: `found` as (line, column, kind, old, new)."""

    def __init__(self, source):
        tokens = tokenize.generate_tokens(io.StringIO(source).readline)
        words = tokenize.OP, tokenize.NAME, tokenize.NUMBER
        self.tokens = [(token.start, token.string) for token in tokens if token.type in words]
        self.found, self.idle = [], []
        self.visit(ast.parse(source))

    def add(self, kind, start, end, change):
        """Take the one token between two places of the source that `change` has a word for."""
        for place, old in self.tokens:
            if start <= place < end and (new := change(old)) is not None:
                self.found.append((*place, kind, old, new))
                return

    def leave_out(self, start, end):
        """Note places whose change isn't a fault in a formula."""
        self.idle += [place for place in self.found if start <= place[:2] < end]

    def between(self, kind, left, right, change):
        self.add(kind, end_of(left), start_of(right), change)

    def number(self, kind, node, change):
        if isinstance(node, ast.UnaryOp):
            node, change = node.operand, more  # -1 becomes -2, and not 0
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            self.add(kind, start_of(node), end_of(node), change)

    def visit_BinOp(self, node):
        kinds = {ast.Add: "sign", ast.Sub: "sign", ast.Mult: "factor", ast.Div: "factor"}
        kind = kinds.get(type(node.op))
        if kind == "sign" and not (joins(node.left) or joins(node.right)):
            self.between(kind, node.left, node.right, OPPOSITE.get)
        if kind == "factor" and not (joins(node.left) or joins(node.right)):
            twice = {"*": "* 2 *", "/": "/ 2 /"}
            self.between("factor", node.left, node.right, twice.get)
            self.between("exponent", node.left, node.right, {"*": "/", "/": "*"}.get)
        if isinstance(node.op, ast.Pow):
            self.number("exponent", node.right, lambda n: str(int(n) + 1) if n.isdigit() else None)
            self.visit(node.left)
        else:
            self.generic_visit(node)
        if guards(node.left) or guards(node.right):  # what is added to a divisor that may be 0
            self.leave_out(end_of(node.left), end_of(node))

    def visit_AugAssign(self, node):
        self.between("sign", node.target, node.value, {"+=": "-=", "-=": "+="}.get)
        self.visit(node.value)

    def visit_UnaryOp(self, node):
        if isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
            self.add("sign", start_of(node), end_of(node), {"-": "+"}.get)
        self.generic_visit(node)

    def visit_Compare(self, node):
        if len(node.ops) == 1:
            self.between("branch", node.left, node.comparators[0], OPPOSITE.get)
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        self.between("branch", *node.values[:2], OPPOSITE.get)
        self.generic_visit(node)

    def visit_Subscript(self, node):
        inside = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        for index in inside:
            ends = [index.lower, index.upper] if isinstance(index, ast.Slice) else [index]
            for end in ends:
                self.number("index", end, lambda n: str(int(n) - 1) if n > "0" else "1")
        self.visit(node.value)

    def visit_Constant(self, node):
        # Tolerances are written with an exponent; they are no one's formula.
        self.number("constant", node, lambda n: None if "e" in n.lower() else more(n))

    def visit_keyword(self, node):
        if node.arg not in ("axis", "ndim", "shape", "stacklevel", "decimals", "initial"):
            self.visit(node.value)

    def visit_Call(self, node):
        name = ast.unparse(node.func).rpartition(".")[2]
        if name in ("reshape", "moveaxis", "expand_dims", "swapaxes", "range", "lru_cache"):
            return  # how arrays lie and how often a loop may run
        self.generic_visit(node)

    def visit_Raise(self, node):
        """Messages stay."""

    visit_JoinedStr = visit_Raise

    def visit_FunctionDef(self, node):
        for default in [*node.args.defaults, *filter(None, node.args.kw_defaults)]:
            self.visit(default)
            self.leave_out(start_of(default), end_of(default))  # how finely, how often
        for statement in node.body:
            self.visit(statement)

    def visit_AnnAssign(self, node):
        if node.value:
            self.visit(node.value)


def start_of(node):
    return node.lineno, node.col_offset


def end_of(node):
    return node.end_lineno, node.end_col_offset


def joins(node):
    """Tell whether + and * join or repeat it, as with text, lists and shapes."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str)
    if isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp)):
        return True
    return bool(re.search(r"\bshape\b|Path|folder|root\b.*\bname|suffix", ast.unparse(node)))


def guards(node):
    return isinstance(node, ast.Compare) or "finfo" in ast.unparse(node)


def modules():
    every = sorted(str(path.relative_to(COPY)) for path in COPY.glob("tunneller_lib/**/*.py"))
    return [file for file in every if not LEFT_OUT.fullmatch(file)]


def draw(file):
    """Return a module's mutants: at random, of as many kinds as there are."""
    draws = random.Random(f"{SEED} {file}")
    source = (COPY / file).read_text()
    each = EACH if source.count("\n") >= SHORT else 1
    # Columns of the syntax tree count bytes, those of tokens characters.
    if not source.isascii():
        source = re.sub(r"[^\x00-\x7f]", "?", source)
    places = Places(source)
    found = sorted(set(places.found))
    kinds = sorted({place[2] for place in found})
    draws.shuffle(kinds)
    chosen = []
    while found and len(chosen) < each:
        kind = kinds[len(chosen) % len(kinds)]
        place = draws.choice([p for p in found if p[2] == kind] or found)
        if place in places.idle:
            found.remove(place)
            continue
        found = [p for p in found if p[0] != place[0]]  # another line next
        chosen.append(Mutant(file, *place))
    return chosen


def public(file):
    """Return the names that a module gives to others."""
    tree = ast.parse((COPY / file).read_text())
    defined = [n for n in ast.walk(tree) if isinstance(n, (ast.FunctionDef, ast.ClassDef))]
    return {node.name for node in defined if not node.name.startswith("_")}


def tests_of(file):
    """Return the tests in three lots: those nearest to a module, the others, the notebooks."""
    words = re.compile(rf"\b({'|'.join(sorted(public(file)) or ['-'])})\b")
    stem, room = Path(file).stem, ".".join(Path(file).parts[:2]).removesuffix(".py")
    near = {}
    for path in sorted((COPY / "tests").glob("test_*.py")):
        if (name := f"tests/{path.name}") not in FORM:
            text = path.read_text()
            near[name] = len(words.findall(text)) + 5 * (room in text) + 1000 * (stem in path.stem)
    names = sorted(near, key=lambda name: -near[name])
    rest = [other for other in modules() if other != file]
    return [file, *names[:4]], [*names[4:], *rest], ["notebooks"]


class First:
    """Notes the first test that fails."""

    name = ""

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.name = self.name or report.nodeid

    pytest_collectreport = pytest_runtest_logreport


def run(tests, limit):
    """Return what failed first in the copy: a test, nothing, or that there was no end."""
    verdict = BUILD / "verdict"
    verdict.unlink(missing_ok=True)
    child = multiprocessing.get_context("fork").Process(target=report, args=(tests, limit, verdict))
    child.start()
    child.join()
    if verdict.exists():
        return verdict.read_text()
    if child.exitcode < 0:
        return "(no end)" if child.exitcode == -signal.SIGXCPU else "(crash)"
    sys.exit("pytest could not be run at all.")


def report(tests, limit, verdict):
    """Run tests in the copy, in a process of its own, and write down what failed first."""
    # Not by the clock, which also counts what others do on the machine, and its pauses.
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 10))
    os.chdir(COPY)
    sys.path[0] = str(COPY)
    sys.stdout = sys.stderr = open(os.devnull, "w")
    first = First()
    options = ["-x", "-q", "--tb=no", "-p", "no:cacheprovider"]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # for what is warm
    code = pytest.main([*options, *tests], plugins=[first])
    replace(verdict, first.name or ("(no test ran)" if code else ""))


def warm_up():
    """Import what tests need but the library itself, so that each run needn't."""
    settings = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "LP_NUM_THREADS"), "1")
    settings |= {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    # Compiled files are told apart by time and size, which a mutant may share with the next.
    settings |= {"PYVISTA_JUPYTER_BACKEND": "static", "PYTHONDONTWRITEBYTECODE": "1"}
    settings |= {"PYTHONPATH": str(COPY)}  # what the notebooks import
    os.environ.update(settings)
    sys.dont_write_bytecode = True
    for name in HEAVY:
        importlib.import_module(name)


def judge(mutant, lot):
    """Return the test of one of a module's lots that notices a mutant, or nothing."""
    target = COPY / mutant.file
    before, after = mutant.lines()
    try:
        target.write_text("".join(after))
        return run(tests_of(mutant.file)[lot], LIMITS[lot])
    finally:
        target.write_text("".join(before))


def copy():
    """Make the copy of the checkout anew."""
    shutil.rmtree(COPY, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, text=True,
                            capture_output=True, check=True).stdout  # fmt: skip
    for name in listed.splitlines():
        if (ROOT / name).is_file():
            (COPY / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, COPY / name)


def digest(paths):
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


def everything():
    """Return one digest of the library and its tests."""
    return digest(sorted([*COPY.glob("tunneller_lib/**/*.py"), *COPY.glob("tests/*.py")]))


class Known:
    """What was judged before. After any change only those which survived are judged again."""

    def __init__(self):
        self.file, self.all = BUILD / "judged.json", everything()
        self.entries = json.loads(self.file.read_text()) if self.file.exists() else {}

    def judge(self, name, key, lot, action):
        """Return the test that notices it, found before or now."""
        by, seen, done = self.entries.get(key, ("", "", -1))
        if by or (seen == self.all and done >= lot):
            return by
        start = time.monotonic()
        by = action()
        self.entries[key] = by, self.all, lot
        self.save()
        say(f"{name}: {by or 'not noticed'} ({time.monotonic() - start:.0f} s)")
        return by

    def forget(self, key):
        del self.entries[key]
        self.save()

    def save(self):
        replace(self.file, json.dumps(self.entries, indent=0))


def replace(path, text):
    beside = path.with_name(f".{path.name}.new")
    beside.write_text(text)
    os.replace(beside, path)


def table(rows):
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def say(text):
    print(text, file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", action="store_true", help="only show what would be planted")
    parser.add_argument("--of", default="", help="only modules with this in their path")
    parser.add_argument("--near", action="store_true", help="only the tests nearest to a module")
    options = parser.parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    alone = (BUILD / "lock").open("w")  # until we end
    try:
        fcntl.flock(alone, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit("Another run is using build/mutants.")
    copy()
    drawn = [draw(file) for file in modules() if options.of in file]
    mutants = [
        m for turn in itertools.zip_longest(*drawn) for m in turn if m
    ]  # each module's first
    if options.list:
        print(table(mutant.row("") for mutant in mutants), end="")
        return
    warm_up()
    known, killers = Known(), [""] * len(mutants)
    reasons = tomllib.loads(REASONS.read_text()) if REASONS.exists() else {}
    explained = {(entry["file"], entry["after"]) for entry in reasons.values()}
    passes = list(itertools.chain(*tests_of(modules()[0])))
    if run(["tests/test_arguments_and_exact.py"], LIMITS[0]):
        sys.exit("Tests fail in the copy although nothing was altered.")
    if not options.near and known.judge("unchanged", known.all, 2, lambda: run(passes, LIMITS[2])):
        known.forget(known.all)
        sys.exit("The tests must pass before a fault is planted.")
    for lot in range(1 if options.near else 3):
        for i, mutant in enumerate(mutants):
            if lot and (mutant.file, mutant.row("")["after"]) in explained:
                continue
            name = f"{lot + 1}: {i + 1}/{len(mutants)} {mutant.file}:{mutant.line} {mutant.kind}"
            key = hashlib.sha256("".join([mutant.file, *mutant.lines()[1]]).encode()).hexdigest()
            killers[i] = known.judge(name, key, lot, lambda m=mutant, lot=lot: judge(m, lot))
    rows = [mutant.row(by) for mutant, by in zip(mutants, killers, strict=True)]
    if not options.of and not options.near:
        replace(TABLE, table(sorted(rows, key=lambda row: (row["file"], row["line"]))))
    alive = [row for row in rows if not row["killed by"]]
    say(f"{len(rows) - len(alive)} of {len(rows)} noticed.")
    for row in alive:
        why = "" if (row["file"], row["after"]) in explained else ", unexplained"
        say(f"survived{why}: {row['file']}:{row['line']} {row['before']}  ->  {row['after']}")


if __name__ == "__main__":
    main()
