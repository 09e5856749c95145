"""What a mill must stay off beside its patch: between the points of a grid it is seen, too."""

import numpy as np
import pytest

from tunneller_lib.envelopes.blade import BladeRing
from tunneller_lib.milling import ConicalMill, Patch, find_positions
from tunneller_lib.milling.obstacles import Obstacles, as_obstacles
from tunneller_lib.milling.tools import seen_from

MM = 1e-3
DEG = np.pi / 180
MILL = ConicalMill(8 * DEG, 0.5 * MM, 100 * MM, 12 * MM, 40 * MM)


def depth_of(points, tip, axis):
    """Return how deep one mill enters points (n, 3)."""
    seen = seen_from(points, tip[None], axis[None])
    return max(0.0, -float(np.minimum(MILL.cutting(*seen), MILL.holder(*seen)).min()))


def standing(rng, count, low):
    """Return tips (count, 3) at heights from `low` to 2 mm, and axes that lean at random."""
    tip = rng.uniform([-20 * MM, -20 * MM, low], [20 * MM, 20 * MM, 2 * MM], (count, 3))
    axis = rng.normal(size=(count, 3)) * [0.5, 0.5, 0] + [0, 0, 1]
    return tip, axis / np.linalg.norm(axis, axis=1)[:, None]


def test_between_the_corners_of_a_plane_a_tip_is_seen_and_its_depth_is_that_at_many_points():
    corner = 50 * MM
    plane = np.array([[[x, y, 0.0] for y in (-corner, corner)] for x in (-corner, corner)])
    tip, axis = standing(np.random.default_rng(29), 40, -4 * MM)
    depth = as_obstacles("others", plane).deepest(MILL, tip, axis)
    assert (depth > 0).any() and (depth == 0).any()
    for found, one, along in zip(depth, tip, axis, strict=True):
        # Where the axis comes through the plane, at points 0.05 mm apart.
        middle = one - one[2] / along[2] * along
        fine = np.linspace(-4 * MM, 4 * MM, 161)
        points = middle + np.stack(np.meshgrid(fine, fine, [0.0]), axis=-1).reshape(-1, 3)
        assert found == pytest.approx(depth_of(points, one, along), rel=0.02, abs=0.02 * MM)


def test_cells_are_bilinear_between_their_corners():
    def at(u, v):
        return np.stack(np.broadcast_arrays(u * 40 * MM, v * 40 * MM, u * v * 30 * MM), axis=-1)

    ends = np.array([-0.5, 0.5])
    around = as_obstacles("others", at(ends[:, None], ends))
    tip, axis = standing(np.random.default_rng(30), 20, -3 * MM)
    depth = around.deepest(MILL, tip, axis)
    fine = np.linspace(-0.5, 0.5, 401)
    points = at(fine[:, None], fine).reshape(-1, 3)
    true = [depth_of(points, *one) for one in zip(tip, axis, strict=True)]
    assert (depth > 0).any() and (depth == 0).any()
    np.testing.assert_allclose(depth, true, rtol=0.02, atol=0.05 * MM)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_depths_grow_with_the_size_of_all(scale):
    mill = ConicalMill(8 * DEG, *(scale * MM * x for x in (0.5, 100, 12, 40)))
    corner = 50 * MM
    plane = np.array([[[x, y, 0.0] for y in (-corner, corner)] for x in (-corner, corner)])
    tip, axis = standing(np.random.default_rng(31), 20, -4 * MM)
    depth = as_obstacles("others", scale * plane).deepest(mill, scale * tip, axis)
    usual = as_obstacles("others", plane).deepest(MILL, tip, axis)
    np.testing.assert_allclose(depth, scale * usual, rtol=0.01, atol=scale * 1e-5 * MILL.height)


def test_points_alone_are_no_surface_and_arrays_may_be_several():
    row = np.array([[-1.0, 0, 0], [1.0, 0, 0]]) * 50 * MM
    tip, axis = np.array([[0, 0, -1 * MM]]), np.array([[0, 0, 1.0]])
    assert not as_obstacles("others", row).deepest(MILL, tip, axis).any()
    plane = row + np.array([[[0, -50 * MM, 0]], [[0, 50 * MM, 0]]])
    assert as_obstacles("others", plane).deepest(MILL, tip, axis)[0] > 0.3 * MM
    both = as_obstacles("others", [row, plane])
    assert len(both) == 3
    assert both.deepest(MILL, tip, axis) == as_obstacles("others", plane).deepest(MILL, tip, axis)
    assert as_obstacles("others", both) is both
    assert not Obstacles(np.empty((0, 2, 2, 3))).deepest(MILL, tip, axis).any()


def test_no_position_that_fits_enters_the_hub_between_the_points_of_its_grid():
    """As some did by up to 0.3 mm, where the hub was points 3 mm apart."""
    ring = BladeRing(60 * MM, 30 * MM, 50 * MM, -40 * DEG, 70 * DEG, -6 * MM, -6 * MM, 6)
    blade = Patch(ring.coordinates, (0, 1), (0, 1))
    mill = ConicalMill(20 * DEG, 3 * MM, 60 * MM, 12 * MM, 40 * MM)
    s, t = blade.parameters(17, margin=0.03)
    about = {"tolerance": 10e-6, "others": ring.drum(361), "n": 41}
    found = find_positions(blade, mill, s[6:9], t[6:9], **about)
    assert found.fits.any() and (found.reason == "enters a neighbour").any()
    u, z = np.meshgrid(np.linspace(0, 2 * np.pi, 1501), np.linspace(-25, 25, 151) * MM)
    hub = np.stack([60 * MM * np.cos(u), 60 * MM * np.sin(u), z], axis=-1).reshape(-1, 3)
    for row in np.flatnonzero(found.fits):
        seen = seen_from(hub, found.tip[[row]], found.axis[[row]])
        assert min(mill.cutting(*seen).min(), mill.holder(*seen).min()) > -5e-6
