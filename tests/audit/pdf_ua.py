"""List by hand what PDF/UA-1 asks of the documents, for tests/audit/pdf_ua.md.

    .venv/bin/python -m tests.audit.pdf_ua [FILE.pdf ...]

A validator, veraPDF, is in no package registry that a study may ask; Typst keeps the standard while
it compiles. This reads the finished files in another way: by their objects' text.
"""

import re
import sys
import zlib
from pathlib import Path

from report.lists import PDFS

GLYPH = re.compile(rb"/Type ?/Font\b(?:(?!endobj).)*?/Subtype ?/(?:Type0|Type1|TrueType)", re.S)


def objects(content):
    """Return the text of a PDF's objects, those in compressed streams among them."""
    parts = [content]
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, re.S):
        try:
            parts.append(zlib.decompress(stream))
        except zlib.error:  # a picture, or not compressed
            continue
    return b"\n".join(parts)


def checks(content):
    """Return what is asked, each with what was found of it and whether that is right."""
    text = objects(content)

    def many(pattern):
        return len(re.findall(pattern, text))

    figures, formulas = many(rb"/S ?/Figure\b"), many(rb"/S ?/Formula\b")
    fonts, unicode = len(GLYPH.findall(text)), many(rb"/ToUnicode\b")
    asked = {
        "marked as tagged": (many(rb"/Marked true"), 1),
        "a language": (many(rb"/Lang ?\("), 1),
        "a title, shown in the window's bar": (many(rb"/DisplayDocTitle true"), 1),
        "its title in the metadata": (many(rb"<dc:title>"), 1),
        "PDF/UA-1 in the metadata": (many(rb"<pdfuaid:part>1<"), 1),
        "bookmarks": (many(rb"/Type ?/Outlines"), 1),
        "pages whose tabs follow the structure": (many(rb"/Tabs ?/S\b"), many(rb"/Type ?/Page\b")),
        "alternative texts of figures and formulas": (many(rb"/Alt ?[(<]"), figures + formulas),
        "cells of table heads, with a scope": (many(rb"/Scope ?/"), many(rb"/S ?/TH\b")),
        "links with a text of their own": (many(rb"/Contents ?[(<]"), many(rb"/Subtype ?/Link\b")),
        "fonts with a way to Unicode": (unicode, fonts),
    }
    return [[what, found, least, found >= least] for what, (found, least) in asked.items()]


def main(files):
    for file in files:
        print(f"\n{Path(file).name}")
        for what, found, least, right in checks(Path(file).read_bytes()):
            print(f"| {what} | {found} | {least} | {'yes' if right else 'NO'} |")


if __name__ == "__main__":
    main(sys.argv[1:] or PDFS.values())
