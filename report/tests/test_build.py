"""The build: what counts as a change, and that no failure leaves half a result."""

import errno
import json
import os
import shutil
import subprocess
import sys

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from report import execute, lock, runs
from report.execute import NotebookFailed, run_notebook
from report.lock import locked
from report.runs import recover, told
from report.sources import ROOT, cells, file_digests, is_run, notebook_sources, notebooks, records
from report.state import State

pytestmark = pytest.mark.usefixtures("shared_kernels")

SHOW = """from kit import Show
show = Show("01_test")
show("it", {value}, "m")"""
DRAW = """from kit.style import figure
show.figure(figure(height=4)[0], "axes", "Empty axes.")"""


def place(root):
    """Return the path of a notebook in a new checkout."""
    (root / "notebooks").mkdir()
    (root / "environment.txt").touch()
    return root / "notebooks" / "01_test.ipynb"


@pytest.fixture
def notebook(tmp_path):
    return place(tmp_path)


def write(notebook, *sources):
    cells = [new_code_cell(source, id=f"cell-{i}") for i, source in enumerate(sources)]
    nbformat.write(new_notebook(cells=cells), notebook)


def files(notebook):
    root = notebook.parent.parent
    return {p: p.read_bytes() for p in root.rglob("*") if p.is_file() and "build" not in p.parts}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """Return a checkout whose notebook, of a number and a figure, has been run to its end.

    The results are still to be moved into place.
    """
    notebook = place(tmp_path_factory.mktemp("checkout"))
    write(notebook, SHOW.format(value=1), DRAW)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(execute, "publish", lambda place: None)
        run_notebook(notebook, {"a": "1"})
    return notebook.parents[1]


@pytest.fixture
def finished(notebook, checkout):
    """Return a notebook, of a number and a figure, whose results are to be moved into place."""
    shutil.copytree(checkout, notebook.parent.parent, dirs_exist_ok=True)
    return notebook


@pytest.fixture
def run_before(finished):
    """Return a notebook, of a number and a figure, that has been run in its checkout."""
    recover(finished.parents[1])
    return finished


def test_running_puts_results_into_place(run_before):
    assert is_run(run_before)
    assert records(run_before)[1]["numbers"]["it"]["value"] == 1
    assert records(run_before)[1]["numbers"]["it"]["cell"] == 1
    assert records(run_before)[1]["figures"]["axes"]["cell"] == 2
    assert (run_before.parent.parent / "figures" / "axes.svg").exists()
    write(run_before, SHOW.format(value=1), DRAW)
    assert not is_run(run_before)


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


def test_result_no_longer_made_is_removed(run_before):
    write(run_before, SHOW.format(value=1))
    run_notebook(run_before)
    assert not (run_before.parent.parent / "figures" / "axes.svg").exists()
    write(run_before, "1")
    run_notebook(run_before)
    assert not records(run_before)[0].exists()


@pytest.mark.parametrize(
    ("last", "message"),
    [
        ("1 / 0", "01_test.ipynb, code cell 2: ZeroDivisionError: division by zero"),
        ("assert 1 == 2", "01_test.ipynb, code cell 2: AssertionError: assert 1 == 2"),
        ("import os; os._exit(1)", "01_test.ipynb, code cell 2: the kernel died"),
    ],
)
def test_failure_names_the_cell_and_changes_nothing(run_before, last, message):
    write(run_before, SHOW.format(value=2), last)
    content = nbformat.read(run_before, as_version=4)
    content.cells.insert(0, new_markdown_cell("Cells of text aren't counted.", id="text"))
    nbformat.write(content, run_before)
    before = files(run_before)
    with pytest.raises(NotebookFailed, match=message):
        run_notebook(run_before)
    assert files(run_before) == before


def test_kernel_that_dies_while_it_starts_is_a_sentence(run_before, tmp_path_factory, monkeypatch):
    write(run_before, SHOW.format(value=2))
    before = files(run_before)
    spec = {"argv": ["false", "{connection_file}"], "display_name": "", "language": "python"}
    folder = tmp_path_factory.mktemp("jupyter")
    (folder / "kernels" / "python3").mkdir(parents=True)
    (folder / "kernels" / "python3" / "kernel.json").write_text(json.dumps(spec))
    monkeypatch.setenv("JUPYTER_PATH", str(folder))
    with pytest.raises(NotebookFailed, match=r"^01_test.ipynb: the kernel doesn't start \(.*died"):
        run_notebook(run_before)
    assert files(run_before) == before


def test_edit_while_running_is_kept(notebook):
    edit = f"import shutil; shutil.copy({str(notebook) + '.edited'!r}, {str(notebook)!r})"
    edited = notebook.with_name("01_test.ipynb.edited")
    write(edited, "'edited'")
    write(notebook, edit)
    with pytest.raises(NotebookFailed, match="was edited while it ran"):
        run_notebook(notebook)
    assert notebook.read_bytes() == edited.read_bytes()


KILLED = """import os, sys; from pathlib import Path
import report.execute as execute
def killed(source, target, replace=os.replace):
    if len(moved) == after: os._exit(9)
    moved.append(target)
    replace(source, target)
execute.os.replace = killed
for after in range(3):
    moved = []
    if os.fork() == 0: execute.publish(Path(sys.argv[1], str(after), "build", "ready", "01_test"))
    assert os.waitstatus_to_exitcode(os.wait()[1]) == 9
"""


@pytest.fixture(scope="module")
def killed(checkout, tmp_path_factory):
    """Return checkouts whose builds were killed after so many results had been moved into place."""
    folder = tmp_path_factory.mktemp("killed")
    for after in range(3):
        shutil.copytree(checkout, folder / str(after))
    subprocess.run([sys.executable, "-c", KILLED, folder], cwd=ROOT, check=True)
    return folder


@pytest.mark.parametrize("after", [0, 1, 2])
def test_build_killed_while_results_move_is_finished_by_the_next(killed, after):
    root = killed / str(after)
    notebook = root / "notebooks" / "01_test.ipynb"
    assert not records(notebook)[0].exists()  # it comes last
    recover(root)
    assert is_run(notebook) and records(notebook)[1]["numbers"]["it"]["value"] == 1
    assert (root / "figures" / "axes.svg").exists()
    assert State(root, "01_test").stale({"a": "1"}) is None
    assert not any((root / "build" / "ready").iterdir())


def test_edit_after_a_killed_build_is_kept(finished):
    write(finished, "'edited'")
    before = files(finished)
    recover(finished.parent.parent)
    assert files(finished) == before


@pytest.mark.parametrize("reason", [errno.ENOSPC, errno.EFBIG, errno.EROFS])
def test_disk_that_takes_no_more_changes_nothing_and_is_told(
    run_before, reason, monkeypatch, capsys
):
    write(run_before, SHOW.format(value=2))
    before = files(run_before)

    def refuse(*_):
        raise OSError(reason, os.strerror(reason), "a.svg")

    monkeypatch.setattr(execute, "execute", lambda *_: nbformat.read(run_before, as_version=4))
    monkeypatch.setattr(nbformat, "write", refuse)
    assert told(lambda: run_notebook(run_before)) == 1
    assert capsys.readouterr().err == (
        f"The build stopped: {os.strerror(reason)} (a.svg). Finished notebooks are kept; "
        "the next build goes on from here.\n"
    )
    assert files(run_before) == before
    assert list((run_before.parents[1] / "build" / "staging").iterdir()) == []


@pytest.fixture
def three(tmp_path, monkeypatch):
    """Return a study of three notebooks, of which the build works on one at a time."""
    for number in (1, 2, 3):
        path = tmp_path / "notebooks" / f"0{number}_test.ipynb"
        path.parent.mkdir(exist_ok=True)
        write(path, "1 / 0")
    (tmp_path / "environment.txt").touch()
    monkeypatch.setattr(runs, "ROOT", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    return notebooks(tmp_path)


def test_notebooks_that_fail_are_told_and_do_not_stop_the_others(three, monkeypatch, capsys):
    def fail(notebook, sources):
        raise NotebookFailed(notebook.name)

    monkeypatch.setattr(runs, "run", fail)
    assert not runs.run_stale(three)
    said = capsys.readouterr().out.splitlines()
    assert said == [f" {k} of 3  failed: 0{4 - k}_test.ipynb" for k in (1, 2, 3)]


def test_stale_notebooks_are_told_to_a_reader_who_reads_one_line_alone():
    told_ = subprocess.run(
        f"{sys.executable} -m report.build stale | head -1", shell=True, cwd=ROOT,
        capture_output=True, text=True,
    )  # fmt: skip
    assert told_.stdout.count("\n") == 1 and told_.stderr == ""


def test_results_that_agree_are_kept_as_they_are(run_before):
    first = files(run_before)
    figure = run_before.parent.parent / "figures" / "axes.svg"
    figure.write_bytes(figure.read_bytes().replace(b"<svg ", b"<svg  "))
    altered = figure.read_bytes()
    assert run_notebook(run_before) == ["axes.svg"]
    assert files(run_before) == first | {figure: altered}


def test_state_tells_why_a_task_is_stale(tmp_path):
    made = tmp_path / "figures" / "a.svg"
    made.parent.mkdir()
    made.write_text("a")
    assert State(tmp_path, "it").stale({"a": "1"}) == "not built here yet"
    State(tmp_path, "it").save({"a": "1", "b": "1"}, file_digests(tmp_path, [made]))
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) is None
    assert State(tmp_path, "it").stale({"a": "2", "b": "1"}) == "a changed"
    assert State(tmp_path, "it").stale({"a": "1"}) == "b changed"
    assert State(tmp_path, "it").stale({"c": "1"}) == "c and 2 more changed"
    made.write_text("b")
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) == "figures/a.svg was altered"
    made.unlink()
    assert State(tmp_path, "it").stale({"a": "1", "b": "1"}) == "figures/a.svg is missing"


@pytest.mark.parametrize("text", ["", "{", "[1]", "null", "{}", '{"sources": 1}', "\x00\xff"])
def test_state_that_is_none_is_no_state(tmp_path, text):
    State(tmp_path, "it").save({"a": "1"}, {})
    State(tmp_path, "it").file.write_text(text)
    assert State(tmp_path, "it").stale({"a": "1"}) == "not built here yet"


HOLD = """import sys, time; from pathlib import Path; from report.lock import locked
from report.runs import recover, told
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


def test_checkout_that_cannot_be_written_is_told_in_a_sentence(tmp_path, monkeypatch, capsys):
    (tmp_path / "build").touch()  # no folder can be made there, not even by root
    monkeypatch.setattr(lock, "ROOT", tmp_path)
    assert lock.main("make clean", "true") == 1
    said = capsys.readouterr().err
    assert said.startswith("`make clean` stopped: ") and said.count("\n") == 1


def test_broken_notebook_is_named(tmp_path):
    broken = tmp_path / "01_torus.ipynb"
    broken.write_text("{")
    with pytest.raises(SystemExit, match=r"^01_torus.ipynb is no notebook"):
        cells(broken)
