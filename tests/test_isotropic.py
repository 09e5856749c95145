"""Planes to points and back, what spheres and cones become, and tangents of curves."""

import numpy as np
import pytest

from tests.draws import directions
from tunneller_lib.envelopes.developable import curve_derivatives, osculating_cone, tangent_planes
from tunneller_lib.envelopes.families import cubic, helix
from tunneller_lib.envelopes.isotropic import (
    cone_planes,
    cone_rulings,
    cone_vertex,
    plane_azimuth,
    plane_to_point,
    top_circle,
)

RNG = np.random.default_rng(5)


def test_plane_to_point_keeps_digits_near_the_one_that_has_none():
    n = np.array([3e-9, 4e-9, -1.0])
    np.testing.assert_allclose(plane_to_point(n, 1.0), [2.4e8, 3.2e8, 8e16], rtol=1e-14)


@pytest.mark.parametrize("n", [(0, 0, -5.0), [(0, 0, 1), (0, 0, -1)], (1e-99, 0, -9e99)])
def test_a_plane_without_point_is_refused(n):
    with pytest.raises(ValueError, match=r"^n: a normal must not have the direction \(0, 0, -1\)"):
        plane_to_point(n, 1e20)


# ---- cones and conics -----------------------------------------------------------------------


def test_cone_planes_touch_the_cone_along_its_rulings():
    axis = directions(RNG, 9)
    n, h = cone_planes((1, 2, 3), 7 * axis, 0.4, 0.7)
    np.testing.assert_allclose(n @ [1, 2, 3] + h, 0, atol=1e-14)
    np.testing.assert_allclose((n * axis).sum(-1), np.sin(0.4), rtol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(n, axis=-1), 1, rtol=1e-14)
    ruling = cone_rulings(7 * axis, 0.4, 0.7)
    np.testing.assert_allclose((n * ruling).sum(-1), 0, atol=1e-14)
    np.testing.assert_allclose((ruling * axis).sum(-1), np.cos(0.4), rtol=1e-13)


@pytest.mark.parametrize("half_angle", [0.01, 0.5, 1.5])
def test_plane_azimuth_is_the_one_that_made_the_plane(half_angle):
    axis, azimuth = directions(RNG, 50)[:, None], np.linspace(-3.1, 3.1, 40)
    n, _ = cone_planes((1, 2, 3), 7 * axis, half_angle, azimuth)
    found = plane_azimuth(7 * axis, half_angle, n)
    np.testing.assert_allclose(found, np.broadcast_to(azimuth, (50, 40)), atol=1e-11)


def test_top_circle_holds_the_points_of_a_cones_planes():
    axis = directions(RNG, 30)
    centre, radius = top_circle(axis, 0.4)
    for azimuth in (0.3, 2.0, 4.0):
        place = plane_to_point(*cone_planes((1, 2, 3), axis, 0.4, azimuth))[:, :2]
        np.testing.assert_allclose(np.linalg.norm(place - centre, axis=-1), radius, rtol=1e-9)


def test_top_circle_refuses_a_cone_with_the_plane_that_has_no_point():
    with pytest.raises(ValueError, match=r"^axis: no plane .* \(0, 0, -1\); got one\.$"):
        top_circle((0.0, 0.8, -0.6), np.arcsin(0.6))


@pytest.mark.parametrize(("given", "message"), [
    (((0, 0, 0), (0.0, 0.0), 1, 1), r"^centre: must not be the point itself, \(0, 0\); got"),
    (((1, 0, 0), (-1.0, 1.0), 1, 1), r"^centre: must not be that of a cylinder, which has no"),
    (((1, 0, 0), (1.0, 1.0), 1, 1e70), r"^point, centre, a, b: must be at most 1e\+60 in size"),
])  # fmt: skip
def test_conics_without_a_vertex_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        cone_vertex(*given)


# ---- tangents of a curve --------------------------------------------------------------------

CURVES = {"cubic": lambda s: cubic(s, bend=0.8)[0], "helix": lambda s: helix(s)[0]}


def gap(curve, s, step):
    """Return how far a neighbouring plane's normal lies from the osculating cone's circle."""
    _, axis, half_angle = osculating_cone(curve, s)
    centre, radius = top_circle(axis, half_angle)
    place = plane_to_point(*tangent_planes(curve, s + step))[:2]
    return abs(np.hypot(*(place - centre)) - radius)


def test_derivatives_are_those_of_the_curve():
    s = np.linspace(-1, 2, 7)
    known = [*cubic(s, bend=0.8), [0, 0, 1]]  # the third derivative of s^3/6
    for got, expected in zip(curve_derivatives(CURVES["cubic"], s), known, strict=True):
        np.testing.assert_allclose(got, np.stack([c + 0 * s for c in expected], -1), atol=1e-15)


def test_osculating_cone_holds_the_tangent_and_its_plane_and_all_normals_of_a_helix():
    s = np.linspace(-0.5, 1.5, 9)
    vertex, axis, angle = osculating_cone(CURVES["cubic"], s)
    point, velocity, *_ = curve_derivatives(CURVES["cubic"], s)
    tangent = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.sum(axis * tangent, axis=-1), np.cos(angle), atol=1e-14)
    n, h = tangent_planes(CURVES["cubic"], s)
    np.testing.assert_allclose(np.sum(axis * n, axis=-1), np.sin(angle), atol=1e-14)
    np.testing.assert_array_equal(vertex, point)
    np.testing.assert_allclose(np.sum(n * vertex, axis=-1) + h, 0, atol=1e-14)
    assert max(gap(CURVES["helix"], 0.3, step) for step in (0.1, 1.0, 2.0)) < 1e-14


@pytest.mark.parametrize("function", [tangent_planes, osculating_cone])
def test_no_plane_in_a_point_of_inflexion(function):
    with pytest.raises(ValueError, match=r"^curve: must have no point of inflexion .*; got one\.$"):
        function(lambda s: [s, s**3, 0.0], [0.5, 0.0])
