"""The pieces of a section, an arc or a line, each with the same questions to answer."""

from typing import NamedTuple

import numpy as np


class Arc(NamedTuple):
    """An arc, counter-clockwise in the plane of y (left) and z (up); metres and radians."""

    y: float
    z: float
    radius: float
    start: float
    sweep: float

    @property
    def length(self):
        """Return its length, in m."""
        return self.radius * self.sweep

    @property
    def headings(self):
        """Return its directions at start and end, in rad from y to z."""
        return self.start + np.pi / 2, self.start + self.sweep + np.pi / 2

    def locate(self, s):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        angle = self.start + s / self.radius
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.array([self.y, self.z]) + self.radius * normal, normal

    def depth(self, y, z, slack):
        """Return the depth of points behind the arc, infinite outside its sector, in m.

        The sector is wider by `slack`, in m on the arc, at both ends: at a blend both pieces count.
        """
        dy, dz = y - self.y, z - self.z
        wider = 1e-12 + slack / self.radius
        turned = np.mod(np.arctan2(dz, dy) - self.start + wider, 2 * np.pi)
        return np.where(turned <= self.sweep + 2 * wider, self.radius - np.hypot(dy, dz), np.inf)

    def inset(self, d):
        """Return the arc at a distance d on its inner side."""
        return self._replace(radius=self.radius - d)

    @property
    def swept(self):
        """Return twice the area between the arc and the origin, in m^2."""
        (y, z), radius, end = (self.y, self.z), self.radius, self.start + self.sweep
        moment = y * (np.sin(end) - np.sin(self.start)) - z * (np.cos(end) - np.cos(self.start))
        return radius * (radius * self.sweep + moment)


class Line(NamedTuple):
    """A straight piece from (y, z) along a heading, in rad from y (left) to z (up); metres."""

    y: float
    z: float
    heading: float
    length: float

    radius = np.inf

    @property
    def headings(self):
        """Return its direction at start and end, in rad from y to z."""
        return self.heading, self.heading

    def locate(self, s):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        s = np.asarray(s, dtype=float)
        along = np.array([np.cos(self.heading), np.sin(self.heading)])
        points = np.array([self.y, self.z]) + s[..., None] * along
        return points, np.broadcast_to([along[1], -along[0]], points.shape)

    def depth(self, y, z, slack):
        """Return the depth of points behind the line, infinite beyond its ends by `slack`, in m."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        dy, dz = y - self.y, z - self.z
        along = cos * dy + sin * dz
        within = (-slack <= along) & (along <= self.length + slack)
        return np.where(within, cos * dz - sin * dy, np.inf)

    def inset(self, d):
        """Return the line at a distance d on its inner side."""
        return self._replace(y=self.y - d * np.sin(self.heading),
                             z=self.z + d * np.cos(self.heading))  # fmt: skip

    @property
    def swept(self):
        """Return twice the area between the line and the origin, in m^2."""
        return self.length * (self.y * np.sin(self.heading) - self.z * np.cos(self.heading))
