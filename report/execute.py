"""Run one notebook and put what it made into place."""

import os
import shutil
import subprocess

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

from report.sources import SCENES, cells, figure_files, records, scene_files

CELL_TIMEOUT = 120  # s
# What JupyterLab would write, without the version of Python: the same on every machine.
METADATA = {
    "kernelspec": {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"},
    "language_info": {
        "codemirror_mode": {"name": "ipython", "version": 3},
        "file_extension": ".py",
        "mimetype": "text/x-python",
        "name": "python",
        "nbconvert_exporter": "python",
        "pygments_lexer": "ipython3",
    },
}


class NotebookFailed(Exception):
    """A notebook that didn't run to its end; the message says where and why."""


def run_notebook(notebook):
    """Execute a notebook beside its place, then move it and its results there.

    Everything is made under build/ first, so an interruption leaves the old results whole.
    """
    root = notebook.parent.parent
    staging = root / "build" / notebook.stem
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir(parents=True)
    written = cells(notebook)
    content = execute(notebook, staging)
    if cells(notebook) != written:
        raise NotebookFailed(f"{notebook.name} was edited while it ran: build again.")
    executed = staging / notebook.name
    nbformat.write(content, executed)
    publish(notebook, staging)
    os.replace(executed, notebook)
    shutil.rmtree(staging)


def execute(notebook, staging):
    """Return a notebook with its outputs, its results left in a folder."""
    content = nbformat.read(notebook, as_version=4)
    reached = []
    client = NotebookClient(
        content,
        kernel_name="python3",
        timeout=CELL_TIMEOUT,
        record_timing=False,
        coalesce_streams=True,  # prints that arrive in two pieces are stored as one
        on_cell_start=lambda cell, cell_index: reached.append(cell_index),
        resources={"metadata": {"path": str(notebook.parent)}},
    )
    try:
        places = {
            "TUNNELLER_RESULTS": str(staging),
            "TUNNELLER_SCENES": str(staging / SCENES / notebook.stem),
        }
        # What a notebook says on stderr is among its outputs; the rest is about kernels' sockets.
        client.execute(env=os.environ | places, stderr=subprocess.DEVNULL)
    except (CellExecutionError, CellTimeoutError, DeadKernelError) as error:
        place = f"{notebook.name}, code cell {len(reached)}"
        raise NotebookFailed(f"{place}: {reason(error)}") from error
    content.metadata = nbformat.from_dict(METADATA)
    for cell in content.cells:
        cell.metadata.pop("execution", None)
    return content


def reason(error):
    if isinstance(error, CellExecutionError):
        return f"{error.ename}: {error.evalue}"
    if isinstance(error, CellTimeoutError):
        return f"no answer within {CELL_TIMEOUT} s"
    return "the kernel died (is the off-screen GL library there?)"


def publish(notebook, staging):
    """Move new results into place, file by file, and remove those no longer made."""
    root = notebook.parent.parent
    old = {records(notebook)[0], *figure_files(notebook), *scene_files(notebook)}
    made = [
        path for path in sorted(staging.rglob("*")) if path.is_file() and path.parent != staging
    ]
    new = [root / path.relative_to(staging) for path in made]
    for source, target in zip(made, new):
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(source, target)
    for path in old.difference(new):
        path.unlink(missing_ok=True)
