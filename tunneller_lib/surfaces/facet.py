"""Facets that move along a direction until they touch a solid; a box that comes down on one."""

from itertools import pairwise

import numpy as np

from ..arguments import Array, Corners, Directions, checked
from ..kernels.vectors import differences, scalar_products, sums, unit_and_speed
from .blocks import BLOCK
from .rod_interval import GUARD, nearest_offset
from .touching import (
    Solid,
    accurate_cross,
    swept_planes,
    touches_of_edges,
    touches_of_planes,
    unit_of,
)

UP = np.array([0.0, 0.0, 1.0])

Facets = Array(
    "(..., k, 3) float",
    "m",
    last="x, y, z",
    also=("have a corner each", lambda facets: facets.shape[-2]),
)


@checked
def meet_facets(solid: Solid, facets: Facets, direction: Directions):
    """Return where facets that move along directions first touch and last leave a solid.

    Parameters
    ----------
    solid : Solid
        A `Rod`, `Frustum`, `Box` or `RoundedDisc`, in any pose.
    facets : (..., k, 3) float
        Corners of flat convex polygons, in order, in m: points, edges, triangles, ...
    direction : (..., 3) float
        Along which each moves, of any length but zero.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction: a facet moved by `enter` <= t <= `leave` has points in common
        with the solid; ``inf`` and ``-inf`` where it passes.

    Raises
    ------
    ValueError
        If a direction is zero, or a number isn't finite or too great or small for its square.

    Notes
    -----
    A line is a facet's point that moves, so that this is `Rod.meet_line` grown to facets. Both
    bodies are convex: they first touch at a corner of the facet, or with an edge at a point of
    the solid's limb along that edge, or with the face where the solid reaches farthest along the
    facet's normal. Each has a closed form, but for the rounded rim, which takes a search that
    can't fail. The answer is that of a solid whose surface is off by at most 64 eps of the sum of
    its size, the facet's and the distance at which the facet's first corner passes the solid, and
    along the direction by another 16 eps, of its size or of the way moved, for facets that are
    given at most 1e6 times this sum away. A touch is never missed.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Rod
    >>> triangle = [(-5, -5, 0), (5, -5, 0), (0, 5, 5)]
    >>> enter, leave = meet_facets(Rod((0, 0, 9), (0, 0, 9), 2, ends="round"), triangle, (0, 0, 1))
    >>> round(float(enter), 6), round(float(leave), 6)
    (4.263932, 8.736068)
    """
    shape = np.broadcast_shapes(facets.shape[:-2], direction.shape[:-1])
    corners = facets.shape[-2]
    facets = np.broadcast_to(facets, (*shape, corners, 3)).reshape(-1, corners, 3)
    turns = np.broadcast_to(direction, (*shape, 3)).reshape(-1, 3)
    found = np.empty((2, len(facets)))
    for first in range(0, len(facets), BLOCK):
        block = slice(first, first + BLOCK)
        found[:, block] = _meet(solid, facets[block], turns[block])
    enter, leave = found.reshape(2, *shape)
    return enter[()], leave[()]


@checked
def meet_box(solid: Solid, low: Corners, high: Corners):
    """Return the lowest and highest points of a solid in boxes that are endless along z.

    Parameters
    ----------
    solid : Solid
        A `Rod`, `Frustum`, `Box` or `RoundedDisc`, in any pose.
    low, high : (..., 2) float
        Opposite corners (x, y) of the boxes' sections, in m; low <= high.

    Returns
    -------
    bottom, top : (...) float
        Heights z between which a rectangular cutter over that section touches the solid, in m;
        ``inf`` and ``-inf`` where it doesn't.

    Raises
    ------
    ValueError
        If a corner isn't finite or low > high.

    Notes
    -----
    Line and finite cylinder announces this for a cylinder as its part two, and doesn't give it.
    The section is a facet that moves along z. A `Box` in any pose that moves in any direction
    touches with its faces: take the least `enter` and the greatest `leave` of `meet_facets` of
    ``box.faces``. So each solid meets lines by its `meet_line`, and boxes by this, with one guard.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Rod
    >>> bottom, top = meet_box(Rod((0, 0, 0), (0, 8, 0), 2), (1, 1), (3, 9))
    >>> float(top.round(6)), float(bottom.round(6))
    (1.732051, -1.732051)
    """
    low, high = np.broadcast_arrays(low, high)
    if not np.all(low <= high):
        raise ValueError("low: must not be above high on either axis; got a corner that is.")
    corners = [(low, low), (high, low), (high, high), (low, high)]
    section = np.stack(
        [np.stack([x[..., 0], y[..., 1], np.zeros_like(x[..., 0])], axis=-1) for x, y in corners],
        axis=-2,
    )
    return meet_facets(solid, section, UP)


def _meet(solid, facets, u):
    """Return `enter` and `leave` (2, n) of facets (n, k, 3) along u (n, 3)."""
    n, count, _ = facets.shape
    found = [np.reshape(solid.meet_line(facets, u[:, None]), (2, n, count))]
    if count > 1:
        following = np.roll(np.arange(count), -1)[: count if count > 2 else 1]
        edges = np.stack([facets[:, : len(following)], facets[:, following]], axis=2)
        along = np.repeat(u, len(following), axis=0)
        touches = _meet_edges(solid.outline, edges.reshape(-1, 2, 3), along)
        found.append(touches.reshape(2, n, len(following)))
    if count > 2:
        found.append(_meet_faces(solid.outline, facets, u)[..., None])
    enter, leave = np.concatenate(found, axis=-1)
    return enter.min(axis=-1), leave.max(axis=-1)


def _meet_edges(body, edges, u):
    """Return `enter` and `leave` (2, n) of edges (n, 2, 3), but for their ends, along u (n, 3)."""
    (start, end), along, shift, speed, guard = _nearby(body, edges, u)
    cut = swept_planes(start, end, along, guard)
    times = []
    for point in touches_of_edges(body, cut):
        way = point - cut.start
        place = scalar_products(way, cut.across)
        # An edge along the direction moves in itself: its ends tell all.
        over = (place >= -guard) & (place <= cut.width + guard) & (cut.width > guard)
        t = scalar_products(way, along) - cut.slope * np.clip(place, 0, cut.width)
        times.append(np.where(over, t, np.nan))
    return _first_and_last(times, shift, speed)


def _meet_faces(body, facets, u):
    """Return `enter` and `leave` (2, n) of facets (n, k, 3) but for their edges, along u (n, 3)."""
    corners, along, shift, speed, guard = _nearby(body, facets, u)
    sides = [
        swept_planes(a, b, along, guard)
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    ways = [corner - corners[0] for corner in corners[1:]]
    normal, length = unit_of(sum(accurate_cross(a, b) for a, b in pairwise(ways)))
    facing = scalar_products(normal, along)
    # Seen along the direction it's so narrow that its edges are all of it.
    wide = np.abs(facing) * length > 4 * guard * sum(side.width for side in sides)
    times = []
    for point in touches_of_planes(body, normal):
        over = wide
        for side in sides:
            away = scalar_products(side.normal, point - side.start)
            over = over & (-np.sign(facing) * away >= -guard)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = scalar_products(normal, point - corners[0]) / facing
        times.append(np.where(over, t, np.nan))
    return _first_and_last(times, shift, speed)


def _nearby(body, facets, u):
    """Return facets moved next to a solid, and what that took.

    These are corners (3, n), unit vectors (3, n) along u (n, 3), the parameter by which the facets
    were moved, the lengths of u, and the rounding of places here.
    """
    along, speed = unit_and_speed(u.T)
    corners = np.moveaxis(facets, 0, -1).copy()
    first, shift = nearest_offset(body.start, along, speed, corners[0], u.T)
    moved = [np.array(sums(first, differences(corner, corners[0]))) for corner in corners]
    reach = np.max([np.abs(corner).max(axis=0) for corner in moved], axis=0)
    return moved, np.array(along), shift, speed, GUARD * (body.size + reach)


def _first_and_last(times, shift, speed):
    """Return the least and the greatest (2, n) of times in m, NaN left out, as parameters."""
    times = np.reshape(times, (-1, len(speed)))
    met = ~np.isnan(times)
    enter = times.min(axis=0, where=met, initial=np.inf)
    leave = times.max(axis=0, where=met, initial=-np.inf)
    return np.array([shift + enter / speed, shift + leave / speed])
