"""Flank milling with cones: surfaces by knots, positions, chains, and what they leave."""

import time
from dataclasses import replace

import numpy as np
import pytest

from tests.long import many
from tunneller_lib.envelopes.blade import BladeRing, cone_distance
from tunneller_lib.envelopes.families import moving_cone, turning
from tunneller_lib.envelopes.jet import EXPONENTS, jet_variables
from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    CylinderMill,
    Patch,
    ball_positions,
    cylinder_positions,
    find_positions,
    fit_nurbs,
    moved,
    strip_across,
    sweep_error,
    trace_chains,
)
from tunneller_lib.milling.nurbs import Nurbs
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
    """Return the envelope of a known motion of a cone: the motion, and the surface with a grid."""

    def vertex(v):
        return [0.03 * v, 0.01 * v * v, 0.01 * v]

    def velocity(v):
        return [0.03 + 0 * v, 0.02 * v, 0.01 + 0 * v]

    motion = turning(vertex, velocity, 1.0, rate=0.7, start=1.0)
    u = np.linspace(3.7, 5.2, 60)
    v = np.linspace(0, 1, 60)
    surface = moving_cone(motion, HALF_ANGLE)
    return motion, u, v, np.stack(surface(*np.meshgrid(u, v, indexing="ij")), axis=-1)


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


def test_a_fit_has_the_derivatives_of_what_it_fits():
    s = np.linspace(0, 1, 80)
    grid = np.stack(RING.coordinates(*np.meshgrid(s, s, indexing="ij")), axis=-1)
    fit, error = fit_nurbs(grid, s, s, count=24, degree=7)
    assert error < 1e-14
    at = jet_variables(*np.random.default_rng(2).uniform(0.1, 0.9, (2, 20)))
    for ours, theirs in zip(fit.coordinates(*at), RING.coordinates(*at), strict=True):
        for place, exponents in enumerate(EXPONENTS):
            bound = 1e-14 * 30 ** sum(exponents)
            assert np.abs(ours.c[place] - theirs.c[place]).max() < bound


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


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_beyond_its_faces_a_point_is_no_farther_than_its_distance_and_within_as_deep(scale):
    rng = np.random.default_rng(29)
    height, radius = scale * rng.uniform([[-0.1], [0.0]], [[0.4], [0.2]], (2, 20_000))
    sizes = (scale * x for x in (0.01, 0.12, 0.03, 0.05, 0.08, 0.1))
    cone = ConicalMill(0.3, *sizes)
    cylinder = CylinderMill(scale * 0.02, scale * 0.1)
    ball = BallMill(scale * 0.05)
    for distance, faces in [
        *((one.cutting, one.cutting_faces) for one in (cone, cylinder, ball)),
        (cone.holder, cone.holder_faces),
    ]:
        whole = distance(height, radius)
        bound = faces(height, radius)
        within = whole < 0
        assert within.any() and np.array_equal(within, bound < 0)
        np.testing.assert_allclose(bound[within], whole[within], rtol=0, atol=1e-15 * scale)
        assert np.all(bound <= whole + 1e-15 * scale)


def test_the_holder_is_a_cylinder_above_the_mill():
    height = np.array([0.03, 0.041, 0.06, 0.06, 0.09])
    radius = np.array([0.0, 0.0, 0.011, 0.015, 0.0])
    np.testing.assert_allclose(MILL.holder(height, radius), [0.01, -0.001, -0.001, 0.003, 0.01])


def test_a_spindle_is_a_cylinder_above_the_holder():
    mill = replace(MILL, spindle_radius=50 * MM, spindle_length=100 * MM)
    height = np.array([0.06, 0.09, 0.19, 0.1])
    radius = np.array([0.011, 0.0, 0.0, 0.055])
    np.testing.assert_allclose(mill.holder(height, radius), [-0.001, -0.01, 0.01, 0.005])
    assert (MILL.height, MILL.widest) == pytest.approx((0.08, MILL.top_radius))
    assert (mill.height, mill.widest) == pytest.approx((0.18, 0.05))
    for size in ({"spindle_radius": 0.05}, {"spindle_length": 0.1}):
        with pytest.raises(ValueError, match=r"^spindle_radius, spindle_length: must both"):
            replace(MILL, **size)


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
    assert np.all(found.state[found.state == "regular"] == "regular")
    assert set(found.state.ravel().tolist()) <= {"convex", "spherical"}
    assert not found.fits.any()


def test_chains_go_across_the_characteristic_in_equal_steps():
    patch = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
    mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    starts = find_positions(patch, mill, 0.005, 0.002, tolerance=1e-4)
    chains = trace_chains(patch, mill, starts, step=5e-4, tolerance=1e-4)
    assert len(chains) == starts.fits.sum() > 0
    for chain in chains:
        chord = np.diff(chain.contact, axis=0)
        length = np.linalg.norm(chord, axis=-1)
        np.testing.assert_allclose(length, 5e-4, rtol=2e-3)
        middle = chain.across[1:] + chain.across[:-1]
        assert np.abs(np.sum(chord * middle, axis=-1) / length).max() < 0.02
        assert set(chain.ends) <= {
            "the patch ends", "no cone continues", "the next one doesn't fit", "long enough",
            "the mill would gouge on its way",
        }  # fmt: skip


@pytest.fixture(scope="module")
def recovered():
    motion, u, v, grid = enveloped()
    fit, error = fit_nurbs(grid, u, v, count=14)
    patch = Patch(fit.coordinates, *fit.domain, -1)
    mill = ConicalMill(HALF_ANGLE, 2 * MM, 70 * MM, 5 * MM, 50 * MM)
    found = find_positions(patch, mill, *patch.parameters(5, margin=0.1), tolerance=1e-6)
    return motion, error, patch, mill, found


def test_starts_of_another_mill_are_refused(on_blade):
    _, found = on_blade
    other = replace(MILL, half_angle=0.1, tip_radius=0.1)
    with pytest.raises(ValueError, match="starts: must be positions of this mill on this patch"):
        trace_chains(BLADE, other, found, step=1 * MM, tolerance=TOLERANCE)


def axis_of(motion, v):
    return np.stack(np.broadcast_arrays(*motion(v)[2][0]), axis=-1)


def test_the_motion_of_a_cone_is_recovered_from_a_fit_to_its_envelope(recovered):
    motion, error, _, _, found = recovered
    assert error < 0.1e-6
    off = angle_between(found.axis, axis_of(motion, found.t))
    every = [off[(found.index == i) & found.fits].min(initial=180) for i in range(25)]
    assert max(every) < 0.05


def test_the_chain_of_recovered_cones_sweeps_the_surface_within_the_error_of_its_fit(recovered):
    motion, error, patch, mill, found = recovered
    off = angle_between(found.axis, axis_of(motion, found.t))
    start = np.flatnonzero((found.index == 12) & found.fits & (off < 0.05))
    alone = np.where(np.arange(len(found)) == start[0], "fits", "not asked")
    [chain] = trace_chains(patch, mill, replace(found, reason=alone), step=1 * MM, tolerance=1e-6)
    assert angle_between(chain.axis, axis_of(motion, chain.t)).max() < 0.05
    strip = strip_across(patch, mill, chain, chain.tip, chain.axis, reach=20 * MM)
    assert strip.widths(error).min() > 5 * MM
    assert strip.widths(1e-6).min() > 13 * MM  # the whole patch


def test_the_sweep_of_a_known_motion_is_its_envelope():
    motion, _, v, grid = enveloped()
    mill = ConicalMill(HALF_ANGLE, 2 * MM, 70 * MM, 5 * MM, 50 * MM)
    vertex = np.stack(np.broadcast_arrays(*motion(v)[0]), axis=-1)
    axis = axis_of(motion, v)
    error = sweep_error(grid[:, 5:-5], mill, vertex + mill.below * axis, axis)
    assert np.abs(error).max() < 1e-9


def test_a_ball_along_a_line_leaves_what_pythagoras_says():
    line = np.stack([np.linspace(0, 0.1, 9), np.zeros(9), np.zeros(9)], axis=-1)
    up = np.broadcast_to((0.0, 0.0, 1.0), line.shape)
    y = np.linspace(-2e-3, 2e-3, 21)
    points = np.stack([np.full(21, 0.047), y, np.zeros(21)], axis=-1)
    error = sweep_error(points, BallMill(5 * MM), line, up)
    np.testing.assert_allclose(error, np.hypot(y, 5 * MM) - 5 * MM, atol=1e-9)


def test_motions_pass_through_their_positions():
    rng = np.random.default_rng(5)
    tip = np.cumsum(rng.uniform(0, 1e-3, (7, 3)), axis=0)
    axis = np.array([0.0, 0.0, 1.0]) + 0.1 * rng.normal(size=(7, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    at, along = moved(tip, axis, between=4)
    np.testing.assert_allclose(at[::4], tip, atol=1e-15)
    np.testing.assert_allclose(along[::4], axis, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(along, axis=-1), 1)


@pytest.fixture(scope="module")
def chain(on_blade):
    others, found = on_blade
    one = np.flatnonzero(found.fits)[10]
    alone = np.where(np.arange(len(found)) == one, found.reason, "not asked")
    [chain] = trace_chains(
        BLADE, MILL, replace(found, reason=alone), step=1 * MM, tolerance=TOLERANCE, others=others
    )
    return chain


def test_ball_and_cylinder_touch_where_the_chain_does(chain):
    ball = BallMill(5 * MM)
    tip, axis = ball_positions(chain, ball)
    seen = seen_from(chain.contact[:, None], tip, axis)
    assert np.abs(ball.cutting(*seen)).max() < 1e-15
    cylinder = CylinderMill(5 * MM, 40 * MM)
    tip, axis = cylinder_positions(BLADE, chain, cylinder)
    seen = seen_from(chain.contact[:, None], tip, axis)
    assert np.abs(cylinder.cutting(*seen)).max() < 1e-15
    assert np.abs(np.sum(axis * chain.normal, axis=-1)).max() < 1e-12


def test_a_cylinder_is_as_close_as_it_can_be_without_gouging(chain):
    """The gap, by distances to nearby points, vanishes to second order in one direction alone."""
    cylinder = CylinderMill(5 * MM, 40 * MM)
    tip, axis = cylinder_positions(BLADE, chain, cylinder)
    k = len(chain) // 2
    turn = np.linspace(0, np.pi, 181)
    step = 0.2 * MM
    from tunneller_lib.milling.chains import conjugate_frame

    _, inverse = conjugate_frame(BLADE, chain.s[k : k + 1], chain.t[k : k + 1], axis[k : k + 1])
    tangent = np.cross(chain.normal[k], axis[k])
    ways = np.cos(turn)[:, None] * axis[k] + np.sin(turn)[:, None] * tangent
    rates = step * ways @ inverse[0].T
    gaps = []
    for sign in (1, -1):
        points = BLADE.points(chain.s[k] + sign * rates[:, 0], chain.t[k] + sign * rates[:, 1])
        gaps.append(cylinder.cutting(*seen_from(points, tip[k : k + 1], axis[k : k + 1]))[0])
    second = sum(gaps) / step**2  # the gap's second derivative, by a difference, in 1/m
    assert -0.5 < second.min() < 0.5 and second.max() > 50


def test_a_cylinder_that_is_too_thick_is_refused(chain):
    with pytest.raises(ValueError, match="mill: must be thin enough"):
        cylinder_positions(BLADE, chain, CylinderMill(5.0, 1.0))


def test_strips_of_cones_are_wider_than_those_of_balls(chain):
    ball = BallMill(MILL.top_radius)
    wide = strip_across(BLADE, MILL, chain, chain.tip, chain.axis, reach=12 * MM)
    narrow = strip_across(BLADE, ball, chain, *ball_positions(chain, ball), reach=12 * MM)
    assert np.median(wide.widths(1e-5)) > 3 * np.median(narrow.widths(1e-5))


def test_dexels_leave_what_the_sweep_says():
    """Frusta cut from a block along z leave, above a graph, its error over the slope."""
    patch = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
    mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    starts = find_positions(patch, mill, 0.003, 0.001, tolerance=1e-4)
    [chain, *_] = trace_chains(patch, mill, starts, step=5e-4, tolerance=1e-4)
    tip, axis = moved(chain.tip, chain.axis, between=20)
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
    error = sweep_error(wanted, mill, chain.tip, chain.axis, between=20)
    assert np.abs(error).max() < 50e-6
    assert np.abs(left - error).max() < 0.2e-6


def test_a_thousand_positions_are_checked_in_half_a_minute():
    share = many(100, 1000) / 1000
    s, t = np.random.default_rng(7).uniform(0.05, 0.95, (2, int(1000 * share)))
    s, t = np.repeat(s, 2), np.repeat(t, 2)
    start = time.process_time()
    found = find_positions(
        BLADE, MILL, s, t, tolerance=TOLERANCE, others=RING.mesh(61, 1).reshape(-1, 3)
    )
    taken = time.process_time() - start
    checked = np.isfinite(found.enters).sum()
    assert checked > 400 * share
    assert taken / checked < 30 / 1000
