"""Cutters as unions of solids, lowered onto points: the drop cutter's elementary step."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Corners, Directions, Length, Points, Rule, checked, near_points, shown
from .box import Box
from .frustum import Frustum
from .rod import Rod

BLOCK = 2_000_000  # points under places looked at together
UP = (0.0, 0.0, 1.0)


def _solids(name, value):
    """Return `value` as a tuple of solids."""
    parts = tuple(value) if isinstance(value, (tuple, list)) else ()
    if not parts or not all(isinstance(part, (Rod, Frustum, Box)) for part in parts):
        raise ValueError(
            f"{name}: must be rods, frusta or boxes, one at least; got {shown(value)}."
        )
    return parts


def _cloud(name, value):
    """Return `value` as a float array (n, 3) of points."""
    cloud = near_points(name, value)
    if cloud.ndim != 2:
        raise ValueError(f"{name}: must have the shape (n, 3); got {cloud.shape}.")
    return cloud


Solids = Annotated[tuple, Rule("tuple of Rod, Frustum or Box", _solids)]
Cloud = Annotated[ArrayLike, Rule("(n, 3) float", _cloud, "m")]


@dataclass(frozen=True)
@checked
class Cutter:
    """A tool of several solids in one frame, whose origin is its tip and whose axis is z.

    Parameters
    ----------
    parts : tuple of Rod, Frustum or Box
        The solids, which may overlap, in m.

    Raises
    ------
    ValueError
        If there is no part, or one is something else.
    """

    parts: Solids

    @classmethod
    @checked
    def ball(cls, radius: Length, length: Length):
        """Return a ball cutter.

        Parameters
        ----------
        radius, length : float
            Of the ball, and from its tip to the shank's end, in m, two radii at least.
        """
        _long_enough(length, 2 * radius)
        return cls((Rod((0, 0, radius), (0, 0, length - radius), radius, ends="round"),))

    @classmethod
    @checked
    def flat(cls, radius: Length, length: Length):
        """Return a flat end mill.

        Parameters
        ----------
        radius, length : float
            In m.
        """
        return cls((Rod((0, 0, 0), (0, 0, length), radius),))

    @classmethod
    @checked
    def cone(cls, radius: Length, half_angle: Length, length: Length, *, tip: Length | None = None):
        """Return a cone with a shank: a drill, an engraver, with a tip's radius a tapered mill.

        Parameters
        ----------
        radius : float
            Of the shank, in m.
        half_angle : float
            Of the cone, in rad, below pi/2.
        length : float
            From the tip to the shank's end, in m, longer than the cone.
        tip : float, optional
            Radius of the disc that the cone ends in, in m, less than the shank's; a point unless
            given.
        """
        least = 0.0 if tip is None else tip
        if half_angle >= np.pi / 2:
            raise ValueError(f"half_angle: must be below pi/2 rad; got {half_angle:g}.")
        if least >= radius:
            raise ValueError(f"tip: must be below the shank's {radius:g} m; got {least:g}.")
        height = (radius - least) / np.tan(half_angle)
        _long_enough(length, height)
        shank = Rod((0, 0, height), (0, 0, length), radius)
        return cls((Frustum((0, 0, 0), (0, 0, height), least, radius), shank))

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines first enter and last leave the cutter.

        Parameters
        ----------
        point, direction : (..., 3) float
            One point of each line, in m, and its direction, of any length but zero.

        Returns
        -------
        enter, leave : (...) float
            In lengths of the direction, each as exact as of one solid; between them a line may be
            outside. ``inf`` and ``-inf`` where it misses all parts.
        """
        ends = [part.meet_line(point, direction) for part in self.parts]
        enter = np.min([first for first, _ in ends], axis=0)
        return enter, np.max([last for _, last in ends], axis=0)

    @checked
    def drop(self, points: Cloud, places: Corners):
        """Return how high the tip stops where the cutter is lowered along z onto points.

        Parameters
        ----------
        points : (n, 3) float
            In m, all of which it may come to rest on: a cloud, or a fine mesh's corners.
        places : (..., 2) float
            Where its axis is, x and y, in m.

        Returns
        -------
        heights : (...) float
            Of the tip over each place, in m; ``-inf`` where no point is below the cutter.

        Notes
        -----
        Lowered over a point the cutter stops where a line upwards from its tip's plane first
        enters it: what the drop cutter asks of a mesh's corners. Edges and faces between the points
        aren't looked at.

        Examples
        --------
        >>> heights = Cutter.ball(5, 30).drop([(3, 0, 1), (40, 0, 9)], [(0, 0), (3, 0), (20, 0)])
        >>> heights
        array([  0.,   1., -inf])
        """
        over = places.reshape(-1, 2)
        heights = np.full(len(over), -np.inf)
        step = max(1, BLOCK // max(1, len(points)))
        for first in range(0, len(over), step):
            block = slice(first, first + step)
            beside = np.zeros((len(over[block]), len(points), 3))
            beside[..., :2] = points[:, :2] - over[block, None]
            enter, _ = self.meet_line(beside, UP)
            heights[block] = np.max(points[:, 2] - enter, axis=1, initial=-np.inf)
        return heights.reshape(places.shape[:-1])[()]


def _long_enough(length, least):
    if not length >= least:
        raise ValueError(f"length: must be at least {least:g} m; got {length:g}.")
