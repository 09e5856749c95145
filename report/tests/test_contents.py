"""The index: every chapter in a part, every number a recorded one."""

import base64
import io
import json
import re
import tomllib
from html import unescape
from itertools import chain

import PIL.Image
import pytest

from kit import Record, ending
from kit.chapters import (
    contents_table,
    course_table,
    filled,
    machine_map,
    printed,
    read_chapters,
    worth,
)
from report.site.proofs import proofs
from report.sources import INDEX, ROOT, notebooks, records

READS = ["notebooks/*", "report/numbers/*", "report/ledger/*", "tests/test_*.py"]

FOLDER = ROOT / "notebooks"
CONTENTS = tomllib.loads((FOLDER / "contents.toml").read_text())
CHAPTERS = [n for n in notebooks() if n.stem != INDEX]


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


def test_chapters_say_in_words_what_they_need():
    for chapter in read_chapters():
        assert not re.search(r"\b(Eqs?\.?|sections?) \d", chapter.needs), chapter.file


def test_whole_study_is_read_in_ten_hours():
    every = [chapter.minutes for chapter in read_chapters()]
    assert all(minutes >= 5 and minutes % 5 == 0 for minutes in every)
    assert sum(every) <= 600


def test_contents_table_links_every_chapter():
    text = contents_table().data
    assert all(f"]({n.name})" in text for n in CHAPTERS)


def test_ending_tells_the_finding_and_the_ways_on(monkeypatch):
    monkeypatch.setenv("TUNNELLER_RESULTS", str(ROOT))  # only to read
    text = ending(Record("08_cone")).data
    assert filled("08_cone", CONTENTS["found"]["08_cone"]) in text
    assert re.findall(r"\]\((\w+)\.ipynb\)", text) == ["00_index", "07_chord", "09_geodesic"]
    own = ending(Record("08_cone"), "It is {excess} longer.").data
    assert re.match(r"It is [\d.]+\S* \S+ longer\.\n", own) or "{" not in own
    first, last = (ending(Record(CHAPTERS[i].stem)).data for i in (0, -1))
    assert first.count(".ipynb)") == last.count(".ipynb)") == 2


def sources(notebook):
    """Return what its author wrote in each cell of a notebook."""
    return ["".join(cell["source"]) for cell in json.loads(notebook.read_text())["cells"]]


def titles(notebook):
    return re.findall(r"^## .*", "\n".join(sources(notebook)), re.M)


def outputs(notebook):
    """Return the data of every output, of each code cell a list."""
    cells = json.loads(notebook.read_text())["cells"]
    every = [cell["outputs"] for cell in cells if cell["cell_type"] == "code"]
    return [[o.get("data", {"text/plain": o.get("text")}) for o in cell] for cell in every]


NUMBERS = "## Numbers for the report"  # the block at the end of what is still a lab's record
STORIES = [n for n in CHAPTERS if NUMBERS not in titles(n)]
TAUGHT = [n for n in STORIES if int(n.stem[:2]) < 60]


@pytest.mark.parametrize("notebook", CHAPTERS, ids=lambda n: n.stem)
def test_every_chapter_begins_and_ends_alike(notebook):
    texts = sources(notebook)
    assert texts[0].index("**You will see**") < texts[0].index("**You need**")
    assert titles(notebook)[-1] == "## What came out"
    assert re.match(r"ending\(\s*record\b", texts[-1])


@pytest.mark.parametrize("notebook", STORIES, ids=lambda n: n.stem)
def test_story_begins_with_a_picture(notebook):
    first = next(filter(None, outputs(notebook)))
    assert any("image/png" in data for data in first)


@pytest.mark.parametrize("notebook", STORIES, ids=lambda n: n.stem)
def test_pictures_that_move_are_small(notebook):
    for data in chain(*outputs(notebook)):
        if "image/png" in data:
            content = base64.b64decode(data["image/png"])
            with PIL.Image.open(io.BytesIO(content)) as picture:
                still = getattr(picture, "n_frames", 1) == 1
            assert still or len(content) < 300_000


@pytest.mark.parametrize("notebook", TAUGHT, ids=lambda n: n.stem)
def test_story_has_questions_exercises_and_ways_on(notebook):
    parts = titles(notebook)
    assert parts[-4:] == ["## By hand", "## Two exercises", "## Where to read on",
                          "## What came out"]  # fmt: skip
    prose = "\n".join(sources(notebook))
    questions = prose[prose.index("## By hand") : prose.index("## Two exercises")]
    assert questions.count("<details>") >= 2
    assert len(re.findall(r"^def check_", prose, re.M)) == 2
    reading = prose[prose.index("## Where to read on") :]
    assert "](https://" in reading and "](../tests/" in reading


@pytest.mark.parametrize("notebook", STORIES, ids=lambda n: n.stem)
def test_story_shows_no_number_without_its_name(notebook):
    for data in chain(*outputs(notebook)):
        if "image/png" not in data and "text/markdown" not in data:
            for line in "".join(data.get("text/plain", "")).splitlines():
                assert not re.match(r"\W*(at most )?\d|\W*(less|greater)\b", line), line


@pytest.mark.parametrize("notebook", notebooks(), ids=lambda n: n.stem)
def test_pictures_have_words_without_the_code(notebook):
    """A page whose code is hidden has a caption below a recorded figure, prose above any other."""
    captioned = {figure["alt"] for figure in records(notebook)[1].get("figures", {}).values()}
    above = None
    for cell in json.loads(notebook.read_text())["cells"]:
        for output in cell.get("outputs", []):
            alt = " ".join(output.get("metadata", {}).get("image/png", {}).get("alt", "").split())
            if "image/png" in output.get("data", {}) and alt not in captioned:
                assert alt and above == "markdown", f"{alt}: {above}"
            above = output["output_type"]
        if cell["cell_type"] == "markdown":
            above = "markdown"


@pytest.mark.parametrize("notebook", STORIES, ids=lambda n: n.stem)
def test_links_of_a_story_lead_somewhere(notebook):
    text = "\n".join(sources(notebook))
    for file, _, function in re.findall(r"\]\(\.\./(tests/\w+\.py)(#(\w+))?\)", text):
        assert ROOT / file in proofs(), f"{file} has no page on the site"
        assert f"def {function}(" in (ROOT / file).read_text(), function
    for file in re.findall(r"\]\((\w+\.ipynb)\)", text):
        assert (FOLDER / file).exists(), file


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


def test_filled_refuses_what_is_not_recorded():
    with pytest.raises(KeyError, match="no such"):
        filled("07_chord", "It is {no such}.")
    assert "at most 0.0001" in filled("07_chord", "{worst ratio, arc}.")


@pytest.mark.parametrize(
    ("text", "unit", "shown"),
    [("5.6e-4", "", "5.6 · 10⁻⁴"), ("12345", "", "12\u202f345"), ("1234", "", "1234"),
     ("0.1021", "%", "0.1021\u202f%"), ("-12345.5", "m^-1", "−12\u202f345.5\u202fm⁻¹")],
)  # fmt: skip
def test_printed_is_set_as_in_the_report(text, unit, shown):
    assert printed(text, unit) == shown
