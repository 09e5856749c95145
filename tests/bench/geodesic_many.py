"""Shortest geodesics between millions of pairs, block by block: memory stays that of one block.

python -m tests.bench.geodesic_many PAIRS

The blocks go to the local cores; each is summed up where it is made. A run that was interrupted
goes on from where it stopped.

100,000,000 pairs on two cores (2026-11-24, Python 3.11, numba 0.68.1; other programs ran beside, a
load of 6 to 8, and this one at a low priority): a process held 217 MB in the first half of the 400
blocks and 217 MB in the second, and the run took 512 s on the clock.
"""

import resource
import sys
import time

import numpy as np

from exhibits.sweep import compute_blocks
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE as MACHINE

BLOCK = 250_000
FOLDER = "build/geodesics"


def survey(block):
    """Return what came of a block of random pairs on the machine's sheet.

    Number of answers, sum of the lengths and the greatest, in m; and the most memory that the
    process held so far, in MB.
    """
    low = MACHINE.theta_min, MACHINE.phi_min
    high = MACHINE.theta_max, MACHINE.phi_max
    p, q = np.random.default_rng(block).uniform(low, high, (2, BLOCK, 2))
    found = geodesic_inverse(MACHINE.torus, p, q)
    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return np.array([np.sum(found.converged), np.sum(found.length), np.max(found.length), held])


def main():
    count = -(-int(float(sys.argv[1])) // BLOCK)
    blocks = [(k,) for k in range(count)]
    begin = time.monotonic()
    files = compute_blocks(survey, blocks, FOLDER)
    answers, total, longest, held = np.stack([np.load(file) for file in files]).T
    print(
        f"{count * BLOCK:,} pairs, {answers.sum():,.0f} answers in {time.monotonic() - begin:.0f} s"
    )
    print(f"mean length {total.sum() / answers.sum():.6f} m, longest {longest.max():.6f} m")
    # The first blocks load and compile; the later ones hold no more.
    first, last = np.array_split(held, 2)
    print(f"a process held {first.max():.0f} MB in the first half, {last.max():.0f} in the second")


if __name__ == "__main__":
    main()
