"""First and second derivatives of the overbreak: the closed forms of the error budget.

The cutter's centre at the joint position q is f(q) outside the offset section. n is the section's
outward normal and rho its radius of curvature at the place where f is zero.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import checked
from ..kernels.exact import dot, norm
from .both_axes import Loops, Plants, check_linear, check_ticks
from .outward import gradient, wall_frame
from .planning import Plan

HARMONICS = 64  # of the encoder's rounding that count
ANGLES = 41  # of a lap, at which a plant's linear form is asked for


def joint_bend(circuit, s, q, rate):
    """Return d^2 f/dt^2 (...) along straight lines in joint space, in m over the rate's s^2.

    The lines have the joint positions q and rates (..., 2) where the circuit has the arc lengths s
    (...).
    """
    torus = circuit.machine.torus
    normal, tangent, curvature = wall_frame(circuit, s)
    along = dot(torus.velocity(q, rate), tangent)
    return dot(torus.acceleration(q, rate), normal) + curvature * along**2


def geodesic_bend(circuit, s, q, direction):
    """Return d^2 f/dl^2 (...) along geodesics of unit directions (..., 3), in 1/m.

    They pass joint positions q (..., 2) where the circuit has the arc lengths s (...). It is the
    section's curvature less the part that the torus' own bend takes away; the sagitta between knots
    a length l apart is l^2/8 times as great.
    """
    torus = circuit.machine.torus
    normal, tangent, curvature = wall_frame(circuit, s)
    across = torus.normal(q[..., 0], q[..., 1])
    of_torus = torus.normal_curvature(q, direction) * dot(across, normal)
    return curvature * dot(direction, tangent) ** 2 - of_torus


def _linear(plant, angles):
    """Return linear plants of small motions, and the index (m,) of the nearest to each angle (m,).

    The joint angles are in rad.
    """
    # A few suffice, since the oil's stiffness changes slowly with the angle.
    asked = np.linspace(angles.min(), angles.max(), ANGLES)
    models = [plant.linear(angle) for angle in asked.tolist()]
    return models, np.abs(angles[:, None] - asked).argmin(axis=-1)


def _latenesses(plant, angles):
    """Return the lateness (m,) of a plant's small motions near joint angles (m,) in rad, in s."""
    models, nearest = _linear(plant, angles)
    return np.array([one.lateness for one in models])[nearest]


def rounding_passed(plant, loop, rate, angle):
    """Return the mean square (m,) of an encoder's rounding that reaches the joint, in counts^2.

    At a steady `rate` (m,) in rad/s the rounding is a sawtooth of known harmonics, each of which
    the linear `loop` of the `plant` passes on at the joint `angle` (m,) in rad, sampled at the
    ticks: 1/12 in slow motion, and 1/12 Kv T / (2 - Kv T) for T0 in fast motion. The axis also
    reacts to the rounding and shifts its phase, which no linear theory has:
    ((1 - Kv T)^2 + (Kv T)^2)/12 in slow motion. On the wall 0.65 to 1.43 times this rms were
    measured, with T0, T1 and T2 at 30 to 200 mm/s and 2^12 to 2^18 counts a turn.
    """
    if not loop.count:
        return np.zeros(len(rate))
    # The sawtooth's k-th harmonic has the amplitude count/(pi k), and turns by this much per tick.
    k = np.arange(1, HARMONICS + 1)
    turns = np.abs(rate) * loop.tick / loop.count + 1e-9  # at rest the limit of slow motion
    z = np.exp(2j * np.pi * k * turns[:, None])
    models, nearest = _linear(plant, angle)
    discrete = zip(*(one.discrete(loop.tick) for one in models), strict=True)
    Ad, Bd = (np.stack(part)[nearest] for part in discrete)
    steady = np.array([one.command(1.0) for one in models])[nearest]
    order = Bd.shape[-1]
    held = np.broadcast_to(
        (Bd * steady[:, None]).astype(complex)[:, None, :, None], (*z.shape, order, 1)
    )
    # The plant's answer to a command held over each tick: the first number of (z - Ad)^-1 Bd.
    open_loop = np.linalg.solve(z[..., None, None] * np.eye(order) - Ad[:, None], held)[..., 0, 0]
    open_loop = loop.gain * open_loop / z**loop.delay
    passed = np.abs(open_loop / (1 + open_loop)) ** 2
    return np.sum(passed / k**2, axis=-1) / (2 * np.pi**2)


class PlannedMotion(NamedTuple):
    """The joints' motion amid a plan's m moves, without the feed's own changes.

    Parameters
    ----------
    place : (m,) float
        Arc lengths along the offset section, in m.
    position, rate, change : (m, 2) float
        Positions, rates and accelerations of the joints, in rad, rad/s and rad/s^2.
    slope : (m, 2) float
        How far the cutter's centre moves out of the wall per radian of each joint, in m.
    """

    place: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    change: np.ndarray
    slope: np.ndarray


@lru_cache(2)
def planned_motion(plan):
    """Return the `PlannedMotion` of a plan, which all closed forms of its axes need."""
    circuit = plan.circuit
    h = 1e-4  # m, less than a move, so that few differences straddle a blend
    middle = (plan.s[1:] + plan.s[:-1]) / 2
    before = circuit.position(middle - h)
    at = circuit.position(middle)
    after = circuit.position(middle + h)
    along = (after - before) / (2 * h)
    speed = np.where(np.diff(plan.s) > 0, (plan.feed[1:] + plan.feed[:-1]) / 2, 0.0)
    speed = (speed / norm(circuit.machine.torus.velocity(at, along)))[:, None]
    change = (after - 2 * at + before) / h**2 * speed**2
    return PlannedMotion(middle, at, along * speed, change, gradient(circuit, middle, at))


@checked
def trailing(plan: Plan, plant: Plants, loop: Loops):
    """Return the deviation by the loops' lag amid a plan's moves, to second order.

    Parameters
    ----------
    plan : Plan
        The plan to run.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick and without integral; encoders are taken as
        ideal.

    Returns
    -------
    deviation : (2, m) float
        Two terms of a series, in m: with gains u times as high the deviation is the first over u
        plus the second over u^2.

    Raises
    ------
    NoLinearForm
        If a plant has no linear form.

    Notes
    -----
    To first order a joint is behind by lag ((1 - share) rate + ((1 - share) tick / 2 + late)
    change): the part of the rate that isn't fed forward, held over a tick, and the acceleration
    during the delays of loop and plant. To second order a P loop's lag counts twice, and the wall
    bends.
    """
    check_ticks(plan, loop)
    check_linear(loop)
    circuit = plan.circuit
    motion = planned_motion(plan)
    share = np.array([one.feedforward for one in loop])
    lag = 1 / np.array([one.gain for one in loop])
    delay = np.array([one.delay * plan.tick for one in loop])
    late = delay + np.stack(list(map(_latenesses, plant, motion.position.T)), axis=-1)
    # Where the rate isn't fed forward the error must ask for it, which takes lag times the rate.
    behind = -(1 - share) * lag * motion.rate
    first = behind - lag * ((1 - share) * plan.tick / 2 + late) * motion.change
    bend = joint_bend(circuit, motion.place, motion.position, behind)
    second = dot(motion.slope, (1 - share) * lag**2 * motion.change) + bend / 2
    return np.stack([dot(motion.slope, first), second])
