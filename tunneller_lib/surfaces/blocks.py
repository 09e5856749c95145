"""Many lines against one shape, in blocks that stay in the cache.

Each shape has two ways. The quick way is the plain formula. It holds for lines that are given
near the shape, that are neither nearly parallel nor nearly level with it, and that neither touch
it nor pass it closely. The careful way, with twice the digits where they cancel, takes the rest:
one of a hundred thousand lines that come from anywhere, and any number of those that don't.
"""

import numpy as np

BLOCK = 16384  # lines treated at once
CLOSE = 1e-6  # of the shape: so near to a touch the careful way decides
RANGE = 1e20  # sizes up to this and down to its inverse: no product of four leaves the floats
FAR = 6.0  # sizes from which the quick way's roundings come to less than the promise


def meet_in_blocks(quick, careful, start, point, direction):
    """Return where lines enter and leave one shape.

    Parameters
    ----------
    quick : callable
        Of q and u (3, n), points from `start`, in m, and directions; returns `enter`, `leave`
        and where they are `sure` (n,). Directions may be (3, 1); of one line both are (3,).
    careful : callable
        Of points and directions (k, 3); returns `enter` and `leave` (k,).
    start : (3,) float
        A point of the shape, in m.
    point, direction : (..., 3) float
        Points of the lines, in m, and their directions.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` for a miss.
    """
    if point.ndim == 1 == direction.ndim:
        # One line: the same formulas with numbers in the place of rows, ten times as fast.
        with np.errstate(all="ignore"):
            enter, leave, sure = quick(point - start, direction)
        return (enter[()], leave[()]) if sure else careful(point, direction)
    shape = np.broadcast_shapes(point.shape, direction.shape)
    rows = np.broadcast_to(point, shape).reshape(-1, 3)
    one = direction.size == 3
    turns = direction.reshape(1, 3) if one else np.broadcast_to(direction, shape).reshape(-1, 3)
    found = np.empty((2, len(rows)))
    for first in range(0, len(rows), BLOCK):
        block = slice(first, first + BLOCK)
        p = rows[block]
        u = turns if one else turns[block]
        # Rows of x, y and z, over which numpy runs fastest.
        q = np.subtract(p.T, start[:, None], order="C")
        with np.errstate(all="ignore"):
            enter, leave, sure = quick(q, u.T if one else u.T.copy())
        rest = np.flatnonzero(~sure)
        if len(rest):
            enter[rest], leave[rest] = careful(p[rest], u if one else u[rest])
        found[:, block] = enter, leave
    enter, leave = found.reshape(2, *shape[:-1])
    return enter[()], leave[()]


def scalar_products(a, b):
    """Return scalar products of vectors (3, ...) along the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def vector_products(a, b):
    """Return the components of vector products of vectors (3, ...)."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def well_shaped(*sizes):
    """Return whether a shape's sizes, in m, let the quick way decide: no needle, no wafer."""
    least, most = min(sizes), max(sizes)
    return least > CLOSE * most and least > 1 / RANGE and most < RANGE


def unsure(q, u):
    """Return that nothing is sure: the quick way of a shape that isn't `well_shaped`."""
    del u
    return np.empty(q.shape[1:]), np.empty(q.shape[1:]), np.zeros(q.shape[1:], dtype=bool)


def about_an_axis(v, radius, inside, q, u):
    """Return `enter`, `leave` and `sure` (n,) of lines against a shape about an axis.

    Parameters
    ----------
    v : (3,) float
        The axis from its start on, in m.
    radius : float
        The widest of the shape, in m.
    inside : callable
        Of a `Nearest`: returns `enter`, `leave` and `sure`.
    q, u : (3, n) or (3,) float
        The lines' points from the axis' start, in m, and their directions.
    """
    n = vector_products(u, v)
    nn, aside = scalar_products(n, n), scalar_products(q, n)
    uu, size = scalar_products(u, u), scalar_products(q, q)
    size = size * (uu * scalar_products(v, v))
    # Most lines pass beside the endless wall, by more than what rounding makes of it.
    beside = aside * aside > (1 + 10 * CLOSE) * radius**2 * nn + 1e-23 * size
    if q.ndim == 1:
        if beside:
            return np.float64(np.inf), np.float64(-np.inf), True
        return _met(inside, Nearest(v, radius, q, u, n, nn, aside, uu, size))
    near = ~beside
    enter = np.full(near.shape, np.inf)
    leave = np.full(near.shape, -np.inf)
    sure = ~near
    near = np.flatnonzero(near)
    if len(near):
        take = [x if np.shape(x)[-1:] == (1,) != enter.shape else x[..., near]
                for x in (q, u, np.stack(n), nn, aside, uu, size)]  # fmt: skip
        enter[near], leave[near], sure[near] = _met(inside, Nearest(v, radius, *take))
    return enter, leave, sure


def _met(inside, lines):
    """Return `enter`, `leave` and `sure` of lines that pass an endless wall inside."""
    first, last, certain = inside(lines)
    hit = first <= last
    return np.where(hit, first, np.inf), np.where(hit, last, -np.inf), certain & lines.sound


class Nearest:
    """Lines where they are nearest to an axis v, as arrays (n,).

    `middle` is the line's parameter there, `share` the axis's; `room` is radius^2 less the
    squared distance, times nn; `half` is the parameter from the middle to an endless wall.
    """

    def __init__(self, v, radius, q, u, n, nn, aside, uu, size):
        self.radius, self.nn, self.uu = radius, nn, uu
        self.vv = scalar_products(v, v)
        self.qv, self.uv = scalar_products(q, v), scalar_products(u, v)
        self.middle = -scalar_products(vector_products(q, v), n) / nn
        self.aside2 = aside * aside / nn
        self.room = radius**2 * nn - aside * aside
        self.half = np.sqrt(self.room * self.vv) / nn
        # Where the line's given point is near and its angle to the axis not small, and no tangent.
        enough = size <= FAR**2 * nn * (radius**2 + nn / uu)
        enough = enough & (uu < RANGE**2) & (uu > RANGE**-2)
        self.sound = enough & (self.room > CLOSE * radius**2 * nn)

    @property
    def share(self):
        """Return the share of the axis that is nearest to each line."""
        return (self.qv + self.uv * self.middle) / self.vv

    def planes(self):
        """Return where lines enter and leave the slab between the axis' ends, and where sure."""
        at_start, at_end = -self.qv / self.uv, (self.vv - self.qv) / self.uv
        steep = self.uv**2 > CLOSE**2 * self.uu * self.vv
        return np.minimum(at_start, at_end), np.maximum(at_start, at_end), steep
