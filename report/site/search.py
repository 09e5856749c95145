"""The index that the pages' search looks up: which sections hold a word."""

import json
import re
import unicodedata
from collections import defaultdict

from report.site.markup import plain

HEADING = re.compile(r'<h[1-4][^>]*\bid="([^"]+)"[^>]*>(.*?)</h[1-4]>', re.S)
WORD = re.compile(r"\w+")
JUDGED = re.compile(
    r'<div class="judged">(.*?)<div class="label">\((.*?)\)</div>'
    r'.*?\bid="([^"]+)"[^>]*>(.*?)</div>',
    re.S,
)


def sections(title, address, body):
    """Yield each section of a page as (title, address, text), cut at its named headings.

    A judged equation is found by its number too, right after its section.
    """
    start, name, target = 0, title, address
    for match in [*HEADING.finditer(body), None]:
        content = body[start : match.start() if match else None]
        text = plain(content)
        if text or not match:
            yield name, target, text
        for formula, number, place, verdict in JUDGED.findall(content):
            yield f"{name} · Eq. {number}", f"{address}#{place}", plain(f"{formula} <p>{verdict}")
        if match:
            start, heading = match.end(), plain(match[2])
            name = title if heading == title else f"{title} · {heading}"
            target = f"{address}#{match[1]}"


def words(text):
    """Return the words of a text as the search folds them, a formula's letters as plain ones."""
    return WORD.findall(unicodedata.normalize("NFKD", text).lower())


def script(entries):
    """Return the index as a script, which a page that is opened as a file can load."""
    index = defaultdict(list)
    for number, (title, _, text) in enumerate(entries):
        for word in sorted(set(words(f"{title} {text}"))):
            if len(word) > 1 or word.isdigit() or not word.isascii():
                index[word].append(number)
    content = {"words": dict(sorted(index.items())), "sections": entries}
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"))
    return f"window.searchIndex = {text};\n"
