"""The tangent-sphere path of a chord: where it runs, how its points are spaced, how long it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

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
