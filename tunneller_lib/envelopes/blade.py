"""A ring of blades to place cones on, and how near a truncated cone comes to points.

A substitute: the industrial impeller of the document (Example 33, Fig. 11) isn't public.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import (
    Angle,
    Coordinate,
    Direction,
    Directions,
    HalfAngle,
    Length,
    Length0,
    Point,
    Points,
    Whole,
    checked,
)
from ..kernels.exact import dot, norm
from .functions import Varying
from .jet import Jet

_SLENDER = 1e6  # times a hub's radius: no size of a blade is above it


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
            if size > _SLENDER * self.hub:
                raise ValueError(
                    f"{name}: must be at most {_SLENDER:g} times the hub's radius {self.hub:g} m; "
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
def blade_distances(
    ring: BladeRing,
    vertex: Point,
    axis: Direction,
    half_angle: HalfAngle,
    near: Length0,
    far: Length,
    *,
    n: Whole(2, 500) = 121,
):
    """Return how far a truncated cone stays from the first blade and from both its neighbours.

    Parameters
    ----------
    ring : BladeRing
        The blades.
    vertex : (3,) float
        In m.
    axis : (3,) float
        A vector along the axis into the cone.
    half_angle : float
        Between axis and rulings, in rad.
    near, far : float
        Where the rulings begin and end, as distances from the vertex, in m.
    n : int
        Points are compared on a grid n by n of each blade; from 2 to 500.

    Returns
    -------
    distance : (3,) float
        In m, negative within the cone: to the first blade, the next and the last.
    """
    tool = vertex, axis, half_angle, near, far
    return np.array([cone_distance(ring.mesh(n, k), *tool).min() for k in (0, 1, -1)])


@checked
def cone_distance(
    point: Points,
    vertex: Points,
    axis: Directions,
    half_angle: HalfAngle,
    near: Length0,
    far: Length,
):
    """Return how far points are from a truncated cone, negative within it.

    Parameters
    ----------
    point : (..., 3) float
        In m.
    vertex, axis : (..., 3) float
        Vertex in m, and a vector along the axis into the cone.
    half_angle : float
        Between axis and rulings, in rad.
    near, far : float
        Where the rulings begin and end, as distances from the vertex, in m.

    Returns
    -------
    distance : (...) float
        In m: to the nearest of wall and two flat ends.

    Raises
    ------
    ValueError
        If the half-angle isn't between 0 and pi/2, or `near` not below `far`.

    Examples
    --------
    >>> import numpy as np
    >>> cone_distance((0, 0, 3), (0, 0, 0), (0, 0, 1), 0.5, 1 / np.cos(0.5), 2 / np.cos(0.5))
    np.float64(1.0)
    """
    if near >= far:
        raise ValueError(f"near: must be below far; got {near:g} and {far:g}.")
    axis = axis / norm(axis)[..., None]
    height = dot(point - vertex, axis)
    radius = norm(point - vertex - height[..., None] * axis)
    c = np.cos(half_angle)
    s = np.sin(half_angle)
    # In the half plane of the axis: the wall is a segment, the ends are the levels near c, far c.
    along = np.clip(height * c + radius * s, near, far)
    wall = np.hypot(height - along * c, radius - along * s)
    outside = radius * c - height * s
    ends = [np.hypot(height - end * c, np.maximum(radius - end * s, 0.0)) for end in (near, far)]
    inside = (outside < 0) & (height > near * c) & (height < far * c)
    nearest = np.minimum(wall, np.minimum(*ends))
    return np.where(inside, -nearest, nearest)[()]
