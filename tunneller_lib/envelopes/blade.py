"""A ring of blades to place cones on, and how near a truncated cone comes to points.

A substitute: the industrial impeller of the document (Example 33, Fig. 11) isn't public.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import finite, points, positive
from ..exact import dot, norm


@dataclass(frozen=True)
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
        How many.

    Raises
    ------
    ValueError
        If a length isn't above zero, a number not finite, or there are fewer than 2 blades.

    Examples
    --------
    >>> ring = BladeRing(0.06, 0.03, 0.05, 0.0, 0.5, 0.0, 0.0, 6)
    >>> ring.mesh(3).shape
    (3, 3, 3)
    """

    hub: float
    height: float
    chord: float
    stagger: float
    twist: float
    camber: float
    bow: float
    blades: int

    def __post_init__(self):
        for name in ("hub", "height", "chord"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        for name in ("stagger", "twist", "camber", "bow"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        if self.blades != int(finite("blades", self.blades)) or self.blades < 2:
            raise ValueError(f"blades: must be a whole number of at least 2; got {self.blades}.")

    def coordinates(self, s, t):
        """Return x, y, z of the first blade, by fractions s of its height and t of its chord.

        Numbers, arrays or jets: a surface for `hyperosculating_cones` with model="space".
        """
        radius = self.hub + self.height * s
        slope = self.stagger + self.twist * s
        along = self.chord * (t - 0.5)
        arc = along * np.sin(slope) + 4 * self.camber * t * (1 - t) + self.bow * s**2
        return (radius * np.cos(arc / radius), radius * np.sin(arc / radius), along * np.cos(slope))

    def mesh(self, n, blade=0):
        """Return a grid (n, n, 3) of points of a blade, in m, counted from the first one."""
        s, t = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
        c, d = (f(2 * np.pi * blade / self.blades) for f in (np.cos, np.sin))
        x, y, z = self.coordinates(s, t)
        return np.stack([c * x - d * y, d * x + c * y, z], axis=-1)


def clearance(ring, vertex, axis, half_angle, near, far, *, n=121):
    """Return how far a truncated cone stays from the first blade and from both its neighbours.

    Parameters
    ----------
    ring : BladeRing
        The blades.
    vertex, axis : (3,) float
        Vertex in m, and a vector along the axis into the cone.
    half_angle : float
        Between axis and rulings, in rad.
    near, far : float
        Where the rulings begin and end, as distances from the vertex, in m.
    n : int
        Points are compared on a grid n by n of each blade.

    Returns
    -------
    distance : (3,) float
        In m, negative within the cone: to the first blade, the next and the last.
    """
    tool = vertex, axis, half_angle, near, far
    return np.array([cone_distance(ring.mesh(n, k), *tool).min() for k in (0, 1, -1)])


def cone_distance(point, vertex, axis, half_angle, near, far):
    """Return how far points are from a truncated cone, negative within it.

    Parameters
    ----------
    point : (..., 3) float
        In m.
    vertex, axis : (3,) float
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
        If the cone is no truncated cone.

    Examples
    --------
    >>> import numpy as np
    >>> cone_distance((0, 0, 3), (0, 0, 0), (0, 0, 1), 0.5, 1 / np.cos(0.5), 2 / np.cos(0.5))
    np.float64(1.0)
    """
    point, vertex, axis = points("point", point), points("vertex", vertex), points("axis", axis)
    half_angle, far = positive("half_angle", half_angle), positive("far", far)
    near = finite("near", near)
    if not (half_angle < np.pi / 2 and 0 <= near < far):
        raise ValueError("near: must lie below far and not below 0, and the half_angle below pi/2; "
                         f"got {near}, {far} and {half_angle}.")  # fmt: skip
    axis = axis / norm(axis)
    height = dot(point - vertex, axis)
    radius = norm(point - vertex - height[..., None] * axis)
    c, s = np.cos(half_angle), np.sin(half_angle)
    # In the half plane of the axis: the wall is a segment, the ends are the levels near c, far c.
    along = np.clip(height * c + radius * s, near, far)
    wall = np.hypot(height - along * c, radius - along * s)
    outside = radius * c - height * s
    ends = [np.hypot(height - end * c, np.maximum(radius - end * s, 0.0)) for end in (near, far)]
    inside = (outside < 0) & (height > near * c) & (height < far * c)
    nearest = np.minimum(wall, np.minimum(*ends))
    return np.where(inside, -nearest, nearest)[()]
