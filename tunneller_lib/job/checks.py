"""The check of a job before any wall is simulated: what `cut` and its dry run refuse or warn of.

Causes come before their symptoms: a valve that is fully open before the error that it leaves, and
that error before the trip of the controller that is written. Where a value is refused, another one
is named with which the job passes: it has been tried.
"""

from dataclasses import replace

import numpy as np

from ..motion.hydraulics import STROKE_MARGIN
from ..motion.sizing import axes_of
from ..motion.stability import gain_limit
from ..ream import part_clearances
from ..ream.face import BESIDE
from ..ream.margins import JOINTS, PLACES
from .reader import CYLINDERS, FEELING, HYDRAULICS, LENGTH, MOST_RAYS, TABLES, VALVE

ACROSS = 4  # rays across a groove in whole ground, at least
BESIDE_EACH_OTHER = 2  # rays along half of it round the tunnel, at least, on average
SLOWER = 0.7 ** np.arange(1, 11)  # times the feed, as they are tried


def check(job):
    """Return the warnings of a `Job` that needs no simulated wall, or raise ValueError.

    Refused is what would make the cut meaningless; what only the exported controller can't keep is
    the last of the warnings.
    """
    check_gain(job)
    found = off_course(job)
    if found:
        raise ValueError(with_remedy(job, found, lambda other: not off_course(other)))
    _check_advance(job)
    _check_wall(job)
    return [*_warnings(job), *filter(None, [job.exported.left_out])]


def check_gain(job):
    """Raise ValueError if a position loop of a job is unstable at an angle of its run."""
    name, limit, loop = min(_gain_limits(job), key=lambda found: found[1])
    if loop.gain >= limit:
        raise ValueError(
            f"[controller] gain: must be below the {limit:.3g} 1/s from which {name}'s loop is "
            f"unstable at its tick and delay; got {loop.gain:g} 1/s, {short(limit / 2):g} 1/s "
            "would do."
        )


def _gain_limits(job):
    """Yield each joint's name, the gain in 1/s from which it is unstable, and its loop."""
    plan = job.planned
    at = plan.circuit.position(np.linspace(0, plan.circuit.profile.perimeter, PLACES))
    every = np.concatenate([plan.entry.setvalues, plan.setvalues])
    judged = np.linspace(every.min(axis=0), every.max(axis=0), 5)  # as a `Track` judges itself
    angles = np.concatenate([at, judged]).T
    for name, plant, loop, one in zip(JOINTS, *job.axes, angles, strict=True):
        yield name, gain_limit(plant, loop, one), loop


def off_course(job):
    """Return why the cutter misses the wall by more than it cuts, as a lap in air says, or ""."""
    plan = job.planned
    try:
        track = job.in_air
    except ValueError as error:  # beyond a stroke, or too stiff to be integrated
        return f"a lap in air fails ({_reason(error)})"
    first = int(plan.entry.ticks.sum())
    lap = track.position[first : first + int(plan.ticks.sum()) + 1]
    off = float(np.abs(plan.circuit.overbreak(lap)).max())
    depth = plan.circuit.machine.depth
    if off <= depth:
        return ""
    missed = f"the cutter is up to {off:.2g} m off its way, more than its depth of cut {depth:g} m"
    return f"{opened}, and {missed}" if (opened := fully_open(track)) else f"in air {missed}"


def fully_open(track):
    """Return which joint's valve is fully open in a lap in air, and for how long, or ""."""
    joint = int(np.argmax(track.saturated_share))
    share = track.saturated_share[joint]
    if not share:
        return ""
    return f"{JOINTS[joint]}'s valve is fully open for {100 * share:.2g} % of a lap in air"


def with_remedy(job, found, works):
    """Return the sentence that a job is refused with for what is `found`.

    Parameters
    ----------
    job : Job
        The job.
    found : str
        What is wrong.
    works : callable
        Tells whether a changed job has it no more.
    """
    for table, key, value in _tries(job):
        if _works(with_value(job, table, key, value), works):
            unit = getattr(TABLES[table][key], "unit", "")  # a whole number has none
            had = getattr(job, table).get(key)
            got = "none" if had is None else f"{had:g} {unit}".rstrip()
            return f"[{table}] {key}: {found}; got {got}, {f'{value:g} {unit}'.rstrip()} would do."
    if job.hydraulics and _works(replace(job, hydraulics={}), works):
        return f"[hydraulics] {', '.join(job.hydraulics)}: {found}; the usual sizes would do."
    return f"[limits] feed: {found}; no lower feed alone would do."


def _works(job, works):
    """Return whether a job can be planned, is stable and `works`."""
    try:
        check_gain(job)
        return works(job)
    except ValueError:
        return False


def with_value(job, table, key, value):
    """Return a job with another value."""
    return replace(job, **{table: {**getattr(job, table), key: value}})


def _tries(job):
    """Yield table, key and value of single changes, the likely causes first.

    These are sizes that aren't usual, then what a fully open valve calls for, or else the loop.
    """
    if job.plan["tolerance"] >= job.made.depth:
        yield "plan", "tolerance", short(job.made.depth / 10)
    usual = replace(job, hydraulics={})
    for key in job.hydraulics:
        yield "hydraulics", key, short(size_of(usual, key))
    slower = [("limits", "feed", short(share * job.limits["feed"])) for share in SLOWER]
    if job.oily and job.limits.get("valve", 1) > VALVE:
        slower.insert(0, ("limits", "valve", VALVE))
    half = short(min(limit for _, limit, _ in _gain_limits(job)) / 2)
    loop = [("controller", "feedforward", 1.0), ("controller", "gain", half)]
    loop += [("controller", "delay", 0)]
    try:
        opened = fully_open(job.in_air)
    except ValueError:
        opened = ""
    yield from (slower + loop if opened else loop + slower)


def size_of(job, key):
    """Return the size of a job's hydraulics that a `key` of its table names."""
    joint, _, name = key.partition("_")
    if name in CYLINDERS:
        return getattr(getattr(job.sizes, joint), CYLINDERS[name])
    return getattr(job.sizes, key)


def short(value):
    """Return a value of two digits."""
    return float(f"{value:.2g}")


def _reason(error):
    """Return what an error says of an argument, without the argument's name and the full stop."""
    return str(error).partition(": ")[2].rstrip(".")


def cylinders_remedy(job, error):
    """Return the sentence that refuses a job's cylinders for an `error` of their classes."""
    for key in job.hydraulics:
        rest = {name: value for name, value in job.hydraulics.items() if name != key}
        other = replace(job, hydraulics=rest)
        if _has_cylinders(other):
            unit = HYDRAULICS[key].unit
            usual = f"{size_of(other, key):.3g} {unit}".rstrip()
            said = str(error).removeprefix(f"{key}: ").rstrip(".")
            return f"[hydraulics] {key}: {said}; the usual {usual} would do."
    for joint, name in zip(JOINTS, ("lift", "swing"), strict=True):
        link = getattr(job.sizes, name)
        given = np.degrees([job.machine[f"{joint}_min"], job.machine[f"{joint}_max"]])
        if _fits(link, *given):
            continue
        would_do = _limits_that_fit(job, joint, link, given)
        shorter = _dead_length_that_fits(link, given)
        remedies = ['[controller] plant = "T0", which has no cylinders']
        if shorter:
            remedies.insert(0, f"[hydraulics] {name}_dead_length = {shorter:g}")
        if would_do:
            low, high = would_do
            remedies.insert(0, f"{joint}_min_deg = {low:g} with {joint}_max_deg = {high:g}")
        return (
            f"[machine] {joint}_min, {joint}_max: the {name} can't serve these limits; "
            f"{str(error).rstrip('.')}; {', or '.join(remedies)}, would do."
        )
    return (
        f'[hydraulics] {error} The sizes are those of [hydraulics], or take plant = "T0" in '
        "[controller], which has no cylinders."
    )


def _has_cylinders(job):
    try:
        return bool(axes_of(job.made, job.sizes))
    except ValueError:
        return False


def _fits(link, low, high):
    """Return whether a linkage allows joint limits in degrees."""
    try:
        link.check(*(np.radians((low, high)) + np.array([-1, 1]) * STROKE_MARGIN))
    except ValueError:
        return False
    return True


def _limits_that_fit(job, joint, link, given):
    """Return joint limits in whole degrees that a linkage allows and that reach the section."""
    reach = np.degrees(job.circuit.reach())[:, JOINTS.index(joint)]
    least, most = np.floor(reach[0]), np.ceil(reach[1])
    if link.pair:  # as far to either side
        most = max(-least, most)
        least, given = -most, np.array([-1, 1]) * min(-given[0], given[1])
    for share in np.linspace(1, 0, 41):
        low = np.ceil(least + share * (given[0] - least))
        high = np.floor(most + share * (given[1] - most))
        if low <= least and most <= high and _fits(link, low, high):
            return low, high
    return None


def _dead_length_that_fits(link, given):
    """Return a dead length in m with which a linkage allows joint limits in degrees, or None."""
    ends = np.radians(given) + np.array([-1, 1]) * STROKE_MARGIN
    shortest, longest = sorted(map(link.length, ends.tolist()))
    dead = np.floor(1e3 * (2 * shortest - longest)) / 1e3
    if dead >= LENGTH.least and _fits(replace(link, dead_length=dead), *given):
        return float(dead)
    return None


def groove_of(machine):
    """Return the width in m of a groove that a machine's ball cuts in whole ground."""
    return 2 * np.sqrt(machine.depth * (2 * machine.cutter_radius - machine.depth))


def _check_advance(job):
    """Raise ValueError if all laps would cut the same groove."""
    plan = job.planned
    if plan.laps > 1 and not plan.advance:
        # Between passes a ball leaves cusps of advance^2 / (8 radius).
        cusps = short(np.sqrt(8 * plan.circuit.machine.cutter_radius * job.plan["tolerance"]))
        raise ValueError(
            f"[plan] advance: must be above 0 for {plan.laps} laps, or all cut the same groove; "
            f"got 0 m, {cusps:g} m would do."
        )


def _check_wall(job):
    """Raise ValueError if the rays of the wall are too far apart for its grooves, or too short."""
    plan = job.planned
    machine, section = plan.circuit.machine, plan.circuit.section
    groove = groove_of(machine)
    apart = min(groove / ACROSS, plan.advance or np.inf) if plan.laps > 1 else groove / ACROSS
    run = np.concatenate([plan.entry.setpoints, plan.setpoints])
    x = plan.circuit.in_tunnel(machine.torus.point(*run.T))[:, 0]
    lap = float(np.ptp(x)) + 2 * machine.cutter_radius + 2 * BESIDE * (job.pushing is not None)
    ways = {
        "along": (lap + plan.advance * (plan.laps - 1), apart, "along the tunnel"),
        "around": (section.perimeter, groove / BESIDE_EACH_OTHER, "round it"),
    }
    for key, (length, most, where) in ways.items():
        needs, given = int(np.ceil(length / most)), job.wall[key]
        other = job.wall["around" if key == "along" else "along"]
        if needs * other > MOST_RAYS:
            fits = int(1 + (MOST_RAYS // other * most - lap) / (plan.advance or np.inf))
            if key == "along" and 1 <= fits < plan.laps:
                raise ValueError(
                    f"[plan] laps: {length:.3g} m of wall need {needs} rays along it, and "
                    f"{other} around leave room for {MOST_RAYS // other}; got {plan.laps}, "
                    f"{fits} would do."
                )
        if given < needs:
            raise ValueError(
                f"[wall] {key}: rays {where} must be at most {most:.2g} m apart to show a groove "
                f"{groove:.2g} m wide; got {given} on {length:.3g} m, {needs} would do."
            )
    if not section.depth(0.0, 0.0) > 0:
        y, z = section.box.mean(axis=0)
        raise ValueError(
            "[section] pieces: must have the origin y = z = 0 inside; with each y less "
            f"{y:.3g} m and each z, as [machine] height, less {z:.3g} m it has."
        )
    angle = (np.arange(job.wall["around"]) + 0.5) * 2 * np.pi / job.wall["around"]
    cut = float((section.offset(-machine.depth).ray(angle) - section.ray(angle)).max())
    cut += machine.depth + (np.hypot(job.error.y, job.error.z) if job.error else 0.0)
    if job.wall["thickness"] < cut:
        raise ValueError(
            f"[wall] thickness: must be at least {cut:.2g} m along its rays, to hold the cut, the "
            f"[pose] and as much overbreak as the cut is deep; got {job.wall['thickness']:g} m, "
            f"{short(1.2 * cut):g} m would do."
        )


def _warnings(job):
    """Return sentences about what may be wrong with a job, or what its machine lacks."""
    plan = job.planned
    depth, tolerance = job.machine["depth"], job.plan["tolerance"]
    found = [str(margin) for margin in job.margins if not margin.enough]
    if tolerance >= depth:
        found.append(
            f"[plan] tolerance: {tolerance:g} m isn't below the depth of cut {depth:g} m; "
            "are all sizes in metres?"
        )
    if plan.laps > 1 and plan.advance >= groove_of(plan.circuit.machine):
        found.append(
            f"[plan] advance: {plan.advance:g} m is more than a groove is wide, "
            f"{groove_of(plan.circuit.machine):.2g} m; ground stands between the laps."
        )
    if job.error is not None:
        arm_radius = job.plan.get("arm_radius", 0.0)
        parts = part_clearances(plan.circuit, arm_radius, pose=job.error)
        found += [
            f"the machine's {part.name} {part.depth_in_wall}, where it stands by [pose]."
            for part in parts
            if part.collides
        ]
    if job.ground and job.pushing is None:
        found.append(
            '[ground]: only limits the feed, since only plant = "T3" feels its force; the wall\'s '
            "error lacks it."
        )
    if not job.ground and job.controller["plant"] == FEELING:
        found.append("[ground]: is missing, so that nothing pushes back on the axes.")
    return found
