"""Geodesics of the torus: against high-precision direct solves, integration, and other paths."""

from functools import cache, partial

import numpy as np
import pytest
from mpmath import mp, mpf
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp

from tests.shapes import ways_of
from tunneller_lib.kernels import compiled
from tunneller_lib.kernels.elementwise import PLAIN
from tunneller_lib.paths import (
    competing_geodesics,
    direct_problem,
    geodesic_direct,
    geodesic_inverse,
    geodesic_root,
)
from tunneller_lib.surfaces import Torus

MACHINE, RING, SPINDLE = Torus(0.08, 0.8), Torus(3, 1), Torus(0.5, 1)
SHEET = (1.2, np.radians(40))  # |theta|, |phi| of the working sheet
ANSWERS = ("length", "azimuth1", "azimuth2", "clairaut")
quad = partial(mp.quad, method="gauss-legendre")
every_torus = pytest.mark.parametrize("torus", [MACHINE, RING, SPINDLE], ids=str)


def random_pairs(torus, n, seed=0):
    """Return ends p, q (n, 2): anywhere on a ring, on the working sheet of a spindle."""
    reach = (np.pi, np.pi) if torus.r > torus.R else SHEET
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (2, n, 2)) * reach


def on_torus(torus, joint):
    return torus.point(joint[..., 0], joint[..., 1])


def between(azimuth, other):
    """Return the angles between directions."""
    return np.abs(np.remainder(azimuth - other + np.pi, 2 * np.pi) - np.pi)


# Inverse and direct problem.


@every_torus
def test_geodesic_points_keep_clairauts_constant_and_unit_speed(torus):
    p, q = random_pairs(torus, 50)
    found = geodesic_inverse(torus, p, q)
    n = 401
    way = found.points(n)
    size = torus.r + torus.R
    rho = np.hypot(way.point[..., 0], way.point[..., 2])
    clairaut = rho * np.sin(way.azimuth)
    np.testing.assert_allclose(clairaut, found.clairaut[:, None] + 0 * rho, atol=1e-13 * size)
    np.testing.assert_allclose(np.linalg.norm(way.tangent, axis=-1), 1, rtol=1e-14)
    np.testing.assert_allclose(
        way.s, found.length[:, None] * np.arange(n) / (n - 1), rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(way.position[:, 0], p, atol=1e-15)
    np.testing.assert_allclose(way.point[:, -1], on_torus(torus, q), atol=1e-11 * torus.R)
    # The tangent is the rate of the points by arc length: differences of sixth order.
    point, rate = way.point, 0
    for k, weight in ((1, 45), (2, -9), (3, 1)):
        rate = rate + weight * (point[:, 3 + k : n - 3 + k] - point[:, 3 - k : n - 3 - k])
    rate = rate / (60 * found.length[:, None, None] / (n - 1))
    np.testing.assert_allclose(rate, way.tangent[:, 3:-3], atol=1e-8)


# Special ends.


@every_torus
def test_geodesic_from_a_point_to_itself_has_no_direction(torus):
    found = geodesic_inverse(torus, (0.3, -0.2), (0.3, -0.2))
    assert found.length == 0 and found.kind == "point" and found.converged
    assert np.isnan(found.azimuth1) and np.isnan(found.azimuth2)
    np.testing.assert_allclose(found.points(3).position, [(0.3, -0.2)] * 3, atol=1e-15)


@pytest.mark.parametrize("torus", [MACHINE, Torus(1, 1), RING], ids=str)
@pytest.mark.parametrize("off", [0, 1e-12, 1e-10, 1e-8, 1e-6])
def test_geodesic_that_leaves_its_farther_end_along_the_parallel_is_found(torus, off):
    # There Newton's unknown is zero, or near it, and steps don't shrink below their rounding.
    rng = np.random.default_rng(5)
    lengths = torus.R * rng.uniform(1e-4, 0.5, 40)
    swings = rng.uniform(0, 1.2, 40) * rng.choice([1, 1e-3, 1e-8], 40)
    starts = np.stack([rng.uniform(-0.5, 0.5, 40), swings], axis=-1)
    azimuth = np.pi / 2 + off
    ways = [geodesic_direct(torus, p, azimuth, s) for p, s in zip(starts, lengths, strict=True)]
    found = geodesic_inverse(torus, starts, np.array([way.position[-1] for way in ways]))
    assert np.all(found.converged)
    np.testing.assert_allclose(found.length, lengths, rtol=0, atol=1e-14 * torus.R)


@pytest.mark.parametrize("turn", [0.1, 2, np.pi])
@pytest.mark.parametrize("phi", [(np.pi, np.pi), (np.pi, -np.pi), (-np.pi, np.pi)], ids=str)
def test_geodesic_along_the_inner_equator_of_a_ring(turn, phi):
    found = geodesic_inverse(RING, (0, phi[0]), (turn, phi[1]))
    assert found.converged
    assert found.length == pytest.approx((RING.r - RING.R) * turn, rel=1e-13)
    assert found.azimuth1 == pytest.approx(np.pi / 2, abs=1e-6)


def check_no_answer(found, count):
    assert not np.any(found.converged)
    assert np.all(found.kind == "none") and np.size(found.kind) == count
    assert all(np.all(np.isnan(getattr(found, name))) for name in ANSWERS)


@pytest.mark.parametrize("end", [(0, 2.0), (0.2, np.pi), (3, -2.5)], ids=str)
def test_geodesic_to_a_point_off_the_working_sheet_has_no_answer(end):
    for pair in (((0, 0.1), end), (end, (0, 0.1)), (end, end)):
        check_no_answer(geodesic_inverse(MACHINE, *pair), 1)
    way = geodesic_direct(MACHINE, end, 0.3, 0.1)
    assert np.all(np.isnan(way.position)) and np.all(np.isnan(way.azimuth))


def test_points_of_a_geodesic_without_an_answer_are_not_numbers():
    found = geodesic_inverse(MACHINE, (0, 0.1), [(0.2, 0.3), (0.2, 3.0)])
    way = found.points(3)
    for known in (way.position, way.azimuth, way.point, way.tangent, way.deviation([(0.1, 0.2)])):
        assert np.all(np.isfinite(known[0])) and np.all(np.isnan(known[1]))


# The direct problem by other means: the equations themselves, and integrals in 30 digits.


def by_equations(torus, p, azimuth, length, n):
    """Return theta, phi, azimuth (3, n) along a geodesic, by Dormand and Prince's method."""

    def rates(_, state):
        turning = np.sin(state[2]) / (torus.r + torus.R * np.cos(state[1]))
        return [turning, np.cos(state[2]) / torus.R, np.sin(state[1]) * turning]

    s = np.linspace(0, length, n)
    start = [*p, azimuth]
    way = solve_ivp(rates, (0, length), start, "DOP853", s, rtol=3e-14, atol=1e-15)
    assert way.success
    return way.y


@cache
def up_and_back(torus, phi, azimuth, start):
    """Return c of a way from phi, and its theta and length from a start to its turn and back.

    By integrals over x, phi = turn - x^2, which has no singularity left, in mpmath.
    """
    r, R = mpf(torus.r), mpf(torus.R)
    c = (r + R * mp.cos(phi)) * abs(mp.sin(azimuth))
    turn = mp.acos((c - r) / R)

    def shape(x, power):
        rho = r + R * mp.cos(turn - x * x)
        below = 2 * R * mp.sin(turn - x * x / 2) * mp.sin(x * x / 2)  # rho - c
        return R * rho**power * 2 * x / mp.sqrt(below * (rho + c))

    end = mp.sqrt(turn - start)
    peak = mp.sqrt(c / R)
    legs = [0, *(peak * 10**k for k in range(20) if peak * 10**k < end), end]
    turned, length = (2 * quad(partial(shape, power=k), legs) for k in (-1, 1))
    return c, c * turned, length


@pytest.mark.parametrize("n", [1, 50])  # by numbers, and by arrays
@pytest.mark.parametrize("torus", [MACHINE, RING, SPINDLE, Torus(1e5, 1), Torus(1e-99, 1)], ids=str)
@pytest.mark.parametrize("size", [1e-44, 1e-46, 1e-100, 1e-150, 1e-160, 1e-200, 1e-300])
def test_geodesic_between_ends_all_but_the_same_is_straight(torus, size, n):
    start = np.tile([0.0, 0.4], (n, 1))
    turn = size / (torus.r + torus.R * np.cos(0.4))
    aside = geodesic_inverse(torus, start, [turn, 0.4])
    np.testing.assert_allclose(aside.length, size, rtol=1e-13)
    np.testing.assert_allclose(aside.azimuth1, np.pi / 2)
    # On both sides of the outer equator, with coordinates that are as small as the way.
    stop = size * np.array([-0.6 / (torus.r + torus.R), 0.5 / torus.R])
    start = np.tile([0, -0.3 * size / torus.R], (n, 1))
    across = geodesic_inverse(torus, start, stop)
    np.testing.assert_allclose(across.length, size, rtol=1e-13)
    for azimuth in (across.azimuth1, across.azimuth2):
        np.testing.assert_allclose(azimuth, -np.arctan2(0.6, 0.8), rtol=1e-13)
    np.testing.assert_allclose(across.clairaut, -0.6 * (torus.r + torus.R), rtol=1e-13)


@pytest.mark.parametrize("torus", [MACHINE, RING, SPINDLE, Torus(1, 1), Torus(1.01, 1),
                                   Torus(2e4, 1e3), Torus(1e-6, 1e-3)], ids=str)  # fmt: skip
def test_geodesic_direct_solves_the_geodesic_equations(torus):
    rng = np.random.default_rng(11)
    low = -0.99 * min(torus.r / torus.R, 1)
    phi = np.arccos(rng.uniform(low, 1, 12)) * rng.choice([-1, 1], 12)
    starts = np.stack([rng.uniform(-3, 3, 12), phi], axis=-1)
    azimuths = rng.uniform(-np.pi, np.pi, 12)
    lengths = torus.R * rng.uniform(-8, 8, 12)
    ways = geodesic_direct(torus, starts, azimuths, lengths, 9)
    for k in range(12):
        known = by_equations(torus, starts[k], azimuths[k], lengths[k], 9)
        # Neighbours part on the inner half, by at most e a tube radius over the least of rho.
        least = np.min(torus.r + torus.R * np.cos(known[1]))
        parting = np.exp(np.sqrt(max(-np.min(np.cos(known[1])), 0) * torus.R / least) * 8)
        np.testing.assert_allclose(ways.position[k].T, known[:2], rtol=0, atol=2e-12 * parting)
        assert np.max(between(ways.azimuth[k], known[2])) <= 2e-12 * parting


@pytest.mark.parametrize("torus, phi, azimuth", [
    (MACHINE, 0.3, 1.0), (MACHINE, -0.6, -2.5), (RING, 0.2, 1.1), (RING, 1.0, 2.0),
    (SPINDLE, 0.5, 0.01), (Torus(1, 1), 0.4, 0.7), (Torus(1e3, 1), 0.0, 1.57),
    (Torus(1e-50, 1), 0.5, 0.5),
], ids=str)  # fmt: skip
@pytest.mark.parametrize("swings", [1, 2, 1001, 10**6, -(10**9)])
def test_geodesic_direct_of_any_length_goes_on_by_half_swings(torus, phi, azimuth, swings):
    # After half a swing phi and the cosine of the azimuth are mirrored.
    with mp.workdps(30):
        c, turned, length = up_and_back(torus, phi, azimuth, 0)
        assert c > torus.r - torus.R
        whole = swings * length
        turned = float(
            swings * turned + c / (torus.r + torus.R * mp.cos(phi)) ** 2 * (float(whole) - whole)
        )
    way = geodesic_direct(torus, (0, phi), azimuth, float(whole))
    side = (-1) ** swings
    rounding = 2e-15 * abs(swings) * max(1, float(length / torus.R))
    theta, phi_end = way.position[-1]
    assert theta == pytest.approx(np.sign(azimuth) * turned, rel=1e-14, abs=rounding)
    assert phi_end == pytest.approx(side * phi, rel=0, abs=rounding + 1e-15)
    assert np.cos(way.azimuth[-1]) == pytest.approx(side * np.cos(azimuth), rel=0, abs=4 * rounding)


@pytest.mark.parametrize("azimuth", [1e-3, 1e-6, 1e-10, -1e-14, np.pi - 1e-9])
@pytest.mark.parametrize("torus", [SPINDLE, MACHINE, Torus(1, 1)], ids=str)
def test_geodesic_direct_turns_before_a_node(torus, azimuth):
    phi = 0.4
    with mp.workdps(30):  # towards the node that lies ahead
        _, turned, length = up_and_back(torus, phi, azimuth, phi if np.cos(azimuth) > 0 else -phi)
    way = geodesic_direct(torus, (0, phi), azimuth, float(length), 7)
    assert np.isfinite(way.position).all()
    theta, end = way.position[-1]
    assert theta == pytest.approx(np.sign(azimuth) * float(turned), rel=1e-11)
    assert end == pytest.approx(phi, rel=0, abs=5e-14)
    assert np.cos(way.azimuth[-1]) == pytest.approx(-np.cos(azimuth), rel=0, abs=1e-14)


def test_neighbours_of_the_inner_equator_leave_it_by_its_curvature():
    # By Jacobi's equation; the curvature there is -1 / (R (r - R)).
    off, length = 1e-6, np.linspace(0, 6, 7)
    way = geodesic_direct(RING, (0, np.pi - off), np.pi / 2, length[-1], 7)
    parting = off * np.cosh(length / np.sqrt(RING.R * (RING.r - RING.R)))
    np.testing.assert_allclose(np.pi - way.position[:, 1], parting, rtol=1e-8)


def test_geodesic_direct_counts_what_is_left_of_the_turn_by_the_node_of_a_horn():
    # So near a meridian theta is c times the integral of R / rho^2, the distance rho 2 sin^2(z/2).
    gap, length, azimuth = 2.0**-26, 0.02, np.pi + 1e-10
    way = geodesic_direct(Torus(1, 1), (0, np.pi - gap), azimuth, length)
    clairaut = 2 * np.sin(gap / 2) ** 2 * np.sin(azimuth)
    near, far = (1 / np.tan(z / 2) for z in (gap, gap + length))
    turned = clairaut * (near + near**3 / 3 - far - far**3 / 3) / 2
    # To the rounding of such an azimuth, 4e-16 of 1e-10.
    assert way.position[-1, 0] == pytest.approx(turned, rel=1e-5)
    # Clairaut's constant, where it is known, has more of its digits.
    end = np.pi - gap - length
    found = geodesic_inverse(Torus(1, 1), (0, np.pi - gap), (turned, end))
    assert found.points(2).position[-1, 0] == pytest.approx(turned, rel=1e-9)


def test_a_way_wound_about_the_inner_equator_of_a_thin_ring_has_an_answer():
    ring, start, turn, end = Torus(1e4, 1), 3.141592653589771, 1.325, 1.956
    found = geodesic_inverse(ring, (0, start), (turn, end))
    assert 0 < found.length - (ring.r - ring.R) * turn < ring.R * (start - end)


@pytest.mark.parametrize("azimuth, step", [(0.0, 1), (np.pi, -1), (-np.pi, -1), (2 * np.pi, 1)])
def test_geodesic_direct_follows_a_meridian_through_the_node(azimuth, step):
    way = geodesic_direct(SPINDLE, (0.2, 0.3), azimuth, 5.0, 6)
    np.testing.assert_allclose(way.position[:, 1], 0.3 + step * np.arange(6.0), rtol=1e-15)
    assert np.all(way.position[:, 0] == 0.2)
    np.testing.assert_allclose(way.azimuth, azimuth, rtol=1e-15)


# Where r / R is great: a way over the inside follows the inner equator.


@pytest.mark.parametrize("ratio, turn", [(100, 3), (1e3, 0.5), (1e3, 3), (1e5, 0.5)])
def test_geodesic_inverse_on_a_thin_ring_against_30_digits(ratio, turn):
    a, b = 2.0, -1.5
    with mp.workdps(30):
        narrow = mpf(ratio) - 1
        # Where the gap is small the turned angle grows by 1 / sqrt(narrow) an e-fold of it.
        gap = min(16 * mp.exp(-turn * mp.sqrt(narrow)), narrow / 2)
        peak = mp.sqrt(gap)

        def shape(y, power):  # z = peak sinh(y) from the inner equator
            z = peak * mp.sinh(y)
            above = gap + 2 * mp.sin(z / 2) ** 2  # rho - c
            rho = narrow - gap + above
            root = mp.sqrt(above * (rho + narrow - gap))
            return rho**power / root * peak * mp.cosh(y)

        ends = [mp.asinh(end / peak) for end in (mp.pi - a, mp.pi + b)]
        turned, length = (
            sum(quad(partial(shape, power=power), mp.linspace(0, y, 12)) for y in ends)
            for power in (-1, 1)
        )
        turned *= narrow - gap
        length += (narrow - gap) * (float(turned) - turned)
    assert 0.3 < turned <= np.pi
    found = competing_geodesics(Torus(ratio, 1), (0, a), (float(turned), b))
    over = found.length[found.kind == "inner"]
    assert np.min(np.abs(over / float(length) - 1)) <= 1e-14


@pytest.mark.parametrize("torus", [Torus(0.08, 0.8), Torus(3, 1)], ids=str)
@pytest.mark.parametrize("u", [-0.15, 0.1, 0.4])
def test_angle_turned_grows_with_the_unknown_at_the_rate_that_is_told(torus, u):
    # Newton's method would find the root with a wrong rate, too, by halving its bracket.
    step = 1e-5
    for family in (geodesic_root.OUTSIDE, geodesic_root.PAST, geodesic_root.BEFORE):
        _, turned, rate, _ = ways_of(family, torus, 0.5, -0.3, (u - step, u, u + step))
        assert (turned[2] - turned[0]) / (2 * step) == pytest.approx(rate[1], rel=1e-6)


# Ends at the limits of the sheet.


WIDE = [1, 1 + 2.3e-16, 1 + 1e-12, 1.0001, 1.01, 1.1, 1.5, 3]


@pytest.mark.parametrize("ratio", WIDE)
@pytest.mark.parametrize("turn", [1e-17, 1e-12, 1e-8])
def test_a_tiny_turn_has_its_own_clairauts_constant(ratio, turn):
    # To first order in the turn it is c times the integral of R / rho^2.
    a, b = 2.5, 0.3
    nodes, weights = leggauss(400)
    phi = b + (a - b) * (1 + nodes) / 2
    integral = np.sum(weights / (ratio + np.cos(phi)) ** 2) * (a - b) / 2
    found = geodesic_inverse(Torus(ratio, 1), (0, a), (turn, b))
    assert found.clairaut == pytest.approx(turn / integral, rel=1e-9)


@pytest.mark.parametrize("gap", [1e-3, 1e-6])
def test_a_way_by_the_node_of_a_horn_keeps_the_digits_of_its_azimuth(gap):
    # 1 + cos(phi) there has no digits by its sum; its half is sin^2 of half the gap.
    found = geodesic_inverse(Torus(1, 1), (0, np.pi - gap), (0.5, np.pi - 2 * gap))
    radius = 2 * np.sin(gap / 2) ** 2
    assert found.clairaut / radius == pytest.approx(np.sin(found.azimuth1), rel=2e-9, abs=0)


def test_a_short_way_through_the_node_of_a_horn_counts_what_pi_is_more_than_its_double():
    phi = np.pi - 2.0**-33
    found = geodesic_inverse(Torus(1, 1), (0, phi), (2, -phi))
    with mp.workdps(30):
        exact = float(2 * (mp.pi - mpf(phi)))
    assert found.kind == "inner"
    assert found.length == pytest.approx(exact, rel=1e-12, abs=0)


def test_the_node_of_a_horn_is_no_place_on_its_sheet():
    check_no_answer(geodesic_inverse(Torus(1, 1), (0, 0.1), (1, np.pi)), 1)
    assert np.isnan(geodesic_direct(Torus(1, 1), (0, np.pi), 0.5, 0.1).position).all()


def test_the_rim_is_where_the_cosine_says():
    with mp.workdps(40):
        inside = 1e-3 + mp.cos(mpf(np.arccos(-1e-3))) > 0
    found = geodesic_inverse(Torus(1e-3, 1), (0, np.arccos(-1e-3)), (1, 0))
    assert (found.kind == "outer") == inside
    beyond = geodesic_inverse(Torus(1e-100, 1), (0, np.nextafter(np.pi / 2, 4)), (1, 0))
    check_no_answer(beyond, 1)


def test_deviation_is_positive_to_the_left_of_the_way_as_seen_from_outside():
    way = geodesic_direct(MACHINE, (0, 0), np.pi / 2, 0.2 * (MACHINE.r + MACHINE.R), 65)
    off = way.deviation([(0.1, 0.01), (0.1, -0.02)])
    np.testing.assert_allclose(off, MACHINE.R * np.sin([0.01, -0.02]), rtol=1e-4)


# For the width of their y, ways from phi to -phi, nearly straight down, need most nodes.
@pytest.mark.parametrize("ratio", [1e-6, 0.1, 0.25, 0.5, 0.8, 0.95, 0.999, 1, 1.001, 1.05, 3, 100])
def test_few_nodes_are_as_good_as_many_on_ways_of_any_width(ratio):
    torus = Torus(ratio, 1)
    for share in np.linspace(0.02, 0.85, 84):  # of the way from the outer equator to the rim
        a = share * np.arccos(max(-ratio, -1))
        straight = -(1 - 1e-7) * geodesic_root.ends_at(torus, a, -a).meridian
        unknowns = straight, straight / 2
        few, many_ = (
            ways_of(geodesic_root.OUTSIDE, torus, a, -a, unknowns, n) for n in (None, 200)
        )
        rounding = 1e-14 if share < 0.5 else 3e-13  # grows with the width, to 1e-13
        np.testing.assert_allclose(few[[1, 3]], many_[[1, 3]], rtol=rounding)
        np.testing.assert_allclose(few[2], many_[2], rtol=1e-6, atol=1e-12)  # the rate only steers


# Panels resolve wide peaks, too. The starts call for all numbers of terms but two at most.
@pytest.mark.parametrize("ratio", [1e-3, 0.1, 0.25, 0.7, 0.95, 1, 1.05, 1.3, 3, 100])
def test_series_of_sines_and_panels_agree(ratio, monkeypatch):
    rng, torus = np.random.default_rng(4), Torus(ratio, 1)
    rim = np.arccos(max(-ratio, -1))
    starts = np.stack([np.zeros(300), rng.uniform(-0.9, 0.9, 300) * rim], axis=-1)
    azimuth, length = 10 ** rng.uniform(-2.5, 0.5, 300), rng.uniform(-1, 1, 300)
    monkeypatch.setattr(compiled, "ready", lambda _: False)
    series = geodesic_direct(torus, starts, azimuth, length)
    asked = []
    monkeypatch.setitem(PLAIN, "level_of", lambda stretch: asked.append(stretch**2) or -1)
    panels = geodesic_direct(torus, starts, azimuth, length)
    limits = np.array(direct_problem.SINES)[:, 1]
    assert np.unique(np.searchsorted(limits[::-1], asked)).size >= len(limits) - 2
    off = np.abs(series.position - panels.position).max(axis=(1, 2))
    off = np.maximum(off, np.abs(series.azimuth - panels.azimuth).max(axis=1))
    # Ways that pass near a node turn there by much more than Clairaut's constant is right to.
    assert np.all(off <= np.where(np.array(asked) > 0.2, 1e-14, 2e-13))


# The search for the place begins with two terms of the series, which have no slope there.
@pytest.mark.parametrize("ratio, phi, azimuth, length", [
    (0.1, 1.46, 0.0931, 0.88708033585861), (0.5, 1.64, 0.0558, 1.082455190744864),
])  # fmt: skip
def test_place_is_found_where_two_terms_of_the_series_have_no_slope(
    ratio, phi, azimuth, length, monkeypatch
):
    monkeypatch.setattr(compiled, "ready", lambda _: False)
    series = geodesic_direct(Torus(ratio, 1), (0, phi), azimuth, length)
    monkeypatch.setitem(PLAIN, "level_of", lambda _: -1)
    panels = geodesic_direct(Torus(ratio, 1), (0, phi), azimuth, length)
    np.testing.assert_allclose(series.position, panels.position, rtol=0, atol=1e-12)


@pytest.mark.parametrize("ratio, phi, azimuth, length", [
    (0.1, 0.8650555986282783, 2.724075696455446, 4.675609184439403e33), (0.1, 0.3, 1.0, 8e15),
    (5.37e89, -6.66e-11, 1.41587, 7.02e44),
])  # fmt: skip
def test_longest_geodesics_keep_clairauts_constant(ratio, phi, azimuth, length):
    way = geodesic_direct(Torus(ratio, 1), (0, phi), azimuth, length)
    c = (ratio + np.cos(way.position[:, 1])) * np.sin(way.azimuth)
    assert c[1] == pytest.approx(c[0], rel=1e-12)


def test_geodesic_round_the_tube_of_a_ring_that_is_nearly_a_horn():
    r, phi, end, azimuth = mpf("1.000178256977964"), mpf("1.1227643442654078"), mpf(5.5), 5e-8
    with mp.workdps(30):
        c = (r + mp.cos(phi)) * mp.sin(azimuth)

        def growth(phi, power):
            rho = r + mp.cos(phi)
            return rho**power / mp.sqrt((rho - c) * (rho + c))

        places = phi, mp.pi - 0.1, mp.pi - 0.01, mp.pi, mp.pi + 0.01, mp.pi + 0.1, end
        turned, length = (mp.quad(partial(growth, power=k), places) for k in (-1, 1))
    way = geodesic_direct(Torus(float(r), 1), (0, float(phi)), azimuth, float(length))
    assert way.position[1] == pytest.approx([float(c * turned), 5.5], rel=1e-14)


# Both ends lie beside the inner equator of a ring: a way over it has a peak at either end.
@pytest.mark.parametrize("ratio, a, b, turn", [
    (1.0003922633924152, 3.1406578017600943, 3.141587822095486, 0.1962751115688386),
    (1.01, 3.1, 3.1, 0.3),
])  # fmt: skip
def test_rivals_over_the_inner_equator_lead_from_beside_it_to_beside_it(ratio, a, b, turn):
    found = competing_geodesics(Torus(ratio, 1), (0, a), (turn, b))
    inner = np.flatnonzero(found.kind == "inner")
    assert inner.size == 2
    way = geodesic_direct(found.torus, (0, a), found.azimuth1[inner], found.length[inner])
    missed = np.remainder(way.position[:, 1] - (turn, b) + np.pi, 2 * np.pi) - np.pi
    np.testing.assert_allclose(missed, 0, atol=1e-10)


# Ways round the outside whose far end has a peak of its own: one descends to beside a node, one
# winds about the inner equator of a wide ring first.
@pytest.mark.parametrize("ratio, a, b, turn", [
    (0.3, 1.87372381989098, -1.8731366215846341, 2.2973128858613494),
    (1e4, 2.906664442692681, -2.213177492438752, 1.5096461479736543),
])  # fmt: skip
def test_peak_at_the_far_end_is_not_missed(ratio, a, b, turn):
    # In 30 digits: c times the turn and the integral of sqrt(1 - c^2 / rho^2) is stationary in c.
    found = competing_geodesics(Torus(ratio, 1), (0, a), (turn, b))
    outer = np.flatnonzero(found.kind == "outer")[0]
    with mp.workdps(30):
        c = mpf(float(found.clairaut[outer]))

        def part(*places):
            return mp.quad(lambda phi: mp.sqrt(1 - (c / (ratio + mp.cos(phi))) ** 2), places)

        winds = 2 * part(a, mp.pi) if ratio > 1 else 0
        length = c * turn + part(b, b + 0.001, b + 0.1, 0, a - 0.1, a - 0.001, a) + winds
    assert found.length[outer] == pytest.approx(float(length), rel=3e-14, abs=0)


def test_steps_are_judged_against_a_class_that_is_short_by_the_node():
    # To first order in the turn it is c times the integral of 1 / rho^2, elementary on a horn.
    a, turn = np.pi - 8e-5, 2.8e-3
    tangent = np.tan(a / 2)
    found = competing_geodesics(Torus(1, 1), (0, a), (turn, -a))
    outer = np.flatnonzero(found.kind == "outer")[0]
    expected = turn / (tangent + tangent**3 / 3)
    assert found.clairaut[outer] == pytest.approx(expected, rel=1e-10, abs=0)
