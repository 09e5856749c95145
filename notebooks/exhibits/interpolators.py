"""What the integer line is compared with: the document's listing and other interpolators.

All of `INTERPOLATORS` are called alike: (start, stop, ticks) in whole counts, arrays of moves as
for `time_bresenham`. They return the set-values (..., ticks + 1) that a controller would send,
some of them no whole counts.
"""

from typing import Literal

import numpy as np

from tunneller_lib.arguments import Duration, Finite, Whole, Wholes, checked, whole
from tunneller_lib.motion.interpolate import HIGH, LOW, time_bresenham

ONE = 1 << 16  # of a fixed-point number with 16 fractional bits
FIXED_RANGE = (1 << 15) - 1  # its largest whole part
MOST_STEPS = 100_000  # ticks, where they are taken one by one
MOST_VALUES = 50_000_000  # of all moves together
SHORTEST, LONGEST = 1e-15, 1e15  # s of the listing: its slope is a number in single precision

Counts = Wholes("(...) int", LOW, HIGH)
Ticks = Whole(1, HIGH)
Steps = Whole(1, MOST_STEPS)


@checked
def listing(
    t1: Finite,
    t2: Finite,
    y1: Counts,
    y2: Counts,
    T: Duration,
    *,
    division: Literal["floor", "truncate"] = "floor",
    precision: Literal["double", "single"] = "double",
):
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
    precision : {"double", "single"}
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
        If times or sampling time can't be used, or there are more than 100 000 samples.

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
    if t2 <= t1:
        raise ValueError(f"t2: must be later than t1 = {t1:g} s; got {t2!r}.")
    if not SHORTEST <= t2 - t1 <= LONGEST:
        raise ValueError(
            f"t2: must be later than t1 by {SHORTEST:g} to {LONGEST:g} s; got {t2 - t1:g} s."
        )
    samples = (t2 - t1) / T * (1 + 1e-12)  # a last one that rounding would put off is meant
    if not samples <= MOST_STEPS:
        raise ValueError(
            f"T: must part {t2 - t1:g} s into at most {MOST_STEPS} ticks; got {T:g} s."
        )
    t = t1 + T * np.arange(int(samples) + 1)
    difference = _difference(y1, y2, t.size, "y2 - y1")
    return t, _listed(t.size, t2 - t1, y1, difference, division, precision)


@checked
def printed_listing(start: Counts, stop: Counts, ticks: Steps):
    """Return the set-values of the listing with a second a tick, in double precision."""
    return _listed(ticks + 1, ticks, start, _difference(start, stop, ticks), "floor", "double")


@checked
def single_listing(start: Counts, stop: Counts, ticks: Steps):
    """Return the set-values of the listing with a second a tick, in single precision."""
    return _listed(ticks + 1, ticks, start, _difference(start, stop, ticks), "floor", "single")


@checked
def single_dda(start: Counts, stop: Counts, ticks: Steps):
    """Return the set-values of a digital differential analyser in single precision.

    Section 4.1: "consecutively adding a value to y", so that rounding errors add up; what is sent
    for (start, stop, ticks) is the sum rounded to the nearest count.
    """
    difference = _difference(start, stop, ticks)
    step = (difference / ticks).astype(np.float32)
    value = np.broadcast_to(start, difference.shape).astype(np.float32)
    sums = []
    for _ in range(ticks + 1):
        sums.append(value)
        value = value + step
    return np.floor(np.stack(sums, axis=-1).astype(float) + 0.5)


@checked
def fixed_rounded(start: Counts, stop: Counts, ticks: Ticks):
    """Return the set-values in fixed point, 16 bits each side, slope and value rounded."""
    return _fixed(start, stop, ticks, ONE // 2)


@checked
def fixed_truncated(start: Counts, stop: Counts, ticks: Ticks):
    """Return the set-values in fixed point, 16 bits each side, slope and value cut off."""
    return _fixed(start, stop, ticks, 0)


@checked
def naive_floor(start: Counts, stop: Counts, ticks: Ticks):
    """Return the set-values start + floor(n D / N), with a product and a quotient a tick."""
    difference = _difference(start, stop, ticks)
    n = np.arange(ticks + 1)
    return start[..., None] + np.floor_divide(n * difference[..., None], ticks)


@checked
def integer_slope(start: Counts, stop: Counts, ticks: Ticks):
    """Return the set-values with the slope's whole part alone, its fraction forgotten."""
    difference = _difference(start, stop, ticks)
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


def _difference(start, stop, ticks, name="stop - start"):
    """Return stop - start of moves, which fits 32 bits, as it does in a controller."""
    difference = whole(name, stop - start, LOW, HIGH)
    if max(difference.size, 1) * ticks > MOST_VALUES:  # no moves, too, need all ticks
        raise ValueError(
            f"{name}: {difference.size} moves of {ticks} ticks need more than {MOST_VALUES} values."
        )
    return difference


def _listed(count, duration, start, difference, division, precision):
    """Return the listing's set-values (..., count)."""
    real = {"double": np.float64, "single": np.float32}[precision]
    chop = {"floor": np.floor, "truncate": np.trunc}[division]
    nx = (np.asarray(difference, real) / real(duration)).astype(real)
    nxi = chop(nx)
    y = np.broadcast_to(start, nx.shape).astype(float)
    e = np.zeros_like(nx)
    stored = []
    for _ in range(count):
        carry = e > 0.5
        y = y + carry
        e = e - carry.astype(real)
        stored.append(y)
        y = y + nxi
        e = e + nx - nxi  # in the listing's order: e + (nx - nxi) rounds otherwise
    return np.stack(stored, axis=-1)


def _fixed(start, stop, ticks, half):
    difference = _difference(start, stop, ticks)
    whole("start", start, -FIXED_RANGE, FIXED_RANGE)
    whole("stop", start + difference, -FIXED_RANGE, FIXED_RANGE)
    whole("stop - start", difference, -FIXED_RANGE, FIXED_RANGE)
    step = (difference * ONE + (ticks // 2 if half else 0)) // ticks
    values = start[..., None] + (np.arange(ticks + 1) * step[..., None] + half) // ONE
    whole("end in fixed point", values[..., -1], -FIXED_RANGE - 1, FIXED_RANGE)  # it may drift off
    return values
