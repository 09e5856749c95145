"""The index: every chapter in a part, every number a recorded one."""

import json
import re
import tomllib
from functools import cache
from html import unescape

import pytest

from kit import Show, ending
from kit.chapters import course_table, filled, machine_map, printed, read_chapters, worth
from report.site.proofs import proofs
from report.sources import INDEX, ROOT, notebooks

READS = ["notebooks/*", "report/numbers/*", "report/ledger/*", "tests/test_*.py"]

FOLDER = ROOT / "notebooks"
CONTENTS = tomllib.loads((FOLDER / "contents.toml").read_text())
CHAPTERS = [n for n in notebooks() if n.stem != INDEX]
proofs = cache(proofs)


def test_every_chapter_is_in_one_part():
    for notebook in CHAPTERS:
        parts = [p["name"] for p in CONTENTS["part"]
                 if p["chapters"][0] <= int(notebook.stem[:2]) <= p["chapters"][1]]  # fmt: skip
        assert len(parts) == 1, notebook.stem


def test_findings_are_of_chapters_and_hold_no_typed_result():
    assert CONTENTS["found"].keys() == {n.stem for n in CHAPTERS}
    for stem, sentence in CONTENTS["found"].items():
        left = re.sub(r"\{[^}]*\}|\bEq\. \d+", "", sentence)
        assert not re.search(r"\d", left), stem


def test_chapters_ask_and_answer():
    found = read_chapters()
    assert [c.file for c in found] == [n.name for n in CHAPTERS]
    for chapter in found:
        assert chapter.question.endswith("?") and chapter.found.endswith("."), chapter.file
        assert "{" not in chapter.found
        assert "|" not in chapter.question + chapter.found + chapter.needs


def test_ending_tells_the_finding_and_the_ways_on(monkeypatch):
    monkeypatch.setenv("TUNNELLER_RESULTS", str(ROOT))  # only to read
    text = ending(Show("08_cone")).data
    assert filled("08_cone", CONTENTS["found"]["08_cone"]) in text
    assert re.findall(r"\]\((\w+)\.ipynb\)", text) == ["00_index", "07_chord", "09_geodesic"]
    own = ending(Show("08_cone"), "It is {excess} longer.").data
    assert re.match(r"It is [\d.]+\S* \S+ longer\.\n", own) or "{" not in own
    first, last = (ending(Show(CHAPTERS[i].stem)).data for i in (0, -1))
    assert first.count(".ipynb)") == last.count(".ipynb)") == 2


def content(notebook):
    return json.loads(notebook.read_text())["cells"]


@pytest.mark.parametrize("notebook", notebooks(), ids=lambda n: n.stem)
def test_links_of_a_chapter_lead_somewhere(notebook):
    text = "\n".join("".join(cell["source"]) for cell in content(notebook))
    for file, _, function in re.findall(r"\]\(\.\./(tests/\w+\.py)(#(\w+))?\)", text):
        assert ROOT / file in proofs(), f"{file} has no page on the site"
        assert f"def {function}(" in (ROOT / file).read_text(), function
    for file in re.findall(r"\]\((\w+\.ipynb)\)", text):
        assert (FOLDER / file).exists(), file


@pytest.mark.parametrize("notebook", notebooks(), ids=lambda n: n.stem)
def test_every_picture_of_a_chapter_has_a_text_for_those_who_do_not_see_it(notebook):
    for cell in content(notebook):
        for output in cell.get("outputs", []):
            if "image/png" in output.get("data", {}):
                assert output["metadata"]["image/png"]["alt"], "give figure or sliders an alt text"


def test_courses_lead_through_chapters_in_hours():
    text = course_table().data
    every = {chapter.number: chapter for chapter in read_chapters()}
    assert [len(course["chapters"]) for course in CONTENTS["course"]] == [3, 6, 12]
    for course, line in zip(CONTENTS["course"], text.split("\n")[2:], strict=True):
        assert all(every[number].link in line for number in course["chapters"])
        minutes = sum(every[number].minutes for number in course["chapters"])
        assert f"| {minutes / 60:.1f} |" in line


def test_machine_leads_to_chapters_at_its_parts():
    text = machine_map().data
    links = re.findall(r'<a href="(\w+\.ipynb)" title="([^"]+)"', text)
    assert len(links) == len(CONTENTS["machine"]["places"])
    asked = {chapter.file: chapter.question for chapter in read_chapters()}
    assert all(unescape(title) == asked[file] for file, title in links)
    assert (ROOT / "figures" / re.search(r'src="\.\./figures/([\w.]+)"', text)[1]).exists()


def test_worth_on_the_wall_is_a_number_of_the_budget():
    assert re.fullmatch(r"\*\*What it is worth on the wall\.\*\* [\d.]+\smm\.",
                        worth("{projected chord}.").data)  # fmt: skip


@pytest.mark.parametrize(
    ("text", "unit", "shown"),
    [("5.6e-4", "", "5.6 · 10⁻⁴"), ("12345", "", "12\u202f345"), ("1234", "", "1234"),
     ("0.1021", "%", "0.1021\u202f%"), ("-12345.5", "m^-1", "−12\u202f345.5\u202fm⁻¹")],
)  # fmt: skip
def test_printed_is_set_as_in_the_report(text, unit, shown):
    assert printed(text, unit) == shown
