"""The law of the tangent-sphere path's error for chords of any length."""

import numpy as np
import pytest
from mpmath import mp
from scipy.optimize import brentq, minimize

from tests.references import short_chords, tables
from tests.shapes import joint_pairs
from tunneller_lib.paths import CHORD_PATHS, ChordLaw, geodesic_inverse, path_length
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

READS = ["tests/references/*"]

MACHINE = REFERENCE_MACHINE
CORNERS = np.radians([(0, 40), (95, -40)])  # opposite corners of the joint limits
SUP = 0.0474470131  # of F within them
U = np.linspace(0, 1, 13)
TANGENT_SPHERES = CHORD_PATHS["projected chord"]


def excess(torus, p, q):
    return path_length(torus, TANGENT_SPHERES, p, q) / geodesic_inverse(torus, p, q).length - 1


def scaled(ratio, p=CORNERS[0], q=CORNERS[1]):
    """Return the excess of length over (r/R)^2."""
    return excess(Torus(ratio, 1), p, q) / ratio**2


STEEP = [(CORNERS[0], CORNERS[1]), ((0.1, 0.2), (0.5, 0.45)), ((0, 1.2), (0.9, 1.3)),
         ((0, -1.5), (1e-3, 1.4)), ((2.0, 1.0), (-0.5, 1.0)), ((0, 1e-9), (1.0, 2e-9)),
         ((0.3, 0.2), (0.302, 0.199))]  # fmt: skip


@pytest.mark.parametrize(("p", "q"), STEEP)
def test_gap_is_the_oscillator_s(p, q):
    """By quadrature in 30 digits, where the library has elliptic integrals."""
    with mp.workdps(30):
        chord = short_chords.Chord((0.1, 1), p, q)
        expected = [float(chord.gap(u * chord.angle)) for u in U]
    law = ChordLaw(p, q)
    np.testing.assert_allclose(law.gap(U), expected, atol=3e-15)
    np.testing.assert_allclose(law.pole, np.array(chord.pole, dtype=float), atol=1e-12)
    assert float(chord.angle) == pytest.approx(law.angle, rel=1e-13)


@pytest.mark.parametrize(("turn", "told"), [(6e-6, False), (8e-6, True)])
def test_gap_is_said_to_be_zero_below_the_least_angle(turn, told):
    law = ChordLaw((0, 0.3), (turn, 0.3 + turn))
    assert bool(np.any(law.pole)) == (law.angle >= 1e-5) == told


def test_greatest_excess_in_forty_digits():
    with mp.workdps(40):
        p, q = ([mp.radians(v) for v in end] for end in ((0, 40), (95, -40)))
        chord = short_chords.Chord((mp.mpf("0.1"), 1), p, q)
        t, weights, matrix = short_chords.nodes()
        gap = np.array([chord.gap(share * chord.angle) for share in t])
        slope = matrix @ gap / chord.angle
        second = weights @ (slope**2 - gap**2)
    assert abs(second / 2 - mp.mpf("0.0474470130872")) < 1e-12
    assert ChordLaw(*CORNERS).excess == pytest.approx(float(second / 2), rel=1e-13)
    assert SUP == pytest.approx(float(second / 2), abs=1e-10)


def test_greatest_excess_is_at_opposite_corners():
    turn, phi1, phi2 = np.meshgrid(np.linspace(1, 95, 25), *2 * [np.linspace(-40, 40, 21)])
    p = np.radians(np.stack([0 * turn, phi1], axis=-1))
    q = np.radians(np.stack([turn, phi2], axis=-1))
    F = ChordLaw(p, q).excess
    assert F.max() == pytest.approx(SUP, abs=1e-10)
    at = {(turn.flat[k], phi1.flat[k], phi2.flat[k]) for k in np.flatnonzero(F > SUP - 1e-9)}
    assert at == {(95, 40, -40), (95, -40, 40)}
    # It grows towards the corner from all sides, and nowhere inside is there another summit.
    rng = np.random.default_rng(4)
    bounds = [(1, 95), (-40, 40), (-40, 40)]
    for start in rng.uniform(*np.transpose(bounds), (6, 3)):
        found = minimize(lambda x: -ChordLaw(*np.radians([(0, x[1]), (x[0], x[2])])).excess, start,
                         bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-12})  # fmt: skip
        assert -found.fun <= SUP + 1e-10


@pytest.mark.parametrize("ratio", [1e-2, 1e-3, 1e-4])
def test_excess_is_that_of_tori_near_a_sphere(ratio):
    p, q = joint_pairs(300, seed=1)
    F = ChordLaw(p, q).excess
    off = scaled(ratio, p, q) / F - 1
    # First order in r/R; of two lengths rounding is seen at last, ten of R's, be they as short.
    rounding = 10 * np.spacing(1.0) / geodesic_inverse(Torus(ratio, 1), p, q).length
    assert np.all(np.abs(off) <= 6 * ratio + rounding / (F * ratio**2))


@pytest.mark.parametrize("ratio", [1e-2, 1e-4])
def test_aside_is_that_of_tori_near_a_sphere(ratio):
    p, q = joint_pairs(100, seed=2)
    torus = Torus(ratio, 1)
    # The law's places are those of equal angles; the deviation's sign follows the pole.
    t = np.linspace(0, 1, 129)
    deviation = geodesic_inverse(torus, p, q).points(257).deviation(TANGENT_SPHERES(torus, p, q, t))
    law = ChordLaw(p, q)
    np.testing.assert_allclose(
        np.max(np.abs(deviation), axis=-1) / ratio, law.aside, rtol=3 * ratio + 1e-3, atol=1e-5
    )


def test_law_against_measurement_on_the_machine():
    p, q = joint_pairs(20_000, seed=3)
    torus = MACHINE.torus
    measured = excess(torus, p, q)
    told = measured > 1e-11  # the rest is near rounding
    assert np.mean(told) > 0.98
    ratio = measured[told] / (ChordLaw(p, q).excess[told] * (torus.r / torus.R) ** 2)
    assert 0.79 < ratio.min() < 0.82
    assert 1.11 < ratio.max() < 1.14
    assert np.mean((ratio > 0.83) & (ratio < 1.07)) > 0.965


def test_short_chords_follow_the_short_law():
    """To first order in r/R: tau^2 l^4 / (360 R^2) and kappa tau l^3 / (36 sqrt 3)."""
    phi, alpha = 0.35, 0.7
    ratio = 1e-6
    for size, close in ((0.04, 2e-3), (0.02, 5e-4)):
        ahead = size / 2 * np.array([np.sin(alpha) / np.cos(phi), np.cos(alpha)])
        law = ChordLaw(np.array([0, phi]) - ahead, np.array([0, phi]) + ahead)
        along, around = Torus(ratio, 1).curvatures(0.0, phi)
        torsion = np.sin(alpha) * np.cos(alpha) * (along - around) / ratio
        assert law.excess == pytest.approx(torsion**2 * law.angle**4 / 360, rel=close)
        wide = abs(torsion) * law.angle**3 / (36 * np.sqrt(3))
        assert law.aside == pytest.approx(wide, rel=close + 1e-3)


def test_bound_holds_up_to_the_horn_and_not_on_rings():
    p, q = joint_pairs(3_000, seed=6)
    corners = np.array([CORNERS[0]]), np.array([CORNERS[1]])
    p, q = (np.concatenate(both) for both in zip((p, q), corners, strict=True))
    for ratio in (1, 0.99, 0.9, 0.75, 0.59, 0.5, 0.25, 0.1, 0.01):
        assert 0.0409 < np.max(scaled(ratio, p, q)) <= SUP
    assert scaled(1.1) == pytest.approx(0.0510, abs=5e-5)
    fails = brentq(lambda ratio: scaled(ratio) - SUP, 1, 1.1)
    assert fails == pytest.approx(1.0176623, abs=2e-7)


def test_table_of_short_chords_is_what_its_script_writes():
    header, rows = tables.read(short_chords.TABLE)
    assert header == short_chords.COLUMNS
    assert len(rows) == 48
    assert rows[0] == next(short_chords.rows())
