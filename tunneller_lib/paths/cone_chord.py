"""The test case of the appendix, a cone, whose geodesics are known: Eqs 17 to 19 and the table."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angles, Array, Finite, Length, checked
from ..surfaces import Cone
from .quadrature import gauss_rule

FACTOR = 1e8  # by which the three lengths may differ
APART = 1e-9  # turns by which f must keep away from whole and half ones
SLACK = 1e-9  # of the turn, by which rounding may carry an azimuth past an end

Fractions = Array("(...) float", low=0.0, high=1.0)


@dataclass(frozen=True)
@checked
class ConeChord:
    """A chord PQ between two points of a cone, its tangent-sphere path and the geodesic.

    Parameters
    ----------
    R, H : float
        Radius and distance below the apex of the circle on which P = (R, 0, -H) lies, in m.
    h : float
        Distance of Q below the apex, in m.
    f : float
        Fraction of a turn from P to Q. Whole turns don't count, and past a half turn the chord, and
        the shorter geodesic, go the other way round.

    Raises
    ------
    ValueError
        If a length isn't above zero, two of them differ by more than a factor of 1e8, or f is
        within 1e-9 of a whole turn, where the chord lies on a ruling, or of a half turn, where it
        meets the axis and the foot jumps.

    Notes
    -----
    Tunnelling robot, appendix. The document gives the point M only for f = 1/4; here f may be any.
    The document's theta = (S/R) phi is got by atan2, because phi passes 90 degrees on wide cones.

    Examples
    --------
    >>> ConeChord(1, 1, 1e-9, 0.25)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: R, H, h: must be within a factor of 1e+08 of each other, or ...
    """

    R: Length
    H: Length
    h: Length
    f: Finite

    def __post_init__(self):
        lengths = (self.R, self.H, self.h)
        if max(lengths) > FACTOR * min(lengths):
            raise ValueError(
                f"R, H, h: must be within a factor of {FACTOR:g} of each other, or rounding hides "
                f"the cone; got {self.R:g}, {self.H:g} and {self.h:g} m."
            )
        if abs(self.f - np.round(2 * self.f) / 2) < APART:
            raise ValueError(f"f: must be neither whole nor half a turn; got {self.f!r}.")

    @property
    def cone(self):
        """Return the cone, tan(half_angle) = R/H."""
        return Cone(np.arctan2(self.R, self.H))

    @property
    def turn(self):
        """Return the azimuth of Q, the shorter way round, in rad (the document's Theta_f)."""
        # Without the nearest whole number of turns the shorter way round is left.
        return 2 * np.pi * (self.f - np.round(self.f))

    @property
    def ends(self):
        """Return the distances of P and Q from the apex, S and sigma, in m."""
        slant = np.hypot(self.R, self.H)
        return slant, self.h * slant / self.H

    @checked
    def geodesic(self, u: Fractions):
        """Return points N_d of the geodesic, which is straight on the development (Eq. 17).

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
        return start + u[..., None] * (stop - start)

    @checked
    def azimuth(self, u: Fractions):
        """Return the azimuth of the geodesic's points (Eq. 18, by atan2).

        Parameters
        ----------
        u : (...) float
            Fraction of the geodesic's length from P to Q.

        Returns
        -------
        azimuth : (...) float
            The document's theta, in rad.
        """
        plane = self.geodesic(u)
        return np.arctan2(plane[..., 1], plane[..., 0]) / np.sin(self.cone.half_angle)

    @checked
    def chord_point(self, azimuth: Angles):
        """Return the points M (..., 3), in m, where the chord meets planes by the axis (Eq. 19).

        Parameters
        ----------
        azimuth : (...) float
            Angle of each plane about the axis, in rad, between 0 and `turn`.

        Raises
        ------
        ValueError
            If a plane doesn't meet the chord.
        """
        share = azimuth / self.turn
        if np.any((share < -SLACK) | (share > 1 + SLACK)):
            raise ValueError(
                f"azimuth: must lie between 0 and the chord's turn, {self.turn:g} rad; got others."
            )
        # Seen from the axis, M divides the chord as H sin(azimuth) to h sin(turn - azimuth): each
        # is the distance of an end from M's plane, up to one factor.
        near = self.H * np.sin(azimuth)
        far = self.h * np.sin(self.turn - azimuth)
        start, stop = self.cone.point(self.ends, [0.0, self.turn])
        return start + (near / (near + far))[..., None] * (stop - start)

    @checked
    def tangent_sphere(self, azimuth: Angles):
        """Return the distances LN of the tangent-sphere feet from the apex.

        Parameters
        ----------
        azimuth : (...) float
            Angle of M's plane about the axis, in rad, between 0 and `turn`.

        Returns
        -------
        distance : (...) float
            In m, of the foot of M on its own side of the axis. It is the scalar product of
            (rho, |z|) with the unit vector of the ruling; the document solves its quadratic Eq. 16.
        """
        m = self.chord_point(azimuth)
        sin = np.sin(self.cone.half_angle)
        cos = np.cos(self.cone.half_angle)
        return np.hypot(m[..., 0], m[..., 1]) * sin - m[..., 2] * cos

    @checked
    def table(self, u: Fractions):
        """Return the document's table.

        Parameters
        ----------
        u : (...) float
            Fraction of the geodesic's length from P to Q.

        Returns
        -------
        columns : (..., 5) float
            u, phi (in rad), LN, NN and NN - LN (in m). NN is the geodesic's distance from the apex,
            phi its angle on the development. The document's table has no heads; in this order its
            columns come out.
        """
        plane = self.geodesic(u)
        phi = np.arctan2(plane[..., 1], plane[..., 0])
        geodesic = np.hypot(plane[..., 0], plane[..., 1])
        path = self.tangent_sphere(self.azimuth(u))
        return np.stack([u, phi, path, geodesic, geodesic - path], axis=-1)

    @checked
    def path(self, u: Fractions):
        """Return the tangent-sphere path on the development, (..., 2) in m, at azimuth(u)."""
        azimuth = self.azimuth(u)
        distance = self.tangent_sphere(azimuth)
        return self.cone.development(distance, azimuth)

    @checked
    def deviation(self, u: Fractions):
        """Return how far the path lies off the geodesic.

        Parameters
        ----------
        u : (...) float
            Fraction of the geodesic's length from P to Q, where the azimuths are the same.

        Returns
        -------
        deviation : (...) float
            At right angles to the geodesic, in m, positive towards the apex. The document's
            NN - LN, at equal azimuth, has the same sign and is longer, for it is measured aslant.
        """
        start, stop = self.geodesic([0.0, 1.0])
        along = (stop - start) / np.hypot(*(stop - start))
        offset = self.path(u) - start
        # The apex lies to the left of the geodesic if the azimuth grows, else to its right.
        across = along[0] * offset[..., 1] - along[1] * offset[..., 0]
        return np.sign(self.turn) * across

    @property
    def geodesic_length(self):
        """Return the length of the geodesic from P to Q, in m."""
        return float(np.hypot(*np.diff(self.geodesic([0.0, 1.0]), axis=0)[0]))

    @property
    def path_length(self):
        """Return the length of the tangent-sphere path from P to Q, in m.

        Gauss-Legendre quadrature over w: in plan the chord passes the axis at a distance `gap`, and
        gap sinh(w) is the way along it. Near half a turn the foot hurries round the axis; the
        variable w spreads that out.
        """
        nodes, weights = gauss_rule(64)
        start, stop = self.cone.point(self.ends, [0.0, self.turn])
        chord = stop - start
        sin = np.sin(self.cone.half_angle)
        cos = np.cos(self.cone.half_angle)
        # The ends of the chord are `along` behind its point nearest to the axis.
        plan = np.hypot(chord[0], chord[1])
        gap = np.abs(start[0] * chord[1] - start[1] * chord[0]) / plan
        along = np.array([start[:2] @ chord[:2], stop[:2] @ chord[:2]]) / plan
        first, last = np.arcsinh(along / gap)
        w = np.interp(nodes, (-1, 1), (first, last))
        rho = gap * np.cosh(w)
        height = start[2] + (gap * np.sinh(w) - along[0]) / plan * chord[2]
        # The foot's distance from the apex, and its derivatives by w on the development: away from
        # the apex, and of the angle around it.
        distance = rho * sin - height * cos
        away = gap * np.sinh(w) * sin - rho / plan * chord[2] * cos
        around = gap / rho * sin
        return float(np.sum(weights * np.hypot(away, distance * around)) * (last - first) / 2)
