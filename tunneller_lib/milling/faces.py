"""Surfaces to be milled: a ring of blades, and a patch with a side.

The ring stands for the industrial impeller of the document (Example 33, Fig. 11), which isn't
public.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angle, Array, Coordinate, Length, NotNegative, Reals, Sign, Whole, checked
from ..envelopes.cone_pose import ConePose
from ..envelopes.functions import Function, Varying
from ..envelopes.jet import Jet

SLENDER = 1e6  # times a hub's radius: no size of a blade is above it
Range = Array("(2,) float", also=("ascend", lambda ends: ends[0] < ends[1]))


@dataclass(frozen=True)
@checked
class BladeRing:
    """Equal thin blades about the z axis, hyperbolic at the proportions of the study.

    Parameters
    ----------
    hub, height, chord : float
        Radius at a blade's foot, its height outwards and its length along the ring, in m.
    stagger, twist : float
        Angle between blade and axis at the foot, and how much it grows to the tip, in rad.
    camber, bow : float
        Rise of the blade's arc at the foot's middle and lag of its tip, in m.
    blades : int
        How many, from 2 to 1000.

    Raises
    ------
    ValueError
        If a length isn't above zero, a number not finite, a size above a million times the hub's
        radius, or there are fewer than 2 blades.

    Examples
    --------
    >>> ring = BladeRing(0.06, 0.03, 0.05, 0.0, 0.5, 0.0, 0.0, 6)
    >>> ring.mesh(3).shape
    (3, 3, 3)
    >>> BladeRing(0.06, 0.03, 0.0, 0.0, 0.5, 0.0, 0.0, 6)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: chord: must be ...
    """

    hub: Length
    height: Length
    chord: Length
    stagger: Angle
    twist: Angle
    camber: Coordinate
    bow: Coordinate
    blades: Whole(2, 1000)

    def __post_init__(self):
        for name in ("height", "chord", "camber", "bow"):
            size = abs(getattr(self, name))
            if size > SLENDER * self.hub:
                raise ValueError(
                    f"{name}: must be at most {SLENDER:g} times the hub's radius {self.hub:g} m; "
                    f"got {size:g} m."
                )

    @checked
    def coordinates(self, s: Varying, t: Varying):
        """Return the coordinates of points of the first blade.

        A surface for `hyperosculating_cones` with model="space".

        Parameters
        ----------
        s, t : (...) float or Jet
            Fractions of the blade's height and of its chord, from 0 to 1.

        Returns
        -------
        x, y, z : (...) float or Jet
            In m.
        """
        for name, part in (("s", s), ("t", t)):
            value = part.value if isinstance(part, Jet) else part
            wrong = ~((value >= 0) & (value <= 1))
            if np.any(wrong):
                raise ValueError(f"{name}: must lie from 0 to 1; got {value[wrong].flat[0]:g}.")
        radius = self.hub + self.height * s
        slope = self.stagger + self.twist * s
        along = self.chord * (t - 0.5)
        # A blade is straight on the unrolled cylinder of a radius, but for the camber's parabola.
        arc = along * np.sin(slope) + 4 * self.camber * t * (1 - t) + self.bow * s**2
        return (radius * np.cos(arc / radius), radius * np.sin(arc / radius), along * np.cos(slope))

    @checked
    def mesh(self, n: Whole(1, 500), blade: Whole(-1000, 1000) = 0):
        """Return a grid (n, n, 3) of points of a blade, in m, with n from 1 to 500.

        The blades are counted from the first one, `blade` 0.
        """
        s, t = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
        c = np.cos(2 * np.pi * blade / self.blades)
        d = np.sin(2 * np.pi * blade / self.blades)
        x, y, z = self.coordinates(s, t)
        return np.stack([c * x - d * y, d * x + c * y, z], axis=-1)

    @checked
    def clearances(self, tool: ConePose, *, n: Whole(2, 500) = 121):
        """Return how far a tool stays from the first blade and from both its neighbours.

        Parameters
        ----------
        tool : ConePose
            Where it touches the first blade, or nearly.
        n : int
            Points are compared on a grid n by n of each blade; from 2 to 500.

        Returns
        -------
        distance : (3,) float
            In m, negative within the tool: to the first blade, the next and the last.
        """
        return np.array([tool.clearance(self.mesh(n, k)).min() for k in (0, 1, -1)])


@dataclass(frozen=True)
@checked
class Patch:
    """A surface over a rectangle of its parameters.

    Parameters
    ----------
    surface : callable
        Of two variables, for `hyperosculating_cones` with model="space": three coordinates, in m.
        What it raises itself passes through.
    s, t : (2,) float
        Least and greatest parameters.
    side : {1, -1}
        1 where the tool comes from the side to which the surface's normal r_s x r_t points.

    Examples
    --------
    >>> patch = Patch(lambda s, t: [s, t, s * t], (-1, 1), (-1, 1))
    >>> patch.mesh(3).shape
    (3, 3, 3)
    """

    surface: Function(2)
    s: Range
    t: Range
    side: Sign = 1

    @checked
    def parameters(self, n: Whole(1, 500), *, margin: NotNegative = 0.0):
        """Return a grid n by n of parameters.

        Parameters
        ----------
        n : int
            From 1 to 500.
        margin : float
            Share of the width that is left free at each border.

        Returns
        -------
        s, t : (n, n) float
            Parameters.

        Examples
        --------
        >>> patch = Patch(lambda s, t: [s, t, s * t], (-1, 1), (-1, 1))
        >>> patch.parameters(3, margin=0.25)[0][:, 0].tolist()
        [-0.5, 0.0, 0.5]
        >>> patch.parameters(3, margin=0.5)
        Traceback (most recent call last):
        ValueError: margin: must be below 0.5; got 0.5.
        """
        if margin >= 0.5:
            raise ValueError(f"margin: must be below 0.5; got {margin:g}.")
        where = np.linspace(margin, 1 - margin, n)
        (a, b), (c, d) = self.s, self.t
        # Rounding mustn't lead beyond the ends, where a surface may refuse to answer.
        s = np.clip(a + (b - a) * where, a, b)
        t = np.clip(c + (d - c) * where, c, d)
        return np.meshgrid(s, t, indexing="ij")

    @checked
    def points(self, s: Reals, t: Reals):
        """Return points (..., 3), in m, at parameters s, t (...)."""
        s, t = np.broadcast_arrays(s, t)
        parts = self.surface(s, t)
        return np.stack([np.broadcast_to(part, s.shape) for part in parts], axis=-1).astype(float)

    @checked
    def mesh(self, n: Whole(2, 500) = 121):
        """Return a grid (n, n, 3) of points, in m."""
        return self.points(*self.parameters(n))
