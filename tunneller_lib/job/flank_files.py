"""The files of flank milling: positions, paths, the machine's axes, and the milled surface."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..milling.nurbs import MOST_DEGREE
from ..milling.positions import counted_states, reasons_of
from ..milling.tour import TRAVERSE
from .atomic_write import write
from .flank import FlankJob, FlankResult
from .mesh import Mesh, ply, stl, vertex_normals, vtp

TOLERANCES = 10e-6, 50e-6, 100e-6  # m, within which shares of the patch are said
COLOURED = 100e-6  # m, left or cut, that has the full colour
ERROR = "error / um"
SHORT = 120.0  # s, below which times are in seconds for people, else in minutes
WRITTEN = 1e-9  # m, the last digit of a place in cutter location data


@checked
def summarise_flank(job: FlankJob, result: FlankResult):
    """Return what came of a flank job as a dict, ready for JSON, in SI units.

    Parameters
    ----------
    job : FlankJob
        What was asked for.
    result : FlankResult
        From its `solved`.

    Returns
    -------
    numbers : dict
        ``positions`` by their reasons, of all mills and of each in ``mills``, ``chains`` with
        their mill, counted from 1, lengths and ends, ``covered`` shares, ``gouge_m``, ``scallops``
        with their number, median and greatest height and the median ``kink_rad``,
        ``surface_error`` of a surface through measured points, ``tour`` with places by kind, or
        null, ``seconds``, the least that feed, speeds and accelerations allow, or null, and
        ``warnings``.
    """
    found = result.found
    covered = result.covered
    warnings = []
    state = found[0].state
    unfit = state[state != "regular"]
    if unfit.size:
        warnings.append(
            f"no mill can fit where the surface is no regular saddle: of {state.size} points "
            f"are {counted_states(unfit)}."
        )
    surface = job.surface
    if surface["kind"] == "nurbs":
        n, m, _ = np.shape(surface["control"])
        degrees = len(surface["knots_s"]) - n - 1, len(surface["knots_t"]) - m - 1
        if min(degrees) < 5:
            warnings.append(
                "the surface's degree is below 5: where a knot is crossed positions may jump; "
                f"its degrees are {degrees[0]} and {degrees[1]}, of at most {MOST_DEGREE}."
            )
    height = result.scallops.height
    scallops = {"lines": len(height)}
    if len(height):
        scallops |= {"median_m": float(np.median(height)), "greatest_m": float(height.max())}
        met = result.scallops.kink[np.isfinite(result.scallops.kink)]
        scallops["kink_rad"] = float(np.median(met)) if len(met) else None
    places = Counter(kind for tour in result.tours for kind in tour.kind.tolist())
    return {
        "points": int(state.size),
        "positions": reasons_of(found),
        "mills": [reasons_of([here]) for here in found],
        "chains": [
            {"mill": number, "positions": len(chain), "ends": list(chain.ends)}
            for number, chain in zip(_numbers(job, covered.mills), covered.chains, strict=True)
        ],
        "covered": {f"{within:g}": covered.share(within) for within in TOLERANCES},
        "gouge_m": max(0.0, -float(covered.error.min())),
        "scallops": scallops,
        "surface_error": job.surface_error,
        "tour": dict(places) or None,
        "seconds": float(sum(map(sum, _seconds(result)))) if job.feed else None,
        "warnings": warnings,
    }


def _numbers(job, mills):
    """Return the numbers, from 1, of mills of a job."""
    return [job.tools.index(mill) + 1 for mill in mills]


def _tours(job, result):
    """Yield of each tour its mill, the number of its first chain, from 0, and itself."""
    for first, tour in zip(result.begins, result.tours, strict=True):
        yield result.covered.mills[first], first, tour


def _seconds(result):
    """Return for each tour the least times (k,), in s, of its steps; NaN without a feed."""
    return result.seconds or [np.full(len(tour), np.nan) for tour in result.tours]


def _lasting(seconds):
    """Return a number and its unit, s or min, for how long something lasts."""
    return (seconds, "s") if seconds < SHORT else (seconds / 60, "min")


def _numbers_of(name, value):
    """Return `value`, which must be a dict as `summarise_flank` makes it."""
    if not isinstance(value, dict) or "gouge_m" not in value:
        raise ValueError(f"{name}: must be a dict from summarise_flank; got {shown(value)}.")
    return value


Flanked = Annotated[dict, Rule("dict", _numbers_of)]


@checked
def flank_text(numbers: Flanked):
    """Return what `summarise_flank` found, `numbers`, as lines for people."""
    several = len(numbers["mills"]) > 1
    lines = []
    for k, reasons in enumerate(numbers["mills"], start=1):
        lines += [f"mill {k}:"] if several else []
        lines += [f"{n:6d} positions: {why}" for why, n in reasons.items()]
    for k, chain in enumerate(numbers["chains"], start=1):
        by = f" of mill {chain['mill']}" if several else ""
        ends = "; ".join(chain["ends"])
        lines.append(f"chain {k}: {chain['positions']} positions{by}; its ends: {ends}")
    lines += [
        f"{100 * share:6.1f} % of the patch is milled to within {1e6 * float(within):g} um"
        for within, share in numbers["covered"].items()
    ]
    lines.append(f"{1e6 * numbers['gouge_m']:6.1f} um is the deepest that the mill enters it")
    scallops = numbers["scallops"]
    if scallops["lines"]:
        lines.append(
            f"{1e6 * scallops['median_m']:6.1f} um is the median scallop between strips, "
            f"{1e6 * scallops['greatest_m']:.1f} um the highest"
        )
        if scallops["kink_rad"] is not None:
            lines.append(
                f"{1e3 * scallops['kink_rad']:6.1f} mrad is the median kink where they meet"
            )
    if numbers["seconds"] is not None:
        number, unit = _lasting(numbers["seconds"])
        lines.append(
            f"{number:6.1f} {unit} is the least time that feed, speeds and accelerations allow"
        )
    error = numbers["surface_error"]
    if error:
        lines.append(
            f"{1e6 * error['position_m']:6.1f} um, {1e3 * error['normal_rad']:.2g} mrad and "
            f"{error['curvature_1_m']:.2g} 1/m are the greatest standard errors of the surface's "
            "points, normals and curvatures"
        )
    return "\n".join(lines)


@checked
def positions_csv(result: FlankResult):
    """Return all positions as a table: contact, tip, axis, depths in m, and the reason."""
    names = ["mill", "point", "s", "t", "contact_x_m", "contact_y_m", "contact_z_m", "tip_x_m",
             "tip_y_m", "tip_z_m", "axis_x", "axis_y", "axis_z", "enters_m", "holder_enters_m",
             "others_enter_m", "reason"]  # fmt: skip
    lines = ["# positions of conical mills: lengths in m; inf where a depth wasn't asked for"]
    lines.append(",".join(names))
    for k, found in enumerate(result.found, start=1):
        numbers = np.column_stack([
            found.s, found.t, found.contact, found.tip, found.axis, found.enters,
            found.holder_enters, found.others_enter,
        ])  # fmt: skip
        lines += [
            ",".join([str(k), str(int(index)), *map(repr, row.tolist()), why])
            for index, row, why in zip(found.index, numbers, found.reason.tolist(), strict=True)
        ]
    return "\n".join(lines) + "\n"


@checked
def paths_csv(job: FlankJob, result: FlankResult):
    """Return the chains as a table: chain, mill, position, tip in m, unit axis, contact in m."""
    names = ["chain", "mill", "position", "tip_x_m", "tip_y_m", "tip_z_m", "axis_x", "axis_y",
             "axis_z", "contact_x_m", "contact_y_m", "contact_z_m"]  # fmt: skip
    lines = ["# positions along chains: the tip's middle in m, the axis towards the spindle"]
    lines.append(",".join(names))
    covered = result.covered
    numbers = _numbers(job, covered.mills)
    for k, (number, chain) in enumerate(zip(numbers, covered.chains, strict=True), start=1):
        table = np.concatenate([chain.tip, chain.axis, chain.contact], axis=1)
        lines += [
            ",".join([str(k), str(number), str(i), *map(repr, row)])
            for i, row in enumerate(table.tolist(), start=1)
        ]
    return "\n".join(lines) + "\n"


@checked
def tours_csv(job: FlankJob, result: FlankResult):
    """Return the tours as a table: how the mill gets to each place, least time, axes, tip, axis."""
    names = ["motion", "chain", "mill", "least_time_s", "x_mm", "y_mm", "z_mm", "A_deg", "C_deg",
             "tip_x_m", "tip_y_m", "tip_z_m", "axis_x", "axis_y", "axis_z"]  # fmt: skip
    lines = [
        "# the machine's axes: x, y, z in mm, A and C in degrees; tip and axis of the mill on the "
        "workpiece in m; least time from the place before, nan without a feed",
        ",".join(names),
    ]
    seconds = _seconds(result)
    for (mill, first, tour), least in zip(_tours(job, result), seconds, strict=True):
        [number] = _numbers(job, [mill])
        values = np.column_stack([1e3 * tour.values[:, :3], np.degrees(tour.values[:, 3:])])
        rows = zip(
            tour.kind.tolist(),
            (tour.chain + first + 1).tolist(),
            np.round(np.column_stack([least, values]), 6).tolist(),
            np.column_stack([tour.tip, tour.axis]).tolist(),
            strict=True,
        )
        lines += [",".join([kind, str(k), str(number), *map(repr, [*a, *b])])
                  for kind, k, a, b in rows]  # fmt: skip
    return "\n".join(lines) + "\n"


@checked
def cl_text(job: FlankJob, result: FlankResult):
    """Return chains, or tours, as cutter location data in the manner of APT, in mm.

    Only what a tour traverses is rapid: an approach may meet the stock. A feed is the mean one of
    the tip over a step, in mm/min, that follows from its least time; where the tip stays where it
    is, to the last digit that is written, the feed before goes on.
    """
    lines = [
        "PARTNO/FLANK MILLING WITH A CONE",
        "UNITS/MM",
        "$$ GOTO: middle of the tip, then the axis towards the spindle",
    ]
    covered = result.covered
    loaded = None
    seconds = _seconds(result)
    for k, (mill, chain) in enumerate(zip(covered.mills, covered.chains, strict=True)):
        if mill != loaded:
            lines += _loaded(mill, *_numbers(job, [mill]))
            loaded = mill
            if result.tours:
                place = result.begins.index(k)
                lines += _toured(result.tours[place], k, seconds[place])
        if not result.tours:
            lines.append(f"$$ CHAIN {k + 1}; THE WAY TO IT AND FROM IT IS NOT PLANNED")
            lines += _gotos(chain.tip, chain.axis)
    return "\n".join([*lines, "FINI"]) + "\n"


def _loaded(mill, number):
    """Return lines that take a mill."""
    radius = 1e3 * mill.tip_radius
    return [
        f"LOADTL/{number}",
        f"CUTTER/{2 * radius:.6f},0,{radius:.6f},0,0,{np.degrees(mill.half_angle):.6f},"
        f"{1e3 * mill.length:.6f}",
        "MULTAX/ON",
    ]


def _toured(tour, first, seconds):
    """Return lines for a tour whose first chain has a number, from 0, with feeds where known."""
    lines = ["$$ THE WAY TO THE FIRST PLACE IS NOT PLANNED"]
    if np.isfinite(seconds).all():
        number, unit = _lasting(seconds.sum())
        lines.append(f"$$ FROM THERE {number:.1f} {unit.upper()} AT LEAST, EACH PART REST TO REST")
    moved = np.linalg.norm(np.diff(tour.tip, axis=0, prepend=tour.tip[:1]), axis=-1)
    begins = np.append(True, tour.kind[1:] != tour.kind[:-1])
    last = None
    for k, goto in enumerate(_gotos(tour.tip, tour.axis)):
        if begins[k]:
            lines.append(f"$$ {tour.kind[k].upper()}, CHAIN {tour.chain[k] + first + 1}")
        if tour.kind[k] == TRAVERSE:
            lines.append("RAPID")
        elif seconds[k] > 0 and moved[k] > WRITTEN:
            feed = f"FEDRAT/{_floored(6e4 * moved[k] / seconds[k])},MMPM"
            lines += [feed] if feed != last else []
            last = feed
        lines.append(goto)
    return lines


def _floored(number):
    """Return a number above zero with three digits, rounded down but for last bits."""
    number = number * (1 + 1e-9)
    digits = 2 - int(np.floor(np.log10(number)))
    return f"{np.floor(number * 10.0**digits) / 10.0**digits:.{max(digits, 0)}f}"


def _gotos(tip, axis):
    """Return a line for each position, tip (k, 3) in mm and axis (k, 3)."""
    return [
        "GOTO/" + ",".join([*(f"{1e3 * c:.6f}" for c in at), *(f"{c:.9f}" for c in along)])
        for at, along in zip(tip, axis, strict=True)
    ]


@checked
def milled_surface(job: FlankJob, result: FlankResult):
    """Return the surface that a job leaves as a `Mesh` of triangles, coloured by what is left.

    Points of the patch, moved along its normal by what is left of it or cut from it, at most by the
    job's stock: between strips and beyond them the stock stands.
    """
    error = result.covered.error
    n = len(error)
    corners = np.arange(n * n).reshape(n, n)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    faces = np.concatenate(
        [np.stack(one, axis=-1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))]
    )
    faces = faces[:, :: job.patch.side]  # outside is where the mill comes from
    left = np.minimum(error.ravel(), job.paths["stock"])
    flat = job.patch.mesh(n).reshape(-1, 3)
    normal = vertex_normals(Mesh(flat, faces))
    return Mesh(flat + left[:, None] * normal, faces, {ERROR: 1e6 * left})


@checked
def write_flank(job: FlankJob, result: FlankResult, folder: Path, say: Callable[[str], object]):
    """Write the files of a flank job into a folder, and return their paths.

    Parameters
    ----------
    job : FlankJob
        What was asked for.
    result : FlankResult
        From its `solved`.
    folder : pathlib.Path
        Made where it is missing; files of these names are replaced.
    say : function
        Gets a sentence for each file that is being written.

    Returns
    -------
    files : list of pathlib.Path
    """
    milled = milled_surface(job, result)
    contents = {
        "positions.csv": positions_csv(result),
        "paths.csv": paths_csv(job, result),
        "paths.apt": cl_text(job, result),
        "milled.vtp": vtp(milled),
        "milled.stl": stl(milled),
        "milled.ply": ply(milled, ERROR, 1e6 * COLOURED),
    }
    if result.tours:
        contents["axes.csv"] = tours_csv(job, result)
    files = []
    for name, content in contents.items():
        say(f"writing {name}")
        files.append(write(folder / name, content))
    return files
