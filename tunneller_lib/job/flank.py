"""Flank milling asked for by a small TOML file.

Metres and radians, or degrees in names that end in ``_deg``, as in a job for `cut`. A surface by
knots may be in millimetres, if its ``unit`` says so.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
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
from ..milling.positions import counted_states, reasons_of
from ..milling.scallops import Scallops
from .flank_feeds import seconds_of
from .measured_patch import patch_through
from .tables import (
    CUT,
    FLANK,
    TEXT,
    WHOLE,
    Size,
    WrongJob,
    check_kind,
    check_leaves,
    content_of,
    one_of,
    parsed_toml,
    read_table,
    said_of,
    text_of,
)

PLAUSIBLE = {
    "m": Size("m", most=50), "m/s": Size("m/s", most=5), "m/s^2": Size("m/s^2", most=50),
    "rad": Size("rad", most=7), "rad/s": Size("rad/s"), "rad/s^2": Size("rad/s^2"), "1": Size("1"),
}  # fmt: skip
UNITS = {"m": 1.0, "mm": 1e-3}
SURFACES = {
    "blade": dict(hub="m", height="m", chord="m", stagger="rad", twist="rad", camber="m", bow="m",
                  blades=WHOLE),
    "nurbs": dict(unit=TEXT),
    "points": dict(contact_error="m", normal_error="rad"),
}  # fmt: skip
TABLES = *FLANK, "machine", "feed", "box", "cradle"  # the last four may be missing
SEVERAL = "mill", "box", "cradle"  # of which there may be some, in double brackets
MOST_TABLES = 20
MOST_POINTS_BYTES = 20_000_000  # of a file
MILL = dict(half_angle="rad", tip_radius="m", length="m", holder_radius="m", holder_length="m")
SPINDLE = dict(spindle_radius="m", spindle_length="m")
PATHS = dict(tolerance="m", step="m", side=WHOLE, points=WHOLE, strips=WHOLE, contacts=WHOLE,
             mesh=WHOLE, stock="m")  # fmt: skip
MACHINE = dict(pivot_x="m", pivot_y="m", pivot_z="m", up_x="1", up_y="1", up_z="1",
               x_min="m", x_max="m", y_min="m", y_max="m", z_min="m", z_max="m", tilt_min="rad",
               tilt_max="rad", turn_min="rad", turn_max="rad", most_turn="rad",
               clearance="m")  # fmt: skip
BOX = dict(x_min="m", x_max="m", y_min="m", y_max="m", z_min="m", z_max="m")
FEED = dict(cutting="m/s", x="m/s", y="m/s", z="m/s", tilt="rad/s", turn="rad/s",
            x_acceleration="m/s^2", y_acceleration="m/s^2", z_acceleration="m/s^2",
            tilt_acceleration="rad/s^2", turn_acceleration="rad/s^2")  # fmt: skip


@dataclass(frozen=True, eq=False)
class FlankResult:
    """What came of a flank job.

    Parameters
    ----------
    found : list of Positions
        Of each mill all of them, with the reason against each.
    covered : Coverage
        Chains of those that fit, one mill after the other.
    scallops : Scallops
        Between the chains' strips.
    tours : list of Tour
        The whole way of each mill that has chains, in a job that has a machine; else none.
    seconds : list of (k,) float
        Of each tour the least times of its steps, in s, in a job that has feeds; else none.
    """

    found: list
    covered: Coverage
    scallops: Scallops
    tours: list
    seconds: list = field(default_factory=list)

    @property
    def begins(self):
        """Return the number (k,) of the chain with which each tour begins, counted from 0."""
        count = [int(tour.chain[-1]) + 1 for tour in self.tours]
        return np.cumsum([0, *count])[:-1].tolist()


@dataclass(frozen=True, eq=False)
class FlankJob:
    """What a file asks for, in SI units. `read_flank` makes one.

    Parameters
    ----------
    surface : dict
        ``kind``: "blade", "nurbs" or "points", and what belongs to it.
    mills : list of dict
        Arguments of `ConicalMill`, in the order in which the mills cut.
    paths : dict
        ``tolerance``, ``step`` and ``stock`` in m, ``side``, and how many ``points``, ``strips``
        and ``contacts``, one or two.
    machine : dict or None
        Limits of a `TiltingTable`, each with ``_min`` and ``_max``, and the ``clearance``.
    measured : str, bytes or None
        A table of points with normals, or a mesh in STL, of kind "points".
    feed : dict or None
        Greatest speeds: ``cutting``, and those of the machine's axes, in m/s and rad/s, with their
        accelerations.
    boxes : list of dict
        On the workpiece, as clamps and the table are, that mill, holder and spindle must stay off:
        ``_min`` and ``_max`` of x, y, z.
    cradle : list of dict
        Boxes likewise, in the machine's coordinates from the pivot while A is 0, of what tilts
        with the table and doesn't turn.
    stamp : str
        Of which job its files are, as of `Job`.
    """

    surface: dict
    mills: list
    paths: dict
    machine: dict | None
    measured: str | bytes | None
    feed: dict | None = None
    boxes: list = field(default_factory=list)
    cradle: list = field(default_factory=list)
    stamp: str = field(default="tunneller_lib", compare=False)

    @cached_property
    def tools(self):
        """Return a list of `ConicalMill`."""
        made = []
        for name, about in zip(_names(self.mills), self.mills, strict=True):
            with said_of(name, about):
                made.append(ConicalMill(**about))
        return made

    @cached_property
    def patch(self):
        """Return the `Patch`, or raise ValueError with the reason against it."""
        about = dict(self.surface)
        kind = about.pop("kind")
        side = self.paths["side"]
        if kind == "points":
            return self._fitted[0]
        if kind == "blade":
            return Patch(self._ring.coordinates, (0.0, 1.0), (0.0, 1.0), side)
        with said_of("surface"):
            scale = UNITS[about.pop("unit")]
            control = scale * np.array(about.pop("control"), dtype=float)
            surface = Nurbs(control, **about)
            return Patch(surface.coordinates, *surface.domain, side)

    @cached_property
    def _ring(self):
        """Return the `BladeRing` of a surface of kind "blade"."""
        with said_of("surface"):
            return BladeRing(**{name: v for name, v in self.surface.items() if name != "kind"})

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
        with said_of("machine", about):
            return TiltingTable(
                *(tuple(about[f"{name}_{c}"] for c in "xyz") for name in ("pivot", "up")),
                *((about[f"{name}_min"], about[f"{name}_max"]) for name in LIMITS),
                about["most_turn"],
                [face for box in self.cradle for face in _faces(box)] or None,
            )

    @cached_property
    def neighbours(self):
        """Return grids (n, m, 3) of points, in m: faces of boxes, and neighbours of a blade.

        These are two blades and the hub.
        """
        grids = [face for box in self.boxes for face in _faces(box)]
        if self.surface["kind"] != "blade":
            return grids
        ring = self._ring
        return [ring.mesh(61, 1), ring.mesh(61, -1), ring.drum(361), *grids]

    @checked
    def solved(self, say: Callable[[str], object]):
        """Return the `FlankResult`, or raise ValueError; `say` gets the progress."""
        look = {
            "tolerance": self.paths["tolerance"],
            "others": self.neighbours or None,
            "n": self.paths["mesh"],
        }
        about = look | {"machine": self.table}
        patch, mills = self.patch, self.tools
        s, t = patch.parameters(self.paths["points"], margin=0.05)
        found = []
        for mill, name in zip(mills, _names(self.mills), strict=True):
            say(f"looking for positions of the {name} at {s.size} points ...")
            found.append(find_positions(patch, mill, s, t, **about))
            say(f"{found[-1].fits.sum()} of {len(found[-1])} positions fit")
        _check_saddle(found[0].state)
        if not any(here.fits.any() for here in found):
            reasons = ", ".join(f"{n} {why}" for why, n in reasons_of(found).items())
            raise ValueError(
                f"[mill] none of its {sum(map(len, found))} positions fits: {reasons}. A smaller "
                f"mill, a longer one or another half-angle may."
            )
        options = {"step": self.paths["step"], "most": self.paths["strips"], "say": say,
                   "twice": self.paths["contacts"] == 2}  # fmt: skip
        covered = None
        for mill, here, name in zip(mills, found, _names(self.mills), strict=True):
            say(f"chaining positions of the {name} ...")
            covered = cover(patch, mill, here, begun=covered, **about, **options)
        if not covered.chains:
            raise ValueError(
                "[paths] step: no chain of six positions begins where one fits; "
                f"got {self.paths['step']:g} m."
            )
        scallops = find_scallops(patch, None, covered)
        tours = []
        if self.table is not None:
            say("planning the ways between chains ...")
            for mill in dict.fromkeys(covered.mills):
                pairs = zip(covered.mills, covered.chains, strict=True)
                own = [chain for other, chain in pairs if other == mill]
                clear = self.machine["clearance"]
                tours.append(plan_tour(patch, mill, own, self.table, clearance=clear, **look))
        seconds = []
        if self.feed is not None:
            speed, *axes = (self.feed[name] for name in FEED)
            for mill, tour in zip(dict.fromkeys(covered.mills), tours, strict=True):
                seconds.append(seconds_of(tour, mill.length, speed, axes[:5], axes[5:]))
        return FlankResult(found, covered, scallops, tours, seconds)


@checked
def read_flank(path: str | Path, points: str | Path | None = None):
    """Return the `FlankJob` that a TOML file asks for, with points from a CSV or an STL file.

    Raises
    ------
    WrongJob
        If a file can't be read, or says what it shouldn't or lacks what it should.
    """
    tables, stamp = parsed_toml(path)
    check_leaves(tables)
    check_kind(path, tables, FLANK, CUT, "tunneller cut")
    for name, table in tables.items():
        if name not in TABLES:
            raise WrongJob(f"[{name}]: is no table of such a job; known are {', '.join(TABLES)}.")
        rows = table if name in SEVERAL and isinstance(table, list) and table else [table]
        if not all(isinstance(row, dict) for row in rows):
            raise WrongJob(f"{name}: must be a table, [{name}]; got {shown(table)}.")
        if len(rows) > MOST_TABLES:
            raise WrongJob(f"[[{name}]]: must be at most {MOST_TABLES}; got {len(rows)}.")
    for name in FLANK:
        if name not in tables:
            raise WrongJob(f"[{name}]: is missing.")
    surface = _read_surface(tables["surface"])
    paths = {"side": 1, "points": 9, "strips": 12, "contacts": 1, "mesh": 121,
             "stock": 1e-3}  # fmt: skip
    paths |= _table("paths", tables["paths"], PATHS, ("tolerance", "step"))
    limits = {"points": (2, 50), "strips": (1, 100), "contacts": (1, 2), "mesh": (20, 500)}
    for name, (low, high) in limits.items():
        if not low <= paths[name] <= high:
            raise ValueError(f"[paths] {name}: must be from {low} to {high}; got {paths[name]}.")
    if paths["side"] not in (1, -1):
        raise ValueError(f"[paths] side: must be 1 or -1; got {paths['side']}.")
    lengths = [paths[name] for name in ("step", "stock", "tolerance")]
    if not all(0 <= length < np.inf for length in lengths) or not all(lengths[:2]):
        raise ValueError(
            "[paths] step, stock, tolerance: must be finite lengths, the first two above zero; "
            f"got {', '.join(f'{length:g}' for length in lengths)}."
        )
    mills = _rows(tables, "mill", MILL | SPINDLE, MILL)
    if any(one in mills[:k] for k, one in enumerate(mills)):
        raise WrongJob("[[mill]]: must be different ones; got one twice.")
    measured = None
    if surface["kind"] == "points" and points is None:
        raise WrongJob('[surface] kind: "points" needs the file of measured points, --points FILE.')
    if surface["kind"] != "points" and points is not None:
        raise WrongJob(
            f'--points: is for a [surface] of kind "points"; got one of kind "{surface["kind"]}".'
        )
    if points is not None:
        measured = _content(points)
    machine = None
    if "machine" in tables:
        machine = _table("machine", tables["machine"], MACHINE, MACHINE)
        with said_of("machine", machine):
            _check_ranges(machine, LIMITS)
        if not 0 < machine["clearance"] < np.inf:
            raise ValueError(
                "[machine] clearance: must be a finite length above zero; "
                f"got {machine['clearance']:g}."
            )
    feed = None
    if "feed" in tables:
        feed = _table("feed", tables["feed"], FEED, FEED)
        if machine is None:
            raise WrongJob("[feed]: needs the machine whose axes it is about, [machine].")
        with said_of("feed", feed):
            for name, most in feed.items():
                if not 0 < most < np.inf:
                    raise ValueError(f"{name}: must be finite and above zero; got {most:g}.")
    boxes, cradle = (_read_boxes(tables, name) for name in ("box", "cradle"))
    if cradle and machine is None:
        raise WrongJob("[cradle]: needs the machine that it belongs to, [machine].")
    return FlankJob(surface, mills, paths, machine, measured, feed, boxes, cradle, stamp)


def _table(name, given, units, needed):
    """Return what a table says, its numbers of plausible sizes for their units."""
    sizes = {key: PLAUSIBLE.get(unit, unit) for key, unit in units.items()}
    return read_table(name, given, sizes, needed)


def _read_boxes(tables, name):
    """Return the boxes that tables of a name say, a list of dicts, which may be empty."""
    boxes = _rows(tables, name, BOX, BOX)
    for label, box in zip(_names(boxes, name), boxes, strict=True):
        with said_of(label):
            _check_ranges(box, "xyz")
    return boxes


def _rows(tables, name, units, needed):
    """Return what all tables of a name say, a list of dicts, which may be empty."""
    given = tables.get(name, [])
    given = given if isinstance(given, list) else [given]
    named = zip(_names(given, name), given, strict=True)
    return [_table(label, one, units, needed) for label, one in named]


def _check_ranges(about, names):
    """Refuse what a table says of names if a ``_min`` isn't below its ``_max``, both finite."""
    for name in names:
        low, high = about[f"{name}_min"], about[f"{name}_max"]
        if not -np.inf < low < high < np.inf:
            raise ValueError(
                f"{name}_min: must be below {name}_max, both finite; got {low:g} and {high:g}."
            )


def _names(rows, name="mill"):
    """Return the names of tables in messages, numbered where there are several."""
    return [name] if len(rows) == 1 else [f"{name} {k}" for k in range(1, len(rows) + 1)]


def _faces(box):
    """Yield the faces of a box as grids (2, 2, 3) of their corners, in m."""
    ways = [np.array([box[f"{c}_min"], box[f"{c}_max"]]) for c in "xyz"]
    for k in range(3):
        for end in (0, -1):
            one = [way if i != k else way[[end]] for i, way in enumerate(ways)]
            yield np.stack(np.meshgrid(*one, indexing="ij"), axis=-1).squeeze(axis=k)


def _content(path):
    """Return what a file holds: bytes of an STL file, else text."""
    content = content_of(path, "a file of points", MOST_POINTS_BYTES)
    return content if Path(path).suffix.lower() == ".stl" else text_of(path, content)


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
    values = _table("surface", given, SURFACES[kind], SURFACES[kind])
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
