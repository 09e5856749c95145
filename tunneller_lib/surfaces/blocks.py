"""Many lines against one shape, or each against its own, in blocks that stay in the cache.

Each shape has two ways. The quick way is the plain formula. It holds for lines that are given
near the shape, that are neither nearly parallel nor nearly level with it, and that neither touch
it nor pass it closely. The careful way, with twice the digits where they cancel, takes the rest:
one of a hundred thousand lines that come from anywhere, and any number of those that don't.

Both are written once, `elementwise`: one line takes them in Python's own floats, many in rows of
x, y and z, over which numpy runs fastest. Where loops are `compiled`, both take a loop over lines.
"""

import math
from typing import NamedTuple

import numpy as np

from ..kernels import compiled, line_loops
from ..kernels.elementwise import larger, ratio, smaller, square_root, where
from ..kernels.vectors import differences, scalar_products, vector_products

BLOCK = 16384  # lines treated at once
COMPILED = 65536  # the same by a compiled loop, for which only calls count
PAIRS = 8192  # the same of lines with shapes of their own
CLOSE = 1e-6  # of the shape: so near to a touch the careful way decides
RANGE = 1e20  # sizes up to this and down to its inverse: no product of four leaves the floats
FAR = 6.0  # sizes from which the quick way's roundings come to less than the promise
MISSED = np.inf, -np.inf, True  # what the quick way says of a line beside a shape
# About how long lines take at most without a compiler, in s: one alone, and each of many.
PLAIN_CALL, PLAIN_LINE = 1e-5, 4e-7


def meet_in_blocks(quick, careful, shape, plain, point, direction):
    """Return where lines enter and leave one shape.

    Parameters
    ----------
    quick : function
        Of the shape, points from its start, in m, and directions, as `vectors`; returns `enter`,
        `leave` and where they are `sure`.
    careful : function
        Of the shape, points and directions; returns `enter` and `leave`.
    shape : NamedTuple
        Numbers and vectors of the shape; its `start`, in m, is one of its points.
    plain : bool
        Whether the quick way may decide, see `well_shaped`.
    point, direction : (..., 3) float
        Points of the lines, in m, and their directions.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` for a miss.
    """
    lines = np.broadcast_shapes(point.shape, direction.shape)[:-1]
    one = point.size == 3 == direction.size
    compiled.expect(PLAIN_CALL if one else PLAIN_LINE * math.prod(lines), careful)
    ready = compiled.ready(careful)
    if one and not ready:
        p = point.ravel().tolist()
        u = direction.ravel().tolist()
        sure = False
        if plain:
            enter, leave, sure = quick(shape, differences(p, shape.start), u)
        if not sure:
            enter, leave = careful(shape, p, u)
        found = np.reshape([enter, leave], (2, *lines))
    else:
        found = np.empty((2, *lines))
        meet = _meet_compiled if ready else _meet_rows
        rows = _rows(point, lines), _rows(direction, lines), found.reshape(2, -1)
        meet(quick, careful, shape, plain, *rows)
    found += 0.0  # which of two zeros is the greater numpy says in another way than Python
    return found[0], found[1]


def _rows(vectors, lines):
    """Return vectors as rows (n, 3) of so many lines, or as one row for all."""
    if vectors.size == 3:
        return vectors.reshape(1, 3)
    if vectors.shape[:-1] != lines:  # else read-only: to a compiler a type of its own
        vectors = np.broadcast_to(vectors, (*lines, 3))
    return vectors.reshape(-1, 3)


def _meet_compiled(quick, careful, shape, plain, points, directions, ends):
    """Fill in `enter` and `leave` of lines, the two rows of `ends`, by a compiled loop."""
    rows = np.ascontiguousarray(points), np.ascontiguousarray(directions)
    ways = {"quick": quick, "careful": careful}

    def meet(block):
        some = (row if len(row) == 1 else row[block] for row in rows)
        arguments = shape, plain, *some, ends[0, block], ends[1, block]
        compiled.call(line_loops.meet_lines, *arguments, **ways, **ONE_LINE)

    compiled.each_block(meet, ends.shape[1], COMPILED, careful)


def _meet_rows(quick, careful, shape, plain, points, directions, ends):
    """Fill in the same by whole rows."""
    points = np.broadcast_to(points, (ends.shape[1], 3))
    start = np.array(shape.start)[:, None]
    one = directions[0].tolist() if len(directions) == 1 else None
    with np.errstate(all="ignore"):
        for first in range(0, ends.shape[1], BLOCK):
            block = slice(first, first + BLOCK)
            p = points[block]
            u = one or directions[block].T.copy()
            if not plain:
                ends[:, block] = careful(shape, p.T.copy(), u)
                continue
            enter, leave, sure = quick(shape, np.subtract(p.T, start, order="C"), u)
            rest = np.flatnonzero(~sure)
            if len(rest):
                some = u if one else u[:, rest]
                enter[rest], leave[rest] = careful(shape, p[rest].T.copy(), some)
            ends[:, block] = enter, leave


def meet_one_by_one(careful, vectors, numbers):
    """Return where lines enter and leave shapes, one shape a line.

    Parameters
    ----------
    careful : callable
        Of `vectors` and `numbers`, three rows each, and a row; returns `enter` and `leave`.
    vectors : list of (..., 3) float
        Places of the shapes, the lines' points and directions.
    numbers : list of (...) float
        The shapes' other sizes, in m.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` for a miss.
    """
    parts = [*(v[..., i] for v in vectors for i in range(3)), *numbers]
    shape = np.broadcast_shapes(*(part.shape for part in parts))
    parts = [np.broadcast_to(part, shape).flat if part.size != 1 else part.item() for part in parts]
    found = np.empty((2, int(np.prod(shape))))
    with np.errstate(all="ignore"):
        for first in range(0, found.shape[1], PAIRS):
            block = slice(first, first + PAIRS)
            rows = [part if isinstance(part, float) else part[block] for part in parts]
            triples = [rows[3 * i : 3 * i + 3] for i in range(len(vectors))]
            found[:, block] = np.reshape(careful(*triples, *rows[3 * len(vectors) :]), (2, -1))
    enter, leave = found.reshape(2, *shape)
    return enter[()], leave[()]


def well_shaped(*sizes):
    """Return whether a shape's sizes, in m, let the quick way decide: no needle, no wafer."""
    least, most = min(sizes), max(sizes)
    return least > CLOSE * most and least > 1 / RANGE and most < RANGE


class Passing(NamedTuple):
    """Lines past an axis v.

    Parameters
    ----------
    q, u, n : vectors
        Points from the axis' start, in m, directions, and u x v.
    nn, aside, uu : (...) float
        The products n n, q n and u u.
    size : (...) float
        q^2 u^2 v^2.
    beside : (...) bool
        Which pass beside the endless wall, by more than rounding makes of it.
    """

    q: tuple
    u: tuple
    n: tuple
    nn: np.ndarray
    aside: np.ndarray
    uu: np.ndarray
    size: np.ndarray
    beside: np.ndarray


def past_an_axis(shape, q, u):
    """Return lines as `Passing` the axis of a shape.

    Parameters
    ----------
    shape : NamedTuple
        Its `axis` goes on from its `start`, and `radius` is its widest, in m.
    q, u : vectors
        The lines' points from the start, in m, and their directions.
    """
    n = vector_products(u, shape.axis)
    nn = scalar_products(n, n)
    aside = scalar_products(q, n)
    uu = scalar_products(u, u)
    size = scalar_products(q, q) * (uu * scalar_products(shape.axis, shape.axis))
    wide = (1 + 10 * CLOSE) * shape.radius * shape.radius * nn
    return Passing(q, u, n, nn, aside, uu, size, aside * aside > wide + 1e-23 * size)


def not_beside(passing):
    """Return of lines `Passing` an axis those that don't pass beside its wall."""
    if not isinstance(passing.beside, np.ndarray):
        return passing
    near = np.flatnonzero(~passing.beside)
    return Passing(*(_picked(part, near) for part in passing))


def _picked(part, places):
    """Return a number for all lines, or those of a row or of three rows at some places."""
    if isinstance(part, np.ndarray):
        return part[..., places]
    return [_picked(row, places) for row in part] if isinstance(part, (list, tuple)) else part


def with_those_beside(beside, enter, leave, sure):
    """Return the ends of all lines from those of lines that aren't `beside` a shape.

    The ends are `enter`, `leave` and where they are `sure`.
    """
    hit = enter <= leave
    enter, leave = where(hit, enter, np.inf), where(hit, leave, -np.inf)
    return put_back(beside, enter, leave, sure)


def put_back(beside, enter, leave, sure):
    """Return `enter`, `leave` and `sure` of all lines; those `beside` are missed for sure."""
    if not isinstance(beside, np.ndarray):
        return enter, leave, sure
    near = np.flatnonzero(~beside)
    found = np.full(beside.shape, np.inf), np.full(beside.shape, -np.inf), beside.copy()
    for all_lines, those in zip(found, (enter, leave, sure), strict=True):
        all_lines[near] = those
    return found


def _the_same(passing):
    """Return one line, which passes near an axis."""
    return passing


def _ends(beside, enter, leave, sure):
    """Return the ends of one line, which isn't beside."""
    return enter, leave, sure


# What the formulas call in a compiled loop, which has one line at a time.
ONE_LINE = {**line_loops.FOR_LINES, "not_beside": _the_same, "put_back": _ends}


class Nearest(NamedTuple):
    """Lines where they are nearest to an axis v.

    Parameters
    ----------
    nn, uu, vv, qv, uv : (...) float
        Products of vectors as in `Passing`: n n, u u, v v, q v and u v.
    middle : (...) float
        The line's parameter there.
    aside : (...) float
        The product q n.
    room : (...) float
        Radius^2 less the squared distance, times nn.
    half : (...) float
        The parameter from the middle to an endless wall.
    sound : (...) bool
        Where the line passes near enough, and is no tangent, for the quick way.
    """

    nn: np.ndarray
    uu: np.ndarray
    vv: np.ndarray
    qv: np.ndarray
    uv: np.ndarray
    middle: np.ndarray
    aside: np.ndarray
    room: np.ndarray
    half: np.ndarray
    sound: np.ndarray


def nearest_to_axis(shape, passing):
    """Return lines where they are `Nearest` to the axis of a shape."""
    q, u, n, nn, aside, uu, size, _ = passing
    v = shape.axis
    radius = shape.radius
    vv, qv, uv = scalar_products(v, v), scalar_products(q, v), scalar_products(u, v)
    middle = ratio(-scalar_products(vector_products(q, v), n), nn)
    room = radius * radius * nn - aside * aside
    half = ratio(square_root(room * vv), nn)
    # Where the line's given point is near and its angle to the axis not small, and no tangent.
    enough = size <= FAR * FAR * nn * (radius * radius + nn / uu)
    enough = enough & (uu < RANGE * RANGE) & (uu > 1 / RANGE / RANGE)
    sound = enough & (room > CLOSE * radius * radius * nn)
    return Nearest(nn, uu, vv, qv, uv, middle, aside, room, half, sound)


def share_of_axis(lines):
    """Return which share of the axis, from its start, is nearest to lines."""
    return (lines.qv + lines.uv * lines.middle) / lines.vv


def between_planes(lines):
    """Return where lines enter and leave the slab between an axis' ends, and where it's sure."""
    at_start, at_end = ratio(-lines.qv, lines.uv), ratio(lines.vv - lines.qv, lines.uv)
    steep = lines.uv * lines.uv > CLOSE * CLOSE * lines.uu * lines.vv
    return smaller(at_start, at_end), larger(at_start, at_end), steep
