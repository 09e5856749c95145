"""The pages, opened as files: quiet, whole, turned and searched by hand."""

import base64
import shutil
import subprocess
import time

import numpy as np
import PIL.Image
import pytest
from chromium import wait

from report.site.build import SITE

PAGES = sorted(SITE.rglob("*.html"))
CHAPTERS = [page for page in PAGES if page.parent.name == "chapters"]
WITH_SCENES = [page for page in PAGES if 'class="scene"' in page.read_text()]


def turn(browser, page):
    """Open a page and its first scene; return the script that gives the scene, drawn."""
    browser.open(page.as_uri())
    browser.run("document.querySelector('.scene button').click()")
    browser.until("!!document.querySelector('.stage canvas')")
    stage = "document.querySelector('.stage')"
    wait(lambda: browser.picture(stage).std() > 3, said="a picture of the scene")
    time.sleep(1)
    return stage


def chapter(name):
    return next(page for page in CHAPTERS if page.stem == name)


def test_pages_are_there():
    assert len(PAGES) > 50 and WITH_SCENES, "`make site` makes them"


def test_every_page_is_quiet_and_every_link_leads_to_one(browser):
    opened, linked = set(), set()
    for page in PAGES:
        browser.open(page.as_uri())
        for image in ("i.loading = 'eager'", "i.decode()"):
            browser.run(f"Promise.all([...document.images].map((i) => {image})).then(() => true)")
        assert browser.errors == browser.outside == [], page
        opened.add(page.as_uri())
        links = browser.run("[...document.links].map((link) => link.href)")
        linked |= {link.split("#")[0] for link in links if link.startswith("file:")}
    files = {link for link in linked if not link.endswith(".html")}
    assert linked - files == opened, "a page that nothing leads to, or a link that leads nowhere"


@pytest.mark.parametrize("page", WITH_SCENES, ids=lambda page: page.stem)
def test_scene_is_turned(browser, page):
    stage = turn(browser, page)
    before = browser.picture(stage)
    browser.drag(stage, 150, 60)
    wait(lambda: (browser.picture(stage) != before).mean() > 0.01, said="another one")
    assert browser.errors == [] and browser.outside == []


def test_scene_stands_in_its_pictures_place_and_leaves_the_wheel_to_the_page(browser, screen):
    screen(390, 900)
    turn(browser, chapter("02_torus"))
    assert browser.run("!!document.querySelector('figure > .stage')")
    box = browser.run("document.querySelector('.stage').getBoundingClientRect().toJSON()")
    assert box["left"] >= 0 and box["right"] <= 390
    turned = "document.querySelector('.stage canvas').dispatchEvent(new WheelEvent('wheel', {}))"
    for keys, left in (("", True), ("ctrlKey: true, ", False)):
        event = f"{{{keys}deltaY: 100, bubbles: true, cancelable: true}}"
        assert browser.run(turned.replace("{}", event)) is left
    names = "[...document.querySelectorAll('.scene p button')].map((b) => b.ariaLabel)"
    assert len(set(browser.run(names))) == 6
    assert browser.errors == []


# Drawing takes 0.3 s, as on a computer without a graphics card.
SLOW = """(() => {
  const { prototype } = WebGL2RenderingContext;
  const { clear } = prototype;
  let waited = false;
  prototype.clear = function (mask) {
    if (!waited) {
      waited = true;
      setTimeout(() => (waited = false));
      const end = performance.now() + 300;
      while (performance.now() < end);
      window.drawn = (window.drawn ?? 0) + 1;
    }
    return clear.call(this, mask);
  };
})()"""


def test_slow_scene_turns_as_far_as_the_hand_goes_and_the_wheel_scrolls_the_page(browser):
    browser.open(chapter("02_torus").as_uri())
    browser.run(SLOW)
    browser.run("document.querySelector('.scene button').click()")
    browser.until("!!document.querySelector('.stage canvas')")
    stage = "document.querySelector('.stage')"
    wait(lambda: browser.picture(stage).std() > 3, said="a picture of the scene")
    camera = "renderWindow.getRenderers()[0].getActiveCamera().getDirectionOfProjection()"
    before, drawn = browser.run(camera), browser.run("drawn")
    browser.drag(stage, 150, 0)
    # 0.4 degrees a pixel, about the view's upright.
    turned = np.cos(np.radians(0.4 * 150))
    wait(lambda: abs(np.dot(browser.run(camera), before) - turned) < 0.02, 20, "60 degrees")
    assert browser.run("drawn") > drawn, "drawings were slow meanwhile"
    x, y = browser.middle(stage)
    there = browser.run("scrollY")
    browser.send("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=200)
    browser.until(f"scrollY > {there}")
    names = browser.run("[...document.querySelectorAll('.scene p button')].map((b) => b.ariaLabel)")
    assert len(set(names)) == 6 and all(": Scene 1, " in name for name in names)
    assert browser.errors == []


@pytest.mark.parametrize("kind", ["browser", "fox"])
@pytest.mark.parametrize(
    "name", ["chapters/02_torus", "chapters/42_budget", "supplement", "library/surfaces.torus"]
)
def test_permalinks_lead_to_their_headings_also_after_a_reload(request, kind, name):
    browser = request.getfixturevalue(kind)
    address = (SITE / f"{name}.html").as_uri()
    browser.open(address)
    headings = browser.run(
        "[...document.querySelectorAll('main :is(h2, h3, h4)[id]')].map((head) =>"
        "[head.id, head.querySelector('.permalink').getAttribute('href')])"
    )
    assert len(headings) > 5 and all(link == f"#{own}" for own, link in headings)
    own, link = headings[len(headings) // 2]
    place = f"document.getElementById('{own}').getBoundingClientRect().top"
    seen = "new Promise((done) => setTimeout(() => done(true), 300))"  # pictures come meanwhile
    browser.run(f"document.querySelector('.permalink[href=\"{link}\"]').click()")
    for again in ("", "location.reload(), ", f"location.replace('{address}{link}'), "):
        browser.run(f"({again}true)")
        time.sleep(0.5)
        browser.until("document.readyState === 'complete'")
        browser.run(seen)
        assert browser.run("location.hash") == link
        assert 0 <= browser.run(place) < 100, again


@pytest.mark.parametrize("kind", ["browser", "fox"])
def test_notebook_is_saved_from_the_disk(request, kind, tmp_path):
    browser = request.getfixturevalue(kind)
    browser.save_in(tmp_path)
    browser.open((SITE / "chapters" / "02_torus.html").as_uri())
    browser.run("document.querySelector('.download a').click()")
    there = tmp_path / "02_torus.ipynb"
    wait(lambda: there.exists() and there.stat().st_size, said="the notebook")
    assert there.read_bytes() == (SITE / "notebooks" / there.name).read_bytes()
    assert browser.run("location.href").endswith("chapters/02_torus.html")


PRINTED = "document.querySelector('details.printed')"


def test_equation_as_printed_is_shown_by_mouse_and_keys(browser):
    browser.open((SITE / "supplement.html").as_uri())
    browser.run(f"{PRINTED}.scrollIntoView({{ block: 'center' }})")
    shown = f"{PRINTED}.open && {PRINTED}.querySelector('math').checkVisibility()"
    x, y = browser.middle(f"{PRINTED}.parentElement.querySelector('math')")
    for place, opened in (((x, y), True), ((1, 1), False)):
        browser.send("Input.dispatchMouseEvent", type="mouseMoved", x=place[0], y=place[1])
        browser.until(f"!!({shown}) === {str(opened).lower()}")
    before = "[...document.querySelectorAll('a, summary')]"
    browser.run(f"{before}[{before}.indexOf({PRINTED}.querySelector('summary')) - 1].focus()")
    browser.press("Tab", 9)
    assert browser.run(f"document.activeElement === {PRINTED}.querySelector('summary')")
    assert browser.run(shown)
    browser.press("Escape", 27)
    assert not browser.run(shown)
    browser.press("Enter", 13)
    browser.until(shown)
    browser.press("Tab", 9)
    browser.until(f"!{PRINTED}.open")


def test_equation_as_printed_is_shown_by_a_finger(browser, screen):
    screen(390, 800)
    browser.send("Emulation.setTouchEmulationEnabled", enabled=True)
    try:
        browser.open((SITE / "supplement.html").as_uri())
        browser.run(f"{PRINTED}.scrollIntoView({{ block: 'center' }})")
        box = browser.run(f"{PRINTED}.querySelector('summary').getBoundingClientRect().toJSON()")
        assert box["height"] >= 24
        x, y = box["x"] + box["width"] - 9, box["y"] + box["height"] / 2
        for opened in ("true", "false"):
            browser.send(
                "Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}]
            )
            browser.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
            browser.until(f"{PRINTED}.open === {opened}")
            if opened == "true":
                ends = browser.run(
                    f"{PRINTED}.querySelector('math').getBoundingClientRect().toJSON()"
                )
                assert ends["left"] >= 0 and ends["right"] <= 390
    finally:
        browser.send("Emulation.setTouchEmulationEnabled", enabled=False)


@pytest.mark.parametrize("name", ["report", "supplement", "chapters/42_budget"])
def test_tables_on_a_phone_show_that_they_scroll(browser, screen, name):
    screen(390, 800)
    browser.open((SITE / f"{name}.html").as_uri())
    browser.run("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
    tables = browser.run(
        "[...document.querySelectorAll('main table')].map((table) =>"
        "[table.scrollWidth > table.clientWidth, getComputedStyle(table, '::before').content,"
        "table.tabIndex])"
    )
    assert any(wide for wide, _, _ in tables)
    for wide, said, reached in tables:
        assert ("scrolls sideways" in said) == wide == (reached == 0)


@pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="Debian's poppler-utils looks at PDFs")
@pytest.mark.parametrize(
    "name", ["index", "report", "supplement", "chapters/02_torus", "chapters/31_rod"]
)
def test_print_has_no_empty_halves(browser, name, tmp_path):
    browser.open((SITE / f"{name}.html").as_uri())
    browser.run("Promise.all([...document.images].map((i) => ((i.loading = 'eager'), i.decode())))"
                ".then(() => true)")  # fmt: skip
    made = browser.send("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)  # A4, in inches
    (tmp_path / "a.pdf").write_bytes(base64.b64decode(made["data"]))
    see = ["pdftoppm", "-r", "20", "-gray", "a.pdf", "page"]
    subprocess.run(see, cwd=tmp_path, check=True)
    *pages, _ = [np.asarray(PIL.Image.open(one)) for one in sorted(tmp_path.glob("page*"))]
    filled = [np.flatnonzero((page < 200).any(axis=1))[-1] / len(page) for page in pages]
    assert min(filled) > 0.5, [n for n, share in enumerate(filled, 1) if share <= 0.5]


def test_first_page_s_machine_moves_until_it_is_stopped(browser):
    browser.open((SITE / "index.html").as_uri())
    place = "document.querySelector('.cutter').transform.animVal[0].matrix.e"
    first = browser.run(place)
    browser.until(f"{place} !== {first}")
    browser.run("document.getElementById('still').click()")
    stopped = browser.run(place)
    time.sleep(0.5)
    assert browser.run(place) == stopped
    assert browser.run("document.getElementById('still').ariaPressed") == "true"


def test_scene_is_turned_by_keyboard(browser):
    stage = turn(browser, WITH_SCENES[0])
    assert browser.run(f"document.activeElement === {stage}")
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


def test_dark_is_what_the_system_asks_until_a_button_says_otherwise(browser, screen):
    dark = "getComputedStyle(document.body).backgroundColor !== 'rgb(255, 255, 255)'"
    try:
        for page, asked in zip(CHAPTERS, ("dark", "light", "dark"), strict=False):
            screen(1300, scheme=asked)
            browser.open(page.as_uri())
            assert browser.run(dark) == (page == CHAPTERS[0])
            browser.run("kept.scheme || document.getElementById('scheme').click()")
            assert not browser.run(dark)
    finally:
        browser.run("kept.removeItem('scheme')")


@pytest.mark.parametrize("width", [390, 1400])
def test_lists_stand_beside_the_text_or_fold_above_it(browser, screen, width):
    screen(width, 844)
    browser.open(CHAPTERS[-1].as_uri())
    lists = "[...document.querySelectorAll('.contents details')]"
    assert browser.run(f"{lists}.map((one) => one.open)") == [width > 500] * 2
    browser.run(f"{lists}[1].querySelector('summary').focus()")
    if width < 500:
        browser.press("Enter", 13)
    browser.until(f"{lists}[1].open && {lists}[1].querySelector('ul').scrollTop > 0")
    assert browser.run("document.querySelector('main').getBoundingClientRect().top") < 844


def test_code_is_copied_without_its_number(browser):
    browser.open(chapter("02_torus").as_uri())
    browser.run("navigator.clipboard.writeText = async (text) => { window.taken = text; }")
    browser.run("document.querySelector('#cell-2 .copy').click()")
    browser.until("document.querySelector('#cell-2 .copy').textContent === 'Copied'")
    assert browser.run("taken === document.querySelector('#cell-2 .code pre').textContent")


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_first_picture_begins_in_the_first_screen(browser, screen, width, height):
    screen(width, height)
    tops = {}
    for page in CHAPTERS:
        browser.open(page.as_uri())
        browser.run("document.getElementById('code').checked = true")  # whoever hid it before
        browser.until("!!document.querySelector('.cell img')")
        first = "document.querySelector('.cell img').getBoundingClientRect().top + scrollY"
        tops[page.stem] = round(browser.run(first))
    print(f"{width} x {height}: first pictures begin {min(tops.values())} to {max(tops.values())}")
    assert {stem: top for stem, top in tops.items() if top >= height} == {}


def test_folded_code_opens_by_a_click_and_where_a_link_leads(browser):
    page = chapter("02_torus")
    browser.open(page.as_uri() + "#cell-2")
    folded = "document.querySelector('#cell-{} > details.source')"
    browser.run("document.getElementById('code').checked = true")
    assert browser.run(folded.format(2) + ".open") and not browser.run(folded.format(1) + ".open")
    browser.run(folded.format(1) + ".querySelector('summary').click()")
    assert browser.run(folded.format(1) + ".open")


def test_anchors_are_seen_on_a_small_screen(browser, screen):
    screen(420, 800)
    browser.open((SITE / "supplement.html").as_uri() + "#circuit")
    browser.until("Math.abs(document.getElementById('circuit').getBoundingClientRect().top) < 200")
    header = "document.querySelector('header').getBoundingClientRect().bottom"
    assert browser.run(f"{header} < document.getElementById('circuit').getBoundingClientRect().top")


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


@pytest.mark.parametrize("width", [320, 390, 768, 1366])
def test_what_the_search_finds_is_seen_whole_on_any_screen(browser, screen, width):
    screen(width, 800)
    browser.open((SITE / "index.html").as_uri())
    browser.run("(field.value = 'geodesic', answer().then(() => true))")
    box = browser.run("found.getBoundingClientRect().toJSON()")
    field = browser.run("field.getBoundingClientRect().toJSON()")
    assert box["left"] >= 0 and box["right"] <= width and box["top"] >= field["bottom"]
    assert browser.run("document.querySelectorAll('#results a').length") == 30
    assert "the best 30 are shown" in browser.run("document.getElementById('count').textContent")


def test_search_is_done_by_keyboard(browser):
    browser.open((SITE / "index.html").as_uri())
    browser.press("/", 191)
    browser.send("Input.insertText", text="clairaut")
    browser.until("document.querySelectorAll('#found a').length > 0")
    browser.press("ArrowDown", 40)
    assert browser.run("document.activeElement.closest('#found') !== null")
    target = browser.run("document.activeElement.href")
    browser.run("document.activeElement.click()")
    browser.until(f"location.href === '{target}' && document.readyState === 'complete'")
    assert "clairaut" in browser.run("document.body.textContent.toLowerCase()")
    assert browser.errors == []
