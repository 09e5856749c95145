"""Every page looked at by axe-core; colours, darkness and small screens wherever a page is new."""

import axe
import pytest

from report.live.build import LIVE

# `make site`'s pages are among them, as `make live` builds them.
PAGES = sorted(LIVE.rglob("*.html"))
NARROW, TABLET, WIDE = 390, 768, 1366  # px
# What a style sheet may look at: each element's tag, class and own style, in all that it stands in;
# of a formula's parts in it alone.
KINDS = """(() => {
  const chains = new Map([[document.body.parentNode, ""]]);
  for (const e of document.body.parentNode.querySelectorAll("body, body *")) {
    const within = e.parentNode.closest("math") || e.parentNode;
    const own = `${e.localName}.${e.className}[${e.getAttribute("style")}]`;
    chains.set(e, `${chains.get(within)} ${own}`);
  }
  return [...new Set(chains.values())];
})()"""


@pytest.fixture(scope="module")
def script():
    try:
        return axe.provide()
    except LookupError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def known():
    """Return the kinds of elements that were looked at."""
    return set()


def test_pages_are_there():
    assert len(PAGES) > 100, "`make live` makes them"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(LIVE)))
def test_page_keeps_nobody_out_and_fits_small_screens(browser, script, screen, known, page):
    screen(WIDE)
    browser.open(page.as_uri())
    kinds = set(browser.run(KINDS))
    new = not kinds <= known
    known |= kinds
    assert axe.violations(browser, script, colours=new) == []
    for width in (TABLET, NARROW):
        screen(width, scheme="dark")
        assert browser.run("document.documentElement.scrollWidth") <= width
    if new:
        assert axe.violations(browser, script) == []


# What a page becomes when it is used: its address, what is clicked, and what is there then.
USED = [
    ("chapters/02_torus.html", "[data-program] button", "[data-program] input"),
    ("chapters/02_torus.html", "[data-exercise] button", "[data-exercise] textarea"),
    ("chapters/02_torus.html", ".scene button", ".stage canvas"),
    ("geodesic.html", "#asked .act", "#answer table"),
    ("planner.html", "#plan", "#budget"),
]


@pytest.mark.parametrize(("address", "clicked", "there"), USED, ids=lambda value: value)
def test_page_in_use_keeps_nobody_out(browser, script, screen, address, clicked, there):
    screen(WIDE)
    browser.open((LIVE / address).as_uri())
    browser.run(f"document.querySelector('{clicked}').click()")
    browser.until(f"!!document.querySelector('{there}')", 300)
    assert axe.violations(browser, script) == []
    screen(NARROW, scheme="dark")
    assert browser.run("document.documentElement.scrollWidth") <= NARROW
    assert axe.violations(browser, script) == []
