"""A cut asked for by a small TOML file, such as reference.toml beside this module.

Names, types and units are checked here; sizes by what they are for.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arguments import checked, positive, shown, whole
from ..motion import Compressible, Integrator, Lag, Loop, Rigid
from ..motion.sizing import arm_of, axes_of, usual_sizes
from ..paths import cutting_circuit
from ..ream import Limits, Pose, gain_margins, plan, simulate
from ..ream.cutting import expected_seconds
from ..ream.margins import capability, chatter_margins
from ..removal import Ground
from ..removal.dexel import allowed_memory, check_fits
from ..surfaces import Arc, Body, Egg, Line, Machine, closed_profile
from .tables import (
    NEEDED,
    TEXT,
    WHOLE,
    Size,
    WrongJob,
    brief,
    check_leaves,
    hint,
    one_of,
    parsed_toml,
    read_table,
    said_of,
)

# What each table may hold: TEXT, WHOLE, or a unit and from where to where numbers are plausible. A
# machine of some centimetres or of twenty metres may be meant, and none whose units are mistaken.
ANGLE = Size("rad", most=3.2)
MACHINE = dict(
    r=Size("m", 1e-3, 5), R=Size("m", 0.01, 20), theta_min=ANGLE, theta_max=ANGLE, phi_min=ANGLE,
    phi_max=ANGLE, cutter_radius=Size("m", 1e-3, 5), depth=Size("m", most=1),
    height=Size("m", most=20),
)  # fmt: skip
BODY = dict(
    length=Size("m", most=20), width=Size("m", most=20), low=Size("m", most=20),
    high=Size("m", most=20), holder_radius=Size("m", most=5), holder_length=Size("m", most=10),
)  # fmt: skip


def _circle(radius):
    return closed_profile([Arc(0.0, 0.0, radius, 0.0, 2 * np.pi)])


# What makes a section, and of which sizes; a further one is one entry here. Pieces are read apart.
SHAPES = {
    "egg": (Egg, dict(a=Size("m", 0.01, 20))),
    "circle": (_circle, dict(radius=Size("m", 0.01, 20))),
    "pieces": (closed_profile, dict(snap=Size("m", 0, 5e-4))),
}
PIECES = {
    "arc": (Arc, dict(y=Size("m", most=20), z=Size("m", most=20), radius=Size("m", most=100),
                      start=Size("rad", most=7), sweep=Size("rad", most=7))),
    "line": (Line, dict(y=Size("m", most=20), z=Size("m", most=20), heading=Size("rad", most=7),
                        length=Size("m", most=50))),
}  # fmt: skip
STANCE = dict(pitch=Size("rad", most=1.6), yaw=Size("rad", most=1.6))
LIMITS = dict(
    feed=Size("m/s", 1e-4, 1), acceleration=Size("m/s^2", 1e-4, 50), volume=Size("m^3/s", 0, 0.1),
    flow=Size("m^3/s", 0, 0.01), valve=Size("1", 0, 1), power=Size("W", 20, 1e7),
)  # fmt: skip
GROUND = dict(
    energy=Size("J/m^3", 1e3, 1e10), pick_speed=Size("m/s", 0.01, 20), normal=Size("1", 0, 5),
    ripple=Size("1", 0, 2), ripple_frequency=Size("Hz", 0, 500),
)  # fmt: skip
CYLINDERS = dict(frame_pivot="a", arm_pivot="b", bore="bore", rod="rod", dead_length="dead_length")
LEAK, FRICTION = Size("m^3/s/Pa", 0, 1e-8), Size("N m", 0.1, 1e6)
HYDRAULICS = dict(
    head=Size("kg", 0.5, 1e5), beam=Size("kg", 0.5, 1e5), supply=Size("Pa", 1e5, 1e8),
    tank=Size("Pa", 1e3, 1e7), bulk=Size("Pa", 1e7, 1e10), hose=Size("m^3", 1e-7, 0.01),
    rated_flow=Size("m^3/s", 0, 0.01), valve_lag=Size("s", 0, 0.5), damping=Size("1", 0, 2),
    lift_friction=FRICTION, swing_friction=FRICTION, piston_leak=LEAK, valve_leak=LEAK,
    pump=Size("m^3/s", 0, 0.1),
)  # fmt: skip
HYDRAULICS |= {
    f"{joint}_{name}": Size("m", 1e-3, most)
    for joint in ("lift", "swing")
    for name, most in zip(CYLINDERS, (20, 10, 2, 2, 10), strict=True)
}
# An encoder is often told by its counts or its bits.
COUNT = Size("rad", 1e-9, 0.1, (
    ("counts a turn", lambda number: 2 * np.pi / number),
    ("bits", lambda number: 2 * np.pi / 2.0 ** min(number, 64)),
))  # fmt: skip
PLAN = dict(
    tolerance=Size("m", 0, 0.1), step=Size("m", 0, 0.3), tick=Size("s", 0, 0.5), count=COUNT,
    rest=Size("s", 0, 60), laps=WHOLE, advance=Size("m", 0, 2), arm_radius=Size("m", 0, 5),
    path=TEXT,
)  # fmt: skip
CONTROLLER = dict(
    plant=TEXT, gain=Size("1/s", 0, 1e4), integral=Size("1/s^2", 0, 1e6),
    feedforward=Size("1", 0, 2), delay=WHOLE, encoder=COUNT, trip=Size("m", 1e-5, 1),
    operations=Size("1/s", 0, 1e12),
)  # fmt: skip
TILT = Size("rad", most=0.8)
POSE = dict(y=Size("m", most=0.2), z=Size("m", most=0.2), roll=TILT, pitch=TILT, yaw=TILT)
WALL = dict(along=WHOLE, around=WHOLE, thickness=Size("m", most=2))
MOST_RAYS = 100_000  # each way; memory bounds both together
# Bytes at a command's peak. tests/test_memory.py measures them; a tick takes more with plant T3.
A_RAY, A_TICK = 500, 1200
VALVE = 0.8  # of the open valve, what a plan in ground asks for by default
FULL_SPEED = 0.4  # m/s of the cutter at the end of the arm, of the models that have no cylinder
HYDRAULIC_REMEDY = (
    "The cylinders' sizes are those of [hydraulics]: lift_ and swing_ frame_pivot, arm_pivot, "
    'bore, rod and dead_length, and supply; or take plant = "T0" in [controller], which has none.'
)
USUAL = {"tick": 5e-3, "count": 2 * np.pi / 2**16}  # in s and rad, as of `ream.plan`
EXPORTED = "trip", "operations"  # of the exported controller alone
MOST_ENCODER = 0.1  # rad, as of a plan's count


# The models of both axes that a job may ask for; a further one is one entry here.
PLANTS = {
    "T0": lambda job: [Integrator(job.full_rate)] * 2,
    "T1": lambda job: [Lag(job.full_rate, job.sizes.valve_lag)] * 2,
    "T2": lambda job: [Rigid(axis) for axis in job.cylinders],
    "T3": lambda job: [Compressible(axis) for axis in job.cylinders],
}
FEELING = "T3"  # the one whose axes share an arm and feel the ground


@dataclass(frozen=True)
class Job:
    """What a file asks for, in SI units: each table a dict of its names and values.

    `read_job` makes one from a file. Nothing is computed before it is asked for.

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
        ``plant``, one of `PLANTS`, options of `Loop`, and ``encoder``, the angle of its counts.
    stance : dict
        Pitch and yaw at which the machine is set up, in rad.
    pose : dict
        Arguments of `Pose`, by which the machine really stands, unknown to it.
    wall : dict
        Rays ``along`` the tunnel and ``around`` it; ``thickness`` of the modelled ground, in m.
    hydraulics : dict
        Fields of `Sizes` that aren't the machine's usual ones; those of the cylinders begin with
        ``lift_`` and ``swing_``.
    ground : dict
        Arguments of `Ground`: empty where nothing pushes back.
    body : dict
        Arguments of `Body`: empty where only arm and cutter fill room.
    stamp : str
        What its files say of it: name, digest and version. Jobs that ask for the same are equal.
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
        sizes = self.sizes  # refused by itself
        with said_of("hydraulics", remedy=HYDRAULIC_REMEDY):
            return axes_of(self.made, sizes)

    @property
    def full_rate(self):
        """Return the full speed of both joints, in rad/s, of models without cylinders."""
        return FULL_SPEED / self.made.R

    @property
    def oily(self):
        """Return whether both axes are hydraulic."""
        return all(plant.hydraulics is not None for plant in self.axes[0])

    @cached_property
    def arm(self):
        """Return the `Arm` that both joints share, or None if their plants don't feel it."""
        return arm_of(self.made, self.sizes) if self.controller["plant"] == FEELING else None

    @cached_property
    def pushing(self):
        """Return the `Ground` that the axes feel, or None."""
        return self.cut_ground if self.controller["plant"] == FEELING else None

    @cached_property
    def cut_ground(self):
        """Return the `Ground`, or None where nothing pushes back."""
        with said_of("ground"):
            return Ground(**self.ground) if self.ground else None

    @cached_property
    def planned(self):
        """Return the `Plan`, or raise ValueError with the reason against it."""
        machine = self.made
        with said_of("section"):
            section = _shape(self.section)
        circuit = _circuit(machine, section, self.stance)
        _check_tolerance(machine, self.plan)
        if "power" in self.limits and not self.ground:
            raise ValueError("[limits] power: needs the ground that takes it, a table [ground].")
        plants, loops = self.axes
        # What a plan in oil, and in ground, is limited by unless the job says so.
        usual = {"flow": self.sizes.pump} if self.oily else {}
        if self.oily and self.ground:
            usual["valve"] = VALVE
        bounds = {**usual, **self.limits, "ground": self.cut_ground}
        if "flow" in bounds or "valve" in bounds:
            bounds["axes"] = self.cylinders
        with said_of("limits"):
            limits = Limits(**bounds)
        if self.oily and not loops[0].integral:
            for margin in gain_margins(circuit, plants, loops):
                if margin.what.startswith("gain") and not margin.enough:
                    raise ValueError(f"[controller] {margin}")
        with said_of("plan", self.plan):
            return plan(circuit, limits, **self.plan)

    @cached_property
    def margins(self):
        """Return the list of `Margin` that the machine has for the plan; none without cylinders."""
        plants, loops = self.axes
        if not self.oily or loops[0].integral:
            return []
        return capability(self.planned, plants, loops, self.sizes)

    @cached_property
    def in_step(self):
        """Return each joint's `Margin` against chatter if the picks are in step, or none."""
        plants, loops = self.axes
        if not self.pushing or not self.pushing.ripple_frequency or loops[0].integral:
            return []
        return chatter_margins(self.planned, plants, loops)

    @cached_property
    def axes(self):
        """Return the plants and the loops of theta and phi, each a list of two."""
        about = dict(self.controller)
        plants = PLANTS[about.pop("plant")]
        encoder = about.pop("encoder", None)
        for own in EXPORTED:
            about.pop(own, None)
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
        return plants(self), [loop, loop]

    @cached_property
    def error(self):
        """Return the `Pose` that the machine has and doesn't know of, or None."""
        with said_of("pose", self.pose):
            return Pose(**self.pose) if self.pose else None

    @property
    def limit(self):
        """Return the overbreak at which the colours of pictures end, in m."""
        return 1.5 * self.plan["tolerance"]

    @property
    def expected_seconds(self):
        """Return about how long axes and wall of `simulated` will take, two numbers in s."""
        options = self._options
        about = {name: options[name] for name in options if name != "pose"}
        with said_of("wall", instead=("shape", "along, around")):
            return expected_seconds(self.planned, *self.axes, **about)

    @cached_property
    def _options(self):
        """Return the options of `simulate`; too many rays or ticks for the memory are refused."""
        shape = self.wall["along"], self.wall["around"]
        with said_of("wall"):
            whole("along, around", shape, 1, MOST_RAYS)
            thickness = positive("thickness", self.wall.get("thickness", 0.1))
        with said_of("wall", instead=("shape", "along, around")):
            check_fits(shape, A_RAY, allowed_memory(), "rays, with all that is made of them,")
        ticks = self.planned.laps * int(self.planned.ticks.sum())
        if A_TICK * ticks > allowed_memory():
            raise ValueError(
                f"[plan] tick, laps: {ticks} ticks need {A_TICK * ticks / 1e9:.3g} GB, and "
                f"{allowed_memory() / 1e9:.3g} GB are allowed."
            )
        ground = {"arm": self.arm, "ground": self.pushing}
        return {"pose": self.error, "shape": shape, "thickness": thickness, **ground}

    def simulated(self, say=None):
        """Return the `Cut`, or raise ValueError with the reason; `say` gets the progress."""
        with said_of("wall", instead=("shape", "along, around")):
            return simulate(self.planned, *self.axes, say=say, **self._options)


@checked
def read_job(path: str | Path):
    """Return the `Job` that a TOML file asks for, checked for names, types and units.

    The path ``-`` is standard input. A job names no other file, so that nothing else can be read
    or written at its wish.

    Raises
    ------
    WrongJob
        If the file can't be read, isn't TOML, or has a table, a name or a value that it shouldn't
        have or lacks one.
    """
    tables, stamp = parsed_toml(path)
    check_leaves(tables)
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
        wall={"along": 200, "around": 360, **read_table("wall", given["wall"], WALL)},
        hydraulics=read_table("hydraulics", given["hydraulics"], HYDRAULICS),
        ground=_read_if_any("ground", given["ground"], GROUND, ("energy", "pick_speed")),
        body=_read_if_any("body", given["body"], BODY, ("length", "width", "low", "high")),
        stamp=stamp,
    )


def _read_if_any(table, given, units, needed):
    """Return what a table says: nothing if it is missing, else with all that it needs."""
    return read_table(table, given, units, needed) if given else {}


def _read_section(given):
    """Return what a section's table says, with its pieces as arcs and lines."""
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
        with said_of(where, sizes):
            pieces.append(make(**sizes))
    return {"shape": shape, "pieces": tuple(pieces), **rest}


def _shape(section):
    """Return the Section that a table says."""
    sizes = dict(section)
    make, _ = SHAPES[sizes.pop("shape")]
    return make(**sizes)


def _circuit(machine, section, stance):
    """Return the circuit, or raise ValueError with the heights of the machine that would do."""
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
    """Raise ValueError if the tolerance is below what one count moves the cutter."""
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
