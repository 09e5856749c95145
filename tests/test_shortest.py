"""The numeric ingredients of the proof that a first arrival is the shortest geodesic.

The proof stands in the report's section on geodesics; each of its steps has a test here.
"""

import numpy as np
import pytest
from scipy.integrate import tanhsinh

from tests.audit.long import many
from tests.shapes import half_swing, ways_of
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.paths.geodesic_root import INSIDE, OUTSIDE, PAST, STEEPEST
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

MACHINE, HORN, NARROW, RING = REFERENCE_MACHINE.torus, Torus(1, 1), Torus(1.05, 1), Torus(3, 1)
SPINDLE = Torus(0.5, 1)
every_torus = pytest.mark.parametrize("torus", [MACHINE, SPINDLE, HORN, NARROW, RING], ids=str)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def constants(torus, n):
    """Return n values of Clairaut's constant of geodesics that swing, ascending, in m."""
    narrow = max(torus.r - torus.R, 0)
    return narrow + (torus.r + torus.R - narrow) * np.linspace(0.001, 1, n)


def pairs(torus, n, seed):
    """Return angles a and b (n,) of ends, |b| <= a, on the sheet."""
    reach = np.pi if torus.r > torus.R else np.arccos(-0.98 * torus.r / torus.R)
    ends = np.random.default_rng(seed).uniform(-reach, reach, (2, n))
    farther = np.abs(ends[0]) > np.abs(ends[1])
    a, b = np.where(farther, ends, ends[::-1])
    return np.abs(a), b * np.sign(a)


# Step 2: half a swing.


@every_torus
@pytest.mark.parametrize("share", [0.01, 0.5, 0.99, 1])
def test_half_swing_is_the_proofs_integral(torus, share):
    r, R, narrow = torus.r, torus.R, max(torus.r - torus.R, 0)
    c = narrow + share * (r + R - narrow)

    def density(x):
        rho = 1 / np.sqrt((np.cos(x) / c) ** 2 + (np.sin(x) / (R + r)) ** 2)
        return np.sqrt(1 + 2 * r / (rho + R - r))

    turned = 2 * R / (R + r) * tanhsinh(density, 0, np.pi / 2, rtol=1e-14).integral
    assert half_swing(torus, c) == pytest.approx(turned, rel=1e-13)


@every_torus
def test_half_swing_turns_less_with_a_greater_constant(torus):
    turned = half_swing(torus, constants(torus, many(500, 2000)))
    assert np.all(np.diff(turned) < 0)
    # The least is that of the outer equator, up to its conjugate point.
    assert turned[-1] == pytest.approx(np.pi / np.sqrt(1 + torus.r / torus.R), rel=1e-14)
    # And the greatest is beyond half a turn, so that every end is reached.
    node = half_swing(torus, max(torus.r - torus.R, 0) + 1e-12 * torus.R)
    if torus.r < torus.R:
        assert node == pytest.approx(np.pi / np.sqrt(1 - (torus.r / torus.R) ** 2), rel=1e-10)
    assert node > np.pi


# Step 3: each turned angle belongs to one first arrival.


@every_torus
def test_first_arrivals_turn_the_farther_the_greater_the_unknown(torus):
    for a, b in zip(*pairs(torus, many(3, 8), seed=0), strict=True):
        meridian = np.sqrt((torus.r / torus.R + np.cos(a)) / 2)
        X = np.cos(a / 2) if torus.r >= torus.R else meridian
        low = -meridian * (STEEPEST if torus.r > 0.9 * torus.R else 1)
        u = np.concatenate([low * np.linspace(0.999, 0.002, 50), X * np.linspace(0.002, 8, 50)])
        c, turned, rate, length = ways_of(OUTSIDE, torus, a, b, u)
        assert np.all(np.diff(turned) > 0) and np.all(rate > 0)
        assert turned[0] < 0.3 and turned[-1] > 3.1
        # Step 4: from one to the next the length grows by c times the turned angle. Between the
        # two halves, where c is greatest, is rho_a.
        c = np.insert(c, 50, torus.r + torus.R * np.cos(a))
        least, most = (np.delete(f(c[:-1], c[1:]), 50) for f in (np.minimum, np.maximum))
        slack = 1e-13 * (torus.r + torus.R) * np.maximum(turned[1:], 1)
        assert np.all(np.diff(length) >= least * np.diff(turned) - slack)
        assert np.all(np.diff(length) <= most * np.diff(turned) + slack)


# Step 5: later arrivals are longer.


@every_torus
def test_later_arrivals_are_longer_than_the_first(torus):
    a, b = pairs(torus, many(130, 600), seed=2)
    u = np.random.default_rng(3).normal(-0.5, 0.6, a.size) * np.cos(a / 2)
    ways = [ways_of(PAST, torus, *row[:2], row[2:]) for row in np.stack([a, b, u], axis=-1)]
    _, turned, _, length = np.concatenate(ways, axis=1)
    near = turned <= np.pi
    assert np.sum(near) > 10 or torus.r < torus.R
    # Where the half turn is too near for a second arrival, on spindles, there are none to compare.
    a, b, turned, length = (values[near] for values in (a, b, turned, length))
    p, q = np.stack([0 * a, a], axis=-1), np.stack([turned, b], axis=-1)
    first = geodesic_inverse(torus, p, q)
    assert np.all(first.length < length * (1 + 1e-13))
    assert np.all(first.certificate == "first")
    assert np.all(turned > np.pi / np.sqrt(1 + torus.r / torus.R))


@pytest.mark.parametrize("ratio", [0.9, 1, 3, 30])
def test_past_the_conjugate_point_the_equator_is_longer(ratio):
    torus = Torus(ratio, 1)
    turn = np.pi * np.linspace(1 / np.sqrt(1 + ratio) + 1e-3, 1, 50)
    found = geodesic_inverse(torus, (0, 0), np.stack([turn, 0 * turn], axis=-1))
    assert np.all(found.length < (torus.r + torus.R) * turn)


# Step 6: through a node.


@pytest.mark.parametrize("torus", [MACHINE, SPINDLE, HORN], ids=str)
def test_no_way_into_a_node_and_back_is_shorter(torus):
    # In the limit the way is along two meridians: longer than any first arrival of less turn.
    a, b = pairs(torus, 500, seed=1)
    node = np.arccos(-torus.r / torus.R)
    for turn in (0.5, 2, np.pi):
        p, q = np.stack([0 * a, a], axis=-1), np.stack([0 * a + turn, b], axis=-1)
        assert np.all(geodesic_inverse(torus, p, q).length < torus.R * (2 * node - a - b))


def polyline(points):
    return np.sum(np.linalg.norm(np.diff(points, axis=0), axis=-1))


@pytest.mark.parametrize("p, q", [((0, 3), (1, -3)), ((0, 2), (3, -1.7)), ((-1, -2.9), (2, 3.1))])
def test_through_the_node_of_a_horn_there_is_a_way_that_leaves_on_the_other_side(p, q):
    # Both arcs lie on the surface, from the points alone: their length is that of polygons.
    t = np.linspace(0, 1, 2001)[:, None] ** [1, 1]
    arcs = [
        HORN.point(end[0], end[1] + (np.copysign(np.pi, end[1]) - end[1]) * t[:, 0])
        for end in (p, q)
    ]
    np.testing.assert_allclose([arc[-1] for arc in arcs], 0, atol=1e-15)  # they meet
    found = geodesic_inverse(HORN, p, q)
    assert found.kind == "inner" and found.certified
    assert found.length == pytest.approx(sum(map(polyline, arcs)), rel=1e-6)
    way = found.points(1001)
    np.testing.assert_allclose(way.point[-1], HORN.point(*q), atol=1e-14)
    assert polyline(way.point) == pytest.approx(found.length, rel=1e-5)
    np.testing.assert_allclose(HORN.implicit(way.point), 0, atol=1e-13)


# Step 8: round the tube of a ring.


@pytest.mark.parametrize("torus", [NARROW, RING], ids=str)
def test_ways_round_the_tube_are_no_shorter_than_their_geodesic(torus):
    # For every c up to r - R, c dtheta + R sqrt(1 - c^2/rho^2) dphi is no longer than the way; its
    # greatest value, at the geodesic's c, is the geodesic's length.
    tried = np.array([0.1, 0.5, 0.9, 0.999])
    for a, b in zip(*pairs(torus, 60, seed=4), strict=True):
        if b >= 0:
            continue
        _, turned, _, length = ways_of(INSIDE, torus, a, b, np.arctanh(tried))
        shares = np.append(np.linspace(0, 1, 40)[1:-1], tried)
        along = 0
        for start, stop in ((a, np.pi), (np.pi, 2 * np.pi + b)):
            phi = start + (stop - start) * (1 + NODES) / 2
            rho = torus.r + torus.R * np.cos(phi)
            c = (torus.r - torus.R) * shares[:, None]
            along += torus.R * np.sqrt(1 - (c / rho) ** 2) @ WEIGHTS * (stop - start) / 2
        bound = c * turned + along[:, None]
        assert np.all(bound <= length * (1 + 1e-9))
        np.testing.assert_allclose(np.diag(bound[-4:]), length, rtol=1e-9)
