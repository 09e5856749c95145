"""The tangent-sphere path of a chord: where it runs, how its points are spaced, how long it is."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.integrate import quad

from tests.shapes import log_uniform
from tunneller_lib.paths import CHORD_PATHS, path_length, project_chord
from tunneller_lib.surfaces import Torus

MACHINE = Torus(0.08, 0.8)
PROJECTED = CHORD_PATHS["projected chord"]
P, Q = (-0.9, -0.6), (0.5, 0.4)
SPACINGS = ("chord", "tangent", "arc")
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)

joints = st.tuples(st.floats(-1, 0.6), st.floats(-0.7, 0.7))
working = st.builds(lambda s, k: Torus(s, s * k), log_uniform(1e-3, 1e6), log_uniform(1, 1e4))


def points(torus, path):
    return torus.point(path[..., 0], path[..., 1])


@every_spacing
@given(working, joints, joints)
def test_project_chord_runs_over_feet_of_the_chord(spacing, torus, p, q):
    start, stop = torus.point(*p), torus.point(*q)
    path = points(torus, project_chord(torus, p, q, 9, spacing=spacing))
    chord = stop - start
    length = np.linalg.norm(chord)
    if length < 1e-3 * torus.R:
        return
    # Normals meet the chord: ring point, path point and the chord's line lie in one plane.
    rho = np.hypot(path[:, 0], path[:, 2])[:, None]
    ring = torus.r * path * [1, 0, 1] / rho
    volume = np.einsum("ni,ni->n", np.cross(path - ring, chord), start - ring)
    assert np.max(np.abs(volume)) <= 1e-13 * length * torus.R * (torus.r + torus.R)


@pytest.mark.parametrize("spacing", ["tangent", "arc"])
def test_project_chord_on_a_sphere_is_an_even_great_circle(spacing):
    sphere = Torus(1e-12, 1)
    path = points(sphere, project_chord(sphere, P, Q, 11, spacing=spacing))
    plane = np.cross(path[0], path[-1])
    assert np.max(np.abs(path @ plane)) <= 1e-11
    turns = np.arccos(np.sum(path[1:] * path[:-1], axis=-1))
    np.testing.assert_allclose(turns, np.mean(turns), rtol=1e-10)
    total = np.arccos(path[0] @ path[-1])
    assert path_length(sphere, PROJECTED, P, Q) == pytest.approx(total, rel=1e-11)


def test_project_chord_with_chord_spacing_takes_even_steps_along_the_chord():
    path = points(MACHINE, project_chord(MACHINE, P, Q, 5))
    start, stop = path[0], path[-1]
    for k in range(1, 4):
        m = start + k / 4 * (stop - start)
        np.testing.assert_allclose(MACHINE.foot(m), path[k], atol=1e-14)


@pytest.mark.parametrize("torus, p, q", [
    (MACHINE, P, Q),
    (MACHINE, (-1, -0.7), (0.6, 0.7)),
    (MACHINE, (-1, 0), (0.6, 0)),
    (Torus(1e3, 3e3), P, Q),
    (Torus(1e-3, 2e-4), (-0.3, -0.6), (0.3, 0.4)),  # a thin ring, its chord outside the tube
    (MACHINE, (0, 1.134), (2.618, -1.134)),  # through several panels
    (Torus(0.2, 0.8), (0, 0.698), (1.658, -0.698)),
    (Torus(1, 0.2), (-0.7, 0.09), (0.5, -0.09)),  # close by the ring circle
], ids=str)  # fmt: skip
def test_project_chord_with_arc_spacing_splits_the_length_evenly(torus, p, q):
    n = 5
    path = project_chord(torus, p, q, n, spacing="arc")
    start, stop = torus.point(*p), torus.point(*q)
    foot = path_by_mpmath(torus, start, stop)
    t = [share_of_chord(start, stop, torus, point) for point in path]
    arcs = [arc_length(foot, *ends) for ends in pairwise(t)]
    np.testing.assert_allclose(arcs, np.mean(arcs), rtol=1e-10)
    assert np.sum(arcs) == pytest.approx(path_length(torus, PROJECTED, p, q), rel=1e-11)


def path_by_mpmath(torus, start, stop):
    """Return the foot N(t) of M(t) on a chord, by vectors from the ring's point."""
    start, chord = (
        [mpf(c) for c in start],
        [mpf(b) - mpf(a) for a, b in zip(start, stop, strict=True)],
    )

    def foot(t):
        m = [a + t * c for a, c in zip(start, chord, strict=True)]
        scale = mpf(torus.r) / mp.sqrt(m[0] ** 2 + m[2] ** 2)
        ring = [m[0] * scale, mpf(0), m[2] * scale]
        away = [a - b for a, b in zip(m, ring, strict=True)]
        length = mp.sqrt(sum(c * c for c in away))
        return [a + torus.R * b / length for a, b in zip(ring, away, strict=True)]

    return foot


def share_of_chord(start, stop, torus, position):
    """Return t where the normal of a position comes nearest to the chord."""
    chord, normal = stop - start, torus.normal(*position)
    offset = torus.point(*position) - start
    return np.linalg.lstsq(np.stack([chord, -normal], axis=-1), offset, rcond=None)[0][0]


def arc_length(foot, low, high):
    def speed(t):
        rate = [mp.diff(lambda u, i=i: foot(u)[i], t) for i in range(3)]
        return float(mp.sqrt(sum(c * c for c in rate)))

    return quad(speed, low, high, epsabs=0, epsrel=1e-11)[0]


@every_spacing
def test_project_chord_along_a_meridian_and_the_equator_stays_there(spacing):
    meridian = project_chord(MACHINE, (0.2, -0.5), (0.2, 0.7), 9, spacing=spacing)
    np.testing.assert_allclose(meridian[:, 0], 0.2, atol=1e-14)
    equator = project_chord(MACHINE, (-0.9, 0), (0.5, 0), 9, spacing=spacing)
    np.testing.assert_allclose(equator[:, 1], 0, atol=1e-14)


@pytest.mark.parametrize("spacing", ["chord", "tangent"])
@pytest.mark.parametrize("torus", [MACHINE, Torus(2, 1)], ids=str)
def test_project_chord_through_the_axis_gives_finite_points(spacing, torus):
    path = project_chord(torus, (0, 0.3), (np.pi, -0.3), 5, spacing=spacing)
    assert np.all(np.isfinite(path))
    np.testing.assert_allclose(path[[0, -1]], [(0, 0.3), (np.pi, -0.3)], atol=1e-13)
