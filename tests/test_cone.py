"""The cone: implicit form, feet and development."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.draws import EPS
from tunneller_lib.surfaces import Cone

angles = st.floats(0.01, 1.56)
points = st.tuples(*[st.floats(-10, 10).map(lambda c: round(c, 60))] * 3)


@given(angles, st.floats(-1e6, 1e6), st.floats(-10, 10))
def test_point_lies_on_the_cone_at_its_distance(half_angle, distance, azimuth):
    cone = Cone(half_angle)
    point = cone.point(distance, azimuth)
    assert np.linalg.norm(point) == pytest.approx(abs(distance), rel=4 * EPS)
    assert abs(cone.implicit(point)) <= 16 * EPS * (point @ point) / np.cos(half_angle)
    assert np.sign(point[2]) == -np.sign(distance)


@given(angles, points, st.sampled_from([1e-3, 1, 1e6]))
def test_feet_lie_on_the_cone_and_see_m_at_right_angles(half_angle, where, scale):
    cone, m = Cone(half_angle), scale * np.array(where)
    size = np.linalg.norm(m)
    radius, height = np.hypot(cone.feet(m)[:, 0], cone.feet(m)[:, 1]), np.abs(cone.feet(m)[:, 2])
    off = radius * np.cos(half_angle) - height * np.sin(half_angle)
    assert np.all(np.abs(off) <= 8 * EPS * size)
    for foot in cone.feet(m):
        assert abs((m - foot) @ foot) <= 16 * EPS * size**2
        across = np.cross(foot, [0, 0, 1])  # the other tangent, round the cone
        assert abs((m - foot) @ across) <= 16 * EPS * size**2


@pytest.mark.parametrize("m, feet", [
    ((0, 0, 0), [(0, 0, 0), (0, 0, 0)]),
    ((0, 0, -2), [(1, 0, -1), (-1, 0, -1)]),  # on the axis: azimuth 0 first
    ((0, 0, 2), [(1, 0, 1), (-1, 0, 1)]),
    ((2, 0, 0), [(1, 0, -1), (1, 0, 1)]),  # equally far: the nappe below first
    ((0, -2, 0), [(0, -1, -1), (0, -1, 1)]),
    ((3, 0, -3), [(3, 0, -3), (0, 0, 0)]),  # on the cone: itself, and the apex
])  # fmt: skip
def test_feet_of_degenerate_points(m, feet):
    np.testing.assert_allclose(Cone(np.pi / 4).feet(m), feet, atol=2e-15)


@given(angles, st.floats(0.1, 10), st.floats(0.1, 10), st.floats(-3, 3), st.floats(-3, 3))
def test_development_keeps_lengths_along_and_round(half_angle, one, other, start, stop):
    cone = Cone(half_angle)
    plane = cone.development([one, other], [start, start])
    assert np.linalg.norm(plane[1] - plane[0]) == pytest.approx(abs(other - one), abs=1e-13)
    turn = np.linspace(start, stop, 2001)
    for curve in (cone.development(one, turn), cone.point(one, turn)):
        length = np.sum(np.linalg.norm(np.diff(curve, axis=0), axis=-1))
        exact = one * np.sin(half_angle) * abs(stop - start)
        assert length == pytest.approx(exact, rel=1e-5, abs=1e-12)
