"""The comparison of notebooks catches what is planted, and lets last bits pass."""

import re
import shutil
import subprocess
import sys
from collections import Counter

import matplotlib
import nbformat
import numpy as np
import PIL.Image
import PIL.ImageDraw
import PIL.ImageFont
import pytest
from matplotlib import font_manager
from nbformat.v4 import new_code_cell, new_notebook

from kit import COLOURS, figure
from report.compare import Text, difference, picture_difference
from report.execute import run_notebook
from report.sources import ROOT, notebook_sources

READS = ["figures/circuit_tunnel.png"]

pytestmark = pytest.mark.usefixtures("shared_kernels")

SOURCES = [
    "from kit import Record\nrecord = Record('01_test')",
    "record('it', 1.25, 'm', digits=3)",
    "from kit.style import figure\n"
    "drawing, ax = figure(height=4)\nrecord.figure(drawing, 'axes', 'Empty axes.')",
    "print(0.5)",
]


@pytest.mark.parametrize(
    ("a", "b", "equal"),
    [
        ("x = 1.0000000000001 m", "x = 1.0 m", True),
        ("x = 1.00001 m", "x = 1.0 m", False),
        ("1e-7", "1.0e-07", True),
        ("3 m", "4 m", False),
        ("1.0 m", "1.0 mm", False),
        ("1.0, 2.0", "1.0", False),
        ("-1.5", "1.5", False),
    ],
)
def test_text_is_compared_up_to_last_bits(a, b, equal):
    assert (Text(a) == Text(b)) is equal
    assert (Text(a) != Text(b)) is not equal


@pytest.mark.parametrize(
    ("old", "new", "equal"),
    [
        ({"a": 1.0}, {"a": 1.0 + 1e-12}, True),
        ({"a": 1.0}, {"a": 1.0 + 1e-6}, False),
        ({"a": 1}, {"a": 2}, False),
        ({"a": "m"}, {"a": "mm"}, False),
        ({"a": 1}, {"b": 1}, False),
        ({"a": 1}, {}, False),
        ([1.0, "x"], [1.0, "x"], True),
        ([1.0], [1.0, 2.0], False),
        ([1.0], 1.0, False),
        ({"value": 1.2346, "digits": 2}, {"value": 1.2347, "digits": 2}, True),
        ({"value": 1.2346, "digits": 2}, {"value": 1.2348, "digits": 2}, False),
        ({"value": 1.2346, "digits": None}, {"value": 1.2347, "digits": None}, False),
        ({"rows": [[1.2346]], "text": [["1.2"]]}, {"rows": [[1.2347]], "text": [["1.2"]]}, True),
        ({"rows": [[1.2346]], "text": [["1.2"]]}, {"rows": [[1.2349]], "text": [["1.2"]]}, False),
        ({"rows": [[1.2346]], "text": [["1.2"]]}, {"rows": [[1.2346]], "text": [["1.3"]]}, False),
    ],
)
def test_records_are_compared(old, new, equal):
    assert (difference(old, new) is None) is equal


@pytest.mark.parametrize(("changed", "equal"), [(0, True), (1, True), (40, True), (400, False)])
def test_pictures_are_compared(tmp_path, changed, equal):
    pixels = np.full((100, 100, 3), 255, np.uint8)
    (tmp_path / "new").mkdir()
    PIL.Image.fromarray(pixels).save(tmp_path / "a.png")
    pixels.reshape(-1, 3)[:changed] = 180
    PIL.Image.fromarray(pixels).save(tmp_path / "new" / "a.png")
    same = picture_difference(tmp_path / "a.png", tmp_path / "new" / "a.png")
    assert (same is None) is equal


@pytest.mark.parametrize(
    ("edge", "height", "equal"),
    [(51, 100, True), (50, 101, True), (53, 100, False), (50, 103, False)],
)
def test_edges_of_a_scene_may_lie_a_pixel_aside(tmp_path, edge, height, equal):
    (tmp_path / "new").mkdir()
    for name, begin, size in (("a.png", 50, 100), ("new/a.png", edge, height)):
        pixels = np.full((size, 100, 3), 255, np.uint8)
        pixels[:, begin:] = 60
        PIL.Image.fromarray(pixels).save(tmp_path / name)
    same = picture_difference(tmp_path / "a.png", tmp_path / "new" / "a.png")
    assert (same is None) is equal


@pytest.mark.parametrize(("letters", "equal"), [("", True), (".", True), ("P", False)])
def test_letter_in_a_scene_is_noticed(tmp_path, letters, equal):
    """A P of 8 points at 300 dpi: of the scene's pixels it changes a part in two thousand."""
    (tmp_path / "new").mkdir()
    scene = PIL.Image.open(ROOT / "figures" / "circuit_tunnel.png").convert("RGB")
    scene.save(tmp_path / "a.png")
    font = PIL.ImageFont.truetype(font_manager.findfont("DejaVu Sans"), 33)
    PIL.ImageDraw.Draw(scene).text((300, 300), letters, fill=(30, 30, 30), font=font)
    scene.save(tmp_path / "new" / "a.png")
    same = picture_difference(tmp_path / "a.png", tmp_path / "new" / "a.png")
    assert (same is None) is equal
    assert equal or "about pixel (3" in same


def test_scattered_pixels_of_a_scene_may_differ(tmp_path):
    """As many as another version of the GL library changes, strewn over lines and seams."""
    (tmp_path / "new").mkdir()
    scene = PIL.Image.open(ROOT / "figures" / "circuit_tunnel.png").convert("RGB")
    scene.save(tmp_path / "a.png")
    pixels = np.array(scene)
    rng = np.random.default_rng(7)
    rows, columns = rng.integers(0, pixels.shape[:2], (150, 2)).T
    for step in range(4):  # short strokes, two pixels wide
        for wide in range(2):
            place = (rows + wide) % len(pixels), (columns + step) % pixels.shape[1]
            pixels[place] = 255 - pixels[place]
    PIL.Image.fromarray(pixels).save(tmp_path / "new" / "a.png")
    assert picture_difference(tmp_path / "a.png", tmp_path / "new" / "a.png") is None


@pytest.mark.parametrize(
    ("options", "equal"),
    [({}, True), ({"xlabel": "x / m, 0.2"}, False), ({"colour": "tunnel"}, False),
     ({"to": 1 + 1e-5}, True), ({"to": 1.01}, False)],
)  # fmt: skip
def test_drawings_are_compared_as_the_eye_does(tmp_path, options, equal):
    def drawn(folder, xlabel="x / m, 0.1", colour="torus", to=1.0):
        drawing, ax = figure(height=5)
        ax.plot([0, to], [0, 1], color=COLOURS[colour])
        ax.set(xlabel=xlabel, xlim=(0, 1.1))
        (tmp_path / folder).mkdir()
        with matplotlib.rc_context({"svg.fonttype": "path"}):
            drawing.savefig(tmp_path / folder / "a.svg")
        return tmp_path / folder / "a.svg"

    same = picture_difference(drawn("old"), drawn("new", **options))
    assert (same is None) is equal


def test_missing_picture_is_told(tmp_path):
    assert picture_difference(tmp_path / "a.png", tmp_path / "b.png") == "a.png is not committed."


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def built(root):
    notebook = root / "notebooks" / "01_test.ipynb"
    run_notebook(notebook, notebook_sources(notebook))


def altered_since(root):
    built(root)
    edit(root / "figures" / "axes.svg", "M ", "M 9")


def planted(root):
    edit(root / "notebooks" / "01_test.ipynb", '"0.5\\n"', '"0.6\\n"')
    edit(root / "report" / "numbers" / "01_test.json", '"value": 1.25', '"value": 1.26')
    edit(root / "figures" / "axes.svg", "M ", "M 9")


def dead(root):
    edit(root / "notebooks" / "01_test.ipynb", "print(0.5)", "import os; os._exit(1)")


def unrun(root):
    edit(root / "notebooks" / "01_test.ipynb", '"execution_count": 4', '"execution_count": 5')


@pytest.fixture(scope="module")
def said(tmp_path_factory, shared_kernels):
    """Return what pytest says of a notebook that has been run, as it is and changed: by one run.

    A part for each name, with what passed and failed of it.
    """
    folder = tmp_path_factory.mktemp("checkouts")
    true = folder / "true" / "notebooks" / "01_test.ipynb"
    true.parent.mkdir(parents=True)
    cells = [new_code_cell(source, id=f"cell-{i}") for i, source in enumerate(SOURCES)]
    nbformat.write(new_notebook(cells=cells), true)
    run_notebook(true)
    shutil.rmtree(folder / "true" / "build")
    for change in (built, altered_since, planted, dead, unrun):
        shutil.copytree(folder / "true", folder / change.__name__)
        change(folder / change.__name__)
    command = [sys.executable, "-m", "pytest", "-p", "report.tests.notebook_results", "-q", "-rA"]
    options = ["-p", "no:cacheprovider", "--rootdir", folder, "-c", ROOT / "pyproject.toml"]
    run = subprocess.run(
        [*command, *options, folder], cwd=ROOT, capture_output=True, text=True, timeout=600
    )
    found = {path.name: Counter() for path in folder.iterdir()}
    for word, name in re.findall(r"^(PASSED|FAILED) .*?(\w+)/notebooks/", run.stdout, re.M):
        found[name][word] += 1
    return found, run.stdout


def test_true_notebook_passes(said):
    assert said[0]["true"] == {"PASSED": 7}


def test_notebook_that_a_build_has_run_is_not_run_again(said):
    assert said[0]["built"] == {"PASSED": 2}
    assert said[0]["altered_since"]["FAILED"] == 1


def test_planted_results_are_caught(said):
    found, output = said
    assert found["planted"] == {"PASSED": 4, "FAILED": 3}
    assert "numbers, it, value: 1.26 is committed, 1.25 came out now." in output
    assert "axes.svg differs from the committed figure" in output
    assert "Cell outputs differ" in output


def test_dead_kernel_and_unrun_notebook_are_told(said):
    found, output = said
    assert found["dead"]["FAILED"] >= 1 and "The kernel died" in output
    assert found["unrun"] == {"PASSED": 6, "FAILED": 1}
    assert "isn't stored as run from top to bottom" in output
