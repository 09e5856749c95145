"""The comparison of results notices what differs, and lets last bits and edges of pixels pass."""

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


@pytest.mark.parametrize(
    ("a", "b", "equal"),
    [
        ("x = 1.0000000000001 m", "x = 1.0 m", True),
        ("x = 1.00001 m", "x = 1.0 m", False),
        ("1e-7", "1.0e-07", True),
        ("3 m", "4 m", False),
        ("1.0 m", "1.0 mm", False),
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
        ([1.0], [1.0, 2.0], False),
        ({"value": 1.2346, "digits": 2}, {"value": 1.2347, "digits": 2}, True),
        ({"value": 1.2346, "digits": 2}, {"value": 1.2348, "digits": 2}, False),
        ({"value": 1.2346, "digits": None}, {"value": 1.2347, "digits": None}, False),
        ({"rows": [[1.2346]], "text": [["1.2"]]}, {"rows": [[1.2347]], "text": [["1.2"]]}, True),
        ({"rows": [[1.2346]], "text": [["1.2"]]}, {"rows": [[1.2346]], "text": [["1.3"]]}, False),
    ],
)
def test_records_are_compared(old, new, equal):
    assert (difference(old, new) is None) is equal


def compared(folder, old, new):
    """Return how two pictures, or arrays of pixels, differ."""
    (folder / "new").mkdir()
    for place, picture in (("a.png", old), ("new/a.png", new)):
        made = PIL.Image.fromarray(picture) if isinstance(picture, np.ndarray) else picture
        made.save(folder / place)
    return picture_difference(folder / "a.png", folder / "new" / "a.png")


def edge(at, height=100):
    pixels = np.full((height, 100, 3), 255, np.uint8)
    pixels[:, at:] = 60
    return pixels


@pytest.mark.parametrize(
    ("at", "height", "equal"),
    [(50, 100, True), (51, 100, True), (50, 101, True), (53, 100, False), (50, 103, False)],
)
def test_edges_of_a_scene_may_lie_a_pixel_aside(tmp_path, at, height, equal):
    assert (compared(tmp_path, edge(50), edge(at, height)) is None) is equal


def scene():
    return PIL.Image.open(ROOT / "figures" / "circuit_tunnel.png").convert("RGB")


@pytest.mark.parametrize(("letters", "equal"), [("", True), (".", True), ("P", False)])
def test_letter_in_a_scene_is_noticed(tmp_path, letters, equal):
    """A P of 8 points at 300 dpi: of the scene's pixels it changes a part in two thousand."""
    written = scene()
    font = PIL.ImageFont.truetype(font_manager.findfont("DejaVu Sans"), 33)
    PIL.ImageDraw.Draw(written).text((300, 300), letters, fill=(30, 30, 30), font=font)
    said = compared(tmp_path, scene(), written)
    assert said is None if equal else "about pixel (3" in said


def test_scattered_pixels_of_a_scene_may_differ(tmp_path):
    """As many as another version of the GL library changes, strewn over lines and seams."""
    pixels = np.array(scene())
    rows, columns = np.random.default_rng(7).integers(0, pixels.shape[:2], (150, 2)).T
    for step in range(4):  # short strokes, two pixels wide
        for wide in range(2):
            place = (rows + wide) % len(pixels), (columns + step) % pixels.shape[1]
            pixels[place] = 255 - pixels[place]
    assert compared(tmp_path, scene(), pixels) is None


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
        with matplotlib.rc_context({"svg.fonttype": "none"}):
            drawing.savefig(tmp_path / folder / "a.svg")
        return tmp_path / folder / "a.svg"

    same = picture_difference(drawn("old"), drawn("new", **options))
    assert (same is None) is equal


def test_missing_picture_is_told(tmp_path):
    assert picture_difference(tmp_path / "a.png", tmp_path / "b.png") == "a.png is not committed."


# ---- what pytest says of a notebook -----------------------------------------------------------

SOURCES = [
    "from kit import Show\nshow = Show('01_test')",
    "show('it', 1.25, 'm', digits=3)",
    "from kit.style import figure\n"
    "drawing, ax = figure(height=4)\nshow.figure(drawing, 'axes', 'Empty axes.')",
    "print(0.5)",
]
CHANGES = {
    "planted": [
        ("notebooks/01_test.ipynb", '"0.5\\n"', '"0.6\\n"'),
        ("notebooks/01_test.ipynb", '"execution_count": 4', '"execution_count": 5'),
        ("report/numbers/01_test.json", '"value": 1.25', '"value": 1.26'),
        ("figures/axes.svg", "M ", "M 9"),
    ],
    "dead": [("notebooks/01_test.ipynb", "print(0.5)", "import os; os._exit(1)")],
    "built": [],
    "altered": [("figures/axes.svg", "M ", "M 9")],
}


@pytest.fixture(scope="module")
def said(tmp_path_factory, shared_kernels):
    """Return what passed and failed of a notebook, as it was run and after each change."""
    folder = tmp_path_factory.mktemp("checkouts")
    true = folder / "true" / "notebooks" / "01_test.ipynb"
    true.parent.mkdir(parents=True)
    cells = [new_code_cell(source, id=f"cell-{i}") for i, source in enumerate(SOURCES)]
    nbformat.write(new_notebook(cells=cells), true)
    run_notebook(true, notebook_sources(true))
    for name, changes in CHANGES.items():
        shutil.copytree(folder / "true", folder / name)
        if name not in ("built", "altered"):
            shutil.rmtree(folder / name / "build")
        for file, old, new in changes:
            text = (folder / name / file).read_text()
            assert old in text
            (folder / name / file).write_text(text.replace(old, new))
    shutil.rmtree(folder / "true" / "build")
    command = [sys.executable, "-m", "pytest", "-p", "report.tests.notebook_results", "-q", "-rA"]
    options = ["-p", "no:cacheprovider", "--rootdir", folder, "-c", ROOT / "pyproject.toml"]
    run = subprocess.run(
        [*command, *options, folder], cwd=ROOT, capture_output=True, text=True, timeout=600
    )
    found = {path.name: Counter() for path in folder.iterdir()}
    for word, name in re.findall(r"^(PASSED|FAILED) .*?(\w+)/notebooks/", run.stdout, re.M):
        found[name][word] += 1
    return found, run.stdout


def test_notebook_is_run_again_and_its_results_are_compared(said):
    found, output = said
    assert found["true"] == {"PASSED": 7}
    assert found["planted"] == {"PASSED": 3, "FAILED": 4}
    assert "numbers, it, value: 1.26 is committed, 1.25 came out now." in output
    assert "axes.svg differs from the committed figure" in output
    assert "Cell outputs differ" in output
    assert found["dead"]["FAILED"] >= 1 and "The kernel died" in output
    assert "isn't stored as run from top to bottom" in output


def test_notebook_that_a_build_has_run_is_not_run_again(said):
    assert said[0]["built"] == {"PASSED": 2}
    assert said[0]["altered"]["FAILED"] == 1
