"""How fast the cutter may go along its path: constant, or as fast as the limits let it."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..arguments import instance, positive, real
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
            number = real(field.name, value)
            if number.ndim or not number > 0:
                raise ValueError(f"{field.name}: must be one number above zero; got {value!r}.")
        for name in ("feed", "acceleration"):
            positive(name, getattr(self, name))
        if 1 < self.valve < np.inf:
            raise ValueError(f"valve: must be at most 1, the open valve; got {self.valve!r}.")
        if self.axes is None:
            if min(self.flow, self.valve) < np.inf:
                raise ValueError("axes: must be given for a limit of flow or of valves; got None.")
        elif not isinstance(self.axes, Sequence) or len(self.axes) != 2:
            raise ValueError(f"axes: must be two, theta and phi; got {self.axes!r}.")
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
        bound = self.bounds(lengths, positions, ground)
        square = np.minimum(np.append(bound, np.inf), np.append(np.inf, bound)) ** 2
        square[[0, -1]] = 0
        # A climb beyond the greatest feed says nothing, and its sum would take digits away.
        climb = np.minimum(2 * self.acceleration * real("lengths", lengths), square.max())
        climb = np.concatenate([[0], np.cumsum(climb)])
        square = np.minimum.accumulate(square - climb) + climb
        square = np.minimum.accumulate((square + climb)[::-1])[::-1] - climb
        return np.sqrt(np.maximum(square, 0))

    def bounds(self, lengths, positions, ground):
        """Return the greatest steady feed (m,), in m/s, on each move of `profile`.

        The arguments (lengths, positions, ground) are the same.
        """
        lengths, ground = real("lengths", lengths), real("ground", ground)
        positions = real("positions", positions)
        m = lengths.size
        if m < 2 or lengths.shape != (m,) or ground.shape != (m,) or positions.shape != (m + 1, 2):
            raise ValueError(
                "lengths: must be (m,) with ground (m,) and positions (m + 1, 2), and "
                f"m >= 2; got {lengths.shape}, {ground.shape}, {positions.shape}."
            )
        sound = np.all(np.isfinite(lengths) & (lengths > 0)) and np.all(np.isfinite(positions))
        if not sound or not np.all(np.isfinite(ground) & (ground >= 0)):
            raise ValueError("lengths: must be above zero, ground not below, positions finite.")
        with np.errstate(divide="ignore"):
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
                with np.errstate(divide="ignore"):
                    bound = np.minimum(bound, fastest / np.abs(rate))
        return np.minimum(bound, self.flow / drawn)
