"""Many lines against one shape, in blocks that stay in the cache.

Each shape has a careful way, with twice the digits where numbers cancel. A rod has a quick way as
well, by the plain formula. It is sure of lines whose given point is near the rod, which are neither
nearly parallel to its axis nor nearly level with its discs, and which neither touch the rod nor
pass it closely. Of lines between random places it leaves one in a hundred thousand to the careful
way; of lines that a program aims at an edge it may leave all.

Each way is written once, by the functions of `elementwise`. For one line these take Python's own
floats, for many lines rows of x, y and z, over which numpy runs fastest. Where loops are
`compiled`, one calls the same way line by line.
"""

import math

import numpy as np

from ..kernels import compiled, line_loops
from ..kernels.vectors import differences

BLOCK = 16384  # lines treated at once
COMPILED = 65536  # the same by a compiled loop, which has no arrays in between, only calls
# About the longest that lines take without a compiler, in s: one alone, and each of many.
PLAIN_CALL, PLAIN_LINE = 1e-5, 4e-7


def meet_in_blocks(careful, shape, point, direction, *, quick=line_loops.quick, plain=False):
    """Return where lines enter and leave one shape.

    Parameters
    ----------
    careful : function
        Returns `enter` and `leave` for the shape, and for points and directions as `vectors`.
    shape : NamedTuple
        Numbers and vectors of the shape; `start`, in m, is one of the shape's points.
    point, direction : (..., 3) float
        Points of the lines, in m, and their directions.
    quick : function, optional
        Returns `enter`, `leave` and where they are `sure`, for the shape, for points counted from
        its start, in m, and for directions.
    plain : bool
        Whether the quick way may decide for this shape.

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
    # Adding 0.0 turns -0.0 into 0.0: of two zeros Python's `max` and numpy's choose differently.
    found += 0.0
    return found[0], found[1]


def _rows(vectors, lines):
    """Return vectors as rows (n, 3), one for each of the `lines`, or as one row for all of them."""
    if vectors.size == 3:
        return vectors.reshape(1, 3)
    # An array that is broadcast is read-only, to a compiler a type of its own.
    if vectors.shape[:-1] != lines:
        vectors = np.broadcast_to(vectors, (*lines, 3))
    return vectors.reshape(-1, 3)


def _meet_compiled(quick, careful, shape, plain, points, directions, ends):
    """Fill in `enter` and `leave` of lines, the two rows of `ends`, by a compiled loop."""
    rows = np.ascontiguousarray(points), np.ascontiguousarray(directions)
    ways = {"quick": quick, "careful": careful}

    def meet(block):
        some = (row if len(row) == 1 else row[block] for row in rows)
        arguments = shape, plain, *some, ends[0, block], ends[1, block]
        compiled.call(line_loops.meet_lines, *arguments, **ways, **line_loops.FOR_LINES)

    compiled.each_block(meet, ends.shape[1], COMPILED, careful)


def _meet_rows(quick, careful, shape, plain, points, directions, ends):
    """Fill in what `_meet_compiled` does, by numpy on many lines at once."""
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
