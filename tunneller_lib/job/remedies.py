"""Which key of a job halves a fault of its budget, confirmed by another simulation."""

from dataclasses import replace
from functools import partial
from inspect import signature

import numpy as np

from ..motion.stability import is_stable
from ..ream import Case, halving, plan

# The table of a job that has each remedy.
TABLES = {"tolerance": "plan", "step": "plan", "tick": "plan", "count": "plan",
          "encoder": "controller", "gain": "controller",
          "feed": "limits", "acceleration": "limits", "power": "limits"}  # fmt: skip
USUAL = {name: about.default for name, about in signature(plan).parameters.items()}


def halved_by(job, faults, say=None):
    """Return (key, factor, left) for each of the `faults` of a `job`: what halves it.

    They are the key as the job writes it, ``[table] key``, the factor that multiplies it, and the
    share of the fault that a simulation then leaves. All three are None if none of the keys tried
    leaves about a half. `say` is told how far it is.
    """
    runs = {}  # by their changes: one may be tried for several faults

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
    """Return a `job` with one of its remedies multiplied by a `factor`, or None if it has none."""
    if what == "pose":
        return replace(job, pose={name: factor * value for name, value in job.pose.items()})
    what = _own(job, what)
    table = getattr(job, TABLES[what])
    value = table.get(what, USUAL.get(what))
    if value is None:
        return None
    return replace(job, **{TABLES[what]: {**table, what: factor * value}})


def _own(job, what):
    """Return the key for `what`: without an own key the encoder has the set-values' counts."""
    return "count" if what == "encoder" and "encoder" not in job.controller else what


def _key(job, what):
    """Return a remedy's key as the `job` writes it, with its table."""
    if what == "pose":
        return "[pose]"
    what = _own(job, what)
    return f"[{TABLES[what]}] {what}"


def _case(job):
    """Return the `Case` of a job; None where there is none, or it would be refused."""
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
