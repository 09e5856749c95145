"""Mills: how far points are from the part that cuts, and from the holder above it.

A mill stands with its tip, the middle of its lower end, in a point; its axis goes up from there to
the spindle. As it turns about that axis, only the `height` of a point above the tip and its
distance `radius` from the axis count, both in m. The methods take such arrays (...) and return
distances (...) from a part of the mill, in m, negative within.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import HalfAngle, Length, Lengths, checked
from ..envelopes.cone_pose import distance_to_cone


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
        ruling = self.length / np.cos(self.half_angle)
        return distance_to_cone(height, radius, self.tip_radius, self.half_angle, ruling)

    @checked
    def holder(self, height: Lengths, radius: Lengths):
        """Return how far points are from the holder, in m, negative within."""
        above = height - self.length
        return distance_to_cone(above, radius, self.holder_radius, 0.0, self.holder_length)


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
        return distance_to_cone(height, radius, self.radius, 0.0, self.length)


@dataclass(frozen=True)
@checked
class BallMill:
    """A ball end, without the shank above it.

    Parameters
    ----------
    radius : float
        In m.
    """

    radius: Length

    @checked
    def cutting(self, height: Lengths, radius: Lengths):
        """Return how far points are from the ball, in m, negative within; the tip is its pole."""
        return np.hypot(height - self.radius, radius) - self.radius


def seen_from(points, tip, axis):
    """Return how high points are above mills' tips, and how far from their axes.

    Parameters
    ----------
    points : (n, 3) or (k, n, 3) float
        The same for all mills, or n for each, in m.
    tip, axis : (k, 3) float
        Of the mills: in m, and unit vectors.

    Returns
    -------
    height, radius : (k, n) float
        In m.
    """
    # The radius by Pythagoras: on the axis rounding may leave a square below zero.
    away = points - tip[:, None]
    height = np.einsum("knc,kc->kn", away, axis)
    square = np.einsum("knc,knc->kn", away, away)
    return height, np.sqrt(np.maximum(square - height * height, 0.0))
