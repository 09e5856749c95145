"""The cone of revolution on which the appendix tries the projected chord: Eqs 13 to 18."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angles, HalfAngle, Lengths, Points, checked


@dataclass(frozen=True)
@checked
class Cone:
    """A cone of revolution about the z axis, both nappes, apex in the origin.

    Parameters
    ----------
    half_angle : float
        Angle between the axis and a ruling, in rad, between 0 and pi/2.

    Raises
    ------
    ValueError
        If the angle isn't one number between 0 and pi/2.

    Notes
    -----
    Tunnelling robot, appendix. The text's k = tan^2(alpha/2) is corrected to tan^2(alpha), with
    alpha the half-angle; only so does Eq. 13 describe the cone with tan(alpha) = R/H.
    """

    half_angle: HalfAngle

    @property
    def k(self):
        """Return the coefficient k = tan^2(half_angle) of Eq. 13."""
        return np.tan(self.half_angle) ** 2

    @checked
    def implicit(self, point: Points):
        """Return the left side of Eq. 13, x^2 + y^2 - k z^2, at points (..., 3), in m^2."""
        x, y, z = np.moveaxis(point, -1, 0)
        # As a difference of lengths the left side has digits near the cone; squares would cancel.
        radius = np.hypot(x, y)
        reach = np.tan(self.half_angle) * np.abs(z)
        return (radius - reach) * (radius + reach)

    @checked
    def point(self, distance: Lengths, azimuth: Angles):
        """Return points on the nappe below the apex, as in the appendix.

        Parameters
        ----------
        distance : (...) float
            Distance from the apex along the ruling, in m; below zero it leads to the nappe above.
        azimuth : (...) float
            Angle about the axis, in rad.

        Returns
        -------
        point : (..., 3) float
            In m.
        """
        distance, azimuth = np.broadcast_arrays(distance, azimuth)
        radius = distance * np.sin(self.half_angle)
        height = -distance * np.cos(self.half_angle)
        return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)

    @checked
    def feet(self, m: Points):
        """Return where the two spheres about points touch the cone (Eqs 13 to 16).

        Parameters
        ----------
        m : (..., 3) float
            Centres M of the spheres, in m.

        Returns
        -------
        feet : (..., 2, 3) float
            Points N, in m. The nearer one comes first, on M's side of the axis; the other one is
            opposite. On the axis, M's side is that of azimuth 0; on the plane z = 0, where both
            nappes are equally far, the nappe below is taken.

        Notes
        -----
        They are projections on the two rulings of M's meridian plane. Their n1 are the roots of the
        document's quadratic Eq. 16, which has no answer at m1 = 0.

        Examples
        --------
        >>> Cone(np.arctan(0.5)).feet((-(2**0.5), -3 * 2**0.5, -12))[:, 2]
        array([-11.38885438,  -7.81114562])
        """
        x, y, z = np.moveaxis(m, -1, 0)
        sin, cos = np.sin(self.half_angle), np.cos(self.half_angle)
        rho = np.hypot(x, y)
        # The cone is mirrored in z = 0: the nappe on M's side has the nearer foot.
        nappe = np.where(z > 0, 1.0, -1.0)
        azimuth = np.arctan2(y, x)
        east, north = np.cos(azimuth), np.sin(azimuth)
        both = []
        for side in (1, -1):
            # M projected on the ruling of its meridian plane, on this side of the axis.
            distance = side * rho * sin + np.abs(z) * cos
            radius = side * distance * sin
            both.append(np.stack([radius * east, radius * north, nappe * distance * cos], axis=-1))
        return np.stack(both, axis=-2)

    @checked
    def development(self, distance: Lengths, azimuth: Angles):
        """Return where points of the cone lie when it is unrolled into a plane (Fig. 9).

        Parameters
        ----------
        distance : (...) float
            Distance from the apex, in m.
        azimuth : (...) float
            Angle about the cone's axis, in rad.

        Returns
        -------
        plane : (..., 2) float
            In m, with the apex in the origin and azimuth 0 along the first axis. Lengths and angles
            on the surface are kept.
        """
        # A parallel at the distance d is 2 pi d sin(half_angle) long, and becomes as long an arc.
        angle = azimuth * np.sin(self.half_angle)
        return np.stack(np.broadcast_arrays(distance * np.cos(angle), distance * np.sin(angle)), -1)
