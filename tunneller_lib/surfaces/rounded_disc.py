"""A disc with a ball about each of its points: the end of a bull-nose cutter."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Directions, Length0, Lengths, Point, Points, checked, sizes
from ..exact import dot, norm
from .blocks import meet_in_blocks, scalar_products, unsure
from .rod_interval import GUARD, near_one, nearest_offset

HALVINGS = 64  # after which an interval has no float inside, or next to none


@checked
def meet_rounded_discs(
    centre: Points,
    axis: Directions,
    radius: Lengths,
    corner: Lengths,
    point: Points,
    direction: Directions,
):
    """Return where lines enter and leave rounded discs, one a line: `RoundedDisc.meet_line`.

    Parameters
    ----------
    centre : (..., 3) float
        Of the discs, in m.
    axis : (..., 3) float
        Perpendicular to them, not zero.
    radius, corner : (...) float
        Of the discs and of the balls about their points, in m, zero or above.
    point, direction : (..., 3) float
        One point of each line, in m, and its direction, not zero.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

    Raises
    ------
    ValueError
        As by `RoundedDisc` and `RoundedDisc.meet_line`.

    Examples
    --------
    >>> meet_rounded_discs((0, 0, 0), (0, 0, 1), [3, 0], [1, 4], (-9, 0, 0), (1, 0, 0))
    (array([5., 5.]), array([13., 13.]))
    """
    for name, length in (("radius", radius), ("corner", corner)):
        if not np.all(length >= 0):
            raise ValueError(f"{name}: must not be below zero; got {np.min(length):g} m.")
        sizes(name, length)
    axis, _ = near_one(axis)
    enter, leave = _meet(centre, axis / norm(axis)[..., None], radius, corner, point, direction)
    return enter[()], leave[()]


@dataclass(frozen=True)
@checked
class RoundedDisc:
    """All points that are at most a corner's radius from a disc, its surface included.

    Parameters
    ----------
    centre : (3,) float
        Of the disc, in m.
    axis : (3,) float
        Perpendicular to it, of any length but zero.
    radius : float
        Of the disc, in m; with 0 it's a ball.
    corner : float
        Of the balls about its points, in m; with 0 it's the disc.

    Raises
    ------
    ValueError
        If centre or axis isn't one finite point, the axis is zero, or a size is outside the range
        that `Rod` allows.

    Notes
    -----
    Its border is half a torus and two discs, and its greatest radius is `radius` + `corner`.
    """

    centre: Point
    axis: Point
    radius: Length0
    corner: Length0

    def __post_init__(self):
        sizes("axis", np.abs(self.axis).max())
        if not any(self.axis):
            raise ValueError("axis: must not be zero; got (0, 0, 0).")

    @property
    def unit(self):
        """Return the axis' direction (3,)."""
        axis, _ = near_one(np.array(self.axis))
        return axis / norm(axis)

    @checked
    def contains(self, points: Points):
        """Return whether points (..., 3), in m, are inside or, within rounding, on the surface."""
        q = points - self.centre
        height = dot(q, self.unit)
        beside = norm(q - height[..., None] * self.unit) - self.radius
        distance = np.hypot(np.maximum(beside, 0), height)
        return distance <= self.corner + GUARD * (self.radius + self.corner)

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the rounded disc.

        Parameters
        ----------
        point, direction : (..., 3) float
            One point of each line, in m, and its direction, of any length but zero.

        Returns
        -------
        enter, leave : (...) float
            In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

        Notes
        -----
        The distance from the disc is a convex function along a line. Its least decides once
        whether the line meets the solid, and on either side of it the distance is equal to
        `corner` once. All three are found by halving, which no tangent and no flat place
        disturbs. The answer is that of a solid whose surface is off by at most 64 eps
        (radius + corner): a line that touches it is never missed.

        Examples
        --------
        >>> enter, leave = RoundedDisc((0, 0, 1), (0, 0, 1), 3, 1).meet_line((-9, 0, 1), (1, 0, 0))
        >>> float(enter), float(leave)
        (5.0, 13.0)
        """
        centre = np.array(self.centre)
        unit = self.unit

        def careful(p, u):
            return _meet(centre, unit, self.radius, self.corner, p, u)

        return meet_in_blocks(unsure, careful, centre, point, direction)


def _meet(centre, unit, radius, corner, p, u):
    """Return `enter` and `leave` of lines (..., 3) against rounded discs with unit axes."""
    along, exponent = near_one(u)
    speed = norm(along)
    along = along / speed[..., None]
    speed = np.ldexp(speed, exponent)
    q, shift = nearest_offset(centre, along, speed, p, u)
    hit, start, end = _interval(radius, corner, q, along, unit)
    enter = np.where(hit, shift + start / speed, np.inf)
    return enter, np.where(hit, shift + end / speed, -np.inf)


def _interval(radius, corner, q, along, unit):
    """Return which lines meet rounded discs, and where they enter and leave, in m.

    Parameters: radius, corner (...), from the centres to the lines' points, and unit vectors along
    lines and axes (..., 3).
    """
    size = np.asarray(radius + corner)
    vectors = np.broadcast_arrays(q, along, unit, size[..., None])[:3]
    q, along, unit = (np.moveaxis(v, -1, 0) for v in vectors)
    q_height, along_height = scalar_products(q, unit), scalar_products(along, unit)
    q_flat, along_flat = q - q_height * unit, along - along_height * unit
    flat2, cross2 = scalar_products(along_flat, along_flat), scalar_products(q_flat, along_flat)

    def parts(t):
        flat = q_flat + t * along_flat
        rho = np.sqrt(scalar_products(flat, flat))
        return rho, np.maximum(rho - radius, 0), q_height + t * along_height

    def nears(t):
        # Half the derivative of the squared distance is below zero.
        rho, beside, height = parts(t)
        grow = (cross2 + t * flat2) / np.where(rho > 0, rho, 1)
        return beside * grow + height * along_height < 0

    def distance(t):
        _, beside, height = parts(t)
        return np.hypot(beside, height)

    # The solid is in a ball about its centre, so that a line meets it on this way or not at all.
    reach = np.broadcast_to(2 * size, flat2.shape)
    nearest = _halved(nears, -reach, reach)
    least = distance(nearest)
    start = _halved(lambda t: distance(t) > corner, -reach, nearest)
    end = -_halved(lambda t: distance(-t) > corner, -reach, -nearest)
    # A touch within the guard is one of the solid that is just so much larger.
    touch = least > corner
    start, end = np.where(touch, nearest, start), np.where(touch, nearest, end)
    return (least <= corner + GUARD * size) & (size > 0), start, end


def _halved(before, low, high):
    """Return up to which place `before`, a function of places from `low` to `high`, holds."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        more = before(middle)
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return high
