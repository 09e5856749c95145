"""The report's prose as tests read it: sentences, the records that they use, the words around them.

A sentence can be wrong though each of its numbers is right: "at most" before a median, "shorter"
for longer, the number of another record. What can be told from the words themselves is told here.
"""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]

END = re.compile(r"(?<=[.:;])\s+(?=[A-Z#+*_])|\n\n|\n(?=[+-] )")
NUMBER = re.compile(r'#num\(\s*"([^"]+)",\s*"([^"]+)"\s*\)')
CALL = re.compile(r'#\w+\(\s*"[^"]*"(?:,\s*\w*:?\s*"[^"]*")*\s*\)')
SMALL = set(
    "a an and are as at by for from in is it its of on or s that the to was which with".split()
)

COUNTS = "zero one two three four five six seven eight nine ten eleven twelve".split()
# What has another stem and the same meaning.
ONE = {word: str(number) for number, word in enumerate(COUNTS)} | {
    "deep": "depth",
    "high": "height",
    "long": "length",
    "wide": "width",
}

# What says of which kind a number is among those that it stands for.
STATISTICS = {
    "most": "at most|most(?! of)|no more than|at worst|up to|worst|largest|longest|greatest|highest"
    "|widest|thickest|maximum|limit",
    "least": "at least|least|smallest|shortest|lowest|minimum",
    "median": "median",
    "mean": "mean|average",
    "rms": "rms",
}


@dataclass(frozen=True)
class Use:
    """One `#num` of a sentence.

    Parameters
    ----------
    notebook, name : str
        The record.
    before, around : str
        The words just before it, and those between the numbers before and after it.
    sentence : str
        All words of the sentence.
    file : str
        Where it stands.
    """

    notebook: str
    name: str
    before: str
    around: str
    sentence: str
    file: str


def sources(root=ROOT):
    """Return the files of prose, report.typ last."""
    report = root / "report"
    return [*sorted((report / "sections").glob("*.typ")), report / "report.typ"]


def plain(text):
    """Return a text without its calls."""
    return CALL.sub(" ", text)


def uses(text, file=""):
    """Return the uses of numbers in a text."""
    found = []
    for sentence in END.split(text):
        places = list(NUMBER.finditer(sentence))
        ends = [0, *(place.end() for place in places)]
        starts = [*(place.start() for place in places[1:]), len(sentence)]
        for place, start, end in zip(places, ends, starts, strict=False):
            before = plain(sentence[start : place.start()])
            around = before + " " + plain(sentence[place.end() : end])
            found.append(Use(*place.groups(), before, around, plain(sentence), file))
    return found


def stem(word):
    """Return a word without its ending: "lengths" and "length" are one, "two" and "2", "deep"."""
    word = ONE.get(word.lower(), word.lower())
    for ending in ("ing", "ed", "es", "s", "e", "ly"):
        if word.endswith(ending) and len(word) - len(ending) >= 4:
            word = word[: -len(ending)]
            break
    return word[:6]


def stems(text):
    """Return the stems of the words that carry meaning."""
    words = re.findall(r"[^\W\d_]+|\d+", text)
    return {stem(word) for word in words if word.lower() not in SMALL}


def statistics(text):
    """Return which statistics a text speaks of."""
    kinds = STATISTICS.items()
    return {kind for kind, words in kinds if re.search(rf"\b({words})\b", text, re.I)}
