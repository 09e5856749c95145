"""The force and the power that cutting takes, from the ground that is removed.

Cutting takes a specific energy E, the work for each cubic metre. A cutter at the speed v removes A
cubic metres for each metre of its way, so that its power is E A v. The picks, which go round the
head at the speed u, bring that power by a force E A v / u. It is taken to act against the motion,
and grows with the feed, as a damper's force does.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import LEAST, MOST, NotNegative, Number, Reals, Size, checked

PickSpeed = Number(LEAST, MOST, "m/s")


@dataclass(frozen=True)
@checked
class Ground:
    """Ground and picks; all numbers are assumptions.

    Parameters
    ----------
    energy : float
        Specific energy of cutting, in J/m^3.
    pick_speed : float
        Of the picks round the head, in m/s.
    normal : float
        Ratio of the force out of the wall to the force against the feed.
    ripple : float
        Amplitude of both forces over their mean, below 1: the picks enter one after the other.
    ripple_frequency : float
        Its frequency, in Hz.

    Raises
    ------
    ValueError
        If the energy or the picks' speed isn't above zero, another number is below zero, or the
        ripple isn't below 1.

    Examples
    --------
    >>> concrete = Ground(energy=20e6, pick_speed=2.0, normal=0.5)
    >>> [round(float(one)) for one in (concrete.power(1.5e-4), concrete.force(1.5e-4))]
    [3000, 1500]
    """

    energy: Size
    pick_speed: PickSpeed
    normal: NotNegative = 0.0
    ripple: Number(0.0, also=("be from 0 to below 1", lambda share: share < 1)) = 0.0
    ripple_frequency: NotNegative = 0.0

    @checked
    def power(self, rate: Reals):
        """Return the power of the head (...), in W, for ground removed at a rate in m^3/s."""
        return self.energy * rate

    @checked
    def force(self, rate: Reals):
        """Return the force against the feed (...), in N, for ground removed at a rate in m^3/s."""
        return self.energy * rate / self.pick_speed

    @checked
    def pulse(self, time: Reals):
        """Return the ratio of the force to its mean (...) at times in s."""
        return 1 + self.ripple * np.sin(2 * np.pi * self.ripple_frequency * time)
