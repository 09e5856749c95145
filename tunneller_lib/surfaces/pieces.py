"""The pieces of a section, an arc or a line, each with the same questions to answer."""

from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Angle, Finite, Lengths, NotNegative, checked


@dataclass(frozen=True)
@checked
class Arc:
    """An arc, counter-clockwise in the plane of y (left) and z (up).

    Parameters
    ----------
    y, z : float
        Its centre, in m.
    radius : float
        In m; above zero in a section that closes.
    start, sweep : float
        Where it begins, and the angle over which it runs, in rad, from y to z.
    """

    y: Finite
    z: Finite
    radius: Finite
    start: Angle
    sweep: Angle

    @property
    def length(self):
        """Return its length, in m."""
        return self.radius * self.sweep

    @property
    def headings(self):
        """Return its directions at start and end, in rad from y to z."""
        return self.start + np.pi / 2, self.start + self.sweep + np.pi / 2

    @checked
    def locate(self, s: Lengths):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        angle = self.start + s / self.radius
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.array([self.y, self.z]) + self.radius * normal, normal

    @checked
    def depth(self, y: Lengths, z: Lengths, slack: NotNegative):
        """Return the depth of points behind the arc, infinite outside its sector, in m.

        The sector is wider by `slack`, in m on the arc, at both ends: at a blend both pieces count.
        """
        dy, dz = y - self.y, z - self.z
        wider = 1e-12 + slack / self.radius
        turned = np.mod(np.arctan2(dz, dy) - self.start + wider, 2 * np.pi)
        return np.where(turned <= self.sweep + 2 * wider, self.radius - np.hypot(dy, dz), np.inf)

    @checked
    def inset(self, d: Finite):
        """Return the arc at a distance d on its inner side."""
        return replace(self, radius=self.radius - d)

    @property
    def swept(self):
        """Return twice the area between the arc and the origin, in m^2."""
        y = self.y
        z = self.z
        radius = self.radius
        end = self.start + self.sweep
        moment = y * (np.sin(end) - np.sin(self.start)) - z * (np.cos(end) - np.cos(self.start))
        return radius * (radius * self.sweep + moment)


@dataclass(frozen=True)
@checked
class Line:
    """A straight piece in the plane of y (left) and z (up).

    Parameters
    ----------
    y, z : float
        Where it begins, in m.
    heading : float
        Its direction, in rad from y to z.
    length : float
        In m; above zero in a section that closes.
    """

    y: Finite
    z: Finite
    heading: Angle
    length: Finite

    @property
    def radius(self):
        """Return its radius of curvature, which is infinite."""
        return np.inf

    @property
    def headings(self):
        """Return its direction at start and end, in rad from y to z."""
        return self.heading, self.heading

    @checked
    def locate(self, s: Lengths):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        along = np.array([np.cos(self.heading), np.sin(self.heading)])
        points = np.array([self.y, self.z]) + s[..., None] * along
        return points, np.broadcast_to([along[1], -along[0]], points.shape)

    @checked
    def depth(self, y: Lengths, z: Lengths, slack: NotNegative):
        """Return the depth of points behind the line, infinite beyond its ends by `slack`, in m."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        dy, dz = y - self.y, z - self.z
        along = cos * dy + sin * dz
        within = (-slack <= along) & (along <= self.length + slack)
        return np.where(within, cos * dz - sin * dy, np.inf)

    @checked
    def inset(self, d: Finite):
        """Return the line at a distance d on its inner side."""
        return replace(
            self, y=self.y - d * np.sin(self.heading), z=self.z + d * np.cos(self.heading)
        )

    @property
    def swept(self):
        """Return twice the area between the line and the origin, in m^2."""
        return self.length * (self.y * np.sin(self.heading) - self.z * np.cos(self.heading))
