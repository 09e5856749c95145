"""The two classes of shortest geodesics on a torus, each with its one unknown.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. In both classes sin(phi/2) or cos(phi/2) is
a multiple of cos(t), so that the turned angle and the length are integrals of smooth functions:
with D = A + B sin^2(t) and rho = c + 2R (E + B sin^2(t)),

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.
"""

from typing import NamedTuple

import numpy as np


class Track(NamedTuple):
    """What one value of the unknown stands for.

    `at` (6, n) holds c, A, B, E, the lower limit of t and how far the upper one is from it; `rate`
    what c, A, B, E and both limits change by with the unknown; cos_a and cos_b (n,) are the
    cosines of the azimuths.
    """

    at: np.ndarray
    rate: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


def outer(torus, a, b, u):
    """Return the geodesics that descend to b, at once (u < 0) or after rising above a (u > 0).

    Parameters
    ----------
    torus : Torus
        The surface.
    a, b : (n,) float
        Angles phi of the ends, in rad.
    u : (n,) float
        The unknown, from -sqrt(rho_a / 2R), the meridian, upwards.

    Returns
    -------
    track : Track
        The geodesic of each u.
    """
    r, R = torus.r, torus.R
    sa, sb, rho_a = np.sin(a / 2), np.sin(b / 2), r + R * np.cos(a)
    X = np.cos(a / 2) if r >= R else np.sqrt(rho_a / (2 * R))
    rising = u > 0
    high = np.where(rising, u / X, 0)
    x = np.where(rising, X * np.tanh(high), u)
    # X - x without cancellation where u is great; at such bounds the geodesic runs into the node,
    # with a turn too sharp for the quadrature if it were followed farther, or turns many times.
    bound = 300 if r > R else 30
    gap = np.where(rising, 2 * X / (1 + np.exp(2 * np.minimum(high, bound))), X - x)
    e = gap * (X + x)
    d = np.sin((a + b) / 2) * np.sin((a - b) / 2)  # sin^2(a/2) - sin^2(b/2)
    W = np.sqrt(np.maximum(d + x * x, 0))
    k2 = sa * sa + x * x
    c = max(r - R, 0) + 2 * R * e
    rest = e + (0 if r >= R else np.cos(a / 2) ** 2 - X * X)  # 1 - k^2
    dx = np.where(rising, e / X**2, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # W sa + x sb is their difference where x sb < 0.
        sine = np.where(x * sb < 0, d * k2 / (W * sa - x * sb), W * sa + x * sb)
        dfirst, dlast = -sa * dx / k2, sb * x * dx / (W * k2)
    span = np.arctan2(np.where(np.isnan(sine), 0, sine), sa * sb - W * x)
    span = np.where(span < 0, span + 2 * np.pi, span)
    first = np.arctan2(-x, sa)
    slope_a, slope_b = np.sqrt(2 * R * (rho_a + c)), np.sqrt(2 * R * (r + R * np.cos(b) + c))
    dk2 = 2 * x * dx
    at = _rows(c, rest, k2, 0, first, span)
    rate = _rows(-2 * R * dk2, -dk2, dk2, 0, dfirst, dlast)
    # A geodesic that would cross the inner equator has no turning point; then t = (pi - phi)/2.
    free = rest < 0
    at = np.where(free, _rows(c, -rest, 1, -rest, below_pi(a) / 2, (a - b) / 2), at)
    rate = np.where(free, _rows(-2 * R * dk2, dk2, 0, dk2, 0, 0), rate)
    return Track(at, rate, x * slope_a / rho_a, -W * slope_b / (r + R * np.cos(b)))


def inner(torus, a, b, u):
    """Return the geodesics that rise from a over phi = pi to b + 2 pi, on a ring torus.

    Parameters
    ----------
    torus : Torus
        The surface, a ring.
    a, b : (n,) float
        Angles phi of the ends, in rad.
    u : (n,) float
        The unknown, from 0, the meridian, upwards.

    Returns
    -------
    track : Track
        The geodesic of each u.
    """
    r, R = torus.r, torus.R
    slow = 1 / (1 + np.exp(2 * np.minimum(u, 300)))
    c, kappa2 = (r - R) * np.tanh(u), (r - R) / R * slow
    rho_a, rho_b = r + R * np.cos(a), r + R * np.cos(b)
    start, stop = below_pi(a) / 2, below_pi(-b) / 2
    dc, dkappa2 = 4 * (r - R) * slow * (1 - slow), -2 * kappa2 * (1 - slow)
    cosines = [
        np.sqrt(2 * R * (kappa2 + np.sin(t) ** 2) * (rho + c)) / rho
        for t, rho in ((start, rho_a), (stop, rho_b))
    ]
    at = _rows(c, kappa2, 1, kappa2, -start, start + stop)
    return Track(at, _rows(dc, dkappa2, 0, dkappa2, 0, 0), *cosines)


def below_pi(phi):
    """Return how far angles phi are below pi, to the last digit: np.pi is 1.2e-16 too small."""
    return (np.pi - phi) + 1.2246467991473532e-16


def _rows(*values):
    return np.stack(np.broadcast_arrays(*values))
