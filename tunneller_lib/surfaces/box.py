"""A box in any pose against lines."""

import functools
from dataclasses import dataclass

import numpy as np

from ..arguments import Directions, Point, Points, checked, sizes
from ..exact import cross, dot, norm
from .blocks import CLOSE, FAR, RANGE, meet_in_blocks, scalar_products, unsure, well_shaped
from .rod_interval import GUARD, near_one, nearest_offset

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
    normals, wide = _faces(x, y, z)
    size = norm(wide)
    along, exponent = near_one(direction)
    speed = norm(along)
    along = along / speed[..., None]
    speed = np.ldexp(speed, exponent)
    q, shift = nearest_offset(corner, along, speed, point, direction)
    # Across each pair of faces: where the line is, from the middle, and how fast it goes.
    half = wide / 2
    at = dot(normals, q[..., None, :]) - half
    pace = np.broadcast_to(dot(normals, along[..., None, :]), at.shape)
    hit, enter, leave = box_interval(half, size, at, pace)
    enter = np.where(hit, shift + enter / speed, np.inf)
    return enter[()], np.where(hit, shift + leave / speed, -np.inf)[()]


def box_interval(half, size, at, pace):
    """Return where lines are inside boxes, along the lines from their given points.

    Parameters
    ----------
    half : (..., 3) float
        Half widths, in m.
    size : (...) float
        Of the boxes, in m, by which the guard counts.
    at, pace : (..., 3) float
        Places of the points across the faces, from the middle, in m, and how these grow along
        the lines.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the box.
    enter, leave : (...) float
        In m; meaningless where the line misses.
    """
    guard = GUARD * size[..., None]
    at, pace = np.where(pace < 0, -at, at), np.abs(pace)
    # A line that runs level with two faces, within the guard over the whole box, stays between.
    level = pace * size[..., None] <= guard
    pace = np.where(level, 0.0, pace)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # By how much the faces must move outwards until the line meets both of two slabs at once:
        # seen along the line, its distance from a side of the box's shadow.
        gap = np.abs(at * _next(pace) - _next(at) * pace)
        gap = (gap - half * _next(pace) - _next(half) * pace) / (pace + _next(pace))
        short = np.fmax.reduce(gap, axis=-1)
        # A touch is one of the box that is just so much larger.
        half = half + np.maximum(short, 0)[..., None]
        first = np.where(level, -np.inf, (-half - at) / pace)
        last = np.where(level, np.inf, (half - at) / pace)
    enter, leave = first.max(axis=-1), last.min(axis=-1)
    # Rounding may part its two ends: then the point of the slabs, last that of the steepest faces,
    # which place it best.
    touch = enter
    order = np.argsort(pace, axis=-1)
    firsts, lasts = (np.take_along_axis(ends, order, axis=-1) for ends in (first, last))
    for i in range(3):
        touch = np.clip(touch, firsts[..., i], lasts[..., i])
    crossed = leave < enter
    hit = short <= guard[..., 0]
    return hit, np.where(crossed, touch, enter), np.where(crossed, touch, leave)


def _quickly(normals, half, size, q, u):
    """Return `enter`, `leave` and where they are sure (n,), of lines (3, n) from the corner."""
    enter, leave, sure = -np.inf, np.inf, scalar_products(q, q) <= (FAR * size) ** 2
    speed = np.sqrt(scalar_products(u, u))
    sure = sure & (speed < RANGE) & (speed > 1 / RANGE)
    for normal, wide in zip(normals, half, strict=True):
        at, pace = scalar_products(normal, q) - wide, scalar_products(normal, u)
        middle, reach = -at / pace, wide / np.abs(pace)
        level = np.abs(pace) <= CLOSE * speed
        if np.any(level):
            # Such a line is between the faces all along the box, or nowhere, unless it's close.
            middle = np.where(level, 0, middle)
            reach = np.where(level, np.where(np.abs(at) < wide, np.inf, -np.inf), reach)
            sure = sure & (~level | (np.abs(np.abs(at) - wide) > 10 * CLOSE * size))
        enter, leave = np.maximum(enter, middle - reach), np.minimum(leave, middle + reach)
    sure = sure & (np.abs(leave - enter) * speed > CLOSE * size)
    hit = enter <= leave
    return np.where(hit, enter, np.inf), np.where(hit, leave, -np.inf), sure


def _next(values):
    return np.roll(values, -1, axis=-1)


def _faces(x, y, z):
    """Return the faces' unit normals (..., 3, 3), and how far opposite faces are apart."""
    edges = np.stack(np.broadcast_arrays(x, y, z), axis=-2)
    length = np.abs(edges).max(axis=-1)
    sizes("x, y, z", length)
    if not np.all(length > 0):
        raise ValueError("x, y, z: must not be zero; got an edge that is.")
    edges, exponent = near_one(edges)
    lengths = norm(edges)
    cosines = np.abs(dot(edges, np.roll(edges, -1, axis=-2)) / (lengths * _next(lengths)))
    if not np.all(cosines <= SQUARE):
        raise ValueError(
            f"x, y, z: must be perpendicular to each other; got a cosine of {cosines.max():.2g}."
        )
    normals = cross(np.roll(edges, -1, axis=-2), np.roll(edges, -2, axis=-2))
    normals = normals / norm(normals)[..., None]
    wide = dot(normals, edges)
    # Outwards from the corner, whichever hand the edges are of.
    return normals * np.sign(wide)[..., None], np.ldexp(np.abs(wide), exponent)


@functools.lru_cache
def _faces_of(x, y, z):
    """Return the same of one box, whose edges are tuples: it often meets many lines one by one."""
    return _faces(*np.array([x, y, z]))


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
        _faces(*np.array([self.x, self.y, self.z]))

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
        corner = np.array(self.corner)
        normals, wide = _faces_of(self.x, self.y, self.z)
        half, size = wide / 2, norm(wide)

        def careful(p, u):
            return meet_boxes.unchecked(corner, *np.array([self.x, self.y, self.z]), p, u)

        def quick(q, u):
            return _quickly(normals, half, size, q, u)

        if not well_shaped(*wide):
            quick = unsure
        return meet_in_blocks(quick, careful, corner, point, direction)
