"""Every chapter about the machine runs with another one, or says in a sentence why it can't.

A reader changes one line of a chapter, ``machine = REFERENCE_MACHINE``; so does this. It takes
five minutes of a processor: ``pytest tests/audit/test_second_machine.py -n 2``.
"""

import json
import os
import subprocess
import sys

import pytest

from report.sources import ROOT, cells, notebooks

LINE = "machine = REFERENCE_MACHINE"
# Another arm, crank, cutter and depth, other limits; it cuts the same section.
OTHER = """\
import numpy as np
from tunneller_lib.surfaces import Machine
machine = Machine(r=0.10, R=0.90, theta_min=-1.0, theta_max=0.55, phi_min=-0.65, phi_max=0.65,
                  cutter_radius=0.22, depth=0.03, height=-0.40)
"""


def code(notebook):
    """Return the source of a notebook's code cells, one after the other."""
    return "\n".join(source for kind, source in cells(notebook) if kind == "code")


CHAPTERS = [notebook for notebook in notebooks() if LINE in code(notebook)]


def test_every_chapter_takes_the_machine_from_one_line():
    named = [n.stem for n in notebooks() if "import" in code(n) and "REFERENCE_MACHINE" in code(n)]
    assert named == [notebook.stem for notebook in CHAPTERS]
    assert all(code(notebook).count(LINE) == 1 for notebook in CHAPTERS)


@pytest.mark.parametrize("notebook", CHAPTERS, ids=lambda notebook: notebook.stem)
def test_chapter_runs_with_another_machine(notebook, tmp_path):
    lines = code(notebook).split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith(LINE))
    lines[at] = OTHER
    shell = (
        "from IPython.core.interactiveshell import InteractiveShell\nInteractiveShell.instance()"
    )
    script = tmp_path / "chapter.py"
    script.write_text("\n".join([shell, *lines]), encoding="utf-8")
    paths = [str(ROOT), str(ROOT / "notebooks")]
    environment = os.environ | {
        "TUNNELLER_RESULTS": str(tmp_path),
        "PYTHONPATH": os.pathsep.join(paths),
        "MPLBACKEND": "agg",
    }
    run = subprocess.run(
        [sys.executable, script], cwd=ROOT / "notebooks", env=environment,
        capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[-2000:]
    stored = json.loads(next((tmp_path / "report" / "numbers").glob("*.json")).read_text())
    assert stored["numbers"]
