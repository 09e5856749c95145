"""Ask `recognise_measured` of hundreds of random surfaces, members and near-misses in equal parts.

``python -m tests.measured_many`` writes tests/measured.csv: how many got which verdict by the noise
of their normals, through 2,000 exact contacts, and once through contacts that are off as well. The
tools' sizes are not given.
"""

import csv
import sys
from collections import Counter
from datetime import date
from pathlib import Path

import numpy as np

from tests.envelopes_random import KINDS, member, near_miss, placed
from tunneller_lib.envelopes import fit_surface, hyperosculating_cones, recognise_measured
from tunneller_lib.envelopes.adapted import adapted_frames
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.fit import tilted
from tunneller_lib.envelopes.isotropic import normal, surface_points

TABLE = Path(__file__).with_name("measured.csv")
PLANES = 2000
# Noise of the normals, that of the contacts over the patch's size, and how many draws.
ASKED = ((1e-4, 0.0, 500), (1e-6, 0.0, 300), (1e-6, 1e-6, 120))
HEAD = ("normals", "contacts", "surface", "is", "is not", "cannot tell")


def measured(surface, rng):
    """Return 2,000 points of a patch of a surface, of random size, and unit normals there."""
    size = rng.uniform(0.3, 1)
    while True:
        middle = rng.uniform(-0.5, 0.5, (2, 1))
        s, t = middle + size * rng.uniform(-0.5, 0.5, (2, PLANES))
        found = adapted_frames(surface, s, t, "space")
        n = found.axes[:, 2]
        if np.min(n @ n.mean(axis=0)) > 0.1:  # else it turns back at its edge of regression
            return found.contact, n
        size = size / 2


def tried(seed, turn, off):
    """Return whether a seed makes a member, of which class, and what is found from noisy data."""
    kind = KINDS[seed // 2 % len(KINDS)]
    exact = seed % 2 == 0
    rng = np.random.default_rng((seed, 24))
    surface, _ = (member if exact else near_miss)(kind, rng)
    contact, n = measured(placed(surface, rng, 10.0 ** rng.uniform(-3, 3)), rng)
    error = off * np.ptp(contact, axis=0).max()
    contact = contact + error * rng.normal(size=(PLANES, 1)) * n
    found = recognise_measured(
        contact, tilted(n, turn, rng), kind, contact_error=error, normal_error=turn / np.sqrt(2)
    )
    return exact, kind, found


def example_32(place, seed, turn=0.1, planes=1400):
    """Return the exact cones of 30 degrees at a place and those found from noisy planes."""
    place = np.array(place)
    rng = np.random.default_rng(seed)
    angle, reach = rng.uniform(0, 2 * np.pi, planes), np.sqrt(rng.random(planes))
    reach = reach * np.hypot(*place) / 4
    x, y = place[:, None] + reach * np.array([np.cos(angle), np.sin(angle)])
    n = tilted(np.stack(normal(x, y), axis=-1), turn, rng)
    fit = fit_surface(surface_points(cyclide, x, y), n, contact_error=0, normal_error=turn / 2**0.5)
    exact = hyperosculating_cones(cyclide, *place, half_angle=np.pi / 6)
    here = fit.axes[:2] @ (exact.contact[0] - fit.origin)
    found = hyperosculating_cones(fit.surface, *here, half_angle=np.pi / 6, model="space")
    return exact, found


def main():
    rows = [HEAD]
    for turn, off, draws in ASKED:
        found = [tried(seed, turn, off) for seed in range(draws)]
        for exact in (True, False):
            counts = Counter(answer.verdict for is_one, _, answer in found if is_one == exact)
            name = "member" if exact else "near-miss"
            rows.append([turn, off, name, *(counts[verdict] for verdict in HEAD[3:])])
            print(rows[-1], flush=True)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# {PLANES} planes each, {date.today()}\n")
        csv.writer(file, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    sys.exit(main())
