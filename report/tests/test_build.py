"""The build: what counts as a change, and that no failure leaves half a result."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import nbformat
import pytest
from ipykernel.ipkernel import IPythonKernel
from jupyter_client.kernelspec import KernelSpecManager
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from report.build import recover, told
from report.execute import METADATA, NotebookFailed, run_notebook
from report.lock import locked
from report.sources import (
    ROOT,
    cells,
    file_digests,
    is_run,
    notebook_results,
    notebook_sources,
    notebooks,
    records,
)
from report.state import State

pytestmark = pytest.mark.usefixtures("shared_kernels")

RECORD = """from kit import Record
record = Record("01_test")
record("it", {value}, "m")"""
DRAW = """from kit.style import figure
record.figure(figure(height=4)[0], "axes", "Empty axes.")"""


@pytest.fixture
def notebook(tmp_path):
    (tmp_path / "notebooks").mkdir()
    (tmp_path / "environment.txt").touch()
    return tmp_path / "notebooks" / "01_test.ipynb"


def write(notebook, *sources):
    cells = [new_code_cell(source, id=f"cell-{i}") for i, source in enumerate(sources)]
    nbformat.write(new_notebook(cells=cells), notebook)


def files(notebook):
    root = notebook.parent.parent
    return {p: p.read_bytes() for p in root.rglob("*") if p.is_file() and "build" not in p.parts}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """Return a checkout whose notebook, of a number and a figure, has been run."""
    root = tmp_path_factory.mktemp("checkout")
    (root / "notebooks").mkdir()
    (root / "environment.txt").touch()
    write(root / "notebooks" / "01_test.ipynb", RECORD.format(value=1), DRAW)
    run_notebook(root / "notebooks" / "01_test.ipynb")
    return root


@pytest.fixture
def run_before(notebook, checkout):
    """Return a notebook, of a number and a figure, that has been run in its checkout."""
    shutil.copytree(checkout, notebook.parent.parent, dirs_exist_ok=True)
    return notebook


def test_running_puts_results_into_place(run_before):
    assert is_run(run_before)
    assert records(run_before)[1]["numbers"]["it"]["value"] == 1
    assert records(run_before)[1]["numbers"]["it"]["cell"] == 1
    assert records(run_before)[1]["figures"]["axes"]["cell"] == 2
    assert (run_before.parent.parent / "figures" / "axes.svg").exists()
    write(run_before, RECORD.format(value=1), DRAW)
    assert not is_run(run_before)


def test_running_twice_gives_the_same_bytes(run_before):
    first = files(run_before)
    run_notebook(run_before)
    assert files(run_before) == first


def test_outputs_are_results_and_not_sources(notebook):
    write(notebook, RECORD.format(value=1))
    sources, results = notebook_sources(notebook), notebook_results(notebook)
    run_notebook(notebook)
    assert notebook_sources(notebook) == sources
    assert notebook_results(notebook) != results


def test_change_of_cell_module_data_or_environment_is_seen(notebook):
    root = notebook.parent.parent
    (root / "tunneller_lib").mkdir()
    module, other = (root / "tunneller_lib" / name for name in ("a.py", "b.py"))
    module.write_text("x = 1")
    other.touch()
    (notebook.parent / "table.csv").write_text("1")
    write(notebook, "from tunneller_lib.a import x", "open('table.csv')")

    def changes(file, text):
        before = notebook_sources(notebook)
        file.write_text(text)
        return notebook_sources(notebook) != before

    assert changes(module, "x = 2")
    assert not changes(module, "x = (2)  # two")
    assert not changes(other, "y = 1")
    assert changes(notebook.parent / "table.csv", "2")
    assert changes(root / "environment.txt", "numpy==1")
    assert changes(notebook.parent / "contents.toml", "[found]\n01_test = 'It.'")
    assert not changes(notebook.parent / "contents.toml", "[found]\n01_test = 'It.'\n02_b = 'No.'")
    before = notebook_sources(notebook)
    write(notebook, "2")
    assert notebook_sources(notebook) != before


def test_file_times_are_not_looked_at(notebook):
    write(notebook, "1")
    before = notebook_sources(notebook), notebook_results(notebook)
    os.utime(notebook, (1, 1))
    assert (notebook_sources(notebook), notebook_results(notebook)) == before


def test_missing_result_is_seen(run_before):
    before = notebook_results(run_before)
    (run_before.parent.parent / "figures" / "axes.svg").unlink()
    assert notebook_results(run_before) != before


def test_result_no_longer_made_is_removed(run_before):
    notebook = run_before
    write(notebook, RECORD.format(value=1))
    run_notebook(notebook)
    assert not (notebook.parent.parent / "figures" / "axes.svg").exists()
    write(notebook, "1")
    run_notebook(notebook)
    assert not records(notebook)[0].exists()


@pytest.mark.parametrize(
    ("last", "message"),
    [
        ("1 / 0", "01_test.ipynb, code cell 2: ZeroDivisionError: division by zero"),
        ("assert 1 == 2", "01_test.ipynb, code cell 2: AssertionError: assert 1 == 2"),
        ("import os; os._exit(1)", "01_test.ipynb, code cell 2: the kernel died"),
    ],
)
def test_failure_names_the_cell_and_changes_nothing(run_before, last, message):
    notebook = run_before
    write(notebook, RECORD.format(value=2), last)
    content = nbformat.read(notebook, as_version=4)
    content.cells.insert(0, new_markdown_cell("Cells of text aren't counted.", id="text"))
    nbformat.write(content, notebook)
    before = files(notebook)
    with pytest.raises(NotebookFailed, match=message):
        run_notebook(notebook)
    assert files(notebook) == before


def test_kernel_that_dies_while_it_starts_is_a_sentence(run_before, tmp_path_factory, monkeypatch):
    notebook = run_before
    write(notebook, RECORD.format(value=2))
    before = files(notebook)
    spec = {"argv": ["false", "{connection_file}"], "display_name": "", "language": "python"}
    folder = tmp_path_factory.mktemp("jupyter")
    (folder / "kernels" / "python3").mkdir(parents=True)
    (folder / "kernels" / "python3" / "kernel.json").write_text(json.dumps(spec))
    monkeypatch.setenv("JUPYTER_PATH", str(folder))
    with pytest.raises(NotebookFailed, match=r"^01_test.ipynb: the kernel doesn't start \(.*died"):
        run_notebook(notebook)
    assert files(notebook) == before


def test_edit_while_running_is_kept(notebook):
    edit = f"import shutil; shutil.copy({str(notebook) + '.edited'!r}, {str(notebook)!r})"
    edited = notebook.with_name("01_test.ipynb.edited")
    write(edited, "'edited'")
    write(notebook, edit)
    with pytest.raises(NotebookFailed, match="was edited while it ran"):
        run_notebook(notebook)
    assert notebook.read_bytes() == edited.read_bytes()


def test_interruption_changes_nothing(run_before):
    notebook = run_before
    write(notebook, RECORD.format(value=2), DRAW, "import time; time.sleep(60)")
    before = files(notebook)
    code = (
        "import sys; from pathlib import Path; from report.execute import run_notebook;"
        "run_notebook(Path(sys.argv[1]))"
    )
    command = [sys.executable, "-c", code, notebook]
    build = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    staging = notebook.parent.parent / "build" / "staging"
    limit = time.monotonic() + 60
    while not any(staging.glob("*/figures/axes.svg")) and time.monotonic() < limit:
        time.sleep(0.1)
    build.send_signal(signal.SIGINT)
    assert build.wait(30) != 0
    assert files(notebook) == before


READY = """import os, sys; from pathlib import Path
import report.execute as execute
moved, replace = [], os.replace
def killed(source, target):
    if Path(target).name in ("axes.svg", "01_test.json", "01_test.ipynb"):
        if len(moved) == {after}: os._exit(9)
        moved.append(target)
    replace(source, target)
execute.os.replace = killed
execute.run_notebook(Path(sys.argv[1]), {{"a": "1"}})"""


@pytest.mark.parametrize("after", [0, 1, 2])
def test_build_killed_while_results_move_is_finished_by_the_next(notebook, after):
    write(notebook, RECORD.format(value=1), DRAW)
    subprocess.run([sys.executable, "-c", READY.format(after=after), notebook], cwd=ROOT)
    root = notebook.parent.parent
    assert not records(notebook)[0].exists()  # it comes last
    recover(root)
    assert is_run(notebook) and records(notebook)[1]["numbers"]["it"]["value"] == 1
    assert (root / "figures" / "axes.svg").exists()
    assert State(root, "01_test").stale({"a": "1"}) is None
    assert not any((root / "build" / "ready").iterdir())


PARTS = """import os, sys; from pathlib import Path
import report.execute as execute
moved, replace = [], os.replace
def killed(source, target):
    if Path(target).name in ("a.pdf", "b.pdf", "list.csv"):
        if len(moved) == {after}: os._exit(9)
        moved.append(target)
    replace(source, target)
execute.os.replace = killed
root = Path(sys.argv[1])
files = {{root / name: b"new" for name in ("report/a.pdf", "report/b.pdf", "figures/list.csv")}}
execute.publish_files("report", files, {{"a": "1"}}, 1.0, root)"""


@pytest.mark.parametrize("after", [0, 1, 2])
def test_parts_of_a_report_whose_move_was_killed_are_put_in_place_by_the_next_build(
    tmp_path, after
):
    parts = [tmp_path / name for name in ("report/a.pdf", "report/b.pdf", "figures/list.csv")]
    for part in parts:
        part.parent.mkdir(exist_ok=True)
        part.write_bytes(b"old")
    command = [sys.executable, "-c", PARTS.format(after=after), tmp_path]
    assert subprocess.run(command, cwd=ROOT).returncode == 9
    assert [part.read_bytes() for part in parts].count(b"new") == after
    recover(tmp_path)
    assert [part.read_bytes() for part in parts] == [b"new"] * 3
    assert State(tmp_path, "report").stale({"a": "1"}) is None


def test_edit_after_a_killed_build_is_kept(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    subprocess.run([sys.executable, "-c", READY.format(after=0), notebook], cwd=ROOT)
    write(notebook, "'edited'")
    before = files(notebook)
    recover(notebook.parent.parent)
    assert files(notebook) == before


@pytest.mark.parametrize("reason", [errno.ENOSPC, errno.EFBIG, errno.EROFS])
def test_disk_that_takes_no_more_changes_nothing_and_is_told(
    run_before, reason, monkeypatch, capsys
):
    notebook = run_before
    write(notebook, RECORD.format(value=2))
    before = files(notebook)

    def refuse(*_):
        raise OSError(reason, os.strerror(reason), "a.svg")

    monkeypatch.setattr(nbformat, "write", refuse)
    assert told(lambda: run_notebook(notebook)) == 1
    assert capsys.readouterr().err == (
        f"The build stopped: {os.strerror(reason)} (a.svg). What was there is whole; "
        "the next build goes on from here.\n"
    )
    assert files(notebook) == before
    assert list((notebook.parents[1] / "build" / "staging").iterdir()) == []


def test_what_is_no_finished_notebook_is_removed(tmp_path):
    place = tmp_path / "build" / "ready" / "01_test"
    place.mkdir(parents=True)
    (place / "ready.json").write_text("{")
    (tmp_path / "build" / "staging" / "01_test-x").mkdir(parents=True)
    recover(tmp_path)
    assert not place.exists() and not (tmp_path / "build" / "staging").exists()


def test_results_that_agree_are_kept_as_they_are(run_before):
    notebook = run_before
    first = files(notebook)
    figure = notebook.parent.parent / "figures" / "axes.svg"
    figure.write_bytes(figure.read_bytes().replace(b"<svg ", b"<svg  "))
    altered = figure.read_bytes()
    assert run_notebook(notebook) == ["axes.svg"]
    assert files(notebook) == first | {figure: altered}


def test_state_tells_why_a_task_is_stale(tmp_path):
    made = tmp_path / "figures" / "a.svg"
    made.parent.mkdir()
    made.write_text("a")
    assert State(tmp_path, "it").stale({"a": "1"}) == "not built here yet"
    State(tmp_path, "it").save({"a": "1", "b": "1"}, file_digests(tmp_path, [made]), 2)
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) is None
    assert State(tmp_path, "it").seconds == 2
    assert State(tmp_path, "it").stale({"a": "2", "b": "1"}) == "a changed"
    assert State(tmp_path, "it").stale({"a": "1"}) == "b changed"
    assert State(tmp_path, "it").stale({"c": "1"}) == "c and 2 more changed"
    made.write_text("b")
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) == "figures/a.svg was altered"
    made.unlink()
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) == "figures/a.svg is missing"


@pytest.mark.parametrize("text", ["", "{", "[1]", "null", "{}", '{"sources": 1}', "\x00\xff"])
def test_state_that_is_none_is_no_state(tmp_path, text):
    State(tmp_path, "it").save({"a": "1"}, {}, 1)
    State(tmp_path, "it").file.write_text(text)
    assert State(tmp_path, "it").stale({"a": "1"}) == "not built here yet"


HOLD = """import sys, time; from pathlib import Path; from report.lock import locked
with locked("a task", root=Path(sys.argv[1])): print("got it", flush=True); time.sleep(60)"""


def test_lock_is_waited_for_and_tells_its_holder(tmp_path):
    command = [sys.executable, "-c", HOLD, tmp_path]
    holder = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert holder.stdout.readline() == "got it\n"
    other = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    said = other.stdout.readline()
    assert said.startswith(f"Waiting for `a task`, process {holder.pid}, since ")
    holder.kill()
    assert other.stdout.readline() == "got it\n"
    other.kill()
    for process in (holder, other):
        process.communicate()


def test_lock_outlives_the_removal_of_its_folder(tmp_path):
    with locked("make clean", root=tmp_path):
        shutil.rmtree(tmp_path / "build")
    with locked("a", shared=True, root=tmp_path), locked("b", shared=True, root=tmp_path):
        assert (tmp_path / "build" / "lock").read_text().startswith("`b`, process")


def test_only_numbered_notebooks_belong_to_the_study(tmp_path):
    (tmp_path / "notebooks").mkdir()
    for name in ("01_torus.ipynb", "Untitled.ipynb"):
        (tmp_path / "notebooks" / name).touch()
    assert [path.name for path in notebooks(tmp_path)] == ["01_torus.ipynb"]


def test_broken_notebook_is_named(tmp_path):
    broken = tmp_path / "01_torus.ipynb"
    broken.write_text("{")
    with pytest.raises(SystemExit, match=r"^01_torus.ipynb is no notebook"):
        cells(broken)


def test_metadata_are_what_jupyterlab_writes_but_for_the_version():
    said = IPythonKernel.language_info
    assert METADATA["language_info"] == {k: said[k] for k in said if k != "version"}
    spec = KernelSpecManager().get_kernel_spec("python3")
    assert METADATA["kernelspec"] == {
        "display_name": spec.display_name, "language": spec.language, "name": "python3"
    }  # fmt: skip
