"""The ledger of claims: every row whole, every proof there, every equation judged."""

import ast
import importlib
import json
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest

from tests import matlab_listing
from tests.basic_listing import PRINTED, REPAIRS

READS = ["report/ledger/*", "report/listings.toml", "report/numbers/*", "tests/test_*.py"]

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "report" / "ledger").glob("*.toml"))
LEDGER = {id: row for file in FILES for id, row in tomllib.loads(file.read_text()).items()}
VERDICTS = {"holds", "corrected", "refuted", "imprecise", "ambiguous", "not reproduced"}
ORIGINS = {"author", "transcription", "undecidable"}
SEVERITIES = ["cosmetic", "digit", "local", "result"]  # the gravest last
MENDED = [id for id, row in LEDGER.items() if row["verdict"] in {"corrected", "refuted"}]


def line_of(node):
    return node.lineno


@cache
def proofs_in(path):
    """Return the source of each test of a file, by its name."""
    text = (ROOT / path).read_text()
    lines = text.splitlines(keepends=True)
    return {
        e.name: "".join(lines[min([e, *e.decorator_list], key=line_of).lineno - 1 : e.end_lineno])
        for e in ast.parse(text).body
        if isinstance(e, ast.FunctionDef) and e.name.startswith("test_")
    }


@pytest.mark.parametrize("id", LEDGER)
def test_row_is_whole(id):
    row = LEDGER[id]
    holds, tried = row["verdict"] == "holds", row["verdict"] != "not reproduced"
    fields = ["where", "claim", "verdict", "origin"]
    fields += ["severity"] if tried and not holds else []
    fields += [field for field in ("part_of", "same_as") if field in row]
    fields += ["effect"] if id in MENDED else []
    assert list(row) == [*fields, "says", "proof", "seen"]
    assert all(row[key] == row[key].strip() for key in row)
    assert all(row[key] for key in row if key not in ("origin", "seen"))
    assert row.get("severity", "local") in SEVERITIES
    assert row.get("effect", ".").endswith(".")
    assert row["claim"].endswith(".") and row["says"].endswith(".")
    assert row["verdict"] in VERDICTS
    assert row["origin"] in ({""} if row["verdict"] == "holds" else ORIGINS)
    assert re.fullmatch(r"[A-Za-z0-9]+(-[A-Za-z0-9]+)*", id)


@pytest.mark.parametrize("id", LEDGER)
def test_row_has_a_proof(id):
    path, _, name = LEDGER[id]["proof"].partition("::")
    assert name in proofs_in(path)


@pytest.mark.parametrize("id", MENDED)
def test_correction_is_proved_in_two_ways(id):
    path, _, name = LEDGER[id]["proof"].partition("::")
    first, mark, second = proofs_in(path)[name].partition("# A second way")
    assert mark and ("judge(" in first or " assert" in first) and "assert" in second


@pytest.mark.parametrize("id", [id for id, row in LEDGER.items() if "part_of" in row])
def test_detail_belongs_to_a_row_that_is_as_wrong_as_the_worst_of_them(id):
    whole = LEDGER[id]["part_of"]
    parts = [row for row in LEDGER.values() if row.get("part_of") == whole]
    assert LEDGER[whole]["verdict"] == LEDGER[id]["verdict"]
    assert LEDGER[whole]["where"].split(", ")[0] == LEDGER[id]["where"].split(", ")[0]
    assert LEDGER[whole]["severity"] == max((p["severity"] for p in parts), key=SEVERITIES.index)


@cache
def recorded(notebook):
    return json.loads((ROOT / "report" / "numbers" / f"{notebook}.json").read_text())


@pytest.mark.parametrize("id", [id for id, row in LEDGER.items() if row["seen"]])
def test_what_shows_a_row_is_recorded(id):
    notebook, kind, name = LEDGER[id]["seen"].split("/", 2)
    assert recorded(notebook)[kind][name]["cell"] > 0


def test_every_proof_is_named_by_a_row():
    proofs = {row["proof"].partition("::")[2] for row in LEDGER.values()}
    for path in (ROOT / "tests").glob("test_equations*.py"):
        assert proofs_in(f"tests/{path.name}").keys() - proofs == set()


# What each document numbers; its own headings where it numbers nothing.
ITEMS = {
    "tunneller": {
        "Eq.": range(1, 20), "Fig.": range(1, 10),
        "": ["abstract", "table", "listing", "4.3, listing", "5"],
    },
    "cone-envelopes": {
        "Eq.": range(1, 27), "Fig.": range(1, 12),
        "Theorem": [2, 4, 13, 16], "Example": [1, 10, 31, 32, 33], "Problem": [15, 30],
        "Proposition": [6, 7, 9, 11, 17, 18, 19, 20, 22, 24, 26, 27],
        "Corollary": [12, 25, 28, 29], "Remark": [3, 5, 14, 21, 23], "Definition": [8],
    },
    "line-cylinder": {
        "": ["Point in cylinder", "Line intersect with cylinder", "Independent surfaces",
             "The epsilon fix", "Two volumes", "Point within a 2D shape"],
    },
}  # fmt: skip
EVERY_ITEM = [(name, kind, item) for name, kinds in ITEMS.items() for kind in kinds
              for item in kinds[kind]]  # fmt: skip


@cache
def places(document):
    """Return what the rows of a document stand for: "Eq. 8" and "Eq. 9" for "Eqs 8 and 9"."""
    rows = tomllib.loads((ROOT / "report" / "ledger" / f"{document}.toml").read_text())
    found = set()
    for where in (row["where"] for row in rows.values()):
        found.add(re.sub(r"^(cones|appendix), ", "", where))
        for kind, first, word, last in re.findall(
            r"([A-Z][a-z]+)s?\.? (\d+)(?: (and|to) (\d+))?", where
        ):
            kind = {"Eq": "Eq.", "Eqs": "Eq.", "Fig": "Fig."}.get(kind, kind)
            between = range(int(first), int(last or first) + 1) if word != "and" else [first, last]
            found |= {f"{kind} {number}" for number in between}
    return found


@pytest.mark.parametrize(("document", "kind", "item"), EVERY_ITEM, ids=str)
def test_every_numbered_item_has_a_row(document, kind, item):
    found = places(document)
    if kind:
        assert f"{kind} {item}" in found
    else:
        assert any(re.search(rf"(^|, | and ){re.escape(item)}(,|$)", place) for place in found)


def test_repairs_as_they_are_printed_are_those_that_run():
    assert set(REPAIRS) < set(PRINTED) and all(REPAIRS[n] != PRINTED[n] for n in REPAIRS)
    lines = matlab_listing.PRINTED.splitlines()
    for old, new in matlab_listing.REPAIRS.values():  # the supplement repairs line by line
        [found] = [line for line in lines if old.strip("\n") in line]
        repaired = found.replace(old.strip("\n"), new.strip("\n"))
        assert matlab_listing.PRINTED.replace(old, new) == "\n".join(
            [repaired if line == found else line for line in lines] + [""]
        )


# ---- proofs find verdicts, in two ways that share nothing -----------------------------------


@cache
def proof_tree(id):
    """Return a row's proof as syntax, and its module."""
    path, _, name = LEDGER[id]["proof"].partition("::")
    [tree] = ast.parse(proofs_in(path)[name]).body  # from its decorators on
    return tree, importlib.import_module(path.removesuffix(".py").replace("/", "."))


def calls_of(tree, name):
    return [n for n in ast.walk(tree) if isinstance(n, ast.Call) and ast.unparse(n.func) == name]


@pytest.mark.parametrize("id", LEDGER)
def test_proof_finds_the_verdict_of_its_row(id):
    tree, _ = proof_tree(id)
    assert f'"{id}"' in proofs_in(LEDGER[id]["proof"].partition("::")[0])[tree.name]
    assert "judge" in [argument.arg for argument in tree.args.args]
    for call in calls_of(tree, "judge"):
        evidence = [*call.args[1:], *(k.value for k in call.keywords if k.arg != "missing")]
        evidence = [v for e in evidence for v in (e.values if isinstance(e, ast.Dict) else [e])]
        assert not any(isinstance(e, ast.Constant) for e in evidence), "evidence is computed"
