"""The index: every chapter in a part, every number a recorded one."""

import json
import re
import tomllib

import pytest

from report.sources import INDEX, ROOT, notebooks
from tunneller_lib.reporting import Record, contents_table, draw_map, ending, figure
from tunneller_lib.reporting.chapters import filled, printed, read_chapters

READS = ["notebooks/*", "report/numbers/*"]

FOLDER = ROOT / "notebooks"
CONTENTS = tomllib.loads((FOLDER / "contents.toml").read_text())
CHAPTERS = [n for n in notebooks() if n.stem != INDEX]


def test_every_chapter_is_in_one_part():
    for notebook in CHAPTERS:
        parts = [p["name"] for p in CONTENTS["part"]
                 if p["chapters"][0] <= int(notebook.stem[:2]) <= p["chapters"][1]]  # fmt: skip
        assert len(parts) == 1, notebook.stem


def test_parts_follow_parts_that_there_are():
    names = {part["name"] for part in CONTENTS["part"]}
    assert {other for part in CONTENTS["part"] for other in part["follows"]} <= names


def test_findings_are_of_chapters_and_hold_no_typed_result():
    assert CONTENTS["found"].keys() == {n.stem for n in CHAPTERS}
    for stem, sentence in CONTENTS["found"].items():
        left = re.sub(r"\{[^}]*\}|\bEq\. \d+", "", sentence)
        assert not re.search(r"\d", left), stem


def test_chapters_ask_and_answer():
    found = read_chapters(FOLDER)
    assert [c.file for c in found] == [n.name for n in CHAPTERS]
    for chapter in found:
        assert chapter.question.endswith("?") and chapter.found.endswith("."), chapter.file
        assert "{" not in chapter.found and "|" not in chapter.question + chapter.found


def test_contents_table_links_every_chapter():
    text = contents_table(FOLDER).data
    assert all(f"]({n.name})" in text for n in CHAPTERS)


def test_ending_tells_the_finding_and_the_ways_on(monkeypatch):
    monkeypatch.delenv("TUNNELLER_RESULTS")  # only to read
    text = ending(Record("08_cone")).data
    assert read_chapters(FOLDER)[7].found in text
    assert re.findall(r"\]\((\w+)\.ipynb\)", text) == ["00_index", "07_chord", "09_geodesic"]
    first, last = (ending(Record(CHAPTERS[i].stem)).data for i in (0, -1))
    assert first.count(".ipynb)") == last.count(".ipynb)") == 2


@pytest.mark.parametrize("notebook", CHAPTERS, ids=lambda n: n.stem)
def test_every_chapter_keeps_the_same_order(notebook):
    cells = json.loads(notebook.read_text())["cells"]
    texts = ["".join(cell["source"]) for cell in cells]
    assert texts[0].index("**You will see**") < texts[0].index("**You need**")
    assert [cell["cell_type"] for cell in cells[1:3]] == ["code", "code"]  # imports, sizes
    titles = [text.split("\n")[0] for text in texts if text.startswith("## ")]
    assert titles[-2:] == ["## Numbers for the report", "## What came out"]
    assert "## Checks" not in titles[:-3]
    assert texts[-1] == "ending(record)"


def test_draw_map_draws_parts_with_chapters():
    _, ax = figure(height=5)
    numbers = [int(n.stem[:2]) for n in CHAPTERS]
    filled_parts = [p for p in CONTENTS["part"]
                    if any(p["chapters"][0] <= k <= p["chapters"][1] for k in numbers)]  # fmt: skip
    assert len(draw_map(ax, FOLDER)) == len(filled_parts)


def test_index_refuses_what_is_no_folder():
    _, ax = figure(height=2)
    for call in (lambda: draw_map(ax, "here"), lambda: contents_table("here")):
        with pytest.raises(ValueError, match=r"^folder: must be of class Path; got 'here'\.$"):
            call()


def test_filled_refuses_what_is_not_recorded():
    with pytest.raises(ValueError, match=r"^07_chord: records no number 'no such'\.$"):
        filled("07_chord", "It is {no such}.")
    assert "at most 0.0001" in filled("07_chord", "{worst ratio, arc}.")


@pytest.mark.parametrize(
    ("text", "unit", "shown"),
    [("5.6e-4", "", "5.6 · 10⁻⁴"), ("12345", "", "12\u202f345"), ("1234", "", "1234"),
     ("0.1021", "%", "0.1021\u202f%"), ("-12345.5", "m^-1", "−12\u202f345.5\u202fm⁻¹")],
)  # fmt: skip
def test_printed_is_set_as_in_the_report(text, unit, shown):
    assert printed(text, unit) == shown
