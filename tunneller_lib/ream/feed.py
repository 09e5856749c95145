"""How fast the cutter may go along its path: as fast as the limits let it."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import LEAST, Rule, bounded_array, checked, positions, real, shown, size
from ..motion import Hydraulics
from .both_axes import Pair


def _bound(name, value):
    """Return `value` as a float, which must be `size` or infinite."""
    number = real(name, value)
    if number.ndim or not number > 0:
        raise ValueError(f"{name}: must be one number above zero; got {shown(value)}.")
    return np.inf if np.isinf(number) else size(name, value)


def _row(name, value):
    """Return `value` as a float array (m,)."""
    row = bounded_array(name, value)
    if row.ndim != 1:
        raise ValueError(f"{name}: must be a list of numbers (m,); got shape {row.shape}.")
    return row


Size = Annotated[float, Rule("float", size)]
Bound = Annotated[float, Rule("float", _bound)]
Moves = Annotated[ArrayLike, Rule("(m,) float", _row, "m")]
Areas = Annotated[ArrayLike, Rule("(m,) float", _row)]
Ends = Annotated[ArrayLike, Rule("(m + 1, 2) float", positions, "rad")]


@dataclass(frozen=True)
@checked
class Limits:
    """What bounds the feed of the cutter; volume, flow and valve bound nothing where infinite.

    Parameters
    ----------
    feed : float
        Greatest feed, in m/s.
    acceleration : float
        Along the path, in m/s^2: it starts and ends every lap at rest.
    volume : float
        Ground that a steady groove may remove, in m^3/s (section 3.3.2). Between knots and at
        bends the ball takes somewhat more and less.
    flow : float
        Oil that the pump delivers to both axes together, in m^3/s; needs `axes`.
    valve : float
        Opening of the valve, 1 at most, that the steady motion may ask for; needs `axes`.
    axes : (Hydraulics, Hydraulics), optional
        The axes theta and phi.

    Raises
    ------
    ValueError
        If a number isn't above zero or is out of its range, the valve above 1 but not infinite, or
        a limit needs axes that aren't given.
    """

    feed: Size
    acceleration: Size
    volume: Bound = np.inf
    flow: Bound = np.inf
    valve: Bound = np.inf
    axes: Pair(Hydraulics) | None = None

    def __post_init__(self):
        if 1 < self.valve < np.inf:
            raise ValueError(f"valve: must be at most 1, the open valve; got {self.valve!r}.")
        if self.axes is None and min(self.flow, self.valve) < np.inf:
            raise ValueError("axes: must be given for a limit of flow or of valves; got None.")

    @checked
    def profile(self, lengths: Moves, positions: Ends, ground: Areas):
        """Return the fastest feed from rest to rest.

        Parameters
        ----------
        lengths : (m,) float
            Of the moves of the cutter's centre, in m.
        positions : (m + 1, 2) float
            Joint positions at their ends, in rad; straight in joint space between.
        ground : (m,) float
            Ground removed by each metre of a move, in m^2.

        Returns
        -------
        feed : (m + 1,) float
            At the ends, in m/s, changing by a constant acceleration over each move: the greatest
            that no limit forbids.

        Notes
        -----
        Without acceleration each place has its own bound. With it the square of the feed rises by
        at most 2 a times the length, forwards from every place and backwards: two running minima.
        """
        bound = self.bounds(lengths, positions, ground)
        # A place belongs to the moves before and after it; a lap begins and ends at rest.
        square = np.minimum(np.append(bound, np.inf), np.append(np.inf, bound)) ** 2
        square[[0, -1]] = 0
        # A climb beyond the greatest feed says nothing, and its sum would take digits away.
        climb = np.minimum(2 * self.acceleration * lengths, square.max())
        climb = np.concatenate([[0], np.cumsum(climb)])
        # From every place before, and then from every one behind, no more than the climb: less the
        # climb so far, that is a minimum which runs.
        square = np.minimum.accumulate(square - climb) + climb
        square = np.minimum.accumulate((square + climb)[::-1])[::-1] - climb
        return np.sqrt(np.maximum(square, 0))  # the sums leave a rounding below zero at rest

    @checked
    def bounds(self, lengths: Moves, positions: Ends, ground: Areas):
        """Return the greatest steady feed on each move.

        Parameters
        ----------
        lengths : (m,) float
            Of the moves of the cutter's centre, in m.
        positions : (m + 1, 2) float
            Joint positions at their ends, in rad; straight in joint space between.
        ground : (m,) float
            Ground removed by each metre of a move, in m^2.

        Returns
        -------
        feed : (m,) float
            In m/s.

        Raises
        ------
        ValueError
            If the shapes don't fit each other, a length isn't above zero, or ground is below it.
        """
        m = lengths.size
        if m < 2 or ground.shape != (m,) or positions.shape != (m + 1, 2):
            raise ValueError(
                "lengths: must be (m,) with ground (m,) and positions (m + 1, 2), and "
                f"m >= 2; got {lengths.shape}, {ground.shape}, {positions.shape}."
            )
        if np.any(lengths < LEAST):
            raise ValueError(f"lengths: must be above zero; got {lengths.min():g}.")
        if np.any(ground < 0):
            raise ValueError(f"ground: must not be below zero; got {ground.min():g}.")
        with np.errstate(divide="ignore", over="ignore"):
            bound = np.minimum(self.feed, self.volume / ground)
        if self.axes is None:
            return bound
        rates = np.diff(positions, axis=0) / lengths[:, None]  # rad for each metre
        middle = (positions[1:] + positions[:-1]) / 2
        drawn = 0.0
        for axis, rate, angle in zip(self.axes, rates.T, middle.T, strict=True):
            (filled, _, _), (emptied, _, _) = axis.sides(angle)
            drawn = drawn + np.abs(rate) * np.where(rate > 0, filled, emptied)
            if self.valve < np.inf:
                fastest = np.abs(axis.rate(angle, np.where(rate > 0, self.valve, -self.valve)))
                with np.errstate(divide="ignore", over="ignore"):  # a joint that stands still
                    bound = np.minimum(bound, fastest / np.abs(rate))
        with np.errstate(divide="ignore", over="ignore"):
            return np.minimum(bound, self.flow / drawn)
