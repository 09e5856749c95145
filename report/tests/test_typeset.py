"""The displayed equations: what the report typesets is evaluated, and so is what was printed."""

import re
import tomllib
import zlib
from functools import cache

import pytest
import sympy as sp

from report.sources import ROOT
from report.tests.typeset_check import Check
from report.tests.typeset_marks import changed, marked
from report.tests.typeset_worlds import WORLDS
from report.tests.typst_math import parse
from report.tests.typst_values import to_sympy
from tests import symbols_tunneller
from tests.verdicts import DOCUMENTS, ledger

READS = ["report/equations.toml", "report/ledger/*", "report/verdicts.typ"]

TEXT = (ROOT / "report" / "equations.toml").read_text(encoding="utf-8")
EQUATIONS = tomllib.loads(TEXT)
PRINTED = [id for id, entry in EQUATIONS.items() if "printed" in entry]
RIGHT = [(id, form) for id, entry in EQUATIONS.items() for form in ("right", "reads")
         if form in entry]  # fmt: skip
LEDGER = {id: row for document in DOCUMENTS for id, row in ledger(document).items()}

# What differs from the printed form and isn't red, and why.
UNMARKED = {
    "eq03": "In letters that mean nothing else here.",
    "eq03/reads": "No factor w, but the document says w = 1 beside it: imprecise, not wrong.",
    "eq07": "A quarter of the gradient is enough for a direction: imprecise, not wrong.",
    "eq11": "Rearranged; `reads` has the marks.",
    "eq17": "The text beside it says nothing of the two names; `reads` has the marks.",
    "eq18": "Two arguments in place of a quotient: right where the quotient is, and beyond.",
    "cone-point": "Another formula, for any turn, in place of one for a quarter of a turn.",
    "groove-area": "In letters that mean nothing else here.",
    "groove-area/reads": "Another formula, of a segment, in place of a sector.",
    "rod-miss": "The third condition, with k for r e, only becomes sharper.",
}


@cache
def worlds(id, form="right"):
    return WORLDS.get(f"{id}/{form}", WORLDS[id])(zlib.crc32(id.encode()))


@pytest.mark.parametrize(("id", "form"), RIGHT)
def test_form_is_right_and_every_letter_matters(id, form):
    check = Check(EQUATIONS[id][form], worlds(id, form))
    assert check.right()
    assert check.blind() == []


@pytest.mark.parametrize("id", PRINTED)
def test_printed_form_is_false_where_the_right_one_is_true(id):
    check = Check(EQUATIONS[id]["printed"], worlds(id, "printed"))
    assert not check.right()


@pytest.mark.parametrize("id", [name[:-5] for name in WORLDS if name.endswith("/case")])
def test_imprecise_form_is_true_in_its_own_case(id):
    assert LEDGER[EQUATIONS[id].get("row", id)]["verdict"] == "imprecise"
    assert Check(EQUATIONS[id]["printed"], worlds(id, "case")).right()


@pytest.mark.parametrize("id", ["groove-area", "rod-miss"])
def test_printed_form_is_what_the_row_quotes(id):
    claim = LEDGER[EQUATIONS[id].get("row", id)]["claim"].replace("−", "-")
    assert re.sub(r'quad|"|\s', "", EQUATIONS[id]["printed"]) in re.sub(r"\s", "", claim)


def test_every_equation_has_values_and_nothing_else_has():
    forms = {f"{id}/{form}" for id in EQUATIONS for form in ("printed", "reads", "case")}
    assert set(EQUATIONS) <= set(WORLDS) <= set(EQUATIONS) | forms


# ---- the proofs' forms ----------------------------------------------------------------------


def in_letters(expression):
    """Return a proof's expression with its symbols as the report writes them."""

    def letter(name):
        if name == "tan":
            return sp.tan(sp.Symbol("theta"))
        return sp.Symbol(re.sub(r"^([a-z])(\d|[xy]+)$", r"\1_\2", name))

    return sp.sympify(expression).subs({s: letter(s.name) for s in expression.free_symbols})


def same(a, b):
    return sp.expand(a - b) == 0


def eleven(form):
    """Return the letters that Eq. 11 defines in a form, by their names."""
    statements = [[to_sympy(side) for side in s.sides]
                  for s in parse(EQUATIONS["eq11"][form]).statements]  # fmt: skip
    return {left.name: right for left, right in statements}


def test_eq11_is_printed_as_the_proof_has_it():
    found, proved = eleven("printed"), symbols_tunneller.eq11()
    nu = {sp.Symbol(f"nu_{i}"): in_letters(proved[f"nu{i}"]) for i in (0, 2, 4)}
    assert len(found) == len(proved) == 8
    for name, expression in proved.items():
        letter = re.sub(r"(\d)", r"_\1", name)
        assert same(found[letter].subs(nu), in_letters(expression)), name


# ---- what is red ----------------------------------------------------------------------------


@pytest.mark.parametrize(("id", "form"), RIGHT)
def test_what_is_red_is_what_differs_from_the_printed_form(id, form):
    entry = EQUATIONS[id]
    if "printed" not in entry:
        assert marked(entry[form]) == {}
    elif (id if form == "right" else f"{id}/{form}") in UNMARKED:
        differs = changed(entry[form], entry["printed"])
        assert differs and marked(entry[form]).items() != differs.items()
    else:
        assert marked(entry[form]) == changed(entry[form], entry["printed"])


# ---- the file, the ledgers and the report ---------------------------------------------------


def test_printed_forms_are_of_rows_that_do_not_hold():
    for id, entry in EQUATIONS.items():
        row = entry.get("slip", entry.get("row", id))
        if "printed" in entry:
            assert LEDGER[row]["verdict"] in ("corrected", "imprecise"), id
        elif row in LEDGER:
            assert LEDGER[row]["verdict"] == "holds", id
        assert {entry[key] for key in ("row", "slip") if key in entry} <= set(LEDGER), id
