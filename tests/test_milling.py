"""Mills on surfaces: positions, chains, and what strips, patches and scallops leave."""

from dataclasses import replace

import numpy as np
import pytest

from tunneller_lib.envelopes import ConePose
from tunneller_lib.envelopes.families import moving_cone, turning
from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    CylinderMill,
    Patch,
    ball_chain,
    cover,
    coverage_of,
    cylinder_chain,
    find_positions,
    find_scallops,
    strip_across,
)
from tunneller_lib.milling.chains import Chain, conjugate_frame, motion_through, trace_chain
from tunneller_lib.milling.faces import BladeRing
from tunneller_lib.milling.strips import sweep_error
from tunneller_lib.milling.tools import seen_from
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import Frustum

MM = 1e-3
RING = BladeRing(60 * MM, 30 * MM, 50 * MM, -0.7, 1.2, -6 * MM, -6 * MM, 6)
BLADE = Patch(RING.coordinates, (0, 1), (0, 1))
MILL = ConicalMill(np.radians(15), 4 * MM, 40 * MM, 12 * MM, 40 * MM)
PLANE = Patch(lambda s, t: [s, t, 0 * s], (-0.02, 0.02), (-0.02, 0.02))
BALL = BallMill(5 * MM)
SADDLE = Patch(lambda s, t: [s, t, 30 * s * t + 200 * s**3], (-0.01, 0.01), (-0.01, 0.01))
BROAD = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)  # for the saddle
TOLERANCE = 10e-6
LOOK = {"tolerance": 1e-7, "n": 31}
HALF_ANGLE = np.radians(10)


def straight(y, count=12):
    """Return a chain of a ball on the plane, along x at a place y."""
    x = np.linspace(-11 * MM, 11 * MM, count)
    contact = np.stack([x, np.full(count, y), np.zeros(count)], axis=-1)
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    return Chain(x, contact[:, 1], contact, up, contact, up, up[:, [0, 2, 1]])


def first(chain, k):
    """Return the first k positions of a chain."""
    return Chain(*(part[:k] for part in vars(chain).values()))


@pytest.fixture(scope="module")
def on_blade():
    others = np.concatenate([RING.mesh(61, k).reshape(-1, 3) for k in (1, -1)])
    s, t = BLADE.parameters(9, margin=0.05)
    return others, find_positions(BLADE, MILL, s, t, tolerance=TOLERANCE, others=others)


@pytest.fixture(scope="module")
def chain(on_blade):
    others, found = on_blade
    row = int(np.flatnonzero(found.fits)[10])
    return trace_chain(BLADE, MILL, found, row, step=1 * MM, tolerance=TOLERANCE, others=others)


@pytest.fixture(scope="module")
def on_saddle():
    found = find_positions(SADDLE, BROAD, *SADDLE.parameters(2, margin=0.2), **LOOK)
    rows = np.flatnonzero(found.fits).tolist()
    return found, [trace_chain(SADDLE, BROAD, found, row, step=1 * MM, **LOOK) for row in rows]


# ---- positions ------------------------------------------------------------------------------


def test_the_distance_to_a_mill_is_that_to_its_cone():
    rng = np.random.default_rng(3)
    points = 0.05 * rng.normal(size=(2000, 3))
    axis = rng.normal(size=(1, 3))
    axis /= np.linalg.norm(axis)
    tip = 0.01 * rng.normal(size=(1, 3))
    ours = MILL.cutting(*seen_from(points, tip, axis))[0]
    pose = ConePose(tip[0] - MILL.below * axis[0], axis[0], MILL.half_angle, *MILL.rulings)
    np.testing.assert_allclose(ours, pose.clearance(points), atol=1e-15)
    solid = Frustum(tip[0], tip[0] + MILL.length * axis[0], MILL.tip_radius, MILL.top_radius)
    enter, leave = solid.meet_line(points, (0.0, 0.6, 0.8))
    np.testing.assert_array_equal(ours < 0, (enter < 0) & (leave > 0))
    assert np.any(ours < 0)


def test_the_holder_is_a_cylinder_above_the_mill():
    height = np.array([0.03, 0.041, 0.06, 0.06, 0.09])
    radius = np.array([0.0, 0.0, 0.011, 0.015, 0.0])
    np.testing.assert_allclose(MILL.holder(height, radius), [0.01, -0.001, -0.001, 0.003, 0.01])


def test_positions_touch_on_the_cutting_part_with_unit_normals_towards_the_mill(on_blade):
    _, found = on_blade
    at = np.isfinite(found.enters)
    seen = seen_from(found.contact[at][:, None], found.tip[at], found.axis[at])
    assert np.abs(MILL.cutting(*seen)).max() < 1e-15
    near, far = MILL.rulings
    assert np.all((found.distance[at] >= near) & (found.distance[at] <= far))
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=-1), 1, rtol=1e-14)
    assert np.all(np.sum((found.tip - found.contact) * found.normal, axis=-1)[found.fits] > 0)


def test_depths_are_those_of_a_finer_mesh(on_blade):
    _, found = on_blade
    mesh = BLADE.mesh(400).reshape(-1, 3)
    for k in np.flatnonzero(np.isfinite(found.enters))[::4]:
        vertex = found.tip[k] - MILL.below * found.axis[k]
        tool = ConePose(vertex, found.axis[k], MILL.half_angle, *MILL.rulings)
        # What lies between the points of a finer mesh may be a little deeper.
        assert -1e-9 <= found.enters[k] - max(-tool.clearance(mesh).min(), 0) <= 1e-6


def test_reasons_say_what_the_depths_say(on_blade):
    others, found = on_blade
    assert found.fits.sum() > 20 and np.all(found.enters[found.fits] <= TOLERANCE)
    assert not found.holder_enters[found.fits].any() and not found.others_enter[found.fits].any()
    # With a long mill both reasons occur; each is one just above the tolerance, and none below.
    long = replace(MILL, length=80 * MM)
    s, t = BLADE.parameters(9, margin=0.05)
    deep = find_positions(BLADE, long, s, t, tolerance=TOLERANCE, others=others)
    for reason in ("gouges at its contact", "enters the surface elsewhere"):
        k = np.argmin(np.where(deep.reason == reason, deep.enters, np.inf))
        for share, refused in ((0.99, True), (1.01, False)):
            look = {"tolerance": share * deep.enters[k], "others": others}
            again = find_positions(BLADE, long, deep.s[k], deep.t[k], **look)
            row = np.argmin(np.linalg.norm(again.axis - deep.axis[k], axis=-1))
            assert (again.reason[row] == reason) == refused
    away = np.isin(found.reason, ["on the other side", "off the cutting part"])
    assert np.all(np.isinf(found.enters[away])) and away.any()
    # An obstacle in the mill's middle is a neighbour.
    row = np.flatnonzero(found.fits)[0]
    obstacle = found.tip[row] + 0.5 * MILL.length * found.axis[row]
    again = find_positions(BLADE, MILL, s, t, tolerance=TOLERANCE, others=[obstacle])
    assert again.reason[row] == "enters a neighbour"
    middle = (MILL.tip_radius + MILL.top_radius) / 2 * np.cos(MILL.half_angle)
    assert again.others_enter[row] == pytest.approx(middle)


def test_where_a_surface_is_no_saddle_no_position_fits():
    ball = Patch(lambda s, t: [s, t, 10 * (s * s + t * t)], (-0.01, 0.01), (-0.01, 0.01))
    found = find_positions(ball, MILL, *ball.parameters(5, margin=0.1), tolerance=0)
    assert len(found) and not found.fits.any()


# ---- chains ---------------------------------------------------------------------------------


def test_chains_go_across_the_characteristic_in_equal_steps_to_the_patch_s_rim(on_saddle):
    left = [[0.01 - max(abs(c.s[k]), abs(c.t[k])) for k in (0, -1)] for c in on_saddle[1]]
    assert np.sum(np.max(left, axis=1) < 1e-3) == 4  # the mill would enter at the ends of two
    for chain in on_saddle[1]:
        chord = np.diff(chain.contact, axis=0)
        length = np.linalg.norm(chord, axis=-1)
        np.testing.assert_allclose(length, 1e-3, rtol=4e-3)
        middle = chain.across[1:] + chain.across[:-1]
        assert np.abs(np.sum(chord * middle, axis=-1) / length).max() < 0.03


@pytest.mark.parametrize("side", [1, -1])
def test_a_chain_past_an_obstacle_keeps_its_start(on_saddle, side):
    """The obstacle lies in the way of the mill, a step ahead of the start and not within it."""
    found, (free, *_) = on_saddle
    row = int(np.flatnonzero(found.fits)[0])
    start = int(np.argmin(np.abs(free.contact - found.contact[row]).sum(axis=1)))
    ahead = start + side
    way = free.tip[ahead] - free.tip[start]
    radius = BROAD.tip_radius + BROAD.length / 2 * np.tan(BROAD.half_angle)
    middle = free.tip[ahead] + BROAD.length / 2 * free.axis[ahead]
    point = middle + 0.99 * radius * way / np.linalg.norm(way)
    blocked = trace_chain(SADDLE, BROAD, found, row, step=1 * MM, others=[point], **LOOK)
    kept = slice(None, start + 1) if side > 0 else slice(start, None)
    assert len(blocked) <= len(free.tip[kept]) < len(free)
    assert np.abs(blocked.contact - found.contact[row]).sum(axis=1).min() < 1e-12


@pytest.mark.parametrize(("degrees", "goes_on"), [(13, True), (17, False)])
def test_the_axis_turns_by_15_degrees_at_most(on_saddle, degrees, goes_on):
    found, _ = on_saddle
    row, turn = int(np.flatnonzero(found.fits)[0]), np.radians(degrees)
    across = np.cross(found.axis, found.normal)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    leaning = replace(found, axis=np.cos(turn) * found.axis + np.sin(turn) * across)
    if goes_on:
        assert len(trace_chain(SADDLE, BROAD, leaning, row, step=1 * MM, **LOOK)) > 1
    else:
        with pytest.raises(ValueError, match="found: must be positions of this mill"):
            trace_chain(SADDLE, BROAD, leaning, row, step=1 * MM, **LOOK)


def axis_of(motion, v):
    return np.stack(np.broadcast_arrays(*motion(v)[2][0]), axis=-1)


def test_the_known_motion_of_a_cone_is_recovered_from_its_envelope():
    def vertex(v):
        return [0.03 * v, 0.01 * v * v, 0.01 * v]

    def velocity(v):
        return [0.03 + 0 * v, 0.02 * v, 0.01 + 0 * v]

    motion = turning(vertex, velocity, 1.0, rate=0.7, start=1.0)
    patch = Patch(moving_cone(motion, HALF_ANGLE), (3.7, 5.2), (0, 1), -1)
    mill = ConicalMill(HALF_ANGLE, 2 * MM, 70 * MM, 5 * MM, 50 * MM)
    # The sweep of that motion is the surface.
    v = np.linspace(0, 1, 60)
    axis = axis_of(motion, v)
    tip = np.stack(np.broadcast_arrays(*vertex(v)), axis=-1) + mill.below * axis
    error = sweep_error(patch.mesh(60)[:, 5:-5], mill, Chain(v, v, tip, axis, tip, axis, axis))
    assert np.abs(error).max() < 1e-9
    # And among the surface's cones that fit are those of the motion, whose chain sweeps it.
    found = find_positions(patch, mill, *patch.parameters(5, margin=0.1), tolerance=1e-6)
    right = np.linalg.norm(found.axis - axis_of(motion, found.t), axis=-1) < 2e-7
    assert np.unique(found.index[right & found.fits]).size == 25
    row = int(np.flatnonzero((found.index == 12) & found.fits & right)[0])
    chain = trace_chain(patch, mill, found, row, step=1 * MM, tolerance=1e-6)
    np.testing.assert_allclose(chain.axis, axis_of(motion, chain.t), atol=2e-7)
    assert np.all(np.sum((found.tip - found.contact) * found.normal, axis=-1)[found.fits] > 0)
    strip = strip_across(patch, mill, chain, reach=20 * MM)
    assert strip.widths(1e-8).min() > 13 * MM  # the whole patch


# ---- what a mill leaves ---------------------------------------------------------------------


def test_a_ball_along_a_line_leaves_what_pythagoras_says():
    y = np.linspace(-2e-3, 2e-3, 21)
    points = np.stack([np.full(21, 0.47 * MM), y, np.zeros(21)], axis=-1)
    np.testing.assert_allclose(
        sweep_error(points, BALL, straight(0.0)), np.hypot(y, 5 * MM) - 5 * MM, atol=1e-9
    )


def test_a_sweep_needs_four_positions_and_a_strip_six(chain):
    with pytest.raises(ValueError, match=r"^chain: must have 4 positions or more; got 3\.$"):
        sweep_error((0.0, 0.0, 0.0), MILL, first(chain, 3))
    assert np.abs(sweep_error(chain.contact[:4], MILL, first(chain, 4))).max() < 1e-9
    assert len(strip_across(BLADE, MILL, first(chain, 6), reach=5 * MM).along) == 2
    with pytest.raises(ValueError, match=r"^chain: must have 6 positions or more; got 5\.$"):
        strip_across(BLADE, MILL, first(chain, 5), reach=5 * MM)


def test_ball_and_cylinder_touch_where_the_chain_does(chain):
    cylinder = CylinderMill(5 * MM, 40 * MM)
    beside = cylinder_chain(BLADE, chain, cylinder)
    for mill, one in ((BALL, ball_chain(chain, BALL)), (cylinder, beside)):
        seen = seen_from(chain.contact[:, None], one.tip, one.axis)
        assert np.abs(mill.cutting(*seen)).max() < 1e-15
    assert np.abs(np.sum(beside.axis * chain.normal, axis=-1)).max() < 1e-12
    other = cylinder_chain(BLADE, chain, cylinder, which=-1)
    assert np.abs(np.sum(beside.axis * other.axis, axis=-1)).max() < 0.99  # two ways
    with pytest.raises(ValueError, match="mill: must be thin enough"):
        cylinder_chain(BLADE, chain, CylinderMill(5.0, 1.0))


@pytest.mark.parametrize("which", [1, -1])
def test_a_cylinder_is_as_close_as_it_can_be_without_gouging(chain, which):
    """The gap, by distances to nearby points, vanishes to second order in one direction alone."""
    cylinder = CylinderMill(5 * MM, 40 * MM)
    k = len(chain) // 2
    beside = cylinder_chain(BLADE, chain, cylinder, which=which)
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


def test_dexels_leave_what_the_sweep_says():
    """Frusta cut from a block along z leave, above a graph, its error over the slope."""
    patch = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
    found = find_positions(patch, BROAD, 0.003, 0.001, tolerance=1e-4)
    row = int(np.flatnonzero(found.fits)[0])
    chain = trace_chain(patch, BROAD, found, row, step=5e-4, tolerance=1e-4)
    last = len(chain) - 1
    tip, axis = motion_through(chain.tip, chain.axis)(np.linspace(0, last, 20 * last + 1))
    middle = chain.contact[len(chain) // 2]
    half = np.array([1.5, 1.5, 5]) * MM
    low = middle - half
    grid = DexelGrid.cartesian(low, middle + half, (31, 31))
    for a, u in zip(tip, axis, strict=True):
        grid.cut(Frustum(a, a + BROAD.length * u, BROAD.tip_radius, BROAD.top_radius))
    x, y = np.meshgrid(grid.lines.x, grid.lines.aside, indexing="ij")
    below = (grid.low == low[2]) & (grid.high > grid.low)
    top = np.where(below, grid.high, -np.inf).max(axis=0)
    wanted = patch.points(x, y)
    left = (top - wanted[..., 2]) / np.sqrt(1 + 900 * (x * x + y * y))
    error = sweep_error(wanted, BROAD, chain)
    assert np.abs(error).max() < 50e-6
    assert np.abs(left - error).max() < 0.2e-6


# ---- patches and scallops -------------------------------------------------------------------


def test_a_coverage_takes_the_chain_that_adds_most_and_none_that_adds_little(on_saddle):
    found, chains = on_saddle
    covered = cover(SADDLE, BROAD, found, step=1 * MM, **LOOK)
    mesh = SADDLE.mesh(31)
    assert 1 < len(chains) <= 6  # all are tried in the first round
    alone = [sweep_error(mesh, BROAD, chain) for chain in chains if len(chain) > 5]
    best = max(replace(covered, error=error).share(1e-7) for error in alone)
    error = np.full(mesh.shape[:2], np.inf)
    shares = [0.0]
    for chain in covered.chains:
        error = np.minimum(error, sweep_error(mesh, BROAD, chain))
        shares.append(replace(covered, error=error).share(1e-7))
    assert shares[1] == pytest.approx(best) and np.diff(shares).min() >= 0.01
    np.testing.assert_array_equal(error, covered.error)


@pytest.mark.parametrize("pitch", [0.5 * MM, 4 * MM])
def test_balls_side_by_side_leave_the_scallops_of_pythagoras(pitch):
    chains = [straight(k * pitch) for k in (-1, 0, 1)]
    lines, height = find_scallops(PLANE, BALL, chains, m=101)
    np.testing.assert_allclose(height, np.hypot(pitch / 2, 5 * MM) - 5 * MM, rtol=1e-6)
    assert set(map(tuple, lines[:, [0, 2]].tolist())) == {(0, 1), (1, 2)}  # not the outer two
    assert len(lines) == 16  # eight inner contacts, each pair once
    np.testing.assert_array_equal(lines[:, 1], lines[:, 3])
    assert lines[:, 1].min() == 2 and lines[:, 1].max() == 9


def test_a_patch_has_its_area():
    assert coverage_of(PLANE, BALL, [straight(0.0)], n=21).area.sum() == pytest.approx(0.04**2)


def test_a_strip_between_counts():
    """The outer two chains begin lines to the middle one, whose sweep is what is left there."""
    outer = [straight(-2 * MM), straight(2 * MM)]
    alone = find_scallops(PLANE, BALL, outer, m=101)[1].max()
    both = find_scallops(PLANE, BALL, [*outer, straight(0.5 * MM)], m=101)[1].max()
    assert both == pytest.approx(np.hypot(1.25 * MM, 5 * MM) - 5 * MM, rel=1e-3)
    assert both < alone


def test_chains_that_lie_alone_behind_or_are_too_short_have_no_scallops():
    one = straight(0.0)
    away = np.array([0.03, 1 * MM, 0])  # more along than across
    behind = replace(one, contact=one.contact + away, tip=one.tip + away)
    short = [straight(0.0, count=4), straight(1 * MM, count=4)]
    there_and_back = zip(*(vars(straight(y)).values() for y in (0.0, 2 * MM)), strict=True)
    turned_back = Chain(*(np.concatenate([go, back[::-1]]) for go, back in there_and_back))
    for chains in ([one], short, [one, behind], [turned_back]):
        lines, height = find_scallops(PLANE, BALL, chains)
        assert lines.shape == (0, 4) and height.shape == (0,)
