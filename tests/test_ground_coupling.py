"""Force and motion in the ground agree in each tick, however short it is."""

from dataclasses import replace

import numpy as np
import pytest

from tunneller_lib.motion import Compressible, Loop, both_joints, follow
from tunneller_lib.motion.both_joints import Push
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, face, plan
from tunneller_lib.ream.cutting import whole_run
from tunneller_lib.ream.face import Face
from tunneller_lib.ream.front import side_area
from tunneller_lib.ream.wall import intact_wall
from tunneller_lib.removal import Ground
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

SIZES = usual_sizes(REFERENCE_MACHINE)
AXES = axes_of(REFERENCE_MACHINE, SIZES)
ARM = arm_of(REFERENCE_MACHINE, SIZES)
OILY = [Compressible(axis) for axis in AXES]
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TICK = 5e-3
LOOP = Loop(10.0, TICK, delay=1, feedforward=1.0)
MORTAR, CONCRETE, ROCK = (Ground(energy, 2.0) for energy in (5e6, 20e6, 80e6))


def planned(ground, **options):
    """Return a plan in a ground for a head of 3 kW."""
    limits = Limits(feed=0.1, acceleration=0.5, power=3000, valve=0.8, flow=SIZES.pump, axes=AXES,
                    ground=ground)  # fmt: skip
    return plan(CIRCUIT, limits, **({"tolerance": 1e-3} | options))


def begun(made, ground, way, shape=(60, 240), last=None, loop=LOOP):
    """Return the beginning of a run of a plan, from the entry to some way along, in m.

    Of the entry all ticks are run, or the last ones, in a hole that reaches as far.
    """
    setvalues, slopes = whole_run(made)
    entry = int(made.entry.ticks.sum())
    first = entry if last is None else min(last, entry)
    part = slice(entry - first, entry + int(np.searchsorted(made.reached, way)))
    values = setvalues[part.start : part.stop + 1]
    front = Face(made, ground, values, first, shape, 0.1)
    front.wall.cut_path(made.centres(values[:1]), REFERENCE_MACHINE.cutter_radius)
    track = follow(OILY, loop, values, slopes=slopes[part], arm=ARM, push=front)
    return first, track, front


@pytest.mark.parametrize(
    ("ground", "normal", "way"),
    [(MORTAR, 2.0, 0.06), (CONCRETE, 0.0, 0.04), (ROCK, 1.0, 0.01)],
    ids=["5", "20", "80"],
)
def test_force_that_is_found_more_often_and_closer_is_the_same(ground, normal, way, monkeypatch):
    """With half the tick, steps half as long, and a tenth of the miss."""
    ground = replace(ground, normal=normal, ripple=0.3, ripple_frequency=12.0)
    found = []
    for tick, close, step in ((TICK, face.CLOSE, both_joints.DAMPED), (TICK / 2, 1e-4, 0.5)):
        monkeypatch.setattr(face, "CLOSE", close)
        monkeypatch.setattr(both_joints, "DAMPED", step)
        made = planned(ground, tick=tick)
        first, track, front = begun(made, ground, way, last=round(0.6 / tick), loop=replace(
            LOOP, tick=tick, delay=round(TICK / tick)))  # fmt: skip
        off = CIRCUIT.overbreak(track.position[first:])
        found.append([off.min(), front.force[first:].mean(), front.removed.sum()])
    finest = np.array(found[-1])
    assert finest[0] < -1e-4  # m: what the ground holds back can be seen
    assert np.abs(np.array(found) / finest - 1).max() < 0.02


def test_force_and_removed_volume_agree_in_every_tick():
    """Where it is cut evenly, where it bounces, and where the machine steps sideways."""
    ground = replace(CONCRETE, normal=1.0, ripple=0.9, ripple_frequency=12.0)
    made = planned(ground, laps=2, advance=0.04)
    values, slopes = whole_run(made)
    first = int(made.entry.ticks.sum())
    step = first + int(made.ticks.sum()) - len(made.back)
    for begin in (first, step):
        front = Face(made, ground, values[begin : begin + 301], first - begin, (60, 240), 0.1)
        front.wall.cut_path(made.centres(values[begin : begin + 1]), 0.2)
        track = follow(OILY, LOOP, front_values(values, begin), slopes=slopes[begin : begin + 300],
                       arm=ARM, push=front)  # fmt: skip
        centres = CIRCUIT.in_tunnel(CIRCUIT.machine.torus.point(*track.position.T))
        centres[:, 0] -= front.stepped
        way = np.linalg.norm(np.diff(centres, axis=0), axis=-1)
        missed = np.abs(front.areas[1:] * way - front.removed)
        least = face.CLOSE * np.maximum(front.removed, front._least)
        assert np.mean(missed <= least * (1 + 1e-6)) > 0.99  # the others are jumps of a ray
        assert missed.max() < 0.02 * front.removed.max()
        assert np.count_nonzero(front.removed) > 200


def front_values(values, begin):
    """Return the set-values of 300 ticks."""
    return values[begin : begin + 301]


def test_ground_that_takes_no_work_changes_nothing():
    made = planned(MORTAR)
    _, track, _ = begun(made, Ground(1.0, 2.0), 0.02)
    slopes = whole_run(made)[1][: len(track.command)]
    free = follow(OILY, LOOP, track.setvalue, slopes=slopes, arm=ARM)
    assert np.abs(track.position - free.position).max() < 1e-8


# The step


def test_ground_drags_a_stepping_cutter_back_along_the_tunnel():
    made = planned(CONCRETE, laps=2, advance=0.04)
    values, _ = whole_run(made)
    first = int(made.entry.ticks.sum())
    tick = first + int(made.ticks.sum()) - len(made.back) // 2  # amid the step towards -x
    still = replace(CONCRETE, normal=0.0)
    push = Face(made, still, values, first, (60, 240), 0.1).push[tick]
    axes = AXES
    state = *((angle, 0.0, 5e6, 6e6, 0.0) for angle in values[tick]), (0.0,) * 5
    machine = both_joints.machine_of(axes, ARM)
    free, pushed = (
        both_joints.machine_slopes(machine, state, (0.0, 0.0), (0.0, 0.0, damper, *push[3:]))
        for damper in (0.0, 1e-2 * push[2])  # of an area in m^2
    )
    h = 1e-6
    place = lambda at: CIRCUIT.in_tunnel(CIRCUIT.machine.torus.point(*at))[0]  # noqa: E731
    moves = [(place(values[tick] + h * one) - place(values[tick])) / h for one in np.eye(2)]
    speed = np.diff(made.stepped([tick - first, tick - first + 1]))[0] / TICK
    lost = np.subtract([one[1] for one in free[:2]], [one[1] for one in pushed[:2]])
    torques = ARM.inertias(values[tick, 1]) * lost
    # The force is against the step, so towards +x.
    np.testing.assert_allclose(torques, -1e-2 * push[2] * speed * np.array(moves), rtol=1e-3)


def test_side_of_the_ball_is_as_large_as_points_in_the_ground_count():
    grid = np.linspace(-0.21, 0.21, 901)
    y, z = np.meshgrid(grid, grid)
    for s in (0.0, 0.9, 1.9):
        centre = CIRCUIT.profile.point(s)
        beyond = -CIRCUIT.profile.depth(y + centre[0], z + centre[1])
        inside = (y**2 + z**2 < 0.2**2) & (beyond > REFERENCE_MACHINE.offset)
        counted = np.count_nonzero(inside) * (grid[1] - grid[0]) ** 2
        assert side_area(CIRCUIT, s) == pytest.approx(counted, rel=2e-3)


def test_step_between_laps_keeps_the_power_and_the_volume():
    made = planned(CONCRETE, laps=2, advance=0.04)
    speed = np.diff(made.back).max() / TICK
    assert CONCRETE.power(side_area(CIRCUIT, 0.0)) * speed == pytest.approx(3000, rel=0.01)
    limits = replace(made.limits, volume=1e-5)
    slow = plan(CIRCUIT, limits, tolerance=1e-3, laps=2, advance=0.04)
    assert side_area(CIRCUIT, 0.0) * np.diff(slow.back).max() / TICK <= 1e-5 * (1 + 1e-9)
    # The wall says the same: what a step takes in a second, in a groove that is as deep as meant.
    wall = intact_wall(CIRCUIT, 0.3, 1.1, (400, 1500))
    centres = made.centres(made.setvalues)
    lap = len(centres) - len(made.back)
    wall.cut_path(centres[: lap + 1 : 20], 0.2)
    rates = []
    for a in range(lap, len(centres) - 1, max(len(made.back) // 20, 1)):
        b = min(a + max(len(made.back) // 20, 1), len(centres) - 1)
        rates.append(wall.cut_path(centres[a : b + 1], 0.2) / (b - a) / TICK)
    assert 0.7 * 3000 < CONCRETE.power(max(rates)) < 1.02 * 3000


def test_cutter_that_is_pushed_back_out_of_its_hole_finds_its_force():
    """From rest in whole ground the first ticks go the other way than the front faces."""
    made = planned(Ground(250e6, 2.0, normal=1.2))
    values = CIRCUIT.position(made.places[:60])
    front = Face(made, made.limits.ground, values, 0, (60, 240), 0.1)
    front.wall.cut_path(made.centres(values[:1]), REFERENCE_MACHINE.cutter_radius)
    slopes = np.diff(values, axis=0) / TICK
    follow(OILY, LOOP, values, slopes=slopes, arm=ARM, push=front)
    taken = front.push[:, 2] @ (front.removed / TICK)
    assert front.force.sum() == pytest.approx(taken, rel=1e-3)


# Steps


def test_steps_are_stable_in_hard_ground_where_the_bent_arm_is_lightest():
    machine = both_joints.machine_of(AXES, ARM)
    at = np.array([0.0, 0.999 * machine.phi.high])
    rests = [one.rest(*pair) for one, *pair in zip(OILY, at, ARM.weight(at), strict=True)]
    theta, phi = (tuple(map(float, rest)) for rest in rests)
    state = (theta[0], 1e-3, *theta[2:]), phi, 5 * (0.0,)  # at a rate of a milliradian a second
    for damper in (1e5, 1e6, 1e7):
        push = Push(damper=damper, lever=(1.0, 0.0)).rows
        (parts,) = both_joints.parts_in(machine, 3, push, TICK)
        moved = both_joints.machine_tick(machine, state, (0.0, 0.0), push[0], parts, TICK)
        assert abs(moved[0][1]) < 1e-4
