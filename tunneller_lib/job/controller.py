"""The motion generator of section 4.4 with its two loops, as an engineer loads it into a PLC.

Contract and tasks are in controller.st, the blocks in blocks.st, static_inverse.st and line.st.
Here are a job's numbers, and the proof that with them the slow task is in time and nothing leaves
32 bits.
"""

import re
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from ..arguments import checked
from ..motion.export import constant_rows, line_text, operations, read_blocks
from ..ream.moves import MOST, levers
from ..ream.planning import Plan
from .checks import fully_open, short, with_remedy
from .reader import Job

FULL = 2**15  # of the time scale
SLOW = 10e-3  # s between calls of the slow task, or a tick where that is longer
FASTEST = 2**16 - 2  # counts in a tick, whose product with FULL has 32 bits
RINGS = [2**n for n in range(5, 13)]  # setpoints ahead that may be asked for
OPERATIONS = 1e6  # of the slow task in a second, unless the job tells
TRIP = 1 / 4  # of the depth of cut, unless the job tells
TRIED = 2000  # moves from which stopping is tried
MORE = 1.5  # times what the loops leave without a fault, for the least trip
PLAIN = "rValve := rRate / job.aSpeed[nAxis];\n"


class Program(NamedTuple):
    """A job's motion generator.

    Parameters
    ----------
    text : str
        Contract, tables and tasks in Structured Text, which includes the `blocks` as blocks.st.
    blocks : str
        The function blocks in Structured Text.
    slow : int
        Ticks from one call of the slow task to the next.
    trip : float
        Following error at the cutter that shuts the valves, in m.
    """

    text: str
    blocks: str
    slow: int
    trip: float


class Exported(NamedTuple):
    """What a job's cut has for a controller.

    Parameters
    ----------
    program : Program or None
        The motion generator, if the job's plan has one.
    left_out : str
        Else why there is none, as a sentence.
    """

    program: Program | None
    left_out: str


def exported(job):
    """Return the `Exported` of a `Job`: what only its controller can't keep isn't refused."""
    try:
        return Exported(program(job.planned, job), "")
    except ValueError as error:
        return Exported(None, f"the controller's files are left out; {error}")


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
        If the controller can't keep what the plan asks of it; the sentence names the key of the
        job and a value that it can keep.
    """
    runs = plan.entry, plan, plan.leave
    parts = min(run.fineness for run in runs)
    # Of entry, a lap and exit: ends (m + 1, 2) in parts of a count, and ticks (m,).
    setpoints = np.concatenate([plan.entry.setpoints[:1], *(run.setpoints[1:] for run in runs)])
    ends = np.rint(parts / plan.count * setpoints).astype(np.int64)
    ticks = np.concatenate([run.ticks for run in runs])
    ramps = _ramps(plan, plan.count / parts * ends, ticks)
    stopping = _stopping(ticks, ramps)
    ahead, slow, at_once = _throughput(plan, stopping)
    # Both checks of the tick allow the one that is named. The ticks of a run have 32 bits anyway:
    # they are 5 million at most.
    least = 2 * plan.tick * max(stopping / FULL, ahead / RINGS[-1])
    _check("[plan] tick: to stop takes {} ticks, and may take {}; {:.2g} s", stopping, FULL, least)
    _check("[plan] tick: {} setpoints must be ahead, and the controller has room for {}; {:.2g} s",
           ahead, RINGS[-1], least)  # fmt: skip
    fastest = (np.abs(np.diff(ends, axis=0)) / (parts * ticks[:, None])).max()
    _check("[plan] count: in a tick a joint moves {:.0f}, and may move {}; {:.2g} rad",
           fastest, FASTEST, 1.1 * plan.count * fastest / FASTEST)  # fmt: skip
    text, blocks, inverse = (files(__package__).joinpath(f"{name}.st").read_text(encoding="utf-8")
                             for name in ("controller", "blocks", "static_inverse"))  # fmt: skip
    setpoints = next(one for one in read_blocks(blocks) if one.name == "FB_Setpoints")
    cost = at_once * operations(setpoints)
    second = cost / (slow * plan.tick)
    _check("[controller] operations: the slow task takes {:.3g} a second; got {:g}, {:.2g}",
           second, job.controller.get("operations", OPERATIONS), 1.1 * second)  # fmt: skip
    ring = next(size for size in RINGS if size >= ahead)
    machine = plan.circuit.machine
    arms = np.array([machine.r + machine.R, machine.R])  # the cutter's greatest way by a radian
    trip = _trip(job, arms)
    # The way to the start position: from where a trip isn't yet and a set-value off by another may
    # be, at half of the feed at most, and with room to stop.
    way = 2 * np.sqrt(2) * trip
    approach = max(2 * stopping, int(2 * way / (plan.limits.feed * plan.tick)) + 1)
    farthest = np.abs(ends).max() / parts + way / (machine.R * plan.count)
    while max(approach, farthest) * parts > MOST:
        parts //= 2
    change = min(plan.limits.acceleration * plan.tick**2 * approach / way, 1)
    ramps = np.floor(np.concatenate([[[FULL * change] * 2], ramps])).astype(int)
    first = 1 + len(plan.entry.ticks)
    constants = {
        "nParts": parts, "nRing": ring, "nAtOnce": at_once, "nStopping": stopping,
        "rStopping": FULL / stopping, "nFirst": first, "nExit": first + len(plan.ticks),
        "nRows": len(ramps), "nLaps": plan.laps, "rCount": plan.count,
        "rPart": plan.count / parts, "rPace": plan.count / parts / plan.tick,
        "rEncoder": float(job.axes[1][0].count or plan.count), "rFar": float(MOST // parts),
        "rRingRadius": float(machine.r), "aStart": plan.entry.setpoints[0],
        "aTrip": trip / arms, "aTicks": [approach, *ticks], "aFree": ramps[:, 0],
        "aCorner": ramps[:, 1] - ramps[:, 0],
    }  # fmt: skip
    theta, phi = (_axis(*axis) for axis in zip(*job.axes, strict=True))
    constants |= {key: [float(theta[key]), float(phi[key])] for key in theta} | chord_rows(plan)
    oil, valve = ("", PLAIN) if "aSpeed" in theta else inverse.split("@\n")
    words = {
        "FAST": f"{1e3 * plan.tick:g}", "SLOW": f"{1e3 * slow * plan.tick:g}", "LAST": ring - 1,
        "EVERY": _interval(plan.tick), "SELDOM": _interval(plan.tick, slow), "COST": cost,
        "TRIP": f"{1e3 * trip:.2g}", "JOB": constant_rows(constants),
        "LINE": line_text(parts=parts), "OIL": oil, "VALVE": valve,
    }  # fmt: skip
    text, blocks = (re.sub(r"@([A-Z]+)\n?", lambda found: str(words[found[1]]), one)
                    for one in (text, blocks))  # fmt: skip
    return Program(text, blocks, slow, trip)


def chord_rows(plan):
    """Return what the slow task needs for setpoints: a dict of arrays, of moves and of knots.

    Each setpoint is the foot of a point M (section 3.3.1), which lies on the chord between two
    knots at a share of its length, and is shifted aside where the path is corrected or its corner
    rounded. The setpoints of entry and exit are knots themselves.
    """
    torus = plan.circuit.machine.torus
    knot, _, _ = plan.route.rounding(plan.reached[np.cumsum(plan.ticks)])
    at = plan.circuit.position(plan.route.places)
    at[-1] = at[0]
    points = torus.point(*at.T)
    normals = torus.normal(*at.T)
    chords = np.diff(points, axis=0)
    aside = np.cross(normals[:-1] + normals[1:], chords)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    # M is where the plane of chord and normals, moved aside, meets the normal line of its foot. For
    # the projected chord amid its chord the plane isn't moved.
    feet = plan.setpoints[1:].T
    frame = np.stack([chords[knot], aside[knot], -torus.normal(*feet)], axis=-1)
    off = torus.point(*feet) - points[knot]
    share, shift, _ = np.linalg.solve(frame, off[..., None])[..., 0].T
    straight = torus.point(*np.concatenate([plan.entry.setpoints, plan.leave.setpoints[1:]]).T)
    entry, leave = np.split(len(chords) + np.arange(len(straight)), [len(plan.entry.setpoints)])
    around = len(entry), len(leave)
    rows = {"aKnot": np.concatenate([entry, knot, leave]), "aShare": np.pad(share, around),
            "aShift": np.pad(shift, around)}  # fmt: skip
    tables = {"aKnot": np.concatenate([points[:-1], straight])}
    for name, values in (("aChord", chords), ("aAside", aside)):
        tables[name] = np.pad(values, ((0, len(straight)), (0, 0)))
    return rows | {f"{name}{axis}": values[:, k] for name, values in tables.items()
                   for k, axis in enumerate("XYZ")}  # fmt: skip


def _check(said, found, most, would_do):
    """Raise ValueError if what is found is above what is allowed."""
    if found > most:
        raise ValueError(f"{said.format(found, most, would_do)} would do.")


def _ramps(plan, angles, ticks):
    """Return by how much the time scale may change in a scan (m, 2).

    The first number is for a scan amid a move, the second, which isn't above it, for a fall from
    full scale where the move begins. The scale s may become s + d where rates V become W, if
    d W + s (W - V) is within the acceleration: at s = 1 that is a quadratic equation, at s = 0 a
    quotient, and the fast task interpolates between them. A rise may take what the plan leaves if
    W - V is all of the acceleration.
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
    found[[0, len(plan.entry.ticks)], 0] = 1.0  # from rest as planned, also behind a step
    return FULL * np.clip(np.minimum(found, found[:, :1]), 0.0, 1.0)


def _stopping(ticks, ramps):
    """Return how many ticks must be known ahead, so that the time scale falls to rest in them.

    They are as many as a stop from the fastest move takes at constant acceleration, or more. A
    quarter is added for stops that begin amid a move.
    """
    least = ramps[:, 0].min()  # below 1 the scale can't change
    stopping = int(FULL / (2 * least if least >= 1 else least)) + 2
    while 1.25 * stopping <= FULL and not _rests(ticks, ramps, stopping):
        stopping = int(1.1 * stopping) + 1
    return int(1.25 * stopping) + 1


def _rests(ticks, ramps, known):
    """Return whether the time scale falls to rest in so many known ticks.

    A stop is tried from the begin of each of many moves, at full scale and with no further
    setpoint: as in the fast task, the scale follows the root of what is left. Here each scan of a
    move's first tick, not the first one alone, may change the scale only by what the begin of the
    move leaves.
    """
    begins = np.cumsum(ticks) - ticks
    free, corner = np.floor(ramps).astype(int).T
    less = np.zeros(ticks.sum(), int)  # of each tick, where a move begins
    less[begins] = corner - free
    free = np.repeat(free, ticks)
    begins = begins[:: 1 + len(ticks) // TRIED]
    at = FULL * begins[begins + known <= len(free)]  # ticks times FULL
    end = at + FULL * known
    scale = np.full(len(at), FULL)
    while len(at):
        tick = at // FULL
        after = np.minimum(-(-at // FULL), end // FULL - 1)
        most = np.minimum(*(free[k] + less[k] * scale // FULL for k in (tick, after)))
        wanted = np.sqrt((end - at) * (FULL / known)).astype(np.int64)
        before, scale = scale, np.clip(np.minimum(wanted, FULL), scale - most, scale + most)
        moved = np.minimum(scale, end - at)  # where nothing is left it stands
        at = at + scale
        if np.any((at >= end) & (np.maximum(before - moved, moved) > free[tick])):
            return False
        goes = (scale > 0) & (at < end)
        at, end, scale = at[goes], end[goes], scale[goes]
    return True


def _throughput(plan, stopping):
    """Return setpoints that must be ahead, the slow task's period in ticks, and setpoints a call.

    At full scale a call prepares as many as were taken since the call before it, so that the ring
    is full again. Between two calls the setpoints ahead cover the stopping ticks.
    """
    slow = max(round(SLOW / plan.tick), 1)
    lap = np.tile(plan.ticks, min(plan.laps, 2))
    ends = np.cumsum(np.concatenate([[0], plan.entry.ticks, lap, plan.leave.ticks]))
    # Setpoints that must be known at each end: those to stop in, and while the slow task waits.
    number = np.arange(len(ends))
    ahead = int((np.searchsorted(ends, ends + stopping + 2 * slow) - number).max()) + 3
    return ahead, slow, int((np.searchsorted(ends, ends + slow) - number).max())


def _trip(job, arms):
    """Return the following error that shuts the valves, in m at the cutter.

    A valve that is fully open comes before the trip that its error would take, and no trip above
    the depth of cut is proposed: then another key is at fault.
    """
    least, trip = _least_trip(job, arms), _wanted_trip(job)
    if least <= trip:
        return trip
    depth = job.made.depth
    would_do = short(1.1 * least)
    opened = fully_open(job.in_air)
    if would_do <= depth and not opened:
        raise ValueError(
            f"[controller] trip: {least:.2g} m are needed without a fault; got {trip:.2g} m, "
            f"{would_do:g} m would do."
        )
    asks = f"the following error asks for a trip of {least:.2g} m in a cut {depth:g} m deep"
    kept = lambda other: _least_trip(other, arms) <= max(_wanted_trip(other), TRIP * depth)  # noqa: E731
    raise ValueError(with_remedy(job, f"{opened}, and {asks}" if opened else asks, kept))


def _least_trip(job, arms):
    """Return the least trip without a fault, in m; theta's error counts by the longest arm."""
    track = job.in_air
    return MORE * float((np.abs(track.setvalue - track.position) * arms).max())


def _wanted_trip(job):
    """Return the trip that a job asks for, in m."""
    return float(job.controller.get("trip", TRIP * job.made.depth))


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
        "aTwice": 2 * np.sqrt(link.a * link.b), "aProduct": link.a * link.b,
        "aSecond": link.pair * link.a * link.b, "aAreaPlus": plus, "aAreaMinus": minus,
        "aGravity": axis.gravity, "aDamping": axis.damping, "aSupply": axis.supply,
        "aTank": axis.tank, "aFlow": axis.flow,
    }  # fmt: skip


def _interval(tick, many=1):
    """Return an interval of so many ticks, each in whole ns.

    The digits 49 are for iec2c, which reads it in single precision and truncates.
    """
    whole, rest = divmod(many * round(1e9 * tick), 10**6)
    return f"T#{whole}.{rest:06d}49ms" if rest else f"T#{whole}ms"
