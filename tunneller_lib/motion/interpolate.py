"""Straight lines in time, in whole numbers: Bresenham's line whose major axis is the tick.

A set-value is a number of encoder counts; all axes share one clock.
"""

import math
from typing import Literal

import numpy as np

from ..arguments import Array, Duration, Whole, Wholes, checked, whole

LOW, HIGH = -(2**31), 2**31 - 1  # what a controller's 32-bit integer holds
TIES = {"up": 0, "down": 1}
MOST_SCALE = 2**30  # greatest product of a segment's ticks and the parts of a count
MOST_SETVALUES = 2**25  # in one array, which then takes 256 MiB

Tie = Literal["up", "down"]
Ends = Wholes("(...) int", LOW, HIGH)
Times = Array("(k + 1,) float", "s")
Knots = Wholes("(k + 1, n) int", LOW, HIGH)
Parts = Whole(1, 2**16)
SegmentTicks = Wholes("(k,) int", 1, HIGH)


@checked
def time_bresenham(start: Ends, stop: Ends, ticks: Whole(1, HIGH), *, tie: Tie = "up"):
    """Return the set-values of straight moves, one for each tick.

    Parameters
    ----------
    start, stop : (...) int
        Ends of the moves, in counts; they broadcast. They and their differences must be 32-bit
        integers.
    ticks : int
        Number of ticks that each move takes, at least 1.
    tie : {"up", "down"}
        The direction in which half a count is rounded.

    Returns
    -------
    setvalues : (..., ticks + 1) int64
        In counts; the first is `start`, the last is `stop`.

    Raises
    ------
    ValueError
        If a number isn't whole or is beyond its range, or there are more than 2^25 set-values.

    Notes
    -----
    Tunnelling robot, section 4.3, whose listing computes this line in floating point, with ties
    down. The closed form (n D + N start + N // 2) // N, with the difference D and N ticks, is the
    exact line rounded to the nearest count: its error is at most half a count, and its end is
    exact. The exported block computes the same numbers without a product or a quotient.

    Examples
    --------
    >>> time_bresenham(5, 30, 10)
    array([ 5,  8, 10, 13, 15, 18, 20, 23, 25, 28, 30])
    >>> time_bresenham([0, 7], [-3, 7], 2).tolist()
    [[0, -1, -3], [7, 7, 7]]
    """
    difference = _difference("stop - start", start, stop)
    _limit_setvalues(difference.size, ticks)
    # N times the line, at most 2^31 N < 2^62, fits 64 bits. It is computed in place, since memory
    # takes most of the time.
    values = np.arange(ticks + 1, dtype=np.int64) * difference[..., None]
    values += (ticks * start + _first(ticks, tie))[..., None]
    values //= ticks
    return values


@checked
def tick_counts(times: Times, tick: Duration):
    """Return the number of ticks of each segment of a timed polyline.

    Parameters
    ----------
    times : (k + 1,) float
        The time at which each knot is due, in s, ascending.
    tick : float
        The controller's period, in s.

    Returns
    -------
    ticks : (k,) int64
        Differences of the rounded times, so that no knot is late or early by more than half a
        tick, however long the polyline is.

    Raises
    ------
    ValueError
        If there are fewer than two times, or two knots fall on the same tick.

    Examples
    --------
    >>> tick_counts([0, 0.012, 0.024, 0.036], 0.005)
    array([2, 3, 2])
    """
    if len(times) < 2:
        raise ValueError(f"times: must be at least two; got {len(times)}.")
    latest = np.abs(times).max()
    if latest > HIGH * tick:
        raise ValueError(f"times: must be at most 2^31 - 1 ticks of {tick:g} s; got {latest:g} s.")
    ticks = np.diff(np.floor(times / tick + 0.5).astype(np.int64))
    if np.any(ticks < 1):
        k = int(np.argmax(ticks < 1))
        raise ValueError(
            f"times: each segment must take at least one tick of {tick:g} s; "
            f"got {times[k]:g} s and {times[k + 1]:g} s."
        )
    return ticks


@checked
def polyline(knots: Knots, ticks: SegmentTicks, *, tie: Tie = "up", parts: Parts = 1):
    """Return the set-values of straight moves from knot to knot.

    Parameters
    ----------
    knots : (k + 1, n) int
        Positions of n axes, in counts or equal parts of them.
    ticks : (k,) int
        Ticks of each segment, as from `tick_counts`.
    tie : {"up", "down"}
        As for `time_bresenham`.
    parts : int
        Number of parts of a count in which the knots are given, so that lines may begin and end
        between counts: at most 65536, and, above 1, at most 2^30 times a segment's ticks.

    Returns
    -------
    setvalues : (ticks + 1, n) int64
        The exact lines rounded to the nearest count. With `parts` 1 every knot is met exactly, on
        its tick.

    Raises
    ------
    ValueError
        As by `time_bresenham`, or if the numbers of knots and segments don't fit.

    Examples
    --------
    >>> polyline([[0, 0], [3, -2], [3, 5]], [2, 3]).T.tolist()
    [[0, 2, 3, 3, 3, 3], [0, -1, -2, 0, 3, 5]]
    >>> polyline([[0, 0], [3, -2], [3, 5]], [2, 3, 4])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: knots: must be an array (k + 1, n) for ... segments; got (3, 2) for (3,).
    """
    _check_segments(knots, ticks)
    scale = _scale(ticks, parts)
    segment = np.repeat(np.arange(len(ticks)), ticks.astype(np.intp))
    n = np.arange(len(segment)) - (np.cumsum(ticks) - ticks)[segment]
    first = ticks[:, None] * knots[:-1] + _first(scale, tie)[:, None]
    values = n[:, None] * np.diff(knots, axis=0)[segment]
    values += first[segment]
    values //= scale[segment, None]
    return np.concatenate([values, (knots[-1:] + _first(parts, tie)) // parts])


@checked
def polyline_slopes(knots: Knots, ticks: SegmentTicks, *, parts: Parts = 1):
    """Return the exact slopes D/N of a `polyline`.

    Velocity feed-forward needs them, since differences of set-values jump by a whole count.

    Parameters
    ----------
    knots, ticks, parts
        As for `polyline`: (k + 1, n) int, (k,) int and an int.

    Returns
    -------
    slopes : (ticks, n) float
        In counts per tick.
    """
    _check_segments(knots, ticks)
    scale = _scale(ticks, parts)
    return np.repeat(np.diff(knots, axis=0) / scale[:, None], ticks.astype(np.intp), axis=0)


@checked
def rounding_spectrum(difference: Whole(LOW, HIGH), ticks: Whole(1, MOST_SETVALUES)):
    """Return the amplitudes (ticks // 2 + 1,) of the rounding error's harmonics, in counts.

    For a move of r counts in N ticks without a common factor, harmonic k of the discrete Fourier
    transform over the ticks has the amplitude 1 / (2 N sin(pi s / N)) with s r = k modulo N: the
    errors are those of a sawtooth in another order, and multiplying the ticks by r only permutes
    the harmonics. The mean, which only a tie leaves, is 1/(2 N) for even N and else 0.
    """
    if math.gcd(difference, ticks) != 1:
        raise ValueError(
            f"difference: must have no common factor with {ticks} ticks; got {difference}."
        )
    k = np.arange(ticks // 2 + 1)
    mean = 1 / (2 * ticks) if ticks % 2 == 0 else 0.0
    place = k * pow(difference, -1, ticks) % ticks if ticks > 1 else k
    sine = np.sin(np.pi * place / ticks)
    return np.where(k == 0, mean, 1 / (2 * ticks * np.where(k == 0, 1, sine)))


def _difference(name, start, stop):
    """Return stop - start, which must fit 32 bits as well."""
    return whole(name, stop - start, LOW, HIGH)


def _limit_setvalues(moves, ticks):
    """Raise ValueError if an array would hold more than 2^25 set-values."""
    if moves * (ticks + 1) > MOST_SETVALUES:
        raise ValueError(
            f"ticks: set-values must be at most {MOST_SETVALUES} in all; got {ticks} ticks of "
            f"{moves} moves."
        )


def _first(ticks, tie):
    """Return the accumulator's first value: N // 2 to round ties up, (N - 1) // 2 for down."""
    return (ticks - TIES[tie]) // 2


def _scale(ticks, parts):
    """Return ticks times parts; a controller's 32-bit accumulator reaches 1.5 times that."""
    scale = ticks * parts
    if parts > 1 and np.any(scale > MOST_SCALE):
        raise ValueError(
            f"ticks: must be at most {MOST_SCALE // parts} with {parts} parts of a count; "
            f"got {int(ticks.max())}."
        )
    return scale


def _check_segments(knots, ticks):
    """Raise ValueError if knots and ticks don't fit, or a move is too long."""
    if len(knots) != len(ticks) + 1 or not len(ticks):
        raise ValueError(
            "knots: must be an array (k + 1, n) for ticks (k,) of k >= 1 segments; "
            f"got {knots.shape} for {ticks.shape}."
        )
    _difference("knots[1:] - knots[:-1]", knots[:-1], knots[1:])
    _limit_setvalues(knots.shape[1], int(ticks.sum()))
