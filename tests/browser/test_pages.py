"""The pages, opened as files: quiet, whole, turned and searched by hand."""

import time

import pytest
from chromium import wait

from report.site.build import SITE

PAGES = sorted(SITE.rglob("*.html"))
WITH_SCENES = [page for page in PAGES if 'class="scene"' in page.read_text()]


def elsewhere(browser):
    """Return the requests that left the file system."""
    return [r for r in browser.requests if not r.startswith(("file:", "data:", "blob:"))]


def test_pages_are_there():
    assert len(PAGES) > 50 and WITH_SCENES, "`make site` makes them"


def test_every_page_is_quiet_and_every_link_leads_to_one(browser):
    browser.requests.clear()
    opened, linked = set(), set()
    for page in PAGES:
        browser.open(page.as_uri())
        for image in ("i.loading = 'eager'", "i.decode()"):
            browser.run(f"Promise.all([...document.images].map((i) => {image})).then(() => true)")
        assert browser.errors == [], page
        opened.add(page.as_uri())
        links = browser.run("[...document.links].map((link) => link.href)")
        linked |= {link.split("#")[0] for link in links if link.startswith("file:")}
    files = {link for link in linked if not link.endswith(".html")}
    assert linked - files == opened, "a page that nothing leads to, or a link that leads nowhere"
    assert elsewhere(browser) == []


@pytest.mark.parametrize("page", WITH_SCENES, ids=lambda page: page.stem)
def test_scene_is_turned(browser, page):
    browser.requests.clear()
    browser.open(page.as_uri())
    browser.run("document.querySelector('.scene button').click()")
    browser.until("!!document.querySelector('.stage canvas')")
    stage = "document.querySelector('.stage')"
    wait(lambda: browser.picture(stage).std() > 3, said="a picture of the scene")
    time.sleep(1)
    before = browser.picture(stage)
    browser.drag(stage, 150, 60)
    wait(lambda: (browser.picture(stage) != before).mean() > 0.01, said="another one")
    assert browser.errors == [] and elsewhere(browser) == []


def test_scene_stands_in_its_pictures_place_and_leaves_the_wheel_to_the_page(browser):
    page = next(page for page in WITH_SCENES if page.stem == "02_torus")
    browser.send("Emulation.setDeviceMetricsOverride", width=390, height=900, deviceScaleFactor=1,
                 mobile=True)  # fmt: skip
    browser.open(page.as_uri())
    browser.run("document.querySelector('.scene button').click()")
    browser.until("!!document.querySelector('figure > .stage canvas')")
    box = browser.run("document.querySelector('.stage').getBoundingClientRect().toJSON()")
    assert box["left"] >= 0 and box["right"] <= 390
    turned = "document.querySelector('.stage canvas').dispatchEvent(new WheelEvent('wheel', {}))"
    for keys, left in (("", True), ("ctrlKey: true, ", False)):
        event = f"{{{keys}deltaY: 100, bubbles: true, cancelable: true}}"
        assert browser.run(turned.replace("{}", event)) is left
    names = "[...document.querySelectorAll('.scene p button')].map((b) => b.ariaLabel)"
    assert len(set(browser.run(names))) == 6
    browser.send("Emulation.clearDeviceMetricsOverride")
    assert browser.errors == []


def test_first_page_s_machine_moves_until_it_is_stopped(browser):
    browser.open((SITE / "index.html").as_uri())
    place = "document.querySelector('.cutter').cx.animVal.value"
    first = browser.run(place)
    browser.until(f"{place} !== {first}")
    browser.run("document.getElementById('still').click()")
    stopped = browser.run(place)
    time.sleep(0.5)
    assert browser.run(place) == stopped
    assert browser.run("document.getElementById('still').ariaPressed") == "true"


def test_scene_is_turned_by_keyboard(browser):
    browser.open(WITH_SCENES[0].as_uri())
    browser.run("document.querySelector('.scene button').click()")
    browser.until("document.activeElement.className === 'stage'")
    stage = "document.activeElement"
    wait(lambda: browser.picture(stage).std() > 3, said="a picture of the scene")
    time.sleep(1)
    for key, code in (("ArrowLeft", 37), ("ArrowUp", 38), ("+", 187)):
        before = browser.picture(stage)
        browser.press(key, code)
        wait(lambda old=before: (browser.picture(stage) != old).mean() > 0.005, said=key)
    assert browser.run("document.querySelector('[class*=bigFileDrop]') === null")
    assert browser.errors == []


def test_scene_that_cannot_be_loaded_says_so(browser):
    browser.open(WITH_SCENES[0].as_uri())
    browser.run("document.querySelector('.scene').dataset.scene = 'none'")
    browser.run("document.querySelector('.scene button').click()")
    browser.until("!!document.querySelector('.scene [role=alert]')")
    assert browser.run("document.activeElement.textContent") == "Turn it in 3-D"


def test_policy_lets_workers_and_wasm_run_but_nothing_inline(browser):
    browser.open((SITE / "index.html").as_uri())
    assert browser.run(
        "new Promise((done) => { const worker = new Worker(URL.createObjectURL(new Blob("
        "['postMessage(7)']))); worker.onmessage = (told) => done(told.data); })"
    ) == 7  # fmt: skip
    empty = "new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0])"
    assert browser.run(f"WebAssembly.compile({empty}).then((made) => !!made)")
    assert browser.errors == []
    for inline in (
        "document.body.insertAdjacentHTML('beforeend', '<img src=data:, onerror=\"ran = 1\">')",
        "(() => { const made = document.createElement('script'); made.textContent = 'ran = 1';"
        "document.head.append(made); })()",
        "document.head.insertAdjacentHTML('beforeend', '<style>body { color: red }</style>')",
    ):
        browser.errors.clear()
        browser.run(f"{inline}; true")
        wait(lambda: browser.run("true") and browser.errors, said=inline)
        assert "Content Security Policy" in browser.errors[0]
    assert browser.run("typeof ran") == "undefined"
    assert browser.run("getComputedStyle(document.body).color") != "rgb(255, 0, 0)"


def test_code_stays_hidden_but_where_a_link_leads(browser):
    first, second = [page for page in PAGES if page.parent.name == "chapters"][1:3]
    browser.open(first.as_uri())
    browser.run("document.getElementById('code').click()")
    browser.open(second.as_uri() + "#cell-2")
    seen = "getComputedStyle(document.querySelector('#cell-{} > .source')).display"
    assert browser.run(seen.format(1)) == "none" and browser.run(seen.format(2)) == "block"
    browser.run("document.getElementById('code').click()")
    assert browser.run(seen.format(1)) == "block"


def test_anchors_are_seen_on_a_small_screen(browser):
    browser.send("Emulation.setDeviceMetricsOverride", width=420, height=800, deviceScaleFactor=1,
                 mobile=False)  # fmt: skip
    browser.open((SITE / "supplement.html").as_uri() + "#circuit")
    browser.until("Math.abs(document.getElementById('circuit').getBoundingClientRect().top) < 200")
    header = "document.querySelector('header').getBoundingClientRect().bottom"
    assert browser.run(f"{header} < document.getElementById('circuit').getBoundingClientRect().top")
    browser.send("Emulation.clearDeviceMetricsOverride")


def test_search_finds_names_and_equations(browser):
    browser.open((SITE / "index.html").as_uri())
    for text, first in (("eq11_nu0", "test_eq11_nu0"), ("Eq. 5", "Eq. 5")):
        browser.run(f"(field.value = {text!r}, answer().then(() => true))")
        assert first in browser.run("document.querySelector('#found a b').textContent")
    assert browser.errors == []


@pytest.mark.parametrize("text", ["geodesic", "geodesc", "geodessic"])
def test_search_ranks_and_forgives_a_letter(browser, text):
    browser.open((SITE / "index.html").as_uri())
    browser.run(f"(field.value = {text!r}, answer().then(() => true))")
    first = browser.run("[...document.querySelectorAll('#found a')].slice(0, 2).map((a) => a.href)")
    assert "geodesic_inverse" in first[0] and "chapters/09_geodesic.html" in first[1]


def test_search_is_entered_by_a_key(browser):
    browser.open((SITE / "index.html").as_uri())
    browser.press("/", 191)
    assert browser.run("document.activeElement.id") == "search"


def test_search_is_done_by_keyboard(browser):
    browser.open((SITE / "index.html").as_uri())
    browser.run("document.getElementById('search').focus()")
    browser.send("Input.insertText", text="clairaut")
    browser.until("document.querySelectorAll('#found a').length > 0")
    browser.press("ArrowDown", 40)
    assert browser.run("document.activeElement.closest('#found') !== null")
    target = browser.run("document.activeElement.href")
    browser.run("document.activeElement.click()")
    browser.until(f"location.href === '{target}' && document.readyState === 'complete'")
    assert "clairaut" in browser.run("document.body.textContent.toLowerCase()")
    assert browser.errors == []
