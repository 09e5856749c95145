"""What a mill must stay off beside its patch: how deep it enters surfaces and points."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Rule, near_points
from ..kernels.exact import norm
from .tools import seen_from

BLOCK = 1_000_000  # pairs of a position and a cell that are looked at together
SMALLEST = 1e-5  # of a mill's height, and
WITHIN = 0.01  # of a depth, by which it may be deeper than what is found


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Cells of surfaces, bilinear between their corners; a point is a cell without a size.

    Parameters
    ----------
    corners : (m, 2, 2, 3) float
        In m.
    """

    corners: np.ndarray

    def __len__(self):
        return len(self.corners)

    @property
    def points(self):
        """Return the corners as points (n, 3), in m."""
        return self.corners.reshape(-1, 3)

    def deepest(self, mill, tip, axis):
        """Return how deep (k,) mills with their holders enter any cell, in m; 0 where they don't.

        Parameters
        ----------
        mill : ConicalMill
            The same for all.
        tip, axis : (k, 3) float
            Of the positions: in m, and unit vectors.
        """
        depth = np.zeros(len(tip))
        size = max(1, BLOCK // max(len(self), 1))
        for first in range(0, len(tip) if len(self) else 0, size):
            rows = slice(first, first + size)
            depth[rows] = self._deepest(mill, tip[rows], axis[rows])
        return depth

    def _deepest(self, mill, tip, axis):
        """Return those depths (k,): a cell is halved as long as it may lie deeper than any known.

        The distance to a mill changes by no more than the way: of a cell that is within `reach` of
        its middle no point is deeper than the middle and `reach`.
        """
        centre, reach = _balls(self.corners)
        height, radius = seen_from(centre, tip, axis)
        near = (height > -reach) & (height < mill.height + reach) & (radius < mill.widest + reach)
        row, cell = np.nonzero(near)
        corners = self.corners[cell]
        depth = np.zeros(len(tip))
        while len(row):
            centre, reach = _balls(corners)
            height, radius = seen_from(centre[:, None], tip[row], axis[row])
            outside = np.minimum(
                mill.cutting_faces(height, radius), mill.holder_faces(height, radius)
            )[:, 0]
            np.maximum.at(depth, row, -outside)
            deeper = reach - outside > (1 + WITHIN) * depth[row] + SMALLEST * mill.height
            row = np.repeat(row[deeper], 2)
            corners = _halves(corners[deeper])
        return depth


def _balls(corners):
    """Return middles (m, 3) of cells (m, 2, 2, 3), and how far (m,) they reach from there."""
    centre = corners.mean(axis=(1, 2))
    return centre, norm(corners - centre[:, None, None]).max(axis=(1, 2))


def _halves(corners):
    """Return both halves (2 m, 2, 2, 3) of cells (m, 2, 2, 3), cut across their longer sides."""
    first, second = (
        norm(side[:, 1] - side[:, 0]).max(axis=1) for side in (corners, corners.swapaxes(1, 2))
    )
    longer = (first >= second)[:, None, None, None]
    one, other = np.where(longer, corners, corners.swapaxes(1, 2)).swapaxes(0, 1)
    middle = (one + other) / 2
    halves = np.stack([np.stack([one, middle], axis=1), np.stack([middle, other], axis=1)], axis=1)
    return halves.reshape(-1, 2, 2, 3)


def _cells(array):
    """Return the cells (m, 2, 2, 3) of a grid (n, m, 3), or of points alone."""
    if array.ndim == 3 and min(array.shape[:2]) > 1:
        rows = np.stack([array[:-1], array[1:]], axis=2)
        return np.stack([rows[:, :-1], rows[:, 1:]], axis=3).reshape(-1, 2, 2, 3)
    return np.broadcast_to(array.reshape(-1, 1, 1, 3), (array.size // 3, 2, 2, 3))


def as_obstacles(name, value):
    """Return `value` as `Obstacles`: points, a grid of them, or a list of arrays of either kind."""
    if isinstance(value, Obstacles):
        return value
    several = isinstance(value, list) and any(np.ndim(part) > 1 for part in value)
    several = several and all(isinstance(part, np.ndarray) for part in value)
    arrays = [near_points(name, part) for part in (value if several else [value])]
    return Obstacles(np.concatenate([_cells(array) for array in arrays]))


# What arguments may be, in this room and above it.
Around = Annotated[
    ArrayLike, Rule("(n, 3) or (n, m, 3) float, or a list of them", as_obstacles, "m")
]
