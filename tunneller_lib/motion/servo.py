"""Set-values through position loops, tick by tick, and what came of them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Array, Each, Positive, Whole, checked, shown
from ..surfaces.linkage import check_stroke
from .arm import Arm
from .both_joints import Push
from .loop import Loop
from .plant import NoLinearForm, Plant
from .stability import is_stable
from .ticks import run_each, run_together

Plants = Each(Plant, or_one=True)
Loops = Each(Loop, or_one=True)
Setvalues = Array("(ticks + 1,) or (ticks + 1, n) float", "rad", low=-1e15, high=1e15)
Slopes = Array("(ticks,) or (ticks, n) float", "rad/s", low=-1e15, high=1e15)


@dataclass(frozen=True, eq=False)
class Track:
    """What a simulated run did, of one axis or (..., n) of n.

    Parameters
    ----------
    tick : float
        Period of the loops, in s.
    setvalue, position : (ticks + 1, ...) float
        Wanted and reached, in rad, at the beginning and after each tick.
    command : (ticks, ...) float
        Opening of the valve that is asked for during each tick, at most the loop's `limit` in size.
    saturated : (ticks, ...) bool
        Whether the command was limited.
    states : tuple of (ticks + 1, order) float
        All states of each axis' plant, its position first.
    stable : tuple of bool or None
        For each axis, whether small motions are stable all over the range of its set-values; None
        with an `inverse` that isn't the plant's own, and of a plant without a linear form.
    energies : (ticks + 1, 5) float or None
        What the pump gave and where it went, `both_joints.ENERGIES`, in J; None of axes that don't
        act on each other.
    """

    tick: float
    setvalue: np.ndarray
    position: np.ndarray
    command: np.ndarray
    saturated: np.ndarray
    states: tuple
    stable: tuple
    energies: np.ndarray | None = None

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

    @checked
    def between(self, first: Whole(0, 2**31), last: Whole(0, 2**31)):
        """Return the `Track` from a `first` tick to a `last`, its time beginning anew.

        Raises
        ------
        ValueError
            If `last` isn't behind `first` and within the run.
        """
        if not first < last < len(self.setvalue):
            raise ValueError(
                f"last: must be behind {first} and at most {len(self.setvalue) - 1}; got {last}."
            )
        held = slice(first, last + 1)
        ticks = slice(first, last)
        return replace(
            self,
            setvalue=self.setvalue[held],
            position=self.position[held],
            command=self.command[ticks],
            saturated=self.saturated[ticks],
            states=tuple(states[held] for states in self.states),
            energies=None if self.energies is None else self.energies[held] - self.energies[first],
        )

    @checked
    def settling(self, tolerance: Positive):
        """Return the time after which no axis' error is above a tolerance, in rad; in s.

        It is infinite where the last error still is.
        """
        outside = np.abs(self.error) > tolerance
        outside = outside.reshape(len(outside), -1).any(axis=1)
        if outside[-1]:
            return np.inf
        return self.tick * (int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0)


@checked
def follow(
    plant: Plants,
    loop: Loops,
    setvalues: Setvalues,
    *,
    slopes: Slopes | None = None,
    inverse: Callable[[float, float], float] | None = None,
    arm: Arm | None = None,
    push: Push | Callable | None = None,
):
    """Run set-values through position loops and the axes that they move.

    Parameters
    ----------
    plant : Plant or a list of them
        One for each axis, or one for all.
    loop : Loop or a list of them
        One for each axis, or one for all; one tick for all.
    setvalues : (ticks + 1,) or (ticks + 1, n) float
        Of one axis or of n, in rad. Each axis starts at rest at its first.
    slopes : (ticks,) or (ticks, n) float, optional
        Exact slopes in rad/s, as from `polyline_slopes`; needed for a feed-forward only.
    inverse : function, optional
        (rate, position) -> command, in place of the plant's own static inverse ``command``.
    arm : Arm, optional
        The masses on theta and phi, whose motions then act on each other; for two `Compressible`
        plants. Without it each axis has the inertia and the weight of its own `Hydraulics`.
    push : Push or function, optional
        What pushes two `Compressible` plants: in all ticks, or (tick, tried) -> `Push` or None. It
        is asked with None for the m ticks from `tick` on that it answers for, and then with the
        positions (m + 1, 2) that they got to under its answer and before them: for another answer,
        with which they are tried again, or for None, which lets them be.

    Returns
    -------
    track : Track
        Set-values, positions, commands and states. A loop that `is_stable` calls unstable is run
        all the same: the valve's limit keeps it finite.

    Raises
    ------
    ValueError
        If the arguments don't fit each other, or set-values or an axis leave the cylinder's
        stroke.

    Examples
    --------
    >>> from tunneller_lib.motion import Integrator, Loop
    >>> ramp = 0.001 * np.arange(1001)
    >>> follow(Integrator(0.5), Loop(10, tick=0.01), ramp).error[-1].round(6)
    np.float64(0.01)
    """
    if len(setvalues) < 2 or not setvalues.size:
        raise ValueError(
            f"setvalues: must be of one tick and of one axis at least; got {setvalues.shape}."
        )
    # One axis is a column as well; the answers get back the shape of what was given.
    columns = setvalues.reshape(len(setvalues), -1)
    axes = columns.shape[1]
    plants = _for_each_axis("plant", plant, axes)
    loops = _for_each_axis("loop", loop, axes)
    if len({one.tick for one in loops}) > 1:
        ticks = shown([one.tick for one in loops])
        raise ValueError(f"loop: all axes must share one tick; got {ticks} s.")
    for one, column in zip(plants, columns.T, strict=True):
        if one.hydraulics is not None:
            check_stroke(column, one.hydraulics.low, one.hydraulics.high, "setvalues")
    if inverse is not None:
        _try(inverse, columns[0, 0])
    rates = _slope_columns(slopes, setvalues, loops)
    if arm is None and push is None:
        energies = None
        states, commands = run_each(plants, loops, columns, rates, inverse)
    else:
        states, commands, energies = run_together(plants, loops, columns, rates, inverse, arm, push)
    if setvalues.ndim == 2:
        position = np.stack([s[:, 0] for s in states], axis=1)
        command = np.stack(commands, axis=1)
        limit = np.array([one.limit for one in loops])
    else:
        position = states[0][:, 0].copy()
        command = commands[0]
        limit = loops[0].limit
    stable = (None,) * axes
    if inverse is None:
        stable = tuple(map(_is_stable, plants, loops, columns.T))
    saturated = (command >= limit) | (command <= -limit)
    return Track(loops[0].tick, setvalues, position, command, saturated, states, stable, energies)


def _is_stable(plant, loop, column):
    """Return whether small motions of an axis are stable all over the range of its set-values.

    None where the plant has no linear form to judge by.
    """
    # How stiff oil is depends on the angle, so five of the range are asked.
    angles = np.linspace(column.min(), column.max(), 5)
    try:
        return is_stable(plant, loop, angles)
    except NoLinearForm:
        return None


def _for_each_axis(name, value, axes):
    """Return one item for each axis."""
    if not isinstance(value, tuple):
        return [value] * axes
    if len(value) != axes:
        raise ValueError(f"{name}: must be one, or one for each of {axes} axes; got {len(value)}.")
    return value


def _slope_columns(slopes, values, loops):
    """Return the slopes (ticks, n), zero where no loop asks for them."""
    wanted = (len(values) - 1, *values.shape[1:])
    if slopes is None:
        if any(loop.feedforward for loop in loops):
            raise ValueError("slopes: a loop with feed-forward needs them; got None.")
        slopes = np.zeros(wanted)
    if slopes.shape != wanted:
        raise ValueError(f"slopes: must be of shape {wanted}; got {slopes.shape}.")
    return slopes.reshape(len(slopes), -1)


def _try(inverse, position):
    """Raise ValueError where a caller's own inverse doesn't answer with a number."""
    try:
        answer = inverse(0.0, float(position))
        good = bool(abs(answer) <= np.inf)
    except Exception as error:
        raise ValueError(
            f"inverse: must be a function of rate and position; got {shown(error)}."
        ) from error
    if not good:
        raise ValueError(f"inverse: must return a number; got {shown(answer)}.")
