"""A disc with a ball about each of its points: the end of a bull-nose cutter."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Direction, Directions, Length0, Point, Points, Radii, checked
from ..kernels.elementwise import larger, ratio, some, square_root, where, within
from ..kernels.exact import dot, norm
from ..kernels.vectors import differences, multiples, scalar_products, shares, sums, unit_and_speed
from .blocks import CLOSE, FAR, RANGE, meet_in_blocks, meet_one_by_one, well_shaped
from .rod_interval import GUARD, nearest_offset

FINE = 2.0**-50  # of the size, to which a place is told: there are floats between such ends
GUESSES = 6  # of Newton's steps to about where a line is nearest
SHARES = 2.0**-20, 2.0**-40  # of the size, how far a guess may be off
CHORDS = 2.0**-20, 2.0**-26  # of the size, half of what those lines have inside that touch


@checked
def meet_rounded_discs(
    centre: Points,
    axis: Directions,
    radius: Radii,
    corner: Radii,
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
    return meet_one_by_one(_meet_discs, [centre, axis, point, direction], [radius, corner])


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
    axis: Direction
    radius: Length0
    corner: Length0

    @property
    def unit(self):
        """Return the axis' direction (3,)."""
        return np.array(unit_and_speed(self.axis)[0])

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
        `corner` once. Newton's steps from outside never pass that place. Where a few of them don't
        reach it all three are found by halving, which no tangent and no flat place disturbs. The
        answer is that of a solid whose surface is off by at most 64 eps (radius + corner): a line
        that touches it is never missed. Along the line each end may be off by another 16 eps, of
        radius + corner or of the greater distance of the ends from the given point. All this
        holds while that point is at most 1e15 (radius + corner) away.

        Examples
        --------
        >>> enter, leave = RoundedDisc((0, 0, 1), (0, 0, 1), 3, 1).meet_line((-9, 0, 1), (1, 0, 0))
        >>> float(enter), float(leave)
        (5.0, 13.0)
        """
        shape = _Numbers(self.centre, unit_and_speed(self.axis)[0], self.radius, self.corner)
        plain = well_shaped(self.radius + self.corner)
        return meet_in_blocks(_quickly, _carefully, shape, plain, point, direction)


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
    return _growth_at(line, t, _place(line, t))


def _growth_at(line, t, place):
    rho, beside, height = place
    outwards = (line.turn + t * line.flat) / where(rho > 0, rho, 1.0)
    return beside * outwards + height * line.rise


def _bend(line, t):
    """Return how the growth changes with t."""
    rho, _, _ = _place(line, t)
    area = line.square * line.flat - line.turn * line.turn
    beside = line.flat - ratio(line.radius * area, rho * rho * rho)
    return line.rise * line.rise + where(rho > line.radius, beside, 0.0)


def _quickly(shape, q, u):
    """Return `enter`, `leave` and where they are sure of lines from the centre."""
    size = shape.radius + shape.corner
    uu, qq = scalar_products(u, u), scalar_products(q, q)
    near = (qq <= FAR * FAR * size * size) & (uu < RANGE * RANGE) & (uu > 1 / RANGE / RANGE)
    speed = square_root(uu)
    along = shares(u, speed)
    shift = -scalar_products(q, along)
    q = sums(q, multiples(shift, along))
    line = _line(shape, q, along)
    # The solid is in a ball about its centre, outside of which the search begins.
    reach = square_root(larger(size * size - scalar_products(q, q), 0.0))
    start, started = _stepped(line, -reach, 1, GUARD / 4 * size)
    end, ended = _stepped(line, reach, -1, GUARD / 4 * size)
    # Up to the one and from the other on the distance is too great: passing, they prove a miss.
    # By less, as on a disc without a corner, rounding may have made them pass.
    missed = start - end > CLOSE * size
    met = started & ended & (start <= end)
    enter = where(missed, np.inf, (shift + start) / speed)
    return enter, where(missed, -np.inf, (shift + end) / speed), near & (missed | met)


def _stepped(line, t, sign, guard):
    """Return where lines that go on from t, or back, come as near as `corner`, and if they do."""
    for _ in range(10):  # Newton's steps; a line that needs more nearly touches
        place = _place(line, t)
        _, beside, height = place
        distance = square_root(beside * beside + height * height)
        grow = _growth_at(line, t, place)
        # Tangents of a convex function are below it, so that their zeros are never beyond its own.
        outside = (distance - line.corner > guard) & (sign * grow < 0)
        if not some(outside):
            break
        t = where(outside, t - ratio((distance - line.corner) * distance, grow), t)
    return t, abs(square_root(_square(line, t)) - line.corner) <= 2 * guard


def _meet_discs(centre, axis, p, u, radius, corner):
    """Return `enter` and `leave` of lines against rounded discs, vectors and numbers."""
    return _carefully(_Numbers(centre, unit_and_speed(axis)[0], radius, corner), p, u)


def _carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a rounded disc."""
    along, speed = unit_and_speed(u)
    q, shift = nearest_offset(shape.start, along, speed, p, u)
    hit, start, end = _interval(_line(shape, q, along))
    enter = where(hit, shift + start / speed, np.inf)
    return enter, where(hit, shift + end / speed, -np.inf)


def _interval(line):
    """Return which lines meet rounded discs, and where they enter and leave, in m."""
    size = line.radius + line.corner
    # The solid is in a ball about its centre, so that a line meets it on this way or not at all.
    fine = FINE * size
    guess = _guessed(line, size)
    wide, close = SHARES[0] * size, SHARES[1] * size
    looks = (guess - wide, guess + wide, guess - close, guess + close)
    nearest = _halved(line, True, -2 * size, 2 * size, looks, fine)
    least = square_root(_square(line, nearest))
    touch = least > line.corner
    if touch is True:
        start = end = nearest
    else:
        wide, close = CHORDS[0] * size, CHORDS[1] * size
        looks = (nearest - wide, nearest - close)
        start = _halved(line, False, -2 * size, nearest, looks, fine)
        looks = (-nearest - wide, -nearest - close)
        end = -_halved(_reversed(line), False, -2 * size, -nearest, looks, fine)
    # A touch within the guard is one of the solid that is just so much larger.
    start, end = where(touch, nearest, start), where(touch, nearest, end)
    return least <= line.corner + GUARD * size, start, end


def _guessed(line, size):
    """Return about where lines are nearest to discs, by Newton, if it comes near at all."""
    t = 0.0
    for _ in range(GUESSES):
        t = within(t - ratio(_growth(line, t), _bend(line, t)), -size, size)
    return where(t == t, t, 0.0)


def _reversed(line):
    """Return lines that go the other way."""
    radius, corner, height, rise, square, turn, flat = line
    return _Line(radius, corner, height, -rise, square, -turn, flat)


def _before(line, nears, t):
    """Return whether lines still come nearer to the disc at t, or are still outside."""
    if nears:
        return _growth(line, t) < 0
    return _square(line, t) > line.corner * line.corner


def _halved(line, nears, low, high, looks, fine):
    """Return up to where lines come nearer to the disc, if it is asked for `nears`, or are outside.

    The place is between `low` and `high`, to a length that is `fine`. Places that are looked at
    first may spare most of the halvings.
    """
    for look in looks:
        look = within(look, low, high)
        more = _before(line, nears, look)
        low, high = where(more, look, low), where(more, high, look)
    apart = high - low > fine
    while some(apart):
        middle = (low + high) / 2
        # A line that is done stays as it is, however many others aren't.
        more = _before(line, nears, middle) & apart
        low, high = where(more, middle, low), where(apart ^ more, middle, high)
        apart = high - low > fine
    return high
