"""The test case of the appendix: on a cone the geodesic is known. Eqs 17 to 19 and the table."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from ..arguments import finite, positive, real
from ..surfaces import Cone


@dataclass(frozen=True)
class ConeChord:
    """A chord PQ between two points of a cone, its tangent-sphere path and the geodesic.

    Parameters
    ----------
    R, H : float
        Radius and distance below the apex of the circle on which P = (R, 0, -H) lies, in m.
    h : float
        Distance of Q below the apex, in m.
    f : float
        Fraction of a turn from P to Q. Whole turns are left out, and past a half turn the
        chord, and the shorter geodesic, go the other way round.

    Raises
    ------
    ValueError
        If a length isn't above zero, or f is a whole or a half turn: the chord then lies on a
        ruling, or meets the axis, where the foot jumps.

    Notes
    -----
    Tunnelling robot, appendix. The document gives the point M only for f = 1/4; here for any f.
    Its theta = (S/R) phi is taken by atan2, because phi passes 90 degrees on wide cones.
    """

    R: float
    H: float
    h: float
    f: float

    def __post_init__(self):
        for name in ("R", "H", "h"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        object.__setattr__(self, "f", finite("f", self.f))
        if 2 * self.f == np.round(2 * self.f):
            raise ValueError(f"f: must be neither whole nor half a turn; got {self.f!r}.")

    @property
    def cone(self):
        """Return the cone, tan(half_angle) = R/H."""
        return Cone(np.arctan2(self.R, self.H))

    @property
    def turn(self):
        """Return the azimuth of Q, the shorter way round, in rad (the document's Theta_f)."""
        return 2 * np.pi * (self.f - np.round(self.f))

    @property
    def ends(self):
        """Return the distances of P and Q from the apex, S and sigma, in m."""
        slant = np.hypot(self.R, self.H)
        return slant, self.h * slant / self.H

    def geodesic(self, u):
        """Return the geodesic's points N_d, a straight line on the development (Eq. 17).

        Parameters
        ----------
        u : (...) float
            Fraction of the geodesic's length from P to Q.

        Returns
        -------
        plane : (..., 2) float
            Points on the development, in m.
        """
        start, stop = self.cone.development(self.ends, [0.0, self.turn])
        return start + real("u", u)[..., None] * (stop - start)

    def azimuth(self, u):
        """Return the azimuth theta of the geodesic's points, in rad (Eq. 18, by atan2)."""
        plane = self.geodesic(u)
        return np.arctan2(plane[..., 1], plane[..., 0]) / np.sin(self.cone.half_angle)

    def chord_point(self, azimuth):
        """Return the points M (..., 3), in m, where the chord meets planes on the axis (Eq. 19).

        Parameters
        ----------
        azimuth : (...) float
            Angle of each plane about the axis, in rad, between 0 and `turn`.
        """
        azimuth = real("azimuth", azimuth)
        near, far = self.H * np.sin(azimuth), self.h * np.sin(self.turn - azimuth)
        start, stop = self.cone.point(self.ends, [0.0, self.turn])
        return start + (near / (near + far))[..., None] * (stop - start)

    def tangent_sphere(self, azimuth):
        """Return the distances LN (...) of the tangent-sphere feet from the apex, in m.

        The foot of M on its own side of the axis: the scalar product of (rho, |z|) with the
        ruling. The document solves its quadratic Eq. 16 instead.
        """
        m = self.chord_point(azimuth)
        sin, cos = np.sin(self.cone.half_angle), np.cos(self.cone.half_angle)
        return np.hypot(m[..., 0], m[..., 1]) * sin - m[..., 2] * cos

    def table(self, u):
        """Return the document's table as columns (..., 5): u, phi (rad), LN, NN, NN - LN (m).

        NN is the geodesic's distance from the apex, phi its angle on the development. The
        column heads are missing in the document; its columns come out in the order
        u, phi, LN, NN, NN - LN.
        """
        u = real("u", u)
        plane = self.geodesic(u)
        phi = np.arctan2(plane[..., 1], plane[..., 0])
        geodesic = np.hypot(plane[..., 0], plane[..., 1])
        path = self.tangent_sphere(self.azimuth(u))
        return np.stack([u, phi, path, geodesic, geodesic - path], axis=-1)

    def path(self, u):
        """Return the tangent-sphere path on the development, (..., 2) in m, at azimuth(u)."""
        azimuth = self.azimuth(u)
        return self.cone.development(self.tangent_sphere(azimuth), azimuth)

    def deviation(self, u):
        """Return how far the path lies off the geodesic, at right angles to it, in m.

        Positive towards the apex, like NN - LN, by which the document compares at equal
        azimuth and which is longer by the slant.
        """
        start, stop = self.geodesic([0.0, 1.0])
        along = (stop - start) / np.hypot(*(stop - start))
        offset = self.path(u) - start
        across = along[0] * offset[..., 1] - along[1] * offset[..., 0]
        return np.sign(self.turn) * across

    @property
    def geodesic_length(self):
        """Return the length of the geodesic from P to Q, in m."""
        return float(np.hypot(*np.diff(self.geodesic([0.0, 1.0]), axis=0)[0]))

    @property
    def path_length(self):
        """Return the length of the tangent-sphere path from P to Q, in m.

        Gauss-Legendre quadrature, with the chord in plan written as gap sinh(w) along and gap
        away from the axis: near half a turn the foot hurries round the axis, which w stretches.
        """
        nodes, weights = legendre.leggauss(64)
        start, stop = self.cone.point(self.ends, [0.0, self.turn])
        chord = stop - start
        sin, cos = np.sin(self.cone.half_angle), np.cos(self.cone.half_angle)
        plan = np.hypot(chord[0], chord[1])
        gap = np.abs(start[0] * chord[1] - start[1] * chord[0]) / plan
        along = np.array([start[:2] @ chord[:2], stop[:2] @ chord[:2]]) / plan
        first, last = np.arcsinh(along / gap)
        w = first + (last - first) * (1 + nodes) / 2
        rho = gap * np.cosh(w)
        height = start[2] + (gap * np.sinh(w) - along[0]) / plan * chord[2]
        distance = rho * sin - height * cos
        away = gap * np.sinh(w) * sin - rho / plan * chord[2] * cos
        around = gap / rho * sin
        return float(np.sum(weights * np.hypot(away, distance * around)) * (last - first) / 2)
