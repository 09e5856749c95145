"""Pages that run, opened as files: sliders of chapters move pictures, in a moment, offline."""

import json
import os
import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from statistics import median

import pytest
from chromium import wait

from report.live.build import LIVE

RUNS = ["02_torus", "07_chord", "09_geodesic", "24_follow", "32_volume", "54_recognise"]
BOX = "document.querySelector('[data-program]')"
PICTURE = f"{BOX}.parentElement.querySelector('figure img')"
MOVE = """(() => {{
  const slider = {}.querySelector('input');
  slider.value = +slider.min + (slider.max - slider.min) * {};
  slider.dispatchEvent(new Event('input'));
}})()"""


def pages_with(mark):
    return [p for p in sorted((LIVE / "chapters").glob("*.html")) if mark in p.read_text()]


def chapters():
    return [page for page in WITH_SLIDERS if page.stem in RUNS]


WITH_SLIDERS, WITH_EXERCISES = pages_with("data-program"), pages_with("data-exercise")


def start(browser, page):
    """Open a page and load Python into it; return the seconds that it took."""
    browser.open(page.as_uri())
    browser.run(f"{BOX}.querySelector('button').click()")
    return browser.until(f"+{BOX}.dataset.ready", 120) / 1000


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *words):
        pass


@pytest.fixture
def server():
    """Return the address of a server of the pages."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=LIVE)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_slider_moves_a_picture_from_a_server(browser, server):
    browser.open(f"{server}chapters/02_torus.html")
    browser.run(f"{BOX}.querySelector('button').click()")
    browser.until(f"+{BOX}.dataset.ready", 120)
    before, drawn = browser.picture(PICTURE), browser.run(f"{BOX}.dataset.drawn")
    browser.run(MOVE.format(BOX, 0.3))
    wait(lambda: browser.run(f"{BOX}.dataset.drawn > {drawn}"), said="another drawing")
    assert (browser.picture(PICTURE) != before).mean() > 1e-4
    assert browser.errors == []
    assert [r for r in browser.outside if not r.startswith(server)] == []


def test_pages_that_run_are_there():
    assert len(chapters()) == 5, "`make live` makes them; 07 moves a scene"


@pytest.mark.parametrize("page", chapters(), ids=lambda page: page.stem)
def test_slider_moves_a_picture_at_once(browser, page):
    ready = start(browser, page)
    taken = []
    for share in (0.3, 0.5, 0.7, 0.6, 0.4, 0.2, 0.35, 0.55, 0.65):
        before, drawn = browser.picture(PICTURE), browser.run(f"{BOX}.dataset.drawn")
        browser.run(MOVE.format(BOX, share))
        wait(lambda n=drawn: browser.run(f"{BOX}.dataset.drawn > {n}"), said="another drawing")
        taken.append(float(browser.run(f"{BOX}.dataset.moment")))
        assert (browser.picture(PICTURE) != before).mean() > 1e-4
    usual = median(taken)
    cores, load = os.cpu_count(), os.getloadavg()[0]
    print(f"\n{page.stem}: ready after {ready:.1f} s, {usual:.0f} ms in the median, "
          f"on {cores} cores with a load of {load:.1f}")  # fmt: skip
    assert browser.errors == [] and browser.outside == []
    assert ready < 20 and usual < 300


@pytest.mark.parametrize("kind", ["browser", "fox"])
@pytest.mark.parametrize("page", WITH_SLIDERS, ids=lambda page: page.stem)
def test_every_slider_redraws_and_nothing_is_asked_outside(request, kind, page):
    said = moved_all(request.getfixturevalue(kind), page)
    print(f"\n{page.stem}, {kind}: {said}")  # whose times stand in report/guide/pages.md


def moved_all(browser, page):
    """Move every slider of a page; return in words how long that takes, also of processors."""
    browser.open(page.as_uri())
    taken, worked = [], []
    for number in range(browser.run("document.querySelectorAll('[data-program]').length")):
        box = f"document.querySelectorAll('[data-program]')[{number}]"
        browser.run(f"{box}.querySelector('button').click()")
        browser.until(f"+{box}.dataset.ready", 120)
        picture = f"[...{box}.parentElement.querySelectorAll('figure img')].pop()"
        sliders = browser.run(f"{box}.querySelectorAll('input').length")
        assert sliders > 0
        for which in range(sliders):
            words = {browser.run(f"{picture}.alt")}
            for share in (0.25, 0.8, 0.4, 0.65):
                drawn = browser.run(f"{box}.dataset.drawn")
                move = MOVE.format(box, share).replace(
                    "querySelector('input')", f"querySelectorAll('input')[{which}]"
                )
                before = browser.processor_seconds()
                browser.run(move)
                browser.until(f"{box}.dataset.drawn > {drawn}", 120)
                worked.append(1000 * (browser.processor_seconds() - before))
                taken.append(float(browser.run(f"{box}.dataset.moment")))
                words.add(browser.run(f"{picture}.alt"))
            assert len(words) > 1, "the picture says where its sliders stand"
        assert browser.run(f"{box}.querySelector('[role=status]').textContent") == ""
    assert browser.errors == [] and browser.outside == []
    return (
        f"{len(taken)} moves, {median(taken):.0f} ms in the median, {max(taken):.0f} at worst, "
        f"of processors {median(worked):.0f}, at a load of {os.getloadavg()[0]:.1f}"
    )


def digits_apart(text, page):
    """Return what is said, of hard lines without the digits: last bits decide those."""
    return re.sub(r"\d", "#", text) if page.stem == "31_rod" else text


@pytest.mark.parametrize("page", WITH_EXERCISES, ids=lambda page: page.stem)
def test_exercises_print_what_the_notebook_stored(browser, page):
    browser.open(page.as_uri())
    count = browser.run("document.querySelectorAll('[data-exercise]').length")
    for number in range(count):
        box = f"document.querySelectorAll('[data-exercise]')[{number}]"
        stored = browser.run(f"{box}.parentElement.querySelector('pre.output').textContent")
        assert digits_apart(tried(browser, box), page) == digits_apart(stored, page)
    assert browser.errors == [] and browser.outside == []


def tried(browser, box, code=None):
    """Return what an exercise prints, with its code changed or as it stands."""
    if browser.run(f"{box}.querySelector('textarea') === null"):
        browser.run(f"{box}.querySelector('button').click()")
        browser.until(f"{box}.dataset.ready", 120)
    if code is not None:
        browser.run(f"({box}.querySelector('textarea').value = {json.dumps(code)})")
    browser.run(f"{box}.querySelector('button').click()")
    return browser.until(
        f"(({{ textContent: said }}) => !said.startsWith('Running') && said)"
        f"({box}.querySelector('pre'))", 120
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["browser", "fox"])
def test_exercise_takes_what_the_reader_writes_and_says_what_is_wrong(request, kind):
    browser = request.getfixturevalue(kind)
    browser.open(next(page for page in WITH_EXERCISES if page.stem == "02_torus").as_uri())
    box = "document.querySelectorAll('[data-exercise]')[1]"
    assert tried(browser, box).endswith("not yet\n")
    answer = browser.run(f"{box}.querySelector('textarea').value").replace("= 8", "= 45")
    assert tried(browser, box, answer).endswith(": done\n")
    assert tried(browser, box, "print(machine.R, np.pi)") == "0.8 3.141592653589793\n"
    assert (
        tried(browser, box, "Torus(1, -1)")
        == "ValueError: R: must be one finite number above zero; got -1."
    )
    assert tried(browser, box, "1 +") == "SyntaxError: invalid syntax"


def test_what_is_asked_for_is_noted_in_firefox_too(fox):
    fox.open("about:blank")
    fox.run("fetch('http://127.0.0.1:5999/', { mode: 'no-cors' }).catch(() => 0)")
    assert fox.outside == ["http://127.0.0.1:5999/"]


def test_scene_that_firefox_cannot_draw_is_said_and_its_picture_stays(fox):
    fox.open((LIVE / "chapters" / "02_torus.html").as_uri())
    if fox.run("!!document.createElement('canvas').getContext('webgl2')"):
        pytest.skip("This Firefox draws scenes.")
    fox.run("document.querySelector('.scene button').click()")
    fox.until("!!document.querySelector('.scene [role=alert]')")
    assert fox.run("document.querySelector('.stage') === null")


def test_page_stays_free_while_python_loads(browser):
    browser.open(chapters()[0].as_uri())
    browser.run(
        "window.longest = 0; window.last = performance.now(); setInterval(() => {"
        "longest = Math.max(longest, performance.now() - last); last = performance.now(); }, 20)"
    )
    browser.run(f"{BOX}.querySelector('button').click()")
    browser.until(f"{BOX}.querySelector('progress')?.value > 0.4", 120)
    browser.run("window.longest = 0; true")
    browser.until(f"+{BOX}.dataset.ready", 120)
    longest = browser.run("longest")
    print(f"\nthe page stood still for at most {longest:.0f} ms while Python started")
    assert longest < 500


def test_picture_says_where_the_sliders_stand_and_keys_move_them(browser):
    start(browser, next(page for page in chapters() if page.stem == "02_torus"))
    assert browser.run("document.activeElement.type") == "range"
    before = browser.run(f"{PICTURE}.alt")
    browser.press("ArrowRight", 39)
    browser.until(f"{PICTURE}.alt !== {before!r}")
    assert "Drawn for ratio 2.656." in browser.run(f"{PICTURE}.alt")
    assert browser.run(f"{BOX}.querySelector('output').textContent") == "2.656"


@pytest.mark.parametrize("missing", ["WebAssembly", "Worker"])
def test_browser_that_cannot_says_so_and_keeps_the_picture(browser, missing):
    browser.open(chapters()[0].as_uri())
    stored = browser.run(f"{PICTURE}.src")
    browser.run(f"window.{missing} = undefined; {BOX}.querySelector('button').click()")
    assert "can't run Python in a page" in browser.run(f"{BOX}.textContent")
    assert browser.run(f"{PICTURE}.src") == stored


def test_sliders_that_cannot_start_say_why(browser):
    browser.open(chapters()[0].as_uri())
    browser.run(f"{BOX}.dataset.program = 'none'; runtimeParts.parts = [];")
    browser.run(f"{BOX}.querySelector('button').click()")
    browser.until(f'{BOX}.textContent.includes("Python didn\'t start")')
