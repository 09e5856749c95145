"""A box in any pose against lines."""

import functools
from dataclasses import dataclass

import numpy as np

from ..arguments import Directions, Point, Points, checked, sizes
from ..elementwise import larger, ratio, scaled, smaller, some, square_root, where, within
from ..exact import accurate_products
from .blocks import CLOSE, FAR, RANGE, meet_in_blocks, meet_one_by_one, unsure, well_shaped
from .rod_interval import GUARD, nearest_offset
from .vectors import lengths, near_one, scalar_products, shares, unit_and_speed

SQUARE = 64 * np.finfo(float).eps  # cosines of edges that are perpendicular but for rounding


@checked
def meet_boxes(
    corner: Points, x: Points, y: Points, z: Points, point: Points, direction: Directions
):
    """Return where lines enter and leave boxes, one box a line: `Box.meet_line` of many.

    Parameters
    ----------
    corner : (..., 3) float
        In m.
    x, y, z : (..., 3) float
        Edges from there, in m, not zero and perpendicular to each other.
    point, direction : (..., 3) float
        One point of each line, in m, and its direction, not zero.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

    Raises
    ------
    ValueError
        As by `Box` and `Box.meet_line`.

    Examples
    --------
    >>> edges = (1, 0, 0), (0, 2, 0), (0, 0, 3)
    >>> enter, leave = meet_boxes((0, 0, 0), *edges, [(0.5, 1, -1), (2, 1, -1)], (0, 0, 1))
    >>> enter, leave
    (array([ 1., inf]), array([  4., -inf]))
    """
    return meet_one_by_one(_meet_edges, [corner, x, y, z, point, direction], [])


def _meet_edges(corner, x, y, z, p, u):
    """Return `enter` and `leave` of lines against boxes, all as vectors."""
    return _meet(corner, *_faces(x, y, z), p, u)


def _meet(corner, normals, wide, p, u):
    """Return `enter` and `leave` of lines against boxes with such faces."""
    along, speed = unit_and_speed(u)
    q, shift = nearest_offset(corner, along, speed, p, u)
    # Across each pair of faces: where the line is, from the middle, and how fast it goes.
    half = [w / 2 for w in wide]
    at = [scalar_products(normal, q) - h for normal, h in zip(normals, half, strict=True)]
    pace = [scalar_products(normal, along) for normal in normals]
    hit, enter, leave = box_interval(half, lengths(wide), at, pace)
    enter = where(hit, shift + enter / speed, np.inf)
    return enter, where(hit, shift + leave / speed, -np.inf)


def box_interval(half, size, at, pace):
    """Return where lines are inside boxes, along the lines from their given points.

    Parameters
    ----------
    half : vectors
        Half widths, in m.
    size : (...) float
        Of the boxes, in m, by which the guard counts.
    at, pace : vectors
        Places of the points across the faces, from the middle, in m, and how these grow along
        the lines.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the box.
    enter, leave : (...) float
        In m; meaningless where the line misses.
    """
    guard = GUARD * size
    at = [where(v < 0, -x, x) for x, v in zip(at, pace, strict=True)]
    pace = [abs(v) for v in pace]
    # A line that runs level with two faces, within the guard over the whole box, stays between.
    level = [v * size <= guard for v in pace]
    pace = [where(flat, 0.0, v) for flat, v in zip(level, pace, strict=True)]
    # By how much the faces must move outwards until the line meets both of two slabs at once:
    # seen along the line, its distance from a side of the box's shadow.
    short = -np.inf
    for i, j in ((0, 1), (1, 2), (2, 0)):
        both = pace[i] + pace[j]
        gap = abs(at[i] * pace[j] - at[j] * pace[i]) - half[i] * pace[j] - half[j] * pace[i]
        short = larger(short, where(both > 0, ratio(gap, both), -np.inf))
    # A touch is one of the box that is just so much larger.
    half = [h + larger(short, 0.0) for h in half]
    slabs = []
    for h, x, v, flat in zip(half, at, pace, level, strict=True):
        first, last = ratio(-h - x, v), ratio(h - x, v)
        slabs.append((v, where(flat, -np.inf, first), where(flat, np.inf, last)))
    enter = larger(larger(slabs[0][1], slabs[1][1]), slabs[2][1])
    leave = smaller(smaller(slabs[0][2], slabs[1][2]), slabs[2][2])
    # Rounding may part its two ends: then the point of the slabs, last that of the steepest faces,
    # which place it best.
    touch = enter
    for _, first, last in _by_pace(*slabs):
        touch = within(touch, first, last)
    crossed = leave < enter
    return short <= guard, where(crossed, touch, enter), where(crossed, touch, leave)


def _by_pace(one, other, third):
    """Return three slabs by ascending pace, which is the first number of each."""
    one, other = _in_order(one, other)
    other, third = _in_order(other, third)
    one, other = _in_order(one, other)
    return one, other, third


def _in_order(one, other):
    swap = one[0] > other[0]
    pairs = list(zip(one, other, strict=True))
    return [where(swap, b, a) for a, b in pairs], [where(swap, a, b) for a, b in pairs]


def _quickly(normals, half, size, q, u):
    """Return `enter`, `leave` and where they are sure of lines from the corner."""
    reach = FAR * size
    enter, leave, sure = -np.inf, np.inf, scalar_products(q, q) <= reach * reach
    speed = square_root(scalar_products(u, u))
    sure = sure & (speed < RANGE) & (speed > 1 / RANGE)
    for normal, wide in zip(normals, half, strict=True):
        at, pace = scalar_products(normal, q) - wide, scalar_products(normal, u)
        middle, reach = ratio(-at, pace), ratio(wide, abs(pace))
        level = abs(pace) <= CLOSE * speed
        if some(level):
            # Such a line is between the faces all along the box, or nowhere, unless it's close.
            middle = where(level, 0.0, middle)
            reach = where(level, where(abs(at) < wide, np.inf, -np.inf), reach)
            close = abs(abs(at) - wide) <= 10 * CLOSE * size
            sure = where(level & close, False, sure)
        enter, leave = larger(enter, middle - reach), smaller(leave, middle + reach)
    sure = sure & (abs(leave - enter) * speed > CLOSE * size)
    hit = enter <= leave
    return where(hit, enter, np.inf), where(hit, leave, -np.inf), sure


def _check_edges(x, y, z):
    """Raise ValueError unless edges, vectors in m, are sound and perpendicular to each other."""
    edges = x, y, z
    for edge in edges:
        length = np.abs(edge).max(axis=0)
        sizes("x, y, z", length)
        if not np.all(length > 0):
            raise ValueError("x, y, z: must not be zero; got an edge that is.")
    units = [unit_and_speed(edge)[0] for edge in edges]
    for first, second in ((0, 1), (1, 2), (2, 0)):
        cosine = np.max(np.abs(scalar_products(units[first], units[second])), initial=0)
        if cosine > SQUARE:
            raise ValueError(
                f"x, y, z: must be perpendicular to each other; got a cosine of {cosine:.2g}."
            )


def _faces(x, y, z):
    """Return the unit normals of boxes' faces, and how far opposite faces are apart, as vectors."""
    _check_edges(x, y, z)
    edges = [near_one(edge) for edge in (x, y, z)]
    normals, wide = [], []
    for i in range(3):
        edge, power = edges[i]
        normal = accurate_products(edges[i - 2][0], edges[i - 1][0])
        normal = shares(normal, lengths(normal))
        width = scalar_products(normal, edge)
        # Outwards from the corner, whichever hand the edges are of.
        normals.append([where(width < 0, -part, part) for part in normal])
        wide.append(scaled(abs(width), power))
    return normals, wide


@functools.lru_cache
def _faces_of(x, y, z):
    """Return the same of one box, whose edges are tuples: it often meets many lines one by one."""
    return _faces(x, y, z)


@dataclass(frozen=True)
@checked
class Box:
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
        _faces(self.x, self.y, self.z)

    @property
    def faces(self):
        """Return the corners (6, 4, 3) of its faces, in m, in order round each."""
        corner, *edges = np.array([self.corner, self.x, self.y, self.z])
        x, y, z = edges
        found = []
        for across, first, second in ((x, y, z), (y, z, x), (z, x, y)):
            for start in (corner, corner + across):
                found.append([start, start + first, start + first + second, start + second])
        return np.array(found)

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
        A line meets the box where it's between three pairs of planes at once. Whether it does is
        decided by how far the faces would have to move, with one guard, so that a line through
        an edge or a corner isn't lost. The answer is that of a box whose faces are off by at most
        64 eps of its diagonal.

        Examples
        --------
        >>> enter, leave = Box((0, 0, 0), (4, 3, 0), (-3, 4, 0), (0, 0, 5)).meet_line(
        ...     (0, 0, 9), (0, 0, -1)
        ... )
        >>> float(enter), float(leave)
        (4.0, 9.0)
        """
        normals, wide = _faces_of(self.x, self.y, self.z)
        half, size = [w / 2 for w in wide], lengths(wide)

        def careful(p, u):
            return _meet(self.corner, normals, wide, p, u)

        def quick(q, u):
            return _quickly(normals, half, size, q, u)

        if not well_shaped(*wide):
            quick = unsure
        return meet_in_blocks(quick, careful, self.corner, point, direction)
