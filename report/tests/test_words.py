"""Words that compare or count come from records: by `#num`, `#than`, `#count` or `#compared`."""

import re

import pytest

from exhibits.rod_cases import GENERATORS
from report.sources import ROOT
from report.tests.prose import FREE, ORDERS, captions, sources, unbacked, unbound, unsaid, worded

READS = ["report/*", "tests/test_rod.py"]

TEXTS = {path.stem: path.read_text("utf-8") for path in sources()}
CAPTIONS = {name: captions(text) for name, text in TEXTS.items()}
WAY_OUT = (
    'Make the word from a record: #than("notebook", "record", "shorter") after '
    'show.order("record", a, b), or #count("notebook", "record").'
)


@pytest.mark.parametrize("file", TEXTS)
def test_what_compares_comes_from_a_record(file):
    assert unbacked(TEXTS[file], ORDERS) == [], WAY_OUT


@pytest.mark.parametrize("file", TEXTS)
def test_what_counts_in_a_caption_or_the_abstract_comes_from_a_record(file):
    assert [word for text in CAPTIONS[file] for word in unbacked(text)] == [], WAY_OUT


def test_every_caption_is_read():
    calls = sum(len(re.findall(r"#(?:fig|tabular|figure)\(", text)) for text in TEXTS.values())
    assert sum(map(len, CAPTIONS.values())) >= calls > 100


@pytest.mark.parametrize("free", FREE)
def test_every_free_pattern_is_used(free):
    assert any(re.search(free, worded(text), re.I) for text in TEXTS.values())


@pytest.mark.parametrize("file", TEXTS)
def test_number_stands_where_its_record_is_named(file):
    assert unsaid(TEXTS[file]) == [], "A record's name has a condition that its sentence lacks."
    assert unbound(TEXTS[file]) == [], "Say more of the record's name, or it but once."


@pytest.mark.parametrize("file", TEXTS)
def test_no_semicolon_is_lost(file):
    """One right after a call only ends the call: a semicolon that is to be printed is doubled."""
    assert re.findall(r'"\); +[a-z].*', TEXTS[file]) == []


def test_words_without_a_record_are_noticed():
    assert unbacked("Gains are more, and twice as many.") == ["more", "twice"]
    assert unbacked('It is #than("a", "rule", "more") than #count("b", "paths").') == []
    assert unsaid('The best excess is #num("a", "worst excess"), with T1.') == ["worst excess"]
    assert unsaid('At worst it is #num("a", "worst, T3"), with T1.') == ["worst, T3"]
    assert unbound('The lap takes #num("a", "mass of the cutter").') == ["mass of the cutter"]
    assert unbacked('The nearer one is #num("a", "the nearer"), a longer one too.') == ["longer"]


def test_section_of_rods_says_how_many_lines_its_tests_try():
    said = worded(TEXTS["rods"])
    tests = (ROOT / "tests" / "test_rod.py").read_text("utf-8")
    usual = int(re.search(r"^MANY = many\(([\d_]+)", tests, re.M)[1])
    assert 2 * len(GENERATORS) * usual > 1_000_000
    assert "more than a million such lines." in said
