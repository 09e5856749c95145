"""What loads that the controller doesn't know leave on the wall: the shared arm, the ground."""

from dataclasses import replace

import numpy as np

from ..arguments import checked
from ..kernels.exact import norm
from ..motion import Compressible, follow
from ..motion.arm import Arm
from ..removal import Ground
from .both_axes import Loops, Plants, check_linear, check_ticks
from .face import Face
from .faults import Fault
from .front import engaged_areas, facing_areas
from .moves import levers
from .outward import gradient
from .planning import Plan
from .sensitivity import planned_motion

SHAPE, THICKNESS = (200, 360), 0.1  # rays of the ground that laps are run in, and m
HALVES = 30  # of the way to the torque of the ground that is taken
# Force and speed both go with the feed: of a load that the ground makes a square is left.
SLOWER = ("power", 2**-0.5), ("feed", 2**-0.5)


class LoadedLaps:
    """Laps of a plan's circuit under loads: each is run once, whoever asks for it.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Compressible or a pair of them
        The axes.
    loop : Loop or a pair of them
        Their position loops.
    """

    @checked
    def __init__(self, plan: Plan, plant: Plants, loop: Loops):
        self.plan = plan
        self.plant = plant
        self.loop = loop
        self._found = {}

    @checked
    def overbreak(
        self, *, arm: Arm | None = None, ground: Ground | None = None, picks: bool = False
    ):
        """Return the overbreak (ticks + 1,), in m, of a lap.

        With an `arm` that both joints share, with a `ground` that pushes, and with its `picks`
        or their mean.
        """
        key = arm, ground, picks
        if key not in self._found:
            plan = self.plan
            # Both are the same to the tick at which the cutter rests in the ground between them.
            wanted = plan.circuit.position(plan.places)
            rates = np.diff(wanted, axis=0) / plan.tick
            push = None
            if ground is not None:
                ground = ground if picks else replace(ground, ripple=0.0)
                face = Face(replace(plan, laps=1), ground, wanted, 0, SHAPE, THICKNESS)
                face.wall.cut_path(plan.centres(wanted[:1]), face.radius)  # where the lap begins
                push = face.push
            track = follow(self.plant, self.loop, wanted, slopes=rates, arm=arm, push=push)
            self._found[key] = plan.circuit.overbreak(track.position)
        return self._found[key]


@checked
def arm_fault(plan: Plan, plant: Plants, loop: Loops, arm: Arm, *, laps: LoadedLaps | None = None):
    """Return the `Fault` of an arm that both joints share; the controller models a part.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Compressible or a pair of them
        The axes, whose static inverse has their own weight.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral and dead band.
    arm : Arm
        The masses on both joints.
    laps : LoadedLaps, optional
        Of the same plan, axes and loops, where laps are kept that others ask for, too.

    Returns
    -------
    fault : Fault
        Its closed form is that of slow motion under the weight that the axes' own doesn't have.
    """
    _check(plan, plant, loop)
    middle, _, _ = planned_motion(plan)
    at = plan.circuit.position(middle)
    known = np.stack([one.axis.load(q) for one, q in zip(plant, at.T, strict=True)], axis=-1)
    off = pushed_off(plan, plant, loop, arm.weight(at) - known)
    laps = laps or LoadedLaps(plan, plant, loop)
    deviation = laps.overbreak(arm=arm) - laps.overbreak()
    return Fault(
        source="both joints",
        deviation=deviation,
        measure="largest",
        closed=float(np.abs(off).max()),
        remedies=(("gain", 2.0),),
    )


@checked
def ground_fault(
    plan: Plan,
    plant: Plants,
    loop: Loops,
    ground: Ground,
    *,
    arm: Arm | None = None,
    laps: LoadedLaps | None = None,
):
    """Return the `Fault` of the ground's mean force, on whole grooves as those of a first lap.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Compressible or a pair of them
        The axes.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral and dead band.
    ground : Ground
        What cutting asks for.
    arm : Arm, optional
        The masses on both joints.
    laps : LoadedLaps, optional
        As for `arm_fault`.

    Returns
    -------
    fault : Fault
        Its closed form is that of slow motion, see `held_back`.
    """
    _check(plan, plant, loop)
    off = held_back(plan, plant, loop, ground)
    laps = laps or LoadedLaps(plan, plant, loop)
    return Fault(
        source="ground, mean",
        deviation=laps.overbreak(arm=arm, ground=ground) - laps.overbreak(arm=arm),
        measure="largest",
        closed=float(np.abs(off).max()),
        remedies=(*SLOWER, ("gain", 2.0)),
    )


@checked
def picks_fault(
    plan: Plan,
    plant: Plants,
    loop: Loops,
    ground: Ground,
    *,
    arm: Arm | None = None,
    laps: LoadedLaps | None = None,
):
    """Return the `Fault` of the picks' ripple, beyond that of their mean force.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Compressible or a pair of them
        The axes.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral and dead band.
    ground : Ground
        What cutting asks for, with its ripple.
    arm : Arm, optional
        The masses on both joints.
    laps : LoadedLaps, optional
        As for `arm_fault`.

    Returns
    -------
    fault : Fault
        Its closed form is the linear answer of arm, oil and loop to the ripple's frequency at each
        place, and the mean that is left of the ripple times the speed's own swing.
    """
    _check(plan, plant, loop)
    middle, _, _ = planned_motion(plan)
    at = plan.circuit.position(middle)
    slope = gradient(plan.circuit, middle, at)
    torque = _left_torques(plan, plant, loop, ground)
    swing = -ground.ripple * _answers(plan, plant, loop, ground, arm, torque)  # rad
    fast = np.abs(np.sum(slope * swing, axis=-1))
    # The ripple's force goes with what the front takes, which swings against it: of their product
    # a mean is left, by which the pulsating force is below the steady one.
    rate = (2j * np.pi * ground.ripple_frequency * swing).real
    less = ground.ripple / 2 * np.einsum("nij,nj->ni", _dampers(plan, ground), rate)
    slow = pushed_off(plan, plant, loop, torque + less) - pushed_off(plan, plant, loop, torque)
    off = fast + np.abs(slow)
    laps = laps or LoadedLaps(plan, plant, loop)
    mean = laps.overbreak(arm=arm, ground=ground)
    return Fault(
        source="ground, picks",
        deviation=laps.overbreak(arm=arm, ground=ground, picks=True) - mean,
        measure="largest",
        closed=float(off[:-1].max()),
        remedies=(*SLOWER, ("gain", 2.0)),
    )


def held_back(plan, plant, loop, ground):
    """Return how far (m,), in m, slow axes are off amid a plan's moves by a `ground`'s mean force.

    Of each `plant` under its `loop`. It is `pushed_off` with the ground that is left: a cutter that
    is off by e, negative where it is held back, takes a groove of the depth h + e in the place of
    h, and the section of a groove goes with the depth's power 3/2.
    """
    return pushed_off(plan, plant, loop, _left_torques(plan, plant, loop, ground))


def _left_torques(plan, plant, loop, ground):
    """Return the `ground_torques` (m, 2) of the ground that is taken, see `held_back`."""
    torque = ground_torques(plan, ground)
    left = torque
    for _ in range(HALVES):
        off = pushed_off(plan, plant, loop, left)
        share = np.maximum(1 + off / plan.circuit.machine.depth, 0.0) ** 1.5
        left = (left + share[:, None] * torque) / 2
    return left


def pushed_off(plan, plant, loop, torque):
    """Return how far (m,), in m, slow axes are off amid a plan's moves under a torque (m, 2).

    The `torque`, in N m, resists positive motion of each `plant` under its `loop`.
    The static inverse opens the valve for the rate w, as if nothing pushed. What the torque takes
    of the pressure, and what it drives through the leaks, the loop has to add by its error: with
    the drive d that lands and friction have without the torque,

        Kv e = w (sqrt(d / (d - torque / D)) - 1) + leaks torque / D^2.
    """
    middle, rate, _ = planned_motion(plan)
    at = plan.circuit.position(middle)
    slope = gradient(plan.circuit, middle, at)
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
        # Of a torque both chambers carry a half, and each has three leaks: two lands, the piston.
        leaks = 4 * (axis.piston_leak + axis.valve_leak) / (plus + minus) ** 2
        off = off - slope[:, i] * (behind + leaks * torque[:, i]) / control.gain
    return off


def _check(plan, plant, loop):
    """Raise ValueError where loads have no closed form, or the axes no oil that gives way."""
    check_ticks(plan, loop)
    check_linear(loop)
    if not all(isinstance(one, Compressible) for one in plant):
        raise ValueError(
            "plant: must be of class Compressible, which alone feels a load; got "
            f"{' and '.join(type(one).__name__ for one in plant)}."
        )


def ground_torques(plan, ground):
    """Return the torques (m, 2) of a `ground`'s mean force amid a plan's moves, in N m.

    They resist positive motion.
    """
    circuit = plan.circuit
    middle, rate, _ = planned_motion(plan)
    at = circuit.position(middle)
    along = levers(circuit.machine.torus, at)
    speed = np.linalg.norm(along * rate, axis=-1, keepdims=True)
    force = ground.force(engaged_areas(circuit, middle))[:, None]
    return force * (along**2 * rate + speed * ground.normal * gradient(circuit, middle, at))


def _dampers(plan, ground):
    """Return by how much (m, 2, 2) torques on joints i grow with swings' rates of joints j.

    In N m s, on whole grooves amid a plan's moves. The front takes more where the cutter swings
    ahead, by its section across the way, and where it swings out of the wall, by what faces that.
    Of the force along the way that is the way's part; that across is its share `normal`. A swing
    across the way also turns the force.
    """
    circuit = plan.circuit
    middle, rates, _ = planned_motion(plan)
    at = circuit.position(middle)
    out = gradient(circuit, middle, at)
    along = levers(circuit.machine.torus, at)
    moved = along * rates
    speed = norm(moved)[:, None]
    heading = moved / np.where(speed > 0, speed, 1.0)
    ahead = heading * along
    section = ground.force(engaged_areas(circuit, middle))[:, None]
    taken = section * ahead + ground.force(facing_areas(circuit, middle))[:, None] * out
    resisted = ahead + ground.normal * out
    turned = along[:, :, None] ** 2 * np.eye(2) - ahead[:, :, None] * ahead[:, None, :]
    return resisted[:, :, None] * taken[:, None, :] + section[:, :, None] * turned


def _answers(plan, plant, loop, ground, arm, torque):
    """Return the complex answers (m, 2) of both joints, in rad, to torques (m, 2) of the picks.

    Of small swings about the planned motion amid a plan's moves, at s = i w of the picks: a side
    of a cylinder with displacement D, volume V and pressure lost p at its land, under a flow c x
    sqrt(p) and leaks l, has the compliance C = V s / bulk + c x / (2 sqrt(p)) + l, and the joint

        torque / angle = J s^2 + b s + sum(D^2 s / C) + G(s) sum(D c sqrt(p) / C),

    where the loop G opens the spool for the rate gain e, after its delay, half a tick and its lag.
    The ground damps both joints together.
    """
    middle, rates, _ = planned_motion(plan)
    at = plan.circuit.position(middle)
    if not ground.ripple_frequency:  # no ripple; and no loop leaves a lasting error to the oil
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
        # What the load leaves of the supply is lost at both lands of the spool, as the squares of
        # their flows: rho^2 as much at the emptied side, whose area makes it rho times that again.
        drive = axis.supply - rho * axis.tank - resisted / D
        lost = np.maximum(drive, 1e-3 * axis.supply) / (1 + rho**3)  # at the side that is filled
        # How far the planned motion opens the spool, and how far each rad/s more would.
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
            yields = volume * s / axis.bulk + axis.flow * opened / (2 * np.sqrt(p)) + leaks
            stiff = stiff + displaced / yields * (displaced * s + steered * axis.flow * np.sqrt(p))
        matrix[:, i, i] += stiff
    return np.linalg.solve(matrix, torque[..., None].astype(complex))[..., 0]
