"""A cone where it stands, and the sequence of cones that touch a surface."""

import numpy as np
import pytest

from tunneller_lib.envelopes import ConePose, hyperosculating_cones
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.isotropic import plane_to_point

TOOL = ConePose((0.3, -0.2, 1.0), (1.0, 2.0, 2.0), 0.4, near=0.5, far=2.0)
AZIMUTH = np.linspace(0, 6, 13)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_mesh_planes_and_clearance_are_of_one_cone(scale):
    vertex = tuple(scale * np.array(TOOL.vertex))
    tool = ConePose(vertex, TOOL.axis, 0.4, near=0.5 * scale, far=2 * scale)
    wall = tool.mesh(5, 7)
    assert wall.shape == (5, 7, 3)
    assert np.abs(tool.clearance(wall)).max() < 1e-14 * scale
    away = np.linalg.norm(wall - vertex, axis=-1)
    np.testing.assert_allclose(away, scale * np.linspace(0.5, 2, 5)[:, None] + 0 * away, rtol=1e-13)
    # Once around in equal steps, along the near rim as along every other.
    rim = wall[0]
    np.testing.assert_allclose(rim[0], rim[-1], atol=1e-14 * scale)
    edge = 2 * 0.5 * scale * np.sin(0.4) * np.sin(np.pi / 6)
    np.testing.assert_allclose(np.linalg.norm(np.diff(rim, axis=0), axis=-1), edge, rtol=1e-12)
    n, h = tool.planes(AZIMUTH)
    # Every plane holds the vertex and has the wall on its own side, where its normal points.
    np.testing.assert_allclose(n @ np.array(vertex) + h, 0, atol=1e-14 * scale)
    assert (np.einsum("ijk,lk->ijl", wall, n) + h).min() > -1e-14 * scale
    inside = np.array(vertex) + scale * np.array(TOOL.axis) / 3
    assert tool.clearance(inside) == pytest.approx(-scale * min(np.sin(0.4), 1 - 0.5 * np.cos(0.4)))


def test_planes_lie_over_the_circle():
    centre, radius = TOOL.circle()
    points = plane_to_point(*TOOL.planes(AZIMUTH))
    np.testing.assert_allclose(np.hypot(*(points[:, :2] - centre).T), radius, rtol=1e-13)


@pytest.mark.parametrize(("change", "message"), [
    ({"axis": (0, 0, 0)}, r"^axis: must not be zero; got \(0, 0, 0\)\.$"),
    ({"near": 2.0}, r"^near: must be below far; got 2 and 2\.$"),
    ({"half_angle": 0}, r"^half_angle: must lie between 0 and pi/2, .*; got 0\.0\.$"),
    ({"far": -1}, r"^far: "),
])  # fmt: skip
def test_wrong_cones_are_refused(change, message):
    options = {"vertex": (0, 0, 0), "axis": (0, 0, 1), "half_angle": 0.4, "near": 0.5, "far": 2.0}
    with pytest.raises(ValueError, match=message):
        ConePose(**(options | change))


def test_cones_are_a_sequence_of_what_the_arrays_hold():
    cones = hyperosculating_cones(cyclide, [0.5, 0.9], [0.3, 0.6], half_angle=np.radians(30))
    assert len(cones) == len(list(cones)) == 12
    for k, cone in enumerate(cones):
        assert cone.pose.vertex == tuple(cones.vertex[k]) and cone.side == cones.side[k]
        assert cone.verdict == ("gouges" if cones.gouges[k] else "undecided")
        assert cone.pose.far == 2 * cones.distance[k]
        assert abs(cone.pose.clearance(cone.contact)) < 1e-12 * cone.pose.far
        # Among its planes is the surface's own at the contact.
        n, h = cone.planes(np.linspace(0, 2 * np.pi, 100_001))
        nearest = np.argmax(n @ cone.normal)
        assert n[nearest] @ cone.normal == pytest.approx(1, abs=1e-8)
        assert abs(n[nearest] @ cone.contact + h[nearest]) < 1e-3 * cone.pose.far
    assert cones[-1].multiplicity == cones[11].multiplicity == 1
    for k in (12, -13):
        with pytest.raises(IndexError):
            cones[k]
    cones.vertex[0] = np.nan  # an object doesn't change with the arrays it came from
    assert np.isfinite(cone.contact).all()


def test_double_cone_has_its_multiplicity():
    x = 1 / np.tan(np.radians(30))
    cones = hyperosculating_cones(cyclide, x * 0.6, x * 0.8, half_angle=np.radians(30))
    assert sorted(cone.multiplicity for cone in cones) == [1] * (len(cones) - 1) + [2]


def test_tool_reaches_from_the_contact_as_far_as_it_is_long():
    for cone in hyperosculating_cones(cyclide, 0.5, 0.3, half_angle=0.5):
        distance = np.linalg.norm(cone.contact - cone.pose.vertex)
        tool = cone.tool(0.1, 0.4)
        assert (distance - tool.near, tool.far - distance) == pytest.approx((0.1, 0.4))
        assert cone.tool(10.0, 0.4).near == pytest.approx(0.2 * distance)
        assert abs(tool.clearance(cone.contact)) < 1e-14
