"""The appendix' chord: table, geodesic, tangent-sphere path, lengths, deviation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import tanhsinh

from tests.draws import log_uniform
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
    """Return the path's length in space, by the speed of the foot of M(t), a complex step."""
    p, q = ends(chord)
    sine, cosine = np.sin(chord.cone.half_angle), np.cos(chord.cone.half_angle)

    def speed(t):
        x, y, z = np.moveaxis(p + (t + 1e-30j)[..., None] * (q - p), -1, 0)
        rho = np.sqrt(x * x + y * y)
        along = rho * sine - z * cosine
        foot = np.array([x / rho * along * sine, y / rho * along * sine, -along * cosine])
        return np.sqrt(np.sum((foot.imag / 1e-30) ** 2, axis=0))

    flat, way = p[:2], (q - p)[:2]
    nearest = np.clip(-(flat @ way) / (way @ way), 0, 1)  # there the foot turns fastest
    return tanhsinh(speed, [0, nearest], [nearest, 1], rtol=1e-12).integral.sum()


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


@pytest.mark.parametrize("f", [0.5, -1.5, 0.5 + 1e-9, 3.0])
def test_chords_of_whole_and_half_turns_are_refused(f):
    with pytest.raises(ValueError, match=r"^f: "):
        ConeChord(1, 1, 0.5, f)
