"""The whole controller of section 4.4 for other machines: two tasks, in C99 and Structured Text.

One text, in Structured Text, is the program; the C99 of it is made line by line. The slow task
prepares setpoints ahead in a ring. The fast one joins them by integer lines and closes the position
loops: what it does in a scan is said in the texts themselves.
"""

import math
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments import checked
from ..ream.moves import levers
from ..ream.planning import Plan
from .reader import Job

RING = 64  # setpoints ahead: more than the short moves in which a lap speeds up
FULL = 256  # of the override: 100 %
IDLE, RUN, RETRACT, TRIPPED = range(4)
AXES = "Theta", "Phi"

# Variables of the fast task: name, type, what it is.
INPUTS = [
    ("bRun", "BOOL", "start, or go on after a hold"),
    ("bHold", "BOOL", "slow down to a stop on the way, and stay"),
    ("bRetract", "BOOL", "once stopped, withdraw straight to where the cutter entered"),
    ("bReset", "BOOL", "forget a trip; the axes must stand where the set-values are"),
    ("nOverride", "DINT", "feed override, 0 to 256 (100 %)"),
    ("nActualTheta", "DINT", "encoder of theta, counts"),
    ("nActualPhi", "DINT", "encoder of phi, counts"),
]
OUTPUTS = [
    ("nSetTheta", "DINT", "set-value of theta, counts"),
    ("nSetPhi", "DINT", "set-value of phi, counts"),
    ("rSlopeTheta", "LREAL", "exact slope of theta, rad/s"),
    ("rSlopePhi", "LREAL", "exact slope of phi, rad/s"),
    ("rValveTheta", "LREAL", "opening of theta's valve, -1 to 1"),
    ("rValvePhi", "LREAL", "opening of phi's valve, -1 to 1"),
    ("nMode", "DINT", "0 idle, 1 running, 2 retracting, 3 tripped"),
    ("nTripped", "DINT", "why: 1 and 2 following error, 3 and 4 soft limit, of theta and phi"),
    ("bDone", "BOOL", "all moves are made"),
    ("nStarved", "DINT", "scans in which the slow task was late; no count is lost"),
    ("nFullyOpen", "DINT", "scans in which a valve was asked for more than it has"),
]
STATE = [
    ("nFraction", "DINT", "of the tick that is under way, 1 to 256"),
    ("nSpeed", "DINT", "what the fraction grows by in a scan, 0 to 256"),
    ("nWanted", "DINT", "what nSpeed is led to"),
    ("nFromTheta", "DINT", "set-values at the begin of the tick, counts"),
    ("nFromPhi", "DINT", ""),
    ("rLineTheta", "LREAL", "slopes of the moves under way, rad/s"),
    ("rLinePhi", "LREAL", ""),
    ("nPartsTheta", "DINT", "where the moves under way end, parts of a count"),
    ("nPartsPhi", "DINT", ""),
    ("nLeft", "DINT", "ticks that are left of the moves under way"),
    ("bStarted", "BOOL", "the first move was begun"),
    ("rX", "LREAL", "intermediate"),
    ("rError", "LREAL", "following error, rad"),
    ("rAt", "LREAL", "measured position, rad"),
    ("rRate", "LREAL", "wanted rate, rad/s"),
    ("rLeft", "LREAL", "pressure that is left for the valve, Pa"),
    ("rPlus", "LREAL", "oil displaced, m^3/rad"),
    ("rMinus", "LREAL", ""),
    ("rArm", "LREAL", "moment arm, m"),
    ("rLoad", "LREAL", "torque of the weight, N m"),
]
RING_STATE = [
    ("nHead", "DINT", "next setpoint that the fast task takes; it alone writes here"),
    ("nTail", "DINT", "next one that the slow task prepares; it alone writes here"),
    ("bEnd", "BOOL", "the slow task has prepared all"),
    ("nStage", "DINT", "0 entry, 1 laps, 2 exit, 3 none left"),
    ("nRow", "DINT", "next row of the stage's table"),
    ("nLap", "DINT", "laps that are prepared"),
]
RING_ARRAYS = ["aRingTicks", "aRingTheta", "aRingPhi"]
SLOW_STATE = [
    ("nKnot", "DINT", "where the chord begins"),
    ("rX", "LREAL", "point M on the chord or beside it, in the machine's frame, m"),
    ("rY", "LREAL", ""),
    ("rZ", "LREAL", ""),
    ("rRho", "LREAL", "its distance from the axis, m"),
    ("rTheta", "LREAL", "its foot N on the torus, rad"),
    ("rPhi", "LREAL", ""),
]


@dataclass(frozen=True, eq=False)
class Program:
    """What the texts are made from.

    Parameters
    ----------
    constants : dict of str to int or float
        By the names that the programs use.
    tables : dict of str to (n,) list
        Likewise: whole numbers or floats.
    slow, fast : list of str
        Lines of Structured Text.
    parts : int
        Of a count, in the setpoints.
    tick : float
        Period of the fast task, in s.
    """

    constants: dict
    tables: dict
    slow: list
    fast: list
    parts: int
    tick: float


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
        "aTicks": plan.ticks,
        "aKnot": knot,
        "aShare": share,
        "aWeight": weight,
        "aCorner": corner,
        "aKnotX": points[:, 0],
        "aKnotY": points[:, 1],
        "aKnotZ": points[:, 2],
        "aKinkTheta": way.kinks[:, 0],
        "aKinkPhi": way.kinks[:, 1],
    }
    if plan.path == "corrected chord":
        rows |= {"aShift": shift, **{f"aAside{x}": aside[:, i] for i, x in enumerate("XYZ")}}
    return {name: values.tolist() for name, values in rows.items()}


def line_rows(name, moves, parts):
    """Return the tables of an entry or exit: ticks and ends in parts of a count."""
    ends = np.rint(parts / moves.count * moves.setpoints).astype(np.int64)
    return {
        f"a{name}Ticks": moves.ticks.tolist(),
        f"a{name}Theta": ends[1:, 0].tolist(),
        f"a{name}Phi": ends[1:, 1].tolist(),
    }


@checked
def program(plan: Plan, job: Job, *, setpoints: Literal["computed", "stored"] = "computed"):
    """Return the `Program` of a job: its tables, its constants and both tasks.

    Parameters
    ----------
    plan : Plan
        The job's, ``job.planned``.
    job : Job
        For its axes and loops.
    setpoints : {"computed", "stored"}
        Whether the slow task computes them, as feet of points on chords or beside them, or finds
        the whole lap in constant arrays.

    Returns
    -------
    program : Program
        As `controller_texts` writes it.

    Raises
    ------
    ValueError
        If a loop has an integral.
    """
    plants, loops = job.axes
    if any(loop.integral for loop in loops):
        raise ValueError("[controller] integral: must be 0 for the exported loop; got one above.")
    parts = min(moves.fineness for moves in (plan, plan.entry, plan.leave))
    first = plan.entry.setpoints[0] / plan.count
    machine = plan.circuit.machine
    low, high = (
        np.array(limits) / plan.count
        for limits in ((machine.theta_min, machine.phi_min), (machine.theta_max, machine.phi_max))
    )
    # Twice what a loop of these gains trails at full feed without feed-forward, and 50 counts.
    trail = np.abs(np.concatenate([moves.slopes for moves in (plan, plan.entry)])).max()
    trip = 2 * trail / min(loop.gain for loop in loops) / plan.count + 50
    ramp = plan.limits.acceleration * plan.tick / max(plan.feed.max(), 1e-9) * FULL
    stored = setpoints == "stored"
    away = plan.setpoints - plan.entry.setpoints[0]
    farthest = 1.01 * np.linalg.norm(levers(machine.torus, plan.setpoints) * away, axis=-1).max()
    constants = {
        "nParts": parts,
        "nRing": RING,
        "nFull": FULL,
        "nRamp": max(min(math.floor(ramp), FULL), 1),
        "nMoves": len(plan.ticks),
        "nEntry": len(plan.entry.ticks),
        "nLeave": len(plan.leave.ticks),
        "nLaps": plan.laps,
        "nTrip": math.ceil(trip),
        "nFirstTheta": round(first[0] * parts),
        "nFirstPhi": round(first[1] * parts),
        "nRetractTicks": math.ceil(farthest / plan.limits.feed / plan.tick),
        "nBeginTheta": round(plan.entry.setvalues[0, 0] / plan.count),
        "nBeginPhi": round(plan.entry.setvalues[0, 1] / plan.count),
        "rCount": plan.count,
        "rTick": plan.tick,
    }
    if not stored:
        constants["rRingRadius"] = float(machine.r)
    for axis, name in enumerate(AXES):
        constants |= {
            f"nLeast{name}": math.floor(low[axis]),
            f"nMost{name}": math.ceil(high[axis]),
            f"rGain{name}": float(loops[axis].gain),
            f"rForward{name}": float(loops[axis].feedforward),
        }
        constants |= {f"{key}{name}": value for key, value in _plant(plants[axis]).items()}
    tables = {
        **(line_rows("Lap", plan, parts) if stored else chord_rows(plan)),
        **line_rows("Entry", plan.entry, parts),
        **line_rows("Leave", plan.leave, parts),
    }
    both = "".join(_loop(name, plant) for name, plant in zip(AXES, plants, strict=True))
    fast = _expanded(FAST.replace("@TAKE", TAKE).replace("@LOOPS", both))
    shifted = SHIFT if plan.path == "corrected chord" else ""
    slow = _lines(SLOW.replace("@SETPOINT", STORED if stored else FOOT.replace("@SHIFT", shifted)))
    return Program(constants, tables, slow, fast, parts, plan.tick)


def _lines(text):
    return [line for line in text.splitlines() if line.strip()]


def _expanded(text):
    """Return the lines of a text with LOAD, LINE and STEP of both lines written out."""
    found = []
    for line in _lines(text):
        pad = line[: len(line) - len(line.lstrip())]
        load = re.fullmatch(r"\s*LOAD\((.+), (.+), (\w+)\);", line)
        if load:
            *stops, ticks = load.groups()
            for name, stop in zip(AXES, stops, strict=True):
                change = f"DINT_TO_LREAL({stop} - nParts{name}) / DINT_TO_LREAL({ticks} * nParts)"
                found += [
                    f"{pad}rLine{name} := rCount / rTick * ({change});",
                    f"{pad}line{name}(bLoad := TRUE, nStart := nParts{name}, nStop := {stop}, "
                    f"nTicks := {ticks});",
                    f"{pad}nParts{name} := {stop};",
                ]
        elif line.strip() == "STEP;":
            found += [f"{pad}line{name}(bLoad := FALSE);" for name in AXES]
        else:
            found.append(re.sub(r"LINE\((\w+)\)", r"line\1.nSet", line))
    return found


def _plant(plant):
    """Return the constants of an axis' static inverse by their names."""
    axis = plant.hydraulics
    if axis is None:
        return {"rSpeed": float(plant.gain)}
    link = axis.linkage
    whole, ring = link.areas
    return {
        "rSense": float(link.sense),
        "rMounting": float(link.mounting),
        "rApart": float(link.a - link.b),
        "rTwice": 2 * math.sqrt(link.a * link.b),
        "rProduct": float(link.a * link.b),
        "rAreaPlus": whole if link.sense > 0 else ring,
        "rAreaMinus": ring if link.sense > 0 else whole,
        "rGravity": float(axis.gravity),
        "rDamping": float(axis.damping),
        "rSupply": float(axis.supply),
        "rTank": float(axis.tank),
        "rFlow": float(axis.flow),
    }


def _loop(name, plant):
    """Return the lines of an axis' position loop with the static inverse of its plant."""
    text = LOOP_BEGIN
    if plant.hydraulics is not None:
        second = PAIR if plant.hydraulics.linkage.pair else ""
        text += INVERSE.replace("@PAIR", second)
    else:
        text += "rValve@ := rRate / rSpeed@;\n"
    text += LOOP_END
    return text.replace("@", name)


SLOW = """
(* Prepare one setpoint ahead, if there is room. Call as often as the fast task leaves time. *)
nNext := nTail + 1;
IF nNext = nRing THEN
    nNext := 0;
END_IF;
IF nNext <> nHead AND nStage < 3 THEN
    IF nStage = 0 THEN
        aRingTicks[nTail] := aEntryTicks[nRow];
        aRingTheta[nTail] := aEntryTheta[nRow];
        aRingPhi[nTail] := aEntryPhi[nRow];
    ELSIF nStage = 2 THEN
        aRingTicks[nTail] := aLeaveTicks[nRow];
        aRingTheta[nTail] := aLeaveTheta[nRow];
        aRingPhi[nTail] := aLeavePhi[nRow];
    ELSE
@SETPOINT
    END_IF;
    nRow := nRow + 1;
    IF nStage = 0 AND nRow = nEntry THEN
        nStage := 1;
        nRow := 0;
    END_IF;
    IF nStage = 1 AND nRow = nMoves THEN
        nLap := nLap + 1;
        nRow := 0;
        IF nLap = nLaps THEN
            nStage := 2;
        END_IF;
    END_IF;
    IF nStage = 2 AND nRow = nLeave THEN
        nStage := 3;
    END_IF;
    (* Last of all: now the fast task may take it. *)
    nTail := nNext;
    bEnd := nStage = 3;
END_IF;
"""
FOOT = """
        (* M on the chord between two knots, its foot N on the torus, the corner rounded. *)
        nKnot := aKnot[nRow];
        rX := aKnotX[nKnot] + aShare[nRow] * (aKnotX[nKnot + 1] - aKnotX[nKnot]);
        rY := aKnotY[nKnot] + aShare[nRow] * (aKnotY[nKnot + 1] - aKnotY[nKnot]);
        rZ := aKnotZ[nKnot] + aShare[nRow] * (aKnotZ[nKnot + 1] - aKnotZ[nKnot]);
@SHIFT
        rRho := SQRT(rX * rX + rZ * rZ);
        rTheta := ATAN(-rZ / rX);
        rPhi := ATAN(rY / (rRho - rRingRadius));
        nKnot := aCorner[nRow];
        rTheta := (rTheta + aWeight[nRow] * aKinkTheta[nKnot]) / rCount * DINT_TO_LREAL(nParts);
        rPhi := (rPhi + aWeight[nRow] * aKinkPhi[nKnot]) / rCount * DINT_TO_LREAL(nParts);
        aRingTicks[nTail] := aTicks[nRow];
        (* Nearest whole numbers: truncation goes towards zero. *)
        IF rTheta < 0.0 THEN
            aRingTheta[nTail] := 0 - TRUNC(0.5 - rTheta);
        ELSE
            aRingTheta[nTail] := TRUNC(rTheta + 0.5);
        END_IF;
        IF rPhi < 0.0 THEN
            aRingPhi[nTail] := 0 - TRUNC(0.5 - rPhi);
        ELSE
            aRingPhi[nTail] := TRUNC(rPhi + 0.5);
        END_IF;
"""
SHIFT = """
        (* Of a corrected chord M lies beside the chord. *)
        rX := rX + aShift[nRow] * aAsideX[nKnot];
        rY := rY + aShift[nRow] * aAsideY[nKnot];
        rZ := rZ + aShift[nRow] * aAsideZ[nKnot];
"""
STORED = """
        aRingTicks[nTail] := aLapTicks[nRow];
        aRingTheta[nTail] := aLapTheta[nRow];
        aRingPhi[nTail] := aLapPhi[nRow];
"""
FAST = """
(* One call is one scan: load and tick share it, so that no setpoint lasts two ticks. *)
IF bReset AND nMode = 3 THEN
    nMode := 0;
    nTripped := 0;
    nSpeed := 0;
END_IF;
IF bRun AND NOT bHold AND nMode = 0 AND NOT bDone THEN
    nMode := 1;
    IF NOT bStarted THEN
        bStarted := TRUE;
        nSpeed := nOverride;
    END_IF;
END_IF;
(* Withdraw in a straight line: the section is convex, its inside is clear. *)
IF bRetract AND nMode = 1 AND nSpeed = 0 THEN
    nMode := 2;
    nLeft := nRetractTicks;
    nFraction := nFull;
    nPartsTheta := nSetTheta * nParts;
    nPartsPhi := nSetPhi * nParts;
    LOAD(nFirstTheta, nFirstPhi, nRetractTicks);
    nFromTheta := LINE(Theta);
    nFromPhi := LINE(Phi);
END_IF;
(* The next move, where the last one is at its end. *)
IF nFraction = nFull THEN
@TAKE
    IF nMode = 1 AND nLeft = 0 THEN
        rLineTheta := 0.0;
        rLinePhi := 0.0;
        IF bEnd THEN
            nMode := 0;
            bDone := TRUE;
        ELSE
            nStarved := nStarved + 1;
        END_IF;
    END_IF;
END_IF;
(* The speed on the way: led to the override, or to a stop, no faster than the feed may change. *)
nWanted := 0;
IF nMode = 1 AND NOT bHold THEN
    nWanted := nOverride;
ELSIF nMode = 2 THEN
    nWanted := nFull;
    IF nSpeed * nSpeed / (2 * nRamp * nFull) >= nLeft THEN
        nWanted := nRamp;
    END_IF;
END_IF;
IF nWanted > nSpeed + nRamp THEN
    nSpeed := nSpeed + nRamp;
ELSIF nWanted < nSpeed - nRamp THEN
    nSpeed := nSpeed - nRamp;
ELSE
    nSpeed := nWanted;
END_IF;
(* The set-values of this scan; with an override they are between two of the line's. *)
nSetTheta := nFromTheta;
nSetPhi := nFromPhi;
IF nFraction < nFull THEN
    nSetTheta := nFromTheta + (LINE(Theta) - nFromTheta) * nFraction / nFull;
    nSetPhi := nFromPhi + (LINE(Phi) - nFromPhi) * nFraction / nFull;
END_IF;
rSlopeTheta := rLineTheta * (DINT_TO_LREAL(nSpeed) / DINT_TO_LREAL(nFull));
rSlopePhi := rLinePhi * (DINT_TO_LREAL(nSpeed) / DINT_TO_LREAL(nFull));
(* What must never happen shuts both valves. *)
IF nMode <> 3 THEN
    IF NABS(nSetTheta - nActualTheta) > nTrip THEN
        nTripped := 1;
    ELSIF NABS(nSetPhi - nActualPhi) > nTrip THEN
        nTripped := 2;
    ELSIF nSetTheta < nLeastTheta OR nSetTheta > nMostTheta THEN
        nTripped := 3;
    ELSIF nSetPhi < nLeastPhi OR nSetPhi > nMostPhi THEN
        nTripped := 4;
    END_IF;
    IF nTripped > 0 THEN
        nMode := 3;
    END_IF;
END_IF;
IF nMode = 3 THEN
    rValveTheta := 0.0;
    rValvePhi := 0.0;
ELSE
@LOOPS
END_IF;
(* On along the lines: a whole tick of theirs, or what the override leaves of it. *)
IF (nMode = 1 OR nMode = 2) AND nSpeed > 0 AND (nLeft > 0 OR nFraction < nFull) THEN
    nFraction := nFraction + nSpeed;
    IF nFraction > nFull THEN
        nFraction := nFraction - nFull;
@TAKE
        IF nLeft > 0 THEN
            nFromTheta := LINE(Theta);
            nFromPhi := LINE(Phi);
            STEP;
            nLeft := nLeft - 1;
        ELSE
            nFraction := nFull;
        END_IF;
    END_IF;
    IF nFraction = nFull THEN
        nFromTheta := LINE(Theta);
        nFromPhi := LINE(Phi);
    END_IF;
    IF nMode = 2 AND nLeft = 0 AND nFraction = nFull THEN
        nMode := 0;
        bDone := TRUE;
    END_IF;
END_IF;
"""
TAKE = """
    IF nMode = 1 AND nLeft = 0 AND nHead <> nTail THEN
        nLeft := aRingTicks[nHead];
        LOAD(aRingTheta[nHead], aRingPhi[nHead], nLeft);
        IF nHead = nRing - 1 THEN
            nHead := 0;
        ELSE
            nHead := nHead + 1;
        END_IF;
    END_IF;
"""
LOOP_BEGIN = """
    (* Wanted rate of @: gain times error, and the share of the exact slope. *)
    rAt := rCount * DINT_TO_LREAL(nActual@);
    rError := rCount * DINT_TO_LREAL(nSet@) - rAt;
    rRate := rGain@ * rError + rForward@ * rSlope@;
"""
INVERSE = """
    (* Static inverse of valve and linkage: the opening that gives this rate. *)
    rArm := rMounting@ + rSense@ * rAt;
    rX := rTwice@ * SIN(rArm / 2.0);
    rArm := ABS(rProduct@ * SIN(rArm) / SQRT(rApart@ * rApart@ + rX * rX));
    rPlus := rAreaPlus@ * rArm;
    rMinus := rAreaMinus@ * rArm;
@PAIR
    rLoad := -(rGravity@ * COS(rAt));
    IF rRate < 0.0 THEN
        rX := rPlus;
        rPlus := rMinus;
        rMinus := rX;
        rLoad := -rLoad;
    END_IF;
    rX := rMinus / rPlus;
    rLeft := rSupply@ - rX * rTank@ - rLoad / rPlus - rDamping@ * ABS(rRate) / rPlus;
    IF rRate = 0.0 THEN
        rValve@ := 0.0;
    ELSIF rLeft <= 0.0 THEN
        rValve@ := 2.0;
    ELSE
        rValve@ := ABS(rRate) * rPlus / rFlow@ * SQRT((1.0 + rX * rX * rX) / rLeft);
    END_IF;
    IF rRate < 0.0 THEN
        rValve@ := -rValve@;
    END_IF;
"""
PAIR = """
    rArm := rMounting@ - rSense@ * rAt;
    rX := rTwice@ * SIN(rArm / 2.0);
    rArm := ABS(rProduct@ * SIN(rArm) / SQRT(rApart@ * rApart@ + rX * rX));
    rPlus := rPlus + rAreaMinus@ * rArm;
    rMinus := rMinus + rAreaPlus@ * rArm;
"""
LOOP_END = """
    IF rValve@ > 1.0 THEN
        rValve@ := 1.0;
        nFullyOpen := nFullyOpen + 1;
    ELSIF rValve@ < -1.0 THEN
        rValve@ := -1.0;
        nFullyOpen := nFullyOpen + 1;
    END_IF;
"""
