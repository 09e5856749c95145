"""Gain, lag and delay of an axis, from what a controller logged.

The model is T1, a lag and an integrator, sampled with the log's tick and fitted by least squares.
The logged valve alone drives it, so noise of the measurement biases nothing. A log that a lag
doesn't fit is refused: its errors would mean nothing.
"""

from typing import Literal, NamedTuple

import numpy as np

from ..arguments import Array, Duration, checked
from .plant import Lag

LEAST_ROWS = 20
MOST_DELAY = 10  # ticks
SHORTEST, LONGEST = 1e-2, 1e3  # lags that are tried, in ticks
STEP = 1e-4  # of the lag, relative, for the derivative
FINELY = {"xatol": 1e-9}  # of the lag's logarithm
CHANCE = 1e-4  # below which a residual is not taken for white noise
FEW_BLOCKS = 16  # of rows, whose means are looked at
FINE = 1e-6  # of the measured range, below which a residual is left by rounding and by the search

Shares = Array("(n,) float", low=-1.0, high=1.0)
Column = Array("(n,) float", low=-1e15, high=1e15)


class Identified(NamedTuple):
    """What a log says of an axis.

    Parameters
    ----------
    gain, gain_error : float
        Speed for the full valve and its standard error, in rad/s.
    lag, lag_error : float
        Time constant and its standard error, in s.
    delay : int
        Whole ticks that fit best. The errors contain what other likely delays would say.
    rms : float
        Root mean square of the residual, in the unit of the measured column.
    """

    gain: float
    gain_error: float
    lag: float
    lag_error: float
    delay: int
    rms: float


@checked
def identify_axis(
    valve: Shares, measured: Column, tick: Duration, *, kind: Literal["speed", "position"] = "speed"
):
    """Return gain, lag and delay of an axis, from the valve's opening and the axis' motion.

    Parameters
    ----------
    valve : (n,) float
        Opening from -1 to 1 at each tick, held until the next. The axis may move at the beginning;
        before, the valve was open as in the first row.
    measured : (n,) float
        Speeds in rad/s or positions in rad, at the same ticks.
    tick : float
        Between rows, in s.
    kind : {"speed", "position"}
        What was measured.

    Returns
    -------
    found : Identified
        Standard errors are those for white noise in the measurement.

    Raises
    ------
    ValueError
        If there are fewer than 20 rows, the columns differ in length, one of them stays the same,
        or a lag doesn't fit: the residual isn't white noise, nor within half a count of the
        measurement, or a delay of more than 10 ticks would fit better.

    Notes
    -----
    The residual is tested by the means of 1, 2, 4, .. rows: each test refuses white noise once in
    ten thousand logs. An overlap or a saturation that noise hides may pass.

    Examples
    --------
    >>> valve = np.repeat([0.2, -0.1, 0.3, 0.0], 50)
    >>> speed, speeds = 0.0, []
    >>> for opening in valve:
    ...     speeds.append(speed)
    ...     speed = speed + (0.5 * opening - speed) * -np.expm1(-0.005 / 0.02)
    >>> found = identify_axis(valve, speeds, 0.005)
    >>> round(found.gain, 3), round(found.lag, 4)
    (0.5, 0.02)
    """
    from scipy.optimize import minimize_scalar

    rows = len(valve)
    if rows < LEAST_ROWS or len(measured) != rows:
        raise ValueError(
            f"measured: must have as many rows as valve, at least {LEAST_ROWS}; "
            f"got {len(measured)} and {rows}."
        )
    for name, column in (("valve", valve), ("measured", measured)):
        if not np.ptp(column):
            raise ValueError(f"{name}: must change; got a column that stays the same.")

    def fit(lag, delay):
        """Return the columns of the unknowns, their weights, and the residual."""
        columns = _columns(valve, tick, lag, delay, kind)
        weights = np.linalg.lstsq(columns, measured, rcond=None)[0]
        return columns, weights, columns @ weights - measured

    def squares_left(logarithm, delay):
        return float(np.sum(fit(np.exp(logarithm), delay)[2] ** 2))

    bounds = np.log(np.array([SHORTEST, LONGEST]) * tick)
    found = [
        minimize_scalar(
            squares_left, bounds=bounds, args=(delay,), method="bounded", options=FINELY
        )
        for delay in range(MOST_DELAY + 2)  # one too many, by which to tell a longer delay
    ]
    squares = np.array([one.fun for one in found])
    lags = np.exp([one.x for one in found])
    gains = np.array([fit(one, delay)[1][0] for delay, one in enumerate(lags)])
    delay = int(np.argmin(squares))
    if delay > MOST_DELAY:
        raise ValueError(
            f"measured: must fit a lag with a delay of at most {MOST_DELAY} ticks; "
            f"{MOST_DELAY + 1} or more would fit better."
        )
    lag = float(lags[delay])
    columns, weights, left = fit(lag, delay)
    steps = [_columns(valve, tick, lag * (1 + h), delay, kind) @ weights for h in (STEP, -STEP)]
    jacobian = np.column_stack([columns, (steps[0] - steps[1]) / (2 * STEP * lag)])
    rms = float(np.sqrt(np.sum(left**2) / (rows - jacobian.shape[1])))
    # The covariance of the unknowns is rms^2 P P', with the pseudoinverse P.
    errors = rms * np.linalg.norm(np.linalg.pinv(jacobian), axis=1)
    errors *= _widening(measured, left, rms)
    # How likely each delay is, relative to the best one; logs without noise leave rounding.
    floor = rows * (1e-9 * np.ptp(measured)) ** 2
    likely = ((squares[delay] + floor) / (squares + floor)) ** (rows / 2)
    likely /= likely.sum()
    spread = [np.sqrt(likely @ (one - one[delay]) ** 2) for one in (gains, lags)]
    gain_error, lag_error = np.hypot(errors[[0, -1]], spread).tolist()
    return Identified(float(weights[0]), gain_error, lag, lag_error, delay, rms)


def _columns(valve, tick, lag, delay, kind):
    """Return what each unknown adds to the measured column, (n, 2) or (n, 3), for a lag in s.

    The unknowns are the gain and the first speed, and of positions the first position.
    """
    from scipy.signal import lfilter

    Ad, (pushed, taken) = Lag(1.0, lag).discrete(tick)
    drift, kept = Ad[:, 1]
    late = np.concatenate([np.full(delay, valve[0]), valve])[: len(valve)]
    # speed' = kept speed + taken u,  position' = position + drift speed + pushed u
    speed = lfilter([0.0, taken], [1.0, -kept], late)
    free = kept ** np.arange(len(valve))
    if kind == "speed":
        return np.column_stack([speed, free])
    ways = np.cumsum([drift * speed + pushed * late, drift * free], axis=1)
    moved, coasted = np.pad(ways[:, :-1], ((0, 0), (1, 0)))
    return np.column_stack([moved, coasted, np.ones(len(valve))])


def _widening(measured, left, rms):
    """Return the factor of the errors, or raise ValueError if the residual isn't white noise.

    Below half a count of the measurement nobody could tell: the errors then get as much wider as
    the means of blocks of rows are than those of white noise.
    """
    from scipy.special import gammaincc

    if not rms:
        return 1.0
    ratios, chances = [1.0], []
    for size in 2 ** np.arange(int(np.log2(len(left) / FEW_BLOCKS)) + 1):
        blocks = len(left) // size
        means = left[: blocks * size].reshape(blocks, size).mean(axis=1)
        squares = size * np.sum((means / rms) ** 2)
        ratios.append(squares / blocks)
        chances.append(gammaincc(blocks / 2, squares / 2))  # of chi-square
    steps = np.abs(np.diff(measured))
    if rms <= max(FINE * np.ptp(measured), steps[steps > 0].min() / 2):
        return float(np.sqrt(max(ratios)))
    if min(chances) < CHANCE:
        raise ValueError(
            f"measured: must fit a lag, which leaves white noise; got {rms:.3g} rms whose rows go "
            "together."
        )
    return 1.0
