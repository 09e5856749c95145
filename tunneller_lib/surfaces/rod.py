"""A finite cylinder, flat or round at its ends, against lines: Line and finite cylinder."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..arguments import Directions, Length0, Point, Points, Radii, checked, rule_of, sizes
from ..kernels.elementwise import larger, ratio, smaller, square_root, where, within
from ..kernels.exact import cross, dot, norm
from ..kernels.vectors import differences, lengths
from .blocks import (
    CLOSE,
    MISSED,
    between_planes,
    meet_in_blocks,
    meet_one_by_one,
    nearest_to_axis,
    not_beside,
    past_an_axis,
    share_of_axis,
    well_shaped,
    with_those_beside,
)
from .rod_interval import GUARD, flat_interval, frame, nearest_point, round_interval


@checked
def meet_rods(
    a: Points,
    b: Points,
    radius: Radii,
    point: Points,
    direction: Directions,
    *,
    ends: Literal["flat", "round"] = "flat",
):
    """Return where lines enter and leave rods, one rod a line: `Rod.meet_line` of many.

    Parameters
    ----------
    a, b : (..., 3) float
        Ends of the axes, in m.
    radius : (...) float
        In m, zero or above.
    point, direction : (..., 3) float
        One point of each line, in m, and its direction, not zero.
    ends : {"flat", "round"}
        Discs, or half balls about a and b.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

    Raises
    ------
    ValueError
        As by `Rod` and `Rod.meet_line`.

    Examples
    --------
    >>> enter, leave = meet_rods((0, 0, 0), (9, 0, 0), [1, 2, 3], (4, 2, 0), (0, 0, 1))
    >>> enter.round(3), leave.round(3)
    (array([   inf,  0.   , -2.236]), array([ -inf, 0.   , 2.236]))
    """
    sizes("b - a", np.abs(b - a).max(axis=-1))
    careful = _meet_capsules if ends == "round" else _meet_flat
    return meet_one_by_one(careful, [a, b, point, direction], [radius])


def check_rods(a, b, radius):
    """Raise ValueError where a radius (...) is negative, or it or an axis has no sound square.

    `a` and `b` (..., 3) are the axes' ends, in m, as the radius.
    """
    rule_of(Radii).check("radius", radius)
    sizes("b - a", np.abs(b - a).max(axis=-1))


def _meet_flat(a, b, p, u, radius):
    """Return `enter` and `leave` of lines against flat rods, vectors and numbers."""
    axis = frame(a, b, u)
    s, m, z, shift = nearest_point(axis, p, u)
    interval = flat_interval(axis.run, axis.rise, axis.length, radius, s, m)
    return _along_lines(axis, z, shift, *interval)


def _meet_capsules(a, b, p, u, radius):
    """Return the same of capsules."""
    axis = frame(a, b, u)
    s, m, z, shift = nearest_point(axis, p, u)
    interval = round_interval(axis.run, axis.rise, axis.length, radius, s, m)
    return _along_lines(axis, z, shift, *interval)


def _along_lines(axis, z, shift, hit, enter, leave):
    """Return `enter` and `leave` as parameters of lines that see an axis so."""
    enter = where(hit, shift + (enter - z) / axis.speed, np.inf)
    return enter, where(hit, shift + (leave - z) / axis.speed, -np.inf)


@dataclass(frozen=True)
@checked
class Rod:
    """A cylinder of finite length, or a capsule, its surface included.

    Parameters
    ----------
    a, b : (3,) float
        Ends of the axis, in m.
    radius : float
        In m, zero or above.
    ends : {"flat", "round"}
        Discs, or half balls about a and b: the sweep of a ball from a to b.

    Raises
    ------
    ValueError
        If an end isn't one finite point, the radius is negative, `ends` is another word, or a
        number is too small or too great for its square: radius and length must be 0 or from 1e-100
        to 1e100, and no coordinate above that.

    Notes
    -----
    Line and finite cylinder. A flat rod without length is empty, a round one is a ball. With
    radius 0 it's the segment.
    """

    a: Point
    b: Point
    radius: Length0
    ends: Literal["flat", "round"] = "flat"

    def __post_init__(self):
        sizes("b - a", np.abs(self.axis).max())

    @property
    def axis(self):
        """Return the vector (3,) from a to b, in m."""
        return np.subtract(self.b, self.a)

    @property
    def length(self):
        """Return the length of the axis, in m."""
        return float(norm(self.axis))

    @checked
    def contains(self, points: Points):
        """Return whether points (..., 3), in m, are inside or, within rounding, on the surface.

        Examples
        --------
        >>> Rod((0, 0, 0), (4, 0, 0), 1).contains([(4, 0, 1), (4.5, 0, 0)])
        array([ True, False])
        """
        q = points - self.a
        v = self.axis
        length = self.length
        if length == 0:
            return (norm(q) <= self.radius * (1 + GUARD)) & (self.ends == "round")
        guard = GUARD * (self.radius + length)
        along = dot(q, v) / length
        off = norm(cross(q, np.broadcast_to(v, q.shape))) / length
        beyond = np.maximum(np.maximum(-along, along - length), 0)
        if self.ends == "round":
            return np.hypot(beyond, off) <= self.radius + guard
        return (beyond <= guard) & (off <= self.radius + guard)

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the rod.

        Parameters
        ----------
        point : (..., 3) float
            One point of each line, in m.
        direction : (..., 3) float
            Direction of each line, of any length but zero; one (3,) for all will do.

        Returns
        -------
        enter, leave : (...) float
            The line is inside where ``enter <= t <= leave``, in lengths of the direction; for a
            line that misses ``inf`` and ``-inf``, an empty interval.

        Raises
        ------
        ValueError
            If a direction is zero, or a number isn't finite or too great or small for its square.

        Notes
        -----
        Line and finite cylinder, "Treating the line as a point within a 2D shape", with the
        sign of its first miss condition corrected and the ellipses' caps included. The answer is
        that of a rod whose surface is off by at most 64 eps (radius + run), with run the length
        of the axis as the line sees it: a line that touches the rod is never missed. Along the
        line each end may be off by another 16 eps, of radius + length or of the greater distance
        of the ends from the given point. All this holds while that point is at most
        1e15 (radius + run) from either end of the axis, wherever the origin is; beyond, roundings
        of the way to the rod count. What has no size for the line, a point or a segment along it,
        is met where no rounding is in the way.

        Examples
        --------
        >>> enter, leave = Rod((0, 0, 0), (90, 0, 120), 25).meet_line((16, 15, 0), (0, 0, 1))
        >>> float(enter), round(float(leave), 3)
        (-12.0, 54.667)
        """
        shape = _Numbers(self.a, self.b, differences(self.b, self.a), self.radius)
        flat = self.ends == "flat"
        careful = _flat_carefully if flat else _round_carefully
        quick = _flat_quickly if flat else _round_quickly
        plain = well_shaped(lengths(shape.axis), shape.radius)
        return meet_in_blocks(quick, careful, shape, plain, point, direction)


class _Numbers(NamedTuple):
    """A rod in numbers: the ends of its axis, the vector from one to the other, the radius."""

    start: tuple
    end: tuple
    axis: tuple
    radius: float


def _flat_carefully(shape, p, u):
    return _meet_flat(shape.start, shape.end, p, u, shape.radius)


def _round_carefully(shape, p, u):
    return _meet_capsules(shape.start, shape.end, p, u, shape.radius)


def _flat_quickly(shape, q, u):
    passing = past_an_axis(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = nearest_to_axis(shape, not_beside(passing))
    return with_those_beside(passing.beside, *_inside_rod(lines))


def _round_quickly(shape, q, u):
    passing = past_an_axis(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = nearest_to_axis(shape, not_beside(passing))
    return with_those_beside(passing.beside, *_inside_capsule(lines, shape.radius))


def _inside_rod(lines):
    """Return where lines enter and leave a rod, and where that is sure."""
    first, last, steep = between_planes(lines)
    enter = larger(first, lines.middle - lines.half)
    leave = smaller(last, lines.middle + lines.half)
    clear = abs(leave - enter) > CLOSE * (lines.half + (last - first))
    return enter, leave, steep & clear & lines.sound


def _inside_capsule(lines, radius):
    """Return where lines enter and leave a capsule, by the balls on which they do."""
    enter, enters = _end_on_ball(lines, radius, -1.0)
    leave, leaves = _end_on_ball(lines, radius, 1.0)
    return enter, leave, enters & leaves & lines.sound


def _end_on_ball(lines, radius, sign):
    """Return where lines enter (-1) or leave (1) that ball of a capsule, and where it's sure."""
    share = share_of_axis(lines)
    step = lines.half * (lines.uv / lines.vv)
    beside = within(share + sign * step, 0.0, 1.0) - share
    room = lines.room - beside * beside * (lines.nn * lines.nn / lines.uu)
    room = ratio(room, lines.nn)
    end = lines.middle + beside * (lines.uv / lines.uu) + sign * square_root(room / lines.uu)
    clear = abs(room) > CLOSE * radius * radius
    return where(room > 0, end, -sign * np.inf), clear
