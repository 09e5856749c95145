"""Bring the figures, the numbers and the report up to date: `make report`.

Every task is decided by content (report/sources.py): a notebook is left alone when its sources are
those of its last run and its results are still those it left then. `make stale` only says what
would be done, and why. What runs notebooks and compiles takes seconds to import: it is imported
where there is something to do.
"""

import os
import shutil
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

from report.lists import (
    FIGURE_LIST,
    MOVING,
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
from report.state import State, replace

DOCUMENTS = ("report", "supplement", "corrigenda")
PDFS = {name: ROOT / "report" / f"{name}.pdf" for name in DOCUMENTS}
PDF = PDFS["report"]
USUAL = 10.0  # s that a notebook may take of which nothing is known


class Progress:
    """Lines that say how many notebooks are done, and how long the rest may take."""

    def __init__(self, seconds):
        self.left, self.done = dict(seconds), 0
        self.count, self.all = len(seconds), sum(seconds.values())
        self.lock, self.begun = threading.Lock(), time.monotonic()

    def end(self, name, text):
        """Say how the notebook `name` ended."""
        with self.lock:
            self.done += 1
            del self.left[name]
            passed, left = time.monotonic() - self.begun, sum(self.left.values())
            rest = passed * left / max(self.all - left, 1e-9)
            more = f"; about {_duration(rest)} left" if self.left else ""
            say(f"{self.done:2} of {self.count}  {text}{more}")


def main():
    """Build what is stale; return the exit code."""
    with locked("make report"):
        recover(ROOT)
        return write_report() if run_notebooks() else 1


def recover(root):
    """Finish what a build that was killed had come to the end of, and remove what it hadn't."""
    shutil.rmtree(root / "build" / "staging", ignore_errors=True)
    for place in sorted((root / "build" / "ready").glob("*")):
        from report.execute import publish

        try:
            publish(place)
        except (OSError, ValueError, KeyError):  # not left by us: what it belonged to is run again
            shutil.rmtree(place, ignore_errors=True)


def run_notebooks():
    """Run the notebooks that are stale, the longest first; tell whether all is well.

    The index comes last, for it shows what the others recorded.
    """
    index, *chapters = notebooks()
    sources = {notebook: notebook_sources(notebook) for notebook in chapters}
    stale = [n for n in chapters if State(ROOT, n.stem).stale(sources[n])]
    stale = without_scenes_that_cannot_be_drawn(stale)
    seconds = {n: State(ROOT, n.stem).seconds or USUAL for n in stale}
    progress = Progress(seconds | {index: State(ROOT, index.stem).seconds or USUAL})
    stale.sort(key=seconds.get, reverse=True)
    with shared_imports_of(stale):
        # The work is done in the kernels' own processes. Ctrl-C isn't to wait for their end.
        pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
        ended = list(pool.map(lambda n: run(n, sources[n], progress), stale))
        pool.shutdown()
    if not all(ended):
        say("The index and report/report.pdf are left as they were, because of the failure above.")
        return False
    sources = notebook_sources(index)
    if State(ROOT, index.stem).stale(sources):
        return run(index, sources, progress)
    if stale:
        progress.end(index, f"{index.stem} is up to date")
    return True


def shared_imports_of(stale):
    """Return a context for notebooks to be run in: more than one share what they import."""
    if len(stale) < 2:
        return nullcontext()
    from report.kernels import shared_imports

    return shared_imports()


def run(notebook, sources, progress):
    """Run a notebook and say how that ended; tell whether it is well."""
    from report.execute import NotebookFailed, run_notebook

    begun = time.monotonic()
    try:
        kept = run_notebook(notebook, sources)
    except NotebookFailed as error:
        progress.end(notebook, f"failed: {error}")
        return False
    said = f"{notebook.stem}, {time.monotonic() - begun:.1f} s"
    if kept:
        said += f" (unchanged, because the new ones differ in last bits only: {', '.join(kept)})"
    progress.end(notebook, said)
    return True


def without_scenes_that_cannot_be_drawn(stale):
    """Return which notebooks can be run: without a GL library those that draw no scene."""
    scenes = [notebook for notebook in stale if draws_scenes(notebook)]
    if scenes:
        from kit import gl

        if said := gl.problem():
            say(f"{said} {len(scenes)} notebooks draw some: they stay as they are committed.")
            return [notebook for notebook in stale if notebook not in scenes]
    return stale


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
    from report.site.front import moving_file

    lists = {FIGURE_LIST: figure_list(), RECORD_LIST: record_list(), VERDICT_LIST: verdict_list()}
    lists[MOVING] = moving_file()
    # The README is somebody's text with findings in it, which they may edit meanwhile.
    replace(README, with_findings(README.read_text(encoding="utf-8")).encode())
    contents = {PDFS[name]: pdf for name, pdf in made.items()}
    contents |= {path: text.encode() for path, text in lists.items()}
    seconds = time.monotonic() - begun
    publish_files("report", contents, sources, seconds, ROOT)
    say(f"report/report.pdf, {seconds:.1f} s")
    return 0


def tell_stale():
    """Say what a build would do, and why; it changes nothing."""
    reasons = {n: State(ROOT, n.stem).stale(notebook_sources(n)) for n in notebooks()}
    for notebook in filter(reasons.get, reasons):
        say(f"{notebook.stem}: {reasons[notebook]}")
    number = sum(map(bool, reasons.values()))
    say(f"{number} of {len(reasons)} notebooks would be run (and the index, if numbers change).")
    if reason := State(ROOT, "report").stale(report_sources()):
        say(f"report/report.pdf would be written: {reason}.")
    elif not number:
        say("report/report.pdf is up to date.")
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


def _duration(seconds):
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


def told(task):
    """Return the exit code of a task, which says in one sentence what stops it."""
    try:
        return task()
    except KeyboardInterrupt:
        print("Interrupted; the next build goes on from here.", file=sys.stderr, flush=True)
        os._exit(130)  # at once: the threads wait for kernels, which end when we are gone
    except OSError as error:
        where = f" ({error.filename})" if error.filename else ""
        print(
            f"The build stopped: {error.strerror}{where}. What was there is whole; "
            "the next build goes on from here.",
            file=sys.stderr,
        )
        return 1


if __name__ == "__main__":
    sys.exit(told(tell_stale if sys.argv[1:] == ["stale"] else main))
