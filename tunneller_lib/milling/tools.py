"""Tools that turn about an axis: how far points are from what they cut with and from their holder.

A tool stands with its tip, the middle of its lower end, in a point; its axis goes up from there
to the spindle. All that counts of a point is its `height` above the tip and its distance `radius`
from the axis, both in m. The methods take such arrays (...) and return distances (...) from a part
of the tool, in m, negative within.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import HalfAngle, Length, Lengths, checked


@dataclass(frozen=True)
@checked
class ConicalMill:
    """A truncated cone that widens upwards, and a holder above it.

    Parameters
    ----------
    half_angle : float
        Between axis and rulings, in rad.
    tip_radius : float
        Of the lower end, in m.
    length : float
        Of the cutting part, along the axis, in m.
    holder_radius, holder_length : float
        Of the cylinder that holds it, in m.
    """

    half_angle: HalfAngle
    tip_radius: Length
    length: Length
    holder_radius: Length
    holder_length: Length

    @property
    def top_radius(self):
        """Return the radius of the upper end, in m."""
        return self.tip_radius + self.length * np.tan(self.half_angle)

    @property
    def below(self):
        """Return how far the vertex lies below the tip, in m."""
        return self.tip_radius / np.tan(self.half_angle)

    @property
    def rulings(self):
        """Return where the rulings begin and end, as distances from the vertex, in m."""
        cosine = np.cos(self.half_angle)
        return self.tip_radius / np.sin(self.half_angle), (self.below + self.length) / cosine

    @checked
    def cutting(self, height: Lengths, radius: Lengths):
        """Return how far points are from the cutting part, in m, negative within."""
        return _stub(height, radius, self.tip_radius, self.length, self.top_radius)

    @checked
    def holder(self, height: Lengths, radius: Lengths):
        """Return how far points are from the holder, in m, negative within."""
        wide = self.holder_radius
        return _stub(height - self.length, radius, wide, self.holder_length, wide)


@dataclass(frozen=True)
@checked
class CylinderMill:
    """A cylinder that cuts with its flank.

    Parameters
    ----------
    radius, length : float
        In m.
    """

    radius: Length
    length: Length

    @checked
    def cutting(self, height: Lengths, radius: Lengths):
        """Return how far points are from the cutting part, in m, negative within."""
        return _stub(height, radius, self.radius, self.length, self.radius)


@dataclass(frozen=True)
@checked
class BallMill:
    """A ball that cuts: the end of a tool whose shank isn't looked at.

    Parameters
    ----------
    radius : float
        In m.
    """

    radius: Length

    @checked
    def cutting(self, height: Lengths, radius: Lengths):
        """Return how far points are from the ball, in m, negative within; the tip is its lowest."""
        return np.hypot(height - self.radius, radius) - self.radius


def _stub(height, radius, first, length, last):
    """Return the distance (...) to a truncated cone of a length, with radii at its ends.

    In the half plane of the axis the wall is a segment, the ends are levels. Roots of sums of
    squares are within roundings of `hypot`, which takes several times as long.
    """
    ruling = np.hypot(length, last - first)
    c = length / ruling
    s = (last - first) / ruling
    off = radius - first
    side = off * c - height * s
    along = height * c + off * s
    over = np.maximum(np.maximum(-along, along - ruling), 0.0)
    square = side * side + over * over
    for level, wide in ((height, off), (height - length, radius - last)):
        beyond = np.maximum(wide, 0.0)
        square = np.minimum(square, level * level + beyond * beyond)
    inside = (side < 0) & (height > 0) & (height < length)
    nearest = np.sqrt(square)
    return np.where(inside, -nearest, nearest)[()]


def seen_from(points, tip, axis):
    """Return heights above tools' tips, and distances from their axes, of points.

    Parameters
    ----------
    points : (n, 3) or (k, n, 3) float
        The same of all tools, or of each its own, in m.
    tip, axis : (k, 3) float
        Of the tools: in m, and unit vectors.

    Returns
    -------
    height, radius : (k, n) float
        In m.
    """
    away = points - tip[:, None]
    height = np.einsum("knc,kc->kn", away, axis)
    square = np.einsum("knc,knc->kn", away, away)
    return height, np.sqrt(np.maximum(square - height * height, 0.0))
