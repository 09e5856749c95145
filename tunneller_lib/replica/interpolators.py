"""What the integer line is compared with: the document's listing and other interpolators.

All of `INTERPOLATORS` are called alike: (start, stop, ticks) in whole counts, arrays of moves as
for `time_bresenham`. They return the set-values (..., ticks + 1) that a controller would send,
some of them no whole counts.
"""

import numpy as np

from ..arguments import finite, positive, whole
from ..motion.interpolate import checked_ends, checked_move, time_bresenham

ONE = 1 << 16  # of a fixed-point number with 16 fractional bits
FIXED_RANGE = (1 << 15) - 1  # its largest whole part


def listing(t1, t2, y1, y2, T, *, division="floor", precision=np.float64):
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
    precision : numpy dtype
        Of slope and error term.

    Returns
    -------
    t : (n,) float
        Times in s.
    y : (..., n) float
        Set-values in counts.

    Raises
    ------
    ValueError
        If times or sampling time can't be used, or `division` is another word.

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
    """
    t1, t2, T = finite("t1", t1), finite("t2", t2), positive("T", T)
    if t2 <= t1:
        raise ValueError(f"t2: must be later than t1 = {t1:g} s; got {t2!r}.")
    if division not in ("floor", "truncate"):
        raise ValueError(f'division: must be "floor" or "truncate"; got {division!r}.')
    t = t1 + T * np.arange(int((t2 - t1) / T * (1 + 1e-12)) + 1)
    chop = np.floor if division == "floor" else np.trunc
    y1, k = checked_ends(y1, y2, ("y1", "y2"))
    nx = (np.asarray(k, precision) / precision(t2 - t1)).astype(precision)
    nxi = chop(nx)
    y = np.broadcast_to(y1, nx.shape).astype(float)
    e = np.zeros_like(nx)
    stored = []
    for _ in t:
        carry = e > 0.5
        y = y + carry
        e = e - carry.astype(precision)
        stored.append(y)
        y = y + nxi
        e = e + nx - nxi  # in the listing's order: e + (nx - nxi) rounds otherwise
    return t, np.stack(stored, axis=-1)


def printed_listing(start, stop, ticks):
    """Return the set-values of the listing with a second a tick, in double precision."""
    return listing(0, ticks, start, stop, 1)[1]


def single_listing(start, stop, ticks):
    """Return the set-values of the listing with a second a tick, in single precision."""
    return listing(0, ticks, start, stop, 1, precision=np.float32)[1]


def single_dda(start, stop, ticks):
    """Return the set-values of a digital differential analyser in single precision.

    Section 4.1: "consecutively adding a value to y", so that rounding errors add up; what is sent
    for (start, stop, ticks) is the sum rounded to the nearest count.
    """
    start, difference, ticks = checked_move(start, stop, ticks)
    step = (difference / ticks).astype(np.float32)
    value, sums = np.broadcast_to(start, difference.shape).astype(np.float32), []
    for _ in range(ticks + 1):
        sums.append(value)
        value = value + step
    return np.floor(np.stack(sums, axis=-1).astype(float) + 0.5)


def fixed_rounded(start, stop, ticks):
    """Return the set-values in fixed point, 16 bits each side, slope and value rounded."""
    return _fixed(start, stop, ticks, ONE // 2)


def fixed_truncated(start, stop, ticks):
    """Return the set-values in fixed point, 16 bits each side, slope and value cut off."""
    return _fixed(start, stop, ticks, 0)


def naive_floor(start, stop, ticks):
    """Return the set-values start + floor(n D / N), with a product and a quotient a tick."""
    start, difference, ticks = checked_move(start, stop, ticks)
    n = np.arange(ticks + 1)
    return start[..., None] + np.floor_divide(n * difference[..., None], ticks)


def integer_slope(start, stop, ticks):
    """Return the set-values with the slope's whole part alone, its fraction forgotten."""
    start, difference, ticks = checked_move(start, stop, ticks)
    return start[..., None] + np.arange(ticks + 1) * (difference // ticks)[..., None]


INTERPOLATORS = {
    "integer line": time_bresenham,
    "listing": printed_listing,
    "listing, single precision": single_listing,
    "DDA, single precision": single_dda,
    "Q16.16, rounded": fixed_rounded,
    "Q16.16, truncated": fixed_truncated,
    "floor of the line": naive_floor,
    "whole slope only": integer_slope,
}


def _fixed(start, stop, ticks, half):
    start, difference, ticks = checked_move(start, stop, ticks)
    whole("start", start, -FIXED_RANGE, FIXED_RANGE)
    whole("stop", start + difference, -FIXED_RANGE, FIXED_RANGE)
    whole("stop - start", difference, -FIXED_RANGE, FIXED_RANGE)
    step = (difference * ONE + (ticks // 2 if half else 0)) // ticks
    values = start[..., None] + (np.arange(ticks + 1) * step[..., None] + half) // ONE
    whole("end in fixed point", values[..., -1], -FIXED_RANGE - 1, FIXED_RANGE)  # it may drift off
    return values
