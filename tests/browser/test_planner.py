"""The planner and the calculator, opened as files: the command line's own numbers."""

import json
import os
import re
import time
import tomllib
from pathlib import Path

import pytest
from chromium import wait

from report.live import planner
from report.live.build import LIVE
from report.sources import ROOT
from report.tests.test_live_planner import quick, said

REFERENCE = ROOT / "notebooks" / "reference.toml"
ANSWER = "document.getElementById('answer')"


def open_page(browser, name):
    browser.open((LIVE / name).as_uri())


def write(browser, name, value):
    """Write a value into a field of the form."""
    browser.run(
        f"(() => {{ const field = document.querySelector('[name=\"{name}\"]');"
        f"field.value = '{value}'; field.dispatchEvent(new Event('change')); }})()"
    )


def plan(browser):
    """Let the page plan and simulate; return the seconds on the clock, and of the processor."""
    began, used = time.monotonic(), browser.processor_seconds()
    browser.run("document.getElementById('plan').click()")
    state = "document.getElementById('state')"
    browser.until(f"!!{ANSWER}.querySelector('h2') || {state}.textContent.includes('ailed')", 300)
    assert browser.run(f"{state}.textContent") == ""
    return time.monotonic() - began, browser.processor_seconds() - used


def text_of_budget(browser):
    """Return what the page prints above and below the table of the budget."""
    printed = "[...document.querySelectorAll('#budget pre')].map((one) => one.textContent)"
    return browser.run(f"{printed}.join('')")


def around_table(printed):
    """Return what the command prints above and below that table."""
    return re.sub(r"each alone, in mm.*\n(?: .*\n)+", "", printed)


@pytest.mark.parametrize("kind", ["browser", "fox"])
def test_planner_gives_the_command_s_budget_to_the_printed_digit(
    request, kind, tmp_path, monkeypatch
):
    browser = request.getfixturevalue(kind)
    monkeypatch.setattr(planner, "HERE", tmp_path)
    cores, load = os.cpu_count(), os.getloadavg()[0]
    open_page(browser, "planner.html")
    taken, used = plan(browser)
    print(f"\n{type(browser).__name__} cuts: {taken:.0f} s with Python's loading, {used:.0f} "
          f"s of a processor, on {cores} cores with a load of {load:.1f} before")  # fmt: skip
    code, printed, _ = planner.cut(REFERENCE.read_text(), "job.toml")
    assert code == 0
    assert text_of_budget(browser) == around_table(printed)
    assert browser.errors == [] and browser.outside == []


def test_dropped_job_fills_the_form_and_its_files_are_the_command_s(browser, tmp_path, monkeypatch):
    monkeypatch.setattr(planner, "HERE", tmp_path)
    soft = "[ground]\nenergy = 1e6\npick_speed = 2.0\n\n# [hydraulics]"
    text = quick().replace("R = 0.80", "R = 0.81").replace("# [hydraulics]", soft)
    _, printed, files = planner.cut(text, "mine.toml")
    open_page(browser, "planner.html")
    drop(browser, "mine.toml", text)
    assert [value_of(browser, f"machine.{name}") for name in ("r", "R")] == ["0.08", "0.81"]
    assert job_of(browser) == text
    assert browser.run("document.getElementById('name').textContent") == "mine.toml"
    plan(browser)
    assert text_of_budget(browser) == around_table(printed)
    assert "only plant" in browser.run(f"{ANSWER}.querySelector('.said').textContent")
    links = browser.run(f"[...{ANSWER}.querySelectorAll('a[download]')].map((a) => a.download)")
    assert {Path(name).suffix for name in links} >= {".stl", ".st", ".xml", ".dxf", ".c", ".csv"}
    # The manifest has the pictures' digests, too.
    drawn = {"plan.png", "wall.png", "laps.png", "manifest.txt"}
    there = {name: fetched(browser, name, tmp_path / "saved") for name in {*links} - drawn}
    files["mine.toml"] = text.encode()
    assert {*there} == {*files} - drawn
    alike = {name for name, content in there.items() if content == files[name]}
    assert alike >= {"knots.csv", "line.c", "line.st", "section.dxf", "wall.stl", "mine.toml"}
    # A rounding that falls the other way moves an encoder's count, and the budget by nanometres. Of
    # two times ten million counts, whose fractions the controller has, it is four billionths.
    near = dict.fromkeys(("controller.c", "controller.st", "controller.xml"), 4e-9)
    for name, least in (near | {"budget.csv": 1e-7}).items():
        assert same(there[name], files[name], least), name


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [("R = 0.80", "R = 800", 1), ("[section]", "[section", 2), ("gain = 10 ", "gain = 90 ", 1)],
)
def test_dropped_job_that_is_wrong_is_refused_in_the_command_s_sentence(
    browser, tmp_path, monkeypatch, capsys, old, new, code
):
    monkeypatch.setattr(planner, "HERE", tmp_path)
    broken = REFERENCE.read_text().replace(old, new)
    assert planner.cut(broken, "broken.toml")[0] == code
    told = capsys.readouterr().err.replace(str(tmp_path), "/planned").splitlines()
    open_page(browser, "planner.html")
    drop(browser, "broken.toml", broken)
    plan(browser)
    shown = browser.run(f"[...{ANSWER}.querySelectorAll('.said')].map((one) => one.textContent)")
    assert shown == [line for line in told if line.startswith(("wrong: ", "refused: "))] != []
    assert browser.run(f"{ANSWER}.querySelector('a[download]') === null")


def drop(browser, name, text):
    """Drop a file on the page, as a hand that pulls it over does."""
    left = browser.run(
        "(() => { const dataTransfer = new DataTransfer();"
        f"dataTransfer.items.add(new File([{json.dumps(text)}], {json.dumps(name)}));"
        "const about = { dataTransfer, bubbles: true, cancelable: true };"
        "return ['dragover', 'drop'].map((kind) =>"
        "document.getElementById('form').dispatchEvent(new DragEvent(kind, about))); })()"
    )
    assert left == [False, False], "the browser itself would open the file"
    browser.until(f"document.getElementById('name').textContent === {json.dumps(name)}")


def fetched(browser, name, folder):
    """Return what the browser saves when a file's link is followed."""
    browser.save_in(folder)
    link = f"document.querySelector('a[download=\"{name}\"]')"
    browser.run(f"{link}.scrollIntoView({{ block: 'center' }})")
    browser.drag(link, 0, 0)  # by hand: of clicks by script some are held back after the tenth
    wait(lambda: (folder / name).exists(), said=name)
    return (folder / name).read_bytes()


NUMBER = re.compile(rb"-?\d+\.\d+(?:e[-+]\d+)?")


def same(one, other, least):
    """Tell whether two texts agree, numbers with a point to 1e-9 of themselves or to `least`."""
    numbers = [[float(n) for n in NUMBER.findall(text)] for text in (one, other)]
    near = all(abs(a - b) <= 1e-9 * abs(a) + least for a, b in zip(*numbers, strict=True))
    return near and NUMBER.sub(b"0", one) == NUMBER.sub(b"0", other)


def test_form_writes_what_was_left_out_and_leaves_the_words(browser):
    open_page(browser, "planner.html")
    write(browser, "machine.R", "800")
    write(browser, "pose.z", "2e-3")
    job = job_of(browser)
    assert "\nR = 800              # m, tangential" in job
    assert "\n[pose] " in job and "\nz = 2e-3 " in job and "\n# y = 1e-3 " in job


def job_of(browser):
    return browser.run("document.getElementById('job').value")


def show_job(browser, text):
    """Write a job into the page's text as a person does."""
    browser.run(
        f"(() => {{ const job = document.getElementById('job'); job.value = {json.dumps(text)};"
        "job.dispatchEvent(new Event('input')); })()"
    )


def value_of(browser, name):
    return browser.run(f"document.querySelector('[name=\"{name}\"]').value")


def test_form_s_fields_have_the_words_of_their_own_lines(browser):
    open_page(browser, "planner.html")
    shown = browser.run(
        "[...document.querySelectorAll('#form label')].map((one) => [one.control.name,"
        "...['span', 'i', 'small'].map((part) => one.querySelector(part).textContent)])"
    )
    words = said()
    assert [tuple(name.split(".")) for name, *_ in shown] == list(words)
    for full, name, unit, text in shown:
        table, key = full.split(".")
        assert ", ".join(filter(None, (unit, text))) == words[table, key], full
        spelt = key.removesuffix("_deg").replace("theta", "θ").replace("phi", "φ")
        assert name == spelt.replace("_", " ")
    units = {full: unit for full, _, unit, _ in shown}
    names = "machine.r", "ground.ripple", "section.shape"
    assert [units[name] for name in names] == ["m", "", ""]


SKETCH = "document.getElementById('sketch')"


def test_drawing_follows_the_form_and_lights_up_a_field_s_letter(browser):
    open_page(browser, "planner.html")
    names = f"[...{SKETCH}.querySelectorAll('text')].map((one) => one.dataset.name)"
    for name in browser.run(names):
        table = "" if "." in name else "machine."
        there = f'document.querySelector(\'[name="{table}{name}"], [name="{table}{name}_deg"]\')'
        browser.run(f"{there}.focus()")
        assert browser.run(f"{SKETCH}.querySelector('.here').dataset.name") == name
    ball = f"{SKETCH}.querySelector('.ball').r.baseVal.value"
    wall = f"[...{SKETCH}.querySelectorAll('path.wall')].pop().getAttribute('d')"
    egg = browser.run(wall)
    assert browser.run(ball) == pytest.approx(0.2)
    write(browser, "machine.cutter_radius", "0.15")
    write(browser, "section.shape", "circle")
    write(browser, "section.radius", "0.6")
    assert browser.run(ball) == pytest.approx(0.15) and browser.run(wall) != egg
    for wrong in ("", "-1", "none"):
        write(browser, "machine.R", wrong)
        assert browser.run(f"{SKETCH}.childElementCount") == 0
    write(browser, "machine.R", "0.8")
    assert browser.run(f"{SKETCH}.childElementCount") == 3 and browser.errors == []


def test_form_finds_the_values_of_a_job_in_another_form(browser):
    open_page(browser, "planner.html")
    show_job(browser, "\n".join([
        "[machine]", "  R=0.9# long", "theta_min = -1.0", "[section]", "shape = 'pieces'",
        "[[section.pieces]]", "kind = \"arc\"", "radius = 0.7", "# [body]", "# low = -0.3",
        "[pose]", "# y = 3e-3",
    ]))  # fmt: skip
    fields = ["machine.R", "machine.theta_min_deg", "section.shape", "section.radius", "body.low",
              "pose.y"]  # fmt: skip
    assert [value_of(browser, name) for name in fields] == ["0.9", "-1.0", "pieces", "", "", ""]
    told = "document.querySelector('[name=\"machine.theta_min_deg\"]').parentElement.textContent"
    assert browser.run(told).startswith("θ minradof ")
    shut = "[...document.querySelectorAll('#form fieldset:has(details:not([open])) legend')]"
    assert browser.run(f"{shut}.map((one) => one.textContent)") == ["body", "stance", "hydraulics"]


def test_form_writes_where_a_line_counts(browser):
    open_page(browser, "planner.html")
    show_job(browser, "[limits]\nfeed = 0.1\n\n[pose]\n# y = 3e-3\n")
    for name, value in (("limits.feed", "0.2"), ("limits.power", "3e3"), ("pose.y", "1e-3"),
                        ("machine.R", "0.9"), ("pose.z", "4"), ("limits.feed", "")):  # fmt: skip
        write(browser, name, value)
    assert job_of(browser).split("\n") == [
        "[limits]", "# feed = 0.2", "power = 3e3", "", "[pose]", "y = 1e-3", "z = 4", "",
        "[machine]", "R = 0.9", "",
    ]  # fmt: skip
    assert tomllib.loads(job_of(browser))["pose"] == {"y": 1e-3, "z": 4}


def test_field_s_example_has_the_unit_of_its_line(browser):
    open_page(browser, "planner.html")
    show_job(browser, "[machine]\n# theta_min = -1.0\n# phi_max_deg = 40\n[plan]\n# count = 1e-4\n")
    examples = [
        browser.run(f"document.querySelector('[name=\"{name}\"]').placeholder")
        for name in ("machine.theta_min_deg", "machine.phi_max_deg", "plan.count_deg")
    ]
    assert examples == ["e.g. -1.05", "e.g. 40", "e.g. 0.0000959"]


def test_form_takes_away_a_table_that_it_has_made(browser):
    open_page(browser, "planner.html")
    before = tomllib.loads(job_of(browser))
    for table, names in {"pose": ("y", "z"), "body": ("length", "width")}.items():
        for name in names:
            write(browser, f"{table}.{name}", "1e-3")
        assert set(tomllib.loads(job_of(browser))[table]) == set(names)
        for name in names:
            write(browser, f"{table}.{name}", "")
        assert tomllib.loads(job_of(browser)) == before
        write(browser, f"{table}.{names[0]}", "2e-3")
        assert tomllib.loads(job_of(browser))[table] == {names[0]: 2e-3}
        write(browser, f"{table}.{names[0]}", "")
    show_job(browser, "[limits]\nfeed = 0.1\nothers = [\n  1,\n]\n")
    write(browser, "limits.feed", "")
    assert tomllib.loads(job_of(browser)) == {"limits": {"others": [1]}}


def test_every_field_of_the_form_reaches_the_job(browser):
    open_page(browser, "planner.html")
    for table, name in said():
        write(browser, f"{table}.{name}", "7")
    sevens = {"shape": "7", "path": "7", "plant": "7"}
    assert tomllib.loads(job_of(browser)) == {
        table: {name: sevens.get(name, 7) for within, name in said() if within == table}
        for table, _ in said()
    }


def test_calculator_gives_the_library_s_digits(browser):
    open_page(browser, "geodesic.html")
    browser.run("document.getElementById('asked').requestSubmit()")
    browser.until(f"!!{ANSWER}.querySelector('table')", 120)
    asked = {"r": 0.08, "R": 0.8, "theta": 0, "phi": -30, "theta2": 60, "phi2": 35}
    shown = browser.run(f"{ANSWER}.textContent")
    numbers, paths = planner.geodesic_of(asked)
    for name, value in numbers.items():
        assert name in shown and value[:14] in shown
    drawn = browser.run(f"[...{ANSWER}.querySelectorAll('svg path')].length")
    assert drawn == 2 * len(paths) == 6  # each with its line beside its name
    assert browser.errors == [] and browser.outside == []
