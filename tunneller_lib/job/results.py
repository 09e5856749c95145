"""What came of a job: its numbers, and all files that others may want of it."""

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..motion.export import c99, structured_text
from ..motion.stability import is_stable
from ..ream import budget, part_clearances
from ..ream.cutting import Cut
from ..ream.faults import following_fault
from ..ream.margins import used
from .atomic_write import write
from .controller import program
from .controller_texts import c99_text, plcopen_xml, structured_text_of
from .csv_tables import knots_csv, setpoints_csv, setvalues_csv
from .drawing import dxf
from .mesh import stl, vtp, wall_solid, wall_surface
from .reader import Job

CONFIRMED = 0.6  # of a fault, at most, must be left where its halving is confirmed
MOST_GAIN = 1e9  # of a Loop, in 1/s
WORSE = 3  # times the tolerance: all sources together are beyond what was asked for
FAULT = "source", "over_m", "under_m", "rms_m", "measure", "closed_m", "halved_by", "factor", "kind"
SUMMARY = (
    "knots",
    "setpoints",
    "ticks",
    "laps",
    "lap_time_s",
    "removed_m3",
    "overbreak_m",
    "underbreak_m",
    "times_s",
    "limits_used",
    "saturated_share",
    "faults",
    "machine",
    "clearances",
    "warnings",
)
CLEARANCE = "part", "clearance_m", "at_m"
MARGIN = "what", "has", "needs", "unit"
BEYOND = 1.25  # times, either way: what is measured is beyond its closed form's range
LESS = "count", "blend", "pose", "power"  # what is made smaller to halve a fault
# Who answers for a fault, for people.
DUE_TO = {"chosen": "your choice", "machine": "machine", "ground": "ground", "paper": "method"}
LEAST_SEEN = 5e-5  # m, below which a closed form's range matters to nobody


def _summary(name, value):
    """Return `value`, which must be a dict as `summarise` makes it."""
    if not isinstance(value, dict) or tuple(value) != SUMMARY:
        raise ValueError(f"{name}: must be a dict from summarise; got {shown(value)}.")
    return value


Summary = Annotated[dict, Rule("dict", _summary)]


@checked
def summarise(job: Job, cut: Cut, say: Callable[[str], object] | None = None):
    """Return the numbers of a job, in SI units, ready for JSON.

    Parameters
    ----------
    job : Job
        What was asked for.
    cut : Cut
        The simulated job.
    say : function, optional
        Told how far it is.

    Returns
    -------
    numbers : dict
        Of the plan, of the wall, and ``times_s``: what takes how long; ``limits_used``: the
        greatest share of each limit of the motion; ``saturated_share``: of the time that theta's
        and phi's valves are fully open; ``faults``: the error budget, each source switched on
        alone, with its greatest over- and under-break, the closed form of its ``measure`` and who
        answers for it; ``machine``: what it has and needs, in the unit that each row names: as
        planned, then the greatest that the simulated laps took of power, valves and oil, and the
        damper of the ground that each joint bears and meets if the picks are in step;
        ``clearances``: how far each part of the machine keeps from the wall as planned, and where
        along the circuit; ``warnings``, sentences.
    """
    if cut.track is None:
        raise ValueError("cut: must be of simulated loops; got one without a track.")
    plan = job.planned
    faults = [
        (f.source, f.over, f.under, f.rms, f.measure, f.closed, *_halving(job, f), f.kind)
        for f in budget(plan, *job.axes, pose=job.error, arm=job.arm, ground=job.pushing, say=say)
    ]
    over = max(float(cut.deviation.max()), 0.0)
    under = max(float(-cut.deviation.min()), 0.0)
    return {
        "knots": len(plan.knots),
        "setpoints": len(plan.s) - 1,
        "ticks": int(plan.ticks.sum()),
        "laps": plan.laps,
        "lap_time_s": plan.lap_time,
        "removed_m3": float(cut.removed.sum()) + cut.plunged,
        "overbreak_m": over,
        "underbreak_m": under,
        "times_s": plan.times,
        "limits_used": plan.shares,
        "saturated_share": cut.track.saturated_share.tolist(),
        "faults": [dict(zip(FAULT, fault, strict=True)) for fault in faults],
        "machine": [
            dict(zip(MARGIN, margin, strict=False))
            for margin in [*job.margins, *used(plan, job.axes[0], cut, job.sizes), *job.in_step]
        ],
        "clearances": [dict(zip(CLEARANCE, part, strict=True)) for part in plan.clearances],
        "warnings": [
            *_warnings(job, over, under),
            *_colliding(job),
            *_coarse(job, cut),
            *_strained(job, cut),
        ],
    }


def _halving(job, fault):
    """Return what halves a fault, and by which factor; a gain only where a simulation confirms it.

    The gain is raised as the closed form says and the axes run again. Where a loop isn't stable
    then, or less than two fifths of the fault go, no gain is named and the factor is 1.
    """
    if fault.halved_by != "gain":
        return fault.halved_by, float(fault.factor)
    plants, loops = job.axes
    raised = [replace(loop, gain=min(loop.gain * fault.factor, MOST_GAIN)) for loop in loops]
    at = job.planned.setvalues
    angles = np.linspace(at.min(axis=0), at.max(axis=0), 5)
    if all(map(is_stable, plants, raised, angles.T)):
        left = following_fault(job.planned, plants, raised)
        if left.measured <= CONFIRMED * fault.measured:
            return "gain", float(fault.factor)
    return "no gain", 1.0


def _warnings(job, over, under):
    """Return sentences about a cut that is hardly what was meant; sizes in mm, perhaps."""
    depth = job.machine["depth"]
    tolerance = job.plan["tolerance"]
    found = []
    if tolerance >= depth:
        found.append(
            f"[plan] tolerance: {tolerance:g} m isn't below the depth of cut {depth:g} m; "
            "are all sizes in metres?"
        )
    for name, worst in (("over", over), ("under", under)):
        if worst > WORSE * tolerance:
            found.append(
                f"the {name}-break of {1e3 * worst:.3g} mm is {worst / tolerance:.2g} times the "
                f"tolerance of {1e3 * tolerance:g} mm."
            )
    return found


def _colliding(job):
    """Return sentences about parts that are in the wall where the machine stands unknowingly."""
    if job.error is None:
        return []
    arm_radius = job.plan.get("arm_radius", 0.0)
    parts = part_clearances(job.planned.circuit, arm_radius, pose=job.error)
    return [
        f"the machine's {part.name} {part.depth_in_wall}, where it stands by [pose]."
        for part in parts
        if part.collides
    ]


def _strained(job, cut):
    """Return sentences about a machine that can hardly do the cut, or whose ground nobody felt."""
    found = [str(margin) for margin in job.margins if not margin.enough]
    if job.ground and job.pushing is None:
        found.append(
            '[ground]: limits the feed alone; only plant = "T3" feels its force, and the wall\'s '
            "error lacks it."
        )
    if not job.ground and job.controller["plant"] == "T3":
        found.append("[ground]: is missing, so that nothing pushes back on the axes.")
    for joint, share in zip(("theta", "phi"), cut.track.saturated_share, strict=True):
        if share > 0:
            found.append(
                f"{joint}'s valve is fully open for {100 * share:.2g} % of the time, and the axis "
                "doesn't follow; a lower [limits] feed or power would do."
            )
    return found


def _coarse(job, cut):
    """Return sentences about rays so far apart that a groove may meet one alone."""
    radius = job.machine["cutter_radius"]
    depth = job.machine["depth"]
    half = np.sqrt(depth * (2 * radius - depth))
    sizes = {
        "along": np.ptp(cut.centres[:, 0]) + 2 * radius,
        "around": job.planned.circuit.section.perimeter,
    }
    return [
        f"[wall] {name}: {job.wall[name]} rays are {1e3 * size / job.wall[name]:.0f} mm apart, and "
        f"half a groove is {1e3 * half:.0f} mm wide."
        for name, size in sizes.items()
        if size / job.wall[name] > half
    ]


def _knob(fault):
    """Return what halves a fault and by how much it grows or, where less is better, shrinks."""
    sign = "/" if fault["halved_by"] in LESS else "x"
    changed = f"{fault['halved_by']} {sign} {fault['factor']:.2f}"
    return changed if fault["factor"] != 1 else fault["halved_by"]


def _mark(fault):
    """Return a mark for a fault whose closed form is off by more than a quarter, and matters."""
    worst = max(fault["over_m"], fault["under_m"])
    measured = fault["rms_m"] if fault["measure"] == "rms" else worst
    closed = fault["closed_m"]
    within = closed / BEYOND <= measured <= closed * BEYOND
    return "" if within or worst < LEAST_SEEN else " *"


@checked
def summary_text(numbers: Summary):
    """Return what `summarise` found as lines for people, lengths in mm."""
    lines = [
        f"{numbers['knots']} knots, {numbers['setpoints']} setpoints, {numbers['ticks']} ticks",
        f"{numbers['laps']} x {numbers['lap_time_s']:.1f} s, "
        f"{1e3 * numbers['removed_m3']:.2f} l removed",
        f"all together: over-break {1e3 * numbers['overbreak_m']:.3f} mm, "
        f"under-break {1e3 * numbers['underbreak_m']:.3f} mm",
        "time in s: " + ", ".join(f"{name} {t:.2f}" for name, t in numbers["times_s"].items()),
        "limits used: "
        + ", ".join(
            f"{name.replace('_', ' ')} {100 * share:.0f} %"
            for name, share in numbers["limits_used"].items()
            if share
        ),
        "time with a valve fully open: "
        + ", ".join(
            f"{joint} {100 * share:.2g} %"
            for joint, share in zip(("theta", "phi"), numbers["saturated_share"], strict=True)
        ),
        "clear of the wall, in mm: "
        + ", ".join(
            f"{row['part']} {1e3 * row['clearance_m']:.1f}" for row in numbers["clearances"]
        ),
        "",
        "each alone, in mm     over   under     rms   closed form      halved by         due to",
    ]
    for fault in numbers["faults"]:
        over, under, rms, closed = (
            1e3 * fault[f"{k}_m"] for k in ("over", "under", "rms", "closed")
        )
        form = f"{closed:8.4f} {fault['measure']}"
        lines.append(
            f"  {fault['source']:15s} {over:8.3f}{under:8.3f}{rms:8.4f} {form:18s}"
            f"{_knob(fault):18s}{DUE_TO[fault['kind']]}{_mark(fault)}"
        )
    if any(_mark(fault) for fault in numbers["faults"]):
        lines.append("* beyond the range of its closed form, which is for slow, small motions")
    if numbers["machine"]:
        lines += ["", "the machine            has      needs"]
    for row in numbers["machine"]:
        lines.append(
            f"  {row['what']:19s} {row['has']:8.3g}  {row['needs']:8.3g} {row['unit']}"
            + ("" if row["has"] > row["needs"] else ", less than needed")
        )
    if any(row["what"].startswith("in step") for row in numbers["machine"]):
        lines += [
            "in step: the ground's damper where picks follow each other in one track;",
            "a joint that has less would chatter in it, at any feed; the budget is of picks that",
            "don't follow each other in one track",
        ]
    return "\n".join(lines)


@checked
def write_all(job: Job, cut: Cut, folder: Path, numbers: Summary, say: Callable[[str], object]):
    """Write the files of a job into a folder, but pictures.

    Parameters
    ----------
    job : Job
        What was asked for.
    cut : Cut
        The simulated job.
    folder : pathlib.Path
        Made where it is missing; files of these names are replaced.
    numbers : dict
        From `summarise`, for the table of the error budget.
    say : function
        Gets a sentence for each file that is being written.

    Returns
    -------
    files : list of str
        Their paths.
    """
    plan = job.planned
    controller = program(plan, job)
    curves = {"SECTION": plan.circuit.section, "CENTRE": plan.circuit.profile}
    makers = {
        "budget.csv": lambda: _table(numbers["faults"]),
        "knots.csv": lambda: knots_csv(plan),
        "setpoints.csv": lambda: setpoints_csv(plan),
        "setvalues.csv": lambda: setvalues_csv(plan),
        "line.st": structured_text,
        "line.c": c99,
        "controller.c": lambda: c99_text(controller),
        "controller.st": lambda: structured_text_of(controller),
        "controller.xml": lambda: plcopen_xml(controller),
        "section.dxf": lambda: dxf(curves),
        "wall.vtp": lambda: vtp(wall_surface(cut.wall, plan.circuit)),
        "wall.stl": lambda: stl(wall_solid(cut.wall)),
    }
    files = []
    for name, make in makers.items():
        say(f"writing {folder / name}")
        files.append(str(write(folder / name, make())))
    return files


def _table(rows):
    """Return rows of the same names as a table."""
    text = io.StringIO()
    table = csv.DictWriter(text, FAULT, lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()
