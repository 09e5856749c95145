"""The two classes of shortest geodesics on a torus, each with its one unknown.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. In both classes sin(phi/2) or cos(phi/2) is
a multiple of cos(t), so that the turned angle and the length are integrals of smooth functions:
with D = A + B sin^2(t) and rho = c + 2R (E + B sin^2(t)),

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

rule = cache(leggauss)  # an eigenvalue problem each time


class Track(NamedTuple):
    """What one value of the unknown stands for: constants and limits of the integrals."""

    c: np.ndarray
    A: np.ndarray
    B: np.ndarray
    E: np.ndarray
    first: np.ndarray
    span: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


class Answer(NamedTuple):
    """Turned angle, length, Clairaut's constant and the cosines of the azimuths at a and b."""

    turned: np.ndarray
    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray

    def where(self, mask):
        """Return the answers that a mask picks."""
        return Answer(*(array[mask] for array in self))


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
    with np.errstate(divide="ignore", invalid="ignore"):
        # W sa + x sb is their difference where x sb < 0.
        sine = np.where(x * sb < 0, d * k2 / (W * sa - x * sb), W * sa + x * sb)
    span = np.arctan2(np.where(np.isnan(sine), 0, sine), sa * sb - W * x)
    span = np.where(span < 0, span + 2 * np.pi, span)
    first = np.arctan2(-x, sa)
    # A geodesic that would cross the inner equator has no turning point; then t = (pi - phi)/2.
    free = rest < 0
    A = np.abs(rest)
    slope_a, slope_b = np.sqrt(2 * R * (rho_a + c)), np.sqrt(2 * R * (r + R * np.cos(b) + c))
    return Track(
        c=c, A=A, B=np.where(free, 1, k2), E=np.where(free, A, 0),
        first=np.where(free, below_pi(a) / 2, first), span=np.where(free, (a - b) / 2, span),
        cos_a=x * slope_a / rho_a, cos_b=-W * slope_b / (r + R * np.cos(b)),
    )  # fmt: skip


def inner(torus, a, b, u):
    """Return the geodesics that rise from a over phi = pi, on a ring torus.

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
    c = (r - R) * np.tanh(u)
    kappa2 = (r - R) / R / (1 + np.exp(2 * np.minimum(u, 300)))
    rho_a, rho_b = r + R * np.cos(a), r + R * np.cos(b)
    start, stop = below_pi(a) / 2, below_pi(np.abs(b)) / 2
    cosines = [
        np.sqrt(2 * R * (kappa2 + np.sin(t) ** 2) * (rho + c)) / rho
        for t, rho in ((start, rho_a), (stop, rho_b))
    ]
    return Track(c, kappa2, np.ones_like(c), kappa2, -start, start + stop, *cosines)


def below_pi(phi):
    """Return how far angles are below pi, to the last digit: np.pi is less than pi by 1.2e-16."""
    return (np.pi - phi) + 1.2246467991473532e-16


def nodes_for(torus, a, angle):
    """Return how many nodes the quadrature needs, found by doubling them until nothing changed.

    Parameters
    ----------
    torus : Torus
        The surface.
    a : (n,) float
        Angles phi of the first ends, in rad.
    angle : (n,) float
        Turned angles, in rad.

    Returns
    -------
    count : int
        One for all of them.
    """
    if torus.r <= torus.R / 4 and np.all(a <= 1) and np.all(angle <= 2):
        return 20  # a working sheet: no geodesic comes near a node
    return 64 if torus.r > torus.R else 96


def integrate(torus, track, count):
    """Return the turned angle and the length of geodesics by Gauss-Legendre quadrature.

    Parameters
    ----------
    torus : Torus
        The surface.
    track : Track
        Constants and limits, arrays (n,).
    count : int
        Number of nodes.

    Returns
    -------
    turned, length : (n,) float
        In rad and m. In t = a0 sinh(y), which spreads out the peak at the turning point.
    """
    nodes, weights = rule(count)
    c, A, B, E, first, span = (array[..., None] for array in track[:6])
    peak = np.sqrt(np.minimum(A, E + c / (2 * torus.R)) / B)
    a0 = np.clip(np.hypot(peak, np.maximum(first, 0)), 1e-30, 3)
    x, z = first / a0, (first + span) / a0
    low, width = np.arcsinh(x), np.arcsinh(z) - np.arcsinh(x)
    # Far from the turning point that difference cancels, on a short way nearly all of it.
    shared = np.where(x > 0, z * np.hypot(1, x) + x * np.hypot(1, z), 1)
    width = np.where(x > 0, np.arcsinh(span / a0 * (x + z) / shared), width)
    y = low + width * (1 + nodes) / 2
    t = a0 * np.sinh(y)
    sin2 = np.sin(t) ** 2
    rho = c + 2 * torus.R * (E + B * sin2)
    step = weights * width / 2 * np.hypot(a0, t) * np.sqrt(2 * torus.R)
    density = step / np.sqrt((rho + c) * (A + B * sin2))
    return np.sum(c / rho * density, axis=-1), np.sum(rho * density, axis=-1)


def solve(family, torus, a, b, angle):
    """Return the geodesics of a class whose turned angle is the given one.

    Parameters
    ----------
    family : callable
        `outer` or `inner`.
    torus : Torus
        The surface.
    a, b : (n,) float
        Angles phi of the ends, in rad.
    angle : (n,) float
        Turned angles, in rad.

    Returns
    -------
    answer : Answer
        With the turned angle that was reached, to be compared with the given one.
    """
    from scipy.optimize.elementwise import find_root  # here: it takes longer to load than numpy

    count = nodes_for(torus, a, angle)

    def excess(u, a, b, angle):
        return integrate(torus, family(torus, a, b, u), count)[0] - angle

    rho_a = torus.r + torus.R * np.cos(a)
    low = -np.sqrt(rho_a / (2 * torus.R)) if family is outer else np.zeros_like(a)
    high = np.full_like(a, 0.5)
    short = np.ones(a.shape, dtype=bool)
    while np.any(short := short & (high < 500)):
        short[short] = excess(high[short], a[short], b[short], angle[short]) < 0
        high[short] *= 2
    u = find_root(excess, (low, high), args=(a, b, angle)).x
    track = family(torus, a, b, u)
    turned, length = integrate(torus, track, count)
    # For a given angle the length is stationary in c: that makes up for what the root lacks.
    return Answer(turned, length + track.c * (angle - turned), track.c, track.cos_a, track.cos_b)
