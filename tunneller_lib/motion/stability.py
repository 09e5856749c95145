"""How far the gain may be raised: limits in closed form, and by eigenvalues.

Gains are Kv, the wanted rate over the following error, in 1/s; what a plant's own gain K is
doesn't matter, because the static inverse divides by it.
"""

from dataclasses import replace

import numpy as np

from ..arrays import finite, positive, whole
from .plant import Lag


def delay_limit(tick, delay=0):
    """Return the gain limit of T0 under a P loop with whole ticks of delay, in 1/s.

    2 sin(pi / (2 (2 m + 1))) / T for a tick T in s and a delay of m ticks: where the roots of
    z^m (z - 1) + Kv T leave the unit circle. Without delay 2 / T.
    """
    m = whole("delay", delay, 0, 1000)
    return 2 * np.sin(np.pi / (2 * (2 * m + 1))) / positive("tick", tick)


def lag_limit(lag, tick):
    """Return the gain limit of T1, with a lag in s, under a P loop with a tick in s, in 1/s.

    Jury's criterion for z^2 + (Kv b1 - 1 - a) z + a + Kv b0, with a = exp(-T/lag); as the tick
    vanishes nothing limits the gain, as the lag vanishes 2 / T does.
    """
    lag, tick = positive("lag", lag), positive("tick", tick)
    Ad, Bd = Lag(1.0, lag).discrete(tick)
    a, b1 = Ad[1, 1], Bd[0]
    b0 = tick * Bd[1] - b1  # tau (1 - a) - a T, for b1 + b0 = T (1 - a)
    turning = Bd[1] / b0 if b0 > 0 else np.inf
    alternating = 2 * (1 + a) / (b1 - b0) if b1 > b0 else np.inf
    return min(turning, alternating)


def integral_limits(integral, tick):
    """Return the least and the greatest gain of T0 under a PI loop without delay, in 1/s.

    Ki T and (4 + Ki T^2) / (2 T), for `integral` Ki in 1/s^2 and a tick T in s: Jury's criterion
    for z^2 + (Kv T - 2) z + 1 - Kv T + Ki T^2. The range is empty from Ki T^2 = 4 on.
    """
    integral, tick = positive("integral", integral), positive("tick", tick)
    return integral * tick, (4 + integral * tick**2) / (2 * tick)


def resonance_limit(frequency, damping):
    """Return the gain limit 2 zeta w of a resonance under a continuous P loop, in 1/s.

    Routh's criterion for s^3 + 2 zeta w s^2 + w^2 s + Kv w^2, with the `frequency` w in rad/s and
    the `damping` ratio zeta: the practical limit of a hydraulic axis.
    """
    return 2 * positive("damping", damping) * positive("frequency", frequency)


def closed_loop(plant, loop):
    """Return the matrix that takes a linear closed loop from tick to tick.

    The state is the plant's, the integral of the error, and the commands that a `loop` with a
    delay still holds back, oldest first; set-values are zero and the valve doesn't saturate.
    """
    Ad, Bd = plant.discrete(loop.tick)
    order, m = len(Bd), loop.delay
    matrix = np.zeros((order + 1 + m, order + 1 + m))
    command = np.zeros(len(matrix))
    command[0], command[order] = -loop.gain / plant.gain, 1 / plant.gain
    matrix[:order, :order] = Ad
    matrix[order, [0, order]] = -loop.integral * loop.tick, 1
    if m == 0:
        matrix[:order] += np.outer(Bd, command)
    else:
        matrix[:order, order + 1] = Bd
        matrix[range(order + 1, order + m), range(order + 2, order + m + 1)] = 1
        matrix[-1] = command
    if loop.integral == 0:  # no integral: its eigenvalue 1 isn't part of the loop
        matrix = np.delete(np.delete(matrix, order, axis=0), order, axis=1)
    return matrix


def is_stable(plant, loop):
    """Return whether a linear closed loop is stable; None for a plant that isn't linear."""
    return bool(_radius(plant, loop) < 1) if hasattr(plant, "discrete") else None


def eigenvalue_limit(plant, loop, *, side="upper"):
    """Return the gain at which a stable linear loop stops being stable, in 1/s.

    Parameters
    ----------
    plant : Integrator, Lag or Resonance
        The axis.
    loop : Loop
        A stable loop, from whose gain the search starts.
    side : {"upper", "lower"}
        Whether the gain is raised or lowered.

    Returns
    -------
    gain : float
        To about 1e-14 of itself, where an eigenvalue meets the unit circle; 0 or infinity if the
        loop stays stable within a factor 1e9.

    Raises
    ------
    ValueError
        If the loop isn't stable to begin with.
    """
    if side not in ("upper", "lower"):
        raise ValueError(f'side: must be "upper" or "lower"; got {side!r}.')
    factor = 1.25 if side == "upper" else 0.8
    return _first_unstable(lambda g: _radius(plant, replace(loop, gain=g)) - 1, loop.gain, factor)


def continuous_limit(plant):
    """Return the gain at which the continuous P loop of a linear plant turns unstable, in 1/s."""
    A, B = plant.matrices()
    column = np.outer(B, np.eye(len(B))[0]) / plant.gain
    growth = lambda g: np.max(np.linalg.eigvals(A - g * column).real)  # noqa: E731
    start = -1e-3 * min(A.diagonal().min(), -1e-300)
    return _first_unstable(growth, start, 1.25)


def ripple(plant, gain, tick, harmonic=1):
    """Return the velocity ripple of a plant with set-values in steps, as a share of the speed.

    2 |G(2 pi i k / T)| for harmonic k, set-values every T = `tick` s and the closed continuous P
    loop G of a `gain` in 1/s: a staircase is a ramp and a sawtooth of one step's height, v T.
    It doesn't depend on the speed. The amplitude is that of a sine; tick and harmonic broadcast.
    """
    tick, gain = np.asarray(tick, float), positive("gain", gain)
    if not np.all(tick > 0):
        raise ValueError(f"tick: must be above zero, in s; got {tick!r}.")
    open_loop = gain / plant.gain * plant.transfer(2j * np.pi * harmonic / tick)
    return 2 * np.abs(open_loop / (1 + open_loop))


def _radius(plant, loop):
    return np.max(np.abs(np.linalg.eigvals(closed_loop(plant, loop))))


def _first_unstable(growth, start, factor):
    """Return where a function of the gain, negative at its start, turns positive."""
    from scipy.optimize import brentq

    if not growth(finite("gain", start)) < 0:
        raise ValueError(f"gain: the search must start from a stable loop; got {start:g} 1/s.")
    low, high = start, start * factor
    while growth(high) < 0:
        low, high = high, high * factor
        if not 1e-9 < high / start < 1e9:
            return np.inf if factor > 1 else 0.0
    return float(brentq(growth, *sorted((low, high)), xtol=1e-14 * high, rtol=1e-14))
