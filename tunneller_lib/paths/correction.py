"""The corrected chord: the projected chord less the error that `ChordLaw` tells."""

import numpy as np

from ..arguments import Positions, checked
from ..surfaces import Torus
from .bounds import Count, check_on_sheet, check_points
from .chord_law import ChordLaw
from .projection import chord_points, feet


@checked
def corrected_chord(torus: Torus, p: Positions, q: Positions, n: Count):
    """Return points of the corrected chord between two joint positions: nearly a geodesic.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends P and Q, in rad; they broadcast.
    n : int
        Number of points, both ends included, from 2 to a million, and at most 5 million of all
        paths together.

    Returns
    -------
    path : (..., n, 2) float
        Joint positions (theta, phi) on the working sheet, in rad, at equal steps of the angle
        between the normals. On the reference machine's torus the longest step of 33 points is at
        most 1.034 times the shortest.

    Raises
    ------
    ValueError
        If n is below 2 or asks for too many points, a position isn't (theta, phi) or isn't on the
        working sheet, r + R cos(phi) >= 0.

    Notes
    -----
    M(t) of the chord is moved by -r g cos(Theta/2) / cos(s - Theta/2) along the pole of the
    normals' great circle (see `ChordLaw`) and then projected, as in section 3.3 of Tunnelling
    robot. What is left of the excess of length falls with (r/R)^4, and with the sixth power of a
    short chord's length on any torus. Within the reference machine's joint limits it is at most
    1 ppm at R/r = 10 and 0.6 % at R = r, where the uncorrected chord has 458 ppm and 4.7 %. On
    rings, r > R, it is no longer small at the corners. Where `ChordLaw` has no gap, between
    normals that differ by less than 1e-5 rad, along meridians and for ends beyond |phi| = 90 deg,
    this is the projected chord. Where a chord crosses the axis or the ring circle its foot
    jumps, and there is no path.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Torus
    >>> path = corrected_chord(Torus(0.1, 0.9), (0, -0.3), (0.8, 0.3), 3)
    >>> path.round(3) + 0.0
    array([[ 0. , -0.3],
           [ 0.4,  0. ],
           [ 0.8,  0.3]])
    >>> corrected_chord(Torus(0.1, 0.9), (0, -0.3), (0.8, 3), 3)
    Traceback (most recent call last):
    ValueError: q: must lie on the working sheet, r + R cos(phi) >= 0; got phi = 3 rad.
    """
    check_on_sheet(torus, p, q)
    check_points(n, np.broadcast_shapes(p.shape, q.shape)[:-1])
    return corrected_points(torus, p, q, np.linspace(0, 1, n))


def corrected_points(torus, p, q, u):
    """Return the corrected chord on a torus from p to q at shares u (n,) of its normals' angle."""
    # On the sphere of radius R with these normals the chord's point at the angle s from the middle
    # divides the chord as tan(s) divides tan(half).
    law = ChordLaw(p, q)
    half = law.angle[..., None] / 2
    s = half * (2 * u - 1)  # from the middle
    tan = np.tan(np.where(half > 0, half, 1))
    t = np.where(half > 0, (1 + np.tan(s) / tan) / 2, u)
    m = chord_points(torus, p, q, t)
    # The chord lies below the surface: on the way up to its foot a shift of M grows by
    # cos(s) / cos(half).
    shift = torus.r * law.gap(u) * np.cos(half) / np.cos(s)
    m = m - shift[..., None] * law.pole[..., None, :]
    return feet(torus, m)
