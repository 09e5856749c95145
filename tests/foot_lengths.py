"""The length of a chord's normal projection, in space: a second method for the tests.

The foot is the ring's point and R times the unit vector from there, and its speed a derivative by
a complex step. No angle occurs, and no polynomial.
"""

from itertools import pairwise

import numpy as np
from scipy.integrate import quad
from scipy.optimize import minimize_scalar


def length_of_feet(torus, p, q):
    """Return the length, in m, to about 1e-11 of itself, for one pair of ends in rad."""
    start = _point(torus, *p)
    chord = _point(torus, *q) - start

    def from_axis(t):
        x, _, z = start + t * chord
        return np.sqrt(x * x + z * z)

    def from_ring(t):
        return np.hypot(from_axis(t) - torus.r, start[1] + t * chord[1])

    def speed(t):
        step = 1e-30
        m = start + (t + 1j * step) * chord
        ring = m * [1, 0, 1] * (torus.r / np.sqrt(m[0] ** 2 + m[2] ** 2))
        away = m - ring
        foot = ring + torus.R * away / np.sqrt(np.sum(away * away))
        return np.sqrt(np.sum((foot.imag / step) ** 2))

    # The foot is fast where the chord passes the axis or the ring, and may be slow elsewhere.
    grid = np.linspace(0, 1, 301)
    marks = {0.0, 1.0}
    for of in (from_axis, from_ring, speed):
        value = np.array([of(t) for t in grid])
        for k in np.flatnonzero((value[1:-1] <= value[:-2]) & (value[1:-1] <= value[2:])) + 1:
            ends = grid[k - 1], grid[k + 1]
            marks.add(minimize_scalar(of, bounds=ends, options={"xatol": 1e-14}).x)
    marks = sorted(marks)
    total = 0.0
    for low, high in pairwise(marks):
        # In shares of the way from both marks that grow like a power: peaks become plain.
        for mark, side in ((low, 1), (high, -1)):
            half = (high - low) / 2
            total += quad(
                lambda x, mark=mark, side=side, half=half: (
                    speed(mark + side * half * np.exp(x)) * half * np.exp(x)
                ),
                -42, 0, limit=400, epsabs=1e-13 * (torus.r + torus.R), epsrel=1e-12,
            )[0]  # fmt: skip
    return total


def _point(torus, theta, phi):
    rho = torus.r + torus.R * np.cos(phi)
    return np.array([rho * np.cos(theta), torus.R * np.sin(phi), -rho * np.sin(theta)])
