"""The appendix' chord: table, geodesic, tangent-sphere path, lengths, deviation."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.integrate import quad

from tests.shapes import log_uniform
from tunneller_lib.paths import ConeChord

lengths = log_uniform(0.1, 10)
fractions = st.floats(-3, 3).filter(lambda f: 0.01 < abs(2 * f - round(2 * f)))
chords = st.builds(ConeChord, lengths, lengths, lengths, fractions)


def ends(chord):
    return chord.cone.point(chord.ends, [0.0, chord.turn])


@given(chords)
def test_ends_are_the_documents_points(chord):
    R, H, h = chord.R, chord.H, chord.h
    turn = 2 * np.pi * chord.f
    expected = [(R, 0, -H), (R * h / H * np.cos(turn), R * h / H * np.sin(turn), -h)]
    np.testing.assert_allclose(ends(chord), expected, atol=1e-13 * (R + H + h + R * h / H))


@given(chords, st.floats(0, 1))
def test_tangent_sphere_is_the_nearer_foot_of_the_chord(chord, share):
    azimuth = share * chord.turn
    m = chord.chord_point(azimuth)
    foot = chord.cone.feet(m)[0]
    assert chord.tangent_sphere(azimuth) == pytest.approx(np.linalg.norm(foot), rel=1e-12)


def length_on_the_cone(chord):
    """Return the path's length in space, by the speed of the foot of M(t) in mpmath."""
    with mp.workdps(30):
        p, q = ([mpf(c) for c in end] for end in ends(chord))
        ruling = mp.cos(chord.cone.half_angle), mp.sin(chord.cone.half_angle)

        def foot(t):
            x, y, z = (a + t * (b - a) for a, b in zip(p, q, strict=True))
            rho = mp.sqrt(x * x + y * y)
            along = rho * ruling[1] - z * ruling[0]
            return x / rho * along * ruling[1], y / rho * along * ruling[1], -along * ruling[0]

        def speed(t):
            rate = [mp.diff(lambda u, i=i: foot(u)[i], t) for i in range(3)]
            return float(mp.sqrt(sum(c * c for c in rate)))

        nearest = -float(np.dot(p[:2], np.subtract(q, p)[:2]) / np.sum(np.subtract(q, p)[:2] ** 2))
        parts = [0, *([nearest] if 0 < nearest < 1 else []), 1]  # there the foot turns fastest
        return sum(quad(speed, *part, epsabs=0, epsrel=1e-11, limit=200)[0]
                   for part in pairwise(parts))  # fmt: skip


@pytest.mark.parametrize("R, H, h, f", [
    (1, 1, 0.5, 0.25), (1, 1, 0.5, -0.25), (2, 1, 3, 0.1), (0.1, 5, 4, 0.3), (1, 2, 1, 0.7),
    (1, 1, 1, 1.2), (3, 0.5, 0.4, 0.4), (1e6, 1e6, 5e5, 0.25), (1e-3, 1e-3, 5e-4, 0.35),
    (1, 1, 0.5, 0.45), (1, 1, 0.5, 0.49), (1, 1, 0.5, 0.499), (1, 1, 0.5, 0.501),
])  # fmt: skip
def test_path_length_against_quadrature_in_space(R, H, h, f):
    chord = ConeChord(R, H, h, f)
    assert chord.path_length == pytest.approx(length_on_the_cone(chord), rel=1e-10, abs=0)


@given(chords, st.floats(0.01, 0.99))
def test_deviation_has_the_sign_of_the_tables_last_column(chord, u):
    if abs(chord.deviation(u)) > 1e-9 * sum(chord.ends):
        assert np.sign(chord.deviation(u)) == np.sign(chord.table(u)[4])


@given(chords, st.integers(-3, 3))
def test_whole_turns_are_left_out(chord, turns):
    more = ConeChord(chord.R, chord.H, chord.h, chord.f + turns)
    assert more.path_length == pytest.approx(chord.path_length, rel=1e-10)
    assert more.geodesic_length == pytest.approx(chord.geodesic_length, rel=1e-10)


@given(chords, st.floats(0, 1))
def test_mirrored_chords_have_mirrored_paths(chord, u):
    mirrored = ConeChord(chord.R, chord.H, chord.h, -chord.f)
    np.testing.assert_allclose(mirrored.path(u), chord.path(u) * [1, -1], atol=1e-13)
    assert mirrored.deviation(u) == pytest.approx(chord.deviation(u), abs=1e-13)
    assert mirrored.path_length == pytest.approx(chord.path_length, rel=1e-12)
