"""Bring the figures, the numbers and the report up to date: `make report`.

Every task is decided by content (report/sources.py): a notebook is left alone when its sources are
those of its last run and its results are still those it left then. `make stale` only says what
would be done, and why.
"""

import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor

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
from report.runs import recover, run_stale, say, told
from report.sources import ROOT, figure_files, notebook_sources, notebooks, records, report_sources
from report.state import State


def main():
    """Build what is stale; return the exit code."""
    with locked("make report"):
        recover(ROOT)
        index, *chapters = notebooks()
        # The index comes last, because it shows what the others recorded.
        if run_stale(chapters, [index]):
            return write_report()
        say("The index and report/report.pdf are left as they were, because of the failure above.")
        return 1


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
        with ThreadPoolExecutor() as pool:
            made = list(pool.map(lambda name: compile_report(name=name), DOCUMENTS))
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
    contents = {PDFS[name]: pdf for name, pdf in zip(DOCUMENTS, made, strict=True)}
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


if __name__ == "__main__":
    code = told(tell_stale if sys.argv[1:] == ["stale"] else main)
    os._exit(code)  # at once: other threads may still wait for kernels, which end with us
