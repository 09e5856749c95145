"""What came of a job: its numbers, and all files that others may want of it."""

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..motion.export import line_c99, line_text
from ..ream import budget, part_clearances
from ..ream.cutting import Cut
from ..ream.margins import used
from .controller import program
from .controller_texts import c99_header, c99_text, plcopen_xml
from .csv_tables import knots_csv, setpoints_csv, setvalues_csv
from .drawing import dxf
from .mesh import stl_blocks, vtp_blocks, wall_solid, wall_surface
from .reader import Job
from .remedies import halved_by

SEVERAL = 3  # times the tolerance, from which on an over- or underbreak is worth a warning
FAULT = ("source", "over_m", "under_m", "rms_m", "measure", "closed_m", "ratio", "halved_by",
         "factor", "left", "kind")  # fmt: skip
SUMMARY = (
    "knots",
    "setpoints",
    "ticks",
    "laps",
    "lap_time_s",
    "removed_m3",
    "overbreak_m",
    "underbreak_m",
    "each_lap",
    "times_s",
    "limits_used",
    "saturated_share",
    "faults",
    "machine",
    "clearances",
    "warnings",
)
LAP = "lap", "over_m", "under_m", "removed_m3"
CLEARANCE = "part", "clearance_m", "at_m"
MARGIN = "what", "has", "needs", "unit"
# Who answers for a fault, for people.
DUE_TO = {"chosen": "your choice", "machine": "machine", "ground": "ground", "paper": "method"}
# How the first line of a file of each kind says which job it is of; wall.stl and wall.vtp have
# places of their own for it.
STAMPED = {
    ".csv": "# {}\n", ".st": "(* {} *)\n", ".c": "/* {} */\n", ".h": "/* {} */\n",
    ".xml": "<!-- {} -->\n", ".dxf": "999\n{}\n",
}  # fmt: skip


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
        Of the plan, of the wall, also where the cutter enters and leaves, and ``each_lap``: what
        the first and, beside others, the last leaves and removes; ``times_s``: what takes how long;
        ``limits_used``: the
        greatest share of each limit of the motion; ``saturated_share``: of the time that theta's
        and phi's valves are fully open; ``faults``: the error budget, each source switched on
        alone, with its greatest over- and underbreak, the closed form of its ``measure``, the
        ratio of what is simulated to it, the key of the job that halves it, as another simulation
        confirms, by which factor and what is left, and who answers for it, with None for what there
        isn't; ``machine``: what it has and needs, in the unit that each row names: as planned,
        then the greatest that the simulated laps took of power, valves and oil, and the
        damper of the ground that each joint bears and meets if the picks are in step;
        ``clearances``: how far each part of the machine keeps from the wall as planned, and where
        along the circuit; ``warnings``, sentences.
    """
    if cut.track is None:
        raise ValueError("cut: must be of simulated loops; got one without a track.")
    plan = job.planned
    found = budget(plan, *job.axes, pose=job.error, arm=job.arm, ground=job.pushing, say=say)
    faults = [
        (f.source, f.over, f.under, f.rms, f.measure, f.closed, f.ratio, *remedy, f.kind)
        for f, remedy in zip(found, halved_by(job, found, say), strict=True)
    ]
    # Where the cutter enters and leaves it may overshoot; within the wall it is meant to be.
    sides = np.concatenate([cut.before, cut.after])[:, 1:]
    over = max(0.0, float(cut.deviation.max()))
    over = max(over, float(np.max(-plan.circuit.profile.depth(*sides.T), initial=0.0)))
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
        "each_lap": _laps(cut),
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


def _laps(cut):
    """Return a row for the first lap of a cut and, if it isn't the only one, for the last."""
    found = []
    for lap in sorted({0, cut.plan.laps - 1}):
        off = cut.lap_deviations[lap]
        sizes = max(off.max(), 0.0), max(-off.min(), 0.0), cut.lap_volumes[lap]
        found.append(dict(zip(LAP, (lap + 1, *map(float, sizes)), strict=True)))
    return found


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
        if worst > SEVERAL * tolerance:
            found.append(
                f"the {name}-break of {1e3 * worst:.3g} mm is {worst / tolerance:.2g} times the "
                f"tolerance of {1e3 * tolerance:g} mm; above {SEVERAL} times this is said."
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


def _lap_line(row):
    """Return what a lap leaves and removes as a line for people."""
    which = "lap 1, in whole ground" if row["lap"] == 1 else f"lap {row['lap']}, beside another"
    return (
        f"{which}: overbreak {1e3 * row['over_m']:.3f} mm, underbreak "
        f"{1e3 * row['under_m']:.3f} mm, {1e3 * row['removed_m3']:.2f} l"
    )


@checked
def summary_text(numbers: Summary):
    """Return what `summarise` found as lines for people, lengths in mm."""
    lines = [
        f"{numbers['knots']} knots, {numbers['setpoints']} setpoints, {numbers['ticks']} ticks",
        f"{numbers['laps']} x {numbers['lap_time_s']:.1f} s, "
        f"{1e3 * numbers['removed_m3']:.2f} l removed",
        f"all together: overbreak {1e3 * numbers['overbreak_m']:.3f} mm, "
        f"underbreak {1e3 * numbers['underbreak_m']:.3f} mm",
        *(_lap_line(row) for row in numbers["each_lap"]),
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
        "each alone, in mm     over   under     rms   closed form     ratio  halved by"
        "                 left  due to",
    ]
    for fault in numbers["faults"]:
        over, under, rms = (1e3 * fault[f"{k}_m"] for k in ("over", "under", "rms"))
        form = ratio = knob = left = "-"
        if fault["closed_m"] is not None:
            form = f"{1e3 * fault['closed_m']:8.4f} {fault['measure']}"
        if fault["ratio"] is not None:
            ratio = f"{fault['ratio']:.2f}"
        if fault["halved_by"] is not None:
            knob = f"{fault['halved_by']} x {fault['factor']:.2f}"
            left = f"{fault['left']:.2f}"
        lines.append(
            f"  {fault['source']:15s} {over:8.3f}{under:8.3f}{rms:8.4f} {form:17s}{ratio:>5s}  "
            f"{knob:26s}{left:6s}{DUE_TO[fault['kind']]}"
        )
    lines += [
        "A ratio is simulated over closed form, which is for slow, small motions.",
        "What halves a source was simulated: with that key of the job multiplied so, that share of",
        "it is left; - where none of the keys tried leaves 0.4 to 0.6.",
    ]
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
        Made where it is missing; files of these names are replaced. `atomic_write.output` gives
        one whose files come into place together.
    numbers : dict
        From `summarise`, for the table of the error budget.
    say : function
        Gets a sentence for each file that is being written.

    Returns
    -------
    files : list of pathlib.Path
        Each says which job it is of.
    """
    plan = job.planned
    controller = program(plan, job)
    curves = {"SECTION": plan.circuit.section, "CENTRE": plan.circuit.profile}
    makers = {
        "budget.csv": lambda: _table(numbers["faults"]),
        "knots.csv": lambda: knots_csv(plan),
        "setpoints.csv": lambda: setpoints_csv(plan),
        "setvalues.csv": lambda: setvalues_csv(plan),
        "line.st": lambda: line_text(parts=1),
        "line.c": line_c99,
        "controller.h": lambda: c99_header(controller),
        "controller.c": lambda: c99_text(controller),
        "controller.st": lambda: controller.text,
        "controller.xml": lambda: plcopen_xml(controller),
        "section.dxf": lambda: dxf(curves),
        "wall.vtp": lambda: vtp_blocks(wall_surface(cut.wall, plan.circuit), job.stamp),
        "wall.stl": lambda: stl_blocks(wall_solid(cut.wall), job.stamp),
    }
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, make in makers.items():
        say(f"writing {name}")
        files.append(folder / name)
        content = make()
        if isinstance(content, str):
            head = STAMPED[files[-1].suffix].format(job.stamp)
            content = [head.encode(), content.encode()]
        with files[-1].open("wb") as file:
            file.writelines(content)  # block by block, since a wall may be large
    return files


def _table(rows):
    """Return rows of the same names as a table."""
    text = io.StringIO()
    table = csv.DictWriter(text, FAULT, lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()
