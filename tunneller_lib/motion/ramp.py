"""Moves from rest to rest, in whole numbers: two parabolas without a rounding error that grows."""

import numpy as np

from ..arrays import whole
from .interpolate import checked_move

LONGEST = 65534  # ticks; the remainders of a parabola must fit 32 bits


def rest_to_rest(start, stop, ticks):
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
        As `time_bresenham`, or if `ticks` is odd or above its limit.

    Examples
    --------
    >>> rest_to_rest(0, 16, 8)
    array([ 0,  1,  2,  5,  8, 12, 14, 16, 16])
    """
    start, difference, ticks = checked_move(start, stop, _even(ticks))
    middle = ticks // 2
    scale = 2 * middle**2
    quotient, remainder = np.divmod(difference[..., None], scale)
    to_go = np.arange(ticks, -1, -1, dtype=np.int64)
    rising, falling = to_go[:middle:-1] ** 2, to_go[middle:] ** 2
    # difference * rising could leave 64 bits; remainder * rising < 2^31 * 2^30 can't.
    first = quotient * rising + (remainder * rising + middle**2) // scale
    last = difference[..., None] - quotient * falling + (middle**2 - remainder * falling) // scale
    return start[..., None] + np.concatenate([first, last], axis=-1)


def rest_to_rest_ticks(start, stop, ticks):
    """Yield the set-values of `rest_to_rest` (start, stop, ticks) of one axis, tick by tick.

    Two remainder accumulators: one carries the speed, in units of 1/(2 M^2) of a count a tick with
    M half the ticks, the other the position. Both run across the middle without a new start.
    """
    start, difference, ticks = (int(number) for number in checked_move(start, stop, _even(ticks)))
    scale = ticks * ticks // 2
    speed, speed_rest = divmod(difference, scale)
    gain, gain_rest = divmod(2 * difference, scale)
    value, rest = start, scale // 2
    yield value
    for n in range(1, ticks + 1):
        value, rest = value + speed, rest + speed_rest
        if rest >= scale:
            value, rest = value + 1, rest - scale
        yield value
        if n < ticks // 2:
            speed, speed_rest = speed + gain, speed_rest + gain_rest
            if speed_rest >= scale:
                speed, speed_rest = speed + 1, speed_rest - scale
        elif n > ticks // 2:
            speed, speed_rest = speed - gain, speed_rest - gain_rest
            if speed_rest < 0:
                speed, speed_rest = speed - 1, speed_rest + scale


def _even(ticks):
    if np.ndim(ticks) or whole("ticks", ticks, 2, LONGEST) % 2:
        raise ValueError(f"ticks: must be one even number; got {ticks!r}.")
    return ticks
