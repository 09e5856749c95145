"""The index that the pages' search looks up: which sections hold a word."""

import json
import re
import unicodedata
from collections import defaultdict

from report.site.markup import plain

HEADING = re.compile(r'<h[1-4][^>]*\bid="([^"]+)"[^>]*>(.*?)</h[1-4]>', re.S)
WORD = re.compile(r"\w+")
LONGEST = 24  # letters; what is longer is a digest or a table's rule


def sections(title, address, body):
    """Yield each section of a page as (title, address, text), cut at its named headings."""
    start, name, target = 0, title, address
    for match in HEADING.finditer(body):
        if text := plain(body[start : match.start()]):
            yield name, target, text
        start, heading = match.end(), plain(match[2])
        name = title if heading == title else f"{title} · {heading}"
        target = f"{address}#{match[1]}"
    yield name, target, plain(body[start:])


def words(text):
    """Return the words of a text as the search folds them."""
    return WORD.findall(unicodedata.normalize("NFKD", text.lower()))


def script(entries):
    """Return the index as a script, which a page that is opened as a file can load."""
    index = defaultdict(list)
    for number, (title, _, text) in enumerate(entries):
        for word in sorted(set(words(f"{title} {text}"))):
            if 1 < len(word) <= LONGEST:
                index[word].append(number)
    content = {"words": dict(sorted(index.items())), "sections": entries}
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"))
    return f"window.searchIndex = {text};\n"
