"""The displayed equations: what the report typesets is evaluated, and so is what was printed."""

import re
import tomllib
import zlib
from functools import cache

import numpy as np
import pytest
import sympy as sp
import typst

from report.sources import ROOT
from report.tests.typeset_check import Check, survives
from report.tests.typeset_faults import faults
from report.tests.typeset_marks import changed, marked
from report.tests.typeset_worlds import WORLDS
from report.tests.typst_math import UnknownMath, parse
from report.tests.typst_values import to_sympy
from report.tests.typst_words import functions_in, renewed
from tests import symbols_envelopes, symbols_tunneller
from tests.verdicts import DOCUMENTS, ledger

READS = ["report/equations.toml", "report/ledger/*", "report/verdicts.typ"]

TEXT = (ROOT / "report" / "equations.toml").read_text(encoding="utf-8")
EQUATIONS = tomllib.loads(TEXT)
PRINTED = [id for id, entry in EQUATIONS.items() if "printed" in entry]
RIGHT = [(id, form) for id, entry in EQUATIONS.items() for form in ("right", "reads")
         if form in entry]  # fmt: skip
LEDGER = {id: row for document in DOCUMENTS for id, row in ledger(document).items()}

# Changes that can't be seen in the values because they say the same.
EQUIVALENT = {"even-steps": ["0 <= t <= 1"]}  # t runs from 0 to 1 just where u does

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


# ---- planted faults -------------------------------------------------------------------------


@pytest.mark.parametrize("id", EQUATIONS)
def test_planted_faults_are_noticed(id):
    """A sign, a function, a letter, an index, an exponent or a coefficient changed or lost."""
    rng, survivors, planted = np.random.default_rng(7), [], 0
    functions = functions_in(EQUATIONS[id]["right"])
    for _, _, changed_tokens in faults(EQUATIONS[id]["right"], rng):
        try:
            parse(changed_tokens, functions)
        except UnknownMath:
            continue  # no fault that Typst could set
        planted += 1
        if survives(changed_tokens, worlds(id)):
            survivors.append(" ".join(token.text for token in changed_tokens))
    assert planted >= 5
    known = EQUIVALENT.get(id, [])
    assert len(survivors) == len(known)
    assert all(part in whole for part, whole in zip(known, survivors, strict=True))


# ---- the proofs' forms ----------------------------------------------------------------------


def in_letters(expression):
    """Return a proof's expression with its symbols as the report writes them."""

    def letter(name):
        if name == "tan":
            return sp.tan(sp.Symbol("theta"))
        return sp.Symbol(re.sub(r"^([a-z])(\d|[xy]+)$", r"\1_\2", name))

    return sp.sympify(expression).subs({s: letter(s.name) for s in expression.free_symbols})


def sides(id, form="right", place=0):
    return [to_sympy(side) for side in parse(EQUATIONS[id][form]).statements[place].sides]


def same(a, b):
    return sp.expand(a - b) == 0


@pytest.mark.parametrize(
    ("id", "proved"),
    [
        ("eq02", symbols_tunneller.TORUS),
        ("eq13", symbols_tunneller.EQ13),
        ("eq16", symbols_tunneller.EQ16),
        ("cones-eq09", symbols_envelopes.EQ9),
        ("cones-eq11", symbols_envelopes.EQ11),
        ("cones-eq12", symbols_envelopes.EQ12),
    ],
)
def test_left_side_is_what_the_proof_has(id, proved):
    left, right = sides(id)
    left = left.subs(sp.Symbol("W"), in_letters(symbols_envelopes.W))
    assert right == 0 and same(left, in_letters(proved))


def eleven(form):
    """Return the letters that Eq. 11 defines in a form, by their names."""
    statements = [[to_sympy(side) for side in s.sides]
                  for s in parse(EQUATIONS["eq11"][form]).statements]  # fmt: skip
    return {left.name: right for left, right in statements}


def test_eq11_is_printed_as_the_proof_has_it():
    found, proved = eleven("printed"), symbols_tunneller.eq11_printed()
    nu = {sp.Symbol(f"nu_{i}"): in_letters(proved[f"nu{i}"]) for i in (0, 2, 4)}
    assert len(found) == len(proved) == 8
    for name, expression in proved.items():
        letter = re.sub(r"(\d)", r"_\1", name)
        assert same(found[letter].subs(nu), in_letters(expression)), name


@pytest.mark.parametrize(("form", "power"), [("right", 0), ("reads", 4)])
def test_eq11_is_mended_as_the_proof_has_it(form, power):
    found = eleven(form)
    nu = {sp.Symbol(name): found[name] for name in ("nu_0", "nu_2", "nu_4")}
    quartic = sum(found[f"N_{i}"] * sp.Symbol("n_1") ** i for i in range(5)).subs(nu)
    quartic = quartic.subs(sp.Symbol("s"), sp.Symbol("m_1") ** 2 + sp.Symbol("m_3") ** 2)
    assert same(quartic, in_letters(symbols_tunneller.eq11_corrected(power)))


def test_eq17_is_what_the_proof_has():
    S, sigma, whole, point = symbols_tunneller.development()
    _, found = sides("eq17")
    given = {"S": S, "sigma": sigma, "Phi_f": whole}
    given = {sp.Symbol(name): in_letters(value) for name, value in given.items()}
    for part, proved in zip(found, point, strict=True):
        assert sp.simplify(part.subs(given) - in_letters(proved)) == 0


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


def test_nothing_is_red_in_a_printed_form():
    assert not any("mended" in EQUATIONS[id]["printed"] for id in PRINTED)


# ---- the words ------------------------------------------------------------------------------


def test_words_say_the_forms():
    if renewed(TEXT) != TEXT:
        pytest.fail(
            "words are stale: `python -m report.tests.typst_words` renews them.", pytrace=False
        )


# ---- the file, the ledgers and the report ---------------------------------------------------


def test_printed_forms_are_of_rows_that_do_not_hold():
    for id, entry in EQUATIONS.items():
        row = entry.get("slip", entry.get("row", id))
        if "printed" in entry:
            assert LEDGER[row]["verdict"] in ("corrected", "imprecise"), id
        elif row in LEDGER:
            assert LEDGER[row]["verdict"] == "holds", id
        assert {entry[key] for key in ("row", "slip") if key in entry} <= set(LEDGER), id


def shown(body):
    """Return what Typst makes of a call, as SVG."""
    text = f'#import "/report/verdicts.typ": *\n#set page(height: auto)\n{body}'
    return typst.compile(text.encode(), root=ROOT, format="svg", ignore_system_fonts=True)


def test_both_forms_can_be_shown():
    every = shown(
        "#for (id, row) in misprinted { printed-form(id) + right-form(id) + ledger.at(row).says }"
    )
    assert every.count(b"<use") > 1500
    assert shown("#misprinted.len()") == shown(f"{len(PRINTED)}")
    assert shown('#right-form("eq05")') != shown('#printed-form("eq05")')
    assert shown('#right-form("eq11")') != shown('#displayed("eq11")')


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ('displayed("eq99")', "There is no equation 'eq99'."),
        ('printed-form("eq01")', "The equation 'eq01' has no form 'printed'."),
    ],
)
def test_unknown_equation_is_refused(call, message):
    with pytest.raises(typst.TypstError, match=re.escape(message)):
        shown(f"#{call}")
