"""The lines of a grid of intervals: parallel, or rays from the tunnel's axis."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import greater, larger, lesser, square_root, where
from ..kernels.exact import norm
from ..surfaces.rod_interval import ball_sweep

BLOCK = 32768  # lines treated at once: a few MB for work, whatever the size of the grid


class Lines(NamedTuple):
    """Lines in planes x = const, the same m in each of n planes, none of them along x.

    Parameters
    ----------
    x : (n,) float
        The planes, in m, ascending.
    cos, sin : (m,) float
        A line runs along (0, `cos`, `sin`).
    aside : (m,) float
        How far a line passes to the right of the axis y = z = 0, in m.
    cell : float
        What each line stands for: an area, in m^2, or for rays a length times an angle, in m.
    rays : bool
        Whether the lines begin at the axis.
    """

    x: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    aside: np.ndarray
    cell: float
    rays: bool

    def measure(self, low, high):
        """Return the volume of intervals from `low` to `high`, in m^3."""
        return self.cell * (high - low) * ((high + low) / 2 if self.rays else 1.0)

    def window(self, points, radius, nearest):
        """Return the lines that balls may meet which go from point to point.

        Parameters
        ----------
        points : (k, 3) float
            Their centres, in m.
        radius : float
            Of the balls, in m.
        nearest : (m,) float
            Where the material begins on the rays of each angle; unused by parallel lines.

        Returns
        -------
        window : tuple of four int
            From and to in x, from and to among the lines, which on rays may go round.
        """
        if self.rays:
            return self._window_of_rays(points, radius, nearest)
        low = points.min(axis=0) - radius
        high = points.max(axis=0) + radius
        return *_range(self.x, low[0], high[0]), *_range(self.aside, low[1], high[1])

    def _window_of_rays(self, points, radius, nearest):
        """Return `window` on rays: a range of places along x and one of angles.

        The angles are first those at which rays meet one ball about all balls, then only those at
        which that ball reaches beyond the nearest material on these rays; so are the places.
        """
        # One ball stands for all, since the steps of a path are short.
        middle, away = ball_about(points)
        reach = radius + away
        x, y, z = middle.tolist()
        off = math.hypot(y, z)
        angle = math.atan2(z, y)
        # Rays touch a ball beside the axis at angles of -+ half; all rays meet one that holds it.
        half = math.asin(reach / off) if off > reach else math.pi
        # Nearer to the axis than the nearest material on these rays there is nothing to cut, so
        # only the part of the ball beyond counts.
        inner = _least(nearest, *self._turn(angle, half))
        beyond = inner - off
        if beyond > reach:
            return 0, 0, 0, 0
        # That part ends at the angles where the ball's surface is as far from the axis as the
        # material, by the law of cosines. If the material begins nearer than the places where the
        # rays touch the ball, those places are in that part, and the touching rays bound it.
        cosine_law = inner**2 + off**2 - reach**2  # 2 off inner cos(half)
        if inner**2 > off**2 - reach**2 and off > 0 and inner > 0:
            half = math.acos(min(max(cosine_law / off / inner / 2, -1.0), 1.0))
        # That part is also narrower along x than the ball.
        width = math.sqrt(max(reach**2 - max(beyond, 0.0) ** 2, 0.0))
        return *_range(self.x, x - width, x + width), *self._turn(angle, half)

    def blocks(self, window):
        """Yield slices of rows and columns that cover a window, of at most `BLOCK` lines each."""
        first, last, start, stop = window
        count = len(self.cos)
        stop += start % count - start
        start %= count
        # On rays a window may go on past the last one: then there are two parts.
        for left, end in ((start, min(stop, count)), (0, stop - count)):
            for here in range(left, end, BLOCK):
                columns = slice(here, min(here + BLOCK, end))
                height = BLOCK // (columns.stop - here)
                for top in range(first, last, height):
                    yield slice(top, min(top + height, last)), columns

    def _turn(self, angle, half):
        """Return the first and past-the-last indices of the rays within angle -+ half.

        They go on below 0 and past the last ray, but never more than once round.
        """
        step = 2 * np.pi / len(self.cos)
        # The rays are in the middles of their cells, and rounding must lose none at the ends.
        start = math.ceil((angle - half) / step - 0.5 - 1e-9)
        stop = math.floor((angle + half) / step - 0.5 + 1e-9) + 1
        return start, min(stop, start + len(self.cos))

    def seen(self, a, b, columns):
        """Return axes in the coordinates of the lines, whatever their plane, for `across`.

        Parameters
        ----------
        a, b : (..., 3) float
            Ends of the axes, in m.
        columns : slice, or (i, 1) int
            The lines.

        Returns
        -------
        x, side, fx, fy, run, rise, length, start : (..., i, j) float
            Of the end that a line passes first: its x and its way to the right, in m; the unit
            vector of the axis in the plane across the line; how far the axis goes in that plane and
            along the line, its length, and where along the line it starts, in m. i or j is 1.
        """
        cos = self.cos[columns]
        sin = self.sin[columns]
        ax, ay, az = (a[..., i, None, None] for i in range(3))
        bx, by, bz = (b[..., i, None, None] for i in range(3))
        # The axis starts at the end that a line passes first, so that it rises along the line.
        turned = cos * (by - ay) + sin * (bz - az) < 0
        sx, sy, sz = (np.where(turned, q, p) for p, q in ((ax, bx), (ay, by), (az, bz)))
        vx, vy, vz = (np.where(turned, p - q, q - p) for p, q in ((ax, bx), (ay, by), (az, bz)))
        # The plane across a line has the coordinates x and, to its right, sin y - cos z.
        aside = sin * vy - cos * vz
        rise = cos * vy + sin * vz
        run = np.hypot(vx, aside)
        # An axis along the line has no direction in that plane: any will do.
        pace = np.where(run > 0, run, 1)
        fx = np.where(run > 0, vx / pace, 1.0)
        squares = (b - a) ** 2
        length = np.sqrt(np.add.reduce(squares, axis=-1))[..., None, None]
        start = cos * sy + sin * sz
        return sx, sin * sy - cos * sz, fx, aside / pace, run, rise, length, start

    def meet_solid(self, solid, rows, columns):
        """Return `enter` and `leave` (i, j) of the lines of a window against a solid, in m.

        Parameters
        ----------
        solid : Solid
            Met by its own `meet_line`.
        rows, columns : slice
            The window. A line that misses gets an empty interval.
        """
        cos, sin, aside = self.cos[columns], self.sin[columns], self.aside[columns]
        # Each line's point nearest to the axis y = z = 0.
        points = np.empty((len(self.x[rows]), len(cos), 3))
        points[..., 0] = self.x[rows, None]
        points[..., 1] = aside * sin
        points[..., 2] = -aside * cos
        along = np.stack([0 * cos, cos, sin], axis=-1)
        return solid.meet_line(points, along if self.rays else along[0])

    def meet_ball(self, centre, radius, rows, columns):
        """Return `enter` and `leave` (i, j) of the lines of a window against a ball, in m.

        Parameters
        ----------
        centre : (3,) float
            In m.
        radius : float
            In m.
        rows, columns : slice
            The window. A line that misses gets an empty interval where it is nearest.
        """
        cos = self.cos[columns]
        sin = self.sin[columns]
        return met_ball(self.x[rows, None], self.aside[columns], cos, sin, centre, radius)


def ball_about(points):
    """Return the middle (3,) of points (k, 3) along a way, and how far they are at most from it."""
    middle = (points[0] + points[-1]) / 2
    return middle, float(norm(points - middle).max())


def met_ball(x, aside, cos, sin, centre, radius):
    """Return where lines enter and leave a ball of a centre (x, y, z) and a radius, in m.

    Numbers or arrays: x, `aside`, `cos` and `sin` of `Lines`. A line that misses enters and leaves
    where it is nearest to the centre.
    """
    cx, cy, cz = centre
    off = x - cx
    beside = aside - (sin * cy - cos * cz)
    half = square_root(larger(radius * radius - off * off - beside * beside, 0.0))
    middle = cos * cy + sin * cz
    return middle - half, middle + half


def across(x, aside, seen):
    """Return where lines lie across and along axes, in m, in the plane across the lines.

    Numbers or arrays: the lines' planes x and ways `aside`, in m, and the axes as `Lines.seen`.
    """
    sx, side, fx, fy, _, _, _, _ = seen
    qx = x - sx
    qy = aside - side
    return qx * fy - fx * qy, qx * fx + qy * fy


def swept(x, aside, radius, seen):
    """Return where lines enter and leave what balls of a radius sweep, in m.

    Numbers or arrays: x and `aside` of `Lines`, in m, and the axes as `seen` by them. A line
    that misses gets inf and -inf.
    """
    _, _, _, _, run, rise, length, start = seen
    s, m = across(x, aside, seen)
    size = where(length > 0, length, 1.0)  # a ball: its rise is zero, over any length
    enter, leave, room = ball_sweep(run, rise, size, radius, s, m)
    return where(room > 0, enter + start, np.inf), where(room > 0, leave + start, -np.inf)


def parallel(low, high, shape):
    """Return lines along z at the middles of shape = (n, m) cells from low to high (2,), in m.

    Examples
    --------
    >>> lines = parallel((0, 1), (4, 3), (2, 4))
    >>> lines.x.tolist(), lines.aside.tolist(), lines.cell
    ([1.0, 3.0], [1.25, 1.75, 2.25, 2.75], 1.0)
    """
    x = _middles(low[0], high[0], shape[0])
    y = _middles(low[1], high[1], shape[1])
    cell = (high[0] - low[0]) * (high[1] - low[1]) / (shape[0] * shape[1])
    return Lines(x, np.zeros(len(y)), np.ones(len(y)), y, cell, False)


def fan(start, stop, shape):
    """Return n x m = shape rays from the x axis, in the middles of cells from start to stop."""
    n, m = shape
    x = _middles(start, stop, n)
    angle = (np.arange(m) + 0.5) * 2 * np.pi / m
    cell = (stop - start) / n * 2 * np.pi / m
    return Lines(x, np.cos(angle), np.sin(angle), np.zeros(m), cell, True)


def _middles(low, high, n):
    return low + (np.arange(n) + 0.5) * (high - low) / n


def _range(values, low, high):
    """Return the first and past-the-last indices of ascending values from low to high."""
    return int(values.searchsorted(low)), int(values.searchsorted(high, side="right"))


def _least(values, first, last):
    """Return the least of `values` in a range, which may go round; infinite in an empty one."""
    return float(values.take(range(first, last), mode="wrap").min(initial=np.inf))


# ---- the same line by line, for `compiled.call`: the bits are those of the formulas above ------


def meet_moves(low, high, lines, window, ball, radius, seen, rows, columns, enter, leave):
    """Fill in which lines have material in a ball, and where moves within the ball meet them.

    A line that misses the ball counts as well if its point nearest to the ball lies in material;
    it gets empty intervals.

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
        Filled with the indices of these lines; size is at least the number of lines in the window.
    enter, leave : (1 + l, size) float
        Filled with where the moves enter and leave them, in m: in row 0 the least interval that
        holds those of all moves, then a row for each move.

    Returns
    -------
    found : int
        How many lines there are.
    apart : bool
        Whether some move's interval on a line is apart from that which holds those before it.
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
        # The moves are met only from the first to the last line of the row that is reached.
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
            # The union of the moves' intervals is itself an interval unless some are apart.
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


# Each is a loop without branches over neighbouring lines: the compiler takes several at once.


def _meet_row_with_ball(x, aside, cos, sin, ball, near, far):
    """Fill in where the lines of a row enter and leave a ball, its centre and radius in m."""
    cx, cy, cz, radius = ball
    for j in range(len(near)):
        near[j], far[j] = met_ball(x, aside[j], cos[j], sin[j], (cx, cy, cz), radius)


def _reach_row(low, high, near, far, reached):
    """Note on which lines of a row the material overlaps the interval from near to far, in m."""
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
