"""Ask `recognise` of thousands of random surfaces, members and near-misses in equal parts.

``python -m tests.audit.recognise_many`` writes recognised.csv, a row for each kind of surface, with
how many got which verdict; `make long` asks as many others. Windows are of 1e-8 to 1 and scales of
1e-3 to 1e3, and the tools' sizes are not given.
"""

import csv
import sys
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np

from tests.audit.long import judged
from tests.envelopes_random import KINDS, member, near_miss, placed, window
from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.adapted import FLAT, adapted_frames
from tunneller_lib.envelopes.recognition import LEAST_POINTS

TABLE = Path(__file__).with_name("recognised.csv")
SEEDS = 420  # of members, and of near-misses, for each of the six classes
PART = 20  # of them at a time
PARABOLIC = 1e-3  # |K|/|II|^2 of a point that lies near a parabolic curve
HEAD = ("class", "surface", "near parabolic", "is", "is not", "cannot tell")


def tried(kind, exact, seed, smallest=-8):
    """Return which surface a seed makes, whether some point is near parabolic, and the verdict.

    Its window is of 10^smallest to 1.
    """
    rng = np.random.default_rng((seed, KINDS.index(kind), exact))
    scale = 10.0 ** rng.uniform(-3, 3)
    size = 10.0 ** rng.uniform(smallest, 0)
    surface, way = (member if exact else near_miss)(kind, rng)
    points = window(surface, rng, size)
    way = "member" if exact else str(way)
    surface = placed(surface, rng, scale)
    least = np.sort(adapted_frames(surface, *points, "space").curvature)
    if least[-LEAST_POINTS] <= FLAT and kind not in ("developable", "ruled"):
        return way, True, "cannot tell"  # too few points have planes that turn: it's refused
    found = recognise(surface, *points, kind, model="space")
    return way, bool(least[0] < PARABOLIC), found.verdict


def several(kind, exact, first):
    return Counter(tried(kind, exact, seed) for seed in range(first, first + PART))


def main():
    asked = [(kind, exact, first) for first, kind, exact in
             product(range(0, SEEDS, PART), KINDS, (True, False))]  # fmt: skip
    counts = defaultdict(Counter)
    with ProcessPoolExecutor() as pool:
        parts = pool.map(several, *zip(*asked, strict=True))
        for (kind, _, _), part in zip(asked, parts, strict=True):
            counts[kind] += part
    rows = [HEAD]
    for kind, part in counts.items():
        for way, near in sorted({(way, near) for way, near, _ in part}):
            rows.append([kind, way, near, *(part[way, near, verdict] for verdict in HEAD[3:])])
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# {sum(sum(row[3:]) for row in rows[1:])} surfaces, {judged()}\n")
        csv.writer(file, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    sys.exit(main())
