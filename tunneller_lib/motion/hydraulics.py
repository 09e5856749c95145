"""Hydraulic axes: sizes, steady motion and its inverse, natural frequency.

All sizes are the study's assumptions; the document names the parts and gives none.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from ..arguments import finite, instance, positive, real
from ..surfaces import Linkage, Machine, linkages
from .plant import Resonance

STROKE_MARGIN = np.radians(2)  # between a joint's limit and the end of the cylinder's stroke


@dataclass(frozen=True)
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

    def __post_init__(self):
        instance("linkage", self.linkage, Linkage)
        for field in fields(self)[1:]:
            check = finite if field.name in ("low", "high", "gravity") else positive
            object.__setattr__(self, field.name, check(field.name, getattr(self, field.name)))
        if self.tank >= self.supply:
            raise ValueError(f"tank: must be below the supply {self.supply:g} Pa; "
                             f"got {self.tank:g} Pa.")  # fmt: skip
        self.linkage.check(self.low, self.high)
        angle = np.linspace(self.low, self.high, 181)
        drives = [self._drive(*side) for side in self.sides(angle)]
        if np.min(drives) <= 0:
            raise ValueError("supply: must move the weight both ways at every angle; "
                             f"got {self.supply:g} Pa.")  # fmt: skip

    def load(self, angle):
        """Return the torque that resists positive motion, in N m, at joint angles in rad."""
        return -self.gravity * (math.cos(angle) if isinstance(angle, float) else np.cos(angle))

    def rate(self, angle, spool):
        """Return the steady rates, in rad/s, at joint angles and spool positions from -1 to 1.

        theta' = (c x / D_A) sqrt((ps - rho pT - load / D_A) / (1 + rho^3)), rho = D_B / D_A, with
        D_A, D_B the displacements of the filled and of the emptied side: with unequal areas both
        lands share the pressure. The other direction is the mirror image.
        """
        angle, spool = real("angle", angle), real("spool", spool)
        forward, backward = (self.speed(np.abs(spool), *side) for side in self.sides(angle))
        return np.where(spool > 0, forward, -backward)

    def command(self, rate, position):
        """Return the spool position that gives a steady rate, in rad/s, at a joint angle, in rad.

        The static inverse of valve and linkage, for one axis at a time. It is infinite for a rate
        that no opening of the valve could give; `Loop.limit` then opens it fully.
        """
        if rate == 0:
            return 0.0
        D, rho, load = self.sides(float(position))[0 if rate > 0 else 1]
        left = self._drive(D, rho, load) - self.damping * abs(rate) / D
        opening = abs(rate) * D / self.flow * ((1 + rho**3) / left) ** 0.5 if left > 0 else math.inf
        return math.copysign(opening, rate)

    def natural_frequency(self, angle):
        """Return the frequency of arm and oil with the valve shut, in rad/s, at joint angles."""
        plus, minus = self.linkage.displacements(angle)
        first, second = self.linkage.volumes(angle, self.low, self.high)
        springs = plus**2 / (first + self.hose) + minus**2 / (second + self.hose)
        return (self.bulk * springs / self.inertia) ** 0.5

    def resonance(self, angle):
        """Return the linear plant of small motions about a joint angle, in rad."""
        w = self.natural_frequency(finite("angle", angle))
        gain = float(min(np.abs(self.rate(angle, [1, -1]))))
        return Resonance(gain, w, self.damping / (2 * self.inertia * w))

    def swing(self, angle):
        """Return the gain of small swings about rest over that of steady motion, at joint angles.

        (D_A / V_A + D_B / V_B) sqrt(D_A^2 - D_A D_B + D_B^2) / (D_A^2 / V_A + D_B^2 / V_B): swings
        keep the pressures at which both lands lose the same, steady motion brings its own. It is 1
        for equal areas, whatever the weight.
        """
        plus, minus = self.linkage.displacements(angle)
        first, second = (v + self.hose for v in self.linkage.volumes(angle, self.low, self.high))
        mean = (plus**2 - plus * minus + minus**2) ** 0.5
        return mean * (plus / first + minus / second) / (plus**2 / first + minus**2 / second)

    def sides(self, angle):
        """Return (D, rho, load) of positive and of negative motion at a joint angle, in rad."""
        plus, minus = self.linkage.displacements(angle)
        load = self.load(angle)
        return (plus, minus / plus, load), (minus, plus / minus, -load)

    def _drive(self, D, rho, load):
        return self.supply - rho * self.tank - load / D

    def speed(self, opening, D, rho, load):
        """Return the speed, in rad/s, at which lands and friction use up the pressure.

        `opening` is the spool's, from 0 to 1; D, rho and load are one of `sides`.
        """
        slope = self.flow * opening / D / (1 + rho**3) ** 0.5
        drag = slope * self.damping / D
        drive = self._drive(D, rho, load)
        # The root of w^2 + slope drag w = slope^2 drive, without the difference of its usual form.
        return 2 * slope * drive / (drag + (drag**2 + 4 * drive) ** 0.5)


def reference_axes(machine, *, damping=0.15):
    """Return the study's axes theta and phi of a machine.

    Parameters
    ----------
    machine : Machine
        Its joint limits, and the radii r and R that set linkages and inertia.
    damping : float
        Damping ratio of the resonance at joint angle 0.

    Returns
    -------
    theta, phi : Hydraulics
        A cutter head of 30 kg at the end of an arm of 60 kg that is evenly spread from its joint;
        supply 160 bar, tank 3 bar, oil of 1.0 GPa, hoses of 50 cm^3, valves of 4 L/min at 35 bar
        a land with a lag of 4 ms. The weight loads theta alone.
    """
    head, arm, g = 30.0, 60.0, 9.81
    reach = instance("machine", machine, Machine).r + machine.R
    ranges = (machine.theta_min, machine.theta_max), (machine.phi_min, machine.phi_max)
    loads = ((head + arm / 3) * reach**2, (head + arm / 2) * g * reach), (
        (head + arm / 3) * machine.R**2, 0.0)  # fmt: skip
    axes = []
    for linkage, (low, high), (inertia, gravity) in zip(
        linkages(machine), ranges, loads, strict=True
    ):
        sizes = dict(linkage=linkage, low=low - STROKE_MARGIN, high=high + STROKE_MARGIN,
                     inertia=inertia, gravity=gravity, supply=160e5, tank=3e5, bulk=1.0e9,
                     hose=5e-5, flow=4e-3 / 60 / 35e5**0.5, valve_lag=4e-3)  # fmt: skip
        undamped = Hydraulics(damping=1e-9, **sizes).natural_frequency(0.0)
        friction = 2 * positive("damping", damping) * undamped * inertia
        axes.append(Hydraulics(damping=friction, **sizes))
    return tuple(axes)
