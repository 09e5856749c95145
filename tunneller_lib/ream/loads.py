"""What loads that the controller doesn't know leave on the wall: the shared arm and the ground.

The faults take a `Case` and return the overbreak (ticks + 1,), in m, and its closed form, like
those of the module `faults`.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..kernels.exact import norm
from ..motion import follow
from .face import Face
from .front import engaged_areas, facing_areas
from .moves import levers
from .sensitivity import planned_motion

SHAPE = 200, 360  # rays of the ground that laps are run in
THICKNESS = 0.1  # m
HALVES = 30  # damped steps to the torque of the ground that is removed


@lru_cache(6)
def loaded_lap(plan, plant, loop, arm, ground):
    """Return the overbreak (ticks + 1,) of a lap of a `plan` under loads, in m.

    Each `plant` is under its `loop`. Both joints share an `arm`, and a `ground` pushes; arm and
    ground may be None. The answer is kept, since several sources of a budget compare the same laps.
    """
    # All laps begin and end with the cutter at rest in the ground, so one stands for all.
    wanted = plan.circuit.position(plan.places)
    rates = np.diff(wanted, axis=0) / plan.tick
    face = None
    if ground is not None:
        face = Face(replace(plan, laps=1), ground, wanted, 0, SHAPE, THICKNESS)
        # Where the lap begins.
        face.wall.cut_path(plan.centres(wanted[:1]), plan.circuit.machine.cutter_radius)
    track = follow(plant, loop, wanted, slopes=rates, arm=arm, push=face)
    return plan.circuit.overbreak(track.position)


def arm_fault(case):
    """Return what is left by the arm that both joints share, of which the controller models a part.

    The closed form is that of slow motion under the weight that the axes' own models lack.
    """
    given = case.plan, case.plant, case.loop
    at = planned_motion(case.plan).position
    known = np.stack([one.axis.load(q) for one, q in zip(case.plant, at.T, strict=True)], axis=-1)
    off = pushed_off(*given, case.arm.weight(at) - known)
    apart = loaded_lap(*given, case.arm, None) - loaded_lap(*given, None, None)
    return apart, float(np.abs(off).max())


def ground_fault(case):
    """Return what is left by the ground's mean force on whole grooves, as in a first lap.

    The closed form is that of slow motion, see `held_back`.
    """
    given = case.plan, case.plant, case.loop
    off = held_back(*given, case.ground)
    mean = replace(case.ground, ripple=0.0)
    apart = loaded_lap(*given, case.arm, mean) - loaded_lap(*given, case.arm, None)
    return apart, float(np.abs(off).max())


def picks_fault(case):
    """Return what is left by the picks' ripple beyond their mean force.

    The closed form is the linear answer of arm, oil and loop at the ripple's frequency at each
    place, and the mean of the product of the ripple and the speed's own swing.
    """
    given = case.plan, case.plant, case.loop
    plan = case.plan
    ground = case.ground
    torque = _left_torques(*given, ground)
    swing = -ground.ripple * _answers(*given, ground, case.arm, torque)  # rad
    fast = np.abs(np.sum(planned_motion(plan).slope * swing, axis=-1))
    # The ripple multiplies the removal, which swings against it: their product has a mean, by which
    # the pulsating force is below the steady one.
    rate = (2j * np.pi * ground.ripple_frequency * swing).real
    less = ground.ripple / 2 * np.einsum("nij,nj->ni", _dampers(plan, ground), rate)
    slow = pushed_off(*given, torque + less) - pushed_off(*given, torque)
    mean = loaded_lap(*given, case.arm, replace(ground, ripple=0.0))
    apart = loaded_lap(*given, case.arm, ground) - mean
    return apart, float((fast + np.abs(slow))[:-1].max())


def held_back(plan, plant, loop, ground):
    """Return how far (m,) the `ground`'s mean force puts slow axes off amid a plan's moves, in m.

    It is `pushed_off` for each `plant` under its `loop` with the ground that is really removed: a
    cutter that is off by e, negative if it is held back, cuts a groove of depth h + e in place of
    h, and the section of a groove goes with the power 3/2 of its depth.
    """
    return pushed_off(plan, plant, loop, _left_torques(plan, plant, loop, ground))


def _left_torques(plan, plant, loop, ground):
    """Return the `ground_torques` (m, 2) of the ground that is really removed; see `held_back`."""
    torque = ground_torques(plan, ground)
    # A held-back cutter removes less ground, which holds it back less. Each step goes halfway,
    # since whole steps may oscillate about the answer.
    left = torque
    for _ in range(HALVES):
        off = pushed_off(plan, plant, loop, left)
        share = np.maximum(1 + off / plan.circuit.machine.depth, 0.0) ** 1.5
        left = (left + share[:, None] * torque) / 2
    return left


def pushed_off(plan, plant, loop, torque):
    """Return how far (m,) slow axes are off amid a plan's moves under a torque (m, 2), in m.

    The `torque`, in N m, resists positive motion of each `plant` under its `loop`. The static
    inverse opens the valve for the rate w as if nothing pushed. The loop's error e must make up for
    the pressure that the torque takes, and for the oil that it drives through the leaks: with the
    pressure d that lands and friction have without the torque,

        Kv e = w (sqrt(d / (d - torque / D)) - 1) + leaks torque / D^2.
    """
    _, at, rate, _, slope = planned_motion(plan)
    off = 0.0
    for i, (one, control) in enumerate(zip(plant, loop, strict=True)):
        axis = one.axis
        behind = 0.0
        for sign, (D, rho, load) in zip((1, -1), axis.sides(at[:, i]), strict=True):
            forward = np.maximum(sign * rate[:, i], 0.0)
            drive = axis.supply - rho * axis.tank - load / D - axis.damping * forward / D
            left = np.maximum(drive - sign * torque[:, i] / D, 1e-3 * drive)
            behind = behind + sign * forward * (np.sqrt(drive / left) - 1)
        plus, minus = axis.linkage.displacements(at[:, i])
        # Half of the torque changes the pressure of each chamber, which leaks past two lands; the
        # whole of it drives the leak past the piston.
        leaks = 4 * (axis.piston_leak + axis.valve_leak) / (plus + minus) ** 2
        off = off - slope[:, i] * (behind + leaks * torque[:, i]) / control.gain
    return off


def ground_torques(plan, ground):
    """Return the torques (m, 2) against positive motion of a `ground`'s mean force, in N m.

    They hold amid a plan's moves.
    """
    place, at, rate, _, slope = planned_motion(plan)
    along = levers(plan.circuit.machine.torus, at)
    speed = np.linalg.norm(along * rate, axis=-1, keepdims=True)
    force = ground.force(engaged_areas(plan.circuit, place))[:, None]
    return force * (along**2 * rate + speed * ground.normal * slope)


def _dampers(plan, ground):
    """Return the torques on joints i per rate of swings of joints j (m, 2, 2), in N m s.

    They hold in whole grooves amid a plan's moves. The front removes more if the cutter swings
    ahead, by its section across the way, and if it swings out of the wall, by the area that faces
    the wall. The force across the way is the share `normal` of the one along it. A swing across the
    way also turns the force.
    """
    circuit = plan.circuit
    middle, at, rate, _, out = planned_motion(plan)
    along = levers(circuit.machine.torus, at)
    moved = along * rate
    speed = norm(moved)[:, None]
    heading = moved / np.where(speed > 0, speed, 1.0)
    ahead = heading * along
    section = ground.force(engaged_areas(circuit, middle))[:, None]
    taken = section * ahead + ground.force(facing_areas(circuit, middle))[:, None] * out
    resisted = ahead + ground.normal * out
    turned = along[:, :, None] ** 2 * np.eye(2) - ahead[:, :, None] * ahead[:, None, :]
    return resisted[:, :, None] * taken[:, None, :] + section[:, :, None] * turned


def _answers(plan, plant, loop, ground, arm, torque):
    """Return the complex swings (m, 2) of both joints under torques (m, 2) that swing, in rad.

    They are small swings about the planned motion amid a plan's moves, at s = i w for the angular
    frequency w of the picks. The `torque`, in N m, is the amplitude of what swings, and also what
    resists the planned motion steadily. A side of a cylinder with displacement D, volume V,
    pressure drop p at its land, flow c x sqrt(p) and leaks l has the compliance
    C = V s / bulk + c x / (2 sqrt(p)) + l, and the joint

        torque / angle = J s^2 + b s + sum(D^2 s / C) + G(s) sum(D c sqrt(p) / C),

    where the loop G opens the spool for a rate of gain times angle, after its delay, half a tick
    and the spool's lag. The leak past the piston is taken as if the pressure of the other side
    didn't swing. The ground couples both joints, see `_dampers`.
    """
    _, at, rates, _, _ = planned_motion(plan)
    if not ground.ripple_frequency:  # no ripple
        return np.zeros_like(at)
    s = 2j * np.pi * ground.ripple_frequency
    inertias = [one.axis.inertia for one in plant] if arm is None else arm.inertias(at[:, 1])
    matrix = s * _dampers(plan, ground)
    for i, (one, control) in enumerate(zip(plant, loop, strict=True)):
        axis = one.axis
        angle = at[:, i]
        rate = rates[:, i]
        forward, backward = axis.sides(angle)
        # The side that is filled has the displacement D, the emptied one rho D.
        D, rho, load = np.where(rate > 0, forward, backward)
        sign = np.where(rate > 0, 1.0, -1.0)
        resisted = load + sign * (axis.damping * rate + torque[:, i])
        # What the load leaves of the supply's pressure is lost at both lands of the spool, with the
        # square of the flow: rho^2 times as much at the emptied side, whose area is rho times as
        # large. An axis too weak for its load keeps a thousandth of the supply's pressure.
        drive = axis.supply - rho * axis.tank - resisted / D
        lost = np.maximum(drive, 1e-3 * axis.supply) / (1 + rho**3)  # at the side that is filled
        # The share by which the planned motion opens the valve, and that for each rad/s.
        opened = np.abs(rate) * D / (axis.flow * np.sqrt(lost))
        opening = D / (axis.flow * np.sqrt(lost))
        # The loop sees the swing late, and the spool lags behind the loop.
        late = s * control.tick * (control.delay + 0.5)
        steered = control.gain * opening * np.exp(-late) / (1 + s * axis.valve_lag)
        volumes = axis.linkage.volumes(angle, axis.low, axis.high)
        volumes = np.where(rate > 0, volumes, volumes[::-1]) + axis.hose
        leaks = 2 * axis.valve_leak + axis.piston_leak
        stiff = inertias[i] * s**2 + axis.damping * s
        for displaced, volume, p in ((D, volumes[0], lost), (D * rho, volumes[1], rho**2 * lost)):
            compliance = volume * s / axis.bulk + axis.flow * opened / (2 * np.sqrt(p)) + leaks
            oil = displaced * s + steered * axis.flow * np.sqrt(p)  # m^3/s for each rad
            stiff = stiff + displaced / compliance * oil
        matrix[:, i, i] += stiff
    return np.linalg.solve(matrix, torque[..., None].astype(complex))[..., 0]
