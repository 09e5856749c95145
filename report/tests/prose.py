"""The report's prose as tests read it, and which of its words compare or count without a record."""

import re

from report.sources import ROOT

END = re.compile(r"(?<=[.:;])\s+(?=[A-Z#@+*_])|\n\n|\n(?=[+-] )")
NUMBER = re.compile(r'#(?:num|count)\(\s*"([^"]+)",\s*"([^"]+)"\s*\)')
CALL = re.compile(r'#\w+\(\s*"[^"]*"(?:,\s*(?:\w+: *)?(?:"[^"]*"|[\d.]+%))*,?\s*\)')
CAPTION = re.compile(
    r"#(?:fig|tabular)\((?:[^()\"]|\"[^\"]*\")*\)(?=\[)|\b(?:caption|abstract): (?=\[)"
)
ORDERS = (
    "closer nearer shorter longer better worse faster slower more fewer less greater larger "
    "smaller higher lower wider narrower deeper thicker thinner farther milder never always"
).split()
COUNTS = (
    "two three four five six seven eight nine ten eleven twelve "
    "twice half double triple tenfold twentyfold hundredfold"
).split()
# What the name of a record says of its number, and how the number's sentence may say it.
CONDITIONS = {
    "median": "medians?",
    "least": "least|from to",
    "greatest|largest": "greatest|largest|from to|up to",
    **{
        word: word
        for word in (
            "worst rms t0 t1 t2 t3 first radius raised equal unequal constant adaptive oil "
            "concrete mortar invert roof random pose knots"
        ).split()
    },
}
SMALL = "the and for with from its over all than that whose".split()  # words that bind nothing
# What compares or counts and is no result, with the reason.
FREE = {
    r"\bthe worse of (both|the two joints)\b": "says which of two values is drawn",
    r"\btwo (such )?(joints|cylinders|nodes)\b": "a number that belongs to the machine or torus",
    r"\b(two|three) documents\b": "what the study has before it",
    r"\b(three surfaces|two volumes|one to two)\b": "a method's name",
    r"\bten (equal )?steps\b": "a division that's chosen",
    r"\bhalf[- ](angles?|a turn)\b": "an angle",
    r"\b(upper|lower) disc\b|\blower left\b|\blarger circle\b": "a place in the drawing",
    r"\blower the\b": "a verb",
    r"\bmore urgent\b": "an order of tasks that's given",
    r"\bmore than a million such lines\b": "held by the number's test",
    r'"[^"]*"': "a document's own words",
}


def sources():
    """Return the files of prose: the sections of the supplement, and the two documents last."""
    report = ROOT / "report"
    sections = sorted((report / "sections").glob("*.typ"))
    return [*sections, report / "supplement.typ", report / "report.typ"]


def bracketed(text, start):
    """Return what stands between the bracket at a place and the one that closes it."""
    depth = 0
    for place in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[place], 0)
        if depth == 0:
            return text[start + 1 : place]
    raise ValueError(f"{text[start : start + 40]!r}: the bracket isn't closed.")


def captions(text):
    """Return the captions in a source of the report, and its abstract."""
    return [bracketed(text, place.end()) for place in CAPTION.finditer(text)]


def worded(sentence, formula=" N "):
    """Return the words of a sentence, without calls, labels and code; a formula is N."""
    words = re.sub(r"//[^\n]*|`[^`]*`|@[\w-]+|<[\w-]+>", " ", CALL.sub(" ", sentence))
    return " ".join(re.sub(r"\$([^$]*)\$", formula, words).split())


def unsaid(text):
    """Return the names of a text's records of whose condition the sentence says nothing."""
    found = []
    for sentence in END.split(text):
        said = worded(sentence).lower()
        names = dict.fromkeys(name for _, name in NUMBER.findall(sentence))
        for kind, ways in CONDITIONS.items():
            pattern = rf"\b(?:{kind})\b"
            told = re.search(rf"\b(?:{ways})\b", said)
            found += [name for name in names if re.search(pattern, name.lower()) and not told]
    return found


def unbound(text):
    """Return the names of records of whose words their sentence says less than half, or has two."""

    def stems(words):
        return {word[:4] for word in re.findall(r"[a-z]{3,}", words.lower()) if word not in SMALL}

    found = []
    for sentence in END.split(text):
        said = stems(worded(sentence, r" \1 "))
        records = NUMBER.findall(sentence)
        for record in dict.fromkeys(records):
            words = stems(record[1])
            if len(words & said) < len(words) / 2 or records.count(record) > 1:
                found.append(record[1])
    return found


def unbacked(text, words=(*ORDERS, *COUNTS)):
    """Return those of some words that stand in a text and come from no record.

    A record backs a word that compares if its own name, in the same sentence, has that word.
    """
    found = []
    for sentence in END.split(text):
        names = " ".join(name for _, name in NUMBER.findall(sentence))
        backed = set(re.findall(r"\w+", names.lower())) - set(COUNTS)
        said = re.sub("|".join(FREE), " ", worded(sentence), flags=re.I).lower()
        found += [w for w in re.findall(r"[a-z]+", said) if w in words and w not in backed]
    return found
