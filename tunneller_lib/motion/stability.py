"""Limits of the gain: in closed form, and by eigenvalues.

Gains are Kv, the wanted rate per following error, in 1/s. A plant's own gain K doesn't matter,
since the static inverse divides by it.
"""

from functools import lru_cache

import numpy as np

from ..arguments import Angles, Whole, Wholes, checked
from .loop import MOST_DELAY, Loop
from .plant import Lag, LinearPlant, Plant, Resonance
from .quantities import Quantity, Quantity0, Tick, Ticks

GENTLE = 1e-3  # 1/s, a gain at which every loop of the study is stable
GAINS = 60  # gains tried for a loop with an integral
FINER = 5  # times that they are, each time between the two beside the calmest


@checked
def delay_limit(tick: Tick, delay: Whole(0, MOST_DELAY) = 0):
    """Return the gain limit of T0 under a P loop with a delay in ticks, in 1/s.

    It is 2 sin(pi / (2 (2 m + 1))) / T for a tick T in s and a delay of m ticks, at which roots of
    z^m (z - 1) + Kv T leave the unit circle; without delay it is 2 / T.
    """
    return 2 * np.sin(np.pi / (2 * (2 * delay + 1))) / tick


@checked
def lag_limit(lag: Quantity, tick: Tick):
    """Return the gain limit of T1, with a lag in s, under a P loop with a tick in s, in 1/s.

    It follows from Jury's criterion for z^2 + (Kv b1 - 1 - a) z + a + Kv b0, with a = exp(-T/lag).
    As the tick vanishes the limit goes to infinity; as the lag vanishes it goes to 2 / T.
    """
    Ad, Bd = Lag(1.0, lag).discrete(tick)
    a = Ad[1, 1]
    b1 = Bd[0]
    b0 = tick * Bd[1] - b1  # lag (1 - a) - a T, since b1 + b0 = T (1 - a)
    # The constant term reaches 1, where a pair turns about; or the value at z = -1 reaches 0, where
    # the error alternates.
    turning = Bd[1] / b0 if b0 > 0 else np.inf
    alternating = 2 * (1 + a) / (b1 - b0) if b1 > b0 else np.inf
    return min(turning, alternating)


@checked
def integral_limits(integral: Quantity, tick: Tick):
    """Return the least and the greatest gain of T0 under a PI loop without delay, in 1/s.

    They are Ki T and (4 + Ki T^2) / (2 T) for an `integral` Ki in 1/s^2 and a tick T in s, by
    Jury's criterion for z^2 + (Kv T - 2) z + 1 - Kv T + Ki T^2. From Ki T^2 = 4 on there is none.
    """
    return integral * tick, (4 + integral * tick**2) / (2 * tick)


@checked
def resonance_limit(frequency: Quantity, damping: Quantity, lag: Quantity0 = 0.0):
    """Return the gain limit 2 zeta w of a resonance under a continuous P loop, in 1/s.

    It follows from Routh's criterion for s^3 + 2 zeta w s^2 + w^2 s + Kv w^2, with the `frequency`
    w in rad/s and the `damping` ratio zeta, and is the practical limit of a hydraulic axis. A valve
    with a `lag` in s multiplies it by (1 + 2 zeta w lag + (w lag)^2) / (1 + 2 zeta w lag)^2; for
    small swings of T3 it is also divided by `Hydraulics.swing`.
    """
    rate = 2 * damping * frequency
    return rate * (1 + rate * lag + (frequency * lag) ** 2) / (1 + rate * lag) ** 2


@checked
def sampled_resonance_limit(frequency: Quantity, damping: Quantity, tick: Tick):
    """Return the gain limit of a resonance under a P loop with a tick in s, in 1/s.

    It follows from Jury's criterion for (z - 1)(z^2 - t z + d) + Kv (b2 z^2 + b1 z + b0), with
    d = exp(-2 zeta w T) the product and t the sum of the resonance's two roots. As the tick
    vanishes it becomes `resonance_limit`. The `frequency` w is in rad/s, `damping` is the ratio
    zeta.

    Notes
    -----
    Roots of z^3 + a2 z^2 + a1 z + a0 leave the unit circle at z = -1, where 1 - a2 + a1 - a0 = 0,
    or as a pair, where 1 - a1 + a0 a2 - a0^2 = 0. The first is linear in Kv, the second quadratic;
    the limit is the least positive Kv that solves one of them.
    """
    Ad, Bd = Resonance(1.0, frequency, damping).discrete(tick)
    t = Ad[1, 1] + Ad[2, 2]
    d = np.exp(-2 * damping * frequency * tick)
    # The positions one, two and three ticks after a command of one tick begins are the first
    # coefficients of the quotient in powers of 1/z; times the denominator they give the numerator.
    h1 = Bd[0]
    h2 = (Ad @ Bd)[0]
    h3 = (Ad @ Ad @ Bd)[0]
    b2 = h1
    b1 = h2 - (1 + t) * h1
    b0 = h3 - (1 + t) * h2 + (t + d) * h1
    # This is (1 - d)(1 - t + d), where 1 - t + d would cancel for short ticks. The numerator's sum
    # over the tick is equal to it, since the gain from command to steady rate is 1, and keeps its
    # digits.
    constant = -np.expm1(-2 * damping * frequency * tick) * (b2 + b1 + b0) / tick
    roots = np.roots([b0 * (b2 - b0), (2 * d - 1 - t) * b0 - b1 - d * b2, constant])
    limits = [root.real for root in roots if root.imag == 0 and root.real > 0]
    limits += [2 * (1 + t + d) / (b2 + b0 - b1)] if b2 + b0 > b1 else []
    return float(min(limits))


@lru_cache(256)  # a search for a gain asks again and again
def _discrete(plant, tick):
    """Return Ad and Bd of a plant."""
    return plant.discrete(tick)


def _closed_loop(plant, loop, gain):
    """Return the matrix of a linear closed loop with a `gain` in 1/s from tick to tick.

    The state is that of the `plant`, then the integral of the error if there is one, then the
    commands that a `loop` with a delay holds back, oldest first. Set-values are zero, and the valve
    doesn't saturate.
    """
    Ad, Bd = _discrete(plant, loop.tick)
    order = len(Bd)
    m = loop.delay
    matrix = np.zeros((order + 1 + m, order + 1 + m))
    command = np.zeros(len(matrix))
    command[0] = plant.command(-gain)
    command[order] = plant.command(1.0)
    matrix[:order, :order] = Ad
    # The integral grows by -Ki T times the position, since the set-value is zero.
    matrix[order, [0, order]] = -loop.integral * loop.tick, 1
    if m == 0:
        matrix[:order] += np.outer(Bd, command)
    else:
        # The oldest command drives the plant, the others move up, the new one joins at the end.
        matrix[:order, order + 1] = Bd
        matrix[range(order + 1, order + m), range(order + 2, order + m + 1)] = 1
        matrix[-1] = command
    if loop.integral == 0:  # its row would add an eigenvalue 1 that isn't the loop's
        matrix = np.delete(np.delete(matrix, order, axis=0), order, axis=1)
    return matrix


@checked
def is_stable(plant: Plant, loop: Loop, angles: Angles = (0.0,)):
    """Return whether a closed loop is stable in small motions about rest.

    The plant is judged by its linear form at each of some joint angles in rad, without the
    encoder's rounding and the limit of the valve.
    """
    return all(bool(_radius(one, loop, loop.gain) < 1) for one in _models(plant, angles))


@checked
def gain_limit(plant: Plant, loop: Loop, angles: Angles = (0.0,)):
    """Return the gain below which a loop is stable at all the given joint angles in rad, in 1/s.

    The loop's own gain doesn't matter. A loop with an integral raises ValueError, since it needs a
    least gain as well: see `stable_gains`.
    """
    if loop.integral:
        raise ValueError(f"loop: must be without integral; got {loop.integral:g} 1/s^2.")
    return stable_gains(plant, loop, angles)[1]


@checked
def stable_gains(plant: Plant, loop: Loop, angles: Angles = (0.0,)):
    """Return the gains between which a loop is stable at all the given joint angles, in 1/s.

    Parameters
    ----------
    plant : Plant
        The axis, which must have a linear form.
    loop : Loop
        The loop. Its own gain doesn't matter, its integral does.
    angles : (...) float
        Joint angles, in rad.

    Returns
    -------
    low, high : float
        Without an integral `low` is 0. If no gain is found that is stable they are ``inf`` and 0.

    Raises
    ------
    ValueError
        If there is no angle.
    """
    if not np.size(angles):
        raise ValueError("angles: must hold one joint angle at least; got none.")
    models = _models(plant, angles)
    # The matrix is linear in the gain: two of them for each model give those of all gains at once.
    still = np.stack([_closed_loop(one, loop, 0.0) for one in models])
    by_gain = np.stack([_closed_loop(one, loop, 1.0) for one in models]) - still
    growth = lambda gain: np.abs(np.linalg.eigvals(still + gain * by_gain)).max() - 1  # noqa: E731
    if not loop.integral:
        return 0.0, _first_unstable(growth, GENTLE, 1.25)
    least, most = GENTLE, 10 / loop.tick
    for _ in range(FINER):
        tried = np.geomspace(least, most, GAINS)
        grows = [growth(gain) for gain in tried]
        calmest = int(np.argmin(grows))
        if grows[calmest] < 0:
            break
        # Stable gains may still lie between two of these, beside the calmest.
        least, most = tried[max(calmest - 1, 0)], tried[min(calmest + 1, GAINS - 1)]
    else:
        return np.inf, 0.0
    start = float(tried[calmest])
    low, high = (_first_unstable(growth, start, factor) for factor in (0.8, 1.25))
    return float(low), float(high)


def _models(plant, angles):
    """Return the set of linear models of small motions about rest at joint angles in rad."""
    return {plant.linear(angle) for angle in np.ravel(angles).tolist()}


@checked
def eigenvalue_limit(plant: LinearPlant, loop: Loop):
    """Return the gain up to which a stable linear loop stays stable, in 1/s.

    Parameters
    ----------
    plant : LinearPlant
        The axis.
    loop : Loop
        A stable loop, from whose gain the search starts.

    Returns
    -------
    gain : float
        The gain at which an eigenvalue meets the unit circle, to about 1e-14 of itself; infinity
        if the loop stays stable up to 1e9 times its gain.

    Raises
    ------
    ValueError
        If the loop isn't stable at its own gain.

    Examples
    --------
    >>> from tunneller_lib.motion import Integrator
    >>> round(eigenvalue_limit(Integrator(0.5), Loop(1, tick=1)), 12)
    2.0
    >>> eigenvalue_limit(Integrator(0.5), Loop(2, tick=1))  # on the limit it swings for ever
    Traceback (most recent call last):
    ValueError: gain: the search must start from a stable loop; got 2 1/s.
    """
    return _first_unstable(lambda g: _radius(plant, loop, g) - 1, loop.gain, 1.25)


@checked
def continuous_limit(plant: LinearPlant):
    """Return the gain at which a linear plant's continuous P loop becomes unstable, in 1/s."""
    A, B = plant.matrices()
    column = np.outer(B, np.eye(len(B))[0]) * plant.command(1.0)
    growth = lambda g: np.max(np.linalg.eigvals(A - g * column).real)  # noqa: E731
    start = 1e-3 * min((-rate for rate in A.diagonal().tolist() if rate < 0), default=1.0)
    return _first_unstable(growth, start, 1.25)


@checked
def ripple(
    plant: LinearPlant, gain: Quantity, tick: Ticks, harmonic: Wholes("(...) int", 1, 10**6) = 1
):
    """Return the velocity ripple of a plant under set-values in steps, as a share of the speed.

    It is the amplitude 2 |G(2 pi i k / T)| of the harmonic k, for a set-value every T = `tick` s
    and the closed continuous P loop G of a `plant` with a `gain` in 1/s: a staircase is a ramp plus
    a sawtooth as high as one step, v T, so the share doesn't depend on the speed v. Tick and
    `harmonic` broadcast.
    """
    open_loop = plant.command(gain) * plant.response(2 * np.pi * harmonic / tick)
    return 2 * np.abs(open_loop / (1 + open_loop))


def _radius(plant, loop, gain):
    """Return the largest size of a closed loop's eigenvalues, below 1 if it is stable."""
    return np.max(np.abs(np.linalg.eigvals(_closed_loop(plant, loop, gain))))


def _first_unstable(growth, start, factor):
    """Return the gain at which the function `growth` of it, negative at `start`, becomes positive.

    The gain is multiplied by `factor` until it does; after a factor of 1e9 the answer is infinity,
    or 0.
    """
    if not growth(start) < 0:
        raise ValueError(f"gain: the search must start from a stable loop; got {start:g} 1/s.")
    low = start
    high = start * factor
    while growth(high) < 0:
        low = high
        high = high * factor
        if not 1e-9 < high / start < 1e9:
            return np.inf if factor > 1 else 0.0
    # Bisected until no float is left between, which is quicker than loading scipy's root finder.
    while (middle := (low + high) / 2) not in (low, high):
        if growth(middle) < 0:
            low = middle
        else:
            high = middle
    return float(high)
