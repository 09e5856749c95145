"""Set-values run through position loops and axes, tick by tick."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arguments import Array, Each, Whole, checked, shown
from ..surfaces.linkage import check_stroke
from .arm import Arm
from .both_joints import Push, Resistance
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
    """A simulated run of one axis, or of n axes, whose arrays then have a last axis of n.

    Parameters
    ----------
    tick : float
        Period of the loops, in s.
    setvalue, position : (ticks + 1, ...) float
        Wanted and reached positions, in rad, at the beginning and after each tick.
    command : (ticks, ...) float
        Valve opening that the loop asks for in each tick, at most its `limit` in size.
    saturated : (ticks, ...) bool
        Whether the command was limited.
    states : tuple of (ticks + 1, order) float
        All states of each axis' plant, its position first.
    judged : tuple
        What `stable` judges of each axis: its plant, its loop and joint angles; None for an axis
        with a caller's own `inverse`.
    energies : (ticks + 1, 5) float or None
        The energy from the pump and where it went, `both_joints.ENERGIES`, in J; None if the axes
        don't act on each other.
    """

    tick: float
    setvalue: np.ndarray
    position: np.ndarray
    command: np.ndarray
    saturated: np.ndarray
    states: tuple
    judged: tuple
    energies: np.ndarray | None = None

    @cached_property
    def stable(self):
        """Return whether small motions of each axis are stable, over the whole run's set-values.

        None stands for a plant without a linear form, or with a caller's own `inverse`.
        """
        return tuple(None if axis is None else _is_stable(*axis) for axis in self.judged)

    @property
    def time(self):
        """Return the times of the ticks (ticks + 1,), in s."""
        return self.tick * np.arange(len(self.setvalue))

    @property
    def error(self):
        """Return the following errors, set-values less positions, in rad."""
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
        """Return the `Track` from a `first` tick to a `last`, whose time begins anew at 0.

        Raises
        ------
        ValueError
            If `last` isn't after `first` and within the run.

        Examples
        --------
        >>> from tunneller_lib.motion import Integrator
        >>> run = follow(Integrator(0.5), Loop(1, tick=0.5), np.zeros(9))
        >>> run.between(2, 5).time.tolist()
        [0.0, 0.5, 1.0, 1.5]
        >>> run.between(2, -1)
        Traceback (most recent call last):
        ValueError: last: must be one whole number from 0 to 2147483648; got -1.
        """
        if not first < last < len(self.setvalue):
            raise ValueError(
                f"last: must be above {first} and at most {len(self.setvalue) - 1}; got {last}."
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
def follow(
    plant: Plants,
    loop: Loops,
    setvalues: Setvalues,
    *,
    slopes: Slopes | None = None,
    inverse: Callable[[float, float], float] | None = None,
    arm: Arm | None = None,
    push: Push | Resistance | None = None,
):
    """Return the run of set-values through position loops and the axes that they move.

    Parameters
    ----------
    plant : Plant or a list of them
        One for each axis, or one for all.
    loop : Loop or a list of them
        One for each axis, or one for all; all have the same tick.
    setvalues : (ticks + 1,) or (ticks + 1, n) float
        Wanted positions of one axis or of n, in rad. Each axis starts at rest at its first.
    slopes : (ticks,) or (ticks, n) float, optional
        Exact slopes in rad/s, as from `polyline_slopes`; only a feed-forward needs them.
    inverse : function, optional
        (rate, position) -> command, in place of the plant's own static inverse ``command``.
    arm : Arm, optional
        The masses on theta and phi, through which the joints act on each other; for two
        `Compressible` plants. Without it each axis has the inertia and the weight of its own
        `Hydraulics`.
    push : Push or Resistance, optional
        The push on two `Compressible` plants, or what else resists them, as `ream.face.Face`.

    Returns
    -------
    track : Track
        Set-values, positions, commands and states. An unstable loop is run as well, since the
        valve's limit keeps it finite.

    Raises
    ------
    ValueError
        If the arguments don't fit each other, or the set-values or an axis leave a stroke.

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
    # One axis is one column; the answers have the shape of the set-values again.
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
    # The oil's stiffness depends on the angle, so five angles of the range are judged.
    angles = np.linspace(columns.min(axis=0), columns.max(axis=0), 5).T
    judged = (None,) * axes
    if inverse is None:
        judged = tuple(zip(plants, loops, angles, strict=True))
    # Commands are limited exactly to the limit, so that equality tells saturation.
    saturated = (command >= limit) | (command <= -limit)
    return Track(loops[0].tick, setvalues, position, command, saturated, states, judged, energies)


def _is_stable(plant, loop, angles):
    """Return whether an axis is stable at joint angles, or None for one without linear form."""
    try:
        return is_stable(plant, loop, angles)
    except NoLinearForm:
        return None


def _for_each_axis(name, value, axes):
    """Return one item for each axis; another number of them raises ValueError."""
    if not isinstance(value, tuple):
        return [value] * axes
    if len(value) != axes:
        raise ValueError(f"{name}: must be one, or one for each of {axes} axes; got {len(value)}.")
    return value


def _slope_columns(slopes, values, loops):
    """Return the slopes (ticks, n), or zeros if none are given and no loop needs them."""
    wanted = (len(values) - 1, *values.shape[1:])
    if slopes is None:
        if any(loop.feedforward for loop in loops):
            raise ValueError("slopes: a loop with feed-forward needs them; got None.")
        slopes = np.zeros(wanted)
    if slopes.shape != wanted:
        raise ValueError(f"slopes: must be of shape {wanted}; got {slopes.shape}.")
    return slopes.reshape(len(slopes), -1)
