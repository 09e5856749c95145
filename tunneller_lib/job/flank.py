"""Flank milling asked for by a small TOML file.

Metres and radians, or degrees in names that end in ``_deg``, as in a job for `cut`. A surface by
knots may be in millimetres, if its ``unit`` says so.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arguments import checked, shown
from ..envelopes.blade import BladeRing
from ..milling import (
    ConicalMill,
    Patch,
    TiltingTable,
    cover,
    find_positions,
    find_scallops,
    plan_tour,
)
from ..milling.coverage import Coverage
from ..milling.five_axes import LIMITS
from ..milling.nurbs import Nurbs
from ..milling.positions import Positions, counted_states, reasons_of
from ..milling.scallops import Scallops
from ..milling.tour import Tour
from .measured_patch import patch_through
from .reader import TEXT, WHOLE, WrongJob, check_leaves, one_of, parsed_toml, read_table, said_of

UNITS = {"m": 1.0, "mm": 1e-3}
SURFACES = {
    "blade": dict(hub="m", height="m", chord="m", stagger="rad", twist="rad", camber="m", bow="m",
                  blades=WHOLE),
    "nurbs": dict(unit=TEXT),
    "points": dict(contact_error="m", normal_error="rad"),
}  # fmt: skip
TABLES = "surface", "mill", "paths", "machine"  # the last may be missing
MILL = dict(half_angle="rad", tip_radius="m", length="m", holder_radius="m", holder_length="m")
PATHS = dict(tolerance="m", step="m", side=WHOLE, points=WHOLE, strips=WHOLE, mesh=WHOLE,
             stock="m")  # fmt: skip
MACHINE = dict(pivot_x="m", pivot_y="m", pivot_z="m", up_x="1", up_y="1", up_z="1",
               x_min="m", x_max="m", y_min="m", y_max="m", z_min="m", z_max="m", tilt_min="rad",
               tilt_max="rad", turn_min="rad", turn_max="rad", most_turn="rad",
               clearance="m")  # fmt: skip


@dataclass(frozen=True)
class FlankResult:
    """What came of a flank job.

    Parameters
    ----------
    found : Positions
        All of them, with the reason against each.
    covered : Coverage
        Chains of those that fit.
    scallops : Scallops
        Between the chains' strips.
    tour : Tour or None
        The whole way, of a job that has a machine.
    """

    found: Positions
    covered: Coverage
    scallops: Scallops
    tour: Tour | None


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
        ``tolerance``, ``step`` and ``stock`` in m, ``side``, and how many ``points``, ``strips``.
    machine : dict or None
        Limits of a `TiltingTable`, each with ``_min`` and ``_max``, and the ``clearance``.
    measured : str, bytes or None
        A table of points with normals, or a mesh in STL, of kind "points".
    """

    surface: dict
    mill: dict
    paths: dict
    machine: dict | None
    measured: str | bytes | None

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
            return self._fitted[0]
        with said_of("surface"):
            if kind == "blade":
                ring = BladeRing(**about)
                return Patch(ring.coordinates, (0.0, 1.0), (0.0, 1.0), side)
            scale = UNITS[about.pop("unit")]
            control = scale * np.array(about.pop("control"), dtype=float)
            surface = Nurbs(control, **about)
            return Patch(surface.coordinates, *surface.domain, side)

    @cached_property
    def _fitted(self):
        about = {name: value for name, value in self.surface.items() if name != "kind"}
        return patch_through(self.measured, about, self.paths["side"])

    @property
    def surface_error(self):
        """Return the greatest standard errors of a measured surface on the patch, or None.

        Of points in m (``position_m``), normals in rad (``normal_rad``) and curvatures in 1/m
        (``curvature_1_m``), from the covariance of the fit. Other surfaces are given exactly.
        """
        if self.surface["kind"] != "points":
            return None
        patch, fit = self._fitted
        error = fit.jet_errors(*patch.parameters(15)).reshape(15, -1).max(axis=1)
        names = ("position_m", 0, 1), ("normal_rad", 1, 3), ("curvature_1_m", 3, 6)
        factors = np.array([1, 1, 1, 2, 1, 2])  # from Taylor's coefficients to derivatives
        return {name: float((factors * error[:6])[a:b].max()) for name, a, b in names}

    @cached_property
    def table(self):
        """Return the `TiltingTable`, or None."""
        if self.machine is None:
            return None
        about = self.machine
        with said_of("machine"):
            return TiltingTable(
                *(tuple(about[f"{name}_{c}"] for c in "xyz") for name in ("pivot", "up")),
                *((about[f"{name}_min"], about[f"{name}_max"]) for name in LIMITS),
                about["most_turn"],
            )

    @cached_property
    def neighbours(self):
        """Return grids (n, n, 3) of points of neighbours, in m: a blade has two, and the hub."""
        if self.surface["kind"] != "blade":
            return []
        ring = BladeRing(**{name: v for name, v in self.surface.items() if name != "kind"})
        return [ring.mesh(61, 1), ring.mesh(61, -1), ring.drum(121)]

    @property
    def others(self):
        """Return points (n, 3) of all neighbours, in m, or None where there is none."""
        if not self.neighbours:
            return None
        return np.concatenate([grid.reshape(-1, 3) for grid in self.neighbours])

    @checked
    def solved(self, say: Callable[[str], object]):
        """Return the `FlankResult`, or raise ValueError; `say` gets the progress."""
        look = {"tolerance": self.paths["tolerance"], "others": self.others,
                "n": self.paths["mesh"]}  # fmt: skip
        about = look | {"machine": self.table}
        s, t = self.patch.parameters(self.paths["points"], margin=0.05)
        say(f"looking for positions at {s.size} points ...")
        found = find_positions(self.patch, self.tool, s, t, **about)
        _check_saddle(found.state)
        if not found.fits.any():
            reasons = ", ".join(f"{n} {why}" for why, n in reasons_of(found).items())
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
        scallops = find_scallops(self.patch, self.tool, covered)
        tour = None
        if self.table is not None:
            say("planning the ways between chains ...")
            way = self.patch, self.tool, covered.chains, self.table
            tour = plan_tour(*way, clearance=self.machine["clearance"], **look)
        return FlankResult(found, covered, scallops, tour)


@checked
def read_flank(path: str | Path, points: str | Path | None = None):
    """Return the `FlankJob` that a TOML file asks for, with points from a CSV or an STL file.

    Raises
    ------
    WrongJob
        If a file can't be read, or says what it shouldn't or lacks what it should.
    """
    tables = parsed_toml(path)
    check_leaves(tables)
    for name, table in tables.items():
        if name not in TABLES:
            raise WrongJob(f"[{name}]: is no table of such a job; known are {', '.join(TABLES)}.")
        if not isinstance(table, dict):
            raise WrongJob(f"{name}: must be a table, [{name}]; got {shown(table)}.")
    for name in TABLES[:3]:
        if name not in tables:
            raise WrongJob(f"[{name}]: is missing.")
    surface = _read_surface(tables["surface"])
    paths = {"side": 1, "points": 9, "strips": 12, "mesh": 121, "stock": 1e-3}
    paths |= read_table("paths", tables["paths"], PATHS, ("tolerance", "step"))
    limits = {"points": (2, 50), "strips": (1, 100), "mesh": (20, 500)}
    for name, (low, high) in limits.items():
        if not low <= paths[name] <= high:
            raise WrongJob(f"[paths] {name}: must be from {low} to {high}; got {paths[name]}.")
    if paths["side"] not in (1, -1):
        raise WrongJob(f"[paths] side: must be 1 or -1; got {paths['side']}.")
    lengths = [paths[name] for name in ("step", "stock", "tolerance")]
    if not all(0 <= length < np.inf for length in lengths) or not all(lengths[:2]):
        raise WrongJob(
            "[paths] step, stock, tolerance: must be finite lengths, the first two above zero; "
            f"got {', '.join(f'{length:g}' for length in lengths)}."
        )
    mill = read_table("mill", tables["mill"], MILL, MILL)
    measured = None
    if (surface["kind"] == "points") != (points is not None):
        raise WrongJob('[surface] kind: "points" needs a file of them, by --points, no other has.')
    if points is not None:
        measured = _content(points)
    machine = None
    if "machine" in tables:
        machine = read_table("machine", tables["machine"], MACHINE, MACHINE)
        if not 0 < machine["clearance"] < np.inf:
            raise WrongJob(
                "[machine] clearance: must be a finite length above zero; "
                f"got {machine['clearance']:g}."
            )
    return FlankJob(surface, mill, paths, machine, measured)


def _content(path):
    """Return what a file holds: bytes of an STL file, else text."""
    try:
        if Path(path).suffix.lower() == ".stl":
            return Path(path).read_bytes()
        return Path(path).read_text(encoding="utf-8-sig")
    except ValueError:  # what is no UTF-8, too
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


def _check_saddle(state):
    """Raise ValueError where no point of a patch is one at which a cone could keep off it."""
    if not np.any(state == "regular"):
        what = counted_states(state)
        raise ValueError(
            "[surface] is nowhere a regular saddle (K < 0), so that a cone in third-order contact "
            f"gouges or there is none; of {state.size} points are {what}."
        )
