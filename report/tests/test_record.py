"""Records: what is printed, what is stored, what is refused."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kit import Show, figure
from kit.record import drawing_svg
from report.sources import ROOT, cells

READS = ["notebooks/03_tunnel.ipynb"]


@pytest.fixture
def root(tmp_path, monkeypatch):
    monkeypatch.setenv("TUNNELLER_RESULTS", str(tmp_path))
    return tmp_path


@pytest.fixture
def show(root):
    return Show("01_test")


def stored(root):
    return json.loads((root / "report" / "numbers" / "01_test.json").read_text())


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1.0987, 3, "1.10"),
        (-1.0987, 2, "-1.1"),
        (12.34, 2, "12"),
        (99.96, 3, "100"),
        (1234.5, 2, "1.2e3"),
        (0.001234, 2, "0.0012"),
        (5.6e-4, 2, "5.6e-4"),
        (9.996e-4, 3, "0.00100"),
        (2.5e12, 1, "2e12"),
        (0.0, 2, "0.0"),
        (-0.0, 1, "0"),
        (3, None, "3"),
        (np.int64(123456), None, "123456"),
        (np.float64(0.5), 1, "0.5"),
        (np.array(0.5), 1, "0.5"),
    ],
)
def test_number_is_printed_with_its_digits(show, root, capsys, value, digits, text):
    show("it", value, "m", digits=digits)
    assert capsys.readouterr().out == f"it: {text} m\n"
    assert stored(root)["numbers"]["it"]["text"] == text


@pytest.mark.parametrize(
    ("value", "options", "message"),
    [
        (float("nan"), {"digits": 3}, "it: must be one finite number; got nan."),
        (float("inf"), {"digits": 3}, "it: must be one finite number; got inf."),
        (True, {}, "it: must be one finite number; got True."),
        ("1", {"digits": 3}, "it: must be one finite number; got '1'."),
        (np.ones(2), {"digits": 3}, "it: must be one finite number"),
        (1.5, {}, "it: digits must say how many of 1.5 are meant."),
        (1.5, {"digits": 0}, "it: digits must be an integer from 1 to 12; got 0."),
        (1.5, {"digits": 13}, "it: digits must be an integer from 1 to 12; got 13."),
        (1.5, {"digits": 2.0}, "it: digits must be an integer from 1 to 12; got 2.0."),
        (1.5, {"digits": 3, "below": 2.0}, "it: give digits or below, not both."),
        (2e-9, {"below": 1e-9}, "it: must lie between 0 and 1e-09; got 2e-09."),
        (-1e-12, {"below": 1e-9}, "it: must lie between 0"),
        (float("nan"), {"below": 1e-9}, "it: must be one finite number; got nan."),
    ],
)
def test_number_is_refused(show, root, capsys, value, options, message):
    with pytest.raises(ValueError, match=message.replace(".", r"\.")):
        show("it", value, "m", **options)
    assert not (root / "report").exists() and capsys.readouterr().out == ""


def test_name_of_two_lines_is_refused_and_nothing_shown(show, root, capsys):
    with pytest.raises(ValueError, match=r"^name: must be of one line; got 'a\\nb'\.$"):
        show("a\nb", 1, "m")
    assert not (root / "report").exists() and capsys.readouterr().out == ""


def test_bound_is_stored_and_not_the_value(show, root, capsys):
    for residual in (3e-14, 0.0, 1e-12):
        show("residual", residual, "", below=1e-12)
        assert capsys.readouterr().out == "residual: at most 1e-12\n"
    assert stored(root)["numbers"]["residual"] == {"bound": 1e-12, "text": "1e-12", "unit": ""}


@pytest.mark.parametrize(
    ("first", "second", "order"),
    [(1, 2, "less"), (2.0, np.float64(1.999), "greater"), (-1, 0, "less"), (0.0, -1e-9, "greater")],
)
def test_order_is_stored_as_a_word(show, root, capsys, first, second, order):
    show.order("one against the other", first, second)
    assert capsys.readouterr().out == f"one against the other: {order}\n"
    assert stored(root)["orders"] == {"one against the other": {"order": order}}


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (float("nan"), 1.0, "first of it: must be one finite number; got nan."),
        (1.0, float("inf"), "second of it: must be one finite number; got inf."),
        ("1", 2.0, "first of it: must be one finite number; got '1'."),
        (1.0, 1.0000001, "it: must differ by 1e-06 of either; got 1.0, 1.0000001."),
        (0, 0, "it: must differ by 1e-06 of either; got 0, 0."),
    ],
)
def test_order_is_refused(show, root, capsys, first, second, message):
    with pytest.raises(ValueError, match=message.replace(".", r"\.")):
        show.order("it", first, second)
    assert not (root / "report").exists() and capsys.readouterr().out == ""


def test_last_bits_are_not_stored(show, root):
    show("sum", 0.1 + 0.2, "", digits=2)
    assert stored(root)["numbers"]["sum"]["value"] == 0.3
    show("third", 1 / 3, "", digits=2)
    assert stored(root)["numbers"]["third"]["value"] == 0.33333
    show("large", 1e7 / 3, "", digits=2)
    assert stored(root)["numbers"]["large"]["value"] == 3333300.0
    show.table("t", ["x"], [[2 / 3], [-1e-9]], decimals=[1])
    assert stored(root)["tables"]["t"]["rows"] == [[0.6667], [0.0]]


def test_table_is_printed_with_its_decimals(show, root):
    rows = [["a", 1, 0.02024, -0.0001], ["b", 2, 1.0, 0.0]]
    show.table("t", ["name", "n", "x / m", "y / m"], rows, decimals=[None, None, 4, 2])
    printed = [["a", "1", "0.0202", "0.00"], ["b", "2", "1.0000", "0.00"]]
    assert stored(root)["tables"]["t"]["text"] == printed
    assert stored(root)["tables"]["t"]["rows"] == rows


def test_table_is_shown_below_its_headings(show, monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    columns = ["path", "$R\\/r$", "$nu_4 <= 10^(-9)$", "area / m#super[2]"]
    show.table("t", columns, [["$|bold(m)|$", "*-2*", "$x - y$", 3]])
    assert shown[0]._repr_markdown_().split("\n") == [
        "| path | R/r | ν_4 ≤ 10⁻⁹ | area / m² |",
        "|-|-|-|-|",
        r"| \|m\| | *-2* | x − y | 3 |",
    ]


@pytest.mark.parametrize(
    ("rows", "decimals", "message"),
    [
        ([[1.0]], None, "decimals must say"),
        ([[1.0, 2.0]], [1], "argument 2 is longer"),
        ([[1.0]], [1, 1], "argument 3 is longer"),
        ([[float("nan")]], [1], "must be one finite number"),
        ([[None]], [1], "must be one finite number"),
    ],
)
def test_table_is_refused(show, rows, decimals, message):
    with pytest.raises(ValueError, match=message):
        show.table("t", ["x"], rows, decimals=decimals)


def full_of_names(push=0.0):
    """Return a drawing with a clip, markers, a hatch and a cloud, its axes pushed by so much."""
    drawing, axes = figure(1, 2, height=4)
    drawing.set_layout_engine("none")
    for number, ax in enumerate(axes):
        ax.set_position([0.1 + 0.45 * number + push, 0.1, 0.4, 0.8])
        ax.plot([0, 1 / 3], [0, 1 / 7], "o")
        ax.fill_between([0, 1], [1, 0], hatch="/")
        ax.scatter([0.2, 0.4], [0.3, 0.1], rasterized=number == 0)
    return drawing


def test_drawing_has_the_same_bytes_wherever_its_axes_last_bits_fall():
    # The layout's solver adds in the order of memory, so that these differ from run to run.
    whole = drawing_svg(full_of_names())
    assert all(drawing_svg(full_of_names(push)) == whole for push in (1e-15, 3e-15, 1e-14))
    assert drawing_svg(full_of_names(1e-3)) != whole


def test_names_in_a_drawing_are_one_each_and_those_that_are_asked_for():
    text = drawing_svg(full_of_names()).decode()
    names = re.findall(r' id="([^"]+)"', text)
    assert len(set(names)) == len(names)
    asked = set(re.findall(r'(?:url\(|href=")#([^")]+)', text))
    assert asked < set(names)
    for kind in ("p-", "m-", "h-"):
        assert any(name.startswith(kind) for name in asked)


LAID_OUT = """
import sys
import numpy as np
from tunneller_lib.paths import ConeChord
from kit import figure
from exhibits.cone_plot import draw_cone, draw_development
from kit.record import drawing_svg

filled = [bytearray(size) for size in range(int(sys.argv[1]))]
drawing, (one, other, third) = figure(1, 3, height=6.5)
chord = ConeChord(R=1.0, H=1.0, h=0.5, f=0.25)
draw_cone(one, chord, np.linspace(0, 1, 11))
draw_development(other, chord, np.linspace(0, 1, 11))
third.plot([0, 1], [0, 1 / 3], label="a line")
third.set(xlabel="u", ylabel="deviation / mm")
third.legend()
sys.stdout.buffer.write(drawing_svg(drawing))
"""


def test_drawing_has_the_same_bytes_in_two_processes_whose_memory_differs():
    contents = [
        subprocess.run([sys.executable, "-c", LAID_OUT, filled], capture_output=True, check=True,
                       cwd=Path(__file__).parents[2], env=os.environ | {"PYTHONHASHSEED": seed})
        for filled, seed in (("0", "1"), ("3000", "2"))
    ]  # fmt: skip
    assert len(contents[0].stdout) > 10_000 and contents[0].stdout == contents[1].stdout


def test_figure_is_shown_with_its_alternative_text_on_one_line(show, root, monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    show.figure(figure(height=4)[0], "line", "A line\n and no more.")
    assert stored(root)["figures"]["line"] == {"file": "line.svg", "alt": "A line and no more."}
    assert shown[0].alt == "A line and no more."


def test_figure_needs_an_alternative_text(show):
    with pytest.raises(ValueError, match=r"line: needs an alternative text\."):
        show.figure(figure(height=4)[0], "line", " ")


def test_figure_that_is_recorded_again_is_laid_out_again(show):
    drawing, ax = figure(height=4)
    show.figure(drawing, "line", "A line.")
    begin = ax.get_position().x0
    ax.set_ylabel("a label\nof lines")
    show.figure(drawing, "line", "A line.")
    assert ax.get_position().x0 > begin + 0.05


@pytest.mark.parametrize("name", ["", "../up", "Two words", ".hidden"])
def test_file_name_is_refused(show, name):
    with pytest.raises(ValueError, match=r"^name: must have only a-z, 0-9, - and _; got"):
        Show(name)
    with pytest.raises(ValueError, match=r"^name: must have only a-z, 0-9, - and _; got"):
        show.figure(figure(height=4)[0], name, "A line.")


def test_chapter_that_is_run_by_hand_changes_nothing_but_the_folder_build():
    def files():
        folders = [ROOT / name for name in ("figures", "notebooks", "report")]
        found = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
        return {path: path.stat().st_mtime_ns for path in found if path.suffix != ".pyc"}

    before = files()
    script = "\n".join(code for kind, code in cells(ROOT / "notebooks" / "03_tunnel.ipynb")
                       if kind == "code")  # fmt: skip
    environment = {name: value for name, value in os.environ.items() if name != "TUNNELLER_RESULTS"}
    environment |= {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'notebooks'}", "MPLBACKEND": "agg"}
    written = ROOT / "build" / "lab" / "report" / "numbers" / "03_tunnel.json"
    written.unlink(missing_ok=True)
    subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT / "notebooks", env=environment, check=True,
        capture_output=True,
    )  # fmt: skip
    assert written.exists() and files() == before
