"""Notebooks that are run again, each by itself: what failed, or was killed, changes nothing.

Modules that run notebooks take seconds to import, so they are imported only where one is stale.
"""

import os
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack

from report.sources import ROOT, draws_scenes, notebook_sources
from report.state import NotebookFailed, State


def recover(root):
    """Move into place what a killed build had finished, and remove what it hadn't."""
    shutil.rmtree(root / "build" / "staging", ignore_errors=True)
    for place in sorted((root / "build" / "ready").glob("*")):
        from report.execute import publish

        try:
            publish(place)
        except (OSError, ValueError, KeyError):  # damaged: its notebook is run again
            shutil.rmtree(place, ignore_errors=True)


def run_stale(*groups):
    """Run the stale ones of each group of notebooks, in this order; tell whether all is well."""
    with ExitStack() as shared:
        for group in groups:
            # A later group may show what an earlier one has recorded.
            sources = {notebook: notebook_sources(notebook) for notebook in group}
            stale = drawable([n for n in group if State(ROOT, n.stem).stale(sources[n])])
            if len(stale) > 1:
                from report.kernels import shared_imports

                shared.enter_context(shared_imports())
            if not run_all(stale, sources):
                return False
    return True


def run_all(chosen, sources):
    """Run notebooks, whose sources are given, side by side; tell whether all is well."""
    # The work is done in the kernels' own processes.
    pool, failed = ThreadPoolExecutor(len(os.sched_getaffinity(0))), 0
    try:
        # The later ones take longer. If they begin first, no processor waits for one at the end.
        futures = [pool.submit(run, notebook, sources[notebook]) for notebook in reversed(chosen)]
        for number, future in enumerate(as_completed(futures), 1):
            try:
                text = future.result()
            except NotebookFailed as error:
                text, failed = f"failed: {error}", failed + 1
            say(f"{number:2} of {len(chosen)}  {text}")
    finally:  # an interrupt or a full disk doesn't wait for the other notebooks
        pool.shutdown(wait=False, cancel_futures=True)
    return not failed


def run(notebook, sources):
    """Run a notebook and return a few words about it.

    Raises
    ------
    NotebookFailed
        If it doesn't come to its end.
    """
    from report.execute import run_notebook

    begun = time.monotonic()
    kept = run_notebook(notebook, sources)
    same = " (unchanged, because the new ones differ in last bits only: {})"
    said = f"{notebook.stem}, {time.monotonic() - begun:.1f} s"
    return said + (same.format(", ".join(kept)) if kept else "")


def drawable(chosen):
    """Return the notebooks that can be run: without a GL library, those that draw no scene."""
    scenes = [notebook for notebook in chosen if draws_scenes(notebook)]
    if scenes:
        from kit import gl

        if said := gl.problem():
            say(f"{said} {len(scenes)} notebooks draw some: they stay as they are committed.")
            return [notebook for notebook in chosen if notebook not in scenes]
    return chosen


def say(text):
    print(text, flush=True)


def told(task):
    """Return the exit code of a task; what stops the task is said in one sentence."""
    try:
        return task()
    except KeyboardInterrupt:
        print("Interrupted; the next build goes on from here.", file=sys.stderr)
        return 130
    except OSError as error:
        where = f" ({error.filename})" if error.filename else ""
        print(
            f"The build stopped: {error.strerror}{where}. Finished notebooks are kept; "
            "the next build goes on from here.",
            file=sys.stderr,
        )
        return 1
