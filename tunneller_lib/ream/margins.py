"""Whether a machine can do a planned cut: the torque, gain, oil and stroke that it has and needs.

Also whether picks that follow each other in one track would drive the oil's resonance.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import checked
from ..motion.sizing import Sizes
from ..motion.stability import gain_limit
from ..paths.circuit import Circuit
from .both_axes import Loops, Plants, check_ticks
from .cutting import Cut
from .feed import drawn_oil
from .front import engaged_areas, push_levers
from .moves import levers
from .planning import Plan

JOINTS = "theta", "phi"
ACTUATORS = "lift", "swing"
SECOND = 1.0  # s, over which the head's power is averaged, as a motor bears for so long
MOST_LOOKED = 50_000  # ticks of a lap, at which torque and oil are looked at
PLACES = 41  # of the circuit, at which oil and loop are looked at
FREQUENCIES = np.linspace(0.2, 60.0, 20_000)  # Hz, at which chatter is looked for
FEW = 21  # places of the circuit, at which chatter is looked for


class Margin(NamedTuple):
    """The amount of something that a machine has and that a cut needs.

    Parameters
    ----------
    what : str
        The thing that is compared, such as "gain of theta".
    has, needs : float
        The amount that the machine has, and that the cut needs.
    unit : str
        The unit of both, "" for a ratio.
    remedy : str
        End of a sentence about what would do if the machine has too little.
    """

    what: str
    has: float
    needs: float
    unit: str
    remedy: str

    @property
    def enough(self):
        """Whether the machine has more than the cut needs."""
        return self.has > self.needs

    def __str__(self):
        needs, has = (f"{amount:.3g} {self.unit}".rstrip() for amount in (self.needs, self.has))
        return f"{self.what}: needs {needs} and has {has}; {self.remedy}."


@checked
def gain_margins(circuit: Circuit, plant: Plants, loop: Loops):
    """Return the margins of both loops on a circuit, for which no plan is needed.

    Parameters
    ----------
    circuit : Circuit
        The circuit that both joints follow.
    plant : Plant or a pair of them
        The axes theta and phi, which must have cylinders.
    loop : Loop or a pair of them
        Their position loops, without integral.

    Returns
    -------
    margins : list of Margin
        Of each joint the gain, with its least limit along the circuit, in 1/s, and the resonance,
        with its least along the circuit, in Hz: 2 zeta w must exceed the gain.
    """
    axes = _cylinders(plant)
    at = circuit.position(np.linspace(0, circuit.profile.perimeter, PLACES))
    found = []
    # A loop about a resonance w with ratio zeta is stable up to Kv = 2 zeta w, so the gain needs at
    # least the resonance Kv/(2 zeta), which the second row gives in Hz.
    lower = "a lower [controller] gain, or [hydraulics] with more damping, a greater bore, "
    hose = lower + "a smaller hose, would do"
    lighter = lower + "a lighter head or arm, would do"
    for name, one, control, axis, angle in zip(JOINTS, plant, loop, axes, at.T, strict=True):
        limit = gain_limit(one, control, angle)
        least = float(np.min(axis.natural_frequency(angle)))
        ratio = axis.damping / (2 * axis.inertia * least)
        hertz = least / (2 * np.pi)
        needs = control.gain / (2 * ratio) / (2 * np.pi)
        found.append(Margin(f"gain of {name}", limit, control.gain, "1/s", hose))
        found.append(Margin(f"resonance of {name}", hertz, needs, "Hz", lighter))
    return found


@checked
def capability(plan: Plan, plant: Plants, loop: Loops, sizes: Sizes):
    """Return what the machine has and a planned cut needs, as `Margin`s.

    Parameters
    ----------
    plan : Plan
        The plan to run; its limits have the ground that pushes.
    plant : Plant or a pair of them
        The axes theta and phi, which must have cylinders.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick, without integral.
    sizes : Sizes
        The sizes of the hydraulics.

    Returns
    -------
    margins : list of Margin
        Torque of both joints against the ground at the worst place, in N m; gain and resonance; the
        pump's flow, in m^3/s; and the stroke that each cylinder holds at its shortest, in m.

    Raises
    ------
    ValueError
        If a plant has no cylinder, or a loop another tick than the plan or an integral.
    """
    check_ticks(plan, loop)
    axes = _cylinders(plant)
    circuit = plan.circuit
    way = plan.route
    looked = slice(None, None, 1 + len(plan.reached) // MOST_LOOKED)
    length = ((plan.reached[1:] + plan.reached[:-1]) / 2)[looked]
    feed = np.diff(plan.reached)[looked] / plan.tick
    at = way.at(length)
    slopes = way.at(length, order=1)
    found = []
    if plan.limits.ground is not None:
        ground = plan.limits.ground
        places = way.place(length)
        force = (1 + ground.ripple) * ground.force(engaged_areas(circuit, places) * feed)
        torque = force[:, None] * push_levers(circuit, ground, places, at, slopes)
        for joint, (name, cylinder) in enumerate(zip(JOINTS, ACTUATORS, strict=True)):
            has, needs = _torques(axes[joint], at[:, joint], torque[:, joint])
            greater = f"a greater {cylinder}_bore or supply in [hydraulics]"
            remedy = f"a lower [limits] feed or power, or {greater}, would do"
            found.append(Margin(f"torque of {name}", has, needs, "N m", remedy))
    found += gain_margins(circuit, plant, loop)
    drawn = drawn_oil(axes, at, slopes * feed[:, None])
    oil = "a lower [limits] feed, or a greater pump in [hydraulics], would do"
    found.append(Margin("pump", sizes.pump, float(drawn.max()), "m^3/s", oil))
    for axis, name in zip(axes, ACTUATORS, strict=True):
        short, long = sorted((axis.linkage.length(axis.low), axis.linkage.length(axis.high)))
        holds = short - axis.linkage.dead_length
        other = f"other {name}_frame_pivot, _arm_pivot or _dead_length in [hydraulics] would do"
        found.append(Margin(f"stroke of the {name}", holds, long - short, "m", other))
    return found


@checked
def used(plan: Plan, plant: Plants, cut: Cut, sizes: Sizes):
    """Return the greatest power, valve openings and flow in the laps of a simulated cut.

    Parameters
    ----------
    plan : Plan
        The plan that was run; its limits have the power and the ground.
    plant : Plant or a pair of them
        The axes theta and phi.
    cut : Cut
        A cut of that plan, with its track.
    sizes : Sizes
        The sizes of the hydraulics.

    Returns
    -------
    margins : list of Margin
        The head's mean power over a second, in W, if the plan limits it; the valves' openings, as
        shares; and, of axes with cylinders, the pump's flow in a tick, in m^3/s.

    Raises
    ------
    ValueError
        If the cut has no track.

    Examples
    --------
    >>> from tunneller_lib.motion import Lag
    >>> from tunneller_lib.motion.sizing import usual_sizes
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.ream import Limits, carve, plan
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> lap = plan(circuit, Limits(feed=0.1, acceleration=0.5), tolerance=1e-3)
    >>> cut = carve(lap, lap.setvalues, shape=(20, 40))
    >>> used(lap, Lag(0.5, 0.02), cut, usual_sizes(REFERENCE_MACHINE))
    Traceback (most recent call last):
    ValueError: cut: must have a track, as by `simulate`; got one without.
    """
    if cut.track is None:
        raise ValueError("cut: must have a track, as by `simulate`; got one without.")
    limits = plan.limits
    slower = "a lower [limits] feed or power would do"
    found = []
    if limits.power < np.inf:
        time = plan.tick * cut.noted
        volume = np.concatenate([[0.0], np.cumsum(cut.removed)])
        later = np.minimum(np.searchsorted(time, time[:-1] + SECOND), len(time) - 1)
        rate = (volume[later] - volume[:-1]) / (time[later] - time[:-1])
        whole = time[later] - time[:-1] >= min(SECOND, time[-1])
        power = float(limits.ground.power(rate[whole].max()))
        found.append(Margin("power in a second", limits.power, power, "W", slower))
    for name, command in zip(JOINTS, cut.track.command.T, strict=True):
        found.append(Margin(f"valve of {name}", 1.0, float(np.abs(command).max()), "", slower))
    if all(one.hydraulics for one in plant):
        position = cut.track.position
        at = (position[1:] + position[:-1]) / 2
        drawn = drawn_oil(_cylinders(plant), at, np.diff(position, axis=0) / plan.tick)
        found.append(Margin("oil in a tick", sizes.pump, float(drawn.max()), "m^3/s", slower))
    return found


def _cylinders(plant):
    """Return the `Hydraulics` of both plants, each of which must have them."""
    axes = [one.hydraulics for one in plant]
    if None in axes:
        lacking = plant[axes.index(None)]
        raise ValueError(f"plant: must have cylinders; got {type(lacking).__name__}, without.")
    return axes


def _torques(axis, angle, torque):
    """Return the torque that the oil can give beside the weight, and the needed one, in N m.

    They are those of the place at which their ratio is least.
    """
    has = np.full(angle.shape, np.inf)
    for sign, (D, rho, load) in zip((1, -1), axis.sides(angle), strict=True):
        # At rest the filled side has the full supply, the emptied one the tank's pressure.
        can = D * (axis.supply - rho * axis.tank) - load
        has = np.where(sign * torque > 0, can, has)
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = int(np.nanargmin(has / np.abs(torque)))
    return float(has[worst]), float(np.abs(torque[worst]))


def chatter_limit(plant, loop, angle, lever, picks):
    """Return the damper of the ground from which a joint chatters, in N s/m, and the frequency.

    Only in slow motion the force per speed is the damper E A / u. If each pick cuts exactly what
    the one before it left, a time t = 1 / `picks` earlier, a swing x of the cutter along its way
    meets the force damper (x - x(t earlier)) / t, which drives swings from one half to one times
    the picks' frequency, from three halves to two times, and so on. On a `lever` in m, at a joint
    `angle` in rad, and with the valve hardly open, where the oil damps least, the joint answers a
    torque by 1 / Z:

        Z = J s^2 + b s + J w^2 (1 + Kv exp(-late s) / (s (1 + lag s))),

    and chatters from the least damper for which, at some s = 2 pi i f,

        Z + lever^2 damper (1 - exp(-s t)) / t = 0.

    Dry friction, leaks, which damp, and picks that aren't in step are left out.

    Parameters
    ----------
    plant : Compressible
        The axis.
    loop : Loop
        Its position loop, without integral.
    angle, lever : float
        Joint angle in rad and lever in m.
    picks : float
        Frequency at which picks cut, each in the track of the one before, in Hz.

    Returns
    -------
    damper, frequency : float
        In N s/m and Hz; infinite and 0 if there is no chatter up to 60 Hz.
    """
    axis = plant.axis
    s = 2j * np.pi * FREQUENCIES
    spring = axis.inertia * axis.natural_frequency(angle) ** 2
    late = loop.tick * (loop.delay + 0.5)
    steered = loop.gain * np.exp(-s * late) / (s * (1 + s * axis.valve_lag))
    stiff = axis.inertia * s**2 + axis.damping * s + spring * (1 + steered)
    needed = -stiff / (lever**2 * picks * (1 - np.exp(-s / picks)))
    # A damper is real. Sign changes at poles, whole multiples of the picks' frequency, don't count.
    turns = np.flatnonzero(np.diff(np.sign(needed.imag)))
    real = needed.real[turns]
    near = np.abs(np.diff(needed.imag)[turns]) < np.abs(real)
    turns = turns[(real > 0) & near]
    if not len(turns):
        return np.inf, 0.0
    least = turns[np.argmin(needed.real[turns])]
    return float(needed.real[least]), float(FREQUENCIES[least])


def chatter_margins(plan, plant, loop):
    """Return the dampers that both joints bear on a circuit with picks in step, as `Margin`s.

    The needed one is the damper E A / u of the ground where the ball's front is largest, in N s/m.

    Parameters
    ----------
    plan : Plan
        The plan to run, in ground whose ripple has the picks' frequency.
    plant, loop : pair of Compressible and of Loop
        The axes theta and phi, and their loops.
    """
    circuit = plan.circuit
    ground = plan.limits.ground
    places = np.linspace(0, circuit.profile.perimeter, FEW)
    at = circuit.position(places)
    lever = levers(circuit.machine.torus, at)
    every = np.linspace(0, circuit.profile.perimeter, 20 * FEW)  # the front is widest at bends
    needs = float(np.max(ground.force(engaged_areas(circuit, every))))
    found = []
    for joint, name in enumerate(JOINTS):
        has = min(
            chatter_limit(plant[joint], loop[joint], angle, length, ground.ripple_frequency)[0]
            for angle, length in zip(at[:, joint], lever[:, joint], strict=True)
        )
        remedy = "picks that don't follow each other in one track would do"
        found.append(Margin(f"in step, {name}", has, needs, "N s/m", remedy))
    return found
