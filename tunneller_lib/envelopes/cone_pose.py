"""A truncated cone of revolution in space."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angles, Direction, HalfAngle, Length, Length0, Point, Points, Whole, checked
from ..kernels.exact import dot, norm
from .isotropic import cone_planes, cone_rulings, top_circle


@dataclass(frozen=True)
@checked
class ConePose:
    """A truncated cone of revolution in space.

    Parameters
    ----------
    vertex : (3,) float
        In m.
    axis : (3,) float
        A vector along the axis, from the vertex into the cone, of any length but zero.
    half_angle : float
        Between axis and rulings, in rad, between 0 and pi/2.
    near, far : float
        Where the rulings begin and end, as distances from the vertex, in m.

    Raises
    ------
    ValueError
        If the axis is zero, the half-angle isn't between 0 and pi/2, or `near` not below `far`.

    Examples
    --------
    >>> tool = ConePose((0, 0, 0), (0, 0, 2), np.pi / 6, near=0.1, far=0.3)
    >>> float(np.round(tool.circle()[1], 3))
    0.577
    """

    vertex: Point
    axis: Direction
    half_angle: HalfAngle
    near: Length0
    far: Length

    def __post_init__(self):
        if self.near >= self.far:
            raise ValueError(f"near: must be below far; got {self.near:g} and {self.far:g}.")

    @checked
    def planes(self, azimuth: Angles):
        """Return the tangent planes at azimuths about the axis.

        Parameters
        ----------
        azimuth : (...) float
            In rad.

        Returns
        -------
        n : (..., 3) float
            Unit normals that point into the cone.
        h : (...) float
            Constant terms of n.x + h = 0, in m.
        """
        return cone_planes(self.vertex, self.axis, self.half_angle, azimuth)

    def circle(self):
        """Return centre (2,) and radius of the circle over which the planes lie in the model."""
        return top_circle(self.axis, self.half_angle)

    @checked
    def clearance(self, point: Points):
        """Return how far points (..., 3) are from the cone, in m (...), negative within it."""
        axis = np.array(self.axis) / norm(np.array(self.axis))
        away = point - self.vertex
        height = dot(away, axis)
        radius = norm(away - height[..., None] * axis)
        above = height - self.near * np.cos(self.half_angle)
        first = self.near * np.sin(self.half_angle)
        return distance_to_cone(above, radius, first, self.half_angle, self.far - self.near)

    @checked
    def mesh(self, n: Whole(2, 1000) = 25, m: Whole(3, 1000) = 73):
        """Return a grid (n, m, 3) of points of the wall, in m: n along the rulings, m around."""
        azimuth = np.linspace(0, 2 * np.pi, m)
        rulings = cone_rulings(self.axis, self.half_angle, azimuth)
        along = np.linspace(self.near, self.far, n)[:, None, None]
        return np.array(self.vertex) + along * rulings


def distance_to_cone(height, radius, first, half_angle, ruling):
    """Return how far points are from a truncated cone or cylinder, negative within it.

    Parameters
    ----------
    height, radius : (...) float
        Of the points: above the lower end, and from the axis, in m.
    first, half_angle, ruling : float
        The lower end's radius in m, half the opening angle in rad, 0 for a cylinder, and the
        length along the wall in m.

    Returns
    -------
    distance : (...) float
        In m: to the nearest of wall and two flat ends.
    """
    # In the half plane of the axis the wall is a segment. `along` runs on its line and `side`
    # across it; `over` is how far a point lies beyond the segment's ends.
    c = np.cos(half_angle)
    s = np.sin(half_angle)
    off = radius - first
    side = off * c - height * s
    along = height * c + off * s
    over = np.maximum(np.maximum(-along, along - ruling), 0.0)
    # Roots of sums of squares, as `hypot` takes several times as long: sizes are lengths from
    # 1e-100 to 1e100 m, whose squares are numbers.
    square = side * side + over * over
    length = ruling * c
    for level, wide in ((height, off), (height - length, off - ruling * s)):
        beyond = np.maximum(wide, 0.0)
        square = np.minimum(square, level * level + beyond * beyond)
    inside = (side < 0) & (height > 0) & (height < length)
    nearest = np.sqrt(square)
    return np.where(inside, -nearest, nearest)[()]
