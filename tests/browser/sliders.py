"""Time every slider of every drawing in JupyterLab: `make sliders`.

A notebook isn't run to its end for that: each drawing stands in one of its own, with what it needs,
as the pages that run have them. Scenes are left out. With names of notebooks only these are timed;
the rows of others stay as they are.
"""

import os
import re
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import nbformat
from chromium import Browser, wait
from lab import started

from report.execute import METADATA
from report.live.program import programs
from report.sources import ROOT, notebooks
from tests.audit.long import git

TABLE = ROOT / "tests" / "audit" / "sliders.md"
MOVES = 7
PAUSE = 0.25  # s between two moves: there are a hundred sliders


def drawings(notebook):
    """Return the programs of a notebook's sliders that draw no scene."""
    return [program for program in programs(notebook) if not program.draws_scene]


def timed(lab, notebook):
    """Yield the number of the cell and, by slider, two times in ms, of each drawing.

    The median from the key to the new picture, and what processors worked in the kernel for a move.
    """
    for program in drawings(notebook):
        alone = f"notebooks/{notebook.stem}_{program.cell}.ipynb"
        cell = nbformat.v4.new_code_cell(program.source)
        nbformat.write(nbformat.v4.new_notebook(cells=[cell], metadata=METADATA), lab.root / alone)
        lab.open(alone)
        lab.start()
        assert lab.finish() == []
        [words] = wait(lab.sliders, said="sliders")
        taken = {}
        for which, word in enumerate(words):
            before = lab.processor_seconds()
            clock = median(lab.move(MOVES, which, PAUSE))
            taken[word] = 1000 * clock, 1000 * (lab.processor_seconds() - before) / MOVES
        assert lab.errors() == []
        lab.close()
        yield program.cell, taken


def kept():
    """Return the rows of the table, by notebook and cell."""
    lines = TABLE.read_text(encoding="utf-8").splitlines() if TABLE.exists() else []
    return {tuple(line.split(" | ")[:2]): line for line in lines if re.match(r"\| \d", line)}


def main():
    chosen = [n for n in notebooks() if n.stem in sys.argv[1:] or not sys.argv[1:]]
    commit = git("describe", "--always", "--dirty")
    stems = {f"| {notebook.stem}" for notebook in chosen}
    rows = {key: row for key, row in kept().items() if key[0] not in stems}
    with tempfile.TemporaryDirectory() as place:
        (profile := Path(place, "profile")).mkdir()
        (study := Path(place, "study")).mkdir()
        browser = Browser(profile)
        try:
            with started(browser, study) as lab:
                for notebook in filter(drawings, chosen):
                    for cell, taken in timed(lab, notebook):
                        said = ", ".join(f"{w}: {a:.0f} ({b:.0f})" for w, (a, b) in taken.items())
                        when = f"{time.strftime('%F')}, {commit}, {os.getloadavg()[0]:.1f}"
                        row = f"| {notebook.stem} | {cell} | {said} | {when} |"
                        rows[f"| {notebook.stem}", str(cell)] = row
                        print(row, flush=True)
        finally:
            browser.close()
    lines = [
        "# How long a drawing takes in JupyterLab after its slider was moved",
        "",
        f"By `make sliders` in headless Chromium on {len(os.sched_getaffinity(0))} cores: of each "
        f"slider the median of {MOVES} moves, in ms from the key to the new picture, and in "
        "parentheses what processors worked in the kernel for one.",
        "",
        "| notebook | cell | slider: ms | date, commit, load |",
        "| --- | --- | --- | --- |",
        *(rows[key] for key in sorted(rows, key=lambda key: (key[0], int(key[1])))),
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
