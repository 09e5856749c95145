"""The whole cut: plan, feed, wall; ideal chains against closed forms; plans that are refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.controllers import job_with
from tunneller_lib.motion import Integrator, Lag, Loop, follow, reference_axes
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, Pose, carve, plan, simulate, starved
from tunneller_lib.ream.moves import Moves, move_lengths, move_shares, move_ticks, strains
from tunneller_lib.ream.wall import intact_wall, lap_volume, pass_distance, scallop_height
from tunneller_lib.removal import Ground
from tunneller_lib.removal.arm_clearance import rod_clearance
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

READS = ["tests/references/reference_job.toml"]

EGG = Egg(0.5)
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, EGG)
BITS16 = 2 * np.pi / 2**16
QUICK = Limits(feed=0.1, acceleration=0.5)
LAG = Lag(0.5, 0.02)
LOOP = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=BITS16)
COARSE = (150, 240)


def lap(limits=QUICK, **options):
    return plan(CIRCUIT, limits, **({"tolerance": 1e-3, "rest": 0.5} | options))


# Plan


def test_plan_begins_and_ends_at_rest_on_the_circuit():
    job = lap()
    assert job.feed[0] == job.feed[-1] == 0 and job.feed.max() == pytest.approx(0.1, rel=1e-3)
    assert np.array_equal(job.parts[0], job.parts[-1])
    assert job.s[0] == 0 and job.s[-1] == job.s[-2] == CIRCUIT.profile.perimeter
    np.testing.assert_allclose(CIRCUIT.overbreak(job.setpoints[[0, -1]]), 0, atol=1e-13)
    corners = CIRCUIT.machine.torus.point(*job.route.at(job.route.ends[:-1]).T)
    missed = np.linalg.norm(corners - CIRCUIT.point(job.knots), axis=-1)
    assert missed.max() <= 0.5e-3 * (1 + 1e-4)  # half the tolerance
    assert np.median(missed) > 0.05e-3


def test_plan_keeps_its_tolerance_and_its_counts():
    job = lap()
    over = CIRCUIT.overbreak(job.setpoints)
    assert -1e-3 <= over.min() < -0.9e-3 and over.max() <= 1e-3
    moved = job.tick * np.cumsum(np.concatenate([np.zeros((1, 2)), job.slopes]), axis=0)
    line = job.setpoints[0] + moved
    assert np.abs(job.setvalues - line).max() <= BITS16 / 2 * (1 + 2 / job.fineness)
    assert job.lap_time == pytest.approx(len(job.setvalues) * 0.005 - 0.005)


def test_plan_moves_no_farther_than_a_step():
    job = lap(step=4e-3)
    assert np.linalg.norm(np.diff(job.centres(job.setpoints), axis=0), axis=1).max() <= 4e-3
    steady = (job.feed[1:-1] > 0.09999) & (job.feed[:-2] > 0.09999)
    assert np.mean(job.ticks[:-1][steady] == 8) > 0.7  # 4 mm at 0.1 m/s, but before turns


def strained(job):
    """Return the greatest change of slope in a tick, as an acceleration of the cutter in m/s^2."""
    slopes = np.concatenate([np.zeros((1, 2)), job.slopes, np.zeros((1, 2))])
    change = job.circuit.machine.torus.velocity(job.setvalues, np.diff(slopes, axis=0))
    return np.linalg.norm(change, axis=-1).max() / job.tick


@pytest.mark.parametrize(
    "limits", [Limits(feed=0.3, acceleration=0.2), Limits(feed=0.3, acceleration=0.5, volume=1e-4)]
)
def test_exported_moves_keep_every_limit(limits):
    job = lap(limits)
    assert 0.9 < max(job.shares.values()) <= 1
    assert strained(job) <= limits.acceleration * 1.01  # setpoints in parts of a count


def test_slowed_lap_goes_up_to_its_limit():
    job = lap()
    way = job.route.at(job.reached[: -job.ticks[-1]])
    assert 1 - 1e-5 < strains(CIRCUIT.machine.torus, way, job.tick, QUICK).max() <= 1 + 2e-7


def test_route_has_the_derivatives_of_its_positions():
    way = lap(tolerance=3e-3).route
    length = np.linspace(0.01, way.length - 0.01, 4001)
    h = 1e-5
    for order, within in ((1, 1e-6), (2, 1e-4)):
        found = way.at(length, order=order)
        sides = way.at(length + h, order=order - 1), way.at(length - h, order=order - 1)
        off = np.linalg.norm((sides[0] - sides[1]) / (2 * h) - found, axis=-1)
        # But where two pieces meet, whose highest derivatives differ.
        assert np.quantile(off, 0.98) < within * np.abs(found).max()


def test_entry_and_exit_begin_and_end_clear_of_the_ground_at_rest():
    job = lap(clearance=7e-3)
    at = job.entry.setpoints
    assert CIRCUIT.overbreak(at[0]) == pytest.approx(-REFERENCE_MACHINE.depth - 7e-3, abs=1e-9)
    np.testing.assert_array_equal(at[-1], job.setpoints[0])
    np.testing.assert_array_equal(job.leave.setpoints, at[::-1])
    assert strained(replace(job, setpoints=at, ticks=job.entry.ticks)) <= 0.5 * 1.01
    assert job.times["entry"] == job.times["exit"] == pytest.approx(1.5, abs=0.1)


def test_step_between_laps_takes_its_time_within_the_limits():
    one, job = lap(), lap(laps=3, advance=0.04)
    away = job.stepped(np.arange(3 * job.ticks.sum() + 1))
    assert away[0] == 0 and away[-1] == pytest.approx(0.08)
    speed = np.diff(away) / job.tick
    assert 0.09 < speed.max() <= 0.1 + 1e-12
    assert np.abs(np.diff(speed)).max() / job.tick <= 0.5 + 1e-9
    # 0.4 s at full feed, and 0.2 s more for both ramps.
    assert job.lap_time - one.lap_time == pytest.approx(0.6, abs=0.011) == job.times["step"]
    assert np.all(speed[: one.ticks.sum() - 1] == 0)


def test_pose_rolls_then_pitches_then_yaws_about_the_centre_and_shifts():
    pose, centre = Pose(y=0.01, z=-0.02, roll=0.1, pitch=-0.2, yaw=0.3), np.array([0.1, 0.2, 0.3])
    points = np.random.default_rng(1).normal(size=(20, 3))
    found = Rotation.from_euler("xyz", [0.1, -0.2, 0.3]).apply(points - centre)
    np.testing.assert_allclose(pose.moved(points, centre), found + centre + [0, 0.01, -0.02])


# Moves


@pytest.mark.parametrize(
    ("more", "share", "step", "ticks"),
    [(0.0, 0, 4.0, [4, 4]), (1e-12, 0, 4.0, [4, 4]), (1e-7, 0, 4.0, [3, 3, 2]),
     (0.0, 0.5, 99.0, [2] * 4), (0.0, 0.5 * (1 + 1e-7), 99.0, [2] * 4),
     (0.0, 0.5001, 99.0, [1] * 8), (0.0, 1, 99.0, [1] * 8)],
)  # fmt: skip
def test_a_move_keeps_the_step_and_of_n_ticks_an_nth_of_the_strain(more, share, step, ticks):
    found = move_lengths(np.arange(9) * (1 + more), np.full(9, share), step=step)
    assert found.tolist() == ticks


def test_where_the_strain_is_high_moves_are_short():
    strain = np.where(np.arange(25) == 12, 1.0, 0.1)
    found = move_lengths(np.arange(25.0), strain, step=100.0)
    ends = np.cumsum(found)
    assert found.sum() == 24 and found.max() == 10
    assert found[(ends >= 12) & (ends - found <= 12)].tolist() == [1, 1]


@pytest.mark.parametrize(("ticks", "parts"), [(1, 4096), (2**18, 4096), (2**18 + 1, 2048)])
def test_a_count_has_as_many_parts_as_32_bits_hold(ticks, parts):
    assert Moves(np.zeros((2, 2)), np.array([ticks]), 5e-3, BITS16).fineness == parts


# Feed


def test_profile_is_the_greatest_that_keeps_bound_and_acceleration():
    """Nowhere may it be raised: it is at its bound, or is climbed or braked at the limit."""
    rng = np.random.default_rng(4)
    lengths, ground = rng.uniform(1e-3, 5e-3, 60), rng.uniform(1e-4, 2e-3, 60)
    slope, bend = rng.uniform(-1.5, 1.5, (61, 2)), rng.uniform(-80, 80, (61, 2))
    limits = Limits(feed=0.3, acceleration=0.4, volume=3e-4)
    turns = np.stack([slope, bend, np.full((61, 2), 0.8)])
    found = limits.profile(lengths, np.zeros((61, 2)), ground, turns=turns) ** 2
    bound = np.minimum(0.3, 3e-4 / ground) ** 2
    bound = np.minimum(np.append(bound, 0.0), np.append(0.0, bound))
    assert np.all(found <= bound)
    a = np.diff(found) / (2 * lengths)
    joints = slope[:-1] * a[:, None] + bend[:-1] * found[:-1, None]
    strain = np.hypot(*(0.8 * joints).T) / 0.4
    assert strain.max() <= 1 + 1e-9
    full = (strain > 1 - 1e-6) | (found[1:] > bound[1:] * (1 - 1e-9))
    assert np.all(full[1:] | full[:-1])


@pytest.mark.parametrize("length", [0.0625, 0.1249, 0.1251, 0.2])
def test_profile_keeps_the_acceleration_up_to_the_longest_move_that_a_bend_allows(length):
    slope, bend = np.zeros((2, 4, 2))
    slope[:, 0], bend[2] = 1.0, (4.0, 3.0)  # before the last move, with g11 / g12 = 1 / 4 m
    way = [length] * 3, np.zeros((4, 2)), [1e-4] * 3
    turns = np.stack([slope, bend, np.ones((4, 2))])
    if length > 0.125:
        with pytest.raises(ValueError, match=r"^lengths: a move must be shorter than 0\.125 m"):
            Limits(feed=1.0, acceleration=1.0).profile(*way, turns=turns)
        return
    x = Limits(feed=1.0, acceleration=1.0).profile(*way, turns=turns) ** 2
    joints = slope[:-1] * (np.diff(x) / (2 * length))[:, None] + bend[:-1] * x[:-1, None]
    assert np.hypot(*joints.T).max() == pytest.approx(1.0, rel=1e-12)


def test_bounds_keep_valves_flow_and_volume():
    axes, loose = reference_axes(REFERENCE_MACHINE), lap()
    lengths = np.linalg.norm(np.diff(loose.centres(loose.setpoints[:-1]), axis=0), axis=1)
    moves, ground = loose.setpoints[:-1], np.full(len(lengths), 2e-3)
    middle = (moves[1:] + moves[:-1]) / 2
    rates = np.diff(moves, axis=0) / lengths[:, None]
    limits = Limits(feed=9.0, acceleration=1.0, valve=0.5, axes=axes)
    feed = limits.bounds(lengths, moves, ground)
    opened = [np.vectorize(axis.command)(feed * rate, at)
              for axis, rate, at in zip(axes, rates.T, middle.T, strict=True)]  # fmt: skip
    np.testing.assert_allclose(np.abs(opened).max(axis=0), 0.5, rtol=1e-9)
    limits = Limits(feed=9.0, acceleration=1.0, flow=1e-4, axes=axes)
    feed = limits.bounds(lengths, moves, ground)
    drawn = sum(np.where(r > 0, axis.sides(q)[0][0], axis.sides(q)[1][0]) * np.abs(r * feed)
                for axis, r, q in zip(axes, rates.T, middle.T, strict=True))  # fmt: skip
    np.testing.assert_allclose(drawn, 1e-4, rtol=1e-12)
    limits = Limits(feed=9.0, acceleration=1.0, volume=1e-4)
    np.testing.assert_allclose(limits.bounds(lengths, moves, ground), 0.05, rtol=1e-12)
    # The valves bear the greatest force of a ripple, which is that of ground so much harder.
    pushed = np.full((len(moves), 2), 0.3)
    peak, steady = (
        replace(loose.limits, feed=9.0, valve=0.8, axes=axes, ground=hard)
        for hard in (Ground(20e6, 2.0, ripple=0.3), Ground(26e6, 2.0))
    )
    feed = peak.bounds(lengths, moves, ground, pushed=pushed)
    np.testing.assert_allclose(feed, steady.bounds(lengths, moves, ground, pushed=pushed))


# What is refused


REFUSED = {
    "axes: must be given for a limit of flow": lambda: replace(QUICK, flow=1e-4),
    "ground: must be given for a limit of power": lambda: replace(QUICK, power=1e3),
    "step: must be at least the 0.0005 m of a .*; got 1e-09 m": lambda: lap(step=1e-9),
    "step: must be at least the 2.92. m": lambda: lap(
        replace(QUICK, feed=0.5), tolerance=0.02, tick=60.0
    ),
    r"laps: must take at most 5000000 ticks together; got 10000 x \d+ ticks": lambda: lap(
        rest=9e3, laps=10_000
    ),
    "wall: is cut through": lambda: carve(lap(), lap().setvalues, thickness=0.001),
    "tasks: .* period 5000 us; got 4000": lambda: starved(lap(), [Task("line", 4000, 400)], 5),
    "loop: must have the plan's tick": lambda: simulate(lap(), LAG, replace(LOOP, tick=0.01)),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_cannot_be_is_refused_in_a_sentence(message):
    with pytest.raises(ValueError, match=f"^{message}"):
        REFUSED[message]()


# The wall of an ideal chain


@pytest.fixture(scope="module")
def two_laps():
    job = lap(Limits(feed=0.2, acceleration=0.5), laps=3, advance=0.05)
    return carve(job, CIRCUIT.position(job.places))


@pytest.mark.parametrize(
    ("integral", "said"),
    [(0.0, "must be from 0 to 400 1/s"), (20.0, "must be from 0.1 to 400 1/s"),
     (2e5, "is never small enough")],
)  # fmt: skip
def test_unstable_loop_is_refused_with_the_gains_that_would_do(integral, said):
    job = lap()
    loop = Loop(500.0, job.tick, integral=integral)
    with pytest.raises(
        ValueError, match=rf"^loop: must be stable; .* theta's gain {said}; got 500 1/s\.$"
    ):
        simulate(job, Integrator(0.5), loop, shape=COARSE)


def test_ideal_chain_leaves_the_wanted_wall_at_the_bottom(two_laps):
    assert np.abs(two_laps.around).max() < 5e-6
    assert np.abs(two_laps.deviation).max() < 1e-12
    outside = two_laps.overbreak[two_laps.wall.lines.x < two_laps.wall.lines.x[2]]
    np.testing.assert_allclose(outside, -REFERENCE_MACHINE.depth, atol=1e-12)


def test_ideal_chain_leaves_scallops_of_the_formula(two_laps):
    job, lines = two_laps.plan, two_laps.wall.lines
    under = np.where(two_laps.reamed, -two_laps.overbreak, 0).max(axis=0)
    s = np.linspace(0, CIRCUIT.profile.perimeter, 4000)
    touch = CIRCUIT.profile.point(s) + REFERENCE_MACHINE.cutter_radius * CIRCUIT.profile.normal(s)
    pitch = np.interp(np.arctan2(lines.sin, lines.cos), np.arctan2(touch[:, 1], touch[:, 0]),
                      pass_distance(CIRCUIT, s, job.advance), period=2 * np.pi)  # fmt: skip
    height = scallop_height(REFERENCE_MACHINE.cutter_radius, pitch)
    missed = height - under
    # A cusp is sharp, and between two rays along x its tip is missed by its slope's worth.
    spacing = np.diff(two_laps.ends)[0] / 400
    tip = spacing / 2 * job.advance / 2 / REFERENCE_MACHINE.cutter_radius
    start = np.abs(np.angle(lines.cos + 1j * lines.sin)) < 0.2  # the machine's step takes cusps
    assert np.all(missed[~start] < tip + 2e-5) and np.all(missed[~start] > -2e-5)
    assert under.max() <= scallop_height(REFERENCE_MACHINE.cutter_radius, job.advance)


def test_ideal_chain_removes_the_volume_of_the_closed_form(two_laps):
    cut = two_laps
    assert len(cut.lap_volumes) == cut.plan.laps
    for steady in cut.lap_volumes[1:]:
        assert steady == pytest.approx(lap_volume(CIRCUIT, 0.05), rel=5e-4)
    assert cut.lap_volumes.sum() == pytest.approx(cut.removed.sum())
    whole = intact_wall(CIRCUIT, *cut.ends, (4, 720)).volume
    assert cut.removed.sum() == pytest.approx(whole - cut.wall.volume, rel=1e-9)


def test_arm_may_touch_the_wall_and_no_more():
    s = np.linspace(0, CIRCUIT.profile.perimeter, 721)
    room = rod_clearance(EGG, *CIRCUIT.arm(CIRCUIT.position(s)), 0.0).min()
    assert lap(arm_radius=room).laps == 1
    with pytest.raises(ValueError, match=r"^arm_radius: an arm of \S+ m is 0\.001 m in the wall"):
        lap(arm_radius=room + 1e-3)


# Simulation


def test_simulate_notes_the_rate_of_removal():
    cut = simulate(lap(), LAG, LOOP, shape=COARSE)
    assert cut.noted[-1] == len(cut.centres) - 1
    assert np.sum(cut.rate * np.diff(cut.noted) * 0.005) == pytest.approx(cut.removed.sum())
    assert cut.rate[-1] == pytest.approx(0, abs=1e-8)  # at rest


def test_simulate_in_another_pose_shifts_the_wall():
    cut = simulate(lap(), LAG, LOOP, pose=Pose(y=5e-3), shape=(200, 360))
    straight = simulate(lap(), LAG, LOOP, shape=(200, 360))
    lines = cut.wall.lines
    sides = cut.around - straight.around
    for ray, shift in ((lines.cos.argmax(), 5e-3), (lines.cos.argmin(), -5e-3)):
        assert sides[ray] == pytest.approx(shift, rel=0.02)
    assert abs(sides[lines.sin.argmax()]) < 0.2e-3
    assert cut.deviation[np.argmax(cut.centres[:, 1])] == pytest.approx(5e-3, abs=1e-3)


def test_starved_plan_costs_time_and_no_count():
    job, tasks = lap(), [Task("line", 5000, 400), Task("servo", 5000, 600)]
    late = starved(job, tasks, 60_000)
    assert late.lap_time > job.lap_time + 1
    at = np.append(0, np.cumsum(late.ticks))
    assert np.abs(late.setvalues[at] - late.setpoints).max() <= BITS16 / 2 * 1.001
    moves = [one.parts[1:][np.diff(one.parts, axis=0).any(axis=1)] for one in (late, job)]
    np.testing.assert_array_equal(*moves)
    np.testing.assert_array_equal(starved(job, tasks, 100).ticks, job.ticks)


# The promises of the planner, on a job that is kept for it


def test_reference_job_keeps_its_plan():
    job = job_with(controller={"plant": "T3"})
    lap = job.planned
    assert max(lap.shares.values()) <= 1
    assert strained(lap) <= 0.5 * 1.005  # setpoints in parts of a count
    assert lap.times["corners"] <= 0.03 * lap.times["straight"]
    track = follow(*job.axes, lap.setvalues, slopes=lap.slopes)
    torus = lap.circuit.machine.torus
    set_speed = np.linalg.norm(torus.velocity(lap.setvalues[:-1], lap.slopes), axis=-1)
    rates = np.stack([states[:, 1] for states in track.states], axis=-1)
    moved = torus.velocity(track.position, rates)
    steady = slice(400, -600)  # at a constant feed
    assert np.std(set_speed[steady]) < 0.7e-3  # 4.32 mm/s with setpoints between ticks
    change = np.diff(moved[steady], axis=0) / lap.tick
    assert np.sqrt(np.mean(np.sum(change**2, axis=-1))) < 0.1  # 0.55 m/s^2
    off = lap.circuit.overbreak(track.position)
    assert off.max() < 0.501e-3 + 0.02e-3 and -off.min() < 1.139e-3 + 0.02e-3


def test_moves_from_rest_to_rest_keep_speed_and_acceleration():
    rng = np.random.default_rng(7)
    tick = 1e-3
    for _ in range(500):
        distance, *limits = 10.0 ** rng.uniform([-3, -2, -1], [0, 0, 1])
        run = distance * move_shares(move_ticks(distance, *limits, tick))
        assert run[0] == 0 and run[-1] == distance and np.all(np.diff(run) >= 0)
        still = np.pad(run, 3, mode="edge")
        for order, limit in enumerate(limits, start=1):
            assert np.abs(np.diff(still, n=order)).max() / tick**order <= limit * (1 + 1e-6)
