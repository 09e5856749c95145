"""Waypoints in Structured Text for a controller that gets its knots as it goes, run.

They are the library's corrected chord. Their cost is measured by references/controller_cycles.py.
"""

import ctypes

import numpy as np
import pytest

from tests.references import tables
from tests.references.controller_cycles import WAYPOINTS, waypoints_c99
from tests.references.waypoint_operations import COLUMNS, TABLE, rows, waypoints
from tests.test_export import built, compilers
from tunneller_lib.paths import corrected_chord
from tunneller_lib.surfaces import REFERENCE_MACHINE

READS = ["tests/references/waypoints.st", "tests/references/waypoint_operations.csv"]

MACHINE = REFERENCE_MACHINE
LOW, HIGH = (MACHINE.theta_min, MACHINE.phi_min), (MACHINE.theta_max, MACHINE.phi_max)
COUNT = 2 * np.pi / 2**16
CHORD = 352  # operations of the projected chord's 32 waypoints, see notebooks/11_rivals.ipynb


def pairs(n):
    """Return random pairs, the opposite corners, a meridian, ends close together."""
    p, q = np.random.default_rng(8).uniform(LOW, HIGH, (2, n, 2))
    p[0], q[0] = LOW, HIGH
    p[1], q[1] = (0.2, -0.5), (0.2, 0.6)
    p[2], q[2] = (0.2, 0.5), (0.2, 0.5)
    p[3], q[3] = (0.2, 0.5), (0.2 + 3e-6, 0.5 - 3e-6)
    p[4], q[4] = (0.2, 0.5), (0.2 + 3e-5, 0.5 - 3e-5)
    p[5], q[5] = (-0.2, 0.0), (0.5, 0.0)
    return p, q


def in_structured_text(points, p, q):
    """Return waypoints (n, points, 2) of pairs."""
    block = waypoints(points)
    found = []
    for (thetaP, phiP), (thetaQ, phiQ) in zip(p.tolist(), q.tolist(), strict=True):
        block(ring=MACHINE.r, tube=MACHINE.R, thetaP=thetaP, phiP=phiP, thetaQ=thetaQ, phiQ=phiQ)
        found.append(np.transpose([block.state["theta"], block.state["phi"]]))
    return np.array(found)


@pytest.mark.parametrize("points", [5, 9, 32])
def test_structured_text_agrees_to_a_tenth_of_a_count(points):
    p, q = pairs(40)
    found = in_structured_text(points, p, q)
    assert np.max(np.abs(found - corrected_chord(MACHINE.torus, p, q, points))) < COUNT / 10
    np.testing.assert_allclose(found[:, 0], p, atol=1e-14)
    np.testing.assert_allclose(found[:, -1], q, atol=1e-13)


def test_difference_falls_with_the_fourth_power_of_the_waypoints():
    p, q = pairs(60)
    worst = [np.max(np.abs(in_structured_text(n, p, q) - corrected_chord(MACHINE.torus, p, q, n)))
             for n in (9, 17, 33)]  # fmt: skip
    assert np.all(np.abs(np.log2(np.divide(worst[:-1], worst[1:])) - 4) < 0.1)


@compilers
def test_c_agrees_to_a_tenth_of_a_count(tmp_path, compiler):
    fill = built(compiler, tmp_path, waypoints_c99(9) + WAYPOINTS).waypoints
    fill.argtypes = [ctypes.c_double] * 6 + [ctypes.c_void_p] * 2
    p, q = pairs(2_000)
    found = np.empty((len(p), 2, 9))
    for (theta, phi), *ends in zip(found, p, q, strict=True):
        fill(MACHINE.r, MACHINE.R, *np.ravel(ends), theta.ctypes.data, phi.ctypes.data)
    true = corrected_chord(MACHINE.torus, p, q, 9)
    assert np.max(np.abs(found.swapaxes(1, 2) - true)) < COUNT / 10


def test_operations_are_those_of_a_run_and_at_most_six_times_the_chord_s():
    counted = list(rows())
    assert tables.read(TABLE) == (COLUMNS, [list(map(str, row)) for row in counted])
    assert counted[-1] == [32, 1514, 103, 144] and sum(counted[-1][1:]) <= 6 * CHORD
