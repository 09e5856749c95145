"""Conical mills on surfaces: knots, positions, chains, and what they leave."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline

from tests.test_strips import first
from tunneller_lib.envelopes.blade import BladeRing, cone_distance
from tunneller_lib.envelopes.families import moving_cone, turning
from tunneller_lib.envelopes.jet import jet_variables
from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    CylinderMill,
    Nurbs,
    Patch,
    ball_chain,
    cylinder_chain,
    find_positions,
    strip_across,
    strips,
)
from tunneller_lib.milling.chains import Chain, conjugate_frame, motion_through, trace_chain
from tunneller_lib.milling.positions import _between
from tunneller_lib.milling.strips import sweep_error
from tunneller_lib.milling.tools import seen_from
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import Frustum

MM = 1e-3
RING = BladeRing(60 * MM, 30 * MM, 50 * MM, -0.7, 1.2, -6 * MM, -6 * MM, 6)
BLADE = Patch(RING.coordinates, (0, 1), (0, 1))
MILL = ConicalMill(np.radians(15), 4 * MM, 40 * MM, 12 * MM, 40 * MM)
TOLERANCE = 10e-6
HALF_ANGLE = np.radians(10)


def saddle(s, t):
    return [s, t, 30 * s * t]


def quarter(radius):
    """Return a quarter of a cylinder about z as a rational cubic: the circle, raised."""
    corner = np.sqrt(0.5)
    plane = np.array([[1, 0, 1], [corner, corner, corner], [0, 1, 1]])  # x w, y w, w
    raised = np.array([plane[0], plane[0] + 2 * plane[1], 2 * plane[1] + plane[2], plane[2]])
    raised[1:3] /= 3
    weights = np.repeat(raised[:, 2:], 4, axis=1)
    control = np.empty((4, 4, 3))
    control[..., :2] = radius * (raised[:, :2] / raised[:, 2:])[:, None]
    control[..., 2] = np.linspace(0, 1, 4)
    knots = [0] * 4 + [1] * 4
    return Nurbs(control, knots, knots, weights)


def enveloped():
    """Return a known motion of a cone, and its envelope as a function of two variables."""

    def vertex(v):
        return [0.03 * v, 0.01 * v * v, 0.01 * v]

    def velocity(v):
        return [0.03 + 0 * v, 0.02 * v, 0.01 + 0 * v]

    motion = turning(vertex, velocity, 1.0, rate=0.7, start=1.0)
    return motion, moving_cone(motion, HALF_ANGLE)


def angle_between(a, b):
    return np.degrees(np.arccos(np.clip(np.sum(a * b, axis=-1), -1, 1)))


@pytest.mark.parametrize("radius", [1e-3, 2.0])
def test_a_rational_surface_is_a_cylinder_to_rounding(radius):
    surface = quarter(radius)
    x, y, _ = surface.coordinates(*np.random.default_rng(0).uniform(0, 1, (2, 50)))
    np.testing.assert_allclose(np.hypot(x, y), radius, rtol=1e-14)


def test_jets_of_a_rational_surface_are_those_of_its_equation():
    s, t = np.random.default_rng(1).uniform(0, 1, (2, 30))
    x, y, z = quarter(1.0).coordinates(*jet_variables(s, t))
    square = x * x + y * y
    assert np.abs(square.c[0] - 1).max() < 1e-13
    assert np.abs(square.c[1:]).max() < 1e-11  # every derivative to order 4 vanishes
    np.testing.assert_allclose(z.derivative(0, 1), 1.0)


def test_jets_follow_what_is_put_for_the_variables():
    surface = quarter(1.0)
    s, t = jet_variables(np.array([0.3, 0.6]), np.array([0.2, 0.9]))
    turned = surface.coordinates(s * s, s * t)
    plain = quarter(1.0).coordinates(0.3 * 0.3, 0.3 * 0.2)
    np.testing.assert_allclose([c.value[0] for c in turned], plain, rtol=1e-14)
    step = 1e-6
    ahead = surface.coordinates((0.3 + step) ** 2, (0.3 + step) * 0.2)
    behind = surface.coordinates((0.3 - step) ** 2, (0.3 - step) * 0.2)
    slope = [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    np.testing.assert_allclose([c.derivative(1, 0)[0] for c in turned], slope, atol=1e-8)


def test_the_blade_as_one_face_has_the_blade_s_positions():
    s = np.linspace(0, 1, 80)
    knots = np.r_[[0] * 7, np.linspace(0, 1, 18), [1] * 7]
    grid = np.stack(RING.coordinates(*np.meshgrid(s, s, indexing="ij")), axis=-1)
    rows = make_lsq_spline(s, grid, knots, 7).c
    control = make_lsq_spline(s, rows.swapaxes(0, 1), knots, 7).c.swapaxes(0, 1)
    face = Patch(Nurbs(control, knots, knots).coordinates, (0, 1), (0, 1))
    at = BLADE.parameters(3, margin=0.1)
    ours, theirs = (
        find_positions(one, MILL, *at, tolerance=TOLERANCE, n=41) for one in (face, BLADE)
    )
    np.testing.assert_array_equal(ours.reason, theirs.reason)
    np.testing.assert_allclose(ours.axis, theirs.axis, atol=1e-5)
    assert ours.fits.any()


def test_surfaces_by_knots_that_are_none_are_refused():
    control = np.zeros((5, 5, 3))
    knots = [0, 0, 0, 0, 0.5, 1, 1, 1, 1]
    Nurbs(control, knots, knots)
    with pytest.raises(
        ValueError, match=r"knots_t: must be for a degree from 3 to 9, .* for 5 points: deg"
    ):
        Nurbs(control, knots, knots[1:-1])
    with pytest.raises(ValueError, match="without creases"):
        Nurbs(np.zeros((7, 5, 3)), [0] * 4 + [0.5] * 3 + [1] * 4, knots)
    with pytest.raises(ValueError, match="weights: must be above zero"):
        Nurbs(control, knots, knots, np.zeros((5, 5)))
    with pytest.raises(ValueError, match=r"s: must lie from 0 to 1; got 1\.5"):
        Nurbs(control, knots, knots).coordinates(1.5, 0.5)
    with pytest.raises(ValueError, match=r"knots_s: .* row"):
        Nurbs(control, knots[::-1], knots)


def test_the_distance_to_a_mill_is_that_to_its_cone():
    rng = np.random.default_rng(3)
    points = 0.05 * rng.normal(size=(2000, 3))
    axis = rng.normal(size=(1, 3))
    axis /= np.linalg.norm(axis)
    tip = 0.01 * rng.normal(size=(1, 3))
    ours = MILL.cutting(*seen_from(points, tip, axis))[0]
    near, far = MILL.rulings
    theirs = cone_distance(
        points, tip[0] - MILL.below * axis[0], axis[0], MILL.half_angle, near, far
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-15)
    solid = Frustum(tip[0], tip[0] + MILL.length * axis[0], MILL.tip_radius, MILL.top_radius)
    enter, leave = solid.meet_line(points, (0.0, 0.6, 0.8))
    np.testing.assert_array_equal(ours < 0, (enter < 0) & (leave > 0))
    assert np.any(ours < 0)


def test_the_holder_is_a_cylinder_above_the_mill():
    height = np.array([0.03, 0.041, 0.06, 0.06, 0.09])
    radius = np.array([0.0, 0.0, 0.011, 0.015, 0.0])
    np.testing.assert_allclose(MILL.holder(height, radius), [0.01, -0.001, -0.001, 0.003, 0.01])


@pytest.fixture(scope="module")
def on_blade():
    others = np.concatenate([RING.mesh(61, k).reshape(-1, 3) for k in (1, -1)])
    s, t = BLADE.parameters(9, margin=0.05)
    return others, find_positions(BLADE, MILL, s, t, tolerance=TOLERANCE, others=others)


def test_positions_touch_at_their_contact_on_the_cutting_part(on_blade):
    _, found = on_blade
    at = np.isfinite(found.enters)
    seen = seen_from(found.contact[at][:, None], found.tip[at], found.axis[at])
    assert np.abs(MILL.cutting(*seen)).max() < 1e-15
    near, far = MILL.rulings
    assert np.all((found.distance[at] >= near) & (found.distance[at] <= far))
    assert found.fits.sum() > 20


def test_depths_are_those_of_a_finer_mesh(on_blade):
    _, found = on_blade
    asked = np.flatnonzero(np.isfinite(found.enters))
    mesh = BLADE.mesh(400).reshape(-1, 3)
    near, far = MILL.rulings
    for k in asked[::4]:
        vertex = found.tip[k] - MILL.below * found.axis[k]
        least = cone_distance(mesh, vertex, found.axis[k], MILL.half_angle, near, far).min()
        # What lies between the points of a finer mesh may be a little deeper.
        assert -1e-9 <= found.enters[k] - max(-least, 0) <= 1e-6


def test_the_deepest_point_is_looked_for_to_a_27th_of_a_cell_of_the_mesh():
    plane = Patch(lambda s, t: [s, t, 0 * s], (0, 1), (0, 1))
    tip = np.append(np.random.default_rng(8).uniform(0.1, 0.9, (500, 2)), np.zeros((500, 1)), 1)
    up = np.tile([0.0, 0.0, 1.0], (500, 1))
    cell = 0.1
    s, t = (cell * np.rint(part / cell) for part in tip.T[:2])
    away = _between(plane, lambda height, radius: radius, tip, up, s, t, 11)
    assert away.max() <= np.sqrt(0.5) * cell / 27 * (1 + 1e-9)
    # The mean distance from the nearest point of a square grid is 0.38 of its step.
    assert away.mean() == pytest.approx(0.38 * cell / 27, rel=0.1)


def test_reasons_say_what_the_depths_say(on_blade):
    _, found = on_blade
    assert np.all(found.enters[found.fits] <= TOLERANCE)
    assert not found.holder_enters[found.fits].any() and not found.others_enter[found.fits].any()
    gouging = np.isin(found.reason, ["gouges at its contact", "enters the surface elsewhere"])
    assert np.all(found.enters[gouging] > TOLERANCE) and gouging.any()
    refused = found.reason == "holder enters the surface"
    assert np.all(found.holder_enters[refused] > 0)
    away = np.isin(found.reason, ["on the other side", "off the cutting part"])
    assert np.all(np.isinf(found.enters[away])) and away.any()


def test_a_thick_holder_and_a_neighbour_are_reasons(on_blade):
    others, found = on_blade
    s, t = BLADE.parameters(9, margin=0.05)
    thick = replace(MILL, holder_radius=40 * MM)
    again = find_positions(BLADE, thick, s, t, tolerance=TOLERANCE, others=others)
    assert np.any(again.reason == "holder enters the surface")
    assert again.fits.sum() < found.fits.sum()
    row = np.flatnonzero(found.fits)[0]
    obstacle = found.tip[row] + 0.5 * MILL.length * found.axis[row]
    again = find_positions(BLADE, MILL, s, t, tolerance=TOLERANCE, others=[obstacle])
    assert again.reason[row] == "enters a neighbour"
    assert again.others_enter[row] == pytest.approx(
        (MILL.tip_radius + MILL.top_radius) / 2 * np.cos(MILL.half_angle)
    )


def test_where_a_surface_is_no_saddle_no_position_fits():
    ball = Patch(lambda s, t: [s, t, 10 * (s * s + t * t)], (-0.01, 0.01), (-0.01, 0.01))
    found = find_positions(ball, MILL, *ball.parameters(5, margin=0.1), tolerance=0)
    assert not found.fits.any()


def test_chains_go_across_the_characteristic_in_equal_steps():
    patch = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
    mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    look = {"tolerance": 1e-4}
    found = find_positions(patch, mill, 0.005, 0.002, **look)
    rows = np.flatnonzero(found.fits)
    assert len(rows) > 0
    chains = [trace_chain(patch, mill, found, int(k), step=5e-4, **look) for k in rows]
    for chain in chains:
        chord = np.diff(chain.contact, axis=0)
        length = np.linalg.norm(chord, axis=-1)
        np.testing.assert_allclose(length, 5e-4, rtol=2e-3)
        middle = chain.across[1:] + chain.across[:-1]
        assert np.abs(np.sum(chord * middle, axis=-1) / length).max() < 0.02


@pytest.fixture(scope="module")
def recovered():
    motion, surface = enveloped()
    patch = Patch(surface, (3.7, 5.2), (0, 1), -1)
    mill = ConicalMill(HALF_ANGLE, 2 * MM, 70 * MM, 5 * MM, 50 * MM)
    found = find_positions(patch, mill, *patch.parameters(5, margin=0.1), tolerance=1e-6)
    return motion, patch, mill, found


def test_positions_of_another_mill_and_rows_beyond_are_refused(on_blade):
    _, found = on_blade
    look = {"step": 1 * MM, "tolerance": TOLERANCE}
    other = replace(MILL, half_angle=0.1, tip_radius=0.1)
    with pytest.raises(ValueError, match="found: must be positions of this mill on this patch"):
        trace_chain(BLADE, other, found, int(np.flatnonzero(found.fits)[0]), **look)
    with pytest.raises(ValueError, match=rf"^row: must be below {len(found)}, the positions fou"):
        trace_chain(BLADE, MILL, found, len(found), **look)


def axis_of(motion, v):
    return np.stack(np.broadcast_arrays(*motion(v)[2][0]), axis=-1)


def test_the_motion_of_a_cone_is_recovered_from_its_envelope(recovered):
    motion, _, _, found = recovered
    off = angle_between(found.axis, axis_of(motion, found.t))
    every = [off[(found.index == i) & found.fits].min(initial=180) for i in range(25)]
    assert max(every) < 1e-5


def test_the_chain_of_recovered_cones_sweeps_the_surface(recovered):
    motion, patch, mill, found = recovered
    off = angle_between(found.axis, axis_of(motion, found.t))
    row = int(np.flatnonzero((found.index == 12) & found.fits & (off < 1e-5))[0])
    chain = trace_chain(patch, mill, found, row, step=1 * MM, tolerance=1e-6)
    assert angle_between(chain.axis, axis_of(motion, chain.t)).max() < 1e-5
    strip = strip_across(patch, mill, chain, reach=20 * MM)
    assert strip.widths(1e-8).min() > 13 * MM  # the whole patch


def along(tip, axis):
    """Return a chain of which only tips and axes (k, 3) are looked at."""
    return Chain(*tip.T[:2], tip, axis, tip, axis, axis)


def test_the_sweep_of_a_known_motion_is_its_envelope():
    motion, surface = enveloped()
    v = np.linspace(0, 1, 60)
    grid = np.stack(surface(*np.meshgrid(np.linspace(3.7, 5.2, 60), v, indexing="ij")), axis=-1)
    mill = ConicalMill(HALF_ANGLE, 2 * MM, 70 * MM, 5 * MM, 50 * MM)
    vertex = np.stack(np.broadcast_arrays(*motion(v)[0]), axis=-1)
    axis = axis_of(motion, v)
    error = sweep_error(grid[:, 5:-5], mill, along(vertex + mill.below * axis, axis))
    assert np.abs(error).max() < 1e-9


def test_a_ball_along_a_line_leaves_what_pythagoras_says():
    line = np.stack([np.linspace(0, 0.1, 9), np.zeros(9), np.zeros(9)], axis=-1)
    up = np.broadcast_to((0.0, 0.0, 1.0), line.shape)
    y = np.linspace(-2e-3, 2e-3, 21)
    points = np.stack([np.full(21, 0.047), y, np.zeros(21)], axis=-1)
    error = sweep_error(points, BallMill(5 * MM), along(line, up))
    np.testing.assert_allclose(error, np.hypot(y, 5 * MM) - 5 * MM, atol=1e-9)


def test_motions_pass_through_their_positions():
    rng = np.random.default_rng(5)
    tip = np.cumsum(rng.uniform(0, 1e-3, (7, 3)), axis=0)
    axis = np.array([0.0, 0.0, 1.0]) + 0.1 * rng.normal(size=(7, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    at, up = motion_through(tip, axis)(np.linspace(0, 6, 25))
    np.testing.assert_allclose(at[::4], tip, atol=1e-15)
    np.testing.assert_allclose(up[::4], axis, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(up, axis=-1), 1)


def test_a_sweep_is_looked_at_closer_about_the_nearest_of_eight_places_a_step(chain, monkeypatch):
    monkeypatch.setattr(strips, "CLOSER", 0)
    points = BLADE.mesh(9).reshape(-1, 3)
    last = len(chain) - 1
    places = motion_through(chain.tip, chain.axis)(np.linspace(0, last, 8 * last + 1))
    nearest = MILL.cutting(*seen_from(points, *places)).min(axis=0)
    np.testing.assert_allclose(sweep_error(points, MILL, chain), nearest, atol=1e-15)


def test_a_sweep_needs_four_positions_that_differ(chain):
    with pytest.raises(ValueError, match=r"^chain: must have 4 positions or more; got 3\.$"):
        sweep_error((0.0, 0.0, 0.0), MILL, first(chain, 3))
    assert abs(sweep_error(chain.contact[1], MILL, first(chain, 4))) < 1e-9
    still = replace(chain, tip=0 * chain.tip, axis=0 * chain.axis + (0, 0, 1))
    with pytest.raises(ValueError, match=r"^chain: each position must differ from the next; got"):
        sweep_error((0.0, 0.0, 0.0), MILL, still)


@pytest.fixture(scope="module")
def chain(on_blade):
    others, found = on_blade
    row = int(np.flatnonzero(found.fits)[10])
    return trace_chain(BLADE, MILL, found, row, step=1 * MM, tolerance=TOLERANCE, others=others)


def test_ball_and_cylinder_touch_where_the_chain_does(chain):
    ball, cylinder = BallMill(5 * MM), CylinderMill(5 * MM, 40 * MM)
    beside = cylinder_chain(BLADE, chain, cylinder)
    for mill, one in ((ball, ball_chain(chain, ball)), (cylinder, beside)):
        seen = seen_from(chain.contact[:, None], one.tip, one.axis)
        assert np.abs(mill.cutting(*seen)).max() < 1e-15
    assert np.abs(np.sum(beside.axis * chain.normal, axis=-1)).max() < 1e-12


def test_a_cylinder_is_as_close_as_it_can_be_without_gouging(chain):
    """The gap, by distances to nearby points, vanishes to second order in one direction alone."""
    cylinder = CylinderMill(5 * MM, 40 * MM)
    k = len(chain) // 2
    beside = cylinder_chain(BLADE, chain, cylinder)
    tip, axis = beside.tip[k], beside.axis[k]
    turn = np.linspace(0, np.pi, 181)
    step = 0.2 * MM
    _, inverse = conjugate_frame(BLADE, chain.s[k], chain.t[k], axis)
    tangent = np.cross(chain.normal[k], axis)
    ways = np.cos(turn)[:, None] * axis + np.sin(turn)[:, None] * tangent
    rates = step * ways @ inverse.T
    gaps = []
    for sign in (1, -1):
        points = BLADE.points(chain.s[k] + sign * rates[:, 0], chain.t[k] + sign * rates[:, 1])
        gaps.append(cylinder.cutting(*seen_from(points, tip[None], axis[None]))[0])
    second = sum(gaps) / step**2  # the gap's second derivative, by a difference, in 1/m
    assert -0.5 < second.min() < 0.5 and second.max() > 50


def test_a_cylinder_that_is_too_thick_is_refused(chain):
    with pytest.raises(ValueError, match="mill: must be thin enough"):
        cylinder_chain(BLADE, chain, CylinderMill(5.0, 1.0))


def test_strips_of_cones_are_wider_than_those_of_balls(chain):
    ball = BallMill(MILL.top_radius)
    wide = strip_across(BLADE, MILL, chain, reach=12 * MM)
    narrow = strip_across(BLADE, ball, ball_chain(chain, ball), reach=12 * MM)
    assert np.median(wide.widths(1e-5)) > 3 * np.median(narrow.widths(1e-5))


def test_dexels_leave_what_the_sweep_says():
    """Frusta cut from a block along z leave, above a graph, its error over the slope."""
    patch = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
    mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    found = find_positions(patch, mill, 0.003, 0.001, tolerance=1e-4)
    row = int(np.flatnonzero(found.fits)[0])
    chain = trace_chain(patch, mill, found, row, step=5e-4, tolerance=1e-4)
    last = len(chain) - 1
    tip, axis = motion_through(chain.tip, chain.axis)(np.linspace(0, last, 20 * last + 1))
    middle = chain.contact[len(chain) // 2]
    half = np.array([1.5, 1.5, 5]) * MM
    low = middle - half
    high = middle + half
    grid = DexelGrid.cartesian(low, high, (31, 31))
    for a, u in zip(tip, axis, strict=True):
        grid.cut(Frustum(a, a + mill.length * u, mill.tip_radius, mill.top_radius))
    x, y = np.meshgrid(grid.lines.x, grid.lines.aside, indexing="ij")
    below = (grid.low == low[2]) & (grid.high > grid.low)
    top = np.where(below, grid.high, -np.inf).max(axis=0)
    wanted = patch.points(x, y)
    left = (top - wanted[..., 2]) / np.sqrt(1 + 900 * (x * x + y * y))
    error = sweep_error(wanted, mill, chain)
    assert np.abs(error).max() < 50e-6
    assert np.abs(left - error).max() < 0.2e-6
