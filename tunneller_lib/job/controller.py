"""The motion generator of section 4.4 with its two loops, as an engineer loads it into a PLC.

The blocks are in controller.st and loop.st. Here are a job's numbers: tables and constants, and the
proof that with them the slow task is in time and nothing leaves 32 bits.
"""

import math
import re
import textwrap
from bisect import bisect_left
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from ..arguments import checked
from ..motion import follow
from ..motion.export import line_text, operations, read_blocks, with_constants
from ..ream.moves import MOST, levers
from ..ream.planning import Plan
from .reader import Job

FULL = 2**15  # of the time scale
SLOW = 10e-3  # s between calls of the slow task, or a tick where that is longer
LONGEST = 2**16 - 1  # ticks of stopping, and counts in a tick: times FULL within 32 bits
RINGS = [2**n for n in range(5, 13)]  # setpoints ahead that may be asked for
OPERATIONS = 1e6  # of the slow task in a second, unless the job tells
TRIP = 1 / 4  # of the depth of cut, unless the job tells
TRIED = 2000  # moves from which stopping is tried
MORE = 1.5  # times what the loops leave without a fault, for the least trip
AXES = "Theta", "Phi"
SHIFT = """        (* Of a corrected chord M lies beside the chord. *)
        rX := rX + aShift[nRow] * aAsideX[nKnot];
        rY := rY + aShift[nRow] * aAsideY[nKnot];
        rZ := rZ + aShift[nRow] * aAsideZ[nKnot];
"""


@dataclass(frozen=True, eq=False)
class Program:
    """A job's motion generator.

    Parameters
    ----------
    text : str
        In Structured Text, its tables and all.
    ring : int
        Setpoints that are ahead at most.
    tick : float
        Period of the fast task, in s.
    slow : int
        Ticks from one call of the slow task to the next.
    at_once : int
        Setpoints that such a call prepares at most.
    operations : int
        That it takes at most.
    stopping : int
        Ticks of known moves ahead below which the time scale falls.
    trip : float
        Following error at the cutter that shuts the valves, in m.
    """

    text: str
    ring: int
    tick: float
    slow: int
    at_once: int
    operations: int
    stopping: int
    trip: float


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
    plants, loops = job.axes
    if any(loop.integral for loop in loops):
        raise ValueError("[controller] integral: must be 0 for the exported loop; got one above.")
    trip = _trip(plan, job)
    parts = min(moves.fineness for moves in (plan, plan.entry, plan.leave))
    whole = _whole_run(plan, parts)
    _check_counts(plan, parts, whole)
    stopping = _stopping(plan, whole[1], _ramps(plan, parts, *whole))
    ring, slow, at_once = _throughput(plan, whole[1], stopping)
    # To the start position: from where a trip isn't yet and a set-value off by another may be, at
    # half of the feed at most, and with room to stop.
    way = 2 * np.sqrt(2) * trip
    approach = max(2 * stopping, math.ceil(2 * way / (plan.limits.feed * plan.tick)))
    farthest = np.abs(whole[0]).max() / parts + way / (plan.circuit.machine.R * plan.count)
    while max(approach, farthest) * parts > MOST:
        parts //= 2
    whole = _whole_run(plan, parts)
    rows = chord_rows(plan)
    machine = plan.circuit.machine
    first = plan.entry.setpoints[0]
    within = trip / _arms(machine)  # rad of each joint
    change = plan.limits.acceleration * plan.tick**2
    constants = {
        "nParts": parts, "nFull": FULL, "nRing": ring, "nAtOnce": at_once, "nStopping": stopping,
        "rStopping": FULL / stopping, "nMoves": len(plan.ticks), "nEntry": len(plan.entry.ticks),
        "nLeave": len(plan.leave.ticks), "nLaps": plan.laps, "nApproach": approach,
        "nFreeApproach": min(int(FULL * change * approach / way), FULL),
        "nFirstTheta": int(whole[0][0, 0]), "nFirstPhi": int(whole[0][0, 1]),
        "rCount": plan.count, "rPart": plan.count / parts,
        "rEncoder": float(loops[0].count or plan.count),
        "rTick": plan.tick, "rChange": change, "rRingRadius": float(machine.r),
        "rTubeRadius": float(machine.R),
    }  # fmt: skip
    for i, name in enumerate(AXES):
        constants |= {f"rStart{name}": float(first[i]), f"rTrip{name}": float(within[i])}
        constants |= {f"{key}{name}": value for key, value in _axis(plants[i], loops[i]).items()}
    text = _text(plan, plants, ring, slow, TRIP=f"{1e3 * trip:.2g}", STOPPING=stopping,
                 ATONCE=at_once, COST="@COST")  # fmt: skip
    setpoints = next(one for one in read_blocks(text) if one.name == "FB_Setpoints")
    cost = sum(operations(setpoints, nAtOnce=at_once))
    _check_operations(job, cost, slow)
    straight = [np.concatenate(pair).tolist() for pair in zip(
        _straight(plan.entry, parts), _straight(plan.leave, parts), strict=True)]  # fmt: skip
    names = "aStraightTicks", "aStraightTheta", "aStraightPhi"
    text = with_constants(
        text.replace("@COST", str(cost)), constants | rows | dict(zip(names, straight, strict=True))
    )
    return Program(text, ring, plan.tick, slow, at_once, cost, stopping, trip)


def chord_rows(plan):
    """Return what the slow task needs for a lap: a dict of lists, a row for each move.

    Each setpoint is the foot of a point M on a chord between two knots (section 3.3.1) at a share
    of the chord, moved by a weight times the knot's kink where the corner is rounded. For a
    corrected chord M is shifted aside.
    """
    torus = plan.circuit.machine.torus
    way = plan.route
    along = plan.reached[np.concatenate([[0], np.cumsum(plan.ticks)])][1:]
    knot = np.clip(np.searchsorted(way.ends, along, side="right") - 1, 0, len(way.ends) - 2)
    knot[along >= way.ends[-1]] = len(way.ends) - 2
    u = (along - way.ends[knot]) / np.diff(way.ends)[knot]
    corner = np.where(u < 0.5, knot, knot + 1)
    half = way.halves[corner]
    x = np.abs(along - way.ends[corner]) / np.where(half > 0, half, 1)
    weight = np.where((half > 0) & (x < 1), half * (3 / 16 + 3 * x**2 / 8 - x**4 / 16 - x / 2), 0.0)
    foot = plan.setpoints[1:] - way.kinks[corner] * weight[:, None]
    at = plan.circuit.position(way.places)
    at[-1] = at[0]
    points = torus.point(*at.T)
    normals = torus.normal(*at.T)
    chords = np.diff(points, axis=0)
    aside = np.cross(normals[:-1] + normals[1:], chords)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    # M is where the plane of chord and normals, moved aside, meets the normal line of its foot; by
    # nothing for tangent spheres, which have M on the chord.
    off = torus.point(*foot.T) - points[knot]
    frame = np.stack([chords[knot], aside[knot], -torus.normal(*foot.T)], axis=-1)
    share, shift, _ = np.linalg.solve(frame, off[..., None])[..., 0].T
    rows = {
        "aTicks": plan.ticks, "aKnot": knot, "aShare": share, "aWeight": weight, "aCorner": corner,
        "aKnotX": points[:, 0], "aKnotY": points[:, 1], "aKnotZ": points[:, 2],
        "aKinkTheta": way.kinks[:, 0], "aKinkPhi": way.kinks[:, 1],
    }  # fmt: skip
    if plan.path == "corrected chord":
        rows |= {"aShift": shift, **{f"aAside{x}": aside[:, i] for i, x in enumerate("XYZ")}}
    return {name: values.tolist() for name, values in rows.items()}


def _straight(moves, parts):
    """Return ticks and ends in parts of a count, three arrays, of an entry or exit."""
    ends = np.rint(parts / moves.count * moves.setpoints).astype(np.int64)
    return moves.ticks, *ends[1:].T


def _whole_run(plan, parts):
    """Return ends (m + 1, 2) in parts of a count, and ticks (m,), of entry, a lap and exit."""
    runs = plan.entry, plan, plan.leave
    ends = [np.rint(parts / plan.count * run.setpoints).astype(np.int64) for run in runs]
    ends = np.concatenate([ends[0][:1], *(one[1:] for one in ends)])
    return ends, np.concatenate([run.ticks for run in runs])


def _check_counts(plan, parts, whole):
    """Raise ValueError where numbers of a run would leave 32 bits."""
    ends, ticks = whole
    fastest = float((np.abs(np.diff(ends, axis=0)) / (parts * ticks[:, None])).max())
    if fastest > LONGEST - 1:
        raise ValueError(
            f"[plan] tick: a tick moves a joint by {fastest:.0f} counts, and the controller takes "
            f"{LONGEST - 1}; {0.9 * plan.tick * LONGEST / fastest:.2g} s would do."
        )
    total = int(plan.entry.ticks.sum() + plan.laps * plan.ticks.sum() + plan.leave.ticks.sum())
    if total > MOST:
        raise ValueError(
            f"[plan] tick: the run has {total} ticks, and the controller counts {MOST}; "
            f"{2 * plan.tick * total / MOST:.2g} s would do."
        )


def _ramps(plan, parts, ends, ticks):
    """Return by how much the time scale may change (m, 3) in a scan: free, up and down.

    As the slow task finds them: free amid each move, up and down at its begin, at full scale.
    """
    torus = plan.circuit.machine.torus
    angles = plan.count / parts * ends
    rates = np.diff(angles, axis=0) / ticks[:, None]
    lever = levers(torus, angles[:-1])
    now = lever * rates
    change = now - lever * np.concatenate([np.zeros((1, 2)), rates[:-1]])
    most = plan.limits.acceleration * plan.tick**2
    square = np.sum(now**2, axis=-1)
    along = np.sum(now * change, axis=-1)
    root = np.sqrt(along**2 + square * np.maximum(most**2 - np.sum(change**2, axis=-1), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.stack([most / np.sqrt(square), (root - along) / square, (root + along) / square])
    found[:, square == 0] = 1.0
    found = np.floor(FULL * np.clip(found, 0.0, 1.0)).astype(np.int64)
    if found[0].min() < 1:
        raise ValueError(
            f"[plan] tick: the acceleration changes the feed by too little in {plan.tick:g} s; "
            f"{1.1 * plan.tick * FULL / (FULL * most / np.sqrt(square.max())) / FULL:.2g} s would "
            "do."
        )
    return found.T


def _stopping(plan, ticks, ramps):
    """Return of how many ticks the known moves must be, in which the time scale falls to rest.

    Tried from the begin of moves all along the run, at full scale, with no further setpoint: the
    scale is led to the root of what is left, as the fast task does, and its last changes must be
    those of a scan. A quarter more is for runs that begin amid a move.
    """
    stopping = int(_braked(ticks, ramps).max()) + 2
    while stopping <= FULL:
        enough = np.all(_braked(ticks, ramps, stopping) <= 0)
        stopping = int(1.25 * stopping) + 1
        if enough:
            return min(stopping, FULL)
    raise ValueError(
        f"[plan] tick: to stop takes more than {FULL} ticks of {plan.tick:g} s; "
        f"{plan.tick * stopping / FULL * 1.5:.2g} s would do."
    )


def _braked(ticks, ramps, known=None):
    """Return how many ticks (n,) the run goes on from the begin of some moves until it rests.

    Where so many ticks are `known`, return by how much more than a scan may the scale changes at
    their end.
    """
    last = len(ticks) - 1
    row = np.arange(0, last + 1, 1 + last // TRIED)
    found = np.zeros(len(row), dtype=np.int64)
    left = ticks[row]
    scale = np.full(len(row), FULL)
    fraction, gone = np.zeros((2, len(row)), dtype=np.int64)
    begun = np.ones(len(row), dtype=bool)
    runs = np.arange(len(row))  # those that go on; the others are left out
    while len(runs):
        free = ramps[row, 0]
        after = np.minimum(row + 1, last)
        near = (left == 1) & (row < last)
        most = []
        for kind in (1, 2):  # up, down
            bound = np.where(begun, _between(ramps[row], kind, scale), free)
            other = np.minimum(ramps[after, 0], _between(ramps[after], kind, scale))
            most.append(np.where(near, np.minimum(bound, other), bound))
        wanted = 0
        before = scale
        if known is not None:
            room = np.maximum((known - gone) * FULL - fraction, 0)
            wanted = np.minimum(FULL, np.sqrt(room * (FULL / known)).astype(np.int64))
        scale = np.maximum(np.minimum(wanted, scale + most[0]), scale - most[1])
        fraction = fraction + scale
        crossed = fraction >= FULL
        fraction[crossed] -= FULL
        gone = gone + crossed
        left = left - crossed
        over = left == 0
        rests = (scale == 0) | (over & (row == last))  # the end of all is planned at rest
        found[runs] = gone + 1
        if known is not None:
            rests |= gone >= known
            moved = np.minimum(scale, room)  # then it stands
            jump = np.maximum(before - moved, moved) - free
            found[runs] = np.where(gone >= known, jump, 0)
        row = np.where(over, after, row)
        left = np.where(over, ticks[row], left)
        begun = over
        runs, row, left, scale, fraction, gone, begun = (
            values[~rests] for values in (runs, row, left, scale, fraction, gone, begun)
        )
    return found


def _between(ramps, kind, scale):
    """Return what a scale may change at the begin of moves: between free, at 0, and that at 1."""
    free = ramps[:, 0]
    return np.minimum(free, free + (ramps[:, kind] - free) * scale // FULL)


def _throughput(plan, ticks, stopping):
    """Return the ring's size, the slow task's period in ticks and its setpoints a call.

    With them the setpoints ahead of a run at full scale never fall short of the stopping ticks.
    """
    slow = max(round(SLOW / plan.tick), 1)
    lap = np.tile(plan.ticks, min(plan.laps, 2))
    ends = np.cumsum(np.concatenate([plan.entry.ticks, lap, plan.leave.ticks]))
    # Setpoints that must be known at each end: those to stop in, and while the slow task waits.
    needed = np.searchsorted(ends, ends + stopping + 2 * slow) - np.arange(len(ends))
    ring = next((size for size in RINGS if size > needed.max() + 2), None)
    if ring is None:
        raise ValueError(
            f"[plan] tick: {needed.max()} setpoints must be ahead, and the controller has "
            f"{RINGS[-1]} places; {2 * plan.tick * needed.max() / RINGS[-1]:.2g} s would do."
        )
    enough = range(1, ring)  # more setpoints a call are never too few
    return ring, slow, enough[bisect_left(
        enough, True, key=lambda many: _in_time(ends, ring, slow, many, stopping))]  # fmt: skip


def _in_time(ends, ring, slow, at_once, stopping):
    """Return whether so many setpoints a call keep the stopping ticks known all along."""
    # At a call the fast task has begun the moves whose begin is past; a full ring is one short.
    calls = np.arange(0, ends[-1] + slow, slow)
    begun = np.searchsorted(ends, calls, side="right") + 1
    ready = min(ring - 1, len(ends))
    for now, taken in zip(calls.tolist(), begun.tolist(), strict=True):
        ready = min(max(ready, taken) + at_once, taken + ring - 1, len(ends))
        if ready < len(ends) and ends[ready - 1] - now - slow < stopping:
            return False
    return True


def _trip(plan, job):
    """Return the following error that shuts the valves, in m at the cutter."""
    plants, loops = job.axes
    runs = plan.entry, plan, plan.leave
    setvalues = np.concatenate([plan.entry.setvalues[:1], *(run.setvalues[1:] for run in runs)])
    slopes = np.concatenate([run.slopes for run in runs])
    track = follow(plants, loops, setvalues, slopes=slopes)
    # As the controller has it: theta's by the longest arm.
    off = np.abs(track.setvalue - track.position) * _arms(plan.circuit.machine)
    least = MORE * float(off.max())
    trip = job.controller.get("trip", TRIP * plan.circuit.machine.depth)
    if trip < least:
        raise ValueError(
            f"[controller] trip: without a fault the loops are off by {least / MORE:.2g} m; got "
            f"{trip:.2g} m, {1.1 * least:.2g} m would do."
        )
    return float(trip)


def _arms(machine):
    """Return the cutter's greatest way (2,) by a radian of each joint, in m."""
    return np.array([machine.r + machine.R, machine.R])


def _check_operations(job, cost, slow):
    """Raise ValueError if the slow task takes more operations than the job allows."""
    allowed = job.controller.get("operations", OPERATIONS)
    needs = cost / (slow * job.planned.tick)
    if needs > allowed:
        raise ValueError(
            f"[controller] operations: the slow task takes {cost} in a call, {needs:.3g} in a "
            f"second, and {allowed:g} are allowed; {math.ceil(needs)} would do."
        )


def _axis(plant, loop):
    """Return the constants of an axis' loop and static inverse by their names."""
    axis = plant.hydraulics
    found = {"rGain": float(loop.gain), "rForward": float(loop.feedforward)}
    if axis is None:
        return found | {"rSpeed": float(plant.gain)}
    link = axis.linkage
    whole, ring = link.areas
    plus, minus = (whole, ring) if link.sense > 0 else (ring, whole)
    return found | {
        "rSense": float(link.sense), "rMounting": float(link.mounting),
        "rApart": float(link.a - link.b), "rTwice": 2 * math.sqrt(link.a * link.b),
        "rProduct": float(link.a * link.b), "rAreaPlus": float(plus), "rAreaMinus": float(minus),
        "rPair": float(link.pair), "rGravity": float(axis.gravity),
        "rDamping": float(axis.damping), "rSupply": float(axis.supply), "rTank": float(axis.tank),
        "rFlow": float(axis.flow),
    }  # fmt: skip


def _text(plan, plants, ring, slow, **words):
    """Return the contract and the blocks in Structured Text, their constants left out."""
    package = files(__package__)
    kind = "plain" if plants[0].hydraulics is None else "oil"
    text, loop = (package.joinpath(f"{name}.st").read_text(encoding="utf-8")
                  for name in ("controller", f"loop_{kind}"))  # fmt: skip
    (block,) = read_blocks(loop)
    own = [row.name for row in block.rows("VAR_INPUT")[3:]]
    calls = []
    for name in AXES:
        given = {"rSet": f"rCount * DINT_TO_LREAL(nSet{name})", "rAt": f"rAt{name}",
                 "rSlope": f"rSlope{name} * DINT_TO_LREAL(nScale) / DINT_TO_LREAL(nFull)",
                 **{key: key + name for key in own}}  # fmt: skip
        listed = ", ".join(f"{key} := {value}" for key, value in given.items())
        calls += textwrap.wrap(f"loop{name}({listed});", 92, initial_indent=4 * " ",
                               subsequent_indent=8 * " ", break_on_hyphens=False)  # fmt: skip
        calls.append(f"    rValve{name} := loop{name}.rValve;")
    tick = round(1e9 * plan.tick)  # ns
    pieces = {"LINE": line_text(), "LOOP": loop, "LOOPS": "\n".join(calls) + "\n",
              "SHIFT": SHIFT if plan.path == "corrected chord" else ""}  # fmt: skip
    text = re.sub(r"@([A-Z]+)\n", lambda found: pieces.get(found[1], found[0]), text)
    words = {"ARRAY": f"ARRAY [0..{ring - 1}] OF DINT", "RING": ring,
             "FAST": f"{1e3 * plan.tick:g}ms", "SLOW": f"{1e3 * slow * plan.tick:g}ms",
             "EVERY": _interval(tick), "SELDOM": _interval(slow * tick), **words}  # fmt: skip
    # In the picture, where blanks follow, the width is kept.
    return re.sub(
        r"@([A-Z]+)( {2,})?",
        lambda found: str(words[found[1]]).ljust(len(found[0]) if found[2] else 0),
        text,
    )


def _interval(time):
    """Return a task's interval of so many ns; iec2c reads it in single precision, and truncates."""
    whole, rest = divmod(time, 10**6)
    return f"T#{whole}.{rest:06d}49ms" if rest else f"T#{whole}ms"
