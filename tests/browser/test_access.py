"""Every page, light and dark, looked at by axe-core; and on small screens."""

import axe
import pytest

from report.live.build import LIVE
from report.site.build import SITE

PAGES = [page for folder in (LIVE, SITE) for page in sorted(folder.rglob("*.html"))]


@pytest.fixture(scope="module")
def script():
    try:
        return axe.provide()
    except LookupError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_page_keeps_anybody_out(browser, script, scheme):
    browser.send("Emulation.setEmulatedMedia",
                 features=[{"name": "prefers-color-scheme", "value": scheme}])  # fmt: skip
    rules = ["color-contrast"] if scheme == "dark" else None  # nothing else depends on it
    told = []
    for page in PAGES:
        browser.open(page.as_uri())
        told += [f"{page.name}: {line}" for line in axe.violations(browser, script, rules)]
    browser.send("Emulation.setEmulatedMedia", features=[])
    assert PAGES and told == []


@pytest.mark.parametrize("width", [390, 768])
def test_no_page_is_wider_than_a_small_screen(browser, width):
    browser.send("Emulation.setDeviceMetricsOverride", width=width, height=900,
                 deviceScaleFactor=1, mobile=True)  # fmt: skip
    wide = []
    for page in PAGES:
        browser.open(page.as_uri())
        if (needs := browser.run("document.documentElement.scrollWidth")) > width:
            wide.append(f"{page.name}: {needs}")
    browser.send("Emulation.clearDeviceMetricsOverride")
    assert PAGES and wide == []
