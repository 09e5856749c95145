"""A five-axis machine: values of its axes, what they limit, and the ways between chains."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tunneller_lib.job import flank_feeds
from tunneller_lib.job.flank_feeds import seconds_of
from tunneller_lib.milling import (
    ConicalMill,
    Patch,
    TiltingTable,
    find_positions,
    plan_tour,
    trace_chains,
)
from tunneller_lib.milling.five_axes import cradle_depth
from tunneller_lib.milling.positions import depths_of
from tunneller_lib.milling.tools import seen_from
from tunneller_lib.milling.tour import STEP, Tour
from tunneller_lib.ream.timing import fastest

MM = 1e-3
PATCH = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
MILL = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
LOOK = {"tolerance": 1e-4, "n": 41}
WIDE = TiltingTable((0, 0, -0.1), (1, 0, 0), (-1, 1), (-1, 1), (-1, 1), (-3.2, 3.2), (-9, 9), 0.5)


def rotation(angle, axis):
    """Return a rotation by Rodrigues' formula, which the machine's equations don't use."""
    k = np.cross(np.eye(3), np.array(axis, dtype=float))
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


@pytest.fixture(scope="module")
def found():
    return find_positions(PATCH, MILL, *PATCH.parameters(3, margin=0.2), **LOOK)


@pytest.fixture(scope="module")
def chains(found):
    longest = sorted(trace_chains(PATCH, MILL, found, step=1 * MM, **LOOK), key=len)
    return longest[-2:]


def test_values_that_are_no_rows_of_five_are_refused():
    with pytest.raises(ValueError, match=r"^values: must be rows of x, y, z, A, C \(k, 5\); got"):
        WIDE.positions(np.zeros((4, 3)))


def test_an_axis_that_leans_by_more_than_rounding_has_its_own_turn():
    machine = replace(WIDE, up=(0, 0, 1))
    lean = np.array([0.2, 0.1, 1e-8, 1e-10])  # the last is taken as upright
    turn = np.array([0.1, 0.2, 0.5, 1.0])
    axis = np.stack([lean * np.sin(turn), lean * np.cos(turn), np.sqrt(1 - lean**2)], axis=-1)
    values = machine.values(np.zeros((4, 3)), axis @ machine.frame)
    np.testing.assert_allclose(values[:, 4], [0.1, 0.2, 0.5, 0.5], atol=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 50.0])
def test_a_turned_workpiece_stands_under_the_spindle(scale):
    rng = np.random.default_rng(0)
    for _ in range(20):
        pivot, up = rng.normal(size=(2, 3)) * scale
        machine = replace(WIDE, pivot=tuple(pivot), up=tuple(up))
        tip = scale * rng.normal(size=(6, 3))
        axis = rng.normal(size=(6, 3))
        axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
        values = machine.values(tip, axis)
        for point, way, (x, y, z, a, c) in zip(tip, axis, values, strict=True):
            turned = rotation(a, (1, 0, 0)) @ rotation(c, (0, 0, 1)) @ machine.frame
            np.testing.assert_allclose(turned @ way, (0, 0, 1), atol=1e-14)
            np.testing.assert_allclose(turned @ (point - pivot), (x, y, z), atol=1e-14 * scale)
        tips, axes = machine.positions(values)
        np.testing.assert_allclose(tips, tip, atol=1e-14 * scale)
        np.testing.assert_allclose(axes, axis, atol=1e-14)


def test_a_machines_frame_is_three_unit_vectors_right_handed():
    for up in ((0, 1, 0), (0, 0, -2), (1, 0, 0), (1e-3, 1, 1e-3)):
        frame = replace(WIDE, up=up).frame
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(frame) > 0
        np.testing.assert_allclose(frame[2], np.array(up) / np.linalg.norm(up))


def test_axes_along_up_but_for_rounding_turn_nothing():
    up = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)
    axis = up + 1e-13 * np.random.default_rng(0).normal(size=(5, 3))
    values = replace(WIDE, up=(1, 2, 3)).values(0.01 * axis, axis)
    np.testing.assert_array_equal(values[:, 4], 0)


def test_an_axis_that_passes_the_pole_changes_the_sign_of_a():
    """A smooth way past `up`, 0.1 degrees aside: by one sign of A the table would turn by 180."""
    lean = np.radians(np.linspace(-20, 20, 20))
    aside = np.radians(0.1)
    axis = np.stack([np.sin(lean), np.full(20, np.sin(aside)), np.cos(lean)], axis=-1)
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    machine = replace(WIDE, up=(0, 0, 1))
    values = machine.values(0.01 * axis, axis)
    assert np.abs(np.diff(values[:, 3:], axis=0)).max() < np.radians(12)
    assert values[0, 3] * values[-1, 3] < 0
    assert not machine.beyond(values).astype(bool).any()


def test_an_axis_along_up_keeps_the_turn_of_the_position_before():
    up = np.tile([0.0, 0.0, 1.0], (5, 1))
    axis = up.copy()
    axis[:2] = (0.6, 0, 0.8), (0.1, 0, np.sqrt(0.99))
    values = replace(WIDE, up=(0, 0, 1)).values(np.zeros((5, 3)), axis)
    np.testing.assert_allclose(values[:, 4], values[0, 4])


def test_positions_beyond_the_axes_are_said_with_the_axis_and_its_limit():
    rows = np.array([[0, 0, 0, 0.1, 0], [2, 0, 0, 0.1, 0], [0, 0, 0, 3.3, 0], [0, 0, 0, 3.1, 9.5],
                     [0, 0, 0, 3.1, 8.6], [0, 0, 0, 3.1, 8.7]])  # fmt: skip
    said = WIDE.beyond(rows).tolist()
    assert said[0] == "" and said[5] == ""
    assert said[1] == "x must lie from -1000 to 1000 mm; it would be 2000 mm."
    assert said[2].startswith("A must lie from -183.346 to 183.346 deg; it would be 189.1 deg")
    assert said[3].startswith("C must lie from")
    assert said[4] == "C would turn by more than 28.6479 deg in one step."


def test_a_position_that_the_machine_cant_reach_is_refused(found):
    steep = replace(WIDE, tilt=(-0.1, 0.1))
    again = find_positions(PATCH, MILL, *PATCH.parameters(3, margin=0.2), machine=steep, **LOOK)
    lean = np.arccos(found.axis @ np.array(WIDE.up))
    assert found.fits.any()
    np.testing.assert_array_equal(again.fits, found.fits & (lean <= 0.1))
    assert set(again.reason[found.fits & (lean > 0.1)]) == {"beyond the machine's axes"}


def test_a_chain_ends_where_the_machines_axes_do(found, chains):
    whole = chains[-1]
    values = WIDE.values(whole.tip, whole.axis)
    middle = len(whole) // 2
    span = sorted(values[[2, -3], 4])
    narrow = replace(WIDE, turn=(span[0] - 1e-9, span[1] + 1e-9))
    starts = replace(
        found, reason=np.where(np.arange(len(found)) == _start(found, whole), "fits", "")
    )
    [cut] = trace_chains(PATCH, MILL, starts, step=1 * MM, machine=narrow, **LOOK)
    assert 4 <= len(cut) < len(whole) and middle
    assert "the machine's axes end" in cut.ends
    assert not narrow.beyond(narrow.values(cut.tip, cut.axis)).astype(bool).any()


def _start(found, chain):
    """Return the row of positions from which a chain was begun."""
    off = np.linalg.norm(found.tip[:, None] - chain.tip, axis=-1).min(axis=1)
    return int(np.argmin(np.where(found.fits, off, np.inf)))


def test_a_tour_cuts_its_chains_and_touches_nothing_between(chains):
    tour = plan_tour(PATCH, MILL, chains, WIDE, clearance=0.01, **LOOK)
    for k, chain in enumerate(chains):
        rows = (tour.kind == "cut") & (tour.chain == k)
        np.testing.assert_allclose(tour.tip[rows], chain.tip, atol=1e-15)
        np.testing.assert_allclose(tour.axis[rows], chain.axis, atol=1e-14)
    changes = np.flatnonzero(np.append(True, tour.kind[1:] != tour.kind[:-1]))
    assert tour.kind[changes].tolist() == [
        "approach", "cut", "retract", "traverse", "approach", "cut", "retract"
    ]  # fmt: skip
    between = tour.kind != "cut"
    own, holder, _ = depths_of(PATCH, MILL, tour.tip[between], tour.axis[between], None, 41)
    assert own.max() <= LOOK["tolerance"] and holder.max() == 0
    steps = np.abs(np.diff(tour.values, axis=0))[between[1:]]
    assert steps[:, :3].max() <= STEP[0] * (1 + 1e-9) and steps[:, 3:].max() <= STEP[1] * (1 + 1e-9)


def test_while_the_table_moves_the_tip_is_above_the_ball_about_the_pivot(chains):
    tour = plan_tour(PATCH, MILL, chains, WIDE, clearance=0.01, **LOOK)
    aside = tour.kind == "traverse"
    highest = np.linalg.norm(PATCH.mesh(41) - np.array(WIDE.pivot), axis=-1).max()
    assert tour.values[aside, 2].min() >= highest + 0.01 - 1e-12
    assert np.ptp(tour.values[aside, 2]) < 1e-12


def test_a_tour_past_an_obstacle_is_refused(chains):
    chain = chains[0]
    above = chain.tip[-1] + (MILL.length + MILL.holder_length + 0.02) * chain.axis[-1]
    with pytest.raises(ValueError, match="on the retract of chain 0 the mill would enter a neigh"):
        plan_tour(PATCH, MILL, [chain], WIDE, clearance=0.01, others=[above], **LOOK)


def test_the_cradle_tilts_with_the_workpiece_and_doesnt_turn_with_it(found):
    """On the workpiece the cradle's points turn back by C about `up`, through the pivot."""
    rng = np.random.default_rng(0)
    cradle = rng.uniform(-0.3, 0.3, (400, 3))
    machine = replace(WIDE, cradle=cradle)
    values = machine.values(found.tip, found.axis, MILL)
    depth = cradle_depth(machine, MILL, values)
    for tip, axis, turn, ours in zip(found.tip, found.axis, values[:, 4], depth, strict=True):
        there = cradle @ rotation(-turn, (0, 0, 1)).T @ machine.frame + np.array(machine.pivot)
        seen = seen_from(there, tip[None], axis[None])
        theirs = np.minimum(MILL.cutting(*seen), MILL.holder(*seen)).min()
        assert ours == pytest.approx(max(-theirs, 0), abs=1e-14)
    assert 0 < np.sum(depth > 0) < len(depth)
    assert not cradle_depth(WIDE, MILL, values).any()
    assert not cradle_depth(machine, None, values).any()


def post_of(values, row):
    """Return a point of the cradle that is within the holder at a row of values."""
    return rotation(-values[row, 3], (1, 0, 0)) @ (values[row, :3] + [0, 0, MILL.length + 0.02])


def test_positions_in_the_cradle_are_refused_unless_the_other_sign_of_a_clears_it(found):
    row = np.flatnonzero(found.fits)[0]
    ways = [replace(WIDE, tilt=tilt) for tilt in ((0, 3.2), (-3.2, 0))]  # one sign of A each
    whole = np.repeat(found.tip[row : row + 1], 4, axis=0), np.repeat(found.axis[[row]], 4, axis=0)
    posts = np.array([post_of(way.values(*whole), 0) for way in ways])
    for cradle, refused in ((posts[:1], False), (posts, True)):
        machine = replace(WIDE, cradle=cradle)
        again = find_positions(
            PATCH, MILL, *PATCH.parameters(3, margin=0.2), machine=machine, **LOOK
        )
        assert again.reason[row] == ("enters the machine's cradle" if refused else "fits")
        assert machine.reaches(*(part[0] for part in whole), MILL) == (not refused)
        assert machine.reaches(*(part[0] for part in whole))


def test_a_chain_ends_before_the_cradle_and_a_tour_into_it_is_refused(found, chains):
    chain = chains[-1]
    one_sign = replace(WIDE, tilt=(0, 3.2))
    values = one_sign.values(chain.tip, chain.axis)
    machine = replace(one_sign, cradle=[post_of(values, len(chain) - 1)])
    only = np.arange(len(found)) == _start(found, chain)
    starts = replace(found, reason=np.where(only, "fits", ""))
    [cut] = trace_chains(PATCH, MILL, starts, step=1 * MM, machine=machine, **LOOK)
    assert "the cradle is in the way" in cut.ends and 4 <= len(cut) < len(chain)
    assert not cradle_depth(machine, MILL, machine.values(cut.tip, cut.axis, MILL)).any()
    with pytest.raises(ValueError, match=r"chain 0 the mill would enter the machine's cradle, by"):
        plan_tour(PATCH, MILL, [chain], machine, clearance=0.01, **LOOK)


def test_a_tour_without_room_above_or_beyond_the_axes_is_refused(chains):
    low = replace(WIDE, z=(-1, 0.05))
    with pytest.raises(ValueError, match=r"machine: z must reach 1.* mm, where the table moves"):
        plan_tour(PATCH, MILL, chains, low, clearance=0.01, **LOOK)
    short = replace(WIDE, tilt=(-1e-3, 1e-3))
    with pytest.raises(ValueError, match=r"machine: A must lie from .* at position \d+ of chain 0"):
        plan_tour(PATCH, MILL, chains, short, clearance=0.01, **LOOK)


@pytest.mark.parametrize("far", [0.01, 0.4])
def test_a_straight_way_takes_what_the_ramps_of_its_slowest_axis_take(far):
    """From rest to rest, at 0.3 m/s and 1 m/s^2 at most: 0.09 m are the ramps alone."""
    share = np.linspace(0, 1, 41)[:, None]
    values = share * [far, -far / 2, 0.0, 0.0, 0.1 * far]
    tip, axis = WIDE.positions(values)
    tour = Tour(np.full(41, "traverse"), np.zeros(41, int), tip, axis, values)
    found = seconds_of(tour, MILL.length, 1e-3, [0.3] * 5, [1.0] * 5).sum()
    ramps = 2 * np.sqrt(far) if far < 0.09 else far / 0.3 + 0.3
    assert ramps <= found <= 1.01 * ramps


def test_a_straight_way_back_takes_twice_the_way_there():
    """At its middle no axis moves; a rest takes a part more, of 128 a step, than it would need."""
    values = np.array([[0.0, 0, 0, 0, 0], [0.01, 0, 0, 0, 0], [0.0, 0, 0, 0, 0]])
    tip, axis = WIDE.positions(values)
    tour = Tour(np.full(3, "cut"), np.zeros(3, int), tip, axis, values)
    found = seconds_of(tour, MILL.length, 0.02, [0.3] * 5, [1.0] * 5).sum()
    there = 0.01 / 0.02 + 0.02 / 1.0
    assert 2 * there <= found <= 2 * (1 + 4 / 128) * there


@pytest.mark.parametrize("scale", [1e-2, 1.0, 1e2])
@pytest.mark.parametrize("slow", [None, 0, 1, 2, 3, 4])
@pytest.mark.parametrize("slower", [10, 1000])
def test_between_places_the_accelerations_are_kept_too(chains, monkeypatch, scale, slow, slower):
    """Of the times' own profile, whose squared rate is linear between the places looked at."""
    [chain] = chains[-1:]
    count = len(chain)
    values = WIDE.values(chain.tip, chain.axis)
    tour = Tour(np.full(count, "cut"), np.zeros(count, int), chain.tip, chain.axis, values)
    accelerations = scale * np.array([0.1, 0.1, 0.1, 1, 1])
    if slow is not None:
        accelerations[slow] /= slower
    profiles = []

    def kept(steps, places):
        profiles.append(fastest(steps, places))
        return profiles[-1]

    monkeypatch.setattr(flank_feeds, "fastest", kept)
    speeds = np.array([0.3, 0.3, 0.3, 1, 1])
    seconds_of(tour, MILL.length, 0.02, speeds, accelerations)
    [squared] = profiles
    looked = np.linspace(0, count - 1, len(squared))
    between = np.linspace(0, count - 1, 10 * (len(squared) - 1) + 1)[:-1] + 1e-9
    way = CubicSpline(np.arange(count), values)
    x = np.interp(between, looked, squared)[:, None]
    change = np.repeat(np.diff(squared) / np.diff(looked), 10)[:, None]
    speed = way(between, 1) * np.sqrt(x)
    acceleration = way(between, 1) * change / 2 + way(between, 2) * x
    assert np.abs(speed / speeds).max() <= 1
    share = np.abs(acceleration / accelerations).max()
    assert share <= 1
    assert share > (0.95 if scale < 1 else 0)
