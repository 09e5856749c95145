"""What a machine has, and what its loops need: gain, resonance, and picks that are in step."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.job import read_job
from tunneller_lib.kernels.compiled import call
from tunneller_lib.motion import Compressible, Lag, Loop, Push, follow, reference_axes
from tunneller_lib.motion.both_joints import Resistance, parts_in
from tunneller_lib.motion.hydraulics import spool_at
from tunneller_lib.motion.ticks import run_joints
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream.front import engaged_areas
from tunneller_lib.ream.margins import chatter_limit, gain_margins
from tunneller_lib.ream.moves import levers
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

READS = ["notebooks/reference.toml"]

JOB = Path(__file__).resolve().parents[1] / "notebooks" / "reference.toml"
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
AXES = reference_axes(REFERENCE_MACHINE)
PLANTS = [Compressible(axis) for axis in AXES]
LOOP = Loop(10.0, 5e-4, delay=1)
ANGLE, TICKS = 0.1, 6000


def test_margins_are_of_gain_and_resonance_of_each_joint():
    gain = 8.0
    found = {one.what: one for one in gain_margins(CIRCUIT, PLANTS, (Loop(gain, 0.005),) * 2)}
    assert list(found) == ["gain of theta", "resonance of theta", "gain of phi",
                           "resonance of phi"]  # fmt: skip
    angles = CIRCUIT.position(np.linspace(0, CIRCUIT.profile.perimeter, 500))
    for joint, name in enumerate(("theta", "phi")):
        axis = AXES[joint]
        least = axis.natural_frequency(angles[:, joint]).min()
        resonance = found[f"resonance of {name}"]
        assert resonance.unit == "Hz"
        assert resonance.has == pytest.approx(least / (2 * np.pi), rel=1e-3)
        # A loop on an integrator with a resonance w and damping ratio zeta needs gain < 2 zeta w,
        # and 2 zeta w is the damping over the inertia.
        share = resonance.needs / resonance.has
        assert share == pytest.approx(gain / (axis.damping / axis.inertia), rel=1e-3)
        assert resonance.enough == (share < 1)
        limit = found[f"gain of {name}"]
        assert limit.needs == gain and 0 < limit.has < 1000 and limit.enough == (limit.has > gain)


def test_only_axes_with_cylinders_have_margins():
    with pytest.raises(ValueError, match=r"^plant: must have cylinders; got Lag, without\.$"):
        gain_margins(CIRCUIT, Lag(0.5, 0.02), Loop(8.0, 0.005))


# Picks that cut what the picks before them left


class Picks(Resistance):
    """Picks in step: each cuts what the one before it left on one joint's way, a period earlier."""

    def __init__(self, joint, picks, damper, lever):
        self.joint = joint
        self.before = round(1 / picks / LOOP.tick)
        self.stiffness = damper * lever**2 * picks
        self.way = np.full(self.before + TICKS + 1, ANGLE)

    def run(self, machine, tick, controls, memories, least, setvalues, slopes, states, commands):
        for n in range(len(slopes)):
            torque = np.zeros((1, 2))
            off = self.way[self.before + n] - self.way[n]
            torque[0, self.joint] = self.stiffness * off
            state = tuple(map(tuple, states[n].reshape(3, 5).tolist()))
            one = slice(n, n + 1)
            rows = Push(torque=torque).rows
            call(run_joints, machine, tick, controls, memories, n, state, setvalues[one],
                 slopes[one], rows, parts_in(machine, least, rows, tick), states[n : n + 2],
                 commands[one], kind="axes", commanding=spool_at)  # fmt: skip
            self.way[self.before + n + 1] = states[n + 1, 5 * self.joint]
        return len(slopes)


def swing(joint, picks, damper, lever):
    """Return by how much a swing grows in a second, and its frequency in Hz, run tick by tick."""
    wanted = np.full((TICKS + 1, 2), ANGLE)
    wanted[1:] += 1e-5
    push = Picks(joint, picks, damper, lever)
    off = follow(PLANTS, [LOOP] * 2, wanted, push=push).position[1:, joint]
    _, middle, end = off.reshape(3, -1) - off.reshape(3, -1).mean(axis=-1, keepdims=True)
    frequencies = np.fft.rfftfreq(len(end), LOOP.tick)
    return end.std() / middle.std(), frequencies[np.abs(np.fft.rfft(end)).argmax()]


@pytest.mark.parametrize(("joint", "picks", "lever"), [(0, 12.0, 0.88), (1, 20.0, 0.8)])
def test_joint_swings_up_beyond_the_limit_and_not_below(joint, picks, lever):
    limit, frequency = chatter_limit(PLANTS[joint], LOOP, ANGLE, lever, picks)
    assert swing(joint, picks, 0.85 * limit, lever)[0] < 0.6
    grown, found = swing(joint, picks, 1.15 * limit, lever)
    assert grown > 2 and found == pytest.approx(frequency, abs=1.0)


def test_margins_of_a_job_are_the_least_of_its_joints():
    job = read_job(JOB)
    theta, phi = job.in_step
    circuit = job.planned.circuit
    at = circuit.position(np.linspace(0, circuit.profile.perimeter, 41))
    lever = levers(circuit.machine.torus, at)
    for joint, margin in enumerate((theta, phi)):
        plant, loop = (both[joint] for both in job.axes)
        limits = [
            chatter_limit(plant, loop, angle, length, 12.0)[0]
            for angle, length in zip(at[:, joint], lever[:, joint], strict=True)
        ]
        assert margin.has == pytest.approx(min(limits), rel=0.02)
    # In concrete, 20 MJ/m^3 and 2 m/s, the damper is 10 N s/m for each square millimetre.
    most = engaged_areas(circuit, np.linspace(0, circuit.profile.perimeter, 400)).max()
    assert theta.needs == phi.needs == pytest.approx(1e7 * most, rel=0.02)
    assert not theta.enough and not phi.enough


def test_nothing_is_in_step_where_nothing_pushes_in_turn():
    job = read_job(JOB)
    for ground in ({}, job.ground | {"ripple_frequency": 0.0}):
        assert replace(job, ground=ground).in_step == []


@pytest.mark.parametrize("joint", [0, 1])
def test_a_held_command_is_late_by_half_a_tick_beside_its_delay(joint):
    """One and a half ticks of 2 ms are half a tick of 6 ms, and no other sum of ticks is."""
    short, long = (Loop(10.0, tick, delay=n) for tick, n in ((2e-3, 1), (6e-3, 0)))
    found = [chatter_limit(PLANTS[joint], loop, ANGLE, 0.8, 15.0) for loop in (short, long)]
    assert found[0] == pytest.approx(found[1], rel=1e-12)
    other = chatter_limit(PLANTS[joint], Loop(10.0, 2e-3, delay=0), ANGLE, 0.8, 15.0)
    assert abs(other[0] / found[0][0] - 1) > 1e-3
