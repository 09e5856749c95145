"""Competing geodesics and the certificates of the shortest."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tests.audit.long import many
from tests.references import geodesic_rivals
from tests.shapes import ways_of
from tunneller_lib.paths import competing_geodesics, geodesic_direct, geodesic_inverse
from tunneller_lib.paths.geodesic_root import PAST
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

RING, NARROW, SPINDLE = Torus(3, 1), Torus(1.05, 1), Torus(0.5, 1)
MACHINE = REFERENCE_MACHINE.torus
every_torus = pytest.mark.parametrize("torus", [RING, NARROW, SPINDLE, MACHINE], ids=str)


def random_pairs(torus, n, seed=0):
    reach = (np.pi, np.pi) if torus.r > torus.R else (np.pi, 1.2)
    return np.random.default_rng(seed).uniform(-1, 1, (2, n, 2)) * reach


@every_torus
def test_competing_geodesics_begin_with_the_shortest(torus):
    p, q = random_pairs(torus, many(100, 5_000))
    rivals, shortest = competing_geodesics(torus, p, q), geodesic_inverse(torus, p, q)
    for name in ("length", "azimuth1", "azimuth2", "clairaut", "kind", "certificate"):
        np.testing.assert_array_equal(getattr(rivals, name)[0], getattr(shortest, name))
    assert np.all(np.diff(rivals.length, axis=0)[rivals.converged[1:]] >= 0)
    assert np.all(rivals.certificate[1:] == "")
    assert np.all(np.isfinite(rivals.length) == rivals.converged)


@every_torus
def test_competing_geodesics_all_lead_to_the_end(torus):
    p, q = random_pairs(torus, many(100, 5_000), seed=1)
    rivals = competing_geodesics(torus, p, q)
    found = rivals.converged
    way = geodesic_direct(torus, rivals.p[found], rivals.azimuth1[found], rivals.length[found])
    miss = np.linalg.norm(way.point[:, -1] - torus.point(*rivals.q[found].T), axis=-1)
    # Beyond two tube radii on the inner half neighbours part by e a radius: so do errors.
    assert np.max(miss / np.exp(rivals.length[found] / torus.R)) <= 1e-11 * torus.R
    assert np.percentile(miss, 90) <= 1e-11 * torus.R
    assert len(set(zip(*np.nonzero(found)[1:], strict=True))) == len(p)


# Of the meetings that tests/references/geodesic_rivals tells of, in its order: those of each class.
WAVES = list(itertools.product(range(4), (1, -1), (1, -1)))  # half waves before, directions at ends
ROUNDS = list(itertools.product(range(2), (1, -1)))
ARRIVALS = [k for k, wave in enumerate(WAVES) if wave[::2] in {(0, 1), (1, -1)}]
DIRECT, OVER = (len(WAVES) + ROUNDS.index(way) for way in ((0, 1), (1, -1)))


def by_fan(torus, p, q, classes):
    """Return lengths of geodesics from p to q, shot in some thousand directions.

    By another quadrature than the library's, and each found where neighbours pass q on either side.
    """
    (_, a), (_, b) = sorted([p, q], key=lambda end: -abs(end[1]))
    a, b = abs(a), b * np.sign(a)
    turn = abs(np.remainder(q[0] - p[0] + np.pi, 2 * np.pi) - np.pi)
    lengths = []
    for k, (c, turned, length) in enumerate(geodesic_rivals.meetings(torus.r, torus.R, a, b)):
        # Its quadrature isn't made for geodesics that pass closer by a node.
        by_node = (torus.r < torus.R) & (c < 1e-3 * torus.R)
        turned = np.where(by_node, np.nan, turned)
        if k in classes:
            for target in (turn, 2 * np.pi - turn):
                lengths.extend(geodesic_rivals.passing(c, turned, length, target))
    return np.sort(lengths)


@every_torus
def test_competing_geodesics_are_those_of_a_fan_of_directions(torus):
    for p, q in zip(*random_pairs(torus, many(4, 60), seed=4), strict=True):
        rivals = competing_geodesics(torus, p, q)
        lengths = rivals.length[rivals.converged]
        fan = by_fan(torus, p, q, [*ARRIVALS, DIRECT, OVER])
        assert len(lengths) == len(fan) >= 2
        np.testing.assert_allclose(lengths, fan, rtol=1e-5)


def test_competing_geodesics_leave_none_out_on_the_machines_torus():
    # Whatever turns by less than two half swings, 343 degrees, is a first or second arrival.
    assert np.degrees(2 * np.pi / np.sqrt(1.1)) == pytest.approx(343.24, abs=0.01)
    n = many(12, 25)
    ends = zip(*random_pairs(MACHINE, n, seed=5), strict=True)
    far = [(p, q) for p, q in ends if abs(np.sin((q - p)[0] / 2)) > np.sin(np.radians(17 / 2))]
    assert len(far) > 0.8 * n
    for p, q in far:
        rivals = competing_geodesics(MACHINE, p, q)
        lengths = rivals.length[rivals.converged]
        np.testing.assert_allclose(lengths, by_fan(MACHINE, p, q, range(len(WAVES))), rtol=1e-5)


@pytest.mark.parametrize("torus", [Torus(1e60, 1e-60), Torus(1e-60, 1e60)], ids=str)
def test_geodesics_of_a_torus_beyond_all_proportion_are_refused(torus):
    for find in (geodesic_inverse, competing_geodesics):
        with pytest.raises(ValueError, match=r"^torus: r / R must be from 1e-100 to 1e\+100"):
            find(torus, (0, 0), (0.1, 0))


# Certificates.


def test_every_geodesic_of_the_working_sheet_is_the_only_one_that_turns_so_far():
    machine = REFERENCE_MACHINE
    low, high = (machine.theta_min, machine.phi_min), (machine.theta_max, machine.phi_max)
    p, q = np.random.default_rng(2).uniform(low, high, (2, many(1_500, 5_000), 2))
    # As long as pi / sqrt(1 + r / R) is no less than the joint's whole range.
    widest = (np.pi / (machine.theta_max - machine.theta_min)) ** 2 - 1
    assert widest == pytest.approx(935 / 361, rel=1e-14)
    for ratio in (0.01, 0.1, 0.25, 1, 0.9999 * widest):
        found = geodesic_inverse(Torus(ratio, 1), p, q)
        assert set(found.certificate) == {"only"} and found.certified.all()
    corner = geodesic_inverse(Torus(1.0001 * widest, 1), low, high)
    assert corner.certificate == "first" and corner.certified


def test_certificate_ends_where_two_geodesics_meet():
    angle = np.pi * np.sqrt(RING.R / (RING.r + RING.R))
    ends = [(0.999 * angle, 0), (1.001 * angle, 0)]
    near, past = geodesic_inverse(RING, (0, 0), ends).certificate
    assert near == "only" and past == "first"
    # Past it a second geodesic turns as far: the equator, and a mirror image, too.
    turned = competing_geodesics(RING, (0, 0), ends)
    assert list(np.sum(turned.length < 1.01 * 4 * angle, axis=0)) == [1, 3]


@every_torus
def test_certified_geodesics_have_no_shorter_rival(torus):
    p, q = random_pairs(torus, many(200, 20_000), seed=3)
    found, rivals = geodesic_inverse(torus, p, q), competing_geodesics(torus, p, q)
    assert found.certified.all()
    second = rivals.length[1]
    compared = np.isfinite(second)
    assert np.mean(compared) > 0.95
    assert np.all(second[compared] >= found.length[compared])
    # No rival turns as far as one that is called the only one, but for those over the inside.
    sine = np.sin(rivals.azimuth1) * np.sign(np.remainder(q - p + np.pi, 2 * np.pi) - np.pi)[:, 0]
    alike = (sine > 0) & (rivals.kind == "outer")
    assert np.all(np.sum(alike, axis=0)[found.certificate == "only"] == 1)


def test_competing_ways_on_a_horn_hold_the_one_through_its_node_and_all_lead_to_the_end():
    horn = Torus(1, 1)
    p, q = np.random.default_rng(7).uniform(-3, 3, (2, 200, 2))
    rivals, shortest = competing_geodesics(horn, p, q), geodesic_inverse(horn, p, q)
    np.testing.assert_array_equal(rivals.length[0], shortest.length)
    assert np.all(np.sum(rivals.kind == "inner", axis=0) == 1)
    end = rivals.points(5).point[..., -1, :]
    miss = np.linalg.norm(end - horn.point(q[:, 0], q[:, 1]), axis=-1)
    assert np.max(miss[rivals.converged]) <= 1e-11


def test_second_arrivals_just_beyond_their_least_turn_are_found():
    horn, a, b = Torus(1, 1), 0.8, 0.2
    least = minimize_scalar(
        lambda u: ways_of(PAST, horn, a, b, [u])[1, 0], bounds=(-3, -0.1), method="bounded",
        options={"xatol": 1e-12},
    ).fun  # fmt: skip
    beyond, short = (
        competing_geodesics(horn, (0, a), (least * (1 + off), b)).kind for off in (1e-12, -1e-12)
    )
    assert np.sum(beyond == "outer") == np.sum(short == "outer") + 2


@pytest.mark.parametrize(
    ("torus", "p", "q"),
    [(Torus(3, 1), (0, 0), (1, 0)), (Torus(1.01, 1), (0.2, 0), (-0.3, 0)),
     (Torus(1, 1), (0, 1), (0.7, 1)), (Torus(1, 1), (0, 0), (0.7, 0))],
)  # fmt: skip
def test_way_round_the_tube_between_ends_on_one_parallel_is_that_of_ends_beside_it(torus, p, q):
    at, beside = (competing_geodesics(torus, p, (q[0], q[1] - step)) for step in (0.0, 1e-9))
    lengths = [one.length[one.kind == "inner"][0] for one in (at, beside)]
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-8)
    assert lengths[0] > torus.R * np.pi  # it comes by the inner equator
