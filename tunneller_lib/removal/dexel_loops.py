"""A grid of intervals, line by line: for `compiled.call` where loops are `compiled.ready`.

The formulas are those that `grid` has for whole arrays, so that every bit is the same.
"""

import numpy as np

from ..kernels.elementwise import greater, lesser
from .grid import met_ball, swept


def meet_moves(low, high, lines, window, ball, radius, seen, rows, columns, enter, leave):
    """Fill in which lines have material in a ball's reach, and where moves within it meet them.

    Parameters
    ----------
    low, high : (k, n, m) float
        The material, in m.
    lines : tuple of (n,) and three (m,) float
        x, cos, sin and aside of `Lines`.
    window : (int, int, int, int)
        From and to among the planes, from and to among the lines of each.
    ball : (float, float, float, float)
        Its centre and its radius, in m.
    radius : float
        Of the balls that the moves sweep, in m.
    seen : tuple of (l, 1, count) float
        The axes of l moves as `Lines.seen` from these lines.
    rows, columns : (size,) int
        Filled with which lines these are.
    enter, leave : (1 + l, size) float
        Filled with where each move enters and leaves them, and in row 0 all moves together.

    Returns
    -------
    found : int
        How many lines there are.
    apart : bool
        Whether some move takes an interval that doesn't overlap with those before it.
    """
    x, cos, sin, aside = lines
    top, bottom, left, right = window
    width = right - left
    near = np.empty(width)
    far = np.empty(width)
    reached = np.empty(width, dtype=np.bool_)
    firsts = np.empty((len(seen[0]), width))
    lasts = np.empty((len(seen[0]), width))
    found = 0
    apart = False
    for i in range(top, bottom):
        _meet_row_with_ball(
            x[i], aside[left:right], cos[left:right], sin[left:right], ball, near, far
        )
        reached[:] = False
        for slot in range(len(low)):
            _reach_row(low[slot, i, left:right], high[slot, i, left:right], near, far, reached)
        # The moves are met from the first to the last line of the row that is reached, no farther.
        begin = 0
        while begin < width and not reached[begin]:
            begin += 1
        end = width
        while end > begin and not reached[end - 1]:
            end -= 1
        if begin == end:
            continue
        there = aside[left + begin : left + end]
        for k in range(len(firsts)):
            _meet_row(x[i], there, radius, seen, k, begin, firsts[k], lasts[k])
        for j in range(begin, end):
            if not reached[j]:
                continue
            # The union of the moves' intervals, which is one interval unless some are apart.
            first = np.inf
            last = -np.inf
            for k in range(len(firsts)):
                enters = firsts[k, j]
                leaves = lasts[k, j]
                if enters < leaves and first < last and (enters > last or leaves < first):
                    apart = True
                first = lesser(first, enters)
                last = greater(last, leaves)
                enter[1 + k, found] = enters
                leave[1 + k, found] = leaves
            enter[0, found] = first
            leave[0, found] = last
            rows[found] = i
            columns[found] = left + j
            found += 1
    return found, apart


# Each a loop without branches over lines side by side: the compiler takes several at once.


def _meet_row_with_ball(x, aside, cos, sin, ball, near, far):
    """Fill in where the lines of a row enter and leave a ball, its centre and radius in m."""
    cx, cy, cz, radius = ball
    for j in range(len(near)):
        near[j], far[j] = met_ball(x, aside[j], cos[j], sin[j], (cx, cy, cz), radius)


def _reach_row(low, high, near, far, reached):
    """Note which intervals of a row reach between two places, all in m."""
    for j in range(len(near)):
        reached[j] |= (near[j] < high[j]) & (far[j] > low[j]) & (low[j] < high[j])


def _meet_row(x, aside, radius, seen, k, begin, enter, leave):
    """Fill in where the lines of a row, from `begin` on, enter and leave what move k sweeps."""
    length = seen[6][k, 0, 0]
    sx, side, fx, fy, run, rise, _, start = seen
    sx = sx[k, 0, begin:]
    side = side[k, 0, begin:]
    fx = fx[k, 0, begin:]
    fy = fy[k, 0, begin:]
    run = run[k, 0, begin:]
    rise = rise[k, 0, begin:]
    start = start[k, 0, begin:]
    enter = enter[begin:]
    leave = leave[begin:]
    for j in range(len(aside)):
        axis = (sx[j], side[j], fx[j], fy[j], run[j], rise[j], length, start[j])
        enter[j], leave[j] = swept(x, aside[j], radius, axis)
