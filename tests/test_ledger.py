"""The ledger of claims: every row whole, every proof there, every equation judged."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted((ROOT / "report" / "ledger").glob("*.toml"))
LEDGER = {id: row for file in FILES for id, row in tomllib.loads(file.read_text()).items()}
VERDICTS = {"holds", "corrected", "refuted", "imprecise", "ambiguous", "not reproduced"}
ORIGINS = {"author", "transcription", "undecidable"}


def names_in(path):
    tree = ast.parse((ROOT / path).read_text())
    return {e.name for e in tree.body if isinstance(e, ast.FunctionDef) and e.name[:5] == "test_"}


@pytest.mark.parametrize("id", LEDGER)
def test_row_is_whole(id):
    row = LEDGER[id]
    assert list(row) == ["where", "claim", "verdict", "origin", "says", "proof"]
    assert all(row[key] == row[key].strip() != "" for key in row if key != "origin")
    assert row["claim"].endswith(".") and row["says"].endswith(".")
    assert row["verdict"] in VERDICTS
    assert row["origin"] in ({""} if row["verdict"] == "holds" else ORIGINS)
    assert re.fullmatch(r"[A-Za-z0-9]+(-[A-Za-z0-9]+)*", id)


@pytest.mark.parametrize("id", LEDGER)
def test_row_has_a_proof(id):
    path, _, name = LEDGER[id]["proof"].partition("::")
    assert name in names_in(path)


def test_every_proof_is_named_by_a_row():
    proofs = {row["proof"].partition("::")[2] for row in LEDGER.values()}
    for path in (ROOT / "tests").glob("test_equations*.py"):
        assert names_in(path) - proofs == set()


@pytest.mark.parametrize("number", range(1, 20))
def test_every_equation_has_a_row(number):
    row = LEDGER[f"eq{number:02}"]
    assert re.search(rf"\bEq\. {number}$", row["where"])
