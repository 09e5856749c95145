"""The whole cut: plan, feed, wall; ideal chains against closed forms; plans that are refused."""

import re
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.job import read_job
from tunneller_lib.motion import Compressible, Integrator, Lag, Loop, follow, reference_axes
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import cutting_circuit, geodesic_inverse
from tunneller_lib.ream import Limits, Pose, carve, cutting, plan, simulate, starved
from tunneller_lib.ream.cutting import expected_seconds
from tunneller_lib.ream.timing import move_shares, move_ticks
from tunneller_lib.ream.wall import (
    intact_wall,
    lap_volume,
    overbreak,
    pass_distance,
    scallop_height,
    standing,
)
from tunneller_lib.removal import DexelGrid
from tunneller_lib.removal.arm_clearance import rod_clearance
from tunneller_lib.removal.volume import removed_volume
from tunneller_lib.surfaces import REFERENCE_MACHINE, Arc, Egg, closed_profile

READS = ["tests/references/reference_job.toml"]

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
EGG = Egg(0.5)
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, EGG)
BITS16 = 2 * np.pi / 2**16
QUICK = Limits(feed=0.1, acceleration=0.5)
LOOP = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=BITS16)
COARSE = (150, 240)


def lap(limits=QUICK, **options):
    return plan(CIRCUIT, limits, **({"tolerance": 1e-3, "rest": 0.5} | options))


def ideal(job):
    return job.circuit.position(job.places)


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


def test_plan_on_corrected_chords():
    job = lap(path="corrected chord")
    assert job.path == "corrected chord" and lap().path == "projected chord"
    moves = np.diff(CIRCUIT.machine.torus.point(*job.setpoints[:-1].T), axis=0)
    lengths = np.linalg.norm(moves, axis=-1)
    assert lengths.max() <= 5e-3
    torus = CIRCUIT.machine.torus
    # The first half of the way to the next knot has no corner.
    ends = CIRCUIT.position(job.knots[:2])
    way = geodesic_inverse(torus, *ends).points(21).position[:11]
    found = job.route.at(np.linspace(0, job.route.ends[1] / 2, 11))
    np.testing.assert_allclose(found, way, atol=1e-6)
    with pytest.raises(ValueError, match=r'^path: must be "projected chord" or "corrected chord"'):
        lap(path="geodesic")


def test_plan_keeps_its_tolerance_and_its_counts():
    job = lap()
    over = CIRCUIT.overbreak(job.setpoints)
    assert -1e-3 <= over.min() < -0.9e-3 and over.max() <= 1e-3
    moved = job.tick * np.cumsum(np.concatenate([np.zeros((1, 2)), job.slopes]), axis=0)
    line = job.setpoints[0] + moved
    assert np.abs(job.setvalues - line).max() <= BITS16 / 2 * (1 + 2 / job.fineness)
    assert job.lap_time == pytest.approx(len(job.setvalues) * 0.005 - 0.005)


def test_plan_moves_no_farther_than_a_step_and_never_faster_than_the_feed():
    job = lap(step=4e-3)
    centre = job.centres(job.setpoints)
    moves = np.linalg.norm(np.diff(centre, axis=0), axis=1)
    assert moves.max() <= 4e-3
    steady = (job.feed[1:-1] > 0.09999) & (job.feed[:-2] > 0.09999)
    assert np.mean(job.ticks[:-1][steady] == 8) > 0.7  # 4 mm at 0.1 m/s, but before turns
    for share in job.shares.values():
        assert share <= 1


def strained(job):
    """Return the greatest change of slope in a tick, as an acceleration of the cutter in m/s^2."""
    slopes = np.concatenate([np.zeros((1, 2)), job.slopes, np.zeros((1, 2))])
    change = job.circuit.machine.torus.velocity(job.setvalues, np.diff(slopes, axis=0))
    return np.linalg.norm(change, axis=-1).max() / job.tick


@pytest.mark.parametrize(
    "limits",
    [
        QUICK,
        Limits(feed=0.3, acceleration=0.2),
        Limits(feed=0.2, acceleration=9.0, joint_speed=0.2, joint_acceleration=0.3),
        Limits(feed=0.2, acceleration=0.5, joint_acceleration=0.3),
        Limits(feed=0.3, acceleration=0.5, volume=1e-4),
    ],
)
def test_exported_moves_keep_every_limit(limits):
    job = lap(limits)
    assert max(job.shares.values()) <= 1
    assert strained(job) <= limits.acceleration * 1.01  # setpoints in parts of a count
    used = max(job.shares["acceleration"], job.shares["joint_acceleration"], job.shares["feed"])
    assert used > 0.9


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


def test_plan_without_a_limit_of_ground_is_that_of_one_out_of_reach():
    free, wide = lap(), lap(replace(QUICK, volume=1e6))
    assert np.array_equal(free.feed, wide.feed) and np.array_equal(free.ticks, wide.ticks)
    assert lap(replace(QUICK, volume=1e-4)).lap_time > 1.2 * free.lap_time


def test_plan_spaces_knots_by_its_tolerance():
    numbers = [len(lap(tolerance=t).knots) for t in (4e-3, 1e-3, 2.5e-4)]
    assert numbers == sorted(numbers) and numbers[2] / numbers[1] == pytest.approx(2, rel=0.15)


@pytest.mark.parametrize("laps, advance", [(1, 0.0), (3, 0.04)])
def test_centres_step_back_between_laps(laps, advance):
    job = lap(laps=laps, advance=advance)
    ticks = job.ticks.sum()
    every = np.concatenate([job.setvalues[:1], np.tile(job.setvalues[1:], (laps, 1))])
    x = job.centres(every)[:, 0]
    for k in range(laps):
        moved = x[k * ticks : (k + 1) * ticks - len(job.back) + 2]
        np.testing.assert_allclose(moved, x[: len(moved)] - k * advance, atol=1e-15)


def test_pose_moves_as_a_rigid_body():
    pose, centre = Pose(y=0.01, z=-0.02, roll=0.1, pitch=-0.2, yaw=0.3), np.array([0.1, 0.2, 0.3])
    points = np.random.default_rng(1).normal(size=(20, 3))
    moved = pose.moved(points, centre)
    gaps = points[:, None] - points, moved[:, None] - moved
    np.testing.assert_allclose(*(np.linalg.norm(g, axis=-1) for g in gaps), atol=1e-14)
    np.testing.assert_allclose(
        pose.moved(centre, centre), centre + np.array([0, 0.01, -0.02]), atol=1e-15
    )
    small = Pose(roll=1e-7, pitch=-2e-7, yaw=3e-7).moved(points, centre) - points
    np.testing.assert_allclose(small, np.cross([1e-7, -2e-7, 3e-7], points - centre), atol=1e-12)


# Feed


def test_profile_of_a_constant_bound_is_a_trapezoid():
    lengths = np.full(1000, 1e-3)
    feed = Limits(feed=0.2, acceleration=0.1).profile(lengths, np.zeros((1001, 2)), np.ones(1000))
    s = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(feed, np.minimum(0.2, np.sqrt(0.2 * np.minimum(s, 1 - s))),
                               atol=1e-12)  # fmt: skip


def test_profile_is_the_greatest_that_keeps_bound_and_acceleration():
    rng = np.random.default_rng(2)
    lengths, ground = rng.uniform(1e-3, 5e-3, 400), rng.uniform(1e-4, 1e-2, 400)
    limits = Limits(feed=0.3, acceleration=0.4, volume=1e-4)
    feed = limits.profile(lengths, np.zeros((401, 2)), ground)
    bound = np.minimum(0.3, 1e-4 / ground)
    assert np.all(np.maximum(feed[1:], feed[:-1]) <= bound * (1 + 1e-12))
    climb = np.abs(np.diff(feed**2)) / (2 * lengths)
    assert climb.max() <= 0.4 * (1 + 1e-9)
    # Nowhere may it be raised: each inner value meets its bound or one of the two climbs.
    full = (climb > 0.4 * (1 - 1e-9)) | (np.maximum(feed[1:], feed[:-1]) > bound * (1 - 1e-9))
    assert np.all(full[1:] | full[:-1])


def test_profile_with_any_acceleration_keeps_its_digits():
    lengths, ground = np.full(500, 2e-3), np.linspace(1e-3, 5e-3, 500)
    for acceleration in (1e6, 1e13, 1e30):
        limits = Limits(feed=0.3, acceleration=acceleration, volume=1e-4)
        feed = limits.profile(lengths, np.zeros((501, 2)), ground)
        np.testing.assert_allclose(feed[1:-1], np.minimum(0.3, 1e-4 / ground[1:]), rtol=1e-9)


def test_bounds_keep_valves_flow_and_volume():
    axes = reference_axes(REFERENCE_MACHINE)
    loose = lap()
    lengths = np.linalg.norm(np.diff(loose.centres(loose.setpoints[:-1]), axis=0), axis=1)
    moves, ground = loose.setpoints[:-1], np.full(len(lengths), 2e-3)
    middle = (moves[1:] + moves[:-1]) / 2
    rates = np.diff(moves, axis=0) / lengths[:, None]
    limits = Limits(feed=9.0, acceleration=1.0, valve=0.5, axes=axes)
    feed = limits.bounds(lengths, moves, ground)
    opened = np.array([
        [abs(axis.command(float(v * r), float(q))) for v, r, q in zip(feed, rate, at, strict=True)]
        for axis, rate, at in zip(axes, rates.T, middle.T, strict=True)
    ])  # fmt: skip
    np.testing.assert_allclose(opened.max(axis=0), 0.5, rtol=1e-9)
    limits = Limits(feed=9.0, acceleration=1.0, flow=1e-4, axes=axes)
    feed = limits.bounds(lengths, moves, ground)
    drawn = sum(np.where(r > 0, axis.sides(q)[0][0], axis.sides(q)[1][0]) * np.abs(r * feed)
                for axis, r, q in zip(axes, rates.T, middle.T, strict=True))  # fmt: skip
    np.testing.assert_allclose(drawn, 1e-4, rtol=1e-12)
    limits = Limits(feed=9.0, acceleration=1.0, volume=1e-4)
    np.testing.assert_allclose(limits.bounds(lengths, moves, ground), 0.05, rtol=1e-12)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"feed": 0.0}, "feed: must be one finite number above zero"),
        ({"feed": np.inf}, "feed"),
        ({"acceleration": -1.0}, "acceleration: must be one finite number above zero"),
        ({"volume": np.nan}, "volume: must be one number above zero"),
        ({"flow": 1e-4}, "axes: must be given for a limit of flow"),
        ({"axes": (1, 2)}, r"axes\[0\]: must be of class Hydraulics"),
        (
            {"axes": reference_axes(REFERENCE_MACHINE)[:1], "valve": 0.5},
            "axes: must be two, theta's and phi's; got 1",
        ),
        ({"axes": reference_axes(REFERENCE_MACHINE), "valve": 3.0}, "valve: must be at most 1"),
        ({"feed": "a"}, "feed: must hold real numbers"),
        ({"feed": 1e-200}, "feed: must be from 1e-100 to 1e\\+100 in size"),
    ],
)
def test_limits_refuse(options, message):
    with pytest.raises(ValueError, match=message):
        Limits(**({"feed": 0.1, "acceleration": 0.5} | options))


# The wall of an ideal chain


@pytest.fixture(scope="module")
def two_laps():
    job = lap(Limits(feed=0.2, acceleration=0.5), laps=3, advance=0.05)
    return carve(job, ideal(job))


def test_carve_tells_of_each_lap():
    told, job = [], lap(laps=2, advance=0.05)
    carve(job, ideal(job), shape=COARSE, say=told.append)
    whole = [line.partition(";")[0] for line in told if "% of it" not in line]  # nor shares of one
    assert whole == ["cutting: lap 1 of 2", "cutting: lap 2 of 2"]


def test_carve_tells_how_far_it_is_within_a_lap(monkeypatch):
    monkeypatch.setattr(cutting, "SILENCE", 0.0)
    told, job = [], lap(laps=2, advance=0.05)
    carve(job, ideal(job), shape=COARSE, say=told.append)
    shares = [[int(n) for n in re.findall(r"\d+", line.partition(";")[0])] for line in told]
    within = [share for lap, all_laps, *share in shares if lap == 1 and all_laps == 2]
    assert len(within) > 20 and within[-1] == []
    parts = [share for (share,) in within[:-1]]
    assert parts == sorted(parts) and parts[0] < 10 and parts[-1] > 90
    assert told[0].startswith("cutting: lap 1 of 2, ") and "% of it" in told[0]


def test_expected_seconds_are_those_of_a_run_within_a_factor(monkeypatch):
    # By the clock other programs may stop the few ticks that are timed, but not the run.
    monkeypatch.setattr(time, "perf_counter", time.process_time)
    job = lap(laps=2, advance=0.05)
    plant, loop = Integrator(0.5), Loop(10.0, job.tick)
    axes, wall = expected_seconds(job, plant, loop, shape=COARSE)
    begun = time.perf_counter()
    simulate(job, plant, loop, shape=COARSE)
    assert 0 < min(axes, wall) and 0.1 < (axes + wall) / (time.perf_counter() - begun) < 10


@pytest.mark.parametrize(
    ("integral", "said"),
    [(0.0, "the gain must be below 400 1/s; got 500 1/s."),
     (20.0, "with an integral of 20 1/s^2 the gain must be from 0.1 to 400 1/s; got 500 1/s."),
     (2e5, "with an integral of 200000 1/s^2 no gain would do; got 500 1/s.")],
)  # fmt: skip
def test_unstable_loop_is_refused_with_the_gains_that_would_do(integral, said):
    job = lap()
    loop = Loop(500.0, job.tick, integral=integral)
    with pytest.raises(
        ValueError, match=rf"^loop: must be stable; that of theta .*{re.escape(said)}"
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


def test_ideal_chain_removes_the_volume_of_the_closed_form():
    job = lap(Limits(feed=0.2, acceleration=0.5), laps=3, advance=0.05)
    cut = carve(job, ideal(job))
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


def test_ground_is_a_tenth_of_a_metre_thick_unless_told():
    for options, thickness in (({}, 0.1), ({"thickness": 0.3}, 0.3)):
        wall = intact_wall(CIRCUIT, -0.1, 0.1, (2, 90), **options)
        np.testing.assert_allclose(wall.high - wall.low, thickness, rtol=1e-12)


def round_pass():
    """Return a circuit in a round tunnel on a torus so great that it's a plane across."""
    flat = replace(REFERENCE_MACHINE, r=1e-9, R=60.0, phi_min=-1.0, phi_max=1.0, theta_min=-1.0,
                   theta_max=1.0, height=0.0)  # fmt: skip
    return cutting_circuit(flat, closed_profile([Arc(0.0, 0.0, 0.5, 0.0, 2 * np.pi)]))


def test_lap_volume_of_a_straight_pass_is_the_grooves():
    exact = removed_volume(0.2, 2 * np.pi * 0.32, 0.02, wall=0.5, pitch=0.04)
    assert lap_volume(round_pass(), 0.04) == pytest.approx(exact, rel=2e-4)


def test_plan_feeds_a_round_pass_so_that_the_groove_has_the_volume_allowed():
    job = plan(
        round_pass(), Limits(feed=9.0, acceleration=9.0, volume=2e-4), tolerance=1e-5, step=0.05
    )
    steady = job.feed[1:-2]
    assert np.mean(np.isclose(steady, steady.max(), rtol=1e-3)) > 0.9
    assert steady.max() * removed_volume(0.2, 1.0, 0.02, wall=0.5) == pytest.approx(2e-4, rel=1e-3)


@pytest.mark.parametrize("feed", [0.3, 0.1])
def test_overbreak_of_the_ideal_chain_is_that_of_the_grid_alone(feed):
    job = lap(Limits(feed=feed, acceleration=0.5), rest=0.05, step=2e-2)
    for shape in ((100, 180), (200, 360)):
        assert np.abs(carve(job, ideal(job), shape=shape).around).max() < 0.1e-3


# Simulation


def test_simulate_a_lap_within_the_goal():
    job = plan(CIRCUIT, Limits(feed=0.06, acceleration=0.5), tolerance=1e-3)
    assert job.ticks.sum() > 10_000
    tracemalloc.start()
    before = time.process_time()
    cut = simulate(job, Lag(0.5, 0.02), LOOP)
    spent, peak = time.process_time() - before, tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    print(f"{job.ticks.sum()} ticks on 400 x 720 rays in {spent:.1f} s, {peak / 1e6:.0f} MB")
    assert peak < 500e6
    assert (
        cut.removed.sum() + cut.plunged == pytest.approx(9.72e-3, rel=0.05) and cut.wall.splits >= 0
    )
    # What the cutter's centre does is what the wall shows, but for tips between two rays.
    assert 0.7 * cut.deviation.max() < cut.around.max() < cut.deviation.max() + 5e-6
    assert cut.deviation.min() - 5e-6 < cut.around.min() < 0.9 * cut.deviation.min()


def test_simulate_notes_the_rate_of_removal():
    cut = simulate(lap(), Lag(0.5, 0.02), LOOP, shape=COARSE)
    assert cut.noted[-1] == len(cut.centres) - 1
    assert np.sum(cut.rate * np.diff(cut.noted) * 0.005) == pytest.approx(cut.removed.sum())
    np.testing.assert_allclose(cut.power(5e6), 5e6 * cut.rate)
    assert cut.rate[-1] == pytest.approx(0, abs=1e-8)  # at rest


def test_simulate_in_another_pose_shifts_the_wall():
    cut = simulate(lap(), Lag(0.5, 0.02), LOOP, pose=Pose(y=5e-3), shape=(200, 360))
    straight = simulate(lap(), Lag(0.5, 0.02), LOOP, shape=(200, 360))
    lines = cut.wall.lines
    sides = cut.around - straight.around
    assert sides[np.argmax(lines.cos)] == pytest.approx(5e-3, rel=0.02)
    assert sides[np.argmin(lines.cos)] == pytest.approx(-5e-3, rel=0.02)
    crown = np.argmax(lines.sin)
    assert abs(sides[crown]) < 0.2e-3


def test_starved_plan_costs_time_and_no_count():
    job, tasks = lap(), [Task("line", 5000, 400), Task("servo", 5000, 600)]
    late = starved(job, tasks, 60_000)
    assert late.lap_time > job.lap_time + 1
    at = np.concatenate([[0], np.cumsum(late.ticks)])
    assert np.abs(late.setvalues[at] - late.setpoints).max() <= BITS16 / 2 * 1.001
    moved = np.concatenate([[True], np.any(np.diff(late.parts, axis=0) != 0, axis=1)])
    kept = np.concatenate([[True], np.any(np.diff(job.parts, axis=0) != 0, axis=1)])
    assert np.array_equal(late.parts[moved], job.parts[kept])
    same = starved(job, tasks, 100)
    assert np.array_equal(same.ticks, job.ticks)


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: lap(arm_radius=0.25), r"an arm of 0.25 m is 0\.\d+ m in the wall \d\.\d+ m along"),
        (lambda: lap(tolerance=-1), "tolerance"),
        (lambda: lap(laps=0), "laps"),
        (lambda: lap(advance=-0.1), "advance"),
        (lambda: lap(Limits(feed=3.0, acceleration=50.0)), r"step: must be at least the 0.01\d+"),
        (lambda: plan(EGG, QUICK, tolerance=1e-3), "circuit: must be of class Circuit"),
        (lambda: plan(CIRCUIT, 0.1, tolerance=1e-3), "limits: must be of class Limits"),
        (lambda: simulate(lap(), Integrator(0.5), replace(LOOP, gain=500.0)), "of theta isn't"),
        (lambda: simulate(lap(), Integrator(0.5), LOOP, tasks=[Task("line", 5000, 400)],
                          cost=60_000), "the slow task starves the line at"),
        (lambda: simulate(lap(), Integrator(0.5), LOOP, tasks=[Task("line", 4000, 400)],
                          cost=60), "must have the tick's period 5000 us"),
        (lambda: simulate(lap(), Integrator(0.5), LOOP, thickness=0.001), "is cut through"),
        (lambda: simulate(lap(), Integrator(0.5), replace(LOOP, tick=0.01)), "the plan's tick"),
        (lambda: simulate(lap(), Integrator(0.5), LOOP, cost=9), "cost: needs tasks"),
        (lambda: carve(lap(), np.zeros((9, 2))), "position: must be"),
        (lambda: carve(3, np.zeros((9, 2))), "plan: must be of class Plan"),
        (lambda: starved(lap(), None, 5), "tasks: must be a list of Task"),
        (lambda: starved(lap(), [Task("line", 5000, 400)], 2**31), "cost: must"),
        (lambda: lap(count=1e-300), "count: must be from 1e-09 to 0.1"),
        (lambda: lap(rest=1e30), "rest: must be from 0 to 10000"),
        (lambda: lap(rest=9e3, laps=10_000),
         r"^laps: must take at most 5000000 ticks together; got 10000 x \d+ ticks of 0\.005 s\.$"),
        (lambda: lap(Limits(feed=1e-6, acceleration=0.5)), "laps: must take at most 5000000 ticks"),
        (lambda: lap(step=1e-9), "^step: must be at least the 0.0005 m of a .*; got 1e-09 m."),
        (lambda: lap(step=1e-99), "step: must be at least the 0.0005 m of .*; got 1e-99 m."),
        (lambda: lap(step=1e-310), "step: must be from 1e-100"),
        (lambda: lap(tick=1e-9), r"^laps: must take at most 5000000 ticks together; got 1 x \d+"),
        (lambda: lap(laps=[1, 2]), "laps: must be one whole number"),
        (lambda: lap_volume(CIRCUIT, 0.3), "advance: must leave cusps below"),
        (lambda: lap_volume(3, 0.3), "circuit: must be of class Circuit"),
        (lambda: scallop_height(0.2, -0.1), "pitch: must lie between"),
        (lambda: QUICK.profile(np.ones(3), np.zeros((4, 2)), np.ones(2)), "lengths: must be"),
        (lambda: QUICK.profile(np.zeros(3), np.zeros((4, 2)), np.ones(3)), "lengths: must be from"),
        (lambda: QUICK.profile(np.ones(3), np.zeros((4, 2)), -np.ones(3)), "ground: must not be"),
        (lambda: QUICK.profile(np.ones(1), np.zeros((2, 2)), np.ones(1)), "m >= 2"),
        (lambda: Pose(y="a"), "y: must hold real numbers"),
        (lambda: Pose(y=np.nan), "y: must be one finite number"),
        (lambda: scallop_height(0.2, 0.5), "pitch: must lie between"),
        (lambda: cutting_circuit(replace(REFERENCE_MACHINE, height=0.3), EGG), "floor.*fails by"),
        (lambda: simulate(lap(), Integrator(0.5), LOOP, tasks=[Task("line", 5000, 400)]),
         "cost: needs tasks, and they need it"),
        (lambda: starved(lap(), [], 5), "period 5000 us; got no task"),
        (lambda: lap_volume(CIRCUIT, 9.0), "advance: must leave cusps below"),
        (lambda: plan(round_pass(), QUICK, tolerance=9.0), "tolerance: must be so small that two"),
        (lambda: standing(DexelGrid.cartesian((0, 0, 0), (1, 1, 1), (2, 2))), "must be on rays"),
        (lambda: standing(None), "wall: must be of class DexelGrid"),
        (lambda: overbreak(None, CIRCUIT), "wall: must be of class DexelGrid"),
    ],
)  # fmt: skip
def test_bad_plans_are_refused_before_the_run(call, message):
    with pytest.raises(ValueError, match=message):
        cut = call()
        _ = cut.overbreak  # only a wall that is cut through is found later


# The promises of the planner, on a job that is kept for it


def test_reference_job_keeps_its_plan():
    job = read_job(REFERENCE_JOB)
    lap = job.planned
    assert max(lap.shares.values()) <= 1
    assert strained(lap) <= 0.5 * 1.005  # setpoints in parts of a count
    assert lap.times["corners"] <= 0.03 * lap.times["straight"]
    axes = [Compressible(axis) for axis in reference_axes(job.planned.circuit.machine)]
    track = follow(axes, job.axes[1], lap.setvalues, slopes=lap.slopes)
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


@pytest.mark.parametrize("tick", [60.0, 1e12])
def test_a_tick_longer_than_the_lap_is_refused(tick):
    with pytest.raises(ValueError, match=r"^step: must be at least the 2\.92\d m of a tick at"):
        plan(CIRCUIT, Limits(feed=0.5, acceleration=0.5), tolerance=0.02, tick=tick)


@pytest.mark.parametrize(("more", "ticks"), [(0.0, 100), (1e-13, 100), (1e-10, 101)])
def test_a_move_lasts_a_tick_more_where_its_speed_would_be_above_the_limit(more, ticks):
    speed = 1 / (100 * (1 + more))  # m/s, over 1 m with ticks of a second
    assert move_ticks(1.0, speed, 1e3, 1.0)[0] == ticks


def test_lap_under_joint_limits_lasts_as_long_as_toppras():
    """The time that toppra 0.6 gives on the same route: make bench compares more of them."""
    limits = Limits(feed=1e3, acceleration=1e6, joint_speed=0.3, joint_acceleration=2.0)
    job = lap(limits, blend=5e-4, tick=1e-3, step=0.05, rest=0.0)
    assert max(job.shares.values()) <= 1
    assert job.lap_time - job.tick == pytest.approx(11.056, rel=0.01)
