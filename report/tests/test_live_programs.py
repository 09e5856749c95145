"""What pages run of a notebook: all that its sliders need, and nothing else."""

import ast
import base64
import json
from functools import cache

import nbformat
import numpy as np
import pytest

from kit import preview
from report.live.excerpt import excerpt
from report.live.program import exercises, programs
from report.sources import INDEX, ROOT, notebooks
from tests.pictures import pixels

READS = [
    "figures/*", "notebooks/*.ipynb", "notebooks/*.toml", "report/numbers/*", "tunneller_lib/*"
]  # fmt: skip

CALL = "sliders("
CODE = {n: [cell for cell in json.loads(n.read_bytes())["cells"] if cell["cell_type"] == "code"]
        for n in notebooks()}  # fmt: skip
WRITTEN = {n: ["".join(cell["source"]) for cell in code] for n, code in CODE.items()}
EVERY = [(n, k) for n in WRITTEN for k in range("".join(WRITTEN[n]).count(CALL))]

of_study, exercises = cache(programs), cache(exercises)


def kept(folder, *code):
    """Return the lines of the program of the last call of sliders in cells, without that."""
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in code])
    path = folder / "98_made.ipynb"
    nbformat.write(book, path)
    lines = programs(path)[-1].source.strip().split("\n")[:-1]
    return [line for line in lines if line]


def test_program_keeps_what_the_drawing_needs_alone(tmp_path):
    first = "import numpy as np, csv\nfrom math import pi, tau\na = pi\nb = np.ones(9)"
    second = "print(b)\ndraw = lambda x: a * x"
    assert kept(tmp_path, first, second, "sliders(draw, x=(0, 1, 0))") == [
        "from math import pi", "a = pi", "draw = lambda x: a * x"
    ]  # fmt: skip


def test_program_keeps_what_a_function_reads_that_is_bound_after_it(tmp_path):
    body = ["def draw(x):", "    return look"]
    look = ["look = {}", "look |= {'a': 1}", "look['b'] = 2"]
    look += ["for k in (1, 2):", "    look.update(c=k)"]
    assert kept(tmp_path, "\n".join(body), "\n".join(look), "sliders(draw)") == body + look


def test_program_leaves_out_what_is_bound_anew_and_names_of_inner_scopes(tmp_path):
    before = "alt = slow()\nrows = [alt for a in range(3)]\na = 1", "c = [a for a in range(3)]"
    body = ["alt = 'b'", "def draw(x, rows=2):", "    c = alt", "    return c"]
    assert kept(tmp_path, *before, "\n".join(body), "first = sliders(draw, alt=alt)") == body


def test_program_keeps_an_older_value_that_a_function_was_called_with(tmp_path):
    body = ["a = 1", "def made():", "    return a", "b = made()", "a = 2"]
    assert kept(tmp_path, "\n".join(body), "sliders(lambda x: (a, b))") == body


def test_programs_are_as_many_as_calls_of_sliders_and_every_chapter_has_one():
    for notebook, texts in WRITTEN.items():
        assert of_study(notebook) or notebook.stem == INDEX
        assert len(of_study(notebook)) == "".join(texts).count(CALL)


@pytest.mark.parametrize(("path", "number"), EVERY, ids=lambda value: getattr(value, "stem", value))
def test_program_draws_what_the_notebook_stored(path, number, monkeypatch):
    program = of_study(path)[number]
    if program.draws_scene:
        assert "scene" in program.source
        return
    monkeypatch.chdir(ROOT / "notebooks")
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    *before, call = ast.parse(program.source).body
    names = {}
    exec(compile(ast.Module(before, []), "before", "exec"), names)
    drawn = eval(compile(ast.Expression(call.value), "call", "eval"), names)
    outputs = CODE[path][program.cell - 1]["outputs"]
    stored = [o["data"]["image/png"] for o in outputs if "image/png" in o["data"]]
    if not stored:  # the sliders only, for those who move them
        assert path.stem == "43_better" and len(drawn.axes) == 1
        return
    picture = shown[-1] if shown else preview(drawn)
    here, there = pixels(picture.data), pixels(base64.b64decode(stored[-1]))
    assert here.shape == there.shape and np.abs(here - there).mean() < 1


def test_exercise_needs_nothing_that_its_own_cell_binds_first():
    above = ast.parse("watt = slow()\nlaps = [1]\ncheck = print").body
    cell = ast.parse("watt = 1\nlaps += [2]\ncheck(watt, laps)")
    assert list(map(ast.unparse, excerpt(above, cell))) == ["laps = [1]", "check = print"]


def test_every_chapter_has_two_exercises_and_all_run_on_their_pages():
    count = {n.stem: "".join(WRITTEN[n]).count("print(check_") for n in notebooks()}
    there = {n.stem: len(exercises(n)) for n in notebooks()}
    assert there == count and {stem for stem in count if count[stem] < 2} == {INDEX}


# `make browser` tries every chapter's, in the page.
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("path", notebooks()[1::2], ids=lambda path: path.stem)
def test_exercise_prints_what_the_notebook_stored(path, which, monkeypatch, capsys):
    monkeypatch.chdir(ROOT / "notebooks")
    number = exercises(path)[which]
    above = [one for text in WRITTEN[path][: number - 1] for one in ast.parse(text).body]
    cell = ast.parse(WRITTEN[path][number - 1])
    names = {}
    exec(compile(ast.Module(excerpt(above, cell), []), "above", "exec"), names)
    capsys.readouterr()
    exec(compile(cell, "exercise", "exec"), names)
    outputs = CODE[path][number - 1]["outputs"]
    assert capsys.readouterr().out == "".join(line for o in outputs for line in o["text"])
