"""The classes of geodesics on a torus, each with its one unknown.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. Clairaut's c = rho sin(azimuth) is constant
along it, so that with rho = r + R cos(phi)

    d(theta) / d(phi) = R c / (rho sqrt(rho^2 - c^2)),   d(s) / d(phi) = R rho / sqrt(rho^2 - c^2).

The root vanishes at a turning point, where rho = c, and a quadrature in phi would fail there. In
both classes sin(phi/2) or cos(phi/2) is a multiple of cos(t), by which it goes: with
D = A + B sin^2(t) and rho = c + 2R (E + B sin^2(t)),

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.
"""

from typing import NamedTuple

import numpy as np


class Integrand(NamedTuple):
    """What one value of the unknown stands for: both integrals' constants and limits.

    `at` (6, n) holds c, A, B, E, the lower limit of t and how far the upper one is from it; `rate`
    what c, A, B, E and both limits change by with the unknown; cos_a and cos_b (n,) are the
    cosines of the azimuths. A way in legs has the next one in `onward`, mirrored to where t is in
    (-pi/2, pi/2].
    """

    at: np.ndarray
    rate: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray
    onward: "Integrand | None" = None


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
    integrand : Integrand
        That of each u.

    Notes
    -----
    sin(phi/2) = k cos(t), with t = 0 at the turning point. Let x = -k sin(t) at a, which is
    negative where the turning point is behind, and W = k sin(t) at b. Then k^2 = sin^2(a/2) + x^2,
    rho_a - c = 2R x^2 and rho_b - c = 2R W^2: nothing cancels where x is small, and all follows
    from x.
    """
    r, R = torus.r, torus.R
    sa = np.sin(a / 2)
    sb = np.sin(b / 2)
    rho_a = r + R * np.cos(a)
    # x stays below X. On a ring the geodesic of x = X winds towards the inner equator (k = 1,
    # c = r - R), on a spindle it is the meridian, through the node (c = 0).
    X = np.cos(a / 2) if r >= R else np.sqrt(rho_a / (2 * R))
    # On a ring the turned angle grows without limit towards X, as a logarithm, and on a spindle
    # the way turns ever more sharply by the node: x = X tanh(u / X) spreads that out. Below zero
    # there is no such end, and x = u joins without a bend.
    rising = u > 0
    high = np.where(rising, u / X, 0)
    x = np.where(rising, X * np.tanh(high), u)
    # X - x without cancellation where u is great; at such bounds the geodesic runs into the node,
    # with a turn too sharp for the quadrature if it were followed farther, or turns many times.
    bound = 300 if r > R else 30
    gap = np.where(rising, 2 * X / (1 + np.exp(2 * np.minimum(high, bound))), X - x)
    e = gap * (X + x)  # X^2 - x^2
    d = np.sin((a + b) / 2) * np.sin((a - b) / 2)  # sin^2(a/2) - sin^2(b/2), near ends or not
    W = np.sqrt(np.maximum(d + x * x, 0))
    k2 = sa * sa + x * x
    c = max(r - R, 0) + 2 * R * e
    rest = e + (0 if r >= R else np.cos(a / 2) ** 2 - X * X)  # 1 - k^2
    dx = np.where(rising, e / X**2, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # The sine of the span times k^2 is W sa + x sb. Where x sb < 0 that is a difference; its
        # product with the sum, W^2 sa^2 - x^2 sb^2, is d k^2.
        sine = np.where(x * sb < 0, d * k2 / (W * sa - x * sb), W * sa + x * sb)
        dfirst = -sa * dx / k2
        dlast = sb * x * dx / (W * k2)
    span = np.arctan2(np.where(np.isnan(sine), 0, sine), sa * sb - W * x)
    span = np.where(span < 0, span + 2 * np.pi, span)  # atan2 knows no more than pi
    first = np.arctan2(-x, sa)
    slope_a = np.sqrt(2 * R * (rho_a + c))
    slope_b = np.sqrt(2 * R * (r + R * np.cos(b) + c))
    dk2 = 2 * x * dx
    at = _rows(c, rest, k2, 0, first, span)
    rate = _rows(-2 * R * dk2, -dk2, dk2, 0, dfirst, dlast)
    # k > 1, c < r - R: prolonged, it would cross the inner equator, without a turning point. D
    # would vanish there in that form; t = (pi - phi)/2, cos(phi/2) = sin(t), has no such place.
    free = rest < 0
    at = np.where(free, _rows(c, -rest, 1, -rest, _below_pi(a) / 2, (a - b) / 2), at)
    rate = np.where(free, _rows(-2 * R * dk2, dk2, 0, dk2, 0, 0), rate)
    return Integrand(at, rate, x * slope_a / rho_a, -W * slope_b / (r + R * np.cos(b)))


def second(torus, a, b, u, sense=1):
    """Return the geodesics that turn on the other side of the outer equator and rise to b.

    They come to the parallel b a second time, after descending at once (u < 0) or after rising
    above a (u > 0).

    Parameters
    ----------
    torus : Torus
        The surface.
    a, b : (n,) float
        Angles phi of the ends, in rad.
    u : (n,) float
        The unknown, any number: far from zero, c nears 0, or r - R on a ring.
    sense : {1, -1}
        -1 if it is the negative of the unknown that is given.

    Returns
    -------
    integrand : Integrand
        That of each u, in three legs.

    Notes
    -----
    As `outer`, but for the end: t passes pi, where phi is least, and stops at 2 pi - t_b, with
    sin(b/2) = k cos(t_b). The integrands repeat after pi, and backwards from any multiple of pi/2.
    """
    r, R = torus.r, torus.R
    sa = np.sin(a / 2)
    sb = np.sin(b / 2)
    rho_a = r + R * np.cos(a)
    rho_b = r + R * np.cos(b)
    X = np.cos(a / 2) if r >= R else np.sqrt(rho_a / (2 * R))
    x = sense * X * np.tanh(u / X)
    gap = 2 * X / (1 + np.exp(2 * np.minimum(np.abs(u) / X, 300 if r > R else 30)))  # X - |x|
    e = gap * (2 * X - gap)  # X^2 - x^2
    d = np.sin((a + b) / 2) * np.sin((a - b) / 2)
    W = np.sqrt(np.maximum(d + x * x, 0))
    k2 = sa * sa + x * x
    c = max(r - R, 0) + 2 * R * e
    rest = e + (0 if r >= R else np.cos(a / 2) ** 2 - X * X)  # 1 - k^2
    dx = sense * e / X**2
    dk2 = 2 * x * dx
    first = np.arctan2(-x, sa)
    last = np.arctan2(W, sb)
    with np.errstate(divide="ignore", invalid="ignore"):
        dfirst = -sa * dx / k2
        dlast = sb * x * dx / (W * k2)
    # Three legs, none with more than one turning point, where the integrands have their peaks:
    # down to the outer equator, on to its next crossing or to b, and up from there.
    over = b > 0
    constants = _rows(c, rest, k2, 0)
    rates = _rows(-2 * R * dk2, -dk2, dk2, 0)
    cos_a = x * np.sqrt(2 * R * (rho_a + c)) / rho_a
    cos_b = W * np.sqrt(2 * R * (rho_b + c)) / rho_b
    way = None
    for start, speed in (
        (np.where(over, last, np.pi / 2), np.where(over, dlast, 0)),
        (np.where(over, -np.pi / 2, last - np.pi), np.where(over, 0, dlast)),
        (first, dfirst),
    ):
        at = np.stack([*constants, start, np.pi / 2 - start])
        way = Integrand(at, np.stack([*rates, speed, 0 * speed]), cos_a, cos_b, way)
    return way


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
    integrand : Integrand
        That of each u.

    Notes
    -----
    They have no turning point: t = (phi - pi)/2. c = (r - R) tanh(u) grows to that of the inner
    equator, on which they turn the farther the nearer they come, again as a logarithm.
    """
    r, R = torus.r, torus.R
    slow = 1 / (1 + np.exp(2 * np.minimum(u, 300)))  # the bound: exp(710) is no float
    c = (r - R) * np.tanh(u)
    kappa2 = (r - R) / R * slow  # (r - R - c) / 2R, whose difference would cancel
    rho_a = r + R * np.cos(a)
    rho_b = r + R * np.cos(b)
    start = _below_pi(a) / 2
    stop = _below_pi(-b) / 2
    dc = 4 * (r - R) * slow * (1 - slow)
    dkappa2 = -2 * kappa2 * (1 - slow)
    # sqrt(rho^2 - c^2) / rho, with rho - c = 2R (kappa^2 + sin^2(t)).
    cosines = [
        np.sqrt(2 * R * (kappa2 + np.sin(t) ** 2) * (rho + c)) / rho
        for t, rho in ((start, rho_a), (stop, rho_b))
    ]
    at = _rows(c, kappa2, 1, kappa2, -start, start + stop)
    return Integrand(at, _rows(dc, dkappa2, 0, dkappa2, 0, 0), *cosines)


def _below_pi(phi):
    """Return how far angles phi are below pi, to the last digit: np.pi is 1.2e-16 too small."""
    return (np.pi - phi) + 1.2246467991473532e-16


def _rows(*values):
    return np.stack(np.broadcast_arrays(*values))
