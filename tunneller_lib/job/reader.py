"""A cut asked for by a small TOML file, such as reference.toml beside this module.

Names, types and units are checked here; the classes that take the numbers check these.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arguments import checked, positive, shown, whole
from ..motion import Compressible, Integrator, Lag, Loop, Rigid, follow
from ..motion.sizing import arm_of, axes_of, usual_sizes
from ..paths import cutting_circuit
from ..paths.circuit import Circuit
from ..ream import Limits, Pose, plan, simulate
from ..ream.cutting import whole_run
from ..ream.margins import capability, chatter_margins
from ..removal import Ground
from ..surfaces import Arc, Body, Egg, Line, Machine, closed_profile
from .tables import (
    NEEDED,
    TEXT,
    WHOLE,
    Size,
    WrongJob,
    brief,
    hint,
    one_of,
    parsed_toml,
    read_table,
    said_of,
)

# What each table may hold: TEXT, WHOLE, or a unit with the range in which numbers are plausible. A
# machine of some centimetres or of twenty metres may be meant, but none whose units are mistaken.
LENGTH = Size("m", 1e-3, 20)
LENGTH0 = Size("m", 0, 20)
PLACE = Size("m", most=20, signed=True)
ANGLE = Size("rad", most=3.2, signed=True)
COUNT = Size("rad", 1e-9, 0.1)
MACHINE = {"r": LENGTH, "R": LENGTH, "cutter_radius": LENGTH}
MACHINE |= {"depth": Size("m", 1e-4, 1, why=", or no ground is taken"), "height": PLACE}
MACHINE |= dict.fromkeys(("theta_min", "theta_max", "phi_min", "phi_max"), ANGLE)
BODY = {"length": LENGTH, "width": LENGTH, "low": PLACE, "high": PLACE}
BODY |= dict.fromkeys(("holder_radius", "holder_length"), LENGTH0)


def _circle(radius):
    """Return the section of a round tunnel.

    Examples
    --------
    >>> round(_circle(0.5).perimeter, 6)
    3.141593
    """
    return closed_profile([Arc(0.0, 0.0, radius, 0.0, 2 * np.pi)])


# Who makes a section, and of which sizes; a further shape is one entry here. `_read_section` reads
# the list of pieces.
SHAPES = {
    "egg": (Egg, {"a": LENGTH}),
    "circle": (_circle, {"radius": LENGTH}),
    "pieces": (closed_profile, {"snap": Size("m", 0, 5e-4)}),
}
BEGIN = dict.fromkeys("yz", PLACE)
TURN = Size("rad", most=7, signed=True)
# A full turn passes with its rounding.
FORWARDS = ", since pieces run counter-clockwise: a clockwise one begins at its other end"
SWEEP = Size("rad", np.radians(1e-3), 2 * np.pi * (1 + 1e-9), why=FORWARDS)
PIECES = {
    "arc": (Arc, BEGIN | {"radius": Size("m", 1e-3, 100), "start": TURN, "sweep": SWEEP}),
    "line": (Line, BEGIN | {"heading": TURN, "length": Size("m", 1e-6, 50)}),
}
STANCE = dict.fromkeys(("pitch", "yaw"), ANGLE)
LIMITS = {
    "feed": Size("m/s", 1e-3, 1),
    "acceleration": Size("m/s^2", 1e-4, 50),
    "volume": Size("m^3/s", 1e-6, 0.1),
    "flow": Size("m^3/s", 1e-7, 0.01),
    "valve": Size("", 1e-3, 1),
    "power": Size("W", 20, 1e7),
}
GROUND = {
    "energy": Size("J/m^3", 1e3, 1e9),
    "pick_speed": Size("m/s", 0.01, 20),
    "normal": Size("", 0, 5),
    "ripple": Size("", 0, 0.99),
    "ripple_frequency": Size("Hz", 0, 500),
}
CYLINDERS = {"frame_pivot": "a", "arm_pivot": "b"} | {k: k for k in ("bore", "rod", "dead_length")}
HYDRAULICS = {
    "supply": Size("Pa", 1e5, 1e8),
    "tank": Size("Pa", 1e3, 1e7),
    "bulk": Size("Pa", 1e7, 1e10),
    "hose": Size("m^3", 1e-7, 0.01),
    "rated_flow": Size("m^3/s", 1e-7, 0.01),
    "pump": Size("m^3/s", 1e-7, 0.1),
    "valve_lag": Size("s", 1e-5, 0.5),
    "damping": Size("", 1e-3, 2),
}
HYDRAULICS |= dict.fromkeys(("head", "beam"), Size("kg", 0.5, 1e5))
HYDRAULICS |= dict.fromkeys(("lift_friction", "swing_friction"), Size("N m", 0, 1e6))
HYDRAULICS |= dict.fromkeys(("piston_leak", "valve_leak"), Size("m^3/s/Pa", 0, 1e-8))
HYDRAULICS |= {f"{joint}_{name}": LENGTH for joint in ("lift", "swing") for name in CYLINDERS}
PLAN = {
    "tolerance": Size("m", 1e-7, 0.1),
    "step": Size("m", 1e-6, 0.3),
    "tick": Size("s", 1e-4, 0.5),
    "count": COUNT,
    "rest": Size("s", 0, 60),
    "laps": WHOLE,
    "advance": Size("m", 0, 2),
    "arm_radius": Size("m", 0, 5),
    "path": TEXT,
}
LOOP = {"gain": Size("1/s", 0.01, 1e4), "feedforward": Size("", 0, 2), "delay": WHOLE}
# For the controller that is written.
EXPORTED = {"trip": Size("m", 1e-5, 1), "operations": Size("1/s", 1, 1e12)}
CONTROLLER = {"plant": TEXT, "encoder": COUNT._replace(zero=True)} | LOOP | EXPORTED
POSE = dict.fromkeys("yz", Size("m", most=0.2, signed=True))
POSE |= dict.fromkeys(("roll", "pitch", "yaw"), Size("rad", most=0.8, signed=True))
WALL = {"along": WHOLE, "around": WHOLE, "thickness": Size("m", 1e-3, 2)}
# Of what another value may be proposed.
TABLES = {"limits": LIMITS, "hydraulics": HYDRAULICS, "plan": PLAN, "controller": CONTROLLER}
MOST_RAYS = 4_000_000  # of a wall; with all that is made of them they take 2 GB
VALVE = 0.8  # of the open valve, the default limit of a plan in ground
FULL_SPEED = 0.4  # m/s of the cutter at the end of the arm, of the models that have no cylinder
USUAL = {"tick": 5e-3, "count": 2 * np.pi / 2**16}  # in s and rad, the defaults of `ream.plan`


# The models of both axes that a job may ask for; a further model is one entry here.
PLANTS = {
    "T0": lambda job: [Integrator(FULL_SPEED / job.made.R)] * 2,
    "T1": lambda job: [Lag(FULL_SPEED / job.made.R, job.sizes.valve_lag)] * 2,
    "T2": lambda job: [Rigid(axis) for axis in job.cylinders],
    "T3": lambda job: [Compressible(axis) for axis in job.cylinders],
}
FEELING = "T3"  # the model whose axes share an arm and feel the ground


@dataclass(frozen=True)
class Job:
    """A job as its file says it, in SI units: each table is a dict of names and values.

    `read_job` makes one from a file. Its properties are computed when they are first used.

    Parameters
    ----------
    machine : dict
        Arguments of `Machine`, in m and rad.
    section : dict
        ``shape``: "egg", "circle" or "pieces", and its sizes in m and rad.
    limits : dict
        Arguments of `Limits`, without the axes.
    plan : dict
        Options of `ream.plan`.
    controller : dict
        ``plant``, one of `PLANTS`; options of `Loop`; and ``encoder``, the angle of its counts.
    stance : dict
        Pitch and yaw to which the machine is set up, in rad.
    pose : dict
        Arguments of `Pose`: by how much the machine stands elsewhere without knowing it.
    wall : dict
        Numbers of rays ``along`` the tunnel and ``around`` it, and the ``thickness`` of the
        modelled ground, in m.
    hydraulics : dict
        Fields of `Sizes` that differ from the machine's usual ones; those of the cylinders begin
        with ``lift_`` and ``swing_``.
    ground : dict
        Arguments of `Ground`; empty if nothing pushes back.
    body : dict
        Arguments of `Body`; empty if the machine is only an arm and a cutter.
    stamp : str
        What its files say of it: name, digest and version. Equality leaves it out.
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
    stamp: str = field(default="tunneller_lib", compare=False)

    @cached_property
    def made(self):
        """Return the `Machine`, with its `Body` if it has one."""
        with said_of("body"):
            body = Body(**self.body) if self.body else None
        with said_of("machine"):
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
                try:
                    own[joint] = replace(getattr(usual, joint), **changes)
                except ValueError as error:
                    raise ValueError(f"{joint}_{error}") from None
            return replace(usual, **own)

    @cached_property
    def cylinders(self):
        """Return the axes theta and phi, two `Hydraulics`."""
        sizes = self.sizes  # outside: its own refusals need no remedy
        try:
            return axes_of(self.made, sizes)
        except ValueError as error:
            from .checks import cylinders_remedy  # which asks jobs

            raise ValueError(cylinders_remedy(self, error)) from None

    @property
    def oily(self):
        """Return whether both axes are hydraulic."""
        return all(plant.hydraulics is not None for plant in self.axes[0])

    @cached_property
    def arm(self):
        """Return the `Arm` that both joints share, or None if their model doesn't feel it."""
        return arm_of(self.made, self.sizes) if self.controller["plant"] == FEELING else None

    @cached_property
    def pushing(self):
        """Return the `Ground` that the axes feel, or None."""
        return self.cut_ground if self.controller["plant"] == FEELING else None

    @cached_property
    def cut_ground(self):
        """Return the `Ground`, or None if nothing pushes back."""
        with said_of("ground"):
            return Ground(**self.ground) if self.ground else None

    @cached_property
    def circuit(self):
        """Return the `Circuit` of the machine in the section."""
        machine = self.made
        with said_of("section"):
            sizes = dict(self.section)
            section = SHAPES[sizes.pop("shape")][0](**sizes)
            _check_bend(machine, section, self.section)
        return _circuit(machine, section, self.stance)

    @cached_property
    def planned(self):
        """Return the `Plan`; raise ValueError with the reason if the job can't be planned."""
        _, circuit = self.error, self.circuit  # a wrong pose is refused as early
        _check_tolerance(self.made, self.plan)
        if "power" in self.limits and not self.ground:
            raise ValueError("[limits] power: needs a table [ground], which the power cuts.")
        _ = self.axes  # wrong loops are refused before the plan is made
        # The defaults of a plan in oil, and in ground.
        usual = {"flow": self.sizes.pump} if self.oily else {}
        if self.oily and self.ground:
            usual["valve"] = VALVE
        bounds = {**usual, **self.limits, "ground": self.cut_ground}
        if "flow" in bounds or "valve" in bounds:
            bounds["axes"] = self.cylinders
        with said_of("limits"):
            limits = Limits(**bounds)
        with said_of("plan"):
            return plan(circuit, limits, **self.plan)

    @cached_property
    def in_air(self):
        """Return the `Track` of entry, a lap and exit in air, each joint by itself."""
        setvalues, slopes = whole_run(replace(self.planned, laps=1))
        return follow(*self.axes, setvalues, slopes=slopes)

    @cached_property
    def checked(self):
        """Return the warnings, a list of str, that need no simulated wall.

        Raise ValueError with the reason where the job can't be planned or the cut would be
        meaningless.
        """
        from .checks import check  # which asks jobs

        return check(self)

    @cached_property
    def exported(self):
        """Return the `Exported` controller, or why there is none."""
        from .controller import exported  # which is made of jobs

        return exported(self)

    @cached_property
    def margins(self):
        """Return the `Margin`s that the machine has for the plan; none without cylinders."""
        return capability(self.planned, *self.axes, self.sizes) if self.oily else []

    @cached_property
    def in_step(self):
        """Return each joint's `Margin` against chatter by picks in step; none without a ripple."""
        if not self.pushing or not self.pushing.ripple_frequency:
            return []
        return chatter_margins(self.planned, *self.axes)

    @cached_property
    def axes(self):
        """Return the plants and the loops of theta and phi, each a list of two."""
        options = {name: self.controller[name] for name in LOOP if name in self.controller}
        if "encoder" in self.controller:
            options["count"] = self.controller["encoder"]
        with said_of("plan"):
            loop = Loop(1.0, **{name: self.plan.get(name, usual) for name, usual in USUAL.items()})
        with said_of("controller"):
            loop = replace(loop, **options)
        return PLANTS[self.controller["plant"]](self), [loop, loop]

    @cached_property
    def error(self):
        """Return the `Pose` by which the machine stands elsewhere without knowing it, or None."""
        with said_of("pose"):
            return Pose(**self.pose) if self.pose else None

    def simulated(self, say=None):
        """Return the `Cut`; `say` is called with sentences about the progress."""
        shape = self.wall["along"], self.wall["around"]
        about = {"pose": self.error, "arm": self.arm, "ground": self.pushing}
        about |= {"shape": shape, "thickness": self.wall["thickness"], "say": say}
        return simulate(self.planned, *self.axes, **about)


@checked
def read_job(path: str | Path):
    """Return the `Job` that a TOML file asks for, with names, types and units checked.

    The path ``-`` is standard input. A job can't name another file to be read or written.

    Raises
    ------
    WrongJob
        If the file can't be read, isn't TOML, has an unknown table or name, or lacks one.
    """
    tables, stamp = parsed_toml(path)
    known = [one.name for one in fields(Job) if one.name != "stamp"]
    for name, table in tables.items():
        if name not in known:
            raise WrongJob(f"[{brief(name)}]: is no table of a job{hint(name, known)}.")
        if not isinstance(table, dict):
            raise WrongJob(f"{name}: must be a table, [{name}]; got {shown(table)}.")
    for name in NEEDED:
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
        wall=_read_wall(given["wall"]),
        hydraulics=read_table("hydraulics", given["hydraulics"], HYDRAULICS),
        ground=_read_if_any("ground", given["ground"], GROUND, ("energy", "pick_speed")),
        body=_read_if_any("body", given["body"], BODY, ("length", "width", "low", "high")),
        stamp=stamp,
    )


def _read_if_any(table, given, units, needed):
    """Return an optional table's values; if it is there it must hold what is `needed`."""
    return read_table(table, given, units, needed) if given else {}


def _read_wall(given):
    """Return the numbers of rays and the thickness of the modelled ground, in m."""
    wall = {"along": 200, "around": 360, "thickness": 0.1, **read_table("wall", given, WALL)}
    shape = wall["along"], wall["around"]
    with said_of("wall"):
        whole("along, around", shape, 1, MOST_RAYS)
        positive("thickness", wall["thickness"])
        if shape[0] * shape[1] > MOST_RAYS:
            raise ValueError(
                f"along, around: must be at most {MOST_RAYS} rays together; "
                f"got {shape[0]} x {shape[1]}."
            )
    return wall


def _read_section(given):
    """Return the values of the section's table, with its pieces as arcs and lines."""
    given = dict(given)
    shape = given.pop("shape", None)
    one_of("[section] shape", shape, SHAPES)
    _, units = SHAPES[shape]
    if shape != "pieces":
        return {"shape": shape, **read_table("section", given, units, units)}
    rows = given.pop("pieces", None)
    rest = read_table("section", given, {"pieces": TEXT, "shape": TEXT} | units)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise WrongJob("[section] pieces: must be a list of tables, [[section.pieces]].")
    pieces = []
    for number, row in enumerate(map(dict, rows), start=1):
        where = f"section.pieces {number}"
        kind = row.pop("kind", None)
        one_of(f"[{where}] kind", kind, PIECES)
        make, units = PIECES[kind]
        sizes = read_table(where, row, units, units)
        with said_of(where):
            pieces.append(make(**sizes))
    return {"shape": shape, "pieces": tuple(pieces), **rest}


def _check_bend(machine, section, given):
    """Raise ValueError if the cutter doesn't fit the tightest bend of a section."""
    bend, keeps = section.least_radius, machine.offset
    if keeps < bend * (1 - 1e-9):
        return
    wider = 1.05 * keeps
    sizes = [key for key in given if key not in ("shape", "snap")]
    if given["shape"] == "pieces":
        found = f"a bend of {bend:g} m" if bend else "a corner"
        would_do = f"an arc of {wider:.2g} m in its place"
    else:
        (key,) = sizes
        found = f"{given[key]:g} m, which bends by {bend:g} m"
        would_do = f"{given[key] * wider / bend:.2g} m"
    smaller = machine.depth + 0.95 * bend
    if bend and smaller > machine.depth:
        would_do += f", or [machine] cutter_radius = {smaller:.2g},"
    raise ValueError(
        f"{', '.join(sizes)}: each bend must be wider than {keeps:g} m, the cutter_radius less the "
        f"depth; got {found}; {would_do} would do."
    )


def _circuit(machine, section, stance):
    """Return the circuit; a machine that can't run it is told the height or the limits it needs."""
    try:
        return cutting_circuit(machine, section, **stance)
    except ValueError as error:
        said = f"[machine] {str(error).removeprefix('machine: ')}"
        low, high = machine.heights(section)
        if not any(stance.values()) and low < high and not low <= machine.height <= high:
            said += f" [machine] height: may be from {low:.3f} to {high:.3f} m."
        elif needed := _limits_needed(Circuit(machine, section, **stance)):
            said += f" {needed} would do."
        raise ValueError(said) from None


def _limits_needed(circuit):
    """Return joint limits that would let a machine run a circuit, as a job says them, or ""."""
    try:
        low, high = np.degrees(circuit.reach())
    except ValueError:  # beyond the arm's reach
        return ""
    limits = {}
    for joint, least, most in zip(("theta", "phi"), low, high, strict=True):
        if np.radians(least) < getattr(circuit.machine, f"{joint}_min"):
            limits[f"{joint}_min_deg"] = np.floor(least)
        if np.radians(most) > getattr(circuit.machine, f"{joint}_max"):
            limits[f"{joint}_max_deg"] = np.ceil(most)
    return " with ".join(f"{key} = {value:g}" for key, value in limits.items())


def _check_tolerance(machine, plan):
    """Raise ValueError if the tolerance is below what one count moves the cutter.

    Examples
    --------
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE
    >>> _check_tolerance(REFERENCE_MACHINE, {"tolerance": 1e-6})  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: [plan] tolerance: must be at least the 8.4e-05 m that a count moves ...
    """
    count = plan.get("count", USUAL["count"])
    moved = count * (machine.r + machine.R)
    if 0 < plan["tolerance"] < moved:
        raise ValueError(
            f"[plan] tolerance: must be at least the {moved:.2g} m that a count moves the cutter; "
            f"got {plan['tolerance']:g} m with a count of {count:.2g} rad."
        )
