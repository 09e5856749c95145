"""Which key of a job halves a fault of its budget, by the power with which its closed form goes."""

from dataclasses import replace
from inspect import signature

import numpy as np

from ..motion.stability import is_stable
from ..ream import plan

# The table of a job in which each remedy stands.
TABLES = dict.fromkeys(("tolerance", "step", "tick", "count", "advance"), "plan")
TABLES |= dict.fromkeys(("encoder", "gain"), "controller")
TABLES |= dict.fromkeys(("feed", "acceleration", "power"), "limits")
USUAL = {name: about.default for name, about in signature(plan).parameters.items()}
REACHED = 0.99  # share of a limit that is reached where it decides


def _stable(job, _, factor):
    """Return whether both loops bear the gain."""
    plants, loops = job.axes
    at = job.planned.setvalues
    angles = np.linspace(at.min(axis=0), at.max(axis=0), 5).T
    return all(
        is_stable(plant, replace(loop, gain=factor * loop.gain), own)
        for plant, loop, own in zip(plants, loops, angles, strict=True)
    )


def _feed_decides(job, fault, _):
    """Return whether the cutter goes at its full feed where the fault is largest."""
    return _feed_at(job, fault) >= REACHED * job.limits["feed"]


def _power_decides(job, fault, _):
    """Return whether it is slower than that there."""
    return not _feed_decides(job, fault, _)


def _feed_at(job, fault):
    at = int(np.argmax(np.abs(fault.deviation)))
    return float(np.interp(job.planned.places[at], job.planned.s, job.planned.feed))


def _step_decides(job, fault, factor):
    """Return whether the move in which the fault is largest is as long as a step may be.

    A shorter step must still be as long as the way of a tick.
    """
    plan = job.planned
    step = job.plan.get("step", USUAL["step"])
    ends = np.cumsum(plan.ticks)
    move = int(np.searchsorted(ends, np.argmax(np.abs(fault.deviation))))
    way = plan.reached[ends[move]] - plan.reached[ends[move] - plan.ticks[move]]
    # One tick more would be too long.
    longer = way * (1 + 1 / plan.ticks[move])
    return longer >= REACHED * step and factor * step >= np.diff(plan.reached).max()


# What must hold, of (job, fault, factor), for a remedy to act as its power says.
ACTS = {"gain": _stable, "feed": _feed_decides, "power": _power_decides, "step": _step_decides}


def halved_by(job, faults):
    """Return (key, factor) for each of the `faults` of a `job`: the change that halves it.

    These are the key as the job writes it, ``[table] key``, and the factor that multiplies it, by
    the power with which the source's closed form goes with that key. Both are None if no key that
    is known to act does.
    """
    return [
        next(
            (
                (_key(job, what), round(factor, 2))
                for what, factor in fault.remedies
                if fault.measured and _has(job, what) and _acts(job, fault, what, factor)
            ),
            (None, None),
        )
        for fault in faults
    ]


def _acts(job, fault, what, factor):
    return what not in ACTS or ACTS[what](job, fault, factor)


def _has(job, what):
    return changed(job, what, 1.0) is not None


def changed(job, what, factor):
    """Return a `job` with the remedy `what` multiplied by a `factor`; None if it lacks that key."""
    if what == "pose":
        return replace(job, pose={name: factor * value for name, value in job.pose.items()})
    what = _own(job, what)
    table = getattr(job, TABLES[what])
    value = table.get(what, USUAL.get(what))
    if value is None:
        return None
    return replace(job, **{TABLES[what]: {**table, what: factor * value}})


def _own(job, what):
    """Return the key for `what`; an encoder without a key has the set-values' count."""
    return "count" if what == "encoder" and "encoder" not in job.controller else what


def _key(job, what):
    """Return a remedy's key as the `job` writes it, with its table."""
    if what == "pose":
        return "[pose]"
    what = _own(job, what)
    return f"[{TABLES[what]}] {what}"
