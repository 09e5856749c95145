"""The colours: apart in a print in grey too, and on the pages dark enough to read."""

import re
from itertools import combinations

import numpy as np
import pytest

from report.sources import ROOT

READS = ["report/site/style.css", "report/verdicts.typ"]


def luminance(colour):
    """Return the relative luminance of sRGB's definition (IEC 61966-2-1)."""
    part = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def lightness(colour):
    """Return CIE's L*, 0 to 100, of a colour that isn't nearly black."""
    return 116 * np.cbrt(luminance(colour)) - 16


def contrast(a, b):
    """Return the ratio of WCAG 2, 1 to 21."""
    light, dark = sorted([luminance(a), luminance(b)], reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.fixture(scope="module")
def sheet():
    return (ROOT / "report" / "site" / "style.css").read_text()


def test_text_on_the_pages_can_be_read(sheet):
    light, dark = (re.findall(r"--(\w+): (#\w{6});", part) for part in sheet.split("@media", 2)[:2])
    for named in ({"paper": "#ffffff"} | dict(light), dict(light) | dict(dark)):
        for text in ("ink", "grey", "link"):
            for ground in ("paper", "ground"):
                assert contrast(named[text], named[ground]) >= 4.5, text
    assert contrast(dict(light)["ink"], dict(light)["machine"]) >= 4.5  # the button's


def test_verdicts_can_be_read_and_differ_in_grey(sheet):
    source = (ROOT / "report" / "verdicts.typ").read_text(encoding="utf-8")
    printed = re.findall(r'"([\w ]+)": \(fill: rgb\("(#\w{6})"\), ink: (\w+)\)', source)
    looks = {word: (fill.lower(), ink) for word, fill, ink in printed}
    assert len(looks) == 6
    on_pages = re.findall(r"\.verdict\.([\w-]+) \{ color: (\w+); background: (#\w{6})", sheet)
    assert {word.replace("-", " "): (fill, ink) for word, ink, fill in on_pages} == looks
    inks = {"white": "#ffffff", "black": "#000000"}
    assert min(contrast(fill, inks[ink]) for fill, ink in looks.values()) >= 4.5
    grounds = [fill for fill, _ in looks.values()]
    assert min(abs(lightness(a) - lightness(b)) for a, b in combinations(grounds, 2)) >= 15
