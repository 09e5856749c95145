"""Tools that turn about an axis: how far points are from what they cut with and from their holder.

A tool stands with its tip, the middle of its lower end, in a point; its axis goes up from there
to the spindle. All that counts of a point is its `height` above the tip and its distance `radius`
from the axis, both in m. The methods take such arrays (...) and return distances (...) from a part
of the tool, in m, negative within. How far points are beyond a part's faces is the same within;
outside it is above zero and at most the distance, and takes a tenth of the time.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import HalfAngle, Length, Length0, Lengths, checked


@dataclass(frozen=True)
@checked
class ConicalMill:
    """A truncated cone that widens upwards, above it a holder, and above that a spindle.

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
    spindle_radius, spindle_length : float
        Of the cylinder above that, the spindle's housing, in m; it counts as part of the holder.
        There is none by default.
    """

    half_angle: HalfAngle
    tip_radius: Length
    length: Length
    holder_radius: Length
    holder_length: Length
    spindle_radius: Length0 = 0.0
    spindle_length: Length0 = 0.0

    def __post_init__(self):
        if (self.spindle_radius > 0) != (self.spindle_length > 0):
            raise ValueError(
                "spindle_radius, spindle_length: must both be above zero, or neither; "
                f"got {self.spindle_radius:g} and {self.spindle_length:g} m."
            )

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
        return _stub(height, radius, 0.0, self.tip_radius, self.length, self.top_radius)

    @checked
    def holder(self, height: Lengths, radius: Lengths):
        """Return how far points are from the holder, in m, negative within."""
        return self._held(_stub, height, radius)

    @checked
    def cutting_faces(self, height: Lengths, radius: Lengths):
        """Return how far points are beyond faces of the cutting part, in m, negative within."""
        return _faces(height, radius, 0.0, self.tip_radius, self.length, self.top_radius)

    @checked
    def holder_faces(self, height: Lengths, radius: Lengths):
        """Return how far points are beyond faces of the holder, in m, negative within."""
        return self._held(_faces, height, radius)

    def _held(self, distance, height, radius):
        """Return distances from the holder, by a function of a truncated cone."""
        top = self.length + self.holder_length
        wide = self.holder_radius
        holder = distance(height, radius, self.length, wide, top, wide)
        if not self.spindle_length:
            return holder
        wide = self.spindle_radius
        return np.minimum(holder, distance(height, radius, top, wide, self.height, wide))

    @property
    def height(self):
        """Return how far all of it reaches above the tip, in m."""
        return self.length + self.holder_length + self.spindle_length

    @property
    def widest(self):
        """Return the greatest radius of all of it, in m."""
        return max(self.top_radius, self.holder_radius, self.spindle_radius)


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
        return _stub(height, radius, 0.0, self.radius, self.length, self.radius)

    @checked
    def cutting_faces(self, height: Lengths, radius: Lengths):
        """Return how far points are beyond faces of the cutting part, in m, negative within."""
        return _faces(height, radius, 0.0, self.radius, self.length, self.radius)


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

    @checked
    def cutting_faces(self, height: Lengths, radius: Lengths):
        """Return what `cutting` does: a ball has one face."""
        return self.cutting(height, radius)


def _stub(height, radius, low, first, high, last):
    """Return the distance (...) to a truncated cone between two heights, with radii there.

    In the half plane of the axis the wall is a segment, the ends are levels. Roots of sums of
    squares are within roundings of `hypot`, which takes several times as long.
    """
    length = np.hypot(high - low, last - first)
    c = (high - low) / length
    s = (last - first) / length
    up = height - low
    off = radius - first
    side = off * c - up * s
    along = up * c + off * s
    over = np.maximum(np.maximum(-along, along - length), 0.0)
    square = side * side + over * over
    down = height - high
    for level, wide in ((up, off), (down, radius - last)):
        beyond = np.maximum(wide, 0.0)
        square = np.minimum(square, level * level + beyond * beyond)
    inside = (side < 0) & (up > 0) & (down < 0)
    nearest = np.sqrt(square)
    return np.where(inside, -nearest, nearest)[()]


def _faces(height, radius, low, first, high, last):
    """Return how far (...) points are beyond the farthest of wall and ends of a truncated cone."""
    length = np.hypot(high - low, last - first)
    c = (high - low) / length
    s = (last - first) / length
    wall = (radius - first) * c - (height - low) * s
    return np.maximum(wall, np.maximum(height - high, low - height))


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
    if points.ndim == 3:
        away = points - tip[:, None]
        height = np.einsum("knc,kc->kn", away, axis)
        square = np.einsum("knc,knc->kn", away, away)
    else:
        # As products of matrices; about the points' middle the coordinates are as small as can be.
        middle = points.mean(axis=0)
        points = points - middle
        tip = tip - middle
        height = axis @ points.T - np.einsum("kc,kc->k", axis, tip)[:, None]
        square = np.einsum("nc,nc->n", points, points) - 2 * (tip @ points.T)
        square += np.einsum("kc,kc->k", tip, tip)[:, None]
    return height, np.sqrt(np.maximum(square - height * height, 0.0))
