"""How far the projected chord lies beside the geodesic, for chords of any length.

A torus is the sphere of radius R disturbed by r: its point with the outward unit normal n is
R n + r e(n), where e(n) points away from the axis. To first order in r/R both paths then are
curves beside the great circle of the normals, and everything here follows from the normals alone.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import Positions, checked
from ..kernels.exact import cross, dot, norm
from ..surfaces.torus import torus_normal
from .bounds import Row
from .quadrature import gauss_rule

LEAST_ANGLE = 1e-5  # rad between the normals: on shorter chords the gap is below rounding
LEAST_LEVEL = 1e-15  # of a pole above the equator: on circles with lower ones it is so, too
ORDER = 48  # nodes of the quadrature over an arc
PLACES = 65  # of an arc at which the widest gap is sought


@dataclass(frozen=True, eq=False)
@checked
class ChordLaw:
    """The law of the projected chord's error: it lies r g aside, and is longer by (r/R)^2 F.

    Parameters
    ----------
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends P and Q, in rad; they broadcast. The sizes of the
        torus don't matter: the normals at both ends are enough.

    Notes
    -----
    The law is of first order in r/R and holds for chords of any length. A and B are the normals at
    P and Q, Theta is the angle between them, b the pole of their great circle and s the angle from
    A along it. Let m_y be the component of the normal there along the torus' axis. The ring pushes
    the torus across the circle by psi = e . b = -b_y m_y / sqrt(1 - m_y^2). Both paths follow the
    great circle that joins the pushed ends. Beside that circle the geodesic swings by w, where
    w'' + w = psi and w = 0 at both ends, and the projected chord by
    v = psi (1 - cos(s - Theta/2) / cos(Theta/2)). The gap is g = v - w, in units of r.

    The law is for the half of the tube that faces away from the axis, |phi| < 90 deg, where a
    normal n has one e(n). The gap comes as zero where an end lies beyond, on meridians, and for
    Theta below `LEAST_ANGLE`; as Theta nears a half turn it grows without limit.

    Examples
    --------
    >>> corner = ChordLaw((-1.0, 0.6), (0.6, -0.6))
    >>> round(float(corner.excess), 6), round(float(corner.aside), 5)
    (0.028344, 0.1034)
    """

    p: Positions
    q: Positions

    @property
    def pole(self):
        """Return the unit pole b (..., 3) of the normals' circle; zero where g comes as zero."""
        pole, _ = self._circle()
        return pole

    @property
    def angle(self):
        """Return the angle Theta (...) between the normals at the ends, in rad."""
        _, angle = self._circle()
        return angle

    @checked
    def gap(self, u: Row):
        """Return by how much the projected chord swings farther than the geodesic.

        Parameters
        ----------
        u : (n,) float
            Shares of the normals' angle, 0 at P and 1 at Q.

        Returns
        -------
        gap : (..., n) float
            g in units of r, positive towards the pole.
        """
        gap, _ = self._gap_and_slope(u)
        return gap

    @property
    def aside(self):
        """Return max |g| (...), the greatest deviation from the geodesic in units of r."""
        u = np.linspace(0, 1, PLACES)
        gap, _ = self._gap_and_slope(u)
        # Once more, closely about the widest: a step of an arc misses a maximum by its square.
        widest = u[np.argmax(np.abs(gap), axis=-1)][..., None]
        near, _ = self._gap_and_slope(np.clip(widest + (u - 0.5) / (PLACES / 4), 0, 1))
        return np.max(np.abs(near), axis=-1)

    @property
    def excess(self):
        """Return F (...), the relative excess of length in units of (r/R)^2.

        A geodesic is the shortest way: so a gap beside it costs the second variation of length, the
        mean of (g'^2 - g^2) / 2 over the arc. F is right to 1e-10 of itself for |phi| up to 80 deg
        and turns up to 95 deg. Where the normals' circle passes close by the torus' axis, as with
        85 and 170 deg, g' has a peak between the quadrature's nodes, and F may be off by a fifth.
        """
        x, weights = gauss_rule(ORDER)
        gap, slope = self._gap_and_slope((1 + x) / 2)
        return (slope**2 - gap**2) @ weights / 4

    def _circle(self):
        """Return the unit pole of the normals' circle, zero where the gap is, and their angle."""
        first, last = normals(self.p), normals(self.q)
        pole = cross(*np.broadcast_arrays(first, last))
        sine = norm(pole)
        angle = np.arctan2(sine, dot(first, last))
        pole = pole / np.where(sine > 0, sine, 1)[..., None]
        outside = np.minimum(np.cos(self.p[..., 1]), np.cos(self.q[..., 1])) > 0
        # Elsewhere the law doesn't hold, or the gap is below rounding.
        told = outside & (angle >= LEAST_ANGLE) & (np.abs(pole[..., 1]) >= LEAST_LEVEL)
        return np.where(told[..., None], pole, 0), angle

    def _gap_and_slope(self, u):
        """Return g (..., n) and its derivative by s at shares u (..., n) of the arc.

        The oscillator w'' + w = psi is solved by variation of parameters. With sigma counted from
        the node, where the circle crosses the equator and m_y = c sin(sigma), one of the two
        integrals is elementary and the other one elliptic.
        """
        pole, angle = self._circle()
        told = pole[..., 1:2] != 0
        # Ones stand in for what would be divided by where the gap comes as zero.
        angle = np.where(told, angle[..., None], 1)
        level = np.where(told, pole[..., 1:2], 1)  # b_y
        steep = np.hypot(pole[..., 0], pole[..., 2])[..., None]  # c, the sine of its inclination
        first = np.broadcast_to(normals(self.p), pole.shape)
        node = np.arctan2(first[..., 1], cross(pole, first)[..., 1])[..., None]
        s = u * angle
        half = angle / 2

        sin, cos = np.sin(node + s), np.cos(node + s)
        away = np.hypot(level, steep * cos)  # sqrt(1 - m_y^2)
        psi = -level * steep * sin / away
        psi_slope = -level * steep * cos / away**3
        sag = 1 - np.cos(s - half) / np.cos(half)
        sag_slope = np.sin(s - half) / np.cos(half)

        swing, slope = _forced(node + s, level, steep)
        start, _ = _forced(node, level, steep)
        stop, _ = _forced(node + angle, level, steep)
        # A free oscillation is taken off that brings w to zero at both ends.
        swing = swing - (start * np.sin(angle - s) + stop * np.sin(s)) / np.sin(angle)
        slope = slope - (stop * np.cos(s) - start * np.cos(angle - s)) / np.sin(angle)

        gap = np.where(told, psi * sag - swing, 0)
        return gap, np.where(told, psi_slope * sag + psi * sag_slope - slope, 0)


def normals(position):
    """Return the outward unit normals (..., 3) at joint positions (..., 2), of any torus."""
    return torus_normal(*np.moveaxis(position, -1, 0))


def _forced(sigma, level, steep):
    """Return the solution of w'' + w = psi with w = w' = 0 in the node, and its derivative."""
    sin, cos = np.sin(sigma), np.cos(sigma)
    elementary = sin**2 / (1 + np.hypot(level, steep * cos))
    elliptic = _elliptic(sigma, level, steep)
    swing = cos * elliptic - sin * elementary
    slope = -sin * elliptic - cos * elementary
    return level * steep * swing, level * steep * slope


def _elliptic(sigma, level, steep):
    """Return the integral of sin^2 / sqrt(1 - steep^2 sin^2) from 0 to sigma, in Carlson's form.

    Legendre's form, (F - E) / steep^2, would lose its digits on circles near the equator, where
    steep is small.
    """
    from scipy.special import elliprd  # here, for it takes longer to load than numpy

    # Carlson's form is for a quarter turn to either side; whole half turns are complete integrals.
    turns = np.round(sigma / np.pi)
    sin, cos = np.sin(sigma - turns * np.pi), np.cos(sigma - turns * np.pi)
    quarter = elliprd(0, level**2, 1) / 3
    return sin**3 * elliprd(cos**2, level**2 + (steep * cos) ** 2, 1) / 3 + 2 * turns * quarter
