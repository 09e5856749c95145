"""A cut asked for by a small TOML file: see notebooks/reference.toml.

Metres, seconds, radians and what follows from them; the name of an angle may end in ``_deg``, and
its value is then in degrees. Names and types are checked here; sizes by what they are for.
"""

import re
import tomllib
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arguments import checked, positive, shown, whole
from ..motion import Compressible, Integrator, Lag, Loop, Rigid
from ..motion.sizing import arm_of, axes_of, usual_sizes
from ..paths import cutting_circuit
from ..ream import Limits, Pose, gain_margins, plan, simulate
from ..ream.chatter import chatter_margins
from ..ream.cutting import expected_seconds
from ..ream.margins import capability
from ..removal import Ground
from ..surfaces import Arc, Body, Egg, Line, Machine, closed_profile

TEXT, WHOLE = "text", "whole number"
ANGULAR = "rad", "rad/s", "rad/s^2"  # whose names may end in _deg
# What each table may hold: units, TEXT or WHOLE. What has no default is needed.
MACHINE = dict(r="m", R="m", theta_min="rad", theta_max="rad", phi_min="rad", phi_max="rad",
               cutter_radius="m", depth="m", height="m")  # fmt: skip

BODY = dict(length="m", width="m", low="m", high="m", holder_radius="m", holder_length="m")


def _circle(radius):
    return closed_profile([Arc(0.0, 0.0, radius, 0.0, 2 * np.pi)])


# What makes a section, and of which sizes; a further one is one entry here. Pieces are read apart.
SHAPES = {
    "egg": (Egg, dict(a="m")),
    "circle": (_circle, dict(radius="m")),
    "pieces": (closed_profile, {}),
}
PIECES = {
    "arc": (Arc, dict(y="m", z="m", radius="m", start="rad", sweep="rad")),
    "line": (Line, dict(y="m", z="m", heading="rad", length="m")),
}
STANCE = dict(pitch="rad", yaw="rad")
LIMITS = dict(feed="m/s", acceleration="m/s^2", volume="m^3/s", flow="m^3/s", valve="1",
              power="W")  # fmt: skip
GROUND = dict(energy="J/m^3", pick_speed="m/s", normal="1", ripple="1", ripple_frequency="Hz")
CYLINDERS = dict(frame_pivot="a", arm_pivot="b", bore="bore", rod="rod", dead_length="dead_length")
HYDRAULICS = dict(head="kg", beam="kg", supply="Pa", tank="Pa", bulk="Pa", hose="m^3",
                  rated_flow="m^3/s", valve_lag="s", damping="1", lift_friction="N m",
                  swing_friction="N m", piston_leak="m^3/s/Pa", valve_leak="m^3/s/Pa",
                  pump="m^3/s")  # fmt: skip
HYDRAULICS |= {f"{joint}_{name}": "m" for joint in ("lift", "swing") for name in CYLINDERS}
PLAN = dict(tolerance="m", step="m", tick="s", count="rad", rest="s", laps=WHOLE, advance="m",
            arm_radius="m", path=TEXT)  # fmt: skip
CONTROLLER = dict(plant=TEXT, gain="1/s", integral="1/s^2", feedforward="1", delay=WHOLE,
                  encoder="rad")  # fmt: skip
POSE = dict(y="m", z="m", roll="rad", pitch="rad", yaw="rad")
WALL = dict(along=WHOLE, around=WHOLE, thickness="m")
# Beyond this a number is meant in another unit: the most, that unit, and what one of it is.
TOO_MUCH = {
    "m": (50.0, "mm", 1e-3), "m/s": (5.0, "mm/s", 1e-3), "m/s^2": (50.0, "mm/s^2", 1e-3),
    "m^3/s": (1.0, "l/min", 1e-3 / 60), "rad": (7.0, "degrees", np.pi / 180),
    "tick": (0.5, "ms", 1e-3), "tolerance": (0.3, "mm", 1e-3), "depth": (1.0, "mm", 1e-3),
}  # fmt: skip
MOST_RAYS = 100_000  # each way; memory bounds both together
# Tables that a job must have and that the other kind hasn't.
CUT, FLANK = ("section", "limits", "plan", "controller"), ("surface", "mill", "paths")
PLANTS = "T0", "T1", "T2", "T3"
OILY = "T2", "T3"  # those that ask for cylinders
VALVE = 0.8  # of the open valve, what a plan in ground asks for by default
FULL_SPEED = 0.4  # m/s of the cutter at the end of the arm, of the models that have no cylinder
HYDRAULIC_REMEDY = (
    "The cylinders' sizes are those of [hydraulics]: lift_ and swing_ frame_pivot, arm_pivot, "
    'bore, rod and dead_length, and supply; or take plant = "T0" in [controller], which has none.'
)
# The time that TOML's keys of many dots take grows with the square of their number.
MOST_BYTES, MOST_IN_A_LINE = 100_000, 4_000
LEAST_INTEGER, MOST_INTEGER = -(2**63), 2**63 - 1  # as TOML has them
USUAL = {"tick": 5e-3, "count": 2 * np.pi / 2**16}  # in s and rad, as of `ream.plan`
MOST_ENCODER = 0.1  # rad, as of a plan's count
IN_RADIANS = re.compile(
    r"-?\bpi(?:/2)?\b|-?\b\d+(?:\.\d+)?(?:e[+-]?\d+)?\b"
)  # numbers of a message


class WrongJob(ValueError):
    """A job, or a log, that can't be understood; the message says where and why."""


class Table(dict):
    """What a table says by its names, in SI units, and which of them it gave in `degrees`."""

    degrees = frozenset()


@dataclass(frozen=True)
class Job:
    """What a file asks for, in SI units: each table a dict of its names and values.

    Nothing is computed before it is asked for. `read_job` makes one from a file.

    Parameters
    ----------
    machine : dict
        Arguments of `Machine`, in m and rad.
    section : dict
        ``shape``: "egg", "circle" or "pieces", and its sizes in m and rad.
    limits : dict
        Arguments of `Limits` but the axes.
    plan : dict
        Options of `ream.plan`.
    controller : dict
        ``plant``: "T0" to "T3", and options of `Loop`; ``encoder``, an angle of its counts in rad.
    stance : dict
        Pitch and yaw at which the machine is set up, in rad.
    pose : dict
        Arguments of `Pose`, by which the machine stands elsewhere, unknown to it.
    wall : dict
        Rays ``along`` the tunnel and ``around`` it; ``thickness`` of the modelled ground, in m.
    hydraulics : dict
        Fields of `Sizes`, its cylinders by ``lift_`` and ``swing_`` names, where they aren't the
        usual ones of the machine.
    ground : dict
        Arguments of `Ground`: empty where nothing pushes back.
    body : dict
        Arguments of `Body`: empty where only arm and cutter fill room.
    """

    machine: dict
    section: dict
    limits: dict
    plan: dict
    controller: dict
    stance: dict
    pose: dict
    wall: dict
    hydraulics: dict
    ground: dict
    body: dict

    @cached_property
    def made(self):
        """Return the `Machine`, with its `Body` where it has one."""
        with said_of("body"):
            body = Body(**self.body) if self.body else None
        with said_of("machine", self.machine):
            return Machine(**self.machine, body=body)

    @cached_property
    def sizes(self):
        """Return the `Sizes` of the machine's hydraulics."""
        usual = usual_sizes(self.made)
        own = {name: value for name, value in self.hydraulics.items() if hasattr(usual, name)}
        with said_of("hydraulics"):
            for joint in ("lift", "swing"):
                names = {f"{joint}_{name}": field for name, field in CYLINDERS.items()}
                changes = {names[k]: v for k, v in self.hydraulics.items() if k in names}
                own[joint] = replace(getattr(usual, joint), **changes)
            return replace(usual, **own)

    @cached_property
    def cylinders(self):
        """Return the axes theta and phi, two `Hydraulics`; a refusal says what would do."""
        with said_of("hydraulics", remedy=HYDRAULIC_REMEDY):
            return axes_of(self.made, self.sizes)

    @cached_property
    def arm(self):
        """Return the `Arm` that both joints share with plant T3, else None."""
        return arm_of(self.made, self.sizes) if self.controller["plant"] == "T3" else None

    @cached_property
    def cut_ground(self):
        """Return the `Ground`, or None where nothing pushes back."""
        with said_of("ground"):
            return Ground(**self.ground) if self.ground else None

    @cached_property
    def pushing(self):
        """Return the `Ground` with plant T3, which alone feels it, else None."""
        return self.cut_ground if self.controller["plant"] == "T3" else None

    @cached_property
    def planned(self):
        """Return the `Plan`, or raise ValueError with the reason against it."""
        machine = self.made
        with said_of("section"):
            section = _shape(self.section)
        circuit = _circuit(machine, section, self.stance)
        _check_tolerance(machine, self.plan)
        bounds = dict(self.limits)
        if "power" in bounds and not self.ground:
            raise ValueError("[limits] power: needs the ground that takes it, a table [ground].")
        if self.controller["plant"] in OILY:
            bounds = {"flow": self.sizes.pump, **bounds}
        if "flow" in bounds or "valve" in bounds:
            bounds["axes"] = self.cylinders
        if self.ground:
            bounds["ground"] = self.cut_ground
            if self.controller["plant"] in OILY:
                bounds = {"valve": VALVE, "axes": self.cylinders, **bounds}
        with said_of("limits"):
            limits = Limits(**bounds)
        self._check_steady(circuit)
        with said_of("plan", self.plan):
            return plan(circuit, limits, **self.plan)

    def _check_steady(self, circuit):
        """Raise ValueError if the gain isn't below what cylinders and oil allow on a circuit."""
        plants, loops = self.axes
        if self.controller["plant"] in OILY and not loops[0].integral:
            for margin in gain_margins(circuit, plants, loops):
                if margin.what.startswith("gain") and not margin.enough:
                    raise ValueError(f"[controller] {margin}")

    @cached_property
    def margins(self):
        """Return the list of `Margin` that the machine has for the plan; none without cylinders."""
        plants, loops = self.axes
        if self.controller["plant"] not in OILY or loops[0].integral:
            return []
        return capability(self.planned, plants, loops, self.sizes)

    @cached_property
    def in_step(self):
        """Return of each joint the `Margin` against chatter, if the picks are in step; or none."""
        plants, loops = self.axes
        if not self.pushing or not self.pushing.ripple_frequency or loops[0].integral:
            return []
        return chatter_margins(self.planned, plants, loops)

    @cached_property
    def axes(self):
        """Return the plants and the loops of theta and phi, each a list of two."""
        about = dict(self.controller)
        tier = about.pop("plant")
        encoder = about.pop("encoder", None)
        sampled = {name: self.plan.get(name, usual) for name, usual in USUAL.items()}
        with said_of("controller"):
            loop = Loop(tick=USUAL["tick"], **about)
        with said_of("plan", self.plan):
            loop = replace(loop, **sampled)
        if encoder is not None:
            with said_of("controller", self.controller):
                if not 0 <= encoder <= MOST_ENCODER:
                    raise ValueError(
                        f"encoder: must be from 0 to {MOST_ENCODER:g} rad; got {encoder:g}."
                    )
            loop = replace(loop, count=encoder)
        loops = [loop, loop]
        if tier not in OILY:
            # The first models ask nothing of a cylinder: one full speed for both joints.
            rate = FULL_SPEED / self.made.R
            lag = self.sizes.valve_lag
            return [Integrator(rate) if tier == "T0" else Lag(rate, lag)] * 2, loops
        kind = Rigid if tier == "T2" else Compressible
        return [kind(axis) for axis in self.cylinders], loops

    @cached_property
    def error(self):
        """Return the `Pose` that the machine has and doesn't know of, or None."""
        with said_of("pose", self.pose):
            return Pose(**self.pose) if self.pose else None

    @property
    def limit(self):
        """Return the over-break at which the colours of pictures end, in m."""
        return 1.5 * self.plan["tolerance"]

    @property
    def expected_seconds(self):
        """Return about how long axes and wall of `simulated` will take, two numbers in s."""
        shape, thickness = self._rays
        about = dict(shape=shape, thickness=thickness, arm=self.arm, ground=self.pushing)
        with _rays_said():
            return expected_seconds(self.planned, *self.axes, **about)

    @property
    def _rays(self):
        """Return the numbers of rays and the thickness of the modelled ground, in m."""
        about = dict(self.wall)
        shape = about.pop("along"), about.pop("around")
        with said_of("wall"):
            whole("along, around", shape, 1, MOST_RAYS)
            return shape, positive("thickness", about.get("thickness", 0.1))

    @checked
    def simulated(self, say: Callable[[str], object] | None = None):
        """Return the `Cut`, or raise ValueError with the reason; `say` gets the progress."""
        shape, thickness = self._rays
        with _rays_said():
            return simulate(
                self.planned,
                *self.axes,
                pose=self.error,
                shape=shape,
                thickness=thickness,
                arm=self.arm,
                ground=self.pushing,
                say=say,
            )


@checked
def read_job(path: str | Path):
    """Return the `Job` that a TOML file asks for, checked for names, types and units.

    A job names no other file, so that nothing that it says can be read or written elsewhere.

    Raises
    ------
    WrongJob
        If the file can't be read, isn't TOML, or has a table, a name or a value that it shouldn't
        have or lacks one.
    """
    tables = parsed_toml(path)
    check_leaves(tables)
    check_kind(path, tables, CUT, FLANK, "tunneller flank")
    known = [field.name for field in fields(Job)]
    for name, table in tables.items():
        if name not in known:
            raise WrongJob(f"[{brief(name)}]: is no table of a job{hint(name, known)}.")
        if not isinstance(table, dict):
            raise WrongJob(f"{name}: must be a table, [{name}]; got {shown(table)}.")
    for name in ("machine", *CUT):
        if name not in tables:
            raise WrongJob(f"[{name}]: is missing.")
    given = {name: tables.get(name, {}) for name in known}
    controller = read_table("controller", given["controller"], CONTROLLER, ("plant", "gain"))
    one_of("[controller] plant", controller["plant"], PLANTS)
    return Job(
        machine=read_table("machine", given["machine"], MACHINE, MACHINE),
        section=_read_section(given["section"]),
        limits=read_table("limits", given["limits"], LIMITS, ("feed", "acceleration")),
        plan=read_table("plan", given["plan"], PLAN, ("tolerance",)),
        controller=controller,
        stance=read_table("stance", given["stance"], STANCE),
        pose=read_table("pose", given["pose"], POSE),
        wall={"along": 200, "around": 360, **read_table("wall", given["wall"], WALL)},
        hydraulics=read_table("hydraulics", given["hydraulics"], HYDRAULICS),
        ground=_read_if_any("ground", given["ground"], GROUND, ("energy", "pick_speed")),
        body=_read_if_any("body", given["body"], BODY, ("length", "width", "low", "high")),
    )


def _read_if_any(table, given, units, needed):
    """Return what a table says that may be missing, with all that it needs otherwise."""
    return read_table(table, given, units, needed) if given else {}


def parsed_toml(path):
    """Return what a file says in TOML, or raise WrongJob."""
    name = brief(str(path)) or "the file without a name"
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise WrongJob(f"{name}: can't be read; {error.strerror}.") from None
    except ValueError:  # of a zero byte, or of half a pair of UTF-16
        raise WrongJob(f"{name}: can't be read; it isn't the name of a file.") from None
    if len(content) > MOST_BYTES:
        raise WrongJob(f"{name}: is larger than a job may be, {MOST_BYTES} bytes.")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise WrongJob(f"{name}: is no text in UTF-8.") from None
    if max(map(len, text.split("\n"))) > MOST_IN_A_LINE:
        raise WrongJob(f"{name}: has a line of more than {MOST_IN_A_LINE} characters.")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise WrongJob(f"{name}: isn't TOML; {brief(str(error).rstrip('.'))}.") from None
    except RecursionError:
        raise WrongJob(f"{name}: is nested too deeply for a job.") from None
    except ValueError:  # Python's own limit, of thousands of digits
        raise WrongJob(f"{name}: has a number with too many digits.") from None


def check_leaves(tables):
    """Raise WrongJob for characters that a terminal might obey, and for integers beyond 64 bits.

    Whatever a job says may be repeated in a message. Without recursion, for dotted keys nest as
    deeply as one likes.
    """
    left = [("", tables)]
    while left:
        where, value = left.pop()
        if isinstance(value, dict):
            for name in value:
                if not name.isprintable():
                    raise WrongJob(f"{brief(name)}: must be a name of printable characters.")
            # Where it is deep in a table that no job has, the beginning will do.
            left += [(f"{where}.{name}"[:100], inner) for name, inner in value.items()]
        elif isinstance(value, list):
            left += [(where, inner) for inner in value]
        elif isinstance(value, str) and not value.isprintable():
            raise WrongJob(
                f"{where[1:]}: must be a text of printable characters; got {shown(value)}."
            )
        elif isinstance(value, int) and not LEAST_INTEGER <= value <= MOST_INTEGER:
            raise WrongJob(f"{where[1:]}: must be a number of at most 64 bits.")


def brief(text):
    """Return a text for a message, in 200 characters that no terminal obeys."""
    printable = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[:201])
    return printable if len(printable) <= 200 else f"{printable[:197]}..."


def read_table(table, given, units, needed=()):
    """Return a table's values by their names, in SI units.

    Parameters
    ----------
    table : str
        Its name, for messages.
    given : dict
        What it says.
    units : dict
        What it may hold: a unit, `TEXT` or `WHOLE` for each name.
    needed : iterable of str
        Names that must be there.

    Returns
    -------
    values : Table
        Angles in rad.
    """
    values = Table()
    degrees = set()
    for name, value in given.items():
        key = name
        where = f"[{table}] {brief(name)}"
        if name.endswith("_deg") and units.get(name[:-4]) in ANGULAR:
            key = name[:-4]
        if key not in units:
            raise WrongJob(f"{where}: isn't known{hint(name, units)}.")
        if key in values:
            raise WrongJob(f"[{table}] {key}: is given in radians and in degrees.")
        unit = units[key].replace("rad", "degrees") if key != name else units[key]
        kinds = {TEXT: str, WHOLE: int}.get(unit, (int, float))
        if isinstance(value, bool) or not isinstance(value, kinds):
            wanted = {TEXT: "a text", WHOLE: "a whole number", "1": "a plain number"}
            kind = wanted.get(unit, f"a number in {unit}")
            raise WrongJob(f"{where}: must be {kind}; got {shown(value)}.")
        if key == name and unit not in (TEXT, WHOLE):
            _check_unit(where, key, value, unit)
        values[key] = float(np.radians(value)) if key != name else value
        if key != name:
            degrees.add(key)
    for key in needed:
        if key not in values:
            unit = f"{units[key]}, or {key}_deg" if units[key] in ANGULAR else units[key]
            raise WrongJob(f"[{table}] {key}: is missing ({unit}).")
    values.degrees = frozenset(degrees)
    return values


def _read_section(given):
    """Return what a section's table says, its pieces as arcs and lines."""
    given = dict(given)
    shape = given.pop("shape", None)
    one_of("[section] shape", shape, SHAPES)
    if shape != "pieces":
        _, units = SHAPES[shape]
        return {"shape": shape, **read_table("section", given, units, units)}
    rows = given.pop("pieces", None)
    read_table("section", given, {"pieces": TEXT, "shape": TEXT})
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise WrongJob("[section] pieces: must be a list of tables, [[section.pieces]].")
    pieces = []
    for number, row in enumerate(map(dict, rows), start=1):
        where = f"section.pieces {number}"
        kind = row.pop("kind", None)
        one_of(f"[{where}] kind", kind, PIECES)
        make, units = PIECES[kind]
        sizes = read_table(where, row, units, units)
        with said_of(where, sizes):
            pieces.append(make(**sizes))
    return {"shape": shape, "pieces": tuple(pieces)}


def _shape(section):
    """Return the Section that a table says."""
    sizes = dict(section)
    make, _ = SHAPES[sizes.pop("shape")]
    return make(**sizes)


def _circuit(machine, section, stance):
    """Return the circuit; a refusal also says which heights of the machine would do."""
    try:
        return cutting_circuit(machine, section, **stance)
    except ValueError as error:
        if str(error).partition(":")[0] in STANCE:
            with said_of("stance", stance):
                raise
        low, high = machine.heights(section)
        if any(stance.values()) or low <= machine.height <= high:
            raise
        which = "Another [machine] height doesn't help."
        if low < high:
            which = f"[machine] height: may be from {low:.3f} to {high:.3f} m."
        raise ValueError(f"{error} {which}") from None


def _check_tolerance(machine, plan):
    """Raise ValueError where a tolerance is below what one count moves the cutter."""
    count = plan.get("count", USUAL["count"])
    moved = count * (machine.r + machine.R)
    if 0 < plan["tolerance"] < moved:
        angle = f"{count:.3g} rad"
        if "count" in getattr(plan, "degrees", ()):
            angle = f"{np.degrees(count):.3g} degrees"
        raise ValueError(
            f"[plan] tolerance: must be at least what a count of {angle} moves the cutter, "
            f"{moved:.2g} m; got {plan['tolerance']:g} m."
        )


def _check_unit(where, key, value, unit):
    """Raise WrongJob for a number that must be in another unit than it is said to be."""
    most, other, factor = TOO_MUCH.get(key, TOO_MUCH.get(unit, (np.inf, "", 1)))
    if not np.inf > abs(value) > most:
        return
    size = " in size" if value < 0 else ""
    if unit == "rad":
        raise WrongJob(
            f"{where}: must be at most {most:g} rad{size}; got {value:g}. In degrees its name "
            f"is {key}_deg."
        )
    raise WrongJob(
        f"{where}: must be at most {most:g} {unit}{size}; got {value:g}. "
        f"If that is in {other}, it is {value * factor:g} {unit}."
    )


@contextmanager
def _rays_said():
    """Let a refusal of too many rays name them as a job does."""
    try:
        yield
    except ValueError as error:
        argument, _, what = str(error).partition(": ")
        if argument != "shape":
            raise
        raise ValueError(f"[wall] along, around: {what}") from None


@contextmanager
def said_of(table, given=None, *, remedy=""):
    """Begin a refusal with the `table` that it is about, and end it with a `remedy`.

    An angle is said in the unit in which it was `given`, a `Table`. What is said of the machine's
    body is about that table, wherever it is found.
    """
    try:
        yield
    except ValueError as error:
        said = f"[{table}] {_as_given(str(error), getattr(given, 'degrees', ()))}"
        if said.startswith(f"[{table}] body: "):
            said = said.replace(f"[{table}] body: ", "[body] ", 1)
        kind = WrongJob if isinstance(error, WrongJob) else ValueError
        raise kind(" ".join(filter(None, (said, remedy)))) from None


def _as_given(said, names):
    """Return a refusal in degrees if it is of an argument among `names`, which were given so.

    What came is in degrees then, and so is a rule that is in radians.
    """
    rule, got, came = said.partition("; got ")
    ours = set(re.findall(r"\b\w+_(?:min|max)\b", rule)) | {said.partition(":")[0]}
    if not ours <= set(names):  # one of a pair may be in radians: then both are
        return said
    if re.search(r"\b(rad|pi)\b", rule):
        rule = IN_RADIANS.sub(_degrees, rule).replace("rad", "degrees")
    rule = re.sub(rf"\b({'|'.join(names)})\b", r"\1_deg", rule)
    return rule + got + IN_RADIANS.sub(_degrees, came).replace("rad", "degrees")


def _degrees(number):
    """Return the text of a match of `IN_RADIANS` in degrees."""
    text = number[0].replace("pi/2", "90").replace("pi", "180")
    return text if text != number[0] else f"{np.degrees(float(text)):.5g}"


def check_kind(path, tables, own, others, command):
    """Refuse a job at `path` that has none of its `own` tables but some that `command` reads.

    `others` names those. A job with tables of both kinds is refused where they are read.
    """
    found = [name for name in others if name in tables]
    if found and not set(own) & set(tables):
        raise WrongJob(
            f"{brief(str(path))}: is a job for `{command}`, by its tables {', '.join(found)}."
        )


def one_of(where, word, words):
    """Refuse a word that isn't one of those known."""
    if not isinstance(word, str) or word not in words:
        *others, last = (f'"{each}"' for each in words)
        raise WrongJob(f"{where}: must be {', '.join(others)} or {last}; got {shown(word)}.")


def hint(name, known):
    """Return what a name may have been meant to be, as the end of a sentence."""
    close = get_close_matches(name, known, n=1) or get_close_matches(
        name.removesuffix("_deg"), known, n=1
    )
    return f"; {close[0]!r} is meant, perhaps" if close else f"; known are {', '.join(known)}"
