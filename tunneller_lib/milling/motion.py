"""Smooth motions of a tool through its positions."""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Rule, Whole, checked, directions, near_points
from ..kernels.exact import norm


def _rows(check):
    def rows(name, value):
        array = check(name, value)
        if array.ndim != 2 or len(array) < 4:
            raise ValueError(f"{name}: must be four or more in rows (k, 3); got {array.shape}.")
        return array

    return rows


# What arguments may be, in this room and above it.
Tips = Annotated[ArrayLike, Rule("(k, 3) float", _rows(near_points), "m")]
Axes = Annotated[ArrayLike, Rule("(k, 3) float", _rows(directions))]


@checked
def moved(tip: Tips, axis: Axes, *, between: Whole(1, 100) = 8):
    """Return a smooth motion through positions, at places between them.

    Parameters
    ----------
    tip : (k, 3) float
        Positions of the tip, in m, four or more.
    axis : (k, 3) float
        Directions of the axis.
    between : int
        Places from one position to the next.

    Returns
    -------
    tip, axis : (m, 3) float
        At (k - 1) times `between` places and one more: cubic splines over the way of tip and of
        the point one mean way of the tip higher; axes are unit vectors.
    """
    where = np.linspace(0, len(tip) - 1, (len(tip) - 1) * between + 1)
    return motion_through(tip, axis)(where)


def motion_through(tip, axis):
    """Return the smooth motion through positions, tip and axis (k, 3), as a function.

    Its argument (m,) counts positions from 0 to k - 1, in fractions between them; it returns tip
    and axis (m, 3).
    """
    from scipy.interpolate import CubicSpline

    if tip.shape != axis.shape:
        raise ValueError(f"tip, axis: must be as many; got {tip.shape} and {axis.shape}.")
    axis = axis / norm(axis)[:, None]
    chord = norm(np.diff(tip, axis=0))
    length = chord + chord.mean() * norm(np.diff(axis, axis=0))
    if not np.all(length > 0):
        raise ValueError("tip, axis: must differ from one position to the next; got equal ones.")
    knots = np.append(0.0, np.cumsum(length))
    index = np.arange(len(tip))
    both = CubicSpline(knots, np.hstack([tip, axis]))

    def motion(where):
        tips, axes = np.hsplit(both(np.interp(where, index, knots)), 2)
        return tips, axes / norm(axes)[:, None]

    return motion
