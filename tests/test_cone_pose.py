"""Cones where they stand: the sequence of those that touch a surface, and a ring of blades."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from tunneller_lib.envelopes import ConePose, hyperosculating_cones
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.isotropic import plane_to_point
from tunneller_lib.milling.faces import BladeRing

TOOL = ConePose((0.3, -0.2, 1.0), (1.0, 2.0, 2.0), 0.4, near=0.5, far=2.0)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.004, 6)
AZIMUTH = np.linspace(0, 6, 13)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_mesh_and_planes_are_of_one_cone(scale):
    vertex = scale * np.array(TOOL.vertex)
    tool = ConePose(vertex, TOOL.axis, 0.4, near=0.5 * scale, far=2 * scale)
    wall = tool.mesh(5, 7)
    assert np.abs(tool.clearance(wall)).max() < 1e-14 * scale
    away = np.linalg.norm(wall - vertex, axis=-1)
    np.testing.assert_allclose(away, scale * np.linspace(0.5, 2, 5)[:, None] + 0 * away, rtol=1e-13)
    edge = 2 * 0.5 * scale * np.sin(0.4) * np.sin(np.pi / 6)  # once around in equal steps
    rim = np.linalg.norm(np.diff(wall[0], axis=0), axis=-1)
    np.testing.assert_allclose(rim, edge, rtol=1e-12)
    # Every plane holds the vertex and has the wall on its own side, where its normal points.
    n, h = tool.planes(AZIMUTH)
    np.testing.assert_allclose(n @ vertex + h, 0, atol=1e-14 * scale)
    assert (np.einsum("ijk,lk->ijl", wall, n) + h).min() > -1e-14 * scale
    centre, radius = tool.circle()
    place = plane_to_point(n, h)[:, :2]
    np.testing.assert_allclose(np.hypot(*(place - centre).T), radius, rtol=1e-13)


def test_clearance_is_that_of_sampled_walls_and_ends():
    wall = TOOL.mesh(301, 721)
    axis = np.array(TOOL.axis) / 3
    middle = TOOL.vertex + np.cos(0.4) * np.array([[TOOL.near], [TOOL.far]]) * axis
    caps = middle[:, None, None] + np.linspace(0, 1, 101)[:, None, None] * (
        wall[[0, -1], None] - middle[:, None, None]
    )
    solid = np.concatenate([wall.reshape(-1, 3), caps.reshape(-1, 3)])
    rng = np.random.default_rng(5)
    points = TOOL.vertex + rng.uniform(0, 2.3, (200, 1)) * axis + 0.5 * rng.normal(size=(200, 3))
    found = TOOL.clearance(points)
    np.testing.assert_allclose(np.abs(found), KDTree(solid).query(points)[0], atol=0.01)
    depth = (points - TOOL.vertex) @ axis
    lean = np.arccos(depth / np.linalg.norm(points - TOOL.vertex, axis=-1))
    between = (depth > TOOL.near * np.cos(0.4)) & (depth < TOOL.far * np.cos(0.4))
    np.testing.assert_array_equal(found < 0, (lean < 0.4) & between)
    assert np.count_nonzero(found < 0) > 20
    # By hand: on the axis beyond either end, and off the wall's middle along its normal.
    for share, gap in ((0.25 * np.cos(0.4), 0.25), (2 * np.cos(0.4) + 0.5, 0.5 / np.cos(0.4))):
        there = TOOL.clearance(TOOL.vertex + share * axis)
        assert there == pytest.approx(gap * np.cos(0.4), rel=1e-14)
    n, _ = TOOL.planes(0.0)
    assert TOOL.clearance(TOOL.mesh(3, 73)[1, 0] - 0.3 * n) == pytest.approx(0.3, rel=1e-13)


def test_a_cone_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValueError, match=r"^near: must be below far; got 2 and 2\.$"):
        replace(TOOL, near=2.0)


def test_cones_are_a_sequence_of_what_the_arrays_hold():
    cones = hyperosculating_cones(cyclide, [0.5, 0.9], [0.3, 0.6], half_angle=np.radians(30))
    assert len(cones) == len(list(cones)) == 12
    for k, cone in enumerate(cones):
        assert cone.pose.vertex == tuple(cones.vertex[k]) and cone.side == cones.side[k]
        assert cone.verdict == ("gouges" if cones.gouges[k] else "undecided")
        assert cone.pose.far == 2 * cones.distance[k]
        assert abs(cone.pose.clearance(cone.contact)) < 1e-12 * cone.pose.far
        n, _ = cone.planes(np.linspace(0, 2 * np.pi, 10_001))
        assert np.max(n @ cone.normal) == pytest.approx(1, abs=1e-6)  # the surface's own is one
    for k in (12, -13):
        with pytest.raises(IndexError):
            cones[k]
    cones.contact[-1] = np.nan  # an object doesn't change with the arrays it came from
    assert np.isfinite(cone.contact).all()


def test_tool_reaches_from_the_contact_as_far_as_it_is_long():
    for cone in hyperosculating_cones(cyclide, 0.5, 0.3, half_angle=0.5):
        distance = np.linalg.norm(cone.contact - cone.pose.vertex)
        tool = cone.tool(0.1, 0.4)
        assert (distance - tool.near, tool.far - distance) == pytest.approx((0.1, 0.4))
        assert cone.tool(10.0, 0.4).near == pytest.approx(0.2 * distance)
        assert abs(tool.clearance(cone.contact)) < 1e-14


# ---- the blade ring ---------------------------------------------------------------------------


def test_blades_are_turned_copies_on_the_hub():
    first, other = RING.mesh(5), RING.mesh(5, 2)
    np.testing.assert_allclose(np.linalg.norm(first[0, :, :2], axis=-1), 0.06)
    np.testing.assert_allclose(np.linalg.norm(first[-1, :, :2], axis=-1), 0.09)
    moved = 2 * np.sin(np.pi / 3) * np.linalg.norm(first[..., :2], axis=-1)
    np.testing.assert_allclose(np.linalg.norm(first - other, axis=-1), moved)


@pytest.mark.parametrize(("s", "slope"), [(0, -0.7), (0.5, -0.1), (1, 0.5)])
def test_blade_has_its_stagger_twist_camber_and_bow(s, slope):
    # Unrolled at one height: ends of the chord on a straight line, its middle aside by the camber.
    radius, bow = 0.06 + 0.03 * s, -0.004 * s**2
    x, y, z = RING.coordinates(np.full(3, s), np.array([0, 0.5, 1]))
    arc = radius * np.arctan2(y, x)
    np.testing.assert_allclose(z, 0.05 * np.cos(slope) * np.array([-0.5, 0, 0.5]), atol=1e-15)
    ends = 0.025 * np.sin(slope)
    np.testing.assert_allclose(arc, [-ends + bow, bow - 0.006, ends + bow], rtol=1e-12)


def test_clearances_are_from_the_first_blade_and_both_neighbours():
    x, y, _ = RING.coordinates(0.5, 0.5)
    out = np.array([x, y, 0.0]) / np.hypot(x, y)
    around = np.cross((0, 0, 1.0), out)
    # A tool in the middle of the gap to the next blade, then moved into that blade.
    free, hit, back = (
        ConePose(0.04 * way, way, 0.05, near=0.03, far=0.06)
        for way in (np.cos(turn) * out + np.sin(turn) * around
                    for turn in (np.pi / 6, np.pi / 3, -np.pi / 3))
    )  # fmt: skip
    assert np.all(RING.clearances(free) > 0)
    np.testing.assert_allclose(RING.clearances(free, n=241), RING.clearances(free), atol=1e-4)
    own, following, last = RING.clearances(hit, n=241)
    assert following < 0 < min(own, last)
    assert RING.clearances(back, n=241)[2] < 0
