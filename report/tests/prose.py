"""The report's prose as tests read it: sentences, the records that they use, the words around them.

A sentence can be wrong though each of its numbers is right: "at most" before a median, "shorter"
for longer, the number of another record. What can be told from the words themselves is told here.
"""

import re
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[2]

END = re.compile(r"(?<=[.:;])\s+(?=[A-Z#@+*_])|\n\n|\n(?=[+-] )")
NUMBER = re.compile(r'#(?:num|count)\(\s*"([^"]+)",\s*"([^"]+)"\s*\)')
CALL = re.compile(r'#\w+\(\s*"[^"]*"(?:,\s*(?:\w+: *)?(?:"[^"]*"|[\d.]+%))*,?\s*\)')
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
    """One `#num` or `#count` of a sentence.

    Parameters
    ----------
    notebook, name : str
        The record.
    before, after : str
        The words between it and the number before, and between it and the next.
    sentence : str
        All words of the sentence.
    file : str
        Where it stands.
    end : str
        Which statistic an end of a range is.
    """

    notebook: str
    name: str
    before: str
    after: str
    sentence: str
    file: str
    end: str = ""

    @property
    def around(self):
        return f"{self.before} {self.after}"

    def nearness(self, name):
        """Return how near the words of a record's name stand: of each, 1/(3 + words between)."""
        left, right = in_order(self.before)[::-1], in_order(self.after)
        ends = stems(" ".join(word for word in name.split() if self.end in statistics(word)))
        gaps = [
            [0] if word in ends else [side.index(word) for side in (left, right) if word in side]
            for word in stems(name)
        ]
        return sum(1 / (3 + min(gap)) for gap in gaps if gap)


def sources(root=ROOT):
    """Return the files of prose: the sections of the supplement, and the two documents last."""
    report = root / "report"
    return [
        *sorted((report / "sections").glob("*.typ")),
        report / "supplement.typ",
        report / "report.typ",
    ]


def running(path):
    """Return a file's text without captions and abstract; of the findings nothing is left."""
    text = "" if path.stem == "findings" else path.read_text("utf-8")
    for caption in captions(text):
        text = text.replace(caption, " " * len(caption))
    return text


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
        here = []
        for place, start, end in zip(places, ends, starts, strict=False):
            before = plain(sentence[start : place.start()])
            after = plain(sentence[place.end() : end])
            here.append(Use(*place.groups(), before, after, plain(sentence), file))
        found += with_ranges(here)
    return found


def with_ranges(found):
    """Return a sentence's uses, where both ends of a range have the words around the range."""
    found = list(found)
    for i, (low, high) in enumerate(pairwise(found)):
        if re.search(r"\bfrom\W*$", low.before) and re.fullmatch(r"\W*to\W*", low.after):
            found[i] = replace(low, after=high.after, end="least")
            found[i + 1] = replace(high, before=low.before, end="most")
    return found


def stem(word):
    """Return a word without its ending: "lengths" and "length" are one, "two" and "2", "deep"."""
    word = ONE.get(word.lower(), word.lower())
    for ending in ("ing", "ed", "es", "s", "e", "ly"):
        if word.endswith(ending) and len(word) - len(ending) >= 4:
            word = word[: -len(ending)]
            break
    return word[:6]


def in_order(text):
    """Return the stems of a text's words in their order; a small word's is its own."""
    words = re.findall(r"[^\W\d_]+|\d+", text)
    return [word.lower() if word.lower() in SMALL else stem(word) for word in words]


def stems(text):
    """Return the stems of the words that carry meaning."""
    return set(in_order(text)) - SMALL


def as_well_exchanged(one, other):
    """Tell whether the words fit two numbers of a notebook as well if these are exchanged."""
    true = one.nearness(one.name) + other.nearness(other.name)
    false = one.nearness(other.name) + other.nearness(one.name)
    return true <= false + 1e-9  # sums of the same fractions in another order


def statistics(text):
    """Return which statistics a text speaks of."""
    kinds = STATISTICS.items()
    return {kind for kind, words in kinds if re.search(rf"\b({words})\b", text, re.I)}


# Words that compare, that speak of all cases, and number words from two on.
COMPARATIVES = (
    "closer nearer shorter longer better worse faster slower more fewer less greater larger "
    "smaller higher lower wider narrower deeper thicker thinner farther milder twice half double "
    "triple tenfold twentyfold hundredfold"
).split()
SUPERLATIVES = (
    "closest nearest shortest longest best worst fastest slowest most fewest least greatest "
    "largest smallest highest lowest widest narrowest deepest thickest thinnest"
).split()
NUMBERS = {*COUNTS, *"twice half double triple tenfold twentyfold hundredfold".split()}
ALWAYS = ["never", "always"]
CLAIMS = re.compile(
    rf"\b({'|'.join([*COMPARATIVES, *SUPERLATIVES, *ALWAYS, *COUNTS[2:]])})\b", re.I
)
EXTREME = "largest|greatest|highest|longest|shortest|least|worst|fastest|nearest"
QUANTITY = (
    "error|excess|deviation|following error|contour error|gain|step|segment|distance|feed|constant "
    "feed|foot|of the feet|root|count|response|axis|point|lap|one|depth|meeting|N"
)

# What compares or counts and is no result, with the reason.
FREE = {
    rf"\b({EXTREME}) ({QUANTITY})s?\b": "a quantity's name: of a set its extreme is meant",
    r"\b(largest|longest) (in|seen in) a\b": "such a name, with what it's the extreme of",
    r"\bshortest path\b|\bproved? shortest\b": "what a geodesic is, as the proof says",
    r"\bworst over all\b": "names a table's columns",
    r"\bthe worse of (both|the two joints)\b": "says which of two values is drawn",
    r"\btwo (such )?(joints|cylinders|nodes)\b": "a number that belongs to the machine or torus",
    r"\b(two|three) documents\b": "what the study has before it",
    r"\b(three surfaces|two volumes|one-third rule|third rule)\b": "a method's name",
    r"\b(one to two|least squares)\b": "a method's name",
    r"\bten (equal )?steps\b": "a division that's chosen",
    r"\bhalf[- ](angles?|a turn)\b": "an angle",
    r"\b(upper|lower) disc\b|\blower left\b|\blarger circle\b": "a place in the drawing",
    r"\blower the\b": "a verb",
    r"\bmore urgent\b": "an order of tasks that's given",
    r"\bmore than a million such lines\b": "held by the number's test",
    r"\bat (most|least|worst)\b": "a statistic, which stands by its number",
    r"\b(nearest and a farthest|nearest to the|highest of its section)\b": "a choice by a size",
    r"\bgreatest of those\b": "a choice by a size",
    r"\b(at its greatest|of greatest) N?": "a place that's meant",
    r'"[^"]*"': "a document's own words",
}


def bracketed(text, start):
    """Return what stands between the bracket at a place and the one that closes it."""
    depth = 0
    for place in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[place], 0)
        if depth == 0:
            return text[start + 1 : place]
    raise ValueError(f"{text[start : start + 40]!r}: the bracket isn't closed.")


CAPTION = re.compile(
    r"#(?:fig|tabular)\((?:[^()\"]|\"[^\"]*\")*\)(?=\[)|\b(?:caption|abstract): (?=\[)"
)


def captions(text):
    """Return the captions in a source of the report, and its abstract."""
    return [bracketed(text, place.end()) for place in CAPTION.finditer(text)]


def worded(sentence):
    """Return the words of a sentence, without calls, labels and code; a formula is N."""
    words = re.sub(r"//[^\n]*|`[^`]*`|@[\w-]+|<[\w-]+>", " ", plain(sentence))
    return " ".join(re.sub(r"\$[^$]*\$", " N ", words).split())


def claims(text):
    """Return words that compare or count without a record: not made by num, than or count.

    A word that compares is backed by a record of its sentence whose name has it; a superlative, by
    one whose name says that kind.
    """
    found = []
    for sentence in END.split(text):
        names = " ".join(name for _, name in NUMBER.findall(sentence))
        words = worded(sentence)
        for free in FREE:
            words = re.sub(free, " ", words, flags=re.I)
        for word in CLAIMS.findall(words):
            kinds = statistics(word) if word.lower() in SUPERLATIVES else set()
            named = word.lower() not in NUMBERS and re.search(rf"\b{word}\b", names, re.I)
            if not named and (not kinds or not kinds <= statistics(names)):
                found.append(word)
    return found


def orders(text):
    """Return the words of `claims` that aren't numbers: comparatives, superlatives, "never"."""
    return [word for word in claims(text) if word.lower() not in NUMBERS]
