"""Hydraulic axes: sizes, steady motion and its inverse, natural frequency.

All sizes are the study's assumptions; the document names the parts and gives none.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Angles, Finite, Reals, checked
from ..kernels.compiled import cosine, root
from ..surfaces.linkage import Cylinders, JointAngles, Linkage, chambers, check_stroke
from .plant import Resonance
from .quantities import Quantity, Size, Size0, Torque

STROKE_MARGIN = np.radians(2)  # between a joint's limit and the end of the cylinder's stroke


class Axis(NamedTuple):
    """A `Hydraulics` as plain numbers, for functions that simulations call many times a tick.

    Nothing is checked by those, and angles and rates are floats or arrays.
    """

    cylinders: Cylinders
    low: float
    high: float
    inertia: float
    gravity: float
    damping: float
    supply: float
    tank: float
    bulk: float
    hose: float
    flow: float
    valve_lag: float
    friction: float
    piston_leak: float
    valve_leak: float


def sides_at(axis, angle):
    """Return (D, rho, load) of positive and of negative motion of an `Axis` at an angle, in rad."""
    plus, minus, _, _ = chambers(axis.cylinders, angle)
    load = load_at(axis, angle)
    return (plus, minus / plus, load), (minus, plus / minus, -load)


def load_at(axis, angle):
    """Return the torque that resists positive motion of an `axis`, in N m, at an angle, in rad."""
    return -axis.gravity * cosine(angle)


def speed(axis, opened, D, rho, load):
    """Return the speed, in rad/s, at which lands and friction use up the pressure.

    `opened` is the share of the `axis`' open valve, from 0 to 1; D, rho and load are one of its
    `sides_at`.
    """
    slope = axis.flow * opened / D / root(1 + rho * rho * rho)
    drag = slope * axis.damping / D
    drive = drive_of(axis, D, rho, load)
    # The root of w^2 + slope drag w = slope^2 drive, without the difference of its usual form.
    return 2 * slope * drive / (drag + root(drag * drag + 4 * drive))


def spool_at(axis, rate, position):
    """Return the spool position of a steady `rate`, in rad/s: see `Hydraulics.command`.

    The `position` of the `axis` is measured: an encoder may round it beyond the stroke.
    """
    if rate == 0:
        return 0.0
    forward, backward = sides_at(axis, position)
    D, rho, load = forward if rate > 0 else backward
    left = drive_of(axis, D, rho, load) - axis.damping * abs(rate) / D
    if left <= 0:
        return math.copysign(math.inf, rate)
    return rate * D / axis.flow * root((1 + rho * rho * rho) / left)


def drive_of(axis, D, rho, load):
    """Return the pressure that is left for lands and friction of an `axis`, in Pa.

    D, rho and load are one of its `sides_at`.
    """
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
    friction : float
        Dry friction of joint and seals, in N m.
    piston_leak : float
        Past the piston, in m^3/s/Pa.
    valve_leak : float
        Past each closed land, in m^3/s/Pa: two lands a side, from the supply and to the tank.

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
    friction: Size0 = 0.0
    piston_leak: Size0 = 0.0
    valve_leak: Size0 = 0.0

    def __post_init__(self):
        if self.tank >= self.supply:
            raise ValueError(
                f"tank: must be below the supply {self.supply:g} Pa; got {self.tank:g} Pa."
            )
        self.linkage.check(self.low, self.high)
        angle = np.linspace(self.low, self.high, 181)
        # A side without area, of a rod as thick as its bore, drives nothing: NaN or -inf.
        with np.errstate(all="ignore"):
            drives = [drive_of(self, *side) for side in sides_at(self.numbers, angle)]
        if not np.min(drives) > 0:
            raise ValueError(
                f"supply: must move the weight both ways at every angle; got {self.supply:g} Pa."
            )

    @cached_property
    def numbers(self):
        """Return the sizes as an `Axis`."""
        own = {name: getattr(self, name) for name in Axis._fields[1:]}
        return Axis(self.linkage.cylinders(self.low, self.high), **own)

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
        positive, negative = sides_at(self.numbers, angle)
        forward = speed(self, np.abs(spool), *positive)
        backward = speed(self, np.abs(spool), *negative)
        return np.where(spool > 0, forward, -backward)

    @checked
    def loaded(self, angle: Angles, rate: Reals, torque: Reals, opened: Quantity):
        """Return how fast a loaded joint may go with an open valve, as a factor of its rate.

        Parameters
        ----------
        angle : (...) float
            Joint angles, in rad, within the stroke.
        rate : (...) float
            Rates of the joint, in rad/s, at the factor 1.
        torque : (...) float
            Torques, beside weight and friction, that resist positive motion at the factor 1, in
            N m. They grow with the factor, as a cutting force does with the feed.
        opened : float
            Share of the open valve, at most 1.

        Returns
        -------
        factor : (...) float
            The greatest at which lands, friction and torque use up the pressure, and at which
            neither side alone must hold more than the supply: infinite where nothing limits it.

        Raises
        ------
        ValueError
            If an `angle` is outside the stroke, or `opened` above 1.
        """
        check_stroke(angle, self.low, self.high)
        if opened > 1:
            raise ValueError(f"opened: must be at most 1; got {opened:g}.")
        factor = np.inf
        for sign, (D, rho, load) in zip((1, -1), sides_at(self.numbers, angle), strict=True):
            drive = drive_of(self, D, rho, load)
            forward = np.maximum(sign * rate, 0.0)
            # (forward D x / flow)^2 (1 + rho^3) + pull x = drive of the factor x; where the joint
            # goes the other way, or stands, the oil still has to hold the torque.
            lands = (forward * D / (self.flow * opened)) ** 2 * (1 + rho**3)
            pull = (self.damping * forward + sign * torque) / D
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                most = 2 * drive / (pull + np.sqrt(pull**2 + 4 * drive * lands))
            factor = np.minimum(factor, np.where((lands > 0) | (pull > 0), most, np.inf))
        return factor

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position that gives a steady rate, in rad/s, at a joint angle, in rad.

        The static inverse of valve and linkage, for one axis at a time. It is infinite for a rate
        that no opening of the valve could give; `Loop.limit` then opens it fully. The `position`
        must be within the stroke.
        """
        check_stroke(position, self.low, self.high, "position")
        return spool_at(self.numbers, rate, position)

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
        w = self.natural_frequency(angle)
        rates = self.rate(angle, [1.0, -1.0])
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
        check_stroke(angle, self.low, self.high)
        plus, minus, first, second = chambers(self.numbers.cylinders, angle)
        return plus, minus, first + self.hose, second + self.hose

    @checked
    def sides(self, angle: JointAngles):
        """Return (D, rho, load) of positive and of negative motion at joint angles, in rad.

        D, in m^3/rad, is what the filled side takes, rho what the emptied side gives over that,
        load the torque that resists, in N m. Outside the stroke ValueError is raised.
        """
        check_stroke(angle, self.low, self.high)
        return sides_at(self.numbers, angle)
