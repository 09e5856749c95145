"""What each source of plan, axes and pose alone leaves on the wall, and its closed form.

Each function takes a `Case` and returns the overbreak (ticks + 1,), in m, and the closed form of
its largest size, or of its rms, or None.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..kernels.exact import dot, norm
from ..motion import follow
from ..motion.plant import NoLinearForm
from ..paths import geodesic_inverse
from .moves import Moves, levers
from .outward import gradient, wall_frame
from .route import ROUNDED, route_through
from .sensitivity import geodesic_bend, joint_bend, planned_motion, rounding_passed, trailing


def knot_fault(case):
    """Return what is left if true geodesics between knots replace the circuit.

    The closed form is the sagitta of a chord, bend length^2/8.
    """
    plan = case.plan
    middle, length, direction = _segments(plan)
    position = plan.circuit.position(middle)
    sagitta = geodesic_bend(plan.circuit, middle, position, direction) * length**2 / 8
    return _overbreak(plan, _geodesics(plan)), _largest(sagitta)


def projected_fault(case):
    """Return what is left if projected chords replace geodesics between the same knots.

    The closed form is the law of short chords, which goes with the third power of their length.
    """
    plan = case.plan
    torus = plan.circuit.machine.torus
    middle, length, direction = _segments(plan)
    q = plan.circuit.position(middle)
    bend = torus.normal_curvature(q, direction)
    torsion = torus.geodesic_torsion(q, direction)
    across = np.cross(torus.normal(q[:, 0], q[:, 1]), direction)
    law = np.abs(bend * torsion) * length**3 / (36 * np.sqrt(3))
    out = dot(across, wall_frame(plan.circuit, middle)[0])
    return _overbreak(plan, _sharp(plan)) - _overbreak(plan, _geodesics(plan)), _largest(law * out)


def corrected_fault(case):
    """Return what is left if corrected chords replace geodesics between the same knots.

    The correction cancels the projected chord's law, and the next power has no closed form.
    """
    return projected_fault(case)[0], None


def corner_fault(case):
    """Return what the rounding of the corners at knots leaves; `Route.at` has the closed form."""
    plan = case.plan
    way = plan.route
    slope = gradient(plan.circuit, way.places, plan.circuit.position(way.places))
    missed = ROUNDED * dot(slope, way.kinks) * way.halves
    return _overbreak(plan, way) - _overbreak(plan, _sharp(plan)), _largest(missed)


def setpoint_fault(case):
    """Return what is left by straight lines in joint space between setpoints on the circuit."""
    circuit = case.plan.circuit
    s = case.plan.s
    at = circuit.position(s)
    middle = (s[1:] + s[:-1]) / 2
    move = np.diff(at, axis=0)
    sagitta = joint_bend(circuit, middle, circuit.position(middle), move) / 8
    return circuit.overbreak(_between(case.plan, at)), _largest(sagitta)


def count_fault(case):
    """Return what is left by lines in whole counts, and setpoints in parts of a count."""
    plan = case.plan
    circuit = plan.circuit
    at = circuit.position(plan.s)
    moves = Moves(setpoints=at, ticks=plan.ticks, tick=plan.tick, count=plan.count)
    apart = circuit.overbreak(moves.setvalues) - circuit.overbreak(_between(plan, at))
    slope = gradient(circuit, plan.places, circuit.position(plan.places))
    # A line's rounding is uniform over a count, with the mean square count^2/12. That of setpoints
    # to parts of a count is less than the share 1/fineness^2 of it.
    square = plan.count**2 / 12 * np.mean(np.sum(slope**2, axis=-1))
    return apart, float(np.sqrt(square))


def ripple_fault(case):
    """Return how far even joint rates over each move put the cutter ahead along the path.

    Between setpoints each joint turns at one rate, where the planned motion changes it: by an
    acceleration `a` of the cutter along its way over N ticks T. The closed form is the sagitta in
    time at the middle tick, a T^2 (N/2)^2 / 2. The feed may be constant and `a` isn't zero, since
    the levers change; a move of one tick has no tick between its ends.
    """
    plan = case.plan
    torus = plan.circuit.machine.torus
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    wanted = plan.route.at(plan.reached)
    off = _between(plan, plan.setpoints) - wanted
    direction = plan.route.at(plan.reached, order=1)
    lever = levers(torus, wanted)
    along = dot(lever * off, lever * direction)
    # The joints' mean acceleration between the first and the last tick of each move but the rest.
    first = ends[:-2]
    last = ends[1:-1]
    middle = (first + last) // 2
    ticks = plan.ticks[:-1]
    rate = np.diff(wanted, axis=0)  # rad a tick
    change = (rate[last - 1] - rate[first]) / np.maximum(ticks - 1, 1)[:, None]
    acceleration = dot(lever[middle] * change, lever[middle] * direction[middle])
    return along, _largest(acceleration * (ticks // 2) * (ticks - ticks // 2) / 2)


def following_fault(case):
    """Return what is left by axes that trail their exact set-values, with ideal encoders.

    The closed form is the series to second order, for slow motion without waits, or None if a plant
    has no linear form.
    """
    plan = case.plan
    wanted = plan.circuit.position(plan.places)
    deviation = _followed(case, _ideal(case.loop), wanted)
    with suppress(NoLinearForm):
        first, second = trailing(plan, case.plant, case.loop)
        return deviation, _largest(first + second)
    return deviation, None


def encoder_fault(case):
    """Return what is left by encoders with whole counts, beyond ideal ones.

    The rest at the lap's end, in which one rounding persists, is left out. The closed form is None
    if a plant has no linear form.
    """
    plan = case.plan
    wanted = plan.circuit.position(plan.places[: -plan.ticks[-1]])
    apart = _followed(case, case.loop, wanted) - _followed(case, _ideal(case.loop), wanted)
    motion = planned_motion(plan)
    square = 0.0
    with suppress(NoLinearForm):
        for joint, (plant, loop) in enumerate(zip(case.plant, case.loop, strict=True)):
            angle = motion.position[:, joint]
            passed = rounding_passed(plant, loop, motion.rate[:, joint], angle)
            passed = (motion.slope[:, joint] * loop.count) ** 2 * passed
            square += np.average(passed[:-1], weights=plan.ticks[:-1])
        return apart, float(np.sqrt(square))
    return apart, None


def pose_fault(case):
    """Return what is left by a machine that stands elsewhere, by a `Pose`, without knowing it."""
    plan = case.plan
    pose = case.pose
    circuit = plan.circuit
    wanted = circuit.position(plan.places)
    centre = plan.centres(wanted, pose=pose)
    # A small turn moves a point by the cross product with the arm from the centre of the turn.
    arm = plan.centres(wanted) - circuit.in_tunnel(np.zeros(3))
    moved = np.cross([pose.roll, pose.pitch, pose.yaw], arm) + np.array([0.0, pose.y, pose.z])
    closed = _largest(dot(moved[:, 1:], circuit.profile.normal(plan.places)))
    return -circuit.profile.depth(centre[:, 1], centre[:, 2]), closed


def _largest(sizes):
    return float(np.abs(sizes).max())


def _segments(plan):
    """Return the middle arc lengths, lengths and directions of the chords between knots."""
    ends = np.append(plan.knots, plan.circuit.profile.perimeter)
    at = plan.circuit.position(ends)
    chord = np.diff(plan.circuit.machine.torus.point(at[:, 0], at[:, 1]), axis=0)
    length = norm(chord)
    return (ends[1:] + ends[:-1]) / 2, length, chord / length[:, None]


def _geodesics(plan):
    """Return the `Route` of geodesics between the plan's knots, with sharp corners."""

    def way(p, q, count):
        return geodesic_inverse(plan.circuit.machine.torus, p, q).points(count).position

    return route_through(plan.circuit, plan.knots, way=way)


def _sharp(plan):
    """Return the plan's `Route` with sharp corners."""
    return replace(plan.route, halves=np.zeros_like(plan.route.halves))


def _between(plan, at):
    """Return positions (ticks + 1, 2) of straight lines in joint space between setpoints."""
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    ticks = np.arange(ends[-1] + 1)
    return np.stack([np.interp(ticks, ends, axis) for axis in at.T], axis=-1)


def _overbreak(plan, way):
    """Return the overbreak (ticks + 1,) of another way at the places of the ticks, in m."""
    return plan.circuit.overbreak(way.at(np.interp(plan.places, way.places, way.ends)))


def _followed(case, loops, wanted):
    """Return the overbreak (n,) of axes that follow positions (n, 2), one for each tick, in m."""
    rates = np.diff(wanted, axis=0) / case.plan.tick
    track = follow(case.plant, loops, wanted, slopes=rates)
    return case.plan.circuit.overbreak(track.position)


def _ideal(loops):
    """Return the loops with ideal encoders."""
    return [replace(loop, count=0.0) for loop in loops]
