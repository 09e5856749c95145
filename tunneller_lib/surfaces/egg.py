"""The egg-shaped sewer section, four blended arcs, and its inward offset: Fig. 4."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import finite, positive, real

WALL = np.arctan2(3, 4)  # angle of a wall arc: the centres make a 3-4-5 triangle


class Arc(NamedTuple):
    """An arc, counter-clockwise in the plane of y (left) and z (up); metres and radians."""

    y: float
    z: float
    radius: float
    start: float
    sweep: float


class Section:
    """A closed convex curve of arcs in the plane (y, z), counter-clockwise; see `arcs`.

    Arc length s runs from the first arc's start and repeats with the perimeter.
    """

    arcs: tuple[Arc, ...]

    @property
    def blends(self):
        """Return the arc lengths (n + 1,) at which the arcs begin, and the perimeter."""
        return np.concatenate([[0], np.cumsum([arc.radius * arc.sweep for arc in self.arcs])])

    @property
    def perimeter(self):
        """Return the length of the curve, in m."""
        return float(self.blends[-1])

    @property
    def area(self):
        """Return the area within the curve, in m^2, by Green's theorem on each arc."""
        y, z, radius, start, sweep = np.transpose(self.arcs)
        end = start + sweep
        moment = y * (np.sin(end) - np.sin(start)) - z * (np.cos(end) - np.cos(start))
        return float(np.sum(radius * (radius * sweep + moment)) / 2)

    def point(self, s):
        """Return the points (..., 2) = (y, z), in m, at arc lengths s (...), in m."""
        return self._centre_radius_direction(s)[0]

    def normal(self, s):
        """Return the outward unit normals (..., 2) = (y, z) at arc lengths s (...), in m."""
        return self._centre_radius_direction(s)[1]

    def _centre_radius_direction(self, s):
        s = np.mod(real("s", s), self.perimeter)
        index = np.clip(np.searchsorted(self.blends, s, side="right") - 1, 0, len(self.arcs) - 1)
        y, z, radius, start, _ = np.transpose(self.arcs)[:, index]
        angle = start + (s - self.blends[index]) / radius
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.stack([y, z], axis=-1) + radius[..., None] * normal, normal

    def depth(self, y, z):
        """Return how far points lie inside the curve.

        Parameters
        ----------
        y, z : (...) float
            In m.

        Returns
        -------
        depth : (...) float
            Distance to the curve, in m: positive inside, negative in the ground.

        Notes
        -----
        The nearest point of a convex curve lies on an arc within whose sector the given point
        is; only outside a corner no such arc exists, and the corner is nearest.
        """
        y, z = np.broadcast_arrays(real("y", y), real("z", z))
        inside = np.full(y.shape, np.inf)
        corner = np.full(y.shape, np.inf)
        for arc in self.arcs:
            dy, dz = y - arc.y, z - arc.z
            turned = np.mod(np.arctan2(dz, dy) - arc.start + 1e-12, 2 * np.pi)  # at a blend: both
            within = turned <= arc.sweep + 2e-12
            inside = np.where(within, np.minimum(inside, arc.radius - np.hypot(dy, dz)), inside)
            end = arc.radius * np.cos(arc.start), arc.radius * np.sin(arc.start)
            corner = np.minimum(corner, np.hypot(dy - end[0], dz - end[1]))
        return np.where(np.isfinite(inside), inside, -corner)[()]


@dataclass(frozen=True)
class Profile(Section):
    """A section given by its arcs, such as the offset of an egg.

    Parameters
    ----------
    arcs : tuple of Arc
        In counter-clockwise order, each starting where the last one ends.
    """

    arcs: tuple[Arc, ...]


@dataclass(frozen=True)
class Egg(Section):
    """The standard sewer section, in the plane of y (left) and z (up).

    Parameters
    ----------
    a : float
        Radius of the roof, in m; the walls have 3a, the invert a/2. The section fills a box of
        2a by 3a.

    Raises
    ------
    ValueError
        If a isn't one finite number above zero.

    Notes
    -----
    Tunnelling robot, section 2 and Fig. 4. Origin in the roof's centre; arc length begins at
    the left springing (a, 0) and runs over the crown. Walls about (-+2a, 0) over atan(3/4) each,
    invert about (0, -1.5a) over the rest.

    Examples
    --------
    >>> Egg(0.5).point(0.5 * np.pi / 2).round(12)
    array([0. , 0.5])
    """

    a: float

    def __post_init__(self):
        object.__setattr__(self, "a", positive("a", self.a))

    @property
    def arcs(self):
        """Return the four arcs: roof, right wall, invert, left wall."""
        return self.offset(0).arcs

    def offset(self, d):
        """Return the curve at a distance d inside the section.

        Parameters
        ----------
        d : float
            In m; for the centre of a cutter its radius less the depth of cut. Negative: outside.

        Returns
        -------
        profile : Profile
            Arcs with the same centres and radii less by d. From d = a/2 on the invert's arc is
            gone and the walls meet in a corner at (0, -sqrt((3a - d)^2 - 4a^2)). To offset
            further, offset the egg by the sum.

        Raises
        ------
        ValueError
            If d >= a, where nothing of the section is left.
        """
        a, d = self.a, finite("d", d)
        if d >= a:
            raise ValueError(f"d: must be below the roof's radius a = {a:g} m, or nothing of the "
                             f"section is left; got {d:g} m.")  # fmt: skip
        sweep = WALL if d < a / 2 else np.arccos(2 * a / (3 * a - d))
        roof = Arc(0.0, 0.0, a - d, 0.0, np.pi)
        right = Arc(2 * a, 0.0, 3 * a - d, np.pi, sweep)
        invert = Arc(0.0, -1.5 * a, a / 2 - d, np.pi + WALL, np.pi - 2 * WALL)
        left = Arc(-2 * a, 0.0, 3 * a - d, 2 * np.pi - sweep, sweep)
        return Profile((roof, right, invert, left) if d < a / 2 else (roof, right, left))
