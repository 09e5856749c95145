"""Moves from rest to rest, in whole numbers: two parabolas without a rounding error that grows."""

import numpy as np

from ..arguments import Whole, checked
from .interpolate import End, Ends, difference_of, limit_setvalues

MOST_TICKS = 65534  # 2 M; the denominator 2 M^2 of a parabola must fit 32 bits
EvenTicks = Whole(2, MOST_TICKS)


@checked
def rest_to_rest(start: Ends, stop: Ends, ticks: EvenTicks):
    """Return the set-values of moves that speed up evenly for half of their ticks, then slow down.

    Parameters
    ----------
    start, stop : (...) int
        As for `time_bresenham`.
    ticks : int
        An even number from 2 to 65534.

    Returns
    -------
    setvalues : (..., ticks + 1) int64
        The exact parabolas rounded to the nearest count, half a count upwards.

    Raises
    ------
    ValueError
        As `time_bresenham`, or if `ticks` is odd or above its limit; `rest_to_rest_ticks` yields
        more set-values than one array may hold.

    Examples
    --------
    >>> rest_to_rest(0, 16, 8)
    array([ 0,  1,  2,  5,  8, 12, 14, 16, 16])
    """
    difference = difference_of(start, stop)
    _check_even(ticks)
    limit_setvalues(difference.size, ticks, "`motion.ramp.rest_to_rest_ticks`")
    middle = ticks // 2
    scale = 2 * middle**2
    quotient, remainder = np.divmod(difference[..., None], scale)
    to_go = np.arange(ticks, -1, -1, dtype=np.int64)
    rising = to_go[:middle:-1] ** 2
    falling = to_go[middle:] ** 2
    # difference * rising could leave 64 bits; remainder * rising < 2^31 * 2^30 can't.
    first = quotient * rising + (remainder * rising + middle**2) // scale
    last = difference[..., None] - quotient * falling + (middle**2 - remainder * falling) // scale
    return start[..., None] + np.concatenate([first, last], axis=-1)


@checked
def rest_to_rest_ticks(start: End, stop: End, ticks: EvenTicks):
    """Yield the set-values of `rest_to_rest` (start, stop, ticks) of one axis, tick by tick.

    Two remainder accumulators: one carries the speed, in units of 1/(2 M^2) of a count a tick with
    M half the ticks, the other the position. Both run across the middle without a new start, and no
    number leaves the 32-bit range.
    """
    difference = int(difference_of(start, stop))
    _check_even(ticks)
    return _parabolas(start, difference, ticks)


def _parabolas(start, difference, ticks):
    """Yield `rest_to_rest_ticks`."""
    middle = ticks // 2
    scale = 2 * middle**2
    speed = divmod(difference, scale)
    gain = _plus(speed, speed, scale)
    value = start, middle**2
    yield value[0]
    for n in range(1, ticks + 1):
        value = _plus(value, speed, scale)
        yield value[0]
        if n < middle:
            speed = _plus(speed, gain, scale)
        elif n > middle:
            speed = _minus(speed, gain, scale)


def _plus(a, b, scale):
    """Return the sum of two mixed numbers (whole, rest) with 0 <= rest < scale.

    Rests are compared with a complement: their sum could leave the 32-bit range.
    """
    complement = scale - b[1]
    if a[1] >= complement:
        return a[0] + (b[0] + 1), a[1] - complement
    return a[0] + b[0], a[1] + b[1]


def _minus(a, b, scale):
    """Return the difference of two mixed numbers."""
    if a[1] < b[1]:
        return a[0] - (b[0] + 1), a[1] + (scale - b[1])
    return a[0] - b[0], a[1] - b[1]


def _check_even(ticks):
    if ticks % 2:
        raise ValueError(f"ticks: must be one even number; got {ticks}.")
