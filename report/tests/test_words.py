"""Words around numbers: a sentence names what its number is, and of which kind.

A number is named by a word of its record's name that stands between the numbers before and after
it. Number words and digits are one ("four cones" names "share with 4 cones"), and so are deep and
depth, long and length. If the record's name says the kind of its number (worst, least, median,
mean, rms), the sentence says it, too. What stands right before a number ("at most", "up to") is
borne out by the record's name, or by the record, where that's a bound. Both ends of a range ("from
.. to ..") have the words around the range; the first is read as the least, the other as the most.

Two numbers of a section from one notebook aren't exchanged: the words of a record's name stand
nearer to its own number than to the other, both taken together.

In captions, findings and the abstract a word that compares or counts comes from a record, by num,
than, compared or count; in running text a word that compares, "never" and "always". `prose.FREE`
lists the few patterns that are no results. A superlative may stand beside a record whose name says
it.
"""

import itertools
import json
import re

import pytest

from exhibits.rod_cases import GENERATORS
from report.tests.prose import (
    END,
    FREE,
    NUMBER,
    ROOT,
    Use,
    as_well_exchanged,
    bracketed,
    captions,
    claims,
    orders,
    plain,
    running,
    sources,
    statistics,
    stems,
    uses,
    worded,
)

READS = ["report/*", "tests/test_rod.py"]

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
    said = statistics(use.sentence) | {use.end}
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


@pytest.mark.parametrize("path", sources(), ids=lambda path: path.stem)
def test_no_sentence_says_a_number_twice(path):
    for sentence in END.split(path.read_text("utf-8")):
        records = [place.groups() for place in NUMBER.finditer(sentence)]
        assert len(records) == len(set(records)), " ".join(plain(sentence).split())


PAIRS = [
    (one, other) for one, other in itertools.combinations(USES, 2)
    if (one.file, one.notebook) == (other.file, other.notebook) and one.name != other.name
]  # fmt: skip


@pytest.mark.parametrize("file", sorted({use.file for use in USES}))
def test_no_two_numbers_fit_as_well_exchanged(file):
    pairs = [pair for pair in PAIRS if pair[0].file == file and as_well_exchanged(*pair)]
    assert [(one.name, other.name) for one, other in pairs] == []


def test_exchanged_numbers_are_noticed():
    first, second = uses('A depth of #num("a", "depth"). Then a width of #num("a", "width").')
    assert not as_well_exchanged(first, second)
    first, second = uses('A depth of #num("a", "width"). Then a width of #num("a", "depth").')
    assert as_well_exchanged(first, second)


def test_exchanged_ends_of_a_range_are_noticed():
    def ranged(low, high):
        names = [f'#num("05_circuit", "{end} sagitta left on the roof")' for end in (low, high)]
        return uses(f"The share on the roof is from {names[0]} to {names[1]}.")

    right, wrong = ranged("least", "greatest"), ranged("greatest", "least")
    assert not as_well_exchanged(*right)
    assert not any(unnamed(use) or of_another_kind(use) for use in right)
    assert as_well_exchanged(*wrong) and all(map(of_another_kind, wrong))
    assert as_well_exchanged(*ranged("some", "other"))


def test_wrong_words_are_noticed():
    wrong = Use("11_rivals", "worst aside", " is longer by ", " in length", "", "")
    assert unnamed(wrong)
    [median] = uses('It is at most #num("11_rivals", "median aside") longer, an aside.')
    assert of_another_kind(median) == {"median", "most"}


TEXTS = {path.stem: path.read_text("utf-8") for path in sources()}
CAPTIONS = [(name, caption) for name, text in TEXTS.items() for caption in captions(text)]
SHORT = [*CAPTIONS, ("findings", TEXTS["findings"])]


@pytest.mark.parametrize(("file", "text"), SHORT, ids=[name for name, _ in SHORT])
def test_what_compares_or_counts_comes_from_a_record(file, text):
    assert claims(text) == [], " ".join(text.split())


RUNNING = {path.stem: running(path) for path in sources()}


@pytest.mark.parametrize("file", RUNNING)
def test_what_compares_in_running_text_comes_from_a_record(file):
    assert orders(RUNNING[file]) == []


def figures():
    """Yield each figure's section, name, and the words of its caption and of what it shows."""
    for section, text in TEXTS.items():
        for place in FIGURE.finditer(text):
            notebook, name = place.groups()
            numbers = json.loads((ROOT / "report" / "numbers" / f"{notebook}.json").read_text())
            shown = numbers["figures"][name]["alt"]
            own = name.replace("_", " ")
            caption = plain(bracketed(text, place.end()))
            yield section, name, stems(f"{caption} {own}"), stems(f"{shown} {own}")


FIGURE = re.compile(r'#fig\(\s*"([^"]+)",\s*"([^"]+)"(?:[^()"]|"[^"]*")*\)(?=\[)')
FIGURES = list(figures())


@pytest.mark.parametrize(("section", "name", "said", "shown"), FIGURES, ids=[f[1] for f in FIGURES])
def test_caption_fits_its_own_figure_better_than_others(section, name, said, shown):
    for where, other, _, also_shown in FIGURES:
        if where == section and other != name:
            assert len(said & shown) > len(said & also_shown), f"as well for {other}"


def test_every_caption_is_read():
    calls = sum(len(re.findall(r"#(?:fig|tabular|figure)\(", text)) for text in TEXTS.values())
    assert len(CAPTIONS) >= calls > 100


@pytest.mark.parametrize("free", FREE)
def test_every_free_pattern_is_used(free):
    texts = [text for _, text in SHORT] + [*RUNNING.values()]
    assert any(re.search(free, worded(text), re.I) for text in texts)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("The rule gains more on short chords, and twice as much there.", ["more", "twice"]),
        ("Five paths; the plane section is best.", ["Five", "best"]),
        ('The worst excess is #num("11_rivals", "worst excess"), the least too.', ["least"]),
        (
            'It is #than("11_rivals", "rule", "more") than that of #count("05_circuit", "paths").',
            [],
        ),
        ("Largest error of two joints, in ten steps.", []),
    ],
)
def test_claims_without_a_record_are_noticed(text, words):
    assert claims(text) == words


VERDICTS = re.compile(r'#verdicts-of\("[^)]*\)(?!\]?\s*(\n\n|\n- |$))')


@pytest.mark.parametrize("file", RUNNING)
def test_verdicts_stand_at_the_end_of_a_paragraph(file):
    assert [match[0] for match in VERDICTS.finditer(RUNNING[file])] == []


def test_verdict_within_a_paragraph_is_noticed():
    assert VERDICTS.search('It holds, #verdicts-of("eq05") as printed.')
    assert not VERDICTS.search('It holds. #verdicts-of("eq05", "eq06")\n\nThe next.')


def test_section_of_rods_says_how_many_lines_its_tests_try():
    said = worded(TEXTS["rods"])
    tests = (ROOT / "tests" / "test_rod.py").read_text("utf-8")
    usual, judged = (
        int(re.search(rf"^{name} = many\(([\d_]+)", tests, re.M)[1]) for name in ("MANY", "CHECKED")
    )
    assert 2 * len(GENERATORS) * usual > 1_000_000 and 40 * judged == usual
    assert "more than a million such lines, and judge a fortieth as many in whole numbers" in said
