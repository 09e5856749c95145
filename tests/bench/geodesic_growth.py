"""Write geodesic_growth.csv: time and memory of geodesic_inverse for 1 to 10,000,000 pairs.

`growth` draws it.

python -m tests.bench.geodesic_growth

Each number of pairs is tried in a process of its own, compiled, on the machine's working sheet.
"""

import csv
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from tests.bench import growth
from tests.bench.conftest import processor
from tunneller_lib.kernels import compiled
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE as MACHINE

TABLE = Path(__file__).with_suffix(".csv")
LOW = MACHINE.theta_min, MACHINE.phi_min
HIGH = MACHINE.theta_max, MACHINE.phi_max
ENOUGH = 0.2  # s of calls for one time


def peak():
    """Return the most memory that this process held so far, in bytes."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measured(n):
    """Return the processor time of a call, in s, and the memory beside its arguments, in bytes."""
    p = np.random.default_rng(0).uniform(LOW, HIGH, (n, 2))
    q = np.random.default_rng(1).uniform(LOW, HIGH, (n, 2))
    compiled.expect(np.inf, "geodesics")
    geodesic_inverse(MACHINE.torus, p[:20], q[:20])
    before = peak()
    found = geodesic_inverse(MACHINE.torus, p, q)
    memory = peak() - before
    del found
    rounds = []
    begin = time.process_time()
    while len(rounds) < 3 or time.process_time() < begin + ENOUGH:
        start = time.process_time()
        geodesic_inverse(MACHINE.torus, p, q)
        rounds.append(time.process_time() - start)
    return min(rounds), memory


def main():
    if len(sys.argv) > 1:
        print(*measured(int(sys.argv[1])))
        return
    about = time.strftime("%F"), processor(), f"Python {platform.python_version()}"
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["pairs", "s", "bytes beside the arguments", *about])
        for power in range(8):
            command = [sys.executable, "-m", "tests.bench.geodesic_growth", str(10**power)]
            out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            seconds, memory = out.split()
            table.writerow([10**power, f"{float(seconds):.3g}", memory])
            print(10**power, seconds, memory)
    growth.write()


if __name__ == "__main__":
    main()
