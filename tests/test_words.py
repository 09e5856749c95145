"""Words around numbers: a sentence names what its number is, and of which kind.

A number is named by a word of its record's name that stands between the numbers before and after
it. Number words and digits are one ("four cones" names "share with 4 cones"), and so are deep and
depth, long and length. If the record's name says the kind of its number (worst, least, median,
mean, rms), the sentence says it, too. What stands right before a number ("at most", "up to") is
borne out by the record's name, or by the record, where that's a bound.
"""

import json
import re

import pytest

from tests.prose import ROOT, Use, sources, statistics, stems, uses

READS = ["report/*"]

USES = [use for path in sources() for use in uses(path.read_text("utf-8"), path.stem)]


def bounded(use):
    """Tell whether a record is itself a bound."""
    numbers = json.loads((ROOT / "report" / "numbers" / f"{use.notebook}.json").read_text("utf-8"))
    return "bound" in numbers["numbers"][use.name]


def unnamed(use):
    """Tell whether the words between the neighbouring numbers lack all of the record's name."""
    return not stems(use.name) & stems(use.around)


def of_another_kind(use):
    """Return what kinds of number the sentence and the record's name disagree about."""
    named = statistics(use.name)
    said = statistics(use.sentence)
    last = re.search(
        r"(at most|no more than|up to|at worst|at least|worst|median|mean|rms)\W*$", use.before
    )
    claimed = statistics(last[0]) if last else set()
    return (named - said) | (claimed - named if not bounded(use) else set())


@pytest.mark.parametrize("use", USES, ids=lambda use: f"{use.file}-{use.name}")
def test_sentence_names_its_number(use):
    assert not unnamed(use), f"{use.name!r} isn't named in: {' '.join(use.around.split())!r}"


@pytest.mark.parametrize("use", USES, ids=lambda use: f"{use.file}-{use.name}")
def test_sentence_says_of_which_kind_its_number_is(use):
    assert not of_another_kind(use), " ".join(use.sentence.split())


def test_wrong_words_are_noticed():
    wrong = Use("11_rivals", "worst aside", " is longer by ", " is longer by  in length", "", "")
    assert unnamed(wrong)
    [median] = uses('It is at most #num("11_rivals", "median aside") longer, an aside.')
    assert of_another_kind(median) == {"median", "most"}
