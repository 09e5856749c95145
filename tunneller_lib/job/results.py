"""The results of a job: numbers, lines for people, and files for other programs."""

import numpy as np

from ..atomic_write import writing
from ..motion.export import line_c99, line_text
from ..ream import budget
from ..ream.margins import used
from .controller_texts import c99_header, c99_text, plcopen_xml
from .csv_tables import knots_csv, plan_csv, setpoints_csv, setvalues_csv, table
from .drawing import dxf
from .mesh import stl, wall_solid
from .remedies import halved_by

SEVERAL = 3  # times the tolerance, above which an over- or underbreak is worth a warning
FAULT = "source", "over_m", "under_m", "rms_m", "measure", "closed_m", "ratio"
HALVED = "halved_by", "factor", "left"
LAP = "lap", "over_m", "under_m", "removed_m3"
CLEARANCE = "part", "clearance_m", "at_m"
MARGIN = "what", "has", "needs", "unit"
# The kinds of faults, as people read them.
DUE_TO = {"chosen": "your choice", "machine": "machine", "ground": "ground", "paper": "method"}
# The first line of a text, which says of which job it is; a table has nothing but rows.
STAMPED = {".st": "(* {} *)\n", ".xml": "<!-- {} -->\n", ".dxf": "999\n{}\n"}
STAMPED |= dict.fromkeys((".c", ".h"), "/* {} */\n")


def plan_numbers(job):
    """Return the numbers of a planned `Job`, in SI units, ready for JSON."""
    plan = job.planned
    return {
        "knots": len(plan.knots),
        "setpoints": len(plan.s) - 1,
        "ticks": int(plan.ticks.sum()),
        "laps": plan.laps,
        "lap_time_s": plan.lap_time,
        "times_s": plan.times,
        "limits_used": plan.shares,
        "machine": [dict(zip(MARGIN, margin, strict=False)) for margin in job.margins],
        "clearances": [dict(zip(CLEARANCE, part, strict=True)) for part in plan.clearances],
        "warnings": job.checked,
    }


def summarise(job, cut, say=None):
    """Return the numbers of a `Job` and its simulated `Cut`, in SI units, ready for JSON.

    report/guide/command.md lists them. `say` is called with sentences about the progress.
    """
    plan = job.planned
    found = budget(plan, *job.axes, pose=job.error, arm=job.arm, ground=job.pushing, say=say)
    faults = []
    for f, remedy in zip(found, halved_by(job, found, say), strict=True):
        row = f.source, f.over, f.under, f.rms, f.measure, f.closed, f.ratio
        halved = dict(zip(HALVED, remedy, strict=True))
        faults.append(dict(zip(FAULT, row, strict=True)) | halved | {"kind": f.kind})
    beside = [*used(plan, job.axes[0], cut, job.sizes), *job.in_step]
    numbers = plan_numbers(job)
    # On entry and exit an overshoot counts; being short of the wall is no underbreak there.
    sides = np.concatenate([cut.before, cut.after])[:, 1:]
    over = max(0.0, float(cut.deviation.max()))
    over = max(over, float(np.max(-plan.circuit.profile.depth(*sides.T), initial=0.0)))
    under = max(float(-cut.deviation.min()), 0.0)
    return {
        **numbers,
        "machine": numbers["machine"] + [dict(zip(MARGIN, one, strict=False)) for one in beside],
        "removed_m3": float(cut.removed.sum()) + cut.plunged,
        "overbreak_m": over,
        "underbreak_m": under,
        "each_lap": _laps(cut),
        "saturated_share": cut.track.saturated_share.tolist(),
        "faults": faults,
        "warnings": [*job.checked, *_warnings(job, over, under), *_strained(cut)],
    }


def _laps(cut):
    """Return a row for the first lap of a cut and, if there are several, one for the last."""
    found = []
    for lap in sorted({0, cut.plan.laps - 1}):
        off = cut.lap_deviations[lap]
        sizes = max(off.max(), 0.0), max(-off.min(), 0.0), cut.lap_volumes[lap]
        found.append(dict(zip(LAP, (lap + 1, *map(float, sizes)), strict=True)))
    return found


def _warnings(job, over, under):
    """Return sentences about results so large that the job may contain a mistake."""
    tolerance = job.plan["tolerance"]
    found = []
    for name, worst in (("over", over), ("under", under)):
        if worst > SEVERAL * tolerance:
            found.append(
                f"the {name}break of {1e3 * worst:.3g} mm is {worst / tolerance:.2g} times the "
                f"tolerance of {1e3 * tolerance:g} mm; this warning begins at {SEVERAL} times."
            )
    return found


def _strained(cut):
    """Return sentences about valves that were fully open."""
    found = []
    for joint, share in zip(("theta", "phi"), cut.track.saturated_share, strict=True):
        if share > 0:
            found.append(
                f"{joint}'s valve is fully open for {100 * share:.2g} % of the time, and the axis "
                "lags behind; a lower [limits] feed or power would do."
            )
    return found


def _lap_line(row):
    """Return a line about what a lap leaves and removes."""
    which = "lap 1, in whole ground" if row["lap"] == 1 else f"lap {row['lap']}, beside another"
    return (
        f"{which}: overbreak {1e3 * row['over_m']:.2f} mm, underbreak "
        f"{1e3 * row['under_m']:.2f} mm, {1e3 * row['removed_m3']:.2f} l"
    )


def plan_text(numbers):
    """Return the `numbers` of `plan_numbers` as lines for people, lengths in mm."""
    *parts, cutter = numbers["clearances"]
    used = ((name.replace("_", " "), share) for name, share in numbers["limits_used"].items())
    lines = [
        f"{numbers['knots']} knots, {numbers['setpoints']} setpoints, {numbers['ticks']} ticks",
        f"{numbers['laps']} x {numbers['lap_time_s']:.1f} s",
        "time in s: " + _listed(numbers["times_s"].items(), ".2f"),
        "limits used: " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in used if share),
        "clear of the wall, in mm: "
        + _listed(((row["part"], 1e3 * row["clearance_m"]) for row in parts), ".1f")
        + f"; the cutter reaches {-1e3 * cutter['clearance_m']:.1f} into it",
    ]
    if numbers["machine"]:
        lines += ["", "the machine            has      needs"]
    for row in numbers["machine"]:
        lines.append(
            f"  {row['what']:19s} {row['has']:8.3g}  {row['needs']:8.3g} {row['unit']}".rstrip()
            + ("" if row["has"] > row["needs"] else ", less than needed")
        )
    if any(row["what"].startswith("in step") for row in numbers["machine"]):
        lines += [
            "in step: the ground's damper if picks follow each other in one track; a joint that",
            "has less would chatter at any feed; the budget assumes that picks aren't in step",
        ]
    return "\n".join(lines)


def _listed(pairs, form):
    """Return pairs of a name and a number as one line."""
    return ", ".join(f"{name} {number:{form}}" for name, number in pairs)


def summary_text(numbers):
    """Return the `numbers` of `summarise` as lines for people, lengths in mm."""
    valves = zip(("theta", "phi"), numbers["saturated_share"], strict=True)
    lines = [
        plan_text(numbers),
        "",
        # To a hundredth: force and motion agree to 0.3 %, and a count read otherwise moves 1e-3 mm.
        f"all together: overbreak {1e3 * numbers['overbreak_m']:.2f} mm, underbreak "
        f"{1e3 * numbers['underbreak_m']:.2f} mm, {1e3 * numbers['removed_m3']:.2f} l removed",
        *(_lap_line(row) for row in numbers["each_lap"]),
        "time with a valve fully open: "
        + ", ".join(f"{joint} {100 * share:.2g} %" for joint, share in valves),
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
        "What halves a source was simulated: with that key of the job times the factor, the given",
        "share is left; - means that none of the keys tried leaves 0.4 to 0.6.",
    ]
    return "\n".join(lines)


def write_all(job, cut, folder, numbers, say):
    """Write the files of a job and its cut, without pictures, into a new `folder`.

    Return their paths. The controller's are left out if it can't keep the plan. The `numbers` are
    those of `summarise`; `say` gets the files' names.
    """
    plan = job.planned
    controller = job.exported.program
    section = plan.circuit.section
    wall = section.offset(-plan.circuit.machine.depth)
    curves = {"SECTION": section, "WALL": wall, "CENTRE": plan.circuit.profile}
    makers = {
        "budget.csv": lambda: table(numbers["faults"]),
        "plan.csv": lambda: plan_csv(plan, job.stamp),
        "knots.csv": lambda: knots_csv(plan),
        "setpoints.csv": lambda: setpoints_csv(plan),
        "setvalues.csv": lambda: setvalues_csv(plan),
        "section.dxf": lambda: dxf(curves),
        "wall.stl": lambda: stl(*wall_solid(cut.wall), job.stamp),
    }
    if controller:
        makers |= {
            "line.st": lambda: line_text(parts=1),
            "line.c": line_c99,
            "controller.h": lambda: c99_header(controller),
            "controller.c": lambda: c99_text(controller),
            "controller.st": lambda: controller.text,
            "blocks.st": lambda: controller.blocks,
            "controller.xml": lambda: plcopen_xml(controller),
        }
    folder.mkdir(parents=True)
    files = [folder / name for name in makers]
    for file, make in zip(files, makers.values(), strict=True):
        say(f"writing {file.name}")
        content = make()
        if isinstance(content, str):
            content = [(STAMPED.get(file.suffix, "").format(job.stamp) + content).encode()]
        with writing(file), file.open("wb") as opened:
            opened.writelines(content)  # in blocks, since a wall may be large
    return files
