"""By how much a machine stands elsewhere than planned."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angle, Coordinate, Point, Points, checked


@dataclass(frozen=True)
@checked
class Pose:
    """A small displacement of a machine from where it should stand, in m and rad.

    Parameters
    ----------
    y, z : float
        Shifts to the left and up, in m.
    roll, pitch, yaw : float
        Right-handed turns about the tunnel's x, y and z through the torus' centre, in this order,
        in rad.

    Raises
    ------
    ValueError
        If a number isn't finite, or above 1e100 in size.
    """

    y: Coordinate = 0.0
    z: Coordinate = 0.0
    roll: Angle = 0.0
    pitch: Angle = 0.0
    yaw: Angle = 0.0

    @checked
    def moved(self, point: Points, centre: Point):
        """Return points (..., 3) turned about a centre (3,) and then shifted, in m."""
        turn = np.eye(3)
        for axis, angle in enumerate((self.roll, self.pitch, self.yaw)):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            one = np.eye(3)
            one[[i, j], [i, j]] = np.cos(angle)
            one[i, j] = -np.sin(angle)
            one[j, i] = np.sin(angle)
            turn = one @ turn
        return (point - np.array(centre)) @ turn.T + centre + [0.0, self.y, self.z]
