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
    one = direction.ndim == 1
    turns = direction if one else np.broadcast_to(direction, (*shape, 3)).reshape(-1, 3)
    found = np.empty((2, len(facets)))
    for first in range(0, len(facets), BLOCK):
        block = slice(first, first + BLOCK)
        found[:, block] = _meet(solid, facets[block], turns if one else turns[block])
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
    """Return `enter` and `leave` (2, n) of facets (n, k, 3) along u (n, 3) or (3,)."""
    n, count, _ = facets.shape
    following = np.roll(np.arange(count), -1)[: count if count > 2 else count - 1]
    edges = np.stack([facets[:, : len(following)], facets[:, following]], axis=2)
    one = u.ndim == 1
    along = u if one else np.repeat(u, len(following), axis=0)
    corners = solid.meet_line(facets, u if one else u[:, None])
    found = [np.reshape(corners, (2, n, count))]
    if count > 1:
        touches = _meet_edges(solid, edges.reshape(-1, 2, 3), along)
        found.append(touches.reshape(2, n, len(following)))
    if count > 2:
        found.append(_meet_faces(solid, facets, u)[..., None])
    enter, leave = np.concatenate(found, axis=-1)
    return enter.min(axis=-1), leave.max(axis=-1)


def _meet_edges(solid, edges, u):
    """Return `enter` and `leave` (2, n) of edges (n, 2, 3), not of their ends, along u (.., 3)."""
    body = solid.outline
    (start, end), along, shift, speed = _nearby(body, edges, u)
    guard = GUARD * (body.size + _reach([start, end]))
    cut = swept_planes(start, end, along, guard)
    found = _nothing(guard)
    for point in touches_of_edges(body, cut):
        way = point - cut.start
        place = scalar_products(way, cut.across)
        over = (place >= -guard) & (place <= cut.width + guard)
        t = scalar_products(way, along) - cut.slope * np.clip(place, 0, cut.width)
        found = _with(found, t, over)
    # An edge along the direction moves in itself: its ends tell all.
    return _in_lengths(found, cut.width > guard, shift, speed)


def _meet_faces(solid, facets, u):
    """Return `enter` and `leave` of facets (n, k, 3), not of their edges, along u (.., 3)."""
    body = solid.outline
    corners, along, shift, speed = _nearby(body, facets, u)
    guard = GUARD * (body.size + _reach(corners))
    sides = [
        swept_planes(a, b, along, guard)
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    ways = [corner - corners[0] for corner in corners[1:]]
    normal = sum(accurate_cross(a, b) for a, b in pairwise(ways))
    normal, length = unit_of(normal)
    facing = scalar_products(normal, along)
    # Seen along the direction it's so narrow that its edges are all of it.
    wide = np.abs(facing) * length > 4 * guard * sum(side.width for side in sides)
    turn = np.sign(facing)
    found = _nothing(guard)
    for point in touches_of_planes(body, normal):
        over = wide
        for side in sides:
            away = scalar_products(side.normal, point - side.start)
            over = over & (-turn * away >= -guard)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = scalar_products(normal, point - corners[0]) / facing
        found = _with(found, t, over)
    return _in_lengths(found, wide, shift, speed)


def _nearby(body, facets, u):
    """Return corners (3, n) moved next to a solid, unit vectors (3, n), and what that took."""
    u = np.broadcast_to(u, facets[:, 0].shape).T
    along, speed = unit_and_speed(u)
    corners = np.moveaxis(facets, 0, -1).copy()
    first, shift = nearest_offset(body.start, along, speed, corners[0], u)
    moved = [np.array(sums(first, differences(corner, corners[0]))) for corner in corners]
    return moved, np.array(along), shift, speed


def _reach(corners):
    return np.max([np.abs(corner).max(axis=0) for corner in corners], axis=0)


def _nothing(guard):
    return np.full(guard.shape, np.inf), np.full(guard.shape, -np.inf)


def _with(found, t, over):
    """Return `enter` and `leave` with places t (n,) that count where they are `over` a facet."""
    enter, leave = found
    return (
        np.where(over, np.minimum(enter, t), enter),
        np.where(over, np.maximum(leave, t), leave),
    )


def _in_lengths(found, sound, shift, speed):
    enter, leave = found
    hit = sound & (enter <= leave)
    return np.array(
        [
            np.where(hit, shift + enter / speed, np.inf),
            np.where(hit, shift + leave / speed, -np.inf),
        ]
    )
