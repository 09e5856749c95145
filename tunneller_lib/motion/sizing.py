"""The sizes of a machine's hydraulics: usual ones for its arm, and the axes that they make.

All are the study's assumptions. Machines are taken as similar: for an arm s times as long, lengths
grow as s, masses and volumes as s^3, a valve's flow as s^2 and its lag as s; pressures and oil stay
the same. Cutters are then equally fast, joints and resonances s times slower.
"""

from dataclasses import dataclass, replace

from ..arguments import checked
from ..surfaces import Machine
from ..surfaces.linkage import USUAL_R, Linkage, usual_linkages
from .arm import Arm
from .hydraulics import STROKE_MARGIN, Hydraulics
from .quantities import Quantity, Size, Size0

LAND = 35e5  # Pa, the pressure drop at a land at a valve's rated flow
SHARED = "supply", "tank", "bulk", "hose", "valve_lag", "piston_leak", "valve_leak"  # of both axes


@dataclass(frozen=True)
@checked
class Sizes:
    """The sizes of the hydraulics of a machine's two axes.

    Parameters
    ----------
    lift, swing : Linkage
        The cylinders of theta and of phi.
    head, beam : float
        Masses of the cutter head and of the arm, in kg, as in `Arm`.
    supply, tank : float
        Pressures, in Pa.
    bulk : float
        Bulk modulus of the oil with its hoses, in Pa.
    hose : float
        Volume of oil between valve and piston on each side of each axis, in m^3.
    rated_flow : float
        Flow of each open valve at 35 bar per land, in m^3/s.
    valve_lag : float
        Time constant of the spools, in s.
    damping : float
        Damping ratio of each resonance at joint angle 0, or at the end of the stroke nearest to it.
    lift_friction, swing_friction : float
        Dry friction of theta and of phi, including the seals, in N m.
    piston_leak, valve_leak : float
        Leaks past each piston and past each land, in m^3/s/Pa.
    pump : float
        Flow of oil from the pump to both axes together, in m^3/s.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    lift: Linkage
    swing: Linkage
    head: Size
    beam: Size0
    supply: Size
    tank: Size
    bulk: Size
    hose: Size
    rated_flow: Size
    valve_lag: Size
    damping: Quantity
    lift_friction: Size0
    swing_friction: Size0
    piston_leak: Size0
    valve_leak: Size0
    pump: Size


@checked
def usual_sizes(machine: Machine):
    """Return the study's `Sizes` for a machine, scaled by the length of its arm.

    Parameters
    ----------
    machine : Machine
        The machine, of which only `R` counts.

    Returns
    -------
    sizes : Sizes
        At R = 0.80 m: a head of 30 kg, an arm of 60 kg, 160 bar, hoses of 50 cm^3, valves of 4
        L/min with a lag of 4 ms, dry friction of 40 and 20 N m, and leaks of 0.2 L/min at rest.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE
    >>> twice = usual_sizes(replace(REFERENCE_MACHINE, r=0.16, R=1.6))
    >>> twice.head, twice.piston_leak
    (240.0, 2e-13)
    """
    s = machine.R / USUAL_R
    lift, swing = usual_linkages(machine.R)
    return Sizes(
        lift=lift,
        swing=swing,
        head=30.0 * s**3,
        beam=60.0 * s**3,
        supply=160e5,
        tank=3e5,
        bulk=1.0e9,
        hose=5e-5 * s**3,
        rated_flow=4e-3 / 60 * s**2,
        valve_lag=4e-3 * s,
        damping=0.15,
        lift_friction=40.0 * s**3,
        swing_friction=20.0 * s**3,
        piston_leak=1e-13 * s,
        valve_leak=1e-13 * s**2,
        pump=1.5e-4 * s**2,
    )


@checked
def arm_of(machine: Machine, sizes: Sizes):
    """Return the `Arm` that both joints of a machine carry."""
    return Arm(machine.r, machine.R, head=sizes.head, beam=sizes.beam)


@checked
def axes_of(machine: Machine, sizes: Sizes):
    """Return the axes theta and phi of a machine, each as if the other joint stood at 0.

    Parameters
    ----------
    machine : Machine
        The machine. The strokes extend 2 degrees beyond its joint limits.
    sizes : Sizes
        Sizes of cylinders, masses, oil and valves.

    Returns
    -------
    theta, phi : Hydraulics
        Axes with the inertia and the weight of the `Arm` at joint angles 0, where only theta
        carries the weight.

    Raises
    ------
    ValueError
        If a linkage doesn't allow its stroke, or the supply can't move the weight everywhere.
    """
    arm = arm_of(machine, sizes)
    about_theta, about_phi = map(float, arm.inertias(0.0))
    weight = -float(arm.weight((0.0, 0.0))[0])
    lift = (sizes.lift, machine.theta_min, machine.theta_max, about_theta, weight)
    swing = (sizes.swing, machine.phi_min, machine.phi_max, about_phi, 0.0)
    return (_axis(sizes, *lift, sizes.lift_friction), _axis(sizes, *swing, sizes.swing_friction))


def _axis(sizes, linkage, least, greatest, inertia, gravity, friction):
    """Return one of `axes_of` between joint limits, with its damping ratio set near angle 0."""
    axis = Hydraulics(
        linkage=linkage,
        low=least - STROKE_MARGIN,
        high=greatest + STROKE_MARGIN,
        inertia=inertia,
        gravity=gravity,
        damping=inertia,  # a placeholder: the frequency, which sets it below, doesn't depend on it
        flow=sizes.rated_flow / LAND**0.5,
        friction=friction,
        **{name: getattr(sizes, name) for name in SHARED},
    )
    middle = min(max(0.0, axis.low), axis.high)
    return replace(axis, damping=2 * sizes.damping * axis.natural_frequency(middle) * inertia)


@checked
def reference_axes(machine: Machine, *, damping: Quantity = 0.15):
    """Return the axes theta and phi of a machine's `usual_sizes`, without dry friction and leaks.

    Parameters
    ----------
    machine : Machine
        The machine, of which joint limits and radii count.
    damping : float
        Damping ratio of the resonance at joint angle 0, or at the end of the stroke nearest to it.

    Returns
    -------
    theta, phi : Hydraulics
        As by `axes_of`.
    """
    smooth = dict.fromkeys(("lift_friction", "swing_friction", "piston_leak", "valve_leak"), 0.0)
    return axes_of(machine, replace(usual_sizes(machine), damping=damping, **smooth))
