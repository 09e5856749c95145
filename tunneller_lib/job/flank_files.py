"""The files of flank milling: positions, paths, the machine's axes, and the milled surface."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..milling.coverage import Coverage
from ..milling.nurbs import MOST_DEGREE
from ..milling.positions import Positions, counted_states, reasons_of
from ..milling.tour import TRAVERSE, Tour
from .atomic_write import write
from .flank import FlankJob, FlankResult
from .mesh import Mesh, ply, stl, vertex_normals, vtp

TOLERANCES = 10e-6, 50e-6, 100e-6  # m, within which shares of the patch are said
COLOURED = 100e-6  # m, left or cut, that has the full colour
ERROR = "error / um"


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
        ``positions`` by their reasons, ``chains`` with their lengths and ends, ``covered`` shares,
        ``gouge_m``, ``scallops`` with their number, median and greatest height, ``surface_error``
        of a surface through measured points, ``tour`` with its places by kind, or null, and
        ``warnings``.
    """
    found, covered = result.found, result.covered
    warnings = []
    unfit = found.state[found.state != "regular"]
    if unfit.size:
        warnings.append(
            f"no mill can fit where the surface is no regular saddle: of {found.state.size} points "
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
    tour = result.tour
    return {
        "points": int(found.state.size),
        "positions": {why: int(n) for why, n in reasons_of(found).items()},
        "chains": [{"positions": len(chain), "ends": list(chain.ends)} for chain in covered.chains],
        "covered": {f"{within:g}": covered.share(within) for within in TOLERANCES},
        "gouge_m": max(0.0, -float(covered.error.min())),
        "scallops": scallops,
        "surface_error": job.surface_error,
        "tour": None if tour is None else dict(Counter(tour.kind.tolist())),
        "warnings": warnings,
    }


def _numbers_of(name, value):
    """Return `value`, which must be a dict as `summarise_flank` makes it."""
    if not isinstance(value, dict) or "gouge_m" not in value:
        raise ValueError(f"{name}: must be a dict from summarise_flank; got {shown(value)}.")
    return value


Flanked = Annotated[dict, Rule("dict", _numbers_of)]


@checked
def flank_text(numbers: Flanked):
    """Return what `summarise_flank` found, `numbers`, as lines for people."""
    lines = [f"{n:6d} positions: {why}" for why, n in numbers["positions"].items()]
    lines += [
        f"chain {k}: {chain['positions']} positions; its ends: {'; '.join(chain['ends'])}"
        for k, chain in enumerate(numbers["chains"], start=1)
    ]
    lines += [
        f"{100 * share:6.1f} % of the patch is left within {1e6 * float(within):g} um"
        for within, share in numbers["covered"].items()
    ]
    lines.append(f"{1e6 * numbers['gouge_m']:6.1f} um is the deepest that the mill enters it")
    scallops = numbers["scallops"]
    if scallops["lines"]:
        lines.append(
            f"{1e6 * scallops['median_m']:6.1f} um is the median scallop between strips, "
            f"{1e6 * scallops['greatest_m']:.1f} um the highest"
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
def positions_csv(found: Positions):
    """Return all positions as a table: contact, tip, axis, depths in m, and the reason."""
    names = ["point", "s", "t", "contact_x_m", "contact_y_m", "contact_z_m", "tip_x_m", "tip_y_m",
             "tip_z_m", "axis_x", "axis_y", "axis_z", "enters_m", "holder_enters_m",
             "others_enter_m", "reason"]  # fmt: skip
    numbers = np.column_stack([
        found.s, found.t, found.contact, found.tip, found.axis, found.enters, found.holder_enters,
        found.others_enter,
    ])  # fmt: skip
    rows = (
        [str(int(index)), *map(repr, row.tolist()), why]
        for index, row, why in zip(found.index, numbers, found.reason.tolist(), strict=True)
    )
    head = "# positions of a conical mill: lengths in m; inf where a depth wasn't asked for\n"
    return head + "".join(",".join(row) + "\n" for row in (names, *rows))


@checked
def paths_csv(covered: Coverage):
    """Return the chains as a table: chain, position, tip in m, unit axis, contact in m."""
    names = ["chain", "position", "tip_x_m", "tip_y_m", "tip_z_m", "axis_x", "axis_y", "axis_z",
             "contact_x_m", "contact_y_m", "contact_z_m"]  # fmt: skip
    lines = ["# positions along chains: the tip's middle in m, the axis towards the spindle"]
    lines.append(",".join(names))
    for k, chain in enumerate(covered.chains, start=1):
        table = np.concatenate([chain.tip, chain.axis, chain.contact], axis=1)
        lines += [
            ",".join([str(k), str(i), *map(repr, row)])
            for i, row in enumerate(table.tolist(), start=1)
        ]
    return "\n".join(lines) + "\n"


@checked
def tour_csv(tour: Tour):
    """Return a tour as a table: how the mill gets to each place, axes of the machine, tip, axis."""
    names = ["motion", "chain", "x_mm", "y_mm", "z_mm", "A_deg", "C_deg", "tip_x_m", "tip_y_m",
             "tip_z_m", "axis_x", "axis_y", "axis_z"]  # fmt: skip
    values = np.column_stack([1e3 * tour.values[:, :3], np.degrees(tour.values[:, 3:])])
    rows = zip(
        tour.kind.tolist(),
        (tour.chain + 1).tolist(),
        np.round(values, 6).tolist(),
        np.column_stack([tour.tip, tour.axis]).tolist(),
        strict=True,
    )
    lines = [
        "# the machine's axes: x, y, z in mm, A and C in degrees; tip and axis of the mill on the "
        "workpiece in m",
        ",".join(names),
    ]
    lines += [",".join([kind, str(k), *map(repr, [*a, *b])]) for kind, k, a, b in rows]
    return "\n".join(lines) + "\n"


@checked
def cl_text(job: FlankJob, covered: Coverage, tour: Tour | None):
    """Return chains, or a tour, as cutter location data in the manner of APT, in mm.

    Only what a tour traverses is rapid: an approach may meet the stock.
    """
    mill = job.tool
    radius = 1e3 * mill.tip_radius
    lines = [
        "PARTNO/FLANK MILLING WITH A CONE",
        "UNITS/MM",
        "$$ GOTO: middle of the tip, then the axis towards the spindle",
        f"CUTTER/{2 * radius:.6f},0,{radius:.6f},0,0,{np.degrees(mill.half_angle):.6f},"
        f"{1e3 * mill.length:.6f}",
        "MULTAX/ON",
    ]
    if tour is None:
        for k, chain in enumerate(covered.chains, start=1):
            lines.append(f"$$ CHAIN {k}; THE WAY TO IT AND FROM IT IS NOT PLANNED")
            lines += _gotos(chain.tip, chain.axis)
        return "\n".join([*lines, "FINI"]) + "\n"
    begins = np.flatnonzero(np.append(True, tour.kind[1:] != tour.kind[:-1]))
    for first, last in zip(begins, [*begins[1:], len(tour)], strict=True):
        kind = tour.kind[first]
        lines.append(f"$$ {kind.upper()}, CHAIN {tour.chain[first] + 1}")
        for goto in _gotos(tour.tip[first:last], tour.axis[first:last]):
            lines += ["RAPID", goto] if kind == TRAVERSE else [goto]
    return "\n".join([*lines, "FINI"]) + "\n"


def _gotos(tip, axis):
    """Return a line for each position, tip (k, 3) in mm and axis (k, 3)."""
    return [
        "GOTO/" + ",".join([*(f"{1e3 * c:.6f}" for c in at), *(f"{c:.9f}" for c in along)])
        for at, along in zip(tip, axis, strict=True)
    ]


@checked
def milled_surface(job: FlankJob, covered: Coverage):
    """Return the surface that a job leaves as a `Mesh` of triangles, coloured by what is left.

    Points of the patch, moved along its normal by what is left of it or cut from it, at most by the
    job's stock: between strips and beyond them the stock stands.
    """
    n = len(covered.error)
    corners = np.arange(n * n).reshape(n, n)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    faces = np.concatenate(
        [np.stack(one, axis=-1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))]
    )
    faces = faces[:, :: job.patch.side]  # outside is where the mill comes from
    left = np.minimum(covered.error.ravel(), job.paths["stock"])
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
    files : list of str
        Their paths.
    """
    covered = result.covered
    milled = milled_surface(job, covered)
    contents = {
        "positions.csv": positions_csv(result.found),
        "paths.csv": paths_csv(covered),
        "paths.apt": cl_text(job, covered, result.tour),
        "milled.vtp": vtp(milled),
        "milled.stl": stl(milled),
        "milled.ply": ply(milled, ERROR, 1e6 * COLOURED),
    }
    if result.tour is not None:
        contents["axes.csv"] = tour_csv(result.tour)
    files = []
    for name, content in contents.items():
        say(f"writing {folder / name}")
        files.append(str(write(folder / name, content)))
    return files
