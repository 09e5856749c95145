"""Position loops, tick by tick, and what came of them."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..arguments import finite, positive, real, whole
from .stability import is_stable

MAXIMA = {"feedforward": 2.0, "dead_band": 0.99}


@dataclass(frozen=True)
class Loop:
    """A sampled position loop with encoder and valve: wanted rate = Kv e + Ki (integral of e).

    Parameters
    ----------
    gain : float
        Kv in 1/s: wanted rate over following error. The document's controller gain is Kv / K.
    tick : float
        Sampling period, in s.
    integral : float
        Ki in 1/s^2; 0 for a P loop. The sum waits while the valve is fully open.
    feedforward : float
        Share of the exact slope of the set-values that is added to the wanted rate, 0 to 2.
    delay : int
        Whole ticks between the measurement and the command that answers it.
    count : float
        Angle of an encoder count, in rad; 0 for an ideal encoder.
    limit : float
        Largest command; 1 is the fully open valve.
    dead_band : float
        Share of full command in which the valve stays shut, below 1.
    compensated : bool
        Whether the command jumps over the dead band.

    Raises
    ------
    ValueError
        If a number is beyond its range.
    """

    gain: float
    tick: float
    integral: float = 0.0
    feedforward: float = 0.0
    delay: int = 0
    count: float = 0.0
    limit: float = 1.0
    dead_band: float = 0.0
    compensated: bool = False

    def __post_init__(self):
        for field in fields(self)[:-1]:
            name, value = field.name, getattr(self, field.name)
            if name == "delay":
                if np.ndim(whole(name, value, 0, 1000)):
                    raise ValueError(f"{name}: must be one whole number; got {value!r}.")
                continue
            check = positive if name in ("gain", "tick", "limit") else finite
            value = check(name, value)
            if not 0 <= value <= MAXIMA.get(name, np.inf):
                raise ValueError(
                    f"{name}: must lie between 0 and {MAXIMA.get(name, 'infinity')}; got {value!r}."
                )
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Track:
    """What a simulated run did, of one axis or (..., n) of n.

    Parameters
    ----------
    tick : float
        Period of the loops, in s.
    setvalue, position : (ticks + 1, ...) float
        Wanted and reached, in rad, at the beginning and after each tick.
    command : (ticks, ...) float
        Opening of the valve that is asked for during each tick, from -1 to 1.
    saturated : (ticks, ...) bool
        Whether the command was limited.
    states : tuple of (ticks + 1, order) float
        All states of each axis' plant, its position first.
    stable : tuple of bool or None
        For each axis, whether small motions are stable all over the range of its set-values; None
        with an `inverse` that isn't the plant's own.
    """

    tick: float
    setvalue: np.ndarray
    position: np.ndarray
    command: np.ndarray
    saturated: np.ndarray
    states: tuple
    stable: tuple

    @property
    def time(self):
        """Return the times of the ticks (ticks + 1,), in s."""
        return self.tick * np.arange(len(self.setvalue))

    @property
    def error(self):
        """Return the following error, set-value less position, in rad."""
        return self.setvalue - self.position

    @property
    def largest_error(self):
        """Return the largest following error of each axis, in rad."""
        return np.max(np.abs(self.error), axis=0)

    @property
    def rms_error(self):
        """Return the root mean square of the following error of each axis, in rad."""
        return np.sqrt(np.mean(self.error**2, axis=0))

    @property
    def saturated_share(self):
        """Return the share of ticks in which the valve of each axis was fully open."""
        return np.mean(self.saturated, axis=0)

    def settling(self, tolerance):
        """Return the time after which no axis' error is above a tolerance, in rad; in s.

        It is infinite where the last error still is.
        """
        outside = np.abs(self.error) > positive("tolerance", tolerance)
        outside = outside.reshape(len(outside), -1).any(axis=1)
        if outside[-1]:
            return np.inf
        return self.tick * (int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0)


def simulate(plant, loop, setvalues, *, slopes=None, inverse=None):
    """Run set-values through position loops and the axes that they move.

    Parameters
    ----------
    plant : Integrator, Lag, Resonance, Rigid, Compressible or a sequence of them
        One for each axis, or one for all.
    loop : Loop or a sequence of them
        One for each axis, or one for all; one tick for all.
    setvalues : (ticks + 1,) or (ticks + 1, n) float
        Of one axis or of n, in rad. Each axis starts at rest at its first.
    slopes : (ticks,) or (ticks, n) float, optional
        Exact slopes in rad/s, as from `polyline_slopes`; needed for a feed-forward only.
    inverse : function, optional
        (rate, position) -> command, in place of the plant's own static inverse ``command``.

    Returns
    -------
    track : Track
        Set-values, positions, commands and states. A loop that `is_stable` calls unstable is run
        all the same: the valve's limit keeps it finite.

    Raises
    ------
    ValueError
        If the arguments don't fit each other, or an axis runs out of its cylinder's stroke.

    Examples
    --------
    >>> from tunneller_lib.motion import Integrator, Loop
    >>> ramp = 0.001 * np.arange(1001)
    >>> simulate(Integrator(0.5), Loop(10, tick=0.01), ramp).error[-1].round(6)
    np.float64(0.01)
    """
    values = real("setvalues", setvalues)
    if values.ndim not in (1, 2) or len(values) < 2 or not np.all(np.isfinite(values)):
        raise ValueError(
            "setvalues: must be finite and of shape (ticks + 1,) or (ticks + 1, n) with ticks >= 1;"
            f" got shape {values.shape}."
        )
    columns = values.reshape(len(values), -1)
    axes = columns.shape[1]
    plants, loops = _each("plant", plant, axes), _each("loop", loop, axes)
    if len({one.tick for one in loops}) > 1:
        raise ValueError(f"loop: all axes must share one tick; got {[o.tick for o in loops]} s.")
    slopes = _slopes(slopes, values, loops)
    runs = [
        _run(*parts, inverse or parts[0].command)
        for parts in zip(plants, loops, columns.T.tolist(), slopes.T.tolist(), strict=True)
    ]
    states = tuple(np.array(run[0]) for run in runs)
    shape = (-1, *values.shape[1:])
    position = np.stack([s[:, 0] for s in states], axis=1).reshape(shape)
    command = np.array([run[1] for run in runs]).T.reshape(shape)
    limit = np.array([one.limit for one in loops]) if values.ndim == 2 else loops[0].limit
    ranges = np.linspace(columns.min(axis=0), columns.max(axis=0), 5).T
    stable = tuple(
        None if inverse else is_stable(*parts) for parts in zip(plants, loops, ranges, strict=True)
    )
    saturated = np.abs(command) >= limit
    return Track(loops[0].tick, values, position, command, saturated, states, stable)


def _run(plant, loop, setvalues, slopes, inverse):
    """Return states and commands of one axis, in plain floats: arrays of one would be slow."""
    step, state = plant.stepper(loop.tick), plant.rest(setvalues[0])
    gain, share, count, limit = loop.gain, loop.feedforward, loop.count, loop.limit
    growth, dead = loop.integral * loop.tick, loop.dead_band
    summed = 0.0
    waiting = [0.0] * loop.delay
    states, commands = [state], []
    for wanted, slope in zip(setvalues[:-1], slopes, strict=True):
        position = state[0]
        if count:
            position = count * ((position / count + 0.5) // 1)
        error = wanted - position
        u = inverse(gain * error + summed + share * slope, position)
        if dead and loop.compensated and u:
            u = (1 - dead) * u + (dead if u > 0 else -dead)
        if u > limit:
            u = limit
        elif u < -limit:
            u = -limit
        else:
            summed += growth * error
        if waiting:
            waiting.append(u)
            u = waiting.pop(0)
        opening = _opened(u, dead) if dead else u
        state = step(state, opening)
        states.append(state)
        commands.append(u)
    return states, commands


def _opened(u, dead):
    """Return how far a valve opens whose first `dead` share of the command does nothing."""
    beyond = abs(u) - dead
    return 0.0 if beyond <= 0 else (beyond if u > 0 else -beyond) / (1 - dead)


def _each(name, value, axes):
    """Return one item for each axis."""
    if not isinstance(value, Sequence):
        return [value] * axes
    if len(value) != axes:
        raise ValueError(f"{name}: must be one, or one for each of {axes} axes; got {len(value)}.")
    return list(value)


def _slopes(slopes, values, loops):
    """Return the slopes (ticks, n), zero where no loop asks for them."""
    wanted = (len(values) - 1, *values.shape[1:])
    if slopes is None:
        if any(loop.feedforward for loop in loops):
            raise ValueError("slopes: a loop with feed-forward needs them; got None.")
        slopes = np.zeros(wanted)
    slopes = real("slopes", slopes)
    if slopes.shape != wanted or not np.all(np.isfinite(slopes)):
        raise ValueError(f"slopes: must be finite and of shape {wanted}; got {slopes.shape}.")
    return slopes.reshape(len(slopes), -1)
