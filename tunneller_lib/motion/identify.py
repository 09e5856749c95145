"""Gains and lags of an axis or of its position loop, from what a controller logged.

The model is T1, a lag and an integrator, sampled with the log's tick. It is run with the logged
input alone, so that noise of the measurement biases nothing, and fitted by least squares. What it
leaves must be noise: else the log doesn't fit a lag, and nothing is said of one.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Duration, Rule, checked
from .loop import Loop
from .plant import Lag
from .quantities import Share, moderate_array
from .servo import follow

LEAST_ROWS = 20
MOST_DELAY = 10  # ticks that are tried
SHORTEST, LONGEST = 1e-2, 1e3  # of a lag, in ticks
STEP = 1e-4  # of a parameter, relative, for derivatives
TIGHT, FINELY = 1e-13, {"xatol": 1e-9}
UNLIKELY = 20.0  # that twice the logarithm of the likelihood falls by, to e^-10
CHANCE = 1e-4  # of noise, below which it isn't taken for noise
NEW = 1e-3  # of a column, without which others have all of it
FEW_BLOCKS = 16  # of rows, whose means are looked at
FINE = 1e-6  # of a column's way: less than that is left by rounding and by the search
SAME = 1e-6  # of a column's way: set-values that move steadily change by more in so few rows
STILL = 1e-4  # of a column's way, by which an axis may creep while the set-values rest
CERTAIN = 4.0  # standard deviations of noise, beyond which an axis moves
WIDE_OPEN = 1e9  # a loop's limit that none is: what the log's valve did isn't known


def _logged(name, value):
    column = moderate_array(name, value)
    if column.ndim != 1 or len(column) < LEAST_ROWS:
        raise ValueError(
            f"{name}: must be one column of {LEAST_ROWS} rows or more; got shape {column.shape}."
        )
    return column


def _shares(name, value):
    column = _logged(name, value)
    most = np.max(np.abs(column))
    if most > 1:
        raise ValueError(f"{name}: must be shares from -1 to 1 of the full valve; got {most:g}.")
    return column


Shares = Annotated[ArrayLike, Rule("(n,) float", _shares)]
Column = Annotated[ArrayLike, Rule("(n,) float", _logged)]
Angles = Annotated[ArrayLike, Rule("(n,) float", _logged, "rad")]


class Estimate(NamedTuple):
    """A number that was identified: its `value` and its standard `error`, in the same unit."""

    value: float
    error: float


@dataclass(frozen=True)
class Identified:
    """What a log says of an axis or of a loop.

    Parameters
    ----------
    gain : Estimate
        Of an axis in rad/s for the full valve, of a loop Kv in 1/s.
    lag : Estimate
        In s.
    delay : int
        Whole ticks, up to 10, that fit best. What other delays, which noise could have been taken
        for it, would say of gain and lag is in their errors.
    rms : float
        Of what the model leaves of the measured column, in its unit.
    """

    gain: Estimate
    lag: Estimate
    delay: int
    rms: float


@checked
def identify_axis(
    valve: Shares, measured: Column, tick: Duration, *, kind: Literal["speed", "position"] = "speed"
):
    """Return gain and lag of an axis, from the valve's opening and what the axis did.

    Parameters
    ----------
    valve : (n,) float
        Opening at the ticks, each held until the next; -1 to 1. Before the log it was as in the
        first row; the axis may move there.
    measured : (n,) float
        Speeds in rad/s, or positions in rad, at the same ticks.
    tick : float
        Between rows, in s.
    kind : {"speed", "position"}
        What was measured.

    Returns
    -------
    found : Identified
        Standard errors are those of white noise on the measurement.

    Raises
    ------
    ValueError
        If the columns differ in length, the valve doesn't move the axis, or what it does doesn't
        fit a lag: what is left is no noise, nor within half a count of the measurement, but
        follows the valve (an overlap, saturation), goes on for several rows, or asks for a delay
        of more than 10 ticks.

    Notes
    -----
    What is left is compared with white noise by the means of 1, 2, 4, .. rows, and by how much of
    it two more columns explain: the model's answer to the valve's sign, and to its square with
    that sign. A log is refused where noise would look so once in ten thousand times. What changes
    the gain by a few of its errors may pass: a valve with two openings alone shows no overlap.

    Examples
    --------
    >>> valve = np.repeat([0.2, -0.1, 0.3, 0.0], 50)
    >>> speed, speeds = 0.0, []
    >>> for opening in valve:
    ...     speeds.append(speed)
    ...     speed = speed + (0.5 * opening - speed) * -np.expm1(-0.005 / 0.02)
    >>> found = identify_axis(valve, speeds, 0.005)
    >>> round(found.gain.value, 3), round(found.lag.value, 4)
    (0.5, 0.02)
    """
    from scipy.optimize import minimize_scalar

    _check_moving("measured", measured, "valve", valve)

    def left(logarithm, delay):
        columns = _columns(valve, tick, np.exp(logarithm), delay, kind)
        return float(np.sum((columns @ _solved(columns, measured) - measured) ** 2))

    def fit(delay):
        bounds = np.log(np.array([SHORTEST, LONGEST]) * tick)
        found = minimize_scalar(
            left, bounds=bounds, args=(delay,), method="bounded", options=FINELY
        )
        return float(found.fun), delay, float(np.exp(found.x))

    def about(delay, lag):
        columns = _columns(valve, tick, lag, delay, kind)
        weights = _solved(columns, measured)
        steps = [
            _columns(valve, tick, lag * (1 + side * STEP), delay, kind) @ weights
            for side in (1, -1)
        ]
        slope = (steps[0] - steps[1]) / (2 * lag * STEP)
        jacobian = np.concatenate([slope[:, None], columns], axis=1)
        return (
            (weights[0], lag),
            jacobian[:, [1, 0, *range(2, jacobian.shape[1])]],
            (columns @ weights - measured),
        )

    def bent(delay, lag):
        others = np.sign(valve), valve * np.abs(valve)
        return [_columns(other, tick, lag, delay, kind)[:, 0] for other in others]

    return _judged("measured", measured, _fits(fit, measured), about, bent)


@checked
def identify_loop(setvalue: Angles, actual: Angles, tick: Duration, *, feedforward: Share(2) = 0.0):
    """Return gain and lag of a position loop, from set and actual positions.

    Parameters
    ----------
    setvalue, actual : (n,) float
        Of one axis at the ticks, in rad. The log must begin at rest: in its first 10 rows or more
        the set-values stay the same, and before they change the axis moves no more than noise
        and resolution explain.
    tick : float
        Between rows, in s, which is the loop's.
    feedforward : float
        Share of the set-values' slope that the loop adds, as it is set. A log of smooth motions
        can't tell it from the gain: both make the axis trail less.

    Returns
    -------
    found : Identified
        As of `identify_axis`; the valve must not have been fully open.

    Raises
    ------
    ValueError
        If the columns differ in length, the log doesn't begin at rest, or the set-values stay the
        same.
    """
    from scipy.optimize import least_squares

    _check_moving("actual", actual, "setvalue", setvalue)
    _check_rest(setvalue, actual)
    slopes = np.diff(setvalue) / tick

    def residual(numbers, delay):
        gain, lag = np.exp(numbers)
        loop = Loop(float(gain), tick, feedforward=feedforward, delay=delay, limit=WIDE_OPEN)
        track = follow.unchecked(Lag(1.0, float(lag)), loop, setvalue, slopes=slopes)
        off = track.position - actual
        return off - np.mean(off)  # where the encoder has its zero doesn't matter

    low = np.array([np.log(1e-3 / tick), np.log(SHORTEST * tick)])
    high = np.array([np.log(3 / tick), np.log(LONGEST * tick)])
    start = np.array([np.log(0.05 / tick), np.log(2 * tick)])

    def fit(delay):
        found = least_squares(
            lambda numbers: residual(numbers, delay),
            start,
            bounds=(low, high),
            x_scale=(0.1, 0.3),
            diff_step=STEP,
            ftol=TIGHT,
            xtol=TIGHT,
            gtol=TIGHT,
        )
        return 2 * float(found.cost), delay, found

    def about(_, found):
        numbers = np.exp(found.x)
        return numbers, found.jac / numbers, found.fun

    def bent(delay, found):
        gain, lag = np.exp(found.x).tolist()
        loop = Loop(gain, tick, delay=delay, limit=WIDE_OPEN)
        slope = np.append(slopes, 0.0)
        others = np.sign(slope), slope * np.abs(slope)
        answers = [follow.unchecked(Lag(1.0, lag), loop, other).position for other in others]
        return [answer - np.mean(answer) for answer in answers]

    return _judged("actual", actual, _fits(fit, actual), about, bent)


def _check_moving(name, column, input_name, given):
    """Raise ValueError if an axis' column and its input aren't of one length, or one is still."""
    if len(column) != len(given):
        raise ValueError(
            f"{name}: must have as many rows as {input_name}, {len(given)}; got {len(column)}."
        )
    if not np.ptp(given):
        raise ValueError(f"{input_name}: must move the axis; got a column that stays the same.")
    if not np.ptp(column):
        raise ValueError(
            f"{name}: must be of an axis that moves; got a column that stays the same."
        )


def _check_rest(setvalue, actual):
    """Raise ValueError if a loop moves in the rows that the longest delay still acts on."""
    moved = np.ptp(setvalue[:MOST_DELAY])
    if moved > SAME * np.ptp(setvalue):
        raise ValueError(
            f"setvalue: must stay the same in the first {MOST_DELAY} rows, since a log of a loop "
            f"must begin at rest; got a change of {moved:.3g} rad."
        )
    # All rows before the first change tell of a creep that noise hides in ten.
    half = int(np.argmax(np.abs(setvalue - setvalue[0]) > SAME * np.ptp(setvalue))) // 2
    crept = abs(actual[half : 2 * half].mean() - actual[:half].mean())
    # Second differences show white noise sqrt(6)-fold and hardly the motion; the median of their
    # sizes is 0.6745 of their deviation, whatever jerks there are.
    noise = np.median(np.abs(np.diff(actual, 2))) / (0.6745 * np.sqrt(6))
    steps = np.abs(np.diff(actual))
    resolution = steps[steps > 0].min()
    explained = CERTAIN * noise * np.sqrt(2 / half) + resolution
    if crept > explained + STILL * np.ptp(actual):
        raise ValueError(
            f"actual: must rest in the first {2 * half} rows, as the set-values do, since a log of "
            f"a loop must begin at rest; got means of their halves that are {crept:.3g} rad apart."
        )


def _fits(fit, measured):
    """Return fits (squares left, delay, ..) of the delays from 0 on, to where they are unlikely.

    Beyond the longest delay that may be answered some more are tried: who knows no better fit
    would take the last one for the best.
    """
    fits = [fit(0), fit(1)]
    while len(fits) <= 2 * MOST_DELAY:
        fits.append(fit(len(fits)))
        if fits[-1][0] > fits[-2][0] > fits[-3][0] and not _likelihood(fits, measured)[-1]:
            break
    return fits


def _likelihood(fits, measured):
    """Return how likely each fit is, relative to the best one; 0 if it is as good as impossible."""
    rows, squares = len(measured), np.array([fit[0] for fit in fits])
    floor = rows * (1e-9 * np.ptp(measured)) ** 2  # of logs without noise
    fell = rows * np.log((squares + floor) / (squares.min() + floor))
    return np.where(fell < UNLIKELY, np.exp(-fell / 2), 0.0)


def _judged(name, measured, fits, about, bent):
    """Return what was identified, or raise ValueError where a column called `name` fits no lag.

    Parameters
    ----------
    name : str
    measured : (n,) float
    fits : list of (squares left, delay, ..)
    about : callable
        Of the rest of a fit: returns the numbers gain and lag, the derivatives (n, k) by them and
        by what else was fitted, and what is left (n,).
    bent : callable
        Of the same: returns columns that a lag has no use for, and another axis has.
    """
    weights = _likelihood(fits, measured)
    _, delay, *_ = best = fits[int(np.argmax(weights))]
    if delay > MOST_DELAY:
        raise ValueError(
            f"{name}: doesn't fit a lag with a delay of at most {MOST_DELAY} ticks; got one of "
            f"about {delay}."
        )
    found = [about(*fit[1:]) for fit, weight in zip(fits, weights, strict=True) if weight]
    numbers, jacobian, left = about(*best[1:])
    errors, rms = _errors(jacobian, left)
    widened = _check_noise(name, measured, jacobian, left, rms, bent(*best[1:]))
    away = np.array([other for other, *_ in found]) - numbers
    likely = weights[weights > 0]
    others = np.sqrt(likely @ away**2 / likely.sum())
    gain, lag = (
        Estimate(float(number), float(np.hypot(widened * error, other)))
        for number, error, other in zip(numbers, errors, others, strict=False)
    )
    return Identified(gain, lag, delay, rms)


def _check_noise(name, measured, jacobian, left, rms, bent):
    """Raise ValueError if what is left isn't noise; return the factor by which errors are wider.

    Where it is below half a count, or what rounding leaves, nobody could tell: errors are then
    those of noise that is as slow as what is left.
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
        chances.append(gammaincc(blocks / 2, squares / 2))
    steps = np.abs(np.diff(measured))
    if rms <= max(FINE * np.ptp(measured), steps[steps > 0].min() / 2):
        return float(np.sqrt(max(ratios)))
    bent = np.stack(bent, axis=1)
    known = np.linalg.qr(jacobian / _norms(jacobian))[0]
    more = bent - known @ (known.T @ bent)
    more = more[:, _norms(more) > NEW * _norms(bent)]
    explained = np.sum((np.linalg.qr(more)[0].T @ left) ** 2) / rms**2
    follows = gammaincc(more.shape[1] / 2, explained / 2) if more.size else 1.0
    if min(*chances, follows) >= CHANCE:
        return 1.0
    # Second differences show white noise sqrt(6)-fold, and hardly what is slower.
    noise = float(np.median(np.abs(np.diff(left, 2))) / (0.6745 * np.sqrt(6)))
    why = "which bends with the input, as with an overlap or where a valve is full"
    if follows > min(chances):
        why = "which goes on from row to row"
    raise ValueError(
        f"{name}: doesn't fit a lag: what it leaves must be noise; got {rms:.3g} rms, {why}, where "
        f"neighbouring rows show noise of {noise:.2g}."
    )


def _columns(valve, tick, lag, delay, kind):
    """Return what each unknown adds to the measured column, (n, 2) or (n, 3), for a lag in s.

    The unknowns are the gain and the first speed, of positions also the first position.
    """
    from scipy.signal import lfilter

    (_, drift), (_, kept) = Lag(1.0, lag).discrete(tick)[0]
    pushed, taken = Lag(1.0, lag).discrete(tick)[1]
    late = np.concatenate([np.full(delay, valve[0]), valve])[: len(valve)]
    # The state after a tick: speed' = kept speed + taken u, position' = position + drift speed + ..
    speed = lfilter([0.0, taken], [1.0, -kept], late)
    free = kept ** np.arange(len(valve))
    if kind == "speed":
        return np.stack([speed, free], axis=-1)
    moved = np.concatenate([[0.0], np.cumsum(drift * speed + pushed * late)[:-1]])
    coasted = np.concatenate([[0.0], np.cumsum(drift * free)[:-1]])
    return np.stack([moved, coasted, np.ones(len(valve))], axis=-1)


def _solved(columns, measured):
    """Return the weights that make columns come closest to what was measured."""
    scale = _norms(columns)
    return np.linalg.lstsq(columns / scale, measured, rcond=None)[0] / scale


def _errors(jacobian, residual):
    """Return the standard errors of parameters, and the residual's root mean square."""
    rows, unknowns = jacobian.shape
    rms = float(np.sqrt(np.sum(residual**2) / (rows - unknowns)))
    scale = _norms(jacobian)
    spread = np.linalg.pinv(jacobian / scale)  # of covariance spread spread' rms^2
    return (rms * np.linalg.norm(spread, axis=1) / scale).tolist(), rms


def _norms(columns):
    """Return the norms of columns, by which each may be divided: 1 of one that is zero."""
    norms = np.linalg.norm(columns, axis=0)
    norms[norms == 0] = 1.0
    return norms
