"""Competing geodesics and the certificates of the shortest."""

import numpy as np
import pytest

from tests.long import many
from tunneller_lib.paths import competing_geodesics, geodesic_direct, geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

RING, NARROW, SPINDLE = Torus(3, 1), Torus(1.05, 1), Torus(0.5, 1)
MACHINE = REFERENCE_MACHINE.torus
every_torus = pytest.mark.parametrize("torus", [RING, NARROW, SPINDLE, MACHINE], ids=str)


def random_pairs(torus, n, seed=0):
    reach = (np.pi, np.pi) if torus.r > torus.R else (np.pi, 1.2)
    return np.random.default_rng(seed).uniform(-1, 1, (2, n, 2)) * reach


@every_torus
def test_competing_geodesics_begin_with_the_shortest(torus):
    p, q = random_pairs(torus, many(250, 5_000))
    rivals, shortest = competing_geodesics(torus, p, q), geodesic_inverse(torus, p, q)
    for name in ("length", "azimuth1", "azimuth2", "clairaut", "kind", "certificate"):
        np.testing.assert_array_equal(getattr(rivals, name)[0], getattr(shortest, name))
    assert np.all(np.diff(rivals.length, axis=0)[rivals.converged[1:]] >= 0)
    assert np.all(rivals.certificate[1:] == "")
    assert np.all(np.isfinite(rivals.length) == rivals.converged)


@every_torus
def test_competing_geodesics_all_lead_to_the_end(torus):
    p, q = random_pairs(torus, many(250, 5_000), seed=1)
    rivals = competing_geodesics(torus, p, q)
    found = rivals.converged
    way = geodesic_direct(torus, rivals.p[found], rivals.azimuth1[found], rivals.length[found])
    miss = np.linalg.norm(way.point[:, -1] - torus.point(*rivals.q[found].T), axis=-1)
    # Beyond two tube radii on the inner half neighbours part by e a radius: so do errors.
    assert np.max(miss / np.exp(rivals.length[found] / torus.R)) <= 1e-11 * torus.R
    assert np.percentile(miss, 90) <= 1e-11 * torus.R
    assert len(set(zip(*np.nonzero(found)[1:], strict=True))) == len(p)


def crossings(torus, p, q, azimuths, length):
    """Return lengths of geodesics from p to q, found by a fan of directions: independent."""
    way = geodesic_direct(torus, p, azimuths, length, 1500)
    theta, phi = np.moveaxis(way.position, -1, 0)
    lengths = []
    for turn in range(-2, 3):
        for winding in range(-2, 3):
            level = q[1] + 2 * np.pi * winding
            before = phi[:, :-1] - level
            hit = before * (phi[:, 1:] - level) < 0
            share = np.where(hit, before / (phi[:, :-1] - phi[:, 1:]), np.nan)
            miss = theta[:, :-1] + share * np.diff(theta, axis=1) - q[0] - 2 * np.pi * turn
            s = way.s[:, :-1] + share * np.diff(way.s, axis=1)
            for k in range(1, len(azimuths)):
                # Neighbouring directions that pass the end on either side of it.
                i, j = np.nonzero(hit[k - 1])[0], np.nonzero(hit[k])[0]
                for a, b in zip(i, j, strict=True) if len(i) == len(j) else []:
                    if miss[k - 1, a] * miss[k, b] < 0 and abs(miss[k - 1, a] - miss[k, b]) < 0.1:
                        lengths.append((s[k - 1, a] + s[k, b]) / 2)
    return np.array(lengths)


@pytest.mark.parametrize("p, q", [((0, 0.8), (3.1, -0.3)), ((0, 1.6), (0.4, -1.55)),
                                  ((0.2, -1.1), (2.0, 0.9))], ids=str)  # fmt: skip
def test_competing_geodesics_are_those_of_a_fan_of_directions(p, q):
    rivals = competing_geodesics(RING, p, q)
    lengths = rivals.length[rivals.converged]
    fan = crossings(RING, p, q, np.linspace(-np.pi, np.pi, 2000) + 1e-4, lengths[0] * 1.08)
    assert len(fan)
    for length in fan:
        assert np.min(np.abs(lengths - length)) < 0.05


def test_competing_geodesics_on_the_outer_equator_are_mirror_images_and_the_equator():
    rivals = competing_geodesics(RING, (0, 0), (2.6, 0))
    assert rivals.length[0] == pytest.approx(rivals.length[1], rel=1e-14)
    assert rivals.azimuth1[0] + rivals.azimuth1[1] == pytest.approx(np.pi)
    assert rivals.length[2] == pytest.approx(4 * 2.6)
    assert rivals.azimuth1[2] == pytest.approx(np.pi / 2)


def test_competing_geodesics_on_a_meridian_are_its_two_arcs_first():
    rivals = competing_geodesics(RING, (0, 0.3), (0, -0.4))
    np.testing.assert_allclose(rivals.length[:2], [0.7, 2 * np.pi - 0.7], rtol=1e-14)
    assert list(rivals.kind[:2]) == ["meridian", "meridian"]


def test_competing_geodesics_of_no_pairs_and_of_wrong_ends():
    assert competing_geodesics(RING, np.empty((0, 2)), (0, 0)).length.shape == (6, 0)
    assert np.all(competing_geodesics(SPINDLE, (0, 3), (0, 0)).kind == "none")
    with pytest.raises(ValueError, match=r"^p: the last axis must hold theta, phi"):
        competing_geodesics(RING, 1.0, (0, 0))


@every_torus
def test_competing_geodesics_do_not_depend_on_company(torus):
    p, q = random_pairs(torus, 40, seed=2)
    together = competing_geodesics(torus, p, q).length
    ends = np.cumsum([1, 1, 1, 2, 3, 5, 8, 19])  # alone, and in companies of other sizes
    assert ends[-1] == len(p)
    parts = zip(np.split(p, ends[:-1]), np.split(q, ends[:-1]), strict=True)
    apart = np.concatenate([competing_geodesics(torus, *part).length for part in parts], axis=1)
    np.testing.assert_allclose(together, apart, rtol=1e-12)


@pytest.mark.parametrize("torus", [Torus(1e60, 1e-60), Torus(1e-60, 1e60)], ids=str)
def test_geodesics_of_a_torus_beyond_all_proportion_are_refused(torus):
    for find in (geodesic_inverse, competing_geodesics):
        with pytest.raises(ValueError, match=r"^torus: r / R must be from 1e-100 to 1e\+100"):
            find(torus, (0, 0), (0.1, 0))


def test_competing_geodesics_broadcast():
    rivals = competing_geodesics(RING, np.zeros((4, 1, 2)), np.ones((3, 2)))
    assert rivals.length.shape == (6, 4, 3) and rivals.p.shape == (6, 4, 3, 2)


# Certificates.


def test_every_geodesic_of_the_working_sheet_is_certified():
    machine = REFERENCE_MACHINE
    low, high = (machine.theta_min, machine.phi_min), (machine.theta_max, machine.phi_max)
    p, q = np.random.default_rng(2).uniform(low, high, (2, 5000, 2))
    for torus in (machine.torus, Torus(0.25, 1), Torus(0.01, 1)):
        found = geodesic_inverse(torus, p, q)
        assert set(found.certificate) == {"curvature"} and found.certified.all()


def test_certificate_ends_where_two_geodesics_meet():
    # The conjugate point of the outer equator is where the curvature's bound is reached.
    angle = np.pi * np.sqrt(RING.R / (RING.r + RING.R))
    near, past = geodesic_inverse(
        RING, (0, 0), [(0.999 * angle, 0), (1.001 * angle, 0)]
    ).certificate
    assert near == "curvature" and past == "compared"


@every_torus
def test_certified_geodesics_have_no_shorter_rival(torus):
    p, q = random_pairs(torus, many(1_000, 20_000), seed=3)
    found, rivals = geodesic_inverse(torus, p, q), competing_geodesics(torus, p, q)
    certified = found.certificate == "curvature"
    assert np.mean(certified) > 0.3
    other = rivals.length[1][certified]
    assert not np.any(other < found.length[certified])


def test_certificates_of_special_ends():
    found = geodesic_inverse(SPINDLE, [(0, 1), (0, 1), (0, 3)], [(0, 1), (0, -1), (0, 0)])
    assert list(found.certificate) == ["curvature", "meridian", ""]
    np.testing.assert_array_equal(found.certified, [True, True, False])
