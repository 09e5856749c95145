"""Hydraulic axes: sizes, steady motion and its inverse, natural frequency.

All sizes are the study's assumptions: the paper names the parts and gives no sizes.
"""

import math
from collections import namedtuple
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ..arguments import Angle, Angles, Finite, Reals, checked
from ..kernels.compiled import cosine, root
from ..surfaces.linkage import JointAngles, Linkage, chambers, check_stroke
from .plant import Resonance
from .quantities import Quantity, Size, Size0, Torque

STROKE_MARGIN = np.radians(2)  # between a joint's limit and the end of the cylinder's stroke


def sides_at(axis, angle):
    """Return (D, rho, load) of positive and of negative motion; see `Hydraulics.sides`."""
    plus, minus, _, _ = chambers(axis.cylinders, angle)
    load = load_at(axis, angle)
    return (plus, minus / plus, load), (minus, plus / minus, -load)


def load_at(axis, angle):
    """Return the torque by which the weight resists positive motion at an angle in rad, in N m."""
    return -axis.gravity * cosine(angle)


def speed(axis, opened, D, rho, load):
    """Return the steady speed at which lands and friction use up the pressure, in rad/s.

    The valve of the `axis` is open by the share `opened`, from 0 to 1; D, rho and load are one of
    its `sides_at`.
    """
    slope = axis.flow * opened / D / root(1 + rho * rho * rho)
    drag = slope * axis.damping / D
    drive = drive_of(axis, D, rho, load)
    # The positive root w of w^2 + slope drag w = slope^2 drive. Its usual form would subtract two
    # nearly equal numbers where friction takes most of the pressure.
    return 2 * slope * drive / (drag + root(drag * drag + 4 * drive))


def spool_at(axis, rate, position):
    """Return the spool position of a steady `rate` of an `axis`, in rad/s; see `command`.

    The `position` may lie a little outside the stroke, to which an encoder may round it.
    """
    if rate == 0:
        return 0.0
    forward, backward = sides_at(axis, position)
    D, rho, load = forward if rate > 0 else backward
    left = drive_of(axis, D, rho, load) - axis.damping * abs(rate) / D
    if left <= 0:  # no opening suffices, and the loop takes the widest
        return math.copysign(math.inf, rate)
    # Drops go with the flows' squares: rho^2 at the emptied side, which acts on rho of the area.
    return rate * D / axis.flow * root((1 + rho * rho * rho) / left)


def drive_of(axis, D, rho, load):
    """Return the pressure of an `axis` that D, rho and load leave for lands and friction, in Pa."""
    return axis.supply - rho * axis.tank - load / D


@dataclass(frozen=True)
@checked
class Hydraulics:
    """The sizes of one axis: servo-valve, cylinders with their linkage, and load.

    Parameters
    ----------
    linkage : Linkage
        The cylinders and the levers by which they turn the joint.
    low, high : float
        Joint angles at the ends of the stroke, in rad.
    inertia : float
        Moment of inertia about the joint, in kg m^2.
    gravity : float
        Torque of the weight towards positive angles at angle 0, where the arm is level, in N m.
    damping : float
        Viscous friction of the joint, in N m s/rad.
    supply, tank : float
        Pressures, in Pa.
    bulk : float
        Bulk modulus of the oil with its hoses, in Pa.
    hose : float
        Volume of oil between valve and piston on each side, in m^3.
    flow : float
        Flow through the open valve divided by the root of the pressure drop at a land, in
        m^3/s/Pa^0.5.
    valve_lag : float
        Time constant of the spool, in s.
    friction : float
        Dry friction of joint and seals, in N m.
    piston_leak : float
        Flow past the piston per pressure across it, in m^3/s/Pa.
    valve_leak : float
        The same for each land, closed or open; each side has two, from the supply and to the tank.

    Raises
    ------
    ValueError
        If a number is out of its range, the linkage doesn't allow the stroke, or the supply can't
        move the weight everywhere.
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
        # A rod as thick as its bore leaves a side without area: NaN or -inf, which fails as well.
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
        """Return the torque by which the weight resists positive motion at joint angles, in N m."""
        return load_at(self, angle)

    @checked
    def rate(self, angle: Angles, spool: Reals):
        """Return the steady rates at joint angles and spool positions from -1 to 1, in rad/s.

        Without friction theta' = (c x / D_A) sqrt((ps - rho pT - load / D_A) / (1 + rho^3)), where
        D_A and D_B are the displacements of the filled and of the emptied side, rho = D_B / D_A,
        c is the `flow` and x the spool position. The other direction is the mirror image.

        Raises
        ------
        ValueError
            If an `angle` is outside the stroke, or a `spool` beyond its ends.

        Examples
        --------
        >>> from tunneller_lib.motion.sizing import axes_of, usual_sizes
        >>> from tunneller_lib.surfaces import REFERENCE_MACHINE as reference
        >>> theta, _ = axes_of(reference, usual_sizes(reference))
        >>> theta.rate(0.0, -1.5)
        Traceback (most recent call last):
        ValueError: spool: must be from -1 to 1; got 1.5 in size.
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
        """Return the factor by which a loaded joint may turn faster at a given valve opening.

        Parameters
        ----------
        angle : (...) float
            Joint angles, in rad, within the stroke.
        rate : (...) float
            Rates of the joint, in rad/s, at the factor 1.
        torque : (...) float
            Torques besides weight and friction that resist positive motion at the factor 1, in
            N m. They grow with the factor, as a cutting force does with the feed.
        opened : float
            Opening of the valve, at most 1.

        Returns
        -------
        factor : (...) float
            The greatest factor at which the pressure suffices for lands, friction and torque, and
            no side needs more than the supply; infinite where nothing limits it.

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
            # The factor x solves lands x^2 + pull x = drive; the root is written without the
            # cancellation of its usual form. For a joint that stands or goes the other way lands
            # is 0, but the oil still has to hold the torque.
            lands = (forward * D / (self.flow * opened)) ** 2 * (1 + rho**3)
            pull = (self.damping * forward + sign * torque) / D
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                most = 2 * drive / (pull + np.sqrt(pull**2 + 4 * drive * lands))
            factor = np.minimum(factor, np.where((lands > 0) | (pull > 0), most, np.inf))
        return factor

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position that gives a steady rate in rad/s at a joint angle in rad.

        This is the static inverse of valve and linkage. It is infinite if no opening of the valve
        gives the rate. The `position` must lie within the stroke.
        """
        check_stroke(position, self.low, self.high, "position")
        return spool_at(self.numbers, rate, position)

    @checked
    def natural_frequency(self, angle: JointAngles):
        """Return the natural frequency of arm and oil with the valve shut, in rad/s.

        Joint angles outside the stroke raise ValueError.
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
        """Return the gain of small swings about rest over that of steady motion at joint angles.

        It is (D_A / V_A + D_B / V_B) sqrt(D_A^2 - D_A D_B + D_B^2) / (D_A^2 / V_A + D_B^2 / V_B),
        since in swings both lands keep losing the same pressure, while steady motion shifts the
        pressures. It is 1 for equal areas. Angles outside the stroke raise ValueError.
        """
        plus, minus, first, second = self._oil(angle)
        mean = (plus**2 - plus * minus + minus**2) ** 0.5
        return mean * (plus / first + minus / second) / (plus**2 / first + minus**2 / second)

    def _oil(self, angle):
        """Return both sides' displacements in m^3/rad and volumes with hoses in m^3."""
        check_stroke(angle, self.low, self.high)
        plus, minus, first, second = chambers(self.numbers.cylinders, angle)
        return plus, minus, first + self.hose, second + self.hose

    @checked
    def sides(self, angle: JointAngles):
        """Return (D, rho, load) of positive and of negative motion at joint angles in rad.

        D is the displacement of the filled side in m^3/rad, rho that of the emptied side divided
        by D, and load the resisting torque of the weight in N m. Angles outside the stroke raise
        ValueError.
        """
        check_stroke(angle, self.low, self.high)
        return sides_at(self.numbers, angle)


# A `Hydraulics` as plain numbers, for functions that a simulation calls many times a tick. These
# check nothing, and take angles and rates as floats or arrays.
Axis = namedtuple("Axis", ["cylinders", *(field.name for field in fields(Hydraulics)[1:])])
