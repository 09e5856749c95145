"""The length of a chord's normal projection, in space: a second method for the tests.

The foot is the ring's point and R times the unit vector from there, and its speed a derivative by
a complex step. No angle of it occurs, and no polynomial.
"""

import numpy as np
from scipy.integrate import tanhsinh
from scipy.optimize import minimize_scalar


def length_of_feet(torus, p, q):
    """Return the length, in m, to about 1e-11 of itself, for one pair of ends in rad."""
    start, chord = torus.point(*p), torus.point(*q) - torus.point(*p)

    def from_axis(t):
        x, _, z = np.moveaxis(start + t[..., None] * chord, -1, 0)
        return np.sqrt(x * x + z * z)

    def from_ring(t):
        return np.hypot(from_axis(t) - torus.r, start[1] + t * chord[1])

    def speed(t):
        m = start + (t + 1e-30j)[..., None] * chord
        away = m - m * [1, 0, 1] * (torus.r / np.sqrt(np.sum(m * m * [1, 0, 1], -1))[..., None])
        foot = m - away + torus.R * away / np.sqrt(np.sum(away * away, axis=-1))[..., None]
        return np.sqrt(np.sum((foot.imag / 1e-30) ** 2, axis=-1))

    # The foot is fast where the chord passes the axis or the ring, and may be slow elsewhere.
    grid, marks = np.linspace(0, 1, 301), [0.0, 1.0]
    for of in (from_axis, from_ring, speed):
        value = of(grid)
        for k in np.flatnonzero((value[1:-1] <= value[:-2]) & (value[1:-1] <= value[2:])) + 1:
            ends = grid[k - 1], grid[k + 1]
            marks.append(minimize_scalar(of, bounds=ends, options={"xatol": 1e-14}).x)
    marks = np.unique(marks)
    return tanhsinh(speed, marks[:-1], marks[1:], rtol=1e-12, maxlevel=14).integral.sum()
