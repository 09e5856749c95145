"""Cutters as unions of solids, lowered onto points and triangles: the drop cutter."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Corners, Directions, Each, HalfAngle, Length, Points, Wholes, checked
from .box import Box
from .facet import UP, meet_edges, meet_faces
from .frustum import Frustum
from .rod import Rod
from .rounded_disc import RoundedDisc
from .touching import bounds

BLOCK = 200_000  # pairs of a place and a facet looked at together


Solids = Each(Rod, Frustum, Box, RoundedDisc, some=True)
Triangles = Wholes("(m, 3) int", 0, 2**53)
Cloud = Array("(n, 3) float", "m", last="x, y, z")


@dataclass(frozen=True)
@checked
class Cutter:
    """A tool of several solids in one frame, whose origin is its tip and whose axis is z.

    Parameters
    ----------
    parts : tuple of Rod, Frustum, Box or RoundedDisc
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
    def bull(cls, radius: Length, corner: Length, length: Length):
        """Return a bull-nose end mill: flat, with a rounded corner.

        Parameters
        ----------
        radius, corner, length : float
            Of the shank, of the corner, at most as much, and from tip to end, two corners at least,
            in m.
        """
        if corner > radius:
            raise ValueError(f"corner: must not be above the radius {radius:g} m; got {corner:g}.")
        _long_enough(length, 2 * corner)
        end = RoundedDisc((0, 0, corner), (0, 0, 1), radius - corner, corner)
        return cls((end, Rod((0, 0, corner), (0, 0, length), radius)))

    @classmethod
    @checked
    def cone(
        cls, radius: Length, half_angle: HalfAngle, length: Length, *, tip: Length | None = None
    ):
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
    def drop(self, points: Cloud, places: Corners, *, faces: Triangles | None = None):
        """Return how high the tip stops where the cutter is lowered along z onto a surface.

        Parameters
        ----------
        points : (n, 3) float
            In m, all of which it may come to rest on: a cloud, or a mesh's corners.
        places : (..., 2) float
            Where its axis is, x and y, in m.
        faces : (m, 3) int, optional
            Triangles between the points, by their numbers, on whose faces and edges it may come to
            rest as well.

        Returns
        -------
        heights : (...) float
            Of the tip over each place, in m; ``-inf`` where nothing is below the cutter.

        Raises
        ------
        ValueError
            If a face names a point that isn't there.

        Notes
        -----
        Lowered over a point, an edge or a face the cutter stops where that, moved upwards from the
        tip's plane, first touches it: `meet_facets`. The heights are those of a cutter and a mesh
        whose surfaces are off by at most 64 eps of the cutter's size, the triangle's and the
        distance between them.

        Examples
        --------
        >>> Cutter.ball(5, 30).drop([(3, 0, 1), (40, 0, 9)], [(0, 0), (3, 0), (20, 0)])
        array([  0.,   1., -inf])
        >>> roof = [(-9, 0, 0), (9, 0, 0), (0, 40, 40)]
        >>> heights = Cutter.ball(5, 30).drop(roof, [(0, 10), (0, -3)], faces=[(0, 1, 2)])
        >>> heights.round(6)
        array([12.071068, -0.928932])
        """
        over = places.reshape(-1, 2)
        heights = np.full(len(over), -np.inf)
        self._drop_on(points[:, None], over, heights, _meet_corners)
        if faces is not None and len(faces):
            if faces.max() >= len(points):
                raise ValueError(
                    f"faces: must name one of {len(points)} points; got {faces.max()}."
                )
            edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2))
            self._drop_on(points[faces], over, heights, meet_faces)
            self._drop_on(points[np.unique(edges, axis=0)], over, heights, meet_edges)
        return heights.reshape(places.shape[:-1])[()]

    def _drop_on(self, facets, places, heights, meet):
        """Raise heights (k,) over places (k, 2) to where facets (n, j, 3) stop the cutter."""
        for part in self.parts:
            low, high = bounds(part)
            for which, facet in _pairs(facets, places, low, high):
                # Nothing in a facet stops the part higher than its highest corner would.
                most = facets[facet, :, 2].max(axis=-1) - low[2]
                able = most > heights[which]
                which, facet = which[able], facet[able]
                if not len(which):
                    continue
                moved = facets[facet]
                level = moved[:, 0, 2].copy()
                moved[..., :2] -= places[which, None]
                moved[..., 2] -= level[:, None]
                enter, _ = meet(part, moved, UP)
                np.maximum.at(heights, which, level - enter)


def _meet_corners(part, corners, u):
    """Return where corners (n, 1, 3) meet a part on their way up."""
    return part.meet_line(corners[:, 0], u)


def _pairs(facets, places, low, high):
    """Yield the numbers of places and facets that a solid from `low` to `high` (3,) may touch."""
    order = np.argsort(places[:, 0])
    x = places[order, 0]
    least, most = facets[..., :2].min(axis=1), facets[..., :2].max(axis=1)
    # A place is over a facet if it's within its extent, widened by the solid's; a hair more, for
    # the differences round.
    hair = 1e-9 * (np.abs(low) + np.abs(high)).max()
    first = np.searchsorted(x, least[:, 0] - high[0] - hair)
    last = np.searchsorted(x, most[:, 0] - low[0] + hair, side="right")
    ends = np.cumsum(last - first)
    start = 0
    while start < len(facets):
        done = ends[start - 1] if start else 0
        stop = max(np.searchsorted(ends, done + BLOCK, side="right"), start + 1)
        count = (last - first)[start:stop]
        facet = np.repeat(np.arange(start, stop), count)
        which = order[
            np.arange(len(facet))
            + np.repeat(first[start:stop] - ends[start:stop] + count + done, count)
        ]
        y = places[which, 1]
        near = (y >= least[facet, 1] - high[1] - hair) & (y <= most[facet, 1] - low[1] + hair)
        yield which[near], facet[near]
        start = stop


def _long_enough(length, least):
    if not length >= least:
        raise ValueError(f"length: must be at least {least:g} m; got {length:g}.")
