"""Tangents of a curve: their planes, and the cones that osculate them."""

import numpy as np
import pytest

from tunneller_lib.envelopes.conics import top_circle
from tunneller_lib.envelopes.developable import curve_derivatives, osculating_cone, tangent_planes
from tunneller_lib.envelopes.families import cubic, helix
from tunneller_lib.envelopes.isotropic import plane_to_point

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


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_tangent_planes_hold_neighbouring_points(name, scale):
    def curve(s):
        return [scale * c for c in CURVES[name](s)]

    n, h = tangent_planes(curve, 0.4)
    away = [abs(n @ np.array(curve(0.4 + step)) + h) / scale for step in (1e-3, 2e-3)]
    assert away[1] < 1e-8 and away[1] / away[0] == pytest.approx(8, rel=0.01)


@pytest.mark.parametrize("function", [tangent_planes, osculating_cone])
def test_no_plane_in_a_point_of_inflexion(function):
    with pytest.raises(ValueError, match=r"^curve: must have no point of inflexion .*; got one\.$"):
        function(lambda s: [s, s**3, 0.0], [0.5, 0.0])


def test_tangent_planes_of_a_plane_curve_are_its_plane():
    n, h = tangent_planes(lambda s: [np.cos(s), np.sin(s), 3.0], [0.1, 2.0])
    np.testing.assert_allclose(n, [[0, 0, 1], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(h, -3)


@pytest.mark.parametrize(("name", "s", "power"), [
    ("cubic", 0.7, 3), ("cubic", -0.3, 3), ("cubic", 0.0, 4),
])  # fmt: skip
def test_normals_leave_the_cones_at_third_order_or_at_fourth(name, s, power):
    gaps = [gap(CURVES[name], s, step) for step in (0.01, 0.02)]
    assert np.log2(gaps[1] / gaps[0]) == pytest.approx(power, abs=0.15)


@pytest.mark.parametrize(("name", "s"), [("cubic", 0.7), ("cubic", 0.0), ("helix", 0.3)])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_planes_leave_the_vertex_at_third_order(name, s, scale):
    """By curvature times torsion over 6 times the arc's third power, also at such a place."""

    def curve(s):
        return [scale * c for c in CURVES[name](s)]

    vertex, *_ = osculating_cone(curve, s)
    n, h = tangent_planes(curve, s + 1e-3)
    _, v, a, third = curve_derivatives(curve, s)
    volume = np.dot(np.cross(v, a), third) / np.linalg.norm(np.cross(v, a))
    assert (n @ vertex + h) / scale == pytest.approx(-volume / scale * 1e-9 / 6, rel=0.01)


def test_osculating_cone_of_a_helix_holds_all_its_normals():
    assert max(gap(CURVES["helix"], 0.3, step) for step in (0.1, 1.0, 2.0)) < 1e-14


def test_osculating_cone_holds_the_tangent_and_has_its_plane():
    s = np.linspace(-0.5, 1.5, 9)
    vertex, axis, angle = osculating_cone(CURVES["cubic"], s)
    point, velocity, *_ = curve_derivatives(CURVES["cubic"], s)
    tangent = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.sum(axis * tangent, axis=-1), np.cos(angle), atol=1e-14)
    n, h = tangent_planes(CURVES["cubic"], s)
    np.testing.assert_allclose(np.sum(axis * n, axis=-1), np.sin(angle), atol=1e-14)
    np.testing.assert_array_equal(vertex, point)
    np.testing.assert_allclose(np.sum(n * vertex, axis=-1) + h, 0, atol=1e-14)
