"""Where solids can touch a straight edge or a plane: points of theirs, each in closed form.

A solid that moves along u until it touches an edge does so at a point of its section by the plane
through the edge along u, where the section's border runs along the edge. That is on one of the
solid's own edges or rims, on one of two rulings of a wall, which are the wall's limb as seen along
the edge, or on the limb of a ball or of a rounded rim. All points are the solid's, so that the
outermost of those over the edge is the answer, and none of them can be too far out.

Vectors are rows of x, y and z, (3, n), from a point of the solid on, in m. A point that isn't there
is NaN.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.exact import accurate_products
from ..kernels.vectors import scalar_products, unit_and_speed, vector_products

HALVINGS = 32  # a chord of so small an arc is off by the square of it, less than a rounding


class Solid:
    """A convex solid, which lines meet by `meet_line`; facets touch it at places of its `outline`.

    Its `capsule`, as ends (3,) and radius, holds it: whatever is outside can't meet it.
    """


class Outline(NamedTuple):
    """A solid's places by their kind, as lists; all from `start`.

    Parameters
    ----------
    start : (3,) float
        A point of the solid, in m.
    size : float
        Of the solid, in m.
    edges : list
        Straight ones, as their ends.
    rims, walls, balls, rounds : list
        (centre, axis, radius); (a, b, radius_a, radius_b); (centre, radius); (centre, axis, radius,
        corner).
    """

    start: np.ndarray
    size: float
    edges: list = ()
    rims: list = ()
    walls: list = ()
    balls: list = ()
    rounds: list = ()


def round_outline(a, b, radius_a, radius_b, *, round_ends=False):
    """Return the `Outline` of a round solid with a wall from a to b, (3,) in m.

    Parameters: the ends a and b, the radii `radius_a` and `radius_b` there, in m, and `round_ends`,
    which says whether balls close the wall, or discs.
    """
    start = np.zeros(3)
    v = np.subtract(b, a)
    size = max(radius_a, radius_b) + float(np.linalg.norm(v))
    walls = [(start, v, radius_a, radius_b)] if np.any(v) else []
    rims = []
    balls = []
    if round_ends:
        balls = [(start, radius_a), (v, radius_b)]
    elif walls:  # a flat rod without length is empty
        unit = np.array(unit_and_speed(v)[0])
        rims = [(start, unit, radius_a), (v, unit, radius_b)]
    return Outline(np.array(a), size, rims=rims, walls=walls, balls=balls)


class SweptPlanes(NamedTuple):
    """Planes through edges along directions, as (3, n) and (n,).

    Parameters
    ----------
    start : (3, n) float
        The edges' first ends.
    u, across : (3, n) float
        Directions, and unit vectors perpendicular to them in the planes, along the edges.
    normal, edge, out : (3, n) float
        Of the planes; along the edges; in the planes perpendicular to the edges.
    width, slope : (n,) float
        How far the edges reach along `across`, and how they rise along u with it.
    guard : (n,) float
        Rounding of places here.
    """

    start: np.ndarray
    u: np.ndarray
    across: np.ndarray
    normal: np.ndarray
    edge: np.ndarray
    out: np.ndarray
    width: np.ndarray
    slope: np.ndarray
    guard: np.ndarray


def swept_planes(start, end, u, guard):
    """Return the `SweptPlanes` of edges.

    Parameters
    ----------
    start, end, u : (3, n) float
        The edges' ends, and the unit vectors along which they move.
    guard : (n,) float
        Rounding of places here.
    """
    way = end - start
    edge, _ = unit_of(way)
    normal, sine = unit_of(accurate_cross(edge, u))
    across = _cross(u, normal)
    width = scalar_products(way, across)
    slope = scalar_products(edge, u) / np.where(sine > 0, sine, 1)
    return SweptPlanes(start, u, across, normal, edge, _cross(normal, edge), width, slope, guard)


def touches_of_edges(solid, cut):
    """Yield points (3, n) of a solid that may be its outermost in the planes `cut`.

    `solid` is an `Outline`, `cut` a `SweptPlanes`.
    """
    for a, b in solid.edges:
        yield _crossing(cut, a[:, None], b[:, None])
    for centre, axis, radius in solid.rims:
        yield from _of_rim(cut, centre[:, None], axis[:, None], radius)
    for wall in solid.walls:
        yield from _of_wall(cut, *wall)
    for centre, radius in solid.balls:
        yield from _of_ball(cut, centre[:, None], radius)
    for centre, axis, radius, corner in solid.rounds:
        for side in (1, -1):
            yield _of_rounded_rim(cut, centre[:, None], axis[:, None], radius, corner, side)


def touches_of_planes(solid, normal):
    """Yield the outermost points (3, n) of a solid along unit vectors (3, n), on either side."""
    corners = [corner for edge in solid.edges for corner in edge]
    for corner in np.unique(corners, axis=0) if corners else ():
        yield np.broadcast_to(corner[:, None], normal.shape)
    rims = [(*rim, 0.0) for rim in solid.rims]
    balls = [(centre, np.zeros(3), 0.0, radius) for centre, radius in solid.balls]
    for centre, axis, radius, corner in (*rims, *balls, *solid.rounds):
        out = radius * _in_disc(normal, axis[:, None]) + corner * normal
        yield centre[:, None] + out
        yield centre[:, None] - out


def _crossing(cut, a, b):
    """Return where segments from a to b (3, n) go through the planes."""
    first = scalar_products(cut.normal, a - cut.start)
    last = scalar_products(cut.normal, b - cut.start)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip(first / (first - last), 0, 1)
    # Within the guard of the plane, or in it all along: then other points will do.
    met = (np.minimum(first, last) <= cut.guard) & (np.maximum(first, last) >= -cut.guard)
    share = np.where(met, np.where(first == last, 0.0, share), np.nan)
    return a + share * (b - a)


def _of_rim(cut, centre, axis, radius):
    """Yield where a circle goes through the planes."""
    away = scalar_products(cut.normal, cut.start - centre)
    chord, sine = unit_of(accurate_cross(axis, cut.normal))
    # A disc that lies in the plane reaches farthest perpendicular to the edge.
    lying = sine * radius <= cut.guard
    chord = np.where(lying, cut.out, chord)
    beside = np.where(lying, 0.0, _cross(chord, axis))
    out = away / np.where(lying, 1.0, sine)
    met = np.abs(away) <= sine * radius + cut.guard
    out = np.clip(out, -radius, radius)
    half = np.where(met, np.sqrt((radius - out) * (radius + out)), np.nan)
    half = np.where(lying & met, radius, half)
    for sign in (1, -1):
        yield centre + out * beside + sign * half * chord


def _of_wall(cut, a, b, start, end):
    """Yield where the two rulings that are a wall's limb, along the edges, meet the planes."""
    v = b - a
    length = np.linalg.norm(v)
    axis = (v / length)[:, None]
    aside, sine = unit_of(accurate_cross(np.broadcast_to(axis, cut.edge.shape), cut.edge))
    toward = _cross(aside, axis)
    # The wall's normal there is perpendicular to the edge: it leans by the wall's slope.
    with np.errstate(divide="ignore", invalid="ignore"):
        lean = (end - start) / length * scalar_products(axis, cut.edge) / sine
    # So steep an edge sees no limb; the upright one of a wall along an axis is infinitely so.
    lean = np.where(np.abs(lean) <= 1, lean, np.nan)
    root = np.sqrt((1 - lean) * (1 + lean))
    for sign in (1, -1):
        radial = lean * toward + sign * root * aside
        yield _crossing(cut, a[:, None] + start * radial, b[:, None] + end * radial)


def _of_ball(cut, centre, radius):
    away = scalar_products(cut.normal, cut.start - centre)
    met = np.abs(away) <= radius + cut.guard
    away = np.clip(away, -radius, radius)
    half = np.where(met, np.sqrt((radius - away) * (radius + away)), np.nan)
    for sign in (1, -1):
        yield centre + away * cut.normal + sign * half * cut.out


def _of_rounded_rim(cut, centre, axis, radius, corner, side):
    """Return where the limb of a rounded disc, on one side along the edges, meets the planes.

    The limb is where the normal is perpendicular to the edge. It goes round from the planes'
    normal to its opposite, and the place along the normal falls all the while.
    """

    def place(normal):
        return centre + radius * _in_disc(normal, axis) + corner * normal

    first, last, middle = cut.normal, -cut.normal, side * cut.out
    ends = [place(first), place(last)]
    away = [scalar_products(cut.normal, end - cut.start) for end in ends]
    met = (away[0] >= -cut.guard) & (away[1] <= cut.guard)
    for _ in range(HALVINGS):
        here = place(middle)
        height = scalar_products(cut.normal, here - cut.start)
        above = height > 0
        first, last = np.where(above, middle, first), np.where(above, last, middle)
        ends = [np.where(above, here, ends[0]), np.where(above, ends[1], here)]
        away = [np.where(above, height, away[0]), np.where(above, away[1], height)]
        middle, _ = unit_of(first + last)
    # On the chord between its ends, which on a flat face are far apart.
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(away[0] > away[1], np.clip(away[0] / (away[0] - away[1]), 0, 1), 0.0)
    return np.where(met, ends[0] + share * (ends[1] - ends[0]), np.nan)


def _in_disc(normal, axis):
    """Return the unit vectors in discs that are nearest to others, or zero for the axis itself."""
    aside, _ = unit_of(accurate_cross(np.broadcast_to(axis, normal.shape), normal))
    return _cross(aside, axis)


def _cross(a, b):
    """Return vector products (3, n) of vectors that are perpendicular, where nothing cancels."""
    return np.stack(np.broadcast_arrays(*vector_products(a, b)))


def unit_of(v):
    """Return vectors (3, n) with length 1, or 0, and their lengths."""
    exponent = np.frexp(np.abs(v).max(axis=0))[1]
    v = np.ldexp(v, -exponent)
    length = np.sqrt(scalar_products(v, v))
    return v / np.where(length > 0, length, 1), np.ldexp(length, exponent)


def accurate_cross(a, b):
    """Return vector products of vectors (3, n), each component to its last digits."""
    return np.stack(accurate_products(a, b))
