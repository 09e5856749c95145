"""Planes to points and back, what spheres and cones become, the adapted frame."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import KDTree

from tests.envelopes_zoo import GENERAL, GRID
from tests.shapes import directions
from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet, tangent_graph
from tunneller_lib.envelopes.blade import BladeRing, blade_distances, cone_distance
from tunneller_lib.envelopes.conics import cone_vertex, conic, osculating_conic, top_circle
from tunneller_lib.envelopes.isotropic import (
    cone_planes,
    cone_rulings,
    contact_point,
    isotropic_derivatives,
    normal,
    plane_azimuth,
    plane_to_point,
    point_to_plane,
    sphere_point,
    surface_points,
)  # fmt: skip
from tunneller_lib.envelopes.jet import jet_variables

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_planes_come_back_from_their_points(scale):
    n, h = directions(RNG, 500), scale * RNG.normal(size=500)
    back, constant = point_to_plane(plane_to_point(n, h))
    np.testing.assert_allclose(back, n, atol=1e-14)
    np.testing.assert_allclose(constant, h, rtol=1e-13)


def test_plane_to_point_keeps_digits_near_the_one_that_has_none():
    n = np.array([3e-9, 4e-9, -1.0])
    np.testing.assert_allclose(plane_to_point(n, 1.0), [1.2e9 / 5, 1.6e9 / 5, 2 / 25e-18],
                               rtol=1e-14)  # fmt: skip


def test_plane_to_point_takes_normals_of_any_length():
    n = directions(RNG, 20)
    np.testing.assert_allclose(plane_to_point(7 * n, 7.0), plane_to_point(n, 1.0), rtol=1e-13)


@pytest.mark.parametrize(
    "n", [(0, 0, -1), (0, 0, -5.0), [(0, 0, 1), (0, 0, -1)], (1e-99, 0, -9e99)]
)
def test_a_plane_without_point_is_refused(n):
    with pytest.raises(ValueError, match=r"^n: a normal must not have the direction \(0, 0, -1\)"):
        plane_to_point(n, 1e20)


def test_a_plane_without_normal_is_refused():
    with pytest.raises(ValueError, match=r"^n: must not be zero; got \(0, 0, 0\)\.$"):
        plane_to_point((0, 0, 0), 1.0)


def test_arguments_are_not_written_to_and_broadcast():
    n, h = directions(RNG, 6).reshape(2, 3, 3), RNG.normal(size=3)
    for a in (n, h):
        a.flags.writeable = False
    assert plane_to_point(n, h).shape == (2, 3, 3)
    assert point_to_plane(plane_to_point(n, h))[1].shape == (2, 3)
    assert sphere_point(n, 1.0, h, h).shape == (2, 3)
    assert cone_planes(n, n, 0.3, h)[0].shape == (2, 3, 3)


@given(st.integers(0, 1000), st.floats(-5, 5))
def test_sphere_planes_lie_on_its_paraboloid(seed, radius):
    rng = np.random.default_rng(seed)
    m, n = rng.normal(size=3), directions(rng, 20)
    # With inward normals the tangent plane lies a radius behind the centre.
    x, y, z = plane_to_point(n, radius - n @ m).T
    scale = 1 + x**2 + y**2
    np.testing.assert_allclose(sphere_point(m, radius, x, y) / scale, z / scale, atol=1e-13)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_contact_point_undoes_isotropic_derivatives(scale):
    r, n = scale * RNG.normal(size=(3, 50)), directions(RNG, 50).T
    back = contact_point(*isotropic_derivatives(r, n))
    np.testing.assert_allclose(back, r, atol=1e-11 * scale)
    x, y, *_ = isotropic_derivatives(r, n)
    np.testing.assert_allclose(normal(x, y), n, atol=1e-14)


def test_cone_vertex_is_that_of_the_planes():
    for _ in range(50):
        vertex, axis, angle = RNG.normal(size=3), directions(RNG, 1)[0], RNG.uniform(0.1, 1.4)
        p = plane_to_point(*cone_planes(vertex, axis, angle, 2 * np.pi * np.arange(7) / 7))
        # Centre of the top view, from three of its points, and plane of the conic.
        square = (p[:, :2] ** 2).sum(axis=1)
        centre = np.linalg.solve(2 * (p[1:3, :2] - p[0, :2]), square[1:3] - square[0])
        slope = np.linalg.solve(p[1:3, :2] - p[0, :2], p[1:3, 2] - p[0, 2])
        u, v = centre - p[0, :2]
        a, b = slope @ [v, -u], slope @ [u, v]
        scale = 1e-9 * (1 + np.abs(p).max()) ** 2
        np.testing.assert_allclose(cone_vertex(p[0], (u, v), a, b), vertex, atol=scale)
        # The conic has all the planes on it.
        t = np.arctan2((p[:, :2] - centre) @ [v, -u], -(p[:, :2] - centre) @ [u, v])
        np.testing.assert_allclose(conic(p[0], (u, v), a, b, t), p, atol=scale)


@given(st.integers(0, 99), st.floats(0.01, 1.55))
def test_top_circle_holds_the_planes_of_the_cone(seed, angle):
    axis = directions(np.random.default_rng(seed), 3)
    centre, radius = top_circle(7.0 * axis, angle)
    azimuth = np.linspace(0, 6, 7)[:, None]
    place = plane_to_point(*cone_planes((1.0, 2.0, 3.0), axis, angle, azimuth))[..., :2]
    scale = np.abs(place).max() + np.abs(centre).max()
    np.testing.assert_allclose(np.linalg.norm(place - centre, axis=-1), radius + 0 * azimuth,
                               rtol=1e-9, atol=1e-12 * scale)  # fmt: skip


def test_top_circle_refuses_a_cone_with_the_plane_that_has_no_point():
    with pytest.raises(ValueError, match=r"^axis: no plane .* \(0, 0, -1\); got one\.$"):
        top_circle((0.0, 0.8, -0.6), np.arcsin(0.6))


def test_surface_points_of_a_paraboloid_are_a_sphere():
    x, y = RNG.normal(size=(2, 20))
    m, radius = np.array([0.3, -2.0, 1.0]), 1.7

    def f(x, y):
        return (radius + m[2]) / 2 * (x * x + y * y) - m[0] * x - m[1] * y + (radius - m[2]) / 2

    r = surface_points(f, x, y)
    inward = np.stack(normal(x, y), axis=-1)
    np.testing.assert_allclose(r, m - radius * inward, atol=1e-12)
    assert surface_points(f, x[:, None], 0.0).shape == (20, 1, 3)
    np.testing.assert_allclose(surface_points(lambda x, y: 0.5, 0.0, 0.0), [0, 0, -1])


def test_cone_planes_touch_the_cone():
    axis = directions(RNG, 9)
    n, h = cone_planes((1, 2, 3), axis, 0.4, 0.7)
    np.testing.assert_allclose(n @ [1, 2, 3] + h, 0, atol=1e-14)
    np.testing.assert_allclose((n * axis).sum(-1), np.sin(0.4), rtol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(n, axis=-1), 1, rtol=1e-14)
    ruling = cone_rulings(axis, 0.4, 0.7)
    np.testing.assert_allclose((n * ruling).sum(-1), 0, atol=1e-14)
    np.testing.assert_allclose((ruling * axis).sum(-1), np.cos(0.4), rtol=1e-13)


def test_plane_azimuth_is_the_one_that_made_the_plane():
    axis = directions(RNG, 50)[:, None]
    azimuth = np.linspace(-3.1, 3.1, 40)
    for half_angle in (0.01, 0.5, 1.5):
        n, _ = cone_planes((1, 2, 3), 7 * axis, half_angle, azimuth)
        found = plane_azimuth(7 * axis, half_angle, n)
        assert found.shape == (50, 40)
        np.testing.assert_allclose(found, np.broadcast_to(azimuth, (50, 40)), atol=1e-11)


def test_plane_azimuth_of_one_plane_per_cone():
    axis, angle = directions(RNG, 9), np.linspace(0.1, 1.2, 9)
    azimuth = RNG.uniform(-3, 3, 9)
    n, _ = cone_planes((0, 0, 0), axis, angle, azimuth)
    np.testing.assert_allclose(plane_azimuth(axis, angle, n), azimuth, atol=1e-12)


def test_osculating_conic_leaves_the_graph_at_third_order():
    def f(x, y):
        return np.sin(x) * np.cos(2 * y) + x * y

    x, y, centre = 0.3, 0.5, (0.4, -0.7)
    z, a, b = osculating_conic(centre, f(*jet_variables(x, y)))
    gaps = []
    for t in (1e-2, 2e-2):
        px, py, pz = conic((x, y, z), centre, a, b, t)
        gaps.append(abs(pz - f(px, py)))
    assert 7 < gaps[1] / gaps[0] < 9


@pytest.mark.parametrize("name", GENERAL)
def test_adapted_frame_has_the_principal_radii(name):
    found = adapted_frames(GENERAL[name], *GRID, "space")
    f = isotropic_jet(found, slice(None))
    g = tangent_graph(found, slice(None))
    hessian, bend = ([[j.derivative(2, 0), j.derivative(1, 1)],
                      [j.derivative(1, 1), j.derivative(0, 2)]] for j in (f, g))  # fmt: skip
    product = np.moveaxis(hessian, -1, 0) @ np.moveaxis(bend, -1, 0)
    # f's Hessian is twice the inverse of the curvatures' matrix.
    np.testing.assert_allclose(product, np.broadcast_to(2 * np.eye(2), product.shape), atol=1e-10)
    assert np.abs(f.c[:3]).max() == 0 and np.abs(g.c[:3]).max() < 1e-14


@pytest.mark.parametrize("shift", [0.0, 10.0])
def test_both_models_give_the_same_jet(shift):
    def f(x, y):
        return y**2 / (x**2 + y**2) + shift * x

    def space(x, y):
        square = (x * x + y * y) ** 2
        fx, fy = -2 * x * y * y / square + shift, 2 * x * x * y / square
        return contact_point(x, y, f(x, y), fx, fy)

    one = adapted_frames(f, *GRID, "isotropic")
    two = adapted_frames(space, *GRID, "space")
    np.testing.assert_allclose(one.contact, two.contact, atol=1e-12)
    # r_s x r_t may point the other way: R changes its sign, the frame is another.
    j, k = (isotropic_jet(found, slice(None)) for found in (one, two))
    trace = [np.abs(a.derivative(2, 0) + a.derivative(0, 2)) for a in (j, k)]
    np.testing.assert_allclose(*trace, rtol=1e-9)


# ---- the blade ring ---------------------------------------------------------------------------

RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)


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
    x, y, z = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, 0.006, -0.004, 6).coordinates(
        np.full(3, s), np.array([0, 0.5, 1])
    )
    arc = radius * np.arctan2(y, x)
    np.testing.assert_allclose(z, 0.05 * np.cos(slope) * np.array([-0.5, 0, 0.5]), atol=1e-15)
    ends = 0.025 * np.sin(slope)
    np.testing.assert_allclose(arc, [-ends + bow, 0.006 + bow, ends + bow], rtol=1e-12)


@pytest.mark.parametrize("change", [{"hub": 0}, {"height": -1}, {"chord": np.nan},
                                    {"bow": np.inf}, {"blades": 1}, {"blades": 2.5}])  # fmt: skip
def test_no_ring_of_wrong_sizes(change):
    sizes = dict(hub=1, height=1, chord=1, stagger=0, twist=0, camber=0, bow=0, blades=6)
    name, value = next(iter(change.items()))
    with pytest.raises(ValueError, match=rf"^{name}: .*got {value}\.$"):
        BladeRing(**(sizes | change))


def test_no_ring_beyond_all_proportion():
    sizes = dict(hub=1, height=1, chord=1, stagger=0, twist=0, camber=0, bow=0, blades=6)
    for name in ("height", "chord", "camber", "bow"):
        with pytest.raises(
            ValueError,
            match=rf"^{name}: must be at most \S+ times the hub's radius 1 m; got 1e\+20",
        ):
            BladeRing(**(sizes | {name: 1e20}))


def test_surface_points_need_a_smooth_function():
    for f in (lambda x, y: np.log(x), lambda x, y: np.sqrt(x + y)):
        with pytest.raises(ValueError, match=r"^f: must be defined and smooth at every place; got"):
            surface_points(f, [0.5, 0.0], 0.0)


def test_blade_distances_are_from_the_first_blade_and_both_neighbours():
    ring = BladeRing(60, 30, 50, -0.7, 1.2, -6, -6, 6)
    x, y, _ = ring.coordinates(0.5, 0.5)
    out = np.array([x, y, 0.0]) / np.hypot(x, y)
    around = np.cross((0, 0, 1.0), out)
    # A tool in the middle of the gap to the next blade, then moved into that blade.
    turn = np.pi / 6
    middle = np.cos(turn) * out + np.sin(turn) * around
    free = blade_distances(ring, 40 * middle, middle, 0.05, 30, 60)
    assert np.all(free > 0)
    back = np.cos(2 * turn) * out + np.sin(2 * turn) * around
    hit = blade_distances(ring, 40 * back, back, 0.05, 30, 60, n=241)
    assert hit[1] < 0 < min(hit[0], hit[2])
    fine = blade_distances(ring, 40 * middle, middle, 0.05, 30, 60, n=241)
    np.testing.assert_allclose(fine, free, atol=0.1)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_cone_distance_is_that_to_sampled_walls(scale):
    vertex, axis, angle, near, far = np.array([0.2, -0.1, 0.3]), directions(RNG, 1)[0], 0.4, 0.5, 2
    ruling = cone_rulings(axis, angle, np.linspace(0, 2 * np.pi, 721))
    wall = vertex + np.linspace(near, far, 301)[:, None, None] * ruling
    caps = [vertex + np.cos(angle) * e * axis
            + np.linspace(0, 1, 101)[:, None, None] * (e * (ruling - np.cos(angle) * axis))
            for e in (near, far)]  # fmt: skip
    solid = np.concatenate([part.reshape(-1, 3) for part in (wall, *caps)])
    points = vertex + RNG.uniform(-2.5, 2.5, (200, 3))
    sampled, _ = KDTree(solid).query(points)
    d = cone_distance(scale * points, scale * vertex, axis, angle, scale * near, scale * far)
    np.testing.assert_allclose(np.abs(d) / scale, sampled, atol=0.01)
    depth = (points - vertex) @ axis
    lean = np.arccos(depth / np.linalg.norm(points - vertex, axis=-1))
    inside = (lean < angle) & (depth > near * np.cos(angle)) & (depth < far * np.cos(angle))
    np.testing.assert_array_equal(d < 0, inside)


@pytest.mark.parametrize(("near", "far", "angle", "message"), [
    (2, 1, 0.3, r"^near: must be below far; got 2 and 1\.$"),
    (-1, 1, 0.3, r"^near: must be one finite number, not below zero; got -1\.$"),
    (0, 1, 1.6, r"^half_angle: must lie between 0 and pi/2, both left out; got 1\.6\.$"),
])  # fmt: skip
def test_no_distance_from_what_is_no_truncated_cone(near, far, angle, message):
    with pytest.raises(ValueError, match=message):
        cone_distance((0, 0, 0), (0, 0, 0), (0, 0, 1), angle, near, far)
