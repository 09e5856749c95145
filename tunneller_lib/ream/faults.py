"""The sources of the wall's error, each switched on alone, and the closed form of each."""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..arguments import checked
from ..kernels.exact import dot, norm
from ..motion import follow
from ..motion.plant import NoLinearForm
from ..paths import geodesic_inverse
from .both_axes import Loops, Plants, check_linear, check_ticks
from .moves import Moves, levers
from .outward import gradient, wall_frame
from .planning import Plan, check_unheld
from .pose import Pose
from .route import ROUNDED, path_points, route_through
from .sensitivity import geodesic_bend, joint_bend, planned_motion, rounding_passed, trailing

# Who answers for a source; the path between knots, whatever its name, is what the paper is about.
KINDS = {
    "knots": "chosen", "corners": "chosen", "pose": "chosen",
    "setpoints": "machine", "counts": "machine", "feed ripple": "machine",
    "following": "machine", "encoder": "machine", "both joints": "machine",
    "ground, mean": "ground", "ground, picks": "ground",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Fault:
    """One source of error, alone.

    Parameters
    ----------
    source : str
        What is switched on; everything else is ideal.
    deviation : (ticks + 1,) float
        Overbreak that it leaves at each tick of a lap, in m; negative underbreak. Where it is
        `along` the path, how far the set-values are ahead.
    measure : {"largest", "rms"}
        What the closed form says.
    closed : float or None
        The closed form, in m; None where there is none.
    remedies : tuple of (str, float)
        What may halve it, the likeliest first, and by which factor of that by its power or closed
        form: a guess, which `halving` tries.
    along : bool
        Whether it is along the path and not across.
    """

    source: str
    deviation: np.ndarray
    measure: str
    closed: float | None
    remedies: tuple
    along: bool = False

    @property
    def kind(self):
        """Return who answers for it: "chosen", "machine", "ground" or "paper"."""
        return KINDS.get(self.source, "paper")

    @property
    def over(self):
        """Return the greatest overbreak, in m, at least 0."""
        return max(0.0, float(self.deviation.max()))

    @property
    def under(self):
        """Return the greatest underbreak, in m, at least 0."""
        return max(0.0, float(-self.deviation.min()))

    @property
    def rms(self):
        """Return the root mean square over the lap, in m."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    @property
    def measured(self):
        """Return what `closed` is compared with, in m."""
        return self.rms if self.measure == "rms" else max(self.over, self.under)

    @property
    def ratio(self):
        """Return what is measured over its closed form; None where there is none, or it is zero."""
        return self.measured / self.closed if self.closed else None


@checked
def knot_fault(plan: Plan):
    """Return the `Fault` of joining knots by true geodesics instead of following the circuit."""
    check_unheld(plan)
    between = _segments(plan)
    bend = geodesic_bend(plan.circuit, between.middle, between.position, between.direction)
    sagitta = bend * between.length**2 / 8
    return Fault(
        source="knots",
        deviation=_overbreak(plan, _geodesics(plan)),
        measure="largest",
        closed=float(np.abs(sagitta).max()),
        remedies=(("tolerance", 1 / 2),),
    )


@checked
def tangent_sphere_fault(plan: Plan):
    """Return the `Fault` of the plan's paths in place of geodesics between the same knots.

    The closed form is that of the projected chord where chords are short. Of corrected chords
    nothing of it is left: the next power of the length decides, for which there is none.
    """
    check_unheld(plan)
    circuit = plan.circuit
    torus = circuit.machine.torus
    between = _segments(plan)
    q = between.position
    bend = torus.normal_curvature(q, between.direction)
    torsion = torus.geodesic_torsion(q, between.direction)
    across = np.cross(torus.normal(q[:, 0], q[:, 1]), between.direction)
    law = np.abs(bend * torsion) * between.length**3 / (36 * np.sqrt(3))
    closed = law * np.abs(dot(across, wall_frame(circuit, between.middle)[0]))
    apart = _overbreak(plan, _sharp(plan)) - _overbreak(plan, _geodesics(plan))
    corrected = plan.path == "corrected chord"
    return Fault(
        source=plan.path,
        deviation=apart,
        measure="largest",
        closed=None if corrected else float(closed.max()),
        # It goes with the third or fourth power of the length, the tolerance with the second.
        remedies=(("tolerance", 2 ** (-1 / 2 if corrected else -2 / 3)),),
    )


@checked
def corner_fault(plan: Plan):
    """Return the `Fault` of rounding the corners at knots."""
    check_unheld(plan)
    way = plan.route
    circuit = plan.circuit
    at = circuit.position(way.places)
    slope = gradient(circuit, way.places, at)
    missed = ROUNDED * np.abs(dot(slope, way.kinks)) * way.halves
    return Fault(
        source="corners",
        deviation=_overbreak(plan, way) - _overbreak(plan, _sharp(plan)),
        measure="largest",
        closed=float(missed.max()),
        remedies=(("tolerance", 1 / 2),),  # of which corners may miss their knots by a part
    )


@checked
def setpoint_fault(plan: Plan):
    """Return the `Fault` of straight lines in joint space between setpoints on the circuit."""
    circuit = plan.circuit
    at = circuit.position(plan.s)
    middle = (plan.s[1:] + plan.s[:-1]) / 2
    move = np.diff(at, axis=0)
    sagitta = joint_bend(circuit, middle, circuit.position(middle), move) / 8
    return Fault(
        source="setpoints",
        deviation=circuit.overbreak(_between(plan, at)),
        measure="largest",
        closed=float(np.abs(sagitta).max()),
        remedies=(("step", 2**-0.5),),
    )


@checked
def count_fault(plan: Plan):
    """Return the `Fault` of whole counts: of the lines, and of setpoints in parts of a count."""
    circuit = plan.circuit
    at = circuit.position(plan.s)
    moves = Moves(setpoints=at, ticks=plan.ticks, tick=plan.tick, count=plan.count)
    apart = circuit.overbreak(moves.setvalues) - circuit.overbreak(_between(plan, at))
    slope = gradient(circuit, plan.places, circuit.position(plan.places))
    # A line's rounding is uniform over a count. A setpoint is off by a uniform half of a part, and
    # their mix on a line by 2/3 of its square.
    square = (
        plan.count**2 / 12 * (1 + 2 / 3 / moves.fineness**2) * np.mean(np.sum(slope**2, axis=-1))
    )
    return Fault(
        source="counts",
        deviation=apart,
        measure="rms",
        closed=float(np.sqrt(square)),
        remedies=(("count", 1 / 2),),
    )


@checked
def ripple_fault(plan: Plan):
    """Return the `Fault` of a feed that is even over each move: along the path, not across.

    Its deviation is how far the lines between setpoints are ahead of the planned way.
    """
    check_unheld(plan)
    torus = plan.circuit.machine.torus
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    wanted = plan.route.at(plan.reached)
    off = _between(plan, plan.setpoints) - wanted
    direction = plan.route.at(plan.reached, order=1)
    along = dot(levers(torus, wanted) * off, levers(torus, wanted) * direction)
    # A mean speed in place of one that changes by dv over a move of N ticks: dv N T / 8 amid it.
    lever = levers(torus, wanted[ends])
    speed = dot(lever * np.gradient(wanted, axis=0)[ends], lever * direction[ends])[:-1]
    return Fault(
        source="feed ripple",
        deviation=along,
        measure="largest",
        closed=float(np.max(np.abs(np.diff(speed)) * plan.ticks[:-1] / 8)),
        remedies=(("step", 2**-0.5), ("acceleration", 1 / 2)),
        along=True,
    )


@checked
def following_fault(plan: Plan, plant: Plants, loop: Loops):
    """Return the `Fault` of axes that trail their exact set-values, with ideal encoders.

    Parameters
    ----------
    plan : Plan
        What is to be done; here it may wait.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral and dead band.

    Returns
    -------
    fault : Fault
        Its closed form is the series to second order, for slow motion and without waits; None
        where a plant has no linear form.
    """
    check_ticks(plan, loop)
    check_linear(loop)
    circuit = plan.circuit
    wanted = circuit.position(plan.places)
    deviation = _followed(plan, plant, _ideal(loop), wanted)
    closed = None
    factor = 2.0
    with suppress(NoLinearForm):
        first, second = trailing(plan, plant, loop)
        closed = float(np.abs(first + second).max())
        # The gain that leaves half, with delays no power of a factor: looked for among factors.
        factors = np.geomspace(1, 10, 200)
        left = (np.abs(first / factor + second / factor**2).max() for factor in factors)
        halved = (f for f, worst in zip(factors, left, strict=True) if worst <= closed / 2)
        factor = float(next(halved, factor))
    return Fault(
        source="following",
        deviation=deviation,
        measure="largest",
        closed=closed,
        remedies=(("gain", factor), ("feed", 2**-0.5), ("power", 2**-0.5)),
    )


@checked
def encoder_fault(plan: Plan, plant: Plants, loop: Loops):
    """Return the `Fault` of encoders with whole counts, beyond that of ideal ones.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral and dead band.

    Returns
    -------
    fault : Fault
        Up to the rest at the lap's end, where one rounding stays for good. Its closed form is None
        where a plant has no linear form.
    """
    check_ticks(plan, loop)
    check_linear(loop)
    circuit = plan.circuit
    wanted = circuit.position(plan.places[: -plan.ticks[-1]])
    with_counts = _followed(plan, plant, loop, wanted)
    without = _followed(plan, plant, _ideal(loop), wanted)
    middle, rates, _ = planned_motion(plan)
    at = circuit.position(middle)
    slope = gradient(circuit, middle, at)
    closed = None
    with suppress(NoLinearForm):
        square = 0.0
        for axis, control, f, rate, q in zip(plant, loop, slope.T, rates.T, at.T, strict=True):
            passed = (f * control.count) ** 2 * rounding_passed(axis, control, rate, q)
            square += np.average(passed[:-1], weights=plan.ticks[:-1])
        closed = float(np.sqrt(square))
    return Fault(
        source="encoder",
        deviation=with_counts - without,
        measure="rms",
        closed=closed,
        remedies=(("encoder", 1 / 2),),
    )


@checked
def pose_fault(plan: Plan, pose: Pose):
    """Return the `Fault` of a machine that stands elsewhere, in a `Pose`, and doesn't know."""
    circuit = plan.circuit
    wanted = circuit.position(plan.places)
    centre = plan.centres(wanted, pose=pose)
    off = -circuit.profile.depth(centre[:, 1], centre[:, 2])
    # A small turn moves a point by its cross product with the arm from the centre of the turn.
    arm = plan.centres(wanted) - circuit.in_tunnel(np.zeros(3))
    moved = np.cross([pose.roll, pose.pitch, pose.yaw], arm) + np.array([0.0, pose.y, pose.z])
    normal = circuit.profile.normal(plan.places)
    closed = float(np.abs(dot(moved[:, 1:], normal)).max())
    return Fault(
        source="pose", deviation=off, measure="largest", closed=closed, remedies=(("pose", 1 / 2),)
    )


class _Segments(NamedTuple):
    """The moves between knots: arc lengths and positions amid them, chords and their directions."""

    middle: np.ndarray
    length: np.ndarray
    direction: np.ndarray
    position: np.ndarray


def _segments(plan):
    circuit = plan.circuit
    ends = np.append(plan.knots, circuit.profile.perimeter)
    at = circuit.position(ends)
    middle = (ends[1:] + ends[:-1]) / 2
    points = circuit.machine.torus.point(at[:, 0], at[:, 1])
    chord = np.diff(points, axis=0)
    length = norm(chord)
    return _Segments(middle, length, chord / length[:, None], circuit.position(middle))


def _geodesics(plan):
    """Return the `Route` of geodesics between the plan's knots, with sharp corners."""
    torus = plan.circuit.machine.torus
    way = lambda p, q, n: geodesic_inverse(torus, p, q).points(n).position  # noqa: E731
    return route_through(plan.circuit, plan.knots, way=way)


def _sharp(plan):
    """Return the plan's `Route` with sharp corners."""
    way = path_points(plan.circuit.machine.torus, plan.path)
    return route_through(plan.circuit, plan.knots, way=way)


def _between(plan, at):
    """Return positions (ticks + 1, 2) of straight lines in joint space between setpoints."""
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    ticks = np.arange(ends[-1] + 1)
    return np.stack([np.interp(ticks, ends, axis) for axis in at.T], axis=-1)


def _overbreak(plan, way):
    """Return the overbreak (ticks + 1,), in m, where another way has the places of each tick."""
    return plan.circuit.overbreak(way.at(way.length_at(plan.places)))


def _followed(plan, plants, loops, wanted):
    """Return the overbreak (n,), in m, of axes that follow positions (n, 2), one a tick."""
    rates = np.diff(wanted, axis=0) / plan.tick
    return plan.circuit.overbreak(follow(plants, loops, wanted, slopes=rates).position)


def _ideal(loops):
    """Return the loops with encoders that don't round."""
    return [replace(loop, count=0.0) for loop in loops]
