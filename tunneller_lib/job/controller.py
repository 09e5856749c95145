"""The motion generator of section 4.4 with its two loops, as an engineer loads it into a PLC.

The blocks are in controller.st, static_inverse.st and line.st. Here are a job's numbers: tables and
constants, and the proof that with them the slow task is in time and nothing leaves 32 bits.
"""

import math
import re
from dataclasses import dataclass, replace
from importlib.resources import files

import numpy as np

from ..arguments import checked
from ..motion import follow
from ..motion.export import constant_rows, line_text, operations, read_blocks
from ..ream.cutting import whole_run
from ..ream.moves import MOST, levers
from ..ream.planning import Plan
from .reader import Job

INCLUDE = '{#include "blocks.st"}\n'
FULL = 2**15  # of the time scale
SLOW = 10e-3  # s between calls of the slow task, or a tick where that is longer
FASTEST = 2**16 - 2  # counts in a tick, whose product with FULL has 32 bits
RINGS = [2**n for n in range(5, 13)]  # setpoints ahead that may be asked for
OPERATIONS = 1e6  # of the slow task in a second, unless the job tells
TRIP = 1 / 4  # of the depth of cut, unless the job tells
TRIED = 2000  # moves from which stopping is tried
MORE = 1.5  # times what the loops leave without a fault, for the least trip
PLAIN = "rValve := rRate / job.aSpeed[nAxis];\n"
# Of each that a tick must allow: how much at most, the margin of the tick that a refusal names, and
# what is said of what is found. The first allows no longer tick, the others no shorter one.
# The ticks of a run have 32 bits anyway: the planner's are 5 million at most.
CHECKS = [
    (FASTEST, 1.1, "in one a joint moves {:.0f} counts, and may move {}"),
    (1, 1.1, "a change of time scale takes {:.3g} ticks, and may take {}"),
    (FULL, 1.5, "to stop takes {} ticks, and may take {}"),
    (RINGS[-1], 2, "{} setpoints must be ahead, and the controller has room for {}"),
]


@dataclass(frozen=True, eq=False)
class Program:
    """A job's motion generator.

    Parameters
    ----------
    text : str
        In Structured Text: contract, tables and tasks. It includes the `blocks`.
    blocks : str
        The function blocks in Structured Text.
    tick : float
        Period of the fast task, in s.
    slow : int
        Ticks from one call of the slow task to the next.
    trip : float
        Following error at the cutter that shuts the valves, in m.
    """

    text: str
    blocks: str
    tick: float
    slow: int
    trip: float

    @property
    def whole(self):
        """The text with its blocks in the place where it includes them."""
        return self.text.replace(INCLUDE, self.blocks)


@checked
def program(plan: Plan, job: Job):
    """Return the `Program` of a job.

    Parameters
    ----------
    plan : Plan
        The job's, ``job.planned``.
    job : Job
        For its axes, loops and bounds.

    Returns
    -------
    program : Program
        What `controller_texts` writes in other languages.

    Raises
    ------
    ValueError
        If a loop has an integral, or the controller can't keep what the plan asks of it; the
        sentence names the key of the job and a value that it can keep.
    """
    if any(loop.integral for loop in job.axes[1]):
        raise ValueError("[controller] integral: must be 0 for the exported loop; got one above.")
    parts = min(moves.fineness for moves in (plan, plan.entry, plan.leave))
    # Of entry, a lap and exit: ends (m + 1, 2) in parts of a count, and ticks (m,).
    runs = plan.entry, plan, plan.leave
    setpoints = np.concatenate([plan.entry.setpoints[:1], *(run.setpoints[1:] for run in runs)])
    ends = np.rint(parts / plan.count * setpoints).astype(np.int64)
    ticks = np.concatenate([run.ticks for run in runs])
    ramps, longest = _ramps(plan, plan.count / parts * ends, ticks)
    stopping = _stopping(ticks, ramps) if longest <= 1 else int(FULL * longest)
    ahead, slow, at_once = _throughput(plan, stopping)
    fastest = float((np.abs(np.diff(ends, axis=0)) / (parts * ticks[:, None])).max())
    _check_tick(plan, (fastest, longest, stopping, ahead))
    ring = next(size for size in RINGS if size >= ahead)
    trip = _trip(plan, job)
    # The way to the start position: from where a trip isn't yet and a set-value off by another may
    # be, at half of the feed at most, and with room to stop.
    machine = plan.circuit.machine
    way = 2 * np.sqrt(2) * trip
    approach = max(2 * stopping, math.ceil(2 * way / (plan.limits.feed * plan.tick)))
    farthest = np.abs(ends).max() / parts + way / (machine.R * plan.count)
    while max(approach, farthest) * parts > MOST:
        parts //= 2
    change = int(FULL * plan.limits.acceleration * plan.tick**2 * approach / way)
    ramps = np.concatenate([[[min(change, FULL)] * 2], ramps])
    first = 1 + len(plan.entry.ticks)
    ramps[[1, first], 0] = FULL  # from rest as planned, also behind a step
    constants = {
        "nParts": parts, "nRing": ring, "nAtOnce": at_once, "nStopping": stopping,
        "rStopping": FULL / stopping, "nFirst": first, "nExit": first + len(plan.ticks),
        "nRows": len(ramps), "nLaps": plan.laps, "rCount": plan.count,
        "rPart": plan.count / parts, "rPace": plan.count / parts / plan.tick,
        "rEncoder": float(job.axes[1][0].count or plan.count), "rFar": float(MOST // parts),
        "rRingRadius": float(machine.r), "aStart": plan.entry.setpoints[0].tolist(),
        "aTrip": (trip / _arms(machine)).tolist(),  # rad of each joint
        "aTicks": [approach, *ticks.tolist()], "aFree": ramps[:, 0].tolist(),
        "aCorner": (ramps[:, 1] - ramps[:, 0]).tolist(),
    }  # fmt: skip
    theta, phi = (_axis(*axis) for axis in zip(*job.axes, strict=True))
    constants |= {key: [float(theta[key]), float(phi[key])] for key in theta} | chord_rows(plan)
    text, blocks, inverse = (
        files(__package__).joinpath(f"{name}.st").read_text(encoding="utf-8")
        for name in ("controller", "blocks", "static_inverse")
    )
    oil, valve = ("", PLAIN) if "aSpeed" in theta else inverse.split("@\n")
    for name, part in (("LINE", line_text()), ("OIL", oil), ("VALVE", valve)):
        blocks = blocks.replace(f"@{name}\n", part)
    setpoints = next(one for one in read_blocks(blocks) if one.name == "FB_Setpoints")
    cost = at_once * operations(setpoints)
    second = cost / (slow * plan.tick)
    _check("[controller] operations: the slow task takes {:.3g} a second; got {:g}, {:.2g}",
           second, job.controller.get("operations", OPERATIONS), 1.1 * second)  # fmt: skip
    tick = round(1e9 * plan.tick)  # ns
    words = {
        "FAST": f"{1e3 * plan.tick:g}", "SLOW": f"{1e3 * slow * plan.tick:g}", "LAST": ring - 1,
        "EVERY": _interval(tick), "SELDOM": _interval(slow * tick), "COST": cost,
        "TRIP": f"{1e3 * trip:.2g}", "JOB": constant_rows(constants),
    }  # fmt: skip
    text = re.sub(r"@([A-Z]+)", lambda found: str(words[found[1]]), text)
    return Program(text, blocks, plan.tick, slow, trip)


def chord_rows(plan):
    """Return what the slow task needs for setpoints: a dict of lists, of moves and of knots.

    Each setpoint is the foot of a point M (section 3.3.1): on a chord between two knots at a share
    of it, and shifted aside where the path is corrected or its corner rounded. Those of entry and
    exit are knots.
    """
    torus = plan.circuit.machine.torus
    way = plan.route
    along = plan.reached[np.cumsum(plan.ticks)]
    knot, _, _ = way.rounding(along)
    at = plan.circuit.position(way.places)
    at[-1] = at[0]
    points = torus.point(*at.T)
    normals = torus.normal(*at.T)
    chords = np.diff(points, axis=0)
    aside = np.cross(normals[:-1] + normals[1:], chords)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    # M is where the plane of chord and normals, moved aside, meets the normal line of its foot; by
    # nothing for the projected chord amid its chord.
    feet = plan.setpoints[1:].T
    frame = np.stack([chords[knot], aside[knot], -torus.normal(*feet)], axis=-1)
    off = torus.point(*feet) - points[knot]
    share, shift, _ = np.linalg.solve(frame, off[..., None])[..., 0].T
    straight = torus.point(*np.concatenate([plan.entry.setpoints, plan.leave.setpoints[1:]]).T)
    own = len(chords) + np.arange(len(straight))
    entry, leave = len(plan.entry.setpoints), len(plan.leave.ticks)
    rows = {
        "aKnot": np.concatenate([own[:entry], knot, own[entry:]]),
        "aShare": np.pad(share, (entry, leave)), "aShift": np.pad(shift, (entry, leave)),
    }  # fmt: skip
    chords, aside = (np.pad(one, ((0, len(straight)), (0, 0))) for one in (chords, aside))
    points = np.concatenate([points[:-1], straight])
    for name, values in (("aKnot", points), ("aChord", chords), ("aAside", aside)):
        rows |= {f"{name}{axis}": values[:, k] for k, axis in enumerate("XYZ")}
    return {name: values.tolist() for name, values in rows.items()}


def _check(said, found, most, would_do):
    """Raise ValueError where what is found is above what is allowed."""
    if found > most:
        raise ValueError(f"{said.format(found, most, would_do)} would do.")


def _check_tick(plan, found):
    """Check what is found against `CHECKS`; the tick that is named is allowed by all of them.

    Where they allow none, a coarser count is named.
    """
    needed = [margin * one / most for (most, margin, _), one in zip(CHECKS, found, strict=True)]
    most, least = plan.tick / needed[0], plan.tick * max(needed[1:])
    _check("[plan] count: the tick must be {:.2g} s, and at most {:.2g} s; {:.2g} rad",
           least, most, 1.2 * plan.count * least / most)  # fmt: skip
    for at, (allowed, _, said) in enumerate(CHECKS):
        _check(f"[plan] tick: {said}; {{:.2g}} s", found[at], allowed, least if at else most)


def _ramps(plan, angles, ticks):
    """Return by how much the time scale may change (m, 2) in a scan, and the ticks for the least.

    Amid it, and by how much it may fall at its begin at full scale. The scale s may become s + d
    where rates V become W, if d W + s (W - V) is within the acceleration: at s = 1 that is a
    quadratic equation, at s = 0 a quotient, and between them the fast task takes what is between.
    It rises by what the plan leaves, were W - V all the acceleration.
    """
    lever = levers(plan.circuit.machine.torus, angles[:-1])
    rates = np.diff(angles, axis=0) / ticks[:, None]
    now = lever * rates
    change = now - lever * np.concatenate([np.zeros((1, 2)), rates[:-1]])
    most = plan.limits.acceleration * plan.tick**2
    square = np.sum(now**2, axis=-1)
    along = np.sum(now * change, axis=-1)
    root = np.sqrt(along**2 + square * np.maximum(most**2 - np.sum(change**2, axis=-1), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.stack([most / np.sqrt(square), (root + along) / square], axis=-1)
    found[square == 0] = 1.0
    longest = float(1 / (FULL * found[:, 0].min()))
    found = np.floor(FULL * np.clip(found, 0.0, 1.0)).astype(np.int64)
    return np.minimum(found, found[:, :1]), longest


def _stopping(ticks, ramps):
    """Return of how many ticks the known moves must be, in which the time scale falls to rest.

    As many as from the fastest move at the constant acceleration, or more. A quarter more is for
    runs that begin amid a move.
    """
    stopping = FULL // (2 * int(ramps[:, 0].min())) + 2
    while stopping <= FULL and not _rests(ticks, ramps, stopping):
        stopping = int(1.1 * stopping) + 1
    return int(1.25 * stopping) + 1


def _rests(ticks, ramps, known):
    """Return whether a run comes to rest in so many known ticks, its changes those of a scan.

    Tried from the begin of moves all along, at full scale, with no further setpoint: the scale is
    led to the root of what is left, as the fast task does.
    """
    of_tick = np.repeat(np.arange(len(ticks)), ticks)
    begins = np.cumsum(ticks) - ticks
    begins = begins[:: 1 + len(ticks) // TRIED]
    at = FULL * begins[begins + known <= len(of_tick)]  # ticks times FULL
    end = at + FULL * known
    scale = np.full(len(at), FULL)
    was = np.full(len(at), -1)
    while len(at):
        row = of_tick[at // FULL]
        after = of_tick[np.minimum(at // FULL + 1, end // FULL - 1)]
        free = ramps[row, 0]
        most = np.minimum(
            np.where(row != was, _between(ramps[row], scale), free),
            np.where((row != after) & (at % FULL > 0), _between(ramps[after], scale), FULL),
        )
        wanted = np.sqrt((end - at) * (FULL / known)).astype(np.int64)
        before, scale = scale, np.clip(np.minimum(wanted, FULL), scale - most, scale + most)
        moved = np.minimum(scale, end - at)  # where nothing is left it stands
        at, was = at + scale, row
        if np.any((at >= end) & (np.maximum(before - moved, moved) > free)):
            return False
        goes = (scale > 0) & (at < end)
        at, end, scale, was = (values[goes] for values in (at, end, scale, was))
    return True


def _between(ramps, scale):
    """Return by how much a scale may fall at the begin of moves: between what it may at 0 and 1."""
    return ramps[:, 0] + (ramps[:, 1] - ramps[:, 0]) * scale // FULL


def _throughput(plan, stopping):
    """Return the setpoints that must be ahead, the slow task's period in ticks, and its a call.

    At full scale a call prepares as many as were taken since the one before, so that the ring is
    full again; between two calls the setpoints ahead don't fall short of the stopping ticks.
    """
    slow = max(round(SLOW / plan.tick), 1)
    lap = np.tile(plan.ticks, min(plan.laps, 2))
    ends = np.cumsum(np.concatenate([[0], plan.entry.ticks, lap, plan.leave.ticks]))
    # Setpoints that must be known at each end: those to stop in, and while the slow task waits.
    number = np.arange(len(ends))
    ahead = int((np.searchsorted(ends, ends + stopping + 2 * slow) - number).max()) + 3
    return ahead, slow, int((np.searchsorted(ends, ends + slow) - number).max())


def _trip(plan, job):
    """Return the following error that shuts the valves, in m at the cutter."""
    plants, loops = job.axes
    setvalues, slopes = whole_run(replace(plan, laps=1))
    track = follow(plants, loops, setvalues, slopes=slopes)
    # As the controller has it: theta's by the longest arm.
    off = np.abs(track.setvalue - track.position) * _arms(plan.circuit.machine)
    least = MORE * float(off.max())
    trip = float(job.controller.get("trip", TRIP * plan.circuit.machine.depth))
    _check("[controller] trip: {:.2g} m are needed without a fault; got {:.2g} m, {:.2g} m",
           least, trip, 1.1 * least)  # fmt: skip
    return trip


def _arms(machine):
    """Return the cutter's greatest way (2,) by a radian of each joint, in m."""
    return np.array([machine.r + machine.R, machine.R])


def _axis(plant, loop):
    """Return the constants of an axis' loop and static inverse by their names."""
    axis = plant.hydraulics
    found = {"aGain": loop.gain, "aForward": loop.feedforward}
    if axis is None:
        return found | {"aSpeed": plant.gain}
    link = axis.linkage
    plus, minus = link.areas[:: 1 if link.sense > 0 else -1]
    return found | {
        "aSense": link.sense, "aMounting": link.mounting, "aApart": (link.a - link.b) ** 2,
        "aTwice": 2 * math.sqrt(link.a * link.b), "aProduct": link.a * link.b,
        "aSecond": link.pair * link.a * link.b, "aAreaPlus": plus, "aAreaMinus": minus,
        "aGravity": axis.gravity, "aDamping": axis.damping, "aSupply": axis.supply,
        "aTank": axis.tank, "aFlow": axis.flow,
    }  # fmt: skip


def _interval(time):
    """Return a task's interval of so many ns; iec2c reads it in single precision, and truncates."""
    whole, rest = divmod(time, 10**6)
    return f"T#{whole}.{rest:06d}49ms" if rest else f"T#{whole}ms"
