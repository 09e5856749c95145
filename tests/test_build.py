"""The build: what counts as a change, and that no failure leaves half a result."""

import os
import signal
import subprocess
import sys
import time

import nbformat
import pytest
from ipykernel.ipkernel import IPythonKernel
from jupyter_client.kernelspec import KernelSpecManager
from nbformat.v4 import new_code_cell, new_notebook

from report.build import unchanged
from report.execute import METADATA, NotebookFailed, run_notebook
from report.sources import cells, is_run, notebook_results, notebook_sources, notebooks, records

RECORD = """from tunneller_lib.reporting import Record
record = Record("01_test")
record("it", {value}, "m")"""
DRAW = """from tunneller_lib.reporting.style import figure
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


def test_running_puts_results_into_place(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    assert not is_run(notebook)
    run_notebook(notebook)
    assert is_run(notebook)
    assert records(notebook)[1]["numbers"]["it"]["value"] == 1
    assert records(notebook)[1]["numbers"]["it"]["cell"] == 1
    assert records(notebook)[1]["figures"]["axes"]["cell"] == 2
    assert (notebook.parent.parent / "figures" / "axes.svg").exists()


def test_running_twice_gives_the_same_bytes(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    run_notebook(notebook)
    first = files(notebook)
    run_notebook(notebook)
    assert files(notebook) == first


def test_outputs_are_results_and_not_sources(notebook):
    write(notebook, RECORD.format(value=1))
    sources, results = notebook_sources(notebook), notebook_results(notebook)
    run_notebook(notebook)
    assert notebook_sources(notebook) == sources
    assert notebook_results(notebook) != results


def test_change_of_cell_library_or_environment_is_seen(notebook):
    write(notebook, "1")
    root, seen = notebook.parent.parent, {notebook_sources(notebook)}
    write(notebook, "2")
    seen.add(notebook_sources(notebook))
    (root / "environment.txt").write_text("numpy==1")
    seen.add(notebook_sources(notebook))
    (root / "tunneller_lib").mkdir()
    (root / "tunneller_lib" / "a.py").touch()
    seen.add(notebook_sources(notebook))
    assert len(seen) == 4


def test_file_times_are_not_looked_at(notebook):
    write(notebook, "1")
    before = notebook_sources(notebook), notebook_results(notebook)
    os.utime(notebook, (1, 1))
    assert (notebook_sources(notebook), notebook_results(notebook)) == before


def test_missing_result_is_seen(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    run_notebook(notebook)
    before = notebook_results(notebook)
    (notebook.parent.parent / "figures" / "axes.svg").unlink()
    assert notebook_results(notebook) != before


def test_result_no_longer_made_is_removed(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    run_notebook(notebook)
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
        ("import os; os._exit(1)", "01_test.ipynb, code cell 2: the kernel died"),
    ],
)
def test_failure_names_the_cell_and_changes_nothing(notebook, last, message):
    write(notebook, RECORD.format(value=1))
    run_notebook(notebook)
    write(notebook, RECORD.format(value=2), last)
    before = files(notebook)
    with pytest.raises(NotebookFailed, match=message):
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


def test_interruption_changes_nothing(notebook):
    write(notebook, RECORD.format(value=1), DRAW)
    run_notebook(notebook)
    write(notebook, RECORD.format(value=2), DRAW, "import time; time.sleep(60)")
    before = files(notebook)
    code = (
        "import sys; from pathlib import Path; from report.execute import run_notebook;"
        "run_notebook(Path(sys.argv[1]))"
    )
    command = [sys.executable, "-c", code, notebook]
    build = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    staged = notebook.parent.parent / "build" / "01_test" / "figures" / "axes.svg"
    limit = time.monotonic() + 60
    while not staged.exists() and time.monotonic() < limit:
        time.sleep(0.1)
    build.send_signal(signal.SIGINT)
    assert build.wait(30) != 0
    assert staged.exists()
    assert files(notebook) == before


class Task:
    def __init__(self):
        self.value_savers = []


def test_task_is_up_to_date_until_sources_or_results_change():
    state = {"sources": "a", "results": ""}
    check = unchanged(lambda: state["sources"], lambda: state["results"])
    task = Task()
    assert not check(task, {})
    state |= {"sources": "edited while it ran", "results": "b"}
    saved = task.value_savers[0]()
    assert saved == {"sources": "a", "results": "b"}
    assert not check(Task(), saved)
    state["sources"] = "a"
    assert check(Task(), saved)
    state["results"] = "touched by hand"
    assert not check(Task(), saved)


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
