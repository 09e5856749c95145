"""What the integer line is compared with: the document's listing and other interpolators.

All of `INTERPOLATORS` are called alike: (start, stop, ticks) in whole counts, arrays of moves as
for `time_bresenham`. They return the set-values (..., ticks + 1) that a controller would send,
some of them no whole counts.
"""

from functools import partial

import numpy as np

from tunneller_lib.motion.interpolate import time_bresenham

DIVISIONS = {"floor": np.floor, "truncate": np.trunc}
ONE = 1 << 16  # of a fixed-point number with 16 fractional bits


def listing(t1, t2, y1, y2, T, *, division="floor"):
    """Return what the document's listing stores: times and set-values.

    Parameters
    ----------
    t1, t2 : float
        First and last time, in s.
    y1, y2 : (...) int
        First and last set-value, in counts; they broadcast.
    T : float
        The sampling time, in s.
    division : {"floor", "truncate"}
        What stands for ``floor``: the listing's comment, "simulate int division command of modern
        CPUs", suggests the truncating division of most processors.

    Returns
    -------
    t : (n,) float
        Times in s.
    y : (..., n) float
        Set-values in counts.

    Notes
    -----
    Tunnelling robot, section 4.3, as it stands: the slope is that of a second, not of a sampling
    time, so that only T = 1 ends at y2.

    Examples
    --------
    >>> listing(0, 10, 5, 30, 1)[1].tolist()
    [5.0, 7.0, 10.0, 12.0, 15.0, 17.0, 20.0, 22.0, 25.0, 27.0, 30.0]
    >>> listing(0, 10, 5, 30, 0.5)[1][-1]
    np.float64(55.0)

    That 10.6 - 10.5 is a little less than 0.1 takes no sample away:

    >>> listing(10.5, 10.6, 0, 1, 0.1)[0].round(3).tolist()
    [10.5, 10.6]
    """
    samples = (t2 - t1) / T * (1 + 1e-12)  # a last one that rounding would put off is meant
    t = t1 + T * np.arange(int(samples) + 1)
    return t, _listed(y1, y2, t2 - t1, count=t.size, division=DIVISIONS[division])


def _listed(start, stop, duration, *, count=None, real=np.float64, division=np.floor):
    """Return the listing's set-values (..., count), by default with a second a tick."""
    nx = (np.subtract(stop, start).astype(real) / real(duration)).astype(real)
    nxi = division(nx)
    y = np.broadcast_to(start, nx.shape).astype(float)
    e = np.zeros_like(nx)
    stored = []
    for _ in range(count or duration + 1):
        carry = e > 0.5
        y = y + carry
        e = e - carry.astype(real)
        stored.append(y)
        y = y + nxi
        e = e + nx - nxi  # in the listing's order: e + (nx - nxi) rounds otherwise
    return np.stack(stored, axis=-1)


def single_dda(start, stop, ticks):
    """Return the set-values of a digital differential analyser in single precision.

    Section 4.1: "consecutively adding a value to y", so that rounding errors add up; what is sent
    for (start, stop, ticks) is the sum rounded to the nearest count.
    """
    difference = np.subtract(stop, start)
    step = (difference / ticks).astype(np.float32)
    value = np.broadcast_to(start, difference.shape).astype(np.float32)
    sums = []
    for _ in range(ticks + 1):
        sums.append(value)
        value = value + step
    return np.floor(np.stack(sums, axis=-1).astype(float) + 0.5)


def fixed(start, stop, ticks, *, half):
    """Return the set-values in fixed point, 16 bits each side.

    Slope and value are rounded if `half` is ONE / 2, and cut off if it is 0.
    """
    difference = np.subtract(stop, start)
    step = (difference * ONE + (ticks // 2 if half else 0)) // ticks
    run = np.arange(ticks + 1) * np.asarray(step)[..., None]
    return np.asarray(start)[..., None] + (run + half) // ONE


def naive_floor(start, stop, ticks):
    """Return the set-values start + floor(n D / N), with a product and a quotient a tick."""
    run = np.arange(ticks + 1) * np.subtract(stop, start)[..., None]
    return np.asarray(start)[..., None] + run // ticks


def integer_slope(start, stop, ticks):
    """Return the set-values with the slope's whole part alone, its fraction forgotten."""
    slope = np.asarray(np.subtract(stop, start) // ticks)
    return np.asarray(start)[..., None] + np.arange(ticks + 1) * slope[..., None]


INTERPOLATORS = {
    "integer line": time_bresenham,
    "listing": _listed,
    "listing, single precision": partial(_listed, real=np.float32),
    "DDA, single precision": single_dda,
    "Q16.16, rounded": partial(fixed, half=ONE // 2),
    "Q16.16, truncated": partial(fixed, half=0),
    "floor of the line": naive_floor,
    "whole slope only": integer_slope,
}
