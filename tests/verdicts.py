"""What a proof finds, and the verdict that follows.

A row of report/ledger names its proof, a test. The test hands `judge` what it found of the claim as
printed, and of what the row says is right; the word that follows must be the row's. A verdict that
is swapped, softened or sharpened fails, as does a proof under another row's name.

Rules
-----
holds
    The claim as printed is true.
corrected
    It is false, and what the row puts in its place is true.
refuted
    It is false, and nothing of its form can take its place.
imprecise
    It is true in some cases, or to some digits, and false in others; the text doesn't tell which.
ambiguous
    It can be read in two ways, and is true in one and false in the other.
not reproduced
    We could neither confirm nor refute it: what that would take isn't there. Which that is, the
    proof says in words, so that this verdict is a judgement.
"""

import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]


@cache
def ledger(document):
    """Return the rows of a document by their names."""
    return tomllib.loads((ROOT / "report" / "ledger" / f"{document}.toml").read_text("utf-8"))


DOCUMENTS = ("tunneller", "line-cylinder", "cone-envelopes")


def truth(found):
    """Return evidence as True or False; anything else is none."""
    if not isinstance(found, (bool, np.bool_)):
        raise TypeError(f"Evidence must be True or False; got {found!r}.")
    return bool(found)


def verdict(printed=None, right=None, *, cases=None, readings=None, missing=None):
    """Return the word that evidence leads to.

    Parameters
    ----------
    printed : bool, optional
        Whether the claim as printed is true.
    right : bool, optional
        Whether what is put in its place is true; only of a claim that is false.
    cases : dict of str to bool, optional
        In place of `printed`: where it is true and where it isn't.
    readings : dict of str to bool, optional
        In place of `printed`: in which reading it is true.
    missing : str, optional
        In place of `printed`: what isn't there, so that it can't be tried.

    Examples
    --------
    >>> verdict(2 + 2 == 4), verdict(2 + 2 == 5), verdict(2 + 2 == 5, right=2 + 2 == 4)
    ('holds', 'refuted', 'corrected')
    >>> verdict(cases={"small angles": True, "a right angle": False})
    'imprecise'
    """
    if sum(kind is not None for kind in (printed, cases, readings, missing)) != 1:
        raise TypeError("A verdict follows from one kind of evidence.")
    if missing is not None:
        return "not reproduced"
    for word, several in (("imprecise", cases), ("ambiguous", readings)):
        if several is not None:
            if {truth(found) for found in several.values()} != {True, False}:
                raise AssertionError(f"{word}: one must be true and one false; got {several}.")
            return word
    if truth(printed):
        if right is not None:
            raise TypeError("What holds needs nothing in its place.")
        return "holds"
    if right is None:
        return "refuted"
    assert truth(right), "What the row says is right isn't."
    return "corrected"


@pytest.fixture
def judge(request):
    """Return a function of a row's name and evidence, as for `verdict`, that compares the words."""
    proof = f"{request.path.relative_to(ROOT)}::{request.function.__name__}"
    judged = set()

    def compare(name, printed=None, right=None, **evidence):
        [row] = [ledger(d)[name] for d in DOCUMENTS if name in ledger(d)]
        assert row["proof"] == proof, f"{name} is proved by {row['proof']}"
        found = verdict(printed, right, **evidence)
        assert found == row["verdict"], f"{name}: {found} by its proof, {row['verdict']} by its row"
        judged.add(name)

    yield compare
    assert judged, "a proof judges its row"
