"""Time every slider of every drawing in JupyterLab: `make sliders`; tests/sliders.md keeps it.

A notebook isn't run to its end for that: its sliders alone are, with what they need, as the pages
that run have them. Scenes are left out. With names of notebooks only these are timed, and nothing
is kept.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import nbformat
from chromium import Browser
from lab import started

from report.execute import METADATA
from report.live.program import programs
from report.sources import ROOT, notebooks

TABLE = ROOT / "tests" / "sliders.md"
MOVES = 9


def drawings(notebook):
    """Return the programs of a notebook's sliders that draw no scene."""
    return [program for program in programs(notebook) if not program.draws_scene]


def timed(lab, notebook):
    """Yield the number of the cell and, by slider, two times in ms, of each drawing.

    The median from the key to the new picture, and what processors worked in the kernel for a move.
    """
    found = drawings(notebook)
    cells = [nbformat.v4.new_code_cell(program.source) for program in found]
    alone = f"notebooks/{notebook.stem}_sliders.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata=METADATA), lab.root / alone)
    lab.open(alone)
    lab.start()
    assert lab.finish() == []
    which = 0
    for program, words in zip(found, lab.sliders(), strict=True):
        taken = {}
        for word in words:
            before = lab.processor_seconds()
            clock = median(lab.move(MOVES, which))
            taken[word] = 1000 * clock, 1000 * (lab.processor_seconds() - before) / MOVES
            which += 1
        yield program.cell, taken
    assert lab.errors() == []
    lab.close()


def main():
    chosen = [n for n in notebooks() if n.stem in sys.argv[1:] or not sys.argv[1:]]
    commit = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.run(commit, cwd=ROOT, text=True, capture_output=True).stdout.strip()
    rows, slowest, loads = [], 0.0, []
    with tempfile.TemporaryDirectory() as place:
        (profile := Path(place, "profile")).mkdir()
        (study := Path(place, "study")).mkdir()
        browser = Browser(profile)
        try:
            with started(browser, study) as lab:
                for notebook in filter(drawings, chosen):
                    for cell, taken in timed(lab, notebook):
                        loads.append(os.getloadavg()[0])
                        said = ", ".join(
                            f"{word}: {ms:.0f} ({own:.0f})" for word, (ms, own) in taken.items()
                        )
                        rows.append(f"| {notebook.stem} | {cell} | {said} |")
                        slowest = max(slowest, *(ms for ms, _ in taken.values()))
                        print(rows[-1], flush=True)
        finally:
            browser.close()
    if not sys.argv[1:]:
        lines = [
            "# How long a drawing takes in JupyterLab after its slider was moved",
            "",
            f"`make sliders` on {time.strftime('%F')} at {commit}, headless Chromium, "
            f"{len(os.sched_getaffinity(0))} cores with a load of {min(loads):.1f} to "
            f"{max(loads):.1f}: at most {slowest:.0f} ms. Each is the median of {MOVES} moves, "
            "from the key to the new picture; in parentheses, what the kernel's processor worked.",
            "",
            "| notebook | cell | slider: ms |",
            "| --- | --- | --- |",
            *rows,
        ]
        TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
