"""The fastest feed along a way whose limits are convex: two passes, backwards and forwards.

Over the square x = v^2 of the feed v, the acceleration a along the way changes it by
dx/dl = 2 a. At each place the accelerations q' a + q'' x of a machine's axes, be they two joints or
five axes, are linear in both, and so every limit on their size is a convex set of (a, x) about the
origin. The way is passed backwards for
the greatest x from which the rest can still be run, then forwards as fast as these let it.
"""

from dataclasses import dataclass
from math import ceil, inf, sqrt

import numpy as np

HALVINGS = 60  # of the range in which the greatest x of a place is looked for


@dataclass(frozen=True, eq=False)
class Places:
    """What bounds the motion of a tool at each of m + 1 places of a way, which has any unit.

    The units below are those of a way in m and axes in rad.

    Parameters
    ----------
    square : (m + 1,) float
        Greatest square of the feed, in m^2/s^2, by limits of speed.
    acceleration : float
        Of the tool, in m/s^2: the axes' accelerations, each times its lever; infinite for none.
    axis : (j,) float
        Greatest accelerations of the axes, in rad/s^2; infinite for none.
    slope, bend : (m + 1, j) float
        First and second derivatives of the axes' positions by the length of way.
    lever : (m + 1, j) float
        How far the tool moves by a radian of each axis, in m; their moves are at right angles.
    """

    square: np.ndarray
    acceleration: float
    axis: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    lever: np.ndarray

    def products(self):
        """Return g11, g12, g22 (m + 1,) of g11 a^2 + 2 g12 a x + g22 x^2 <= acceleration^2."""
        if np.isinf(self.acceleration):  # any ellipse is within it, also where nothing moves
            return np.ones(len(self.slope)), *np.zeros((2, len(self.slope)))
        slope = self.lever * self.slope
        bend = self.lever * self.bend
        return np.sum(slope**2, -1), np.sum(slope * bend, -1), np.sum(bend**2, -1)

    def lines(self):
        """Return c, d (axes, m + 1) of |a + d x| <= c, of axes that are limited."""
        limited = np.isfinite(self.axis)
        slope = self.slope[:, limited].T
        slope = np.where(np.abs(slope) < 1e-12, 1e-12, slope)
        return self.axis[limited, None] / np.abs(slope), self.bend[:, limited].T / slope

    def highest(self):
        """Return the greatest squares (m + 1,) at which any acceleration at all is allowed."""
        g11, g12, g22 = self.products()
        c, d = self.lines()
        with np.errstate(divide="ignore", over="ignore"):
            rise = np.sqrt(np.maximum(g22 - g12**2 / g11, 0))
            high = np.minimum(self.square, self.acceleration / rise)
        if not len(c):
            return high
        low = np.zeros_like(high)
        top = high
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            under = g11 * self.acceleration**2 - (g11 * g22 - g12**2) * middle**2
            root = np.sqrt(np.maximum(under, 0))
            most = np.minimum((root - g12 * middle) / g11, np.min(c - d * middle, axis=0))
            least = np.maximum((-root - g12 * middle) / g11, np.max(-c - d * middle, axis=0))
            allowed = least <= most
            low = np.where(allowed, middle, low)
            high = np.where(allowed, high, middle)
        return np.where(high >= top, top, low)


def fastest(lengths, places):
    """Return the squares (m + 1,) of the greatest feed from rest to rest over moves (m,), in m."""
    top = places.highest().tolist()
    ellipses = list(zip(*(part.tolist() for part in places.products()), strict=True))
    lines = [
        list(zip(c.tolist(), d.tolist(), strict=True)) for c, d in zip(*places.lines(), strict=True)
    ]
    top[0] = top[-1] = 0.0
    limit = places.acceleration * places.acceleration
    steps = (2 * lengths).tolist()  # dx = 2 a dl: a move changes x by step times a
    # Backwards: the greatest x from which braking as hard as allowed still gets down to `goal`, the
    # greatest x at the move's end. The tool's limit is the ellipse
    # g11 a^2 + 2 g12 a x + g22 x^2 = limit, an axis' are the lines |a + d x| = c.
    for i in reversed(range(len(steps))):
        step = steps[i]
        goal = top[i + 1]
        best = top[i]
        g11, g12, g22 = ellipses[i]
        # Where the line x + step a = goal leaves the ellipse: the greater root of
        # p x^2 + 2 h x + g11 goal^2 - step^2 limit = 0. It counts on the side of least a alone,
        # below the middle a = -g12 x / g11 of the chord at x: above, a may still be less.
        p = g11 - 2 * step * g12 + step * step * g22
        h = goal * (step * g12 - g11)
        under = h * h - p * (g11 * goal * goal - step * step * limit)
        if under >= 0:
            x = (sqrt(under) - h) / p if under < inf else inf
            if x < best and (goal - x) * g11 <= -g12 * x * step:
                best = x
        # With a = -c - d x the goal is met at x (1 - step d) = goal + step c.
        for line in lines:
            c, d = line[i]
            if 1 - step * d > 0:
                best = min(best, (goal + step * c) / (1 - step * d))
        top[i] = best
    # Forwards from rest: the most that ellipse and lines let x grow, but not above what the first
    # pass allows. Where they leave no growth at all the feed falls, at worst to rest.
    square = [0.0]
    for i, step in enumerate(steps):
        x = square[-1]
        g11, g12, g22 = ellipses[i]
        most = (sqrt(max(g12 * g12 * x * x - g11 * (g22 * x * x - limit), 0.0)) - g12 * x) / g11
        for line in lines:
            c, d = line[i]
            most = min(most, c - d * x)
        square.append(min(top[i + 1], max(x + step * most, 0.0)))
    return np.array(square)


def move_ticks(distance, speed, acceleration, tick):
    """Return the ticks (n0, n1) of two means that make the fastest move from rest to rest.

    A step of the `distance` D, smoothed by means over n0 and n1 ticks one after the other, has the
    greatest speed D / n0 and acceleration D / (n0 n1). With n0 >= n1 that is the motion of three
    phases. In m, s and what follows; the `speed` may be infinite. Rounded up to whole ticks, the
    limits are kept.
    """
    # Where the speed isn't reached the first mean is as long as the second.
    n1 = min(speed / acceleration, sqrt(distance / acceleration))
    n0 = distance / (acceleration * n1)
    first, second = (max(ceil(n / tick * (1 - 1e-12)), 1) for n in (n0, n1))
    # Rounded up each by itself they could overlap.
    return [max(first, second), second]


def move_shares(ticks):
    """Return the share of the way, from 0 to 1, at each tick of a move of `move_ticks`."""
    speed = np.ones(1)
    for n in ticks:
        speed = np.convolve(speed, np.full(n, 1 / n))
    shares = np.concatenate([[0.0], np.cumsum(speed)])
    return shares / shares[-1]
