"""How fast the cutter may go along its path: constant, or as fast as the limits let it."""

from dataclasses import dataclass, fields

import numpy as np

from ..arrays import instance, positive, real
from ..motion import Hydraulics


@dataclass(frozen=True)
class Limits:
    """What bounds the feed of the cutter; a number alone bounds nothing if it is infinite.

    Parameters
    ----------
    feed : float
        Greatest feed, in m/s.
    acceleration : float
        Along the path, in m/s^2: it starts and ends every lap at rest.
    volume : float
        Ground that may be removed, in m^3/s (section 3.3.2).
    flow : float
        Oil that the pump delivers to both axes together, in m^3/s; needs `axes`.
    valve : float
        Opening of the valve, 1 at most, that the steady motion may ask for; needs `axes`.
    axes : tuple of Hydraulics, optional
        The axes theta and phi.

    Raises
    ------
    ValueError
        If a number isn't above zero, or a limit needs axes that aren't given.
    """

    feed: float
    acceleration: float
    volume: float = np.inf
    flow: float = np.inf
    valve: float = np.inf
    axes: tuple | None = None

    def __post_init__(self):
        for field in fields(self)[:-1]:
            value = getattr(self, field.name)
            if np.ndim(value) or not value > 0:
                raise ValueError(f"{field.name}: must be one number above zero; got {value!r}.")
        for name in ("feed", "acceleration"):
            positive(name, getattr(self, name))
        if self.axes is None and min(self.flow, self.valve) < np.inf:
            raise ValueError("axes: must be given for a limit of oil flow or of valves; got None.")
        for axis in self.axes or ():
            instance("axes", axis, Hydraulics)

    def profile(self, lengths, positions, ground):
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
        lengths, ground = real("lengths", lengths), real("ground", ground)
        bound = self.bounds(lengths, positions, ground)
        square = np.minimum(np.append(bound, np.inf), np.append(np.inf, bound)) ** 2
        square[[0, -1]] = 0
        climb = 2 * self.acceleration * np.concatenate([[0], np.cumsum(lengths)])
        square = np.minimum.accumulate(square - climb) + climb
        square = np.minimum.accumulate((square + climb)[::-1])[::-1] - climb
        return np.sqrt(np.maximum(square, 0))

    def bounds(self, lengths, positions, ground):
        """Return the greatest steady feed (m,), in m/s, on each move of `profile`."""
        positions = real("positions", positions)
        with np.errstate(divide="ignore"):
            bound = np.minimum(self.feed, self.volume / ground)
        if self.axes is None:
            return bound
        rates = np.diff(positions, axis=0) / lengths[:, None]  # rad for each metre
        middle = (positions[1:] + positions[:-1]) / 2
        drawn = 0.0
        for axis, rate, angle in zip(self.axes, rates.T, middle.T):
            (filled, _, _), (emptied, _, _) = axis.sides(angle)
            drawn = drawn + np.abs(rate) * np.where(rate > 0, filled, emptied)
            if self.valve < np.inf:
                fastest = np.abs(axis.rate(angle, np.where(rate > 0, self.valve, -self.valve)))
                with np.errstate(divide="ignore"):
                    bound = np.minimum(bound, fastest / np.abs(rate))
        return np.minimum(bound, self.flow / drawn)
