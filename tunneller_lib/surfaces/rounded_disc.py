"""A disc with a ball about each of its points: the end of a bull-nose cutter."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Directions, Length0, Lengths, Point, Points, checked, sizes
from ..elementwise import larger, ratio, some, square_root, where, within
from ..exact import dot, norm
from .blocks import CLOSE, FAR, RANGE, meet_in_blocks, meet_one_by_one, unsure, well_shaped
from .rod_interval import GUARD, nearest_offset
from .vectors import differences, multiples, scalar_products, shares, sums, unit_and_speed

FINE = 2.0**-50  # of the size, to which a place is told: there are floats between such ends
GUESSES = 6  # of Newton's steps to about where a line is nearest
SHARES = 2.0**-20, 2.0**-40  # of the size, how far a guess may be off
CHORDS = 2.0**-20, 2.0**-26  # of the size, half of what those lines have inside that touch


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
        that touches it is never missed.

        Examples
        --------
        >>> enter, leave = RoundedDisc((0, 0, 1), (0, 0, 1), 3, 1).meet_line((-9, 0, 1), (1, 0, 0))
        >>> float(enter), float(leave)
        (5.0, 13.0)
        """
        unit, _ = unit_and_speed(self.axis)

        def careful(p, u):
            return _meet(self.centre, unit, p, u, self.radius, self.corner)

        def quick(q, u):
            return _quickly(unit, self.radius, self.corner, q, u)

        if not well_shaped(self.radius + self.corner):
            quick = unsure
        return meet_in_blocks(quick, careful, self.centre, point, direction)


class _Passing:
    """Lines past discs, by how high they are and how far from the axis; in m.

    `height` and `rise` are those of the given points and of the directions; the squared distance
    from the axis is square + 2 turn t + flat t^2.
    """

    def __init__(self, radius, q, along, unit):
        self.radius = radius
        self.height, self.rise = scalar_products(q, unit), scalar_products(along, unit)
        q_flat = differences(q, multiples(self.height, unit))
        along_flat = differences(along, multiples(self.rise, unit))
        self.square, self.turn = (
            scalar_products(q_flat, q_flat),
            scalar_products(q_flat, along_flat),
        )
        self.flat = scalar_products(along_flat, along_flat)

    def at(self, t):
        """Return the distance from the disc, and half of what its square grows by with t."""
        place = self._place(t)
        _, beside, height = place
        return square_root(beside * beside + height * height), self._growth(t, place)

    def distance(self, t):
        """Return the distance from the disc."""
        return square_root(self.square_of_distance(t))

    def square_of_distance(self, t):
        """Return its square."""
        _, beside, height = self._place(t)
        return beside * beside + height * height

    def growth(self, t):
        """Return half of what its square grows by with t."""
        return self._growth(t, self._place(t))

    def bend(self, t):
        """Return how the growth changes with t."""
        rho, *_ = self._place(t)
        area = self.square * self.flat - self.turn * self.turn
        beside = self.flat - ratio(self.radius * area, rho * rho * rho)
        return self.rise * self.rise + where(rho > self.radius, beside, 0.0)

    def _place(self, t):
        """Return how far from the axis, beside the disc and above it a line is."""
        rho = square_root(larger(self.square + t * (2 * self.turn + t * self.flat), 0.0))
        return rho, larger(rho - self.radius, 0.0), self.height + t * self.rise

    def _growth(self, t, place):
        rho, beside, height = place
        outwards = (self.turn + t * self.flat) / where(rho > 0, rho, 1.0)
        return beside * outwards + height * self.rise


def _quickly(unit, radius, corner, q, u):
    """Return `enter`, `leave` and where they are sure of lines from the centre."""
    size, uu, qq = radius + corner, scalar_products(u, u), scalar_products(q, q)
    near = (qq <= FAR * FAR * size * size) & (uu < RANGE * RANGE) & (uu > 1 / RANGE / RANGE)
    speed = square_root(uu)
    along = shares(u, speed)
    shift = -scalar_products(q, along)
    q = sums(q, multiples(shift, along))
    line = _Passing(radius, q, along, unit)
    # The solid is in a ball about its centre, outside of which the search begins.
    reach = square_root(larger(size * size - scalar_products(q, q), 0.0))
    start, started = _stepped(line, corner, -reach, 1, GUARD / 4 * size)
    end, ended = _stepped(line, corner, reach, -1, GUARD / 4 * size)
    # Up to the one and from the other on the distance is too great: passing, they prove a miss.
    missed = start - end > CLOSE * size
    enter = where(missed, np.inf, (shift + start) / speed)
    return enter, where(missed, -np.inf, (shift + end) / speed), near & (missed | started & ended)


def _stepped(line, corner, t, sign, guard):
    """Return where lines that go on from t, or back, come as near as `corner`, and if they do."""
    for _ in range(10):  # Newton's steps; a line that needs more nearly touches
        distance, grow = line.at(t)
        # Tangents of a convex function are below it, so that their zeros are never beyond its own.
        outside = (distance - corner > guard) & (sign * grow < 0)
        if not some(outside):
            break
        t = where(outside, t - ratio((distance - corner) * distance, grow), t)
    return t, abs(line.distance(t) - corner) <= 2 * guard


def _meet_discs(centre, axis, p, u, radius, corner):
    """Return `enter` and `leave` of lines against rounded discs, vectors and numbers."""
    return _meet(centre, unit_and_speed(axis)[0], p, u, radius, corner)


def _meet(centre, unit, p, u, radius, corner):
    """Return the same of discs with unit axes."""
    along, speed = unit_and_speed(u)
    q, shift = nearest_offset(centre, along, speed, p, u)
    hit, start, end = _interval(radius, corner, _Passing(radius, q, along, unit))
    enter = where(hit, shift + start / speed, np.inf)
    return enter, where(hit, shift + end / speed, -np.inf)


def _interval(radius, corner, line):
    """Return which lines meet rounded discs, and where they enter and leave, in m."""
    size = radius + corner

    def nears(t):
        return line.growth(t) < 0

    def outside(t):
        return line.square_of_distance(t) > corner * corner

    # The solid is in a ball about its centre, so that a line meets it on this way or not at all.
    fine = FINE * size
    guess = _guessed(line, size)
    looks = [guess + sign * share * size for share in SHARES for sign in (-1, 1)]
    nearest = _halved(nears, -2 * size, 2 * size, looks, fine)
    least = line.distance(nearest)
    touch = least > corner
    if touch is True:
        start = end = nearest
    else:
        first, last = ([side * nearest - chord * size for chord in CHORDS] for side in (1, -1))
        start = _halved(outside, -2 * size, nearest, first, fine)
        end = -_halved(lambda t: outside(-t), -2 * size, -nearest, last, fine)
    # A touch within the guard is one of the solid that is just so much larger.
    start, end = where(touch, nearest, start), where(touch, nearest, end)
    return (least <= corner + GUARD * size) & (size > 0), start, end


def _guessed(line, size):
    """Return about where lines are nearest to discs, by Newton, if it comes near at all."""
    t = 0.0
    for _ in range(GUESSES):
        t = within(t - ratio(line.growth(t), line.bend(t)), -size, size)
    return where(t == t, t, 0.0)


def _halved(before, low, high, looks, fine):
    """Return up to which place `before`, a function of places from `low` to `high`, holds.

    It is found to a length that is `fine`. Places that are looked at first may spare most of the
    halvings.
    """
    for look in looks:
        look = within(look, low, high)
        more = before(look)
        low, high = where(more, look, low), where(more, high, look)
    while some(apart := high - low > fine):
        middle = (low + high) / 2
        more = before(middle)
        # A line that is done stays as it is, however many others aren't.
        low, high = (
            where(apart, where(more, middle, low), low),
            where(apart, where(more, high, middle), high),
        )
    return high
