"""Whose fault is which part of the wall's error: each source switched on alone, and its form."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import instance
from ..exact import dot, norm
from ..motion import follow, polyline
from ..paths import geodesic_inverse, project_chord
from .plan import Plan, join_knots
from .sensitivity import (
    geodesic_bend,
    gradient,
    joint_bend,
    planned_motion,
    rounding_passed,
    trailing,
    wall_frame,
)
from .simulate import matching_loops


@dataclass(frozen=True)
class Fault:
    """One source of error, alone.

    Parameters
    ----------
    source : str
        What is switched on; everything else is ideal.
    deviation : (ticks + 1,) float
        Over-break that it leaves at each tick of a lap, in m; negative under-break.
    measure : {"largest", "rms"}
        What the closed form says.
    closed : float
        The closed form, in m.
    halved_by : str
        What must change for half of it.
    factor : float
        By how much: the error goes with a power of it.
    """

    source: str
    deviation: np.ndarray
    measure: str
    closed: float
    halved_by: str
    factor: float

    @property
    def over(self):
        """Return the greatest over-break, in m, at least 0."""
        return max(0.0, float(self.deviation.max()))

    @property
    def under(self):
        """Return the greatest under-break, in m, at least 0."""
        return max(0.0, float(-self.deviation.min()))

    @property
    def rms(self):
        """Return the root mean square over the lap, in m."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    @property
    def measured(self):
        """Return what `closed` is to be held against, in m."""
        return self.rms if self.measure == "rms" else max(self.over, self.under)


def budget(plan, plant, loop, *, pose=None, say=None):
    """Return the faults of a planned lap, each switched on alone.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant, loop : pairs
        The axes theta and phi and their position loops.
    pose : Pose, optional
        Where the machine stands instead of where it should.
    say : function, optional
        Told which source is next.

    Returns
    -------
    faults : list of Fault
        Knots, tangent spheres, set-points, counts, following, encoder and, if asked for, pose.
        Their deviations add up to that of all together, but for corners: at a knot the path turns
        at once and a trailing axis cuts the corner, by more than its fault alone.

    Notes
    -----
    The ideal lap has the cutter's centre on the circuit at every tick of the plan.
    """
    instance("plan", plan, Plan)
    if np.any(np.diff(plan.s[:-1]) <= 0):
        raise ValueError("plan: must not wait between set-points; look at its `following` alone.")
    plants = list(plant) if isinstance(plant, Sequence) else [plant] * 2
    loops = matching_loops(plan, loop)
    sources = [(source, ()) for source in (knots, tangent_spheres, setpoints, counts)]
    sources += [(source, (plants, loops)) for source in (following, encoder)]
    if pose is not None:
        sources.append((standing_elsewhere, (pose,)))
    faults = []
    for number, (source, given) in enumerate(sources, start=1):
        if say is not None:
            say(f"budget: source {number} of {len(sources)}")
        faults.append(source(plan, *given))
    return faults


def knots(plan):
    """Return the fault of joining knots by true geodesics instead of following the circuit."""
    circuit, _, _, middle, length, direction, q = _segments(plan)
    sagitta = geodesic_bend(circuit, middle, q, direction) * length**2 / 8
    return Fault("knots", _overcut(plan, _waypoints(plan, True)), "largest",
                 float(np.abs(sagitta).max()), "knots", np.sqrt(2))  # fmt: skip


def tangent_spheres(plan):
    """Return the fault of tangent-sphere paths in place of geodesics between the same knots."""
    circuit, _, _, middle, length, direction, q = _segments(plan)
    torus = circuit.machine.torus
    bend, torsion = torus.normal_curvature(q, direction), torus.geodesic_torsion(q, direction)
    across = np.cross(torus.normal(q[:, 0], q[:, 1]), direction)
    law = np.abs(bend * torsion) * length**3 / (36 * np.sqrt(3))
    closed = law * np.abs(dot(across, wall_frame(circuit, middle)[0]))
    apart = _overcut(plan, _waypoints(plan, False)) - _overcut(plan, _waypoints(plan, True))
    return Fault("tangent spheres", apart, "largest", float(closed.max()), "knots", 2 ** (1 / 3))


def setpoints(plan):
    """Return the fault of straight lines in joint space between set-points on the circuit."""
    circuit = plan.circuit
    at = circuit.position(plan.s)
    middle = (plan.s[1:] + plan.s[:-1]) / 2
    move = np.diff(at, axis=0)
    sagitta = joint_bend(circuit, middle, circuit.position(middle), move) / 8
    return Fault("set-points", circuit.overcut(_between(plan, at)), "largest",
                 float(np.abs(sagitta).max()), "set-points", np.sqrt(2))  # fmt: skip


def counts(plan):
    """Return the fault of whole counts, of set-points and of each tick of their integer lines."""
    circuit = plan.circuit
    at = circuit.position(plan.s)
    rounded = plan.count * polyline(np.rint(at / plan.count).astype(np.int64), plan.ticks)
    apart = circuit.overcut(rounded) - circuit.overcut(_between(plan, at))
    slope = gradient(circuit, plan.places, plan.circuit.position(plan.places))
    # A set-point is off by a uniform half count, their mix on a line by 2/3 of its square, and
    # the line's own rounding adds one more.
    square = plan.count**2 / 12 * (1 + 2 / 3) * np.mean(np.sum(slope**2, axis=-1))
    return Fault("counts", apart, "rms", float(np.sqrt(square)), "count", 2.0)


def following(plan, plants, loops):
    """Return the fault of axes that trail their exact set-values, with ideal encoders.

    The closed form is the series to second order, for slow motion and without waits.
    """
    circuit, loops = plan.circuit, [replace(loop, count=0.0) for loop in _linear(plan, loops)]
    wanted = circuit.position(plan.places)
    track = follow(plants, loops, wanted, slopes=np.diff(wanted, axis=0) / plan.tick)
    first, second = trailing(plan, plants, loops)
    closed = np.abs(first + second).max()
    # The gain that leaves half, which with delays isn't a power's: looked for among factors.
    factors = np.geomspace(1, 10, 200)
    left = (np.abs(first / factor + second / factor**2).max() for factor in factors)
    halving = (factor for factor, worst in zip(factors, left, strict=True) if worst <= closed / 2)
    factor = float(next(halving, np.inf))
    return Fault(
        "following", circuit.overcut(track.position), "largest", float(closed), "gain", factor
    )


def encoder(plan, plants, loops):
    """Return the fault of encoders with whole counts, beyond that of ideal ones."""
    circuit, tick, loops = plan.circuit, plan.tick, _linear(plan, loops)
    wanted = circuit.position(plan.places[: -plan.ticks[-1]])  # at rest one rounding stays for good
    rate = np.diff(wanted, axis=0) / tick
    with_counts, without = (
        circuit.overcut(follow(plants, pair, wanted, slopes=rate).position)
        for pair in (loops, [replace(loop, count=0.0) for loop in loops])
    )
    middle, rates, _ = planned_motion(plan)
    slope = gradient(circuit, middle, circuit.position(middle))
    square = 0.0
    for plant, loop, f, rate in zip(plants, loops, slope.T, rates.T, strict=True):
        passed = (f * loop.count) ** 2 * rounding_passed(plant, loop, rate)
        square += np.average(passed[:-1], weights=plan.ticks[:-1])
    return Fault("encoder", with_counts - without, "rms", float(np.sqrt(square)), "count", 2.0)


def standing_elsewhere(plan, pose):
    """Return the fault of a machine that stands elsewhere and doesn't know."""
    circuit = plan.circuit
    wanted = circuit.position(plan.places)
    centre = plan.centres(wanted, pose=pose)
    off = -circuit.profile.depth(centre[:, 1], centre[:, 2])
    arm = plan.centres(wanted) - circuit.in_tunnel(np.zeros(3))
    moved = np.cross([pose.roll, pose.pitch, pose.yaw], arm) + np.array([0.0, pose.y, pose.z])
    normal = circuit.profile.normal(plan.places)
    closed = float(np.abs(dot(moved[:, 1:], normal)).max())
    return Fault("pose", off, "largest", closed, "pose", 2.0)


def _linear(plan, loops):
    """Return loops that the closed forms are for, or say why they aren't."""
    loops = matching_loops(plan, loops)
    if any(loop.integral or loop.dead_band for loop in loops):
        raise ValueError("loop: the closed forms are for loops without integral and dead band.")
    return loops


def _segments(plan):
    """Return circuit, ends, and middle, length, direction, position of the moves between knots."""
    circuit = plan.circuit
    ends = np.append(plan.knots, circuit.profile.perimeter)
    at = circuit.position(ends)
    middle = (ends[1:] + ends[:-1]) / 2
    points = circuit.machine.torus.point(at[:, 0], at[:, 1])
    chord = np.diff(points, axis=0)
    length = norm(chord)
    return circuit, ends, at, middle, length, chord / length[:, None], circuit.position(middle)


def _waypoints(plan, geodesic):
    """Return set-points (m + 1, 2) at equal arcs between knots, of geodesics or projected."""
    torus = plan.circuit.machine.torus
    first = np.searchsorted(plan.s[:-1], [*plan.knots, plan.circuit.profile.perimeter])
    at, moves = plan.circuit.position(plan.knots), np.diff(first)

    def way(p, q, n):
        if geodesic:
            return geodesic_inverse(torus, p, q).points(n).position
        return project_chord(torus, p, q, n, spacing="arc")

    return np.concatenate([join_knots(at, moves, way), at[:1]])


def _between(plan, at):
    """Return positions (ticks + 1, 2) of straight lines in joint space between set-points."""
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    ticks = np.arange(ends[-1] + 1)
    return np.stack([np.interp(ticks, ends, axis) for axis in at.T], axis=-1)


def _overcut(plan, at):
    """Return the over-break (ticks + 1,), in m, of set-points, interpolated in time."""
    ends = np.concatenate([[0], np.cumsum(plan.ticks)])
    return np.interp(np.arange(ends[-1] + 1), ends, plan.circuit.overcut(at))
