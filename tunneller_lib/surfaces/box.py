"""A box in any pose, and where lines meet it."""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Directions, Point, Points, checked, sizes
from ..kernels.elementwise import larger, ratio, scaled, smaller, where, within
from ..kernels.exact import accurate_products, norm
from ..kernels.vectors import (
    differences,
    either,
    lengths,
    multiples,
    near_one,
    products_with_each,
    scalar_products,
    shares,
    unit_and_speed,
)
from .blocks import meet_in_blocks
from .rod_interval import GUARD, nearest_offset
from .solid import Solid

SQUARE = 64 * np.finfo(float).eps  # the greatest cosine of edges perpendicular but for rounding


class _Numbers(NamedTuple):
    """A box in numbers: a corner, unit normals of its faces, half its widths, its diagonal."""

    start: tuple
    normals: tuple
    half: tuple
    size: float


def _carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a box."""
    along, speed = unit_and_speed(u)
    q, shift = nearest_offset(shape.start, along, speed, p, u)
    # Across each pair of faces: where the line is, counted from the middle, and how fast it goes.
    at = differences(products_with_each(shape.normals, q), shape.half)
    pace = products_with_each(shape.normals, along)
    hit, enter, leave = box_interval(shape.half, shape.size, at, pace)
    enter = where(hit, shift + enter / speed, np.inf)
    return enter, where(hit, shift + leave / speed, -np.inf)


def box_interval(half, size, at, pace):
    """Return where lines are inside boxes, in m along the lines from their given points.

    Parameters
    ----------
    half : vectors
        Half widths, in m.
    size : (...) float
        Of the boxes, in m; the guard is in proportion to it.
    at, pace : vectors
        The points' places across the faces, counted from the middle, in m, and how fast they grow
        along the lines.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the box.
    enter, leave : (...) float
        In m; meaningless where the line misses.
    """
    guard = GUARD * size
    x = _across(guard, half[0], size, at[0], pace[0])
    y = _across(guard, half[1], size, at[1], pace[1])
    z = _across(guard, half[2], size, at[2], pace[2])
    # By how much the faces must move outwards until the line is in two slabs at once: seen along
    # the line, its distance from a side of the box's shadow.
    short = larger(larger(_short(x, y), _short(y, z)), _short(z, x))
    # A line that passes within the guard is taken to meet the box that is larger by just so much.
    more = larger(short, 0.0)
    x, y, z = _slab(x, more), _slab(y, more), _slab(z, more)
    enter = larger(larger(x[1], y[1]), z[1])
    leave = smaller(smaller(x[2], y[2]), z[2])
    # At a touch rounding may put `leave` before `enter`. Then one point is returned, which is moved
    # into each slab: into that of the steepest faces last, for they place it best.
    touch = enter
    for _, first, last in _by_pace(x, y, z):
        touch = within(touch, first, last)
    crossed = leave < enter
    return short <= guard, where(crossed, touch, enter), where(crossed, touch, leave)


def _across(guard, half, size, at, pace):
    """Return half the width between two faces, and the place and pace of lines across them.

    A line so level with the faces that it moves across by less than the guard along the whole box
    gets no pace: it stays between them, or outside.
    """
    # Lines that go down are mirrored, so that all lines go up.
    at, pace = where(pace < 0, -at, at), abs(pace)
    return half, at, where(pace * size <= guard, 0.0, pace)


def _short(one, other):
    """Return how far lines pass beside the corners between two pairs of faces."""
    half, at, pace = one
    other_half, other_at, other_pace = other
    # Along the line the slabs are two intervals. The gap between these, times both paces, falls by
    # the sum of the paces for each unit by which all faces move outwards.
    both = pace + other_pace
    gap = abs(at * other_pace - other_at * pace) - half * other_pace - other_half * pace
    return where(both > 0, ratio(gap, both), -np.inf)


def _slab(across, more):
    """Return the pace of lines across two faces, and where they are between them.

    The faces are moved outwards by `more`.
    """
    half, at, pace = across
    half = half + more
    level = pace == 0
    first, last = ratio(-half - at, pace), ratio(half - at, pace)
    return pace, where(level, -np.inf, first), where(level, np.inf, last)


def _by_pace(one, other, third):
    """Return three slabs by ascending pace, which is the first number of each."""
    one, other = _in_order(one, other)
    other, third = _in_order(other, third)
    one, other = _in_order(one, other)
    return one, other, third


def _in_order(one, other):
    """Return two slabs by ascending pace."""
    swap = one[0] > other[0]
    return either(swap, other, one), either(swap, one, other)


@dataclass(frozen=True)
@checked
class Box(Solid):
    """A box in any pose, its surface included.

    Parameters
    ----------
    corner : (3,) float
        In m.
    x, y, z : (3,) float
        Edges from there, in m, perpendicular to each other within rounding.

    Raises
    ------
    ValueError
        If one of them isn't one finite point, an edge is zero or outside the range that `Rod`
        allows, or two edges aren't perpendicular.
    """

    corner: Point
    x: Point
    y: Point
    z: Point

    def __post_init__(self):
        edges = self.x, self.y, self.z
        for edge in edges:
            length = np.abs(edge).max()
            sizes("x, y, z", length)
            if not length > 0:
                raise ValueError("x, y, z: must not be zero; got an edge that is.")
        # With edges that lean the faces would lie elsewhere than the normals, made of edges, say.
        units = [unit_and_speed(edge)[0] for edge in edges]
        cosine = max(abs(scalar_products(units[i - 1], units[i])) for i in range(3))
        if cosine > SQUARE:
            raise ValueError(
                f"x, y, z: must be perpendicular to each other; got a cosine of {cosine:.2g}."
            )

    @functools.cached_property
    def _numbers(self):
        """Return the box in numbers, made once, for a box often meets many lines one by one."""
        # Near 1, products of three edges are in range whatever the size of the box.
        edges = [near_one(edge) for edge in (self.x, self.y, self.z)]
        normals = []
        wide = []
        for i in range(3):
            edge, power = edges[i]
            # The normal is the product of the two edges that lie in the face; the third edge is
            # perpendicular to it only but for rounding.
            normal = accurate_products(edges[i - 2][0], edges[i - 1][0])
            normal = shares(normal, lengths(normal))
            width = scalar_products(normal, edge)
            # It points away from the corner, whether the edges are right- or left-handed.
            normals.append(multiples(math.copysign(1.0, width), normal))
            wide.append(scaled(abs(width), power))
        return _Numbers(self.corner, tuple(normals), shares(wide, 2), lengths(wide))

    @property
    def hull(self):
        """Return the box's corners, as `Solid` says: balls without a radius."""
        corners = [
            np.add(np.add(x, y), z)
            for x in (np.zeros(3), self.x)
            for y in (np.zeros(3), self.y)
            for z in (np.zeros(3), self.z)
        ]
        return np.array(self.corner), [(corner, None, 0.0) for corner in corners]

    @property
    def capsule(self):
        """Return the middle (3,), twice, and the radius of a ball about the box, in m.

        Examples
        --------
        >>> middle, _, radius = Box((0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 1)).capsule
        >>> middle.tolist(), round(radius, 6)
        ([1.0, 1.0, 0.5], 1.5)
        """
        half = np.add(np.add(self.x, self.y), self.z) / 2
        # A little more than half of the diagonal, for the edges are square only but for rounding.
        return self.corner + half, self.corner + half, float(norm(half)) * (1 + 1e-9)

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the box.

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
        A line meets the box where it is between three pairs of planes at once. Whether it ever is,
        is decided by how far the faces would have to move for that, against one guard, so that a
        line through an edge or a corner isn't lost. The answer is that of a box whose faces are off
        by at most 64 eps of its diagonal. Along the line each end may be off by another 16 eps, of
        the diagonal or of the ends' greater distance from the given point. All this holds while
        that point is at most 1e15 diagonals away.

        Examples
        --------
        >>> enter, leave = Box((0, 0, 0), (4, 3, 0), (-3, 4, 0), (0, 0, 5)).meet_line(
        ...     (0, 0, 9), (0, 0, -1)
        ... )
        >>> float(enter), float(leave)
        (4.0, 9.0)
        """
        return meet_in_blocks(_carefully, self._numbers, point, direction)
