"""The arm and the cutter head: inertia, weight, and how both joints act on each other.

The head is a point at the cutter's centre, the arm a uniform rod from the tangential joint to it.
For the head rho = r + R cos(phi), and likewise for each piece of the arm. Kinetic and potential
energy are

    2 T = sum m rho^2 theta'^2 + sum m R^2 phi'^2,    V = -g sin(theta) sum m rho,

which has no product theta' phi': theta's inertia depends on phi, phi's is constant.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Angles, Length, Length0, Positions, Rates, checked
from ..kernels.compiled import cosine, sine
from .quantities import Size, Size0

GRAVITY = 9.81  # m/s^2


class Moments(NamedTuple):
    """An `Arm` as plain numbers: the sums of m, m s and m s^2 over its masses m.

    s is the distance of a mass from the tangential joint. The functions below take angles and
    rates as floats or as arrays.
    """

    r: float  # m
    mass: float  # kg
    first: float  # kg m
    second: float  # kg m^2


def lift_inertia(moments, phi):
    """Return theta's inertia sum m (r + s cos phi)^2, in kg m^2, at an angle phi, in rad."""
    c = cosine(phi)
    return moments.mass * moments.r * moments.r + c * (
        2 * moments.r * moments.first + moments.second * c
    )


def weights(moments, theta, phi):
    """Return the torques dV/dtheta and dV/dphi by which the weight resists the joints, in N m."""
    reach = moments.mass * moments.r + moments.first * cosine(phi)
    lift = -GRAVITY * cosine(theta) * reach
    return lift, GRAVITY * sine(theta) * moments.first * sine(phi)


def couplings(moments, phi, theta_rate, phi_rate):
    """Return the torques by which the joints' motions resist theta and phi, in N m.

    The Coriolis torque (dI/dphi) theta' phi' acts on theta, the centrifugal torque
    -(dI/dphi) theta'^2 / 2 on phi, where I is theta's inertia by an arm's `moments`. `phi` is in
    rad, the rates theta' = `theta_rate` and phi' = `phi_rate` are in rad/s.
    """
    # Half of dI/dphi, with dI/dphi = -2 sin(phi) sum m s (r + s cos(phi)).
    half = -sine(phi) * (moments.r * moments.first + moments.second * cosine(phi))
    return 2 * half * theta_rate * phi_rate, -half * theta_rate * theta_rate


@dataclass(frozen=True)
@checked
class Arm:
    """The masses that both joints carry: a cutter head and a uniform arm.

    Parameters
    ----------
    r, R : float
        Distances from the horizontal to the tangential joint, and from there to the cutter's
        centre, in m.
    head : float
        Mass of the cutter head with its drive, in kg, at the cutter's centre.
    beam : float
        Mass of the arm, in kg, spread evenly between the tangential joint and the head.

    Raises
    ------
    ValueError
        If a length or the head's mass isn't above zero, or the arm's mass is below zero.

    Notes
    -----
    The theta axis is horizontal, and theta grows downwards. A test derives the equations of motion
    with sympy's mechanics, too.

    Examples
    --------
    >>> arm = Arm(0.08, 0.80, head=30.0, beam=60.0)
    >>> [round(float(one), 1) for one in arm.inertias(0.0)]
    [40.3, 32.0]
    """

    r: Length0
    R: Length
    head: Size
    beam: Size0

    @property
    def moments(self):
        """Return the masses as `Moments`."""
        return Moments(
            self.r,
            self.head + self.beam,
            self.R * (self.head + self.beam / 2),
            self.R**2 * (self.head + self.beam / 3),
        )

    @checked
    def inertias(self, phi: Angles):
        """Return theta's and phi's inertias (...) at angles phi in rad, in kg m^2."""
        about_theta = lift_inertia(self.moments, phi)
        return about_theta, self.moments.second + np.zeros_like(about_theta)

    @checked
    def weight(self, position: Positions):
        """Return the torques (..., 2) by which the weight resists positive motion, in N m.

        Joint positions (..., 2) are in rad.
        """
        return np.stack(weights(self.moments, position[..., 0], position[..., 1]), axis=-1)

    @checked
    def energy(self, position: Positions, rate: Rates):
        """Return kinetic and potential energy (...) at positions in rad, rates in rad/s, in J."""
        about_theta, about_phi = self.inertias(position[..., 1])
        kinetic = (about_theta * rate[..., 0] ** 2 + about_phi * rate[..., 1] ** 2) / 2
        reach = self.moments.mass * self.r + self.moments.first * np.cos(position[..., 1])
        return kinetic, -GRAVITY * np.sin(position[..., 0]) * reach
