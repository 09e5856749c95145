"""Hydraulic axes: sizes, steady motion and its inverse, natural frequency.

All sizes are the study's assumptions; the document names the parts and gives none.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Angle, Angles, Finite, Reals, checked
from ..surfaces import Linkage, Machine, linkages
from ..surfaces.linkage import JointAngles, check_stroke
from .plant import Resonance
from .quantities import Quantity, Size, Torque

STROKE_MARGIN = np.radians(2)  # between a joint's limit and the end of the cylinder's stroke


# Of a linkage and an angle, for loops: nothing is checked but that the angle is in the stroke.
displacements_at = Linkage.displacements.unchecked
volumes_at = Linkage.volumes.unchecked


def sides_at(axis, angle):
    """Return (D, rho, load) of positive and of negative motion at a joint angle, in rad.

    Nothing is checked, as in the functions below: simulations call them many times a tick.
    """
    plus, minus = displacements_at(axis.linkage, angle)
    load = load_at(axis, angle)
    return (plus, minus / plus, load), (minus, plus / minus, -load)


def load_at(axis, angle):
    """Return the torque that resists positive motion of an `axis`, in N m, at an angle, in rad."""
    return -axis.gravity * (math.cos(angle) if isinstance(angle, float) else np.cos(angle))


def speed(axis, opened, D, rho, load):
    """Return the speed, in rad/s, at which lands and friction use up the pressure.

    `opened` is the share of the `axis`' open valve, from 0 to 1; D, rho and load are one of its
    `sides_at`.
    """
    slope = axis.flow * opened / D / (1 + rho**3) ** 0.5
    drag = slope * axis.damping / D
    drive = _drive(axis, D, rho, load)
    # The root of w^2 + slope drag w = slope^2 drive, without the difference of its usual form.
    return 2 * slope * drive / (drag + (drag**2 + 4 * drive) ** 0.5)


def spool_at(axis, rate, position):
    """Return the spool position of a steady `rate`, in rad/s: see `Hydraulics.command`.

    The `position` of the `axis` is measured: an encoder may round it beyond the stroke.
    """
    if rate == 0:
        return 0.0
    D, rho, load = sides_at(axis, position)[0 if rate > 0 else 1]
    left = _drive(axis, D, rho, load) - axis.damping * abs(rate) / D
    opened = abs(rate) * D / axis.flow * ((1 + rho**3) / left) ** 0.5 if left > 0 else math.inf
    return math.copysign(opened, rate)


def _drive(axis, D, rho, load):
    """Return the pressure that is left for lands and friction, in Pa."""
    return axis.supply - rho * axis.tank - load / D


@dataclass(frozen=True)
@checked
class Hydraulics:
    """The sizes of one axis: servo-valve, linkage, load.

    Parameters
    ----------
    linkage : Linkage
        The cylinders and how they turn the joint.
    low, high : float
        Joint angles at the ends of the stroke, in rad.
    inertia : float
        Of the arm about the joint, in kg m^2.
    gravity : float
        Greatest torque of the weight, towards positive angles where the arm is level, in N m.
    damping : float
        Viscous friction of the joint, in N m s/rad.
    supply, tank : float
        Pressures, in Pa.
    bulk : float
        Bulk modulus of the oil with its hoses, in Pa.
    hose : float
        Oil volume between valve and piston on either side, in m^3.
    flow : float
        Flow of the open valve over the root of the pressure lost at one land, in m^3/s/Pa^0.5.
    valve_lag : float
        Time constant of the spool, in s.

    Raises
    ------
    ValueError
        If a number is out of its range, the stroke can't be had, or the supply can't hold the
        weight everywhere.
    """

    linkage: Linkage
    low: Angle
    high: Angle
    inertia: Size
    gravity: Torque
    damping: Size
    supply: Size
    tank: Size
    bulk: Size
    hose: Size
    flow: Size
    valve_lag: Size

    def __post_init__(self):
        if self.tank >= self.supply:
            raise ValueError(
                f"tank: must be below the supply {self.supply:g} Pa; got {self.tank:g} Pa."
            )
        self.linkage.check(self.low, self.high)
        angle = np.linspace(self.low, self.high, 181)
        # A side without area, of a rod as thick as its bore, drives nothing: NaN or -inf.
        with np.errstate(all="ignore"):
            drives = [_drive(self, *side) for side in sides_at(self, angle)]
        if not np.min(drives) > 0:
            raise ValueError(
                f"supply: must move the weight both ways at every angle; got {self.supply:g} Pa."
            )

    @checked
    def load(self, angle: JointAngles):
        """Return the torque that resists positive motion, in N m, at joint angles in rad."""
        return load_at(self, angle)

    @checked
    def rate(self, angle: Angles, spool: Reals):
        """Return the steady rates, in rad/s, at joint angles and spool positions from -1 to 1.

        theta' = (c x / D_A) sqrt((ps - rho pT - load / D_A) / (1 + rho^3)), rho = D_B / D_A, with
        D_A, D_B the displacements of the filled and of the emptied side: with unequal areas both
        lands share the pressure. The other direction is the mirror image.

        Raises
        ------
        ValueError
            If an `angle` is outside the stroke, or a `spool` beyond its ends.
        """
        check_stroke(angle, self.low, self.high)
        if np.any(np.abs(spool) > 1):
            raise ValueError(f"spool: must be from -1 to 1; got {np.abs(spool).max():g} in size.")
        positive, negative = sides_at(self, angle)
        forward = speed(self, np.abs(spool), *positive)
        backward = speed(self, np.abs(spool), *negative)
        return np.where(spool > 0, forward, -backward)

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position that gives a steady rate, in rad/s, at a joint angle, in rad.

        The static inverse of valve and linkage, for one axis at a time. It is infinite for a rate
        that no opening of the valve could give; `Loop.limit` then opens it fully. The `position`
        must be within the stroke.
        """
        check_stroke(position, self.low, self.high, "position")
        return spool_at(self, rate, position)

    @checked
    def natural_frequency(self, angle: JointAngles):
        """Return the frequency of arm and oil with the valve shut, in rad/s, at joint angles.

        They are in rad and within the stroke, else ValueError is raised.
        """
        plus, minus, first, second = self._oil(angle)
        springs = plus**2 / first + minus**2 / second
        return (self.bulk * springs / self.inertia) ** 0.5

    @checked
    def resonance(self, angle: Angle):
        """Return the linear plant of small motions about a joint angle, in rad."""
        w = Hydraulics.natural_frequency.unchecked(self, angle)
        rates = Hydraulics.rate.unchecked(self, np.asarray(angle), np.array([1.0, -1.0]))
        gain = float(min(np.abs(rates)))
        return Resonance(gain, w, self.damping / (2 * self.inertia * w))

    @checked
    def swing(self, angle: JointAngles):
        """Return the gain of small swings about rest over that of steady motion, at joint angles.

        (D_A / V_A + D_B / V_B) sqrt(D_A^2 - D_A D_B + D_B^2) / (D_A^2 / V_A + D_B^2 / V_B): swings
        keep the pressures at which both lands lose the same, steady motion brings its own. It is 1
        for equal areas, whatever the weight. Angles are in rad and within the stroke, else
        ValueError is raised.
        """
        plus, minus, first, second = self._oil(angle)
        mean = (plus**2 - plus * minus + minus**2) ** 0.5
        return mean * (plus / first + minus / second) / (plus**2 / first + minus**2 / second)

    def _oil(self, angle):
        """Return displacements, in m^3/rad, and volumes with the hoses, in m^3, of both sides."""
        volumes = volumes_at(self.linkage, angle, self.low, self.high)
        displacements = displacements_at(self.linkage, angle)
        return *displacements, *(volume + self.hose for volume in volumes)

    @checked
    def sides(self, angle: JointAngles):
        """Return (D, rho, load) of positive and of negative motion at joint angles, in rad.

        D, in m^3/rad, is what the filled side takes, rho what the emptied side gives over that,
        load the torque that resists, in N m. Outside the stroke ValueError is raised.
        """
        check_stroke(angle, self.low, self.high)
        return sides_at(self, angle)


@checked
def reference_axes(machine: Machine, *, damping: Quantity = 0.15):
    """Return the study's axes theta and phi of a machine.

    Parameters
    ----------
    machine : Machine
        Its joint limits, and the radii r and R that set linkages and inertia.
    damping : float
        Damping ratio of the resonance at joint angle 0, or where the stroke comes nearest to it.

    Returns
    -------
    theta, phi : Hydraulics
        A cutter head of 30 kg at the end of an arm of 60 kg that is evenly spread from its joint;
        supply 160 bar, tank 3 bar, oil of 1.0 GPa, hoses of 50 cm^3, valves of 4 L/min at 35 bar
        a land with a lag of 4 ms. The weight loads theta alone.
    """
    head = 30.0  # kg
    arm = 60.0  # kg
    g = 9.81  # m/s^2
    reach = machine.r + machine.R
    lift, swing = linkages(machine)
    return (
        _reference_axis(
            lift,
            machine.theta_min,
            machine.theta_max,
            inertia=(head + arm / 3) * reach**2,
            gravity=(head + arm / 2) * g * reach,
            ratio=damping,
        ),
        _reference_axis(
            swing,
            machine.phi_min,
            machine.phi_max,
            inertia=(head + arm / 3) * machine.R**2,
            gravity=0.0,
            ratio=damping,
        ),
    )


def _reference_axis(linkage, least, greatest, *, inertia, gravity, ratio):
    """Return one of `reference_axes`, between joint limits, with a damping ratio near angle 0."""
    axis = Hydraulics(
        linkage=linkage,
        low=least - STROKE_MARGIN,
        high=greatest + STROKE_MARGIN,
        inertia=inertia,
        gravity=gravity,
        damping=1e-9,  # not yet known: it follows from the frequency, which doesn't depend on it
        supply=160e5,
        tank=3e5,
        bulk=1.0e9,
        hose=5e-5,
        flow=4e-3 / 60 / 35e5**0.5,
        valve_lag=4e-3,
    )
    middle = min(max(0.0, axis.low), axis.high)
    return replace(axis, damping=2 * ratio * axis.natural_frequency(middle) * inertia)
