"""Run one notebook and put all that it made into place, or nothing.

A notebook leaves its results in a folder under build/staging. At its end that folder, with a list
of what it holds, is renamed to build/ready/<notebook>: from then on its results count. They are
moved into place at once, or by the next build if this one is killed meanwhile.
"""

import atexit
import json
import os
import re
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

from report.compare import agree
from report.sources import SCENES, cells, figure_files, file_digests, records, scene_files
from report.state import NotebookFailed, State

CELL_TIMEOUT = 120  # s
LIST = "ready.json"  # in a finished folder: its files, those no longer made, the state to keep
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


def run_notebook(notebook, sources=None):
    """Execute a notebook, then put it and its results into place together.

    Parameters
    ----------
    notebook : pathlib.Path
        In the folder notebooks of a checkout.
    sources : dict of str to str, optional
        What it is made from, to be kept in its state.

    Returns
    -------
    kept : list of str
        Names of results that stay as they were, because the new ones differ in last bits only.

    Raises
    ------
    NotebookFailed
        If a cell fails, or the notebook was edited meanwhile; nothing is changed then.
    """
    root = notebook.parent.parent
    with staging(root, notebook.stem) as folder:
        written = cells(notebook)
        content = execute(notebook, folder)
        if cells(notebook) != written:
            raise NotebookFailed(f"{notebook.name} was edited while it ran: build again.")
        executed = folder / "notebooks" / notebook.name
        executed.parent.mkdir()
        nbformat.write(content, executed)
        kept = keep_what_agrees(folder, root)
        old = {*figure_files(notebook), *scene_files(notebook), records(notebook)[0]}
        place = finish(folder, notebook.stem, old, sources or {})
    publish(place)
    return kept


def publish_files(task, contents, sources, root):
    """Put files of a task into place together, and note its state.

    Parameters
    ----------
    task : str
        Its name.
    contents : dict of pathlib.Path to bytes
        What each file is to hold.
    sources : dict of str to str
        What they are made from, to be kept in the state.
    root : pathlib.Path
        The checkout.
    """
    with staging(root, task) as folder:
        for path, content in contents.items():
            new = folder / path.relative_to(root)
            new.parent.mkdir(parents=True, exist_ok=True)
            new.write_bytes(content)
        place = finish(folder, task, (), sources)
    publish(place)


@contextmanager
def staging(root, task):
    """Give a new folder for a task's results; it is removed unless `finish` has moved it."""
    (root / "build" / "staging").mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix=f"{task}-", dir=root / "build" / "staging"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def finish(folder, task, old, sources):
    """Move a folder of a task's results to build/ready, from where on they count; return it.

    `old` are the files that the task left the last time: those it no longer makes are removed.
    """
    root = folder.parents[2]
    made = file_digests(folder, [path for path in folder.rglob("*") if path.is_file()])
    gone = sorted({str(path.relative_to(root)) for path in old} - made.keys())
    ready = {"results": made, "gone": gone, "sources": sources}
    (folder / LIST).write_text(json.dumps(ready), encoding="utf-8")
    place = root / "build" / "ready" / task
    place.parent.mkdir(exist_ok=True)
    os.replace(folder, place)
    return place


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
        on_cell_execute=lambda cell, cell_index: reached.append(cell_index),
        resources={"metadata": {"path": str(notebook.parent)}},
    )
    try:
        places = {
            "TUNNELLER_RESULTS": str(staging),
            "TUNNELLER_SCENES": str(staging / SCENES / notebook.stem),
        }
        # What a notebook says on stderr is among its outputs; the rest is about kernels' sockets.
        client.execute(env=os.environ | places, stderr=subprocess.DEVNULL)
    except (CellExecutionError, CellTimeoutError, RuntimeError) as error:
        atexit.unregister(client._cleanup_kernel)  # it fails at the end if no kernel started
        place = f", code cell {len(reached)}" if reached else ""
        raise NotebookFailed(f"{notebook.name}{place}: {reason(error)}") from error
    content.metadata = nbformat.from_dict(METADATA)
    for cell in content.cells:
        cell.metadata.pop("execution", None)
    return content


def reason(error):
    if isinstance(error, CellExecutionError):
        plain = re.sub(r"\x1b\[[\d;]*m", "", error.traceback)
        lines = re.findall(r"^-+> \d+ (.*)", plain, re.M)
        return f"{error.ename}: {error.evalue or ' '.join(lines[-1:])}"
    if isinstance(error, CellTimeoutError):
        return f"no answer within {CELL_TIMEOUT} s"
    if isinstance(error, DeadKernelError):
        return "the kernel died"
    return f"the kernel doesn't start ({error})"


def keep_what_agrees(staging, root):
    """Put the results that are there in place of new ones that agree with them; return which."""
    kept = []
    for new in sorted(p for p in staging.rglob("*") if p.is_file()):
        old = root / new.relative_to(staging)
        if agree(old, new) and old.read_bytes() != new.read_bytes():
            shutil.copyfile(old, new)
            kept.append(new.name)
    return kept


def publish(place):
    """Move finished results, a notebook's or others, into place, and note the task's state.

    Parameters
    ----------
    place : pathlib.Path
        A folder of build/ready. Files that its list names and that aren't there were moved by a
        build that was killed. A notebook that was edited since keeps its edits and is run again.
    """
    root = place.parents[2]
    ready = json.loads((place / LIST).read_bytes())
    notebook = root / "notebooks" / f"{place.name}.ipynb"
    executed = place / "notebooks" / notebook.name
    as_run = notebook.exists() and (not executed.exists() or cells(executed) == cells(notebook))
    if as_run or str(notebook.relative_to(root)) not in ready["results"]:
        for name in ready["results"]:
            if (place / name).exists():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                os.replace(place / name, root / name)
        for name in ready["gone"]:
            (root / name).unlink(missing_ok=True)
        State(root, place.name).save(ready["sources"], ready["results"])
    shutil.rmtree(place)
