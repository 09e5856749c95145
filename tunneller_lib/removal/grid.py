"""The lines of a grid of intervals: parallel, or rays from the tunnel's axis."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.exact import norm

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


def ball_about(points):
    """Return the middle (3,) of points (k, 3) along a way, and how far they are at most from it."""
    middle = (points[0] + points[-1]) / 2
    return middle, float(norm(points - middle).max())


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
