"""Flank milling asked for by a small TOML file, and the files that come of it.

Metres and radians, or degrees in names that end in ``_deg``, as in a job for `cut`. A surface by
knots may be in millimetres, if its ``unit`` says so.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..envelopes import fit_surface
from ..envelopes.blade import BladeRing
from ..exact import dot, norm
from ..milling import ConicalMill, Coverage, Nurbs, Patch, Positions, cover, find_positions
from ..milling.nurbs import MOST_DEGREE
from .atomic_write import write
from .csv_tables import read_csv
from .mesh import Mesh, vtp
from .reader import TEXT, WHOLE, WrongJob, check_leaves, one_of, parsed_toml, read_table, said_of

UNITS = {"m": 1.0, "mm": 1e-3}
TOLERANCES = 10e-6, 50e-6, 100e-6  # m, within which shares of the patch are said
SURFACES = {
    "blade": dict(hub="m", height="m", chord="m", stagger="rad", twist="rad", camber="m", bow="m",
                  blades=WHOLE),
    "nurbs": dict(unit=TEXT),
    "points": dict(contact_error="m", normal_error="rad"),
}  # fmt: skip
MILL = dict(half_angle="rad", tip_radius="m", length="m", holder_radius="m", holder_length="m")
PATHS = dict(tolerance="m", step="m", side=WHOLE, points=WHOLE, strips=WHOLE, mesh=WHOLE)
COLUMNS = "x_m", "y_m", "z_m", "nx", "ny", "nz"
NEIGHBOURS = 8  # of a measured point, whose normals must be like its own
HOLE = 5.0  # times the points' usual distance, a place of the patch that is farther from any
INNER = 0.08  # share of measured points that may lie beyond the patch on each of its four sides


@dataclass(frozen=True)
class FlankJob:
    """What a file asks for, in SI units. `read_flank` makes one.

    Parameters
    ----------
    surface : dict
        ``kind``: "blade", "nurbs" or "points", and what belongs to it.
    mill : dict
        Arguments of `ConicalMill`.
    paths : dict
        ``tolerance`` and ``step`` in m, ``side``, and how many ``points`` and ``strips``.
    measured : str or None
        A table of points with normals, of kind "points".
    """

    surface: dict
    mill: dict
    paths: dict
    measured: str | None

    @cached_property
    def tool(self):
        """Return the `ConicalMill`."""
        with said_of("mill"):
            return ConicalMill(**self.mill)

    @cached_property
    def patch(self):
        """Return the `Patch`, or raise ValueError with the reason against it."""
        about = dict(self.surface)
        kind = about.pop("kind")
        side = self.paths["side"]
        if kind == "points":
            return _through(self.measured, about, side)
        with said_of("surface"):
            if kind == "blade":
                ring = BladeRing(**about)
                return Patch(ring.coordinates, (0.0, 1.0), (0.0, 1.0), side)
            scale = UNITS[about.pop("unit")]
            control = scale * np.array(about.pop("control"), dtype=float)
            surface = Nurbs(control, **about)
            return Patch(surface.coordinates, *surface.domain, side)

    @property
    def others(self):
        """Return points (n, 3) of neighbours, in m, or None: a blade has two, and the hub."""
        if self.surface["kind"] != "blade":
            return None
        ring = BladeRing(**{name: v for name, v in self.surface.items() if name != "kind"})
        grids = ring.mesh(61, 1), ring.mesh(61, -1), ring.drum(121)
        return np.concatenate([grid.reshape(-1, 3) for grid in grids])

    @checked
    def solved(self, say: Callable[[str], object]):
        """Return `Positions` and `Coverage`, or raise ValueError; `say` gets the progress."""
        about = {"tolerance": self.paths["tolerance"], "others": self.others,
                 "n": self.paths["mesh"]}  # fmt: skip
        s, t = self.patch.parameters(self.paths["points"], margin=0.05)
        say(f"looking for positions at {s.size} points ...")
        found = find_positions(self.patch, self.tool, s, t, **about)
        _check_saddle(found.state)
        if not found.fits.any():
            reasons = ", ".join(f"{n} {why}" for why, n in _reasons(found).items())
            raise ValueError(
                f"[mill] none of its {len(found)} positions fits: {reasons}. A smaller mill, a "
                f"longer one or another half-angle may."
            )
        say(f"{found.fits.sum()} of {len(found)} positions fit; chaining ...")
        options = {"step": self.paths["step"], "most": self.paths["strips"], "say": say}
        covered = cover(self.patch, self.tool, found, **about, **options)
        if not covered.chains:
            raise ValueError(
                "[paths] step: no chain of six positions begins where one fits; "
                f"got {self.paths['step']:g} m."
            )
        return found, covered


@checked
def read_flank(path: str | Path, points: str | Path | None = None):
    """Return the `FlankJob` that a TOML file asks for, with measured points from a CSV file.

    Raises
    ------
    WrongJob
        If a file can't be read, or says what it shouldn't or lacks what it should.
    """
    tables = parsed_toml(path)
    check_leaves(tables)
    for name, table in tables.items():
        if name not in ("surface", "mill", "paths"):
            raise WrongJob(f"[{name}]: is no table of such a job; known are surface, mill, paths.")
        if not isinstance(table, dict):
            raise WrongJob(f"{name}: must be a table, [{name}]; got {shown(table)}.")
    for name in ("surface", "mill", "paths"):
        if name not in tables:
            raise WrongJob(f"[{name}]: is missing.")
    surface = _read_surface(tables["surface"])
    paths = {"side": 1, "points": 9, "strips": 12, "mesh": 121}
    paths |= read_table("paths", tables["paths"], PATHS, ("tolerance", "step"))
    limits = {"points": (2, 50), "strips": (1, 100), "mesh": (20, 500)}
    for name, (low, high) in limits.items():
        if not low <= paths[name] <= high:
            raise WrongJob(f"[paths] {name}: must be from {low} to {high}; got {paths[name]}.")
    if paths["side"] not in (1, -1):
        raise WrongJob(f"[paths] side: must be 1 or -1; got {paths['side']}.")
    if not 0 < paths["step"] < np.inf or not 0 <= paths["tolerance"] < np.inf:
        raise WrongJob(
            "[paths] step, tolerance: must be finite lengths, the step above zero; "
            f"got {paths['step']} and {paths['tolerance']}."
        )
    mill = read_table("mill", tables["mill"], MILL, MILL)
    measured = None
    if (surface["kind"] == "points") != (points is not None):
        raise WrongJob('[surface] kind: "points" needs a table of them, by --points, no other has.')
    if points is not None:
        measured = _text(points)
    return FlankJob(surface, mill, paths, measured)


def _text(path):
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except (UnicodeDecodeError, ValueError):
        raise WrongJob(f"{path}: is no text in UTF-8.") from None
    except OSError as error:
        raise WrongJob(f"{path}: can't be read; {error.strerror}.") from None


def _read_surface(given):
    """Return what a surface's table says, its control points, weights and knots as lists."""
    given = dict(given)
    kind = given.pop("kind", None)
    one_of("[surface] kind", kind, SURFACES)
    lists = {}
    if kind == "nurbs":
        for name in ("control", "weights", "knots_s", "knots_t"):
            if name in given:
                lists[name] = _numbers(name, given.pop(name))
            elif name != "weights":
                raise WrongJob(f"[surface] {name}: is missing (numbers).")
    values = read_table("surface", given, SURFACES[kind], SURFACES[kind])
    if kind == "nurbs":
        one_of("[surface] unit", values["unit"], UNITS)
    return {"kind": kind, **values, **lists}


def _numbers(name, value):
    """Return nested lists of numbers, or raise WrongJob."""
    try:
        array = np.array(value)
    except ValueError:
        array = np.array(None)
    if array.dtype.kind not in "if" or not np.all(np.isfinite(array)):
        raise WrongJob(f"[surface] {name}: must be finite numbers in lists of equal length.")
    return array.astype(float).tolist()


def _through(text, errors, side):
    """Return the patch through measured points, or raise ValueError with what is wrong."""
    _, columns = read_csv(text)
    if set(COLUMNS) - set(columns):
        raise ValueError(
            f"points: must have the columns {', '.join(COLUMNS)}; got {', '.join(columns)}."
        )
    try:
        table = np.stack([columns[name].astype(float) for name in COLUMNS], axis=-1)
    except ValueError:
        raise ValueError("points: must hold numbers alone.") from None
    if not np.all(np.isfinite(table)):
        raise ValueError("points: must be finite; got one that isn't.")
    contact, normal = table[:, :3], table[:, 3:]
    length = norm(normal)
    if not np.all(np.abs(length - 1) < 0.01):
        raise ValueError("points: nx, ny, nz must be unit normals; got one that isn't.")
    normal = normal / length[:, None]
    _check_normals(contact, normal)
    with said_of("surface"):
        fit = fit_surface(contact, normal, **errors)
    if not fit.fits or len(fit.place) < len(contact):
        raise ValueError(
            "points: no polynomial passes all of them within their errors; give a smaller patch "
            f"or the errors that they have; {len(fit.place)} of {len(contact)} were tried last."
        )
    low, high = np.quantile(fit.place, [INNER, 1 - INNER], axis=0)
    _check_holes(fit.place, low, high)
    # The fit's third axis is the mean normal, so that x and y go round it as the patch's s and t.
    return Patch(fit.surface, (low[0], high[0]), (low[1], high[1]), side)


def _check_normals(contact, normal):
    """Raise ValueError where normals point to the other side than those beside them."""
    from scipy.spatial import cKDTree

    if len(contact) <= NEIGHBOURS:
        raise ValueError(f"points: must be more than {NEIGHBOURS}; got {len(contact)}.")
    _, beside = cKDTree(contact).query(contact, k=NEIGHBOURS + 1)
    against = np.sum(dot(normal[beside[:, 1:]], normal[:, None]) < 0, axis=1)
    flipped = np.count_nonzero(2 * against > NEIGHBOURS)
    if flipped:
        raise ValueError(
            f"points: normals must point to one side; {flipped} of {len(normal)} point to the "
            "other than those of most points beside them."
        )


def _check_holes(place, low, high):
    """Raise ValueError where a place of a rectangle is far from any measured point."""
    from scipy.spatial import cKDTree

    tree = cKDTree(place)
    x, y = (np.linspace(a, b, 60) for a, b in zip(low, high, strict=True))
    asked = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    away, _ = tree.query(asked)
    usual = np.sqrt(np.prod(np.ptp(place, axis=0)) / len(place))
    if away.max() > HOLE * usual:
        raise ValueError(
            f"points: must leave no hole; got one that is {2e3 * away.max():.3g} mm wide, where "
            f"points are {1e3 * usual:.2g} mm apart."
        )


def _check_saddle(state):
    """Raise ValueError where no point of a patch is one at which a cone could keep off it."""
    if not np.any(state == "regular"):
        counts = Counter(state.ravel().tolist())
        what = ", ".join(f"{count} {name}" for name, count in counts.items())
        raise ValueError(
            "[surface] is nowhere a regular saddle (K < 0), so that a cone in third-order contact "
            f"gouges or there is none; of {state.size} points are {what}."
        )


def _reasons(found):
    return dict(Counter(found.reason.tolist()).most_common())


@checked
def summarise_flank(job: FlankJob, found: Positions, covered: Coverage):
    """Return what came of a flank job as a dict, ready for JSON, in SI units.

    Parameters
    ----------
    job : FlankJob
        What was asked for.
    found, covered
        From its `solved`.

    Returns
    -------
    numbers : dict
        ``positions`` by their reasons, ``chains`` with their lengths and ends, ``covered`` shares,
        ``gouge_m`` and ``warnings``.
    """
    state = Counter(found.state.ravel().tolist())
    warnings = []
    odd = {name: count for name, count in state.items() if name != "regular"}
    if odd:
        what = ", ".join(f"{count} {name}" for name, count in odd.items())
        warnings.append(
            f"no mill can fit where the surface is no regular saddle: of {found.state.size} points "
            f"are {what}."
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
    return {
        "points": int(found.state.size),
        "positions": {why: int(n) for why, n in _reasons(found).items()},
        "chains": [{"positions": len(chain), "ends": list(chain.ends)} for chain in covered.chains],
        "covered": {f"{within:g}": covered.share(within) for within in TOLERANCES},
        "gouge_m": max(0.0, -float(covered.error.min())),
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
def cl_text(job: FlankJob, covered: Coverage):
    """Return the chains of a job as cutter location data in the manner of APT, in mm."""
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
    for k, chain in enumerate(covered.chains, start=1):
        lines.append(f"$$ CHAIN {k}; THE WAY TO IT AND FROM IT IS NOT PLANNED")
        lines += [
            "GOTO/" + ",".join(f"{1e3 * c:.6f}" for c in tip) + ","
            + ",".join(f"{c:.9f}" for c in axis)
            for tip, axis in zip(chain.tip, chain.axis, strict=True)
        ]  # fmt: skip
    return "\n".join([*lines, "FINI"]) + "\n"


@checked
def milled_surface(job: FlankJob, covered: Coverage):
    """Return the patch of a job as a `Mesh` with what is left of it, in micrometres."""
    n = len(covered.error)
    corners = np.arange(n * n).reshape(n, n)
    faces = np.stack(
        [corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=-1
    )
    points = job.patch.mesh(n).reshape(-1, 3)
    return Mesh(points, faces.reshape(-1, 4), {"error / um": 1e6 * covered.error.ravel()})


@checked
def write_flank(
    job: FlankJob, found: Positions, covered: Coverage, folder: Path, say: Callable[[str], object]
):
    """Write the files of a flank job into a folder, and return their paths.

    Parameters
    ----------
    job : FlankJob
        What was asked for.
    found, covered
        From its `solved`.
    folder : pathlib.Path
        Made where it is missing; files of these names are replaced.
    say : function
        Told what is being written.

    Returns
    -------
    files : list of str
        Their paths.
    """
    contents = {
        "positions.csv": positions_csv(found),
        "paths.csv": paths_csv(covered),
        "paths.apt": cl_text(job, covered),
        "milled.vtp": vtp(milled_surface(job, covered)),
    }
    files = []
    for name, content in contents.items():
        say(f"writing {folder / name}")
        files.append(str(write(folder / name, content)))
    return files
