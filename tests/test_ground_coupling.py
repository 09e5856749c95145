"""Force and motion in the ground agree, however many ticks are tried together."""

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
from tunneller_lib.removal import DexelGrid, Ground
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


def begun(made, ground, way, shape=(60, 240), last=None):
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
    track = follow(OILY, LOOP, values, slopes=slopes[part], arm=ARM, push=front.push)
    front.finish(track.position)
    return first, track, front


@pytest.mark.parametrize(
    ("ground", "normal", "way"),
    [(MORTAR, 2.0, 0.06), (CONCRETE, 0.0, 0.04), (ROCK, 1.0, 0.01)],
    ids=["5", "20", "80"],
)
def test_force_that_is_renewed_more_often_is_the_same_within_two_percent(
    ground, normal, way, monkeypatch
):
    ground = replace(ground, normal=normal, ripple=0.3, ripple_frequency=12.0)
    made = planned(ground)
    found = []
    for every, step in ((face.EVERY, both_joints.DAMPED), (1, both_joints.DAMPED / 2)):
        monkeypatch.setattr(face, "EVERY", every)
        monkeypatch.setattr(both_joints, "DAMPED", step)
        first, track, front = begun(made, ground, way, last=120)
        off = CIRCUIT.overbreak(track.position[first:])
        found.append([off.min(), front.force(track)[first:].mean(), front.removed.sum()])
    finest = np.array(found[-1])
    assert finest[0] < -1e-4  # m: what the ground holds back can be seen
    assert np.abs(np.array(found) / finest - 1).max() < 0.02


def test_ground_that_takes_no_work_changes_nothing():
    made = planned(MORTAR)
    _, track, _ = begun(made, Ground(1.0, 2.0), 0.02)
    slopes = whole_run(made)[1][: len(track.command)]
    free = follow(OILY, LOOP, track.setvalue, slopes=slopes, arm=ARM)
    assert np.abs(track.position - free.position).max() < 1e-8


# The front


def test_front_is_how_much_more_a_further_short_move_takes():
    rng = np.random.default_rng(3)
    wall = DexelGrid.radial(-0.3, 0.3, 0.5, 0.7, (300, 2000))
    turn = np.linspace(0.0, 0.5, 400)
    way = np.stack([0 * turn, 0.32 * np.cos(turn), 0.32 * np.sin(turn)], axis=-1)
    wall.cut_path(way[:-1], 0.2)
    volume, area, cut = wall.front(way[-2:], 0.2)
    assert volume == pytest.approx(wall.copy().cut_path(way[-2:], 0.2), rel=1e-12)
    assert area @ (way[-1] - way[-2]) == pytest.approx(volume, rel=0.02)
    assert cut() == pytest.approx(volume, rel=1e-12)
    assert cut() == 0  # nothing is left of it
    ahead = (way[-1] - way[-2]) / np.linalg.norm(way[-1] - way[-2])
    outward = way[-1] / np.linalg.norm(way[-1])
    for share in rng.uniform(0.0, 0.2, 4):  # out of the wall or along it the places stay the same
        turned = ahead + share * outward
        step = 1e-5 * turned / np.linalg.norm(turned)
        further = wall.front(np.stack([way[-1], way[-1] + step]), 0.2)[0]
        assert further == pytest.approx(area @ step, rel=0.05)


# The step


def test_ground_drags_a_stepping_cutter_back_along_the_tunnel():
    made = planned(CONCRETE, laps=2, advance=0.04)
    values, _ = whole_run(made)
    first = int(made.entry.ticks.sum())
    tick = first + int(made.ticks.sum()) - len(made.back) // 2  # amid the step towards -x
    front = Face(made, replace(CONCRETE, normal=0.0), values, first, (60, 240), 0.1)
    front._go_on(values[tick : tick + 1])
    front._area = np.array([-1e-2, 0.0, 0.0])  # m^2
    (torque, *_), h = front.push(tick, None).torque, 1e-6
    place = lambda at: CIRCUIT.in_tunnel(CIRCUIT.machine.torus.point(*at))[0]  # noqa: E731
    moves = [(place(values[tick] + h * one) - place(values[tick])) / h for one in np.eye(2)]
    force = -front.stiffness[tick] * 1e-2 * np.diff(made.stepped([tick - first, tick - first + 1]))
    np.testing.assert_allclose(torque, force / TICK * moves, rtol=1e-3)


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
    track = follow(OILY, LOOP, values, slopes=slopes, arm=ARM, push=front.push)
    front.finish(track.position)
    taken = front.stiffness @ (front.removed / TICK)
    assert front.force(track).sum() == pytest.approx(taken, rel=0.05)


# What doesn't agree is refused


def test_force_that_never_agrees_with_the_motion_is_refused(monkeypatch):
    monkeypatch.setattr(face, "CLOSE", 1e-12)
    monkeypatch.setattr(face, "MOST_TRIES", 2)
    # It is refused after a try with one tick alone: two remove more than 4 mm^3.
    said = r"^ground: force and motion must agree within 1e-10 %; got .* in a tick that removes 1\."
    with pytest.raises(ValueError, match=said):
        begun(planned(CONCRETE), CONCRETE, 0.02)


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
