"""Bring the figures, the numbers and the report up to date: `make report`.

Every task is decided by content (report/sources.py): a notebook is left alone when its sources are
those of its last run and its results are still those it left then. `make stale` only says what
would be done, and why. Modules that run notebooks or compile take seconds to import, so they are
imported only where there is something to do.
"""

import os
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import nullcontext

from report.lists import (
    DOCUMENTS,
    FIGURE_LIST,
    MOVING,
    PDFS,
    README,
    RECORD_LIST,
    VERDICT_LIST,
    figure_list,
    record_list,
    verdict_list,
    with_findings,
)
from report.lock import locked
from report.sources import (
    ROOT,
    draws_scenes,
    figure_files,
    notebook_sources,
    notebooks,
    records,
    report_sources,
)
from report.state import NotebookFailed, State


def main():
    """Build what is stale; return the exit code."""
    with locked("make report"):
        recover(ROOT)
        index, *chapters = notebooks()
        # The index comes last, because it shows what the others recorded.
        if run_stale(chapters) and run_stale([index]):
            return write_report()
        say("The index and report/report.pdf are left as they were, because of the failure above.")
        return 1


def recover(root):
    """Move into place what a killed build had finished, and remove what it hadn't."""
    shutil.rmtree(root / "build" / "staging", ignore_errors=True)
    for place in sorted((root / "build" / "ready").glob("*")):
        from report.execute import publish

        try:
            publish(place)
        except (OSError, ValueError, KeyError):  # damaged: its notebook is run again
            shutil.rmtree(place, ignore_errors=True)


def run_stale(chosen):
    """Run the stale ones among some notebooks; tell whether all is well."""
    sources = {notebook: notebook_sources(notebook) for notebook in chosen}
    stale = drawable([n for n in chosen if State(ROOT, n.stem).stale(sources[n])])
    stale.reverse()  # the later ones take longer: then no processor waits for one at the end
    if not stale:
        return True
    from report.kernels import shared_imports

    # The work is done in the kernels' own processes.
    pool, failed = ThreadPoolExecutor(len(os.sched_getaffinity(0))), 0
    with shared_imports() if len(stale) > 1 else nullcontext():
        try:
            futures = [pool.submit(run, notebook, sources[notebook]) for notebook in stale]
            for number, future in enumerate(as_completed(futures), 1):
                try:
                    text = future.result()
                except NotebookFailed as error:
                    text, failed = f"failed: {error}", failed + 1
                say(f"{number:2} of {len(stale)}  {text}")
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


def write_report():
    """Write the PDFs if they are stale; return the exit code."""
    begun = time.monotonic()
    forget_deleted_notebooks()
    sources, state = report_sources(), State(ROOT, "report")
    if not state.stale(sources):
        say("report/report.pdf is up to date")
        return 0
    from report.compile import ReportFailed, compile_report
    from report.execute import publish_files

    try:
        made = {name: compile_report(name=name) for name in DOCUMENTS}
    except ReportFailed as error:
        say(f"report/report.pdf left as it was: {error}")
        return 1
    from report.site.machine import moving_machine
    from tunneller_lib.atomic_write import replacement

    lists = {FIGURE_LIST: figure_list(), RECORD_LIST: record_list(), VERDICT_LIST: verdict_list()}
    lists[MOVING] = moving_machine()
    # The README is somebody's text with findings in it, which they may edit meanwhile.
    with replacement(README) as new:
        new.write_text(with_findings(README.read_text(encoding="utf-8")), encoding="utf-8")
    contents = {PDFS[name]: pdf for name, pdf in made.items()}
    contents |= {path: text.encode() for path, text in lists.items()}
    publish_files("report", contents, sources, ROOT)
    say(f"report/report.pdf, {time.monotonic() - begun:.1f} s")
    return 0


def tell_stale():
    """Say what a build would do and why, and change nothing; return the exit code."""
    reasons = {n: State(ROOT, n.stem).stale(notebook_sources(n)) for n in notebooks()}
    lines = [f"{notebook.stem}: {reason}" for notebook, reason in reasons.items() if reason]
    number = len(lines)
    lines.append(
        f"{number} of {len(reasons)} notebooks would be run (and the index, if numbers change)."
    )
    if reason := State(ROOT, "report").stale(report_sources()):
        lines.append(f"report/report.pdf would be written: {reason}.")
    elif not number:
        lines.append("report/report.pdf is up to date.")
    try:
        say("\n".join(lines))
    except BrokenPipeError:  # `make stale | head` has seen enough
        os._exit(0)
    return 0


def forget_deleted_notebooks():
    """Remove the results of notebooks that are gone."""
    kept = {file for n in notebooks() for file in (records(n)[0], *figure_files(n))}
    for numbers in (ROOT / "report" / "numbers").glob("*.json"):
        if numbers not in kept:
            gone = figure_files(ROOT / "notebooks" / numbers.name)
            for path in {numbers, *gone} - kept:
                path.unlink(missing_ok=True)


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


if __name__ == "__main__":
    code = told(tell_stale if sys.argv[1:] == ["stale"] else main)
    os._exit(code)  # at once: other threads may still wait for kernels, which end with us
