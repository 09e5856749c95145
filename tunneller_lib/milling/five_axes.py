"""A five-axis machine: the values of its axes at positions of a tool, and what is beyond them.

The spindle stands along z and moves along x, y and z against a table. The table tilts about x by
the angle A and turns on itself by the angle C.
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import (
    Directions,
    Point,
    Points,
    Positive,
    Rule,
    bounded_array,
    checked,
    directions,
)
from ..kernels.exact import norm
from .motion import Axes, Tips
from .obstacles import Around
from .patch import Range
from .tools import ConicalMill

LIMITS = ("x", "y", "z", "tilt", "turn")  # of the machine's axes, in the order of their values
UPRIGHT = 1e-9  # rad: an axis that leans less than this leaves C free


def _values(name, value):
    """Return `value` as a float array (k, 5)."""
    array = bounded_array(name, value)
    if array.ndim != 2 or array.shape[1] != len(LIMITS):
        raise ValueError(f"{name}: must be rows of x, y, z, A, C (k, 5); got shape {array.shape}.")
    return array


def _direction(name, value):
    """Return `value` as three floats, of which one at least isn't zero."""
    array = directions(name, value)
    if array.shape != (3,):
        raise ValueError(f"{name}: must be one direction (3,); got shape {array.shape}.")
    return tuple(array.tolist())


# What arguments may be, in this room and above it.
Direction = Annotated[tuple[float, float, float], Rule("(3,) float", _direction)]
AxisValues = Annotated[ArrayLike, Rule("(k, 5) float", _values)]


@dataclass(frozen=True)
@checked
class TiltingTable:
    """A machine whose table tilts about x and turns on itself, under a spindle along z.

    Parameters
    ----------
    pivot : (3,) float
        Where the axes of A and C meet, in the workpiece's coordinates, in m. Of the machine's
        coordinates it is the origin.
    up : (3,) float
        The workpiece's direction, of any length, that is the axis of C.
    x, y, z : (2,) float
        Least and greatest place of the tool's tip, in m.
    tilt : (2,) float
        Least and greatest A, in rad.
    turn : (2,) float
        Least and greatest C, in rad.
    most_turn : float
        By how much A or C may change from one position to the next, in rad.
    cradle : (n, 3) or (n, m, 3) float, or a list of such arrays, optional
        As `others` of `find_positions`, what tilts by A and doesn't turn by C, as the cradle that
        carries the table; in the machine's coordinates while A is 0.

    Notes
    -----
    What the table carries, and the table itself, moves with the workpiece: as points or boxes there
    it is among the `others` that a mill with its holder and spindle must stay off.

    A point p of the workpiece is at Rx(A) Rz(C) F (p - pivot), where the rows of F are three unit
    vectors, the third along `up`. For an axis F u = (sin A sin C, sin A cos C, cos A) there are two
    answers, with A of either sign.

    Examples
    --------
    >>> table = TiltingTable((0, 0, 0), (0, 0, 1), (-1, 1), (-1, 1), (-1, 1), (-2, 2), (-7, 7), 0.2)
    >>> tip = [[0, 0, 0.01 * k] for k in range(4)]
    >>> table.values(tip, [[0, 0.6, 0.8]] * 4).round(3)[1].tolist()
    [0.0, -0.006, 0.008, 0.644, 0.0]
    """

    pivot: Point
    up: Direction
    x: Range
    y: Range
    z: Range
    tilt: Range
    turn: Range
    most_turn: Positive
    cradle: Around | None = field(default=None, compare=False)

    @property
    def frame(self):
        """Return unit vectors in rows (3, 3): with A = C = 0 the machine's x, y and z."""
        third = np.array(self.up) / norm(np.array(self.up))
        first = np.cross(np.eye(3)[1], third)
        if norm(first) < 0.5:
            first = np.cross(np.eye(3)[2], third)
        first = first / norm(first)
        return np.array([first, np.cross(third, first), third])

    @checked
    def values(self, tip: Tips, axis: Axes, mill: ConicalMill | None = None):
        """Return what the machine's axes are at positions one after the other.

        Parameters
        ----------
        tip, axis
            As for `moved`.
        mill : ConicalMill, optional
            That should stay off the cradle.

        Returns
        -------
        values : (k, 5) float
            x, y, z in m, A and C in rad. From one position to the next that sign of A is taken with
            which A and C turn less; of the two signs at the first position, the one with which
            fewer positions are beyond the limits or in the cradle. Where the axis is along `up` C
            is that of the position before.
        """

        if len(axis) != len(tip):
            raise ValueError(f"axis: must be one for each of {len(tip)} tips; got {len(axis)}.")

        def wrong(values):
            return np.sum(self._beyond(values).any(axis=1) | (cradle_depth(self, mill, values) > 0))

        return min(self._ways(tip, axis), key=wrong)

    def _ways(self, tip, axis):
        """Return the values (k, 5) with either sign of A at first, C amid its limits."""
        tilt, turn = self._angles(axis)
        # Where an axis passes near `up`, C would turn far; the other sign of A may be nearer.
        stays = np.abs(np.diff(tilt)) + np.abs(_within_half(np.diff(turn)))
        flips = tilt[1:] + tilt[:-1] + np.abs(_within_half(np.diff(turn) - np.pi))
        signs = np.cumprod(np.append(1.0, np.where(flips < stays, -1.0, 1.0)))
        ways = []
        for sign in (signs, -signs):
            turned = np.unwrap(turn + np.where(sign < 0, np.pi, 0.0))
            # Whole turns that bring the middle of the way nearest to the middle of the limits.
            off = np.mean(self.turn) - (turned.max() + turned.min()) / 2
            turned = turned + 2 * np.pi * np.round(off / (2 * np.pi))
            ways.append(self._values(tip, sign * tilt, turned))
        return ways

    def _angles(self, axis):
        """Return A, not below zero, and C (k,) of axes (k, 3)."""
        axis = axis @ self.frame.T
        across = np.hypot(axis[:, 0], axis[:, 1])
        tilt = np.arctan2(across, axis[:, 2])
        turn = np.arctan2(axis[:, 0], axis[:, 1])
        free = across < UPRIGHT
        if free.all():
            turn = np.zeros(len(turn))  # what is left across is rounding, in any direction
        elif free.any():
            known = np.flatnonzero(~free)
            last = known[np.maximum(np.searchsorted(known, np.arange(len(turn)), "right") - 1, 0)]
            turn = turn[last]
        return tilt, turn

    def _values(self, tip, tilt, turn):
        """Return values (k, 5) of tips (k, 3) at angles (k,)."""
        return np.column_stack(
            [_turned((tip - np.array(self.pivot)) @ self.frame.T, tilt, turn), tilt, turn]
        )

    @checked
    def reaches(self, tip: Points, axis: Directions, mill: ConicalMill | None = None):
        """Return whether the machine can stand at each of some positions (...) by itself.

        Parameters
        ----------
        tip, axis : (..., 3) float
            Of the tool, in m, and towards the spindle.
        mill : ConicalMill, optional
            That must stay off the cradle, too.
        """
        flat = [
            np.broadcast_to(part, np.broadcast_shapes(tip.shape, axis.shape))
            for part in (tip, axis)
        ]
        rows = [part.reshape(-1, 3) for part in flat]
        within = np.zeros(len(rows[0]), dtype=bool)
        tilt, turn = self._angles(rows[1])
        low = self.turn[0]
        for sign in (1, -1):
            # C within its limits, if a whole turn brings it there or if it is free.
            turned = low + np.mod(turn + (np.pi if sign < 0 else 0.0) - low, 2 * np.pi)
            turned = np.where(np.sin(tilt) < UPRIGHT, low, turned)
            values = self._values(rows[0], sign * tilt, turned)
            within |= ~self._outside(values).any(axis=1) & (cradle_depth(self, mill, values) == 0)
        return within.reshape(flat[0].shape[:-1])[()]

    @checked
    def positions(self, values: AxisValues):
        """Return tips (k, 3), in m, and unit axes (k, 3) of values (k, 5), as of `values`."""
        place, tilt, turn = values[:, :3], values[:, 3], values[:, 4]
        up = np.broadcast_to((0.0, 0.0, 1.0), place.shape)
        tip, axis = (_turned_back(part, tilt, turn) @ self.frame for part in (place, up))
        return tip + np.array(self.pivot), axis

    @checked
    def beyond(self, values: AxisValues):
        """Return why the machine can't take each of some positions: (k,) str, "" where it can.

        A sentence names the first axis that is beyond its limits, or that would turn by more than
        `most_turn` from the position before.
        """
        said = np.full(len(values), "", dtype=object)
        for k, column in reversed(list(np.argwhere(self._beyond(values)))):
            said[k] = self._sentence(values[k, column % 5], column)
        return said.astype(str)

    def _beyond(self, values):
        """Return (k, 7) bool: which of the five limits, and of the two steps, are passed."""
        return np.concatenate([self._outside(values), self._jumps(values)], axis=1)

    def _jumps(self, values):
        """Return (k, 2) bool: whether A, and C, turn too far from the position before."""
        return np.abs(np.diff(values[:, 3:], axis=0, prepend=values[:1, 3:])) > self.most_turn

    def _outside(self, values):
        """Return (k, 5) bool: which limits are passed."""
        low, high = np.array([getattr(self, name) for name in LIMITS]).T
        return (values < low) | (values > high)

    def _sentence(self, value, column):
        if column >= len(LIMITS):
            name = "AC"[column - len(LIMITS)]
            return f"{name} would turn by more than {np.degrees(self.most_turn):g} deg in one step."
        low, high = getattr(self, LIMITS[column])
        name, scale, unit = (
            "xyzAC"[column],
            *((1e3, "mm") if column < 3 else (180 / np.pi, "deg")),
        )
        return (
            f"{name} must lie from {scale * low:g} to {scale * high:g} {unit}; "
            f"it would be {scale * value:.4g} {unit}."
        )


def stretch(machine, tip, axis, start):
    """Return the longest stretch about one of some positions that the machine can go through.

    Parameters
    ----------
    machine : TiltingTable
        Whose limits count.
    tip, axis : (k, 3) float
        As for `moved`.
    start : int
        Which position it must hold.

    Returns
    -------
    first, last : int
        It begins at the first position, and ends before the last; empty where the machine
        doesn't reach the start.
    """
    found = []
    for values in machine._ways(tip, axis):
        stop = machine._outside(values).any(axis=1)
        if stop[start]:
            continue
        jump = machine._jumps(values).any(axis=1)  # on the way to a position from the one before
        before = np.r_[np.flatnonzero(stop[:start]) + 1, np.flatnonzero(jump[: start + 1])]
        after = np.flatnonzero((stop | jump)[start + 1 :]) + start + 1
        found.append((int(before.max(initial=0)), int(after.min(initial=len(tip)))))
    return max(found, key=lambda ends: ends[1] - ends[0], default=(start, start))


def cradle_depth(machine, mill, values):
    """Return how deep (k,) a mill with its holder enters a machine's cradle, in m; 0 where not.

    Parameters
    ----------
    machine : TiltingTable
        With a cradle or without.
    mill : ConicalMill or None
        None enters nothing.
    values : (k, 5) float
        Of the machine's axes.
    """
    if mill is None or machine.cradle is None:
        return np.zeros(len(values))
    # As the cradle sees them, which tilts and doesn't turn.
    tilt, turn = values[:, 3], np.zeros(len(values))
    up = np.broadcast_to((0.0, 0.0, 1.0), (len(values), 3))
    tip, axis = (_turned_back(part, tilt, turn) for part in (values[:, :3], up))
    return machine.cradle.deepest(mill, tip, axis)


def _within_half(angle):
    """Return angles less whole turns: -pi to pi."""
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))


def _turned(p, tilt, turn):
    """Return Rx(tilt) Rz(turn) p, for points p (k, 3) and angles (k,)."""
    x = np.cos(turn) * p[:, 0] - np.sin(turn) * p[:, 1]
    y = np.sin(turn) * p[:, 0] + np.cos(turn) * p[:, 1]
    z = p[:, 2]
    return np.stack(
        [x, np.cos(tilt) * y - np.sin(tilt) * z, np.sin(tilt) * y + np.cos(tilt) * z], -1
    )


def _turned_back(p, tilt, turn):
    """Return what `_turned` turns to p."""
    x = p[:, 0]
    y = np.cos(tilt) * p[:, 1] + np.sin(tilt) * p[:, 2]
    z = -np.sin(tilt) * p[:, 1] + np.cos(tilt) * p[:, 2]
    return np.stack(
        [np.cos(turn) * x + np.sin(turn) * y, -np.sin(turn) * x + np.cos(turn) * y, z], -1
    )
