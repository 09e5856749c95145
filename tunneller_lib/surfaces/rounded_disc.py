"""A disc with a ball about each of its points: the end of a bull-nose cutter."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Direction, Directions, Length0, Point, Points, checked
from ..kernels.elementwise import larger, some, square_root, where
from ..kernels.vectors import differences, multiples, scalar_products, unit_and_speed
from .blocks import meet_in_blocks
from .rod_interval import GUARD, nearest_offset
from .solid import Solid, both_ways, nearest_in_disc

FINE = 2.0**-50  # of the size, to which a place is told: there are floats between such ends


@dataclass(frozen=True)
@checked
class RoundedDisc(Solid):
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
    axis: Direction
    radius: Length0
    corner: Length0

    @property
    def unit(self):
        """Return the axis' direction (3,)."""
        return np.array(unit_and_speed(self.axis)[0])

    def outermost(self, normal):
        """Return the disc's points that planes touch, as `Solid` says."""
        out = self.radius * nearest_in_disc(normal, self.unit) + self.corner * normal
        return np.array(self.centre), both_ways(np.zeros(3), out)

    @property
    def capsule(self):
        """Return the centre (3,), twice, and the radius of the ball about the disc, in m."""
        return np.array(self.centre), np.array(self.centre), self.radius + self.corner

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
        `corner` once. All three places are found by halving, which no tangent and no flat place
        disturbs. The answer is that of a solid whose surface is off by at most 64 eps (radius +
        corner): a line that touches it is never missed. Along the line each end may be off by
        another 16 eps, of radius + corner or of the greater distance of the ends from the given
        point. All this holds while that point is at most 1e15 (radius + corner) away.

        Examples
        --------
        >>> enter, leave = RoundedDisc((0, 0, 1), (0, 0, 1), 3, 1).meet_line((-9, 0, 1), (1, 0, 0))
        >>> round(float(enter), 12), round(float(leave), 12)
        (5.0, 13.0)
        """
        shape = _Numbers(self.centre, unit_and_speed(self.axis)[0], self.radius, self.corner)
        return meet_in_blocks(_carefully, shape, point, direction)


class _Numbers(NamedTuple):
    """A rounded disc in numbers: its centre, a unit vector along its axis, its radii."""

    start: tuple
    unit: tuple
    radius: float
    corner: float


class _Line(NamedTuple):
    """Lines past discs, by how high they are and how far from the axis; in m.

    `height` and `rise` are those of the given points and of the directions; the squared distance
    from the axis is square + 2 turn t + flat t^2.
    """

    radius: float
    corner: float
    height: np.ndarray
    rise: np.ndarray
    square: np.ndarray
    turn: np.ndarray
    flat: np.ndarray


def _line(shape, q, along):
    """Return lines by points from the centre of a disc and by unit vectors along them."""
    height, rise = scalar_products(q, shape.unit), scalar_products(along, shape.unit)
    q = differences(q, multiples(height, shape.unit))
    along = differences(along, multiples(rise, shape.unit))
    square, turn = scalar_products(q, q), scalar_products(q, along)
    flat = scalar_products(along, along)
    return _Line(shape.radius, shape.corner, height, rise, square, turn, flat)


def _place(line, t):
    """Return how far from the axis, beside the disc and above it a line is."""
    rho = square_root(larger(line.square + t * (2 * line.turn + t * line.flat), 0.0))
    return rho, larger(rho - line.radius, 0.0), line.height + t * line.rise


def _square(line, t):
    """Return the square of the distance from the disc."""
    _, beside, height = _place(line, t)
    return beside * beside + height * height


def _growth(line, t):
    """Return half of what that square grows by with t."""
    rho, beside, height = _place(line, t)
    outwards = (line.turn + t * line.flat) / where(rho > 0, rho, 1.0)
    return beside * outwards + height * line.rise


def _carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a rounded disc."""
    along, speed = unit_and_speed(u)
    q, shift = nearest_offset(shape.start, along, speed, p, u)
    hit, start, end = _interval(_line(shape, q, along))
    enter = where(hit, shift + start / speed, np.inf)
    return enter, where(hit, shift + end / speed, -np.inf)


def _interval(line):
    """Return which lines meet rounded discs, and where they enter and leave, in m."""
    # The solid is in a ball about its centre, so that a line meets it on this way or not at all.
    size = line.radius + line.corner
    nearest = _halved(line, True, -2 * size, 2 * size)
    least = square_root(_square(line, nearest))
    start = _halved(line, False, -2 * size, nearest)
    end = -_halved(_reversed(line), False, -2 * size, -nearest)
    # A touch within the guard is one of the solid that is just so much larger.
    touch = least > line.corner
    start, end = where(touch, nearest, start), where(touch, nearest, end)
    return least <= line.corner + GUARD * size, start, end


def _reversed(line):
    """Return lines that go the other way."""
    radius, corner, height, rise, square, turn, flat = line
    return _Line(radius, corner, height, -rise, square, -turn, flat)


def _before(line, nears, t):
    """Return whether lines still come nearer to the disc at t, if `nears`, or are still outside."""
    if nears:
        return _growth(line, t) < 0
    return _square(line, t) > line.corner * line.corner


def _halved(line, nears, low, high):
    """Return the place between `low` and `high` up to which `_before` holds."""
    fine = FINE * (line.radius + line.corner)
    apart = high - low > fine
    while some(apart):
        middle = (low + high) / 2
        # A line that is done stays as it is, however many others aren't.
        more = _before(line, nears, middle) & apart
        low, high = where(more, middle, low), where(apart ^ more, middle, high)
        apart = high - low > fine
    return high
