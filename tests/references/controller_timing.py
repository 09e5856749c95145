"""Write controller_timing.csv: scans of the exported motion generator, on time and starved.

    python -m tests.references.controller_timing

Needs a C compiler. The reference job runs twice. In the second run the slow task pauses for four
seconds. Each row is a scan: how much time is scaled, ticks that are known ahead, and the speed of
the cutter's set-values in m/s.
"""

import tempfile
from pathlib import Path

import numpy as np

from tests.controllers import COMPILER, REALS, Driven, c99_program, job_with, with_program
from tests.references import tables
from tunneller_lib.ream.moves import levers

TABLE = Path(__file__).with_suffix(".csv")
COLUMNS = ["time", "scale", "ahead", "speed", "starved scale", "starved ahead", "starved speed"]
SHOWN = range(900, 2200, 3)  # scans
PAUSE = range(1000, 1800)


def run(path, wanted, made, paused):
    """Return the time scale, the ticks ahead and the speed in m/s of the shown scans."""
    driven = Driven(path)
    c = driven.c
    plan = wanted.planned
    c.nActualTheta, c.nActualPhi = np.rint(plan.entry.setvalues[0] / plan.count).astype(int)
    rows = []
    # Time begins where the slow task does with the run, a call after it is asked for.
    for scan in range(-made.slow, SHOWN.stop):
        if scan % made.slow == 0 and not (paused and scan in PAUSE):
            driven.slow()
        c.bEnable, c.bStart = 1, int(scan > 1 - made.slow)
        driven.fast()
        c.nActualTheta, c.nActualPhi = c.nSetTheta, c.nSetPhi
        at = plan.count * np.array([c.nSetTheta, c.nSetPhi])
        slope = np.array([vars(c)[name] for name in REALS[2:]]) * c.nScale / 2**15
        speed = np.linalg.norm(levers(plan.circuit.machine.torus, at) * slope)
        rows.append([c.nScale / 2**15, c.nAhead, speed])
    driven.close()
    return np.array(rows)[made.slow :][SHOWN]


def rows():
    """Yield the rows of the table."""
    wanted = job_with(controller={"plant": "T0"})
    made = with_program(wanted)
    with tempfile.TemporaryDirectory() as folder:
        path = c99_program(COMPILER, Path(folder), made, "-std=c99", "-O1")
        runs = [run(path, wanted, made, paused) for paused in (False, True)]
    for scan, values in zip(SHOWN, np.concatenate(runs, axis=1), strict=True):
        numbers = [f"{value:.4f}" if k % 3 != 1 else int(value) for k, value in enumerate(values)]
        yield [f"{scan * wanted.planned.tick:.3f}", *numbers]


if __name__ == "__main__":
    tables.write(TABLE, COLUMNS, rows())
