"""Which key of a job halves a fault of its budget, as another simulation confirms."""

from dataclasses import replace
from functools import partial
from inspect import signature

import numpy as np

from ..motion.stability import is_stable
from ..ream import Case, halving, plan

# The table of a job in which each remedy stands.
TABLES = dict.fromkeys(("tolerance", "step", "tick", "count"), "plan")
TABLES |= dict.fromkeys(("encoder", "gain"), "controller")
TABLES |= dict.fromkeys(("feed", "acceleration", "power"), "limits")
USUAL = {name: about.default for name, about in signature(plan).parameters.items()}


def halved_by(job, faults, say=None):
    """Return (key, factor, left) for each of the `faults` of a `job`: the change that halves it.

    These are the key as the job writes it, ``[table] key``, the factor that multiplies it, and the
    share of the fault that a simulation then leaves. All three are None if none of the keys tried
    leaves about a half. `say` is called with sentences about the progress.
    """
    runs = {}  # by change, since several faults may try the same one

    def again(source, what, factor):
        if (what, factor) not in runs:
            runs[what, factor] = _case(changed(job, what, factor))
        case = runs[what, factor]
        return case and case.fault(source)

    found = []
    for number, fault in enumerate(faults):
        if say is not None:
            say(f"halving: source {number + 1} of {len(faults)}")
        remedy = halving(fault, partial(again, fault.source))
        found.append(
            (None,) * 3
            if remedy is None
            else (_key(job, remedy.what), remedy.factor, float(remedy.left))
        )
    return found


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


def _case(job):
    """Return the `Case` of a job; None without a job, or if the job would be refused."""
    if job is None:
        return None
    try:
        planned = job.planned
        plants, loops = job.axes
        case = Case(planned, plants, loops, job.error, job.arm, job.pushing)
    except ValueError:
        return None
    at = planned.setvalues
    angles = np.linspace(at.min(axis=0), at.max(axis=0), 5)
    return case if all(map(is_stable, plants, loops, angles.T)) else None
