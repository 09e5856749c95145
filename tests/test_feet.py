"""The four tangent-sphere feet against mpmath."""

import csv

import numpy as np
import pytest
from mpmath import mp

from tests.audit.long import many
from tests.references import torus_feet
from tests.shapes import directions, random_tori
from tunneller_lib.surfaces import Torus

READS = ["tests/references/*"]

with open(torus_feet.TABLE, newline="") as file:
    HEADER, *ROWS = csv.reader(file)
FAMILIES = sorted({row[0] for row in ROWS})


def relative_error(found, expected):
    return np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)


@pytest.mark.parametrize("family", FAMILIES)
def test_feet_against_references(family):
    numbers = np.array([row[1:] for row in ROWS if row[0] == family], dtype=float)
    assert len(numbers) == 40
    found = np.array([Torus(r, R).feet(m) for r, R, *m in numbers[:, :5]])
    assert relative_error(found, numbers[:, 5:].reshape(-1, 4, 3)).max() <= 1e-13


def test_references_are_what_their_script_writes():
    assert HEADER == torus_feet.COLUMNS
    with mp.workdps(50):
        for _, r, R, *numbers in ROWS:
            m, printed = map(float, numbers[:3]), numbers[3:]
            again = torus_feet.feet(float(r), float(R), list(m))
            assert [mp.nstr(c, 20) for n in again for c in n] == printed


@pytest.mark.parametrize("seed", range(4))
def test_feet_against_mpmath(seed):
    rng = np.random.default_rng(seed)
    tori, points = random_tori(rng, 625), many(3, 40)
    far = 10 ** rng.uniform(-2, 6, (len(tori), points, 1))
    m = far * np.array([torus.r + torus.R for torus in tori])[:, None, None]
    m = m * directions(rng, len(tori) * points).reshape(len(tori), points, 3)
    found = np.array([torus.feet(near) for torus, near in zip(tori, m, strict=True)])
    with mp.workdps(30):
        expected = [
            torus_feet.feet(t.r, t.R, p)
            for t, near in zip(tori, m.tolist(), strict=True)
            for p in near
        ]
        expected = np.reshape(np.array(expected, dtype=float), found.shape)
    assert found.shape == (len(tori), points, 4, 3)
    assert relative_error(found, expected).max() <= 1e-13


@pytest.mark.parametrize("exponent", [-3, -6, -9, -12])
def test_feet_of_nearly_horn_tori(exponent):
    rng, count = np.random.default_rng(-exponent), many(400, 8_000)
    tori = [Torus(1.0, 1.0 + sign * 10.0**exponent) for sign in rng.choice([-1, 1], count)]
    m = rng.uniform(0, 3, (count, 1)) * directions(rng, count)
    found = np.array([torus.feet(point) for torus, point in zip(tori, m, strict=True)])
    with mp.workdps(40):
        expected = [torus_feet.feet(t.r, t.R, p) for t, p in zip(tori, m.tolist(), strict=True)]
        expected = np.array(expected, dtype=float)
    assert relative_error(found, expected).max() <= 1e-13
