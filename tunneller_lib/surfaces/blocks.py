"""Many lines against one shape, in blocks that stay in the cache.

Each shape has a careful way, with twice the digits where they cancel. A round shape has a quick
way as well, the plain formula. It is sure of lines that are given near the shape, that are neither
nearly parallel to its axis nor nearly level with its discs, and that neither touch the shape nor
pass it closely. Of lines between random places it leaves one of a hundred thousand to the careful
way; of lines that a program aims at an edge it may leave them all.

Both ways are written once, `elementwise`: for one line they take Python's own floats, for many
rows of x, y and z, over which numpy runs fastest. Where loops are `compiled` a loop calls them line
by line.
"""

import math

import numpy as np

from ..kernels import compiled, line_loops
from ..kernels.vectors import differences

BLOCK = 16384  # lines treated at once
COMPILED = 65536  # the same by a compiled loop, for which only calls count
# About how long lines take at most without a compiler, in s: one alone, and each of many.
PLAIN_CALL, PLAIN_LINE = 1e-5, 4e-7


def meet_in_blocks(careful, shape, point, direction, *, quick=line_loops.quick, plain=False):
    """Return where lines enter and leave one shape.

    Parameters
    ----------
    careful : function
        Of the shape, of points and directions as `vectors`; returns `enter` and `leave`.
    shape : NamedTuple
        Numbers and vectors of the shape; its `start`, in m, is one of its points.
    point, direction : (..., 3) float
        Points of the lines, in m, and their directions.
    quick : function, optional
        Of the shape, of points counted from its start, in m, and of directions; returns `enter`,
        `leave` and where they are `sure`.
    plain : bool
        Whether the quick way may decide, see `well_shaped`.

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
    # Adding 0.0 turns -0.0 into 0.0: of two zeros Python's `max` and numpy's keep different ones.
    found += 0.0
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
        compiled.call(line_loops.meet_lines, *arguments, **ways, **line_loops.FOR_LINES)

    compiled.each_block(meet, ends.shape[1], COMPILED, careful)


def _meet_rows(quick, careful, shape, plain, points, directions, ends):
    """Fill in what `_meet_compiled` does, by numpy on whole rows."""
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
