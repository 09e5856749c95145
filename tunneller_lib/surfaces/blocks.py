"""Many lines against one shape, or each against its own, in blocks that stay in the cache.

Each shape has two ways. The quick way is the plain formula. It holds for lines that are given
near the shape, that are neither nearly parallel nor nearly level with it, and that neither touch
it nor pass it closely. The careful way, with twice the digits where they cancel, takes the rest:
one of a hundred thousand lines that come from anywhere, and any number of those that don't.

Both are written once, `elementwise`: one line takes them in Python's own floats, many in rows of
x, y and z, over which numpy runs fastest.
"""

import numpy as np

from ..elementwise import larger, ratio, smaller, square_root, where
from .vectors import differences, scalar_products, vector_products

BLOCK = 16384  # lines treated at once
PAIRS = 8192  # the same of lines with shapes of their own
CLOSE = 1e-6  # of the shape: so near to a touch the careful way decides
RANGE = 1e20  # sizes up to this and down to its inverse: no product of four leaves the floats
FAR = 6.0  # sizes from which the quick way's roundings come to less than the promise


def meet_in_blocks(quick, careful, start, point, direction):
    """Return where lines enter and leave one shape.

    Parameters
    ----------
    quick : callable
        Of points from `start`, in m, and directions, as `vectors`; returns `enter`, `leave` and
        where they are `sure`.
    careful : callable
        Of points and directions; returns `enter` and `leave`.
    start : (3,) float
        A point of the shape, in m, three floats.
    point, direction : (..., 3) float
        Points of the lines, in m, and their directions.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` for a miss.
    """
    if point.ndim == 1 == direction.ndim:
        p, u = point.tolist(), direction.tolist()
        enter, leave, sure = quick(differences(p, start), u)
        if not sure:
            enter, leave = careful(p, u)
        return np.float64(enter), np.float64(leave)
    shape = np.broadcast_shapes(point.shape, direction.shape)
    rows = np.broadcast_to(point, shape).reshape(-1, 3)
    one = direction.size == 3
    u = direction.ravel().tolist() if one else None
    turns = None if one else np.broadcast_to(direction, shape).reshape(-1, 3)
    found = np.empty((2, len(rows)))
    with np.errstate(all="ignore"):
        for first in range(0, len(rows), BLOCK):
            block = slice(first, first + BLOCK)
            p = rows[block]
            u = u if one else turns[block].T.copy()
            q = np.subtract(p.T, np.array(start)[:, None], order="C")
            enter, leave, sure = quick(q, u)
            rest = np.flatnonzero(~sure)
            if len(rest):
                enter[rest], leave[rest] = careful(p[rest].T.copy(), u if one else u[:, rest])
            found[:, block] = enter, leave
    enter, leave = found.reshape(2, *shape[:-1])
    return enter, leave


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


def unsure(q, u):
    """Return that nothing is sure: the quick way of a shape that isn't `well_shaped`."""
    del u
    x = q[0]
    return (
        (x, x, False) if isinstance(x, float) else (*np.empty((2, len(x))), np.zeros(len(x), bool))
    )


def about_an_axis(v, radius, inside, q, u):
    """Return `enter`, `leave` and `sure` of lines against a shape about an axis.

    Parameters
    ----------
    v : (3,) float
        The axis from its start on, in m, three floats.
    radius : float
        The widest of the shape, in m.
    inside : callable
        Of a `Nearest`: returns `enter`, `leave` and `sure`.
    q, u : vectors
        The lines' points from the axis' start, in m, and their directions.
    """
    n = vector_products(u, v)
    nn, aside = scalar_products(n, n), scalar_products(q, n)
    uu, size = scalar_products(u, u), scalar_products(q, q)
    size = size * (uu * scalar_products(v, v))
    # Most lines pass beside the endless wall, by more than what rounding makes of it.
    beside = aside * aside > (1 + 10 * CLOSE) * radius * radius * nn + 1e-23 * size
    if beside is True:
        return np.inf, -np.inf, True
    if beside is False:
        return _met(inside, Nearest(v, radius, q, u, n, nn, aside, uu, size))
    enter = np.full(beside.shape, np.inf)
    leave = np.full(beside.shape, -np.inf)
    near = np.flatnonzero(~beside)
    if len(near):

        def picked(part):
            return part[near] if isinstance(part, np.ndarray) else part

        triples = [[picked(part) for part in vector] for vector in (q, u, n)]
        take = [*triples, *map(picked, (nn, aside, uu, size))]
        enter[near], leave[near], beside[near] = _met(inside, Nearest(v, radius, *take))
    return enter, leave, beside


def _met(inside, lines):
    """Return `enter`, `leave` and `sure` of lines that pass an endless wall inside."""
    first, last, certain = inside(lines)
    hit = first <= last
    return where(hit, first, np.inf), where(hit, last, -np.inf), certain & lines.sound


class Nearest:
    """Lines where they are nearest to an axis v.

    `middle` is the line's parameter there, `share` the axis's; `room` is radius^2 less the
    squared distance, times nn; `half` is the parameter from the middle to an endless wall.
    """

    def __init__(self, v, radius, q, u, n, nn, aside, uu, size):
        self.radius, self.nn, self.uu = radius, nn, uu
        self.vv = scalar_products(v, v)
        self.qv, self.uv = scalar_products(q, v), scalar_products(u, v)
        self.middle = ratio(-scalar_products(vector_products(q, v), n), nn)
        self.aside2 = ratio(aside * aside, nn)
        self.room = radius * radius * nn - aside * aside
        self.half = ratio(square_root(self.room * self.vv), nn)
        # Where the line's given point is near and its angle to the axis not small, and no tangent.
        enough = size <= FAR * FAR * nn * (radius * radius + nn / uu)
        enough = enough & (uu < RANGE * RANGE) & (uu > 1 / RANGE / RANGE)
        self.sound = enough & (self.room > CLOSE * radius * radius * nn)

    @property
    def share(self):
        """Return the share of the axis that is nearest to each line."""
        return (self.qv + self.uv * self.middle) / self.vv

    def planes(self):
        """Return where lines enter and leave the slab between the axis' ends, and where sure."""
        at_start, at_end = ratio(-self.qv, self.uv), ratio(self.vv - self.qv, self.uv)
        steep = self.uv * self.uv > CLOSE * CLOSE * self.uu * self.vv
        return smaller(at_start, at_end), larger(at_start, at_end), steep
