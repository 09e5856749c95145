"""Straight lines in time, in whole numbers: the Bresenham line whose cardinal axis is the tick.

A set-value is a number of encoder counts. Any number of axes share one clock.
"""

import numpy as np

from ..arguments import positive, real, whole

LOW, HIGH = -(2**31), 2**31 - 1  # what a controller's 32-bit integer holds
TIES = {"up": 0, "down": 1}


def time_bresenham(start, stop, ticks, *, tie="up"):
    """Return the set-values of straight moves, one a tick.

    Parameters
    ----------
    start, stop : (...) int
        Where the moves begin and end, in counts, each a 32-bit integer, their differences too;
        they broadcast.
    ticks : int
        Number of ticks that a move takes, from 1 to 2^31 - 1; all axes share it.
    tie : {"up", "down"}
        Which count half a count is rounded to.

    Returns
    -------
    setvalues : (..., ticks + 1) int64
        In counts; the first is `start`, the last is `stop`.

    Raises
    ------
    ValueError
        If a number isn't whole or is beyond its range, or `tie` is another word.

    Notes
    -----
    Tunnelling robot, section 4.3, whose listing is this line with ties down, computed in floating
    point. The closed form (n D + N start + N // 2) // N, with D the difference and N the ticks, is
    the exact line rounded to the nearest count: the error is at most half a count, the end is
    exact, and the same points are met on the way back. `line_ticks` computes the same without a
    product or a quotient.

    Examples
    --------
    >>> time_bresenham(5, 30, 10)
    array([ 5,  8, 10, 13, 15, 18, 20, 23, 25, 28, 30])
    >>> time_bresenham([0, 7], [-3, 7], 2).tolist()
    [[0, -1, -3], [7, 7, 7]]
    """
    start, difference, ticks = checked_move(start, stop, ticks)
    # N times the line, at most 2^31 N < 2^62, fits 64 bits; in place, for memory takes the time.
    values = np.arange(ticks + 1, dtype=np.int64) * difference[..., None]
    values += (ticks * start + _first(ticks, tie))[..., None]
    values //= ticks
    return values


def line_ticks(start, stop, ticks, *, tie="up"):
    """Yield the set-values of one move of one axis, tick by tick, as the controller computes them.

    The arguments are those of `time_bresenham` for one axis (start, stop, ticks, tie). A tick
    takes one comparison and two or three additions, and no number leaves the 32-bit range.
    """
    start, difference, ticks = one_move(start, stop, ticks)
    quotient, remainder = divmod(difference, ticks)
    accumulator, complement = int(_first(ticks, tie)), ticks - remainder
    value = start
    yield value
    for _ in range(ticks):
        # Comparing with the complement keeps accumulator + remainder from overflowing; adding the
        # carry to the quotient keeps the value from leaving the range below and coming back.
        if accumulator >= complement:
            accumulator = accumulator - complement
            value = value + (quotient + 1)
        else:
            accumulator = accumulator + remainder
            value = value + quotient
        yield value


def tick_counts(times, tick):
    """Return how many ticks each segment of a timed polyline takes.

    Parameters
    ----------
    times : (k + 1,) float
        When each knot is due, in s, ascending.
    tick : float
        The controller's period, in s.

    Returns
    -------
    ticks : (k,) int64
        Differences of the rounded knots, not rounded differences: no knot is late or early by
        more than half a tick, however long the polyline.

    Raises
    ------
    ValueError
        If the times aren't such a list, or two knots fall on the same tick.

    Examples
    --------
    >>> tick_counts([0, 0.012, 0.024, 0.036], 0.005)
    array([2, 3, 2])
    """
    times, tick = real("times", times), positive("tick", tick)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)):
        raise ValueError(f"times: must be a list of at least two finite times; got {times!r}.")
    if np.any(np.abs(times) > HIGH * tick):
        raise ValueError(f"times: must be at most 2^31 - 1 ticks of {tick:g} s; "
                         f"got {np.abs(times).max():g} s.")  # fmt: skip
    ticks = np.diff(np.floor(times / tick + 0.5).astype(np.int64))
    if np.any(ticks < 1):
        k = int(np.argmax(ticks < 1))
        raise ValueError(
            f"times: each segment must take at least one tick of {tick:g} s; "
            f"got {times[k]:g} s and {times[k + 1]:g} s."
        )
    return ticks


def polyline(knots, ticks, *, tie="up"):
    """Return the set-values of moves one after the other through knots.

    Parameters
    ----------
    knots : (k + 1, n) int
        Positions of n axes, in counts.
    ticks : (k,) int
        Ticks of each segment, as from `tick_counts`.
    tie : {"up", "down"}
        As for `time_bresenham`.

    Returns
    -------
    setvalues : (ticks + 1, n) int64
        In counts, for all ticks together; every knot is met exactly, on its tick.

    Raises
    ------
    ValueError
        As `time_bresenham`, or if the numbers of knots and segments don't fit.

    Examples
    --------
    >>> polyline([[0, 0], [3, -2], [3, 5]], [2, 3]).T.tolist()
    [[0, 2, 3, 3, 3, 3], [0, -1, -2, 0, 3, 5]]
    """
    knots, ticks = _segments(knots, ticks)
    segment = np.repeat(np.arange(len(ticks)), ticks)
    n = np.arange(len(segment)) - (np.cumsum(ticks) - ticks)[segment]
    first = ticks[:, None] * knots[:-1] + _first(ticks, tie)[:, None]
    values = n[:, None] * np.diff(knots, axis=0)[segment]
    values += first[segment]
    values //= ticks[segment, None]
    return np.concatenate([values, knots[-1:]])


def polyline_slopes(knots, ticks):
    """Return the exact slopes D/N (ticks, n) of a `polyline`, in counts a tick.

    They are what velocity feed-forward needs; differences of the set-values (knots, ticks) would
    jump by a count.
    """
    knots, ticks = _segments(knots, ticks)
    return np.repeat(np.diff(knots, axis=0) / ticks[:, None], ticks, axis=0)


def rounding_spectrum(difference, ticks):
    """Return the amplitudes (ticks // 2 + 1,) of the rounding error's harmonics, in counts.

    For a move of `difference` counts in `ticks` ticks without a common factor, as coefficients of
    the discrete Fourier transform over its ticks: 1 / (2 N sin(pi s / N)) with s r = k modulo N.
    The residues of the line are those of a sawtooth in another order, and a multiplication of the
    ticks by r only permutes the harmonics; the mean, of ties alone, is 0 or 1/(2 N).
    """
    ticks = int(whole("ticks", ticks, 1, HIGH))
    difference = int(whole("difference", difference, LOW, HIGH))
    if np.gcd(difference, ticks) != 1:
        raise ValueError(
            f"difference: must have no common factor with {ticks} ticks; got {difference}."
        )
    k = np.arange(ticks // 2 + 1)
    mean = 1 / (2 * ticks) if ticks % 2 == 0 else 0.0
    place = k * pow(difference, -1, ticks) % ticks if ticks > 1 else k
    sine = np.sin(np.pi * place / ticks)
    return np.where(k == 0, mean, 1 / (2 * ticks * np.where(k == 0, 1, sine)))


def checked_move(start, stop, ticks):
    """Return start, stop - start and ticks of moves, each within its 32-bit range.

    start broadcasts with the difference, whose shape is that of the moves.
    """
    ticks = whole("ticks", ticks, 1, HIGH)
    if ticks.ndim:
        raise ValueError(f"ticks: must be one whole number; got an array of shape {ticks.shape}.")
    return *checked_ends(start, stop), ticks


def checked_ends(start, stop, names=("start", "stop")):
    """Return start and stop - start of moves, as `checked_move`; `names` are for messages."""
    first, last = names
    start, stop = whole(first, start, LOW, HIGH), whole(last, stop, LOW, HIGH)
    try:
        difference = stop - start
    except ValueError:
        raise ValueError(
            f"{last}: must broadcast with {first} of shape {start.shape}; got shape {stop.shape}."
        ) from None
    return start, whole(f"{last} - {first}", difference, LOW, HIGH)


def one_move(start, stop, ticks):
    """Return the same of the move of one axis, as whole numbers of Python."""
    start, difference, ticks = checked_move(start, stop, ticks)
    if difference.ndim:
        raise ValueError(
            f"start, stop: must be of one axis; got arrays of shape {difference.shape}."
        )
    return int(start), int(difference), int(ticks)


def _first(ticks, tie):
    """Return the accumulator's first value, half of the ticks: N/2 up, just below it down."""
    if tie not in tuple(TIES):
        raise ValueError(f'tie: must be "up" or "down"; got {tie!r}.')
    return (ticks - TIES[tie]) // 2


def _segments(knots, ticks):
    knots, ticks = whole("knots", knots, LOW, HIGH), whole("ticks", ticks, 1, HIGH)
    if knots.ndim != 2 or ticks.ndim != 1 or len(knots) != len(ticks) + 1 or not len(ticks):
        raise ValueError(
            "knots: must be an array (k + 1, n) for ticks (k,) of k >= 1 segments; "
            f"got {knots.shape} for {ticks.shape}."
        )
    checked_ends(knots[:-1], knots[1:])
    return knots, ticks
