"""The classes of geodesics on a torus, each with its one unknown.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. Clairaut's c = rho sin(azimuth) is constant
along it, so that with rho = r + R cos(phi)

    d(theta) / d(phi) = R c / (rho sqrt(rho^2 - c^2)),   d(s) / d(phi) = R rho / sqrt(rho^2 - c^2).

The root vanishes at a turning point, where rho = c, and a quadrature in phi would fail there. In
both classes sin(phi/2) or cos(phi/2) is a multiple of cos(t), by which it goes: with
D = A + B sin^2(t) and rho = c + 2R (E + B sin^2(t)),

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.

No angle is needed: sines and cosines of t follow from those of a/2 and b/2 by roots and quotients.
All is element by element, for floats, arrays or compiled loops. A `torus` is whatever has r and R.
"""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, smaller, some, square_root, where
from ..kernels.repeatable import growth, sine_cosine

STEEP = 0.9  # of the way to the meridian: from there on `outer` counts what is left of it
STEEPEST = 70.0  # of that way: what is left there is 1e-301 of it
NARROW = 0.32  # of R: what is nearer to the axis there than that needs a leg of its own
CLOSE = 1e-5  # rad


class Ends(NamedTuple):
    """What the ends are to their geodesics.

    Parameters
    ----------
    sine_a, cosine_a, sine_b, cosine_b, sine, cosine : (...) float
        Of a/2, of b/2 and of their difference.
    apart : (...) float
        sin^2(a/2) - sin^2(b/2).
    rho_a, rho_b : (...) float
        Distances from the torus' axis, in m.
    """

    sine_a: np.ndarray
    cosine_a: np.ndarray
    sine_b: np.ndarray
    cosine_b: np.ndarray
    sine: np.ndarray
    cosine: np.ndarray
    apart: np.ndarray
    rho_a: np.ndarray
    rho_b: np.ndarray


class Integrand(NamedTuple):
    """What one value of the unknown stands for: both integrals' constants and limits.

    Parameters
    ----------
    c, A, B, E : (...) float
        The constants of both integrals.
    sine, cosine : (...) float
        Of the lower limit of t, which is from -pi/2 to pi/2.
    across, along : (...) float
        Sine and cosine of how far the upper limit is from the lower.
    sine_b, cosine_b : (...) float
        Of the upper limit, which is below pi.
    dc, dA, dB, dE, dfirst, dlast : (...) float
        What the constants and both limits change by with the unknown.
    cos_a, cos_b : (...) float
        Cosines of the azimuths.
    """

    c: np.ndarray
    A: np.ndarray
    B: np.ndarray
    E: np.ndarray
    sine: np.ndarray
    cosine: np.ndarray
    across: np.ndarray
    along: np.ndarray
    sine_b: np.ndarray
    cosine_b: np.ndarray
    dc: np.ndarray
    dA: np.ndarray
    dB: np.ndarray
    dE: np.ndarray
    dfirst: np.ndarray
    dlast: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


def ends_of(torus, a, b):
    """Return the `Ends` of geodesics from phi = a to phi = b, in rad."""
    sine_a, cosine_a = sine_cosine(a / 2)
    sine_b, cosine_b = sine_cosine(b / 2)
    sine, cosine = sine_cosine((a - b) / 2)
    middle, _ = sine_cosine((a + b) / 2)
    rho_a = distance(torus, a, cosine_a)
    rho_b = distance(torus, b, cosine_b)
    # A product has the difference of the squares to its last digits, near ends or not.
    apart = middle * sine
    return Ends(sine_a, cosine_a, sine_b, cosine_b, sine, cosine, apart, rho_a, rho_b)


def distance(torus, phi, cosine):
    """Return rho at phi, in rad, from -pi to pi, the cosine of whose half is given."""
    _, level = sine_cosine(phi)
    # Where r and R cos(phi) nearly cancel on a horn, r - R and R (1 + cos(phi)) keep the digits.
    inside = torus.r - torus.R + 2 * torus.R * (cosine * cosine)
    return where(level < -0.5, inside, torus.r + torus.R * level)


def wide(torus):
    """Return whether `outer` counts by a logarithm what is left of the way to the meridian."""
    return torus.r > 0.9 * torus.R


def steepest(torus, ends):
    """Return the unknown of `outer` that stands for the meridian."""
    return -where(wide(torus), STEEPEST, 1.0) * square_root(ends.rho_a / (2 * torus.R))


def room(torus, ends):
    """Return what the unknowns of `outer` and `second` are measured by: where x ends."""
    # On a ring the geodesic of x = X winds towards the inner equator (k = 1, c = r - R), on a
    # spindle it is the meridian, through the node (c = 0).
    return ends.cosine_a if torus.r >= torus.R else square_root(ends.rho_a / (2 * torus.R))


def outer(torus, ends, u):
    """Return the geodesics that descend to b, at once (u < 0) or after rising above a (u > 0).

    Parameters
    ----------
    torus : Torus
        The surface.
    ends : Ends
        The ends.
    u : (...) float
        The unknown, from `steepest`, the meridian, upwards.

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
    R = torus.R
    sa = ends.sine_a
    sb = ends.sine_b
    X = room(torus, ends)
    # On a ring the turned angle grows without limit towards X, as a logarithm, and on a spindle
    # the way turns ever more sharply by the node: x = X tanh(u / X) spreads that out. Below zero
    # there is no such end, and x = u joins without a bend.
    rising = u > 0
    farthest = _farthest(torus)
    grown = growth(where(rising, smaller(2 * u / X, farthest), 0.0))
    x = where(rising, X * (grown / (2 + grown)), u)
    # X - x without cancellation where u is great.
    gap = where(rising, 2 * X / (2 + grown), X - u)
    e = gap * (X + x)  # X^2 - x^2
    dx = where(rising, e / (X * X), 1.0)
    if torus.r <= R:  # there the class ends by the node, and nothing turns farther
        dx = where(2 * u / X > farthest, 0.0, dx)
    c, rest, k2, k, W = _swing(torus, ends, x, e)
    # The meridian, c = 0, is at x = -L. On a ring c would be a difference, which cancels there,
    # and by the node of a horn the least c turns far: u counts x + L by its logarithm.
    L = square_root(ends.rho_a / (2 * R))
    steep = wide(torus) & (u < -STEEP * L)
    if some(steep):
        unit = (1 - STEEP) * L
        left = unit / (1 + growth(where(steep, (-STEEP * L - u) / unit, 0.0)))
        x = where(steep, left - L, x)
        dx = where(steep, left / unit, dx)
        c = where(steep, 2 * R * (left * (2 * L - left)), c)
        rest = where(steep, (c - (torus.r - R)) / (2 * R), rest)
        W = where(steep, square_root(larger(ends.apart + x * x, 0.0)), W)
        k2 = where(steep, sa * sa + x * x, k2)
        k = square_root(k2)
    # The sine of the span times k^2 is W sa + x sb. Where x sb < 0 that is a difference; its
    # product with the sum, W^2 sa^2 - x^2 sb^2, is apart k^2.
    sum_ = W * sa - x * sb
    small = ends.apart * k2 / where(sum_ > 0, sum_, 1.0)
    across = where(x * sb < 0, small, W * sa + x * sb) / k2
    along = (sa * sb - W * x) / k2
    dk2 = 2 * x * dx
    dfirst = -sa * dx / k2
    dlast = ratio(sb * x * dx, W * k2)
    # k > 1, c < r - R: prolonged, it would cross the inner equator, without a turning point. D
    # would vanish there in that form; t = (pi - phi)/2, cos(phi/2) = sin(t), has no such place.
    free = rest < 0
    return Integrand(
        c,
        abs(rest),
        where(free, 1.0, k2),
        where(free, -rest, 0.0),
        where(free, ends.cosine_a, -x / k),
        where(free, sa, sa / k),
        where(free, ends.sine, across),
        where(free, ends.cosine, along),
        where(free, ends.cosine_b, W / k),
        where(free, sb, sb / k),
        -2 * R * dk2,
        where(free, dk2, -dk2),
        where(free, 0.0, dk2),
        where(free, dk2, 0.0),
        where(free, 0.0, dfirst),
        where(free, 0.0, dlast),
        x * square_root(2 * R * (ends.rho_a + c)) / ends.rho_a,
        -W * square_root(2 * R * (ends.rho_b + c)) / ends.rho_b,
    )


def peaked(torus, ends, b, angle):
    """Return where a way of `outer` may need three legs, lest its quadrature miss a peak.

    `torus`, `ends` and b are those of `outer`. A way needs them where it nears a node, or an inner
    equator, at its end at b, too, or passes by a node so closely as only ways do that turn by an
    `angle` next to what half a swing turns there.
    """
    near = smaller(ends.rho_b, 2 * torus.R * (ends.cosine_b * ends.cosine_b))
    low = (b < 0) & (near < NARROW * torus.R)
    return low | (half_swing_by_the_node(torus) - angle < CLOSE)


def half_swing_by_the_node(torus):
    """Return the turned angle of half a swing that just misses the node, in rad."""
    if torus.r >= torus.R:
        return math.inf
    return math.pi / math.sqrt((1 - torus.r / torus.R) * (1 + torus.r / torus.R))


def in_legs(way):
    """Return a way of `outer` in three legs, that begin or end where the integrands have peaks.

    To the turning point, t = 0; on to the outer equator, t = pi/2; and to the end, from where it
    is mirrored, for the integrands repeat backwards. What a way doesn't have is of no length.
    """
    rising = way.sine < 0
    below = way.cosine_b < 0
    sine = larger(way.sine, 0.0)
    cosine = where(rising, 1.0, way.cosine)
    across = where(rising, way.sine_b, way.across)
    along = where(rising, way.cosine_b, way.along)
    up = sine, cosine, where(rising, -way.sine, 0.0), where(rising, way.cosine, 1.0)
    down = sine, cosine, where(below, cosine, across), where(below, sine, along)
    last = (
        where(below, way.sine_b, 1.0),
        where(below, -way.cosine_b, 0.0),
        where(below, -way.cosine_b, 0.0),
        where(below, way.sine_b, 1.0),
    )
    return (
        _leg(way, up, 0.0, -way.dfirst),
        _leg(way, down, 0.0, where(below, 0.0, way.dlast)),
        _leg(way, last, where(below, -way.dlast, 0.0), 0.0),
    )


def _leg(way, limits, dfirst, dlast):
    """Return a part of a way between other limits."""
    sine, cosine, across, along = limits
    return Integrand(
        way.c,
        way.A,
        way.B,
        way.E,
        sine,
        cosine,
        across,
        along,
        sine,  # not used of a leg
        cosine,
        way.dc,
        way.dA,
        way.dB,
        way.dE,
        dfirst,
        dlast,
        way.cos_a,
        way.cos_b,
    )


def second(torus, ends, u, sense=1):
    """Return the geodesics that turn on the other side of the outer equator and rise to b.

    They come to the parallel b a second time, after descending at once (u < 0) or after rising
    above a (u > 0).

    Parameters
    ----------
    torus : Torus
        The surface.
    ends : Ends
        The ends.
    u : (n,) float
        The unknown, any number: far from zero, c nears 0, or r - R on a ring.
    sense : {1, -1}
        -1 if it is the negative of the unknown that is given.

    Returns
    -------
    legs : list of Integrand
        That of each u, in three legs, none with more than one turning point, where the integrands
        have their peaks.

    Notes
    -----
    As `outer`, but for the end: t passes pi, where phi is least, and stops at 2 pi - t_b, with
    sin(b/2) = k cos(t_b). The integrands repeat after pi, and backwards from any multiple of pi/2:
    each leg is mirrored to where t is in [-pi/2, pi/2], and ends at pi/2.
    """
    R = torus.R
    sa = ends.sine_a
    sb = ends.sine_b
    X = room(torus, ends)
    grown = growth(smaller(2 * abs(u) / X, _farthest(torus)))
    x = sense * np.copysign(X * (grown / (2 + grown)), u)
    gap = 2 * X / (2 + grown)  # X - |x|
    e = gap * (2 * X - gap)  # X^2 - x^2
    c, rest, k2, k, W = _swing(torus, ends, x, e)
    dx = sense * e / (X * X)
    dk2 = 2 * x * dx
    dfirst = -sa * dx / k2
    dlast = ratio(sb * x * dx, W * k2)
    cos_a = x * square_root(2 * R * (ends.rho_a + c)) / ends.rho_a
    cos_b = W * square_root(2 * R * (ends.rho_b + c)) / ends.rho_b
    # Down to the outer equator, on to its next crossing or to b, and up from there.
    over = sb > 0
    legs = []
    for sine, cosine, speed in (
        (-x / k, sa / k, dfirst),
        (where(over, -1.0, -W / k), where(over, 0.0, -sb / k), where(over, 0.0, dlast)),
        (where(over, W / k, 1.0), where(over, sb / k, 0.0), where(over, dlast, 0.0)),
    ):
        limits = sine, cosine, cosine, sine, 1.0, 0.0  # what is missing to a right angle
        rates = -2 * R * dk2, -dk2, dk2, 0.0, speed, 0.0
        legs.append(Integrand(c, rest, k2, 0.0, *limits, *rates, cos_a, cos_b))
    return legs


def inner(torus, ends, u):
    """Return the geodesics that rise from a over phi = pi to b + 2 pi, on a ring torus.

    Parameters
    ----------
    torus : Torus
        The surface, a ring.
    ends : Ends
        The ends.
    u : (...) float
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
    R = torus.R
    narrow = torus.r - R
    grown = growth(smaller(2 * u, 600.0))
    slow = 1 / (2 + grown)  # half of 1 - tanh(u)
    c = narrow * (grown * slow)
    kappa2 = narrow / R * slow  # (r - R - c) / 2R, whose difference would cancel
    dc = 4 * narrow * slow * (1 - slow)
    dkappa2 = -2 * kappa2 * (1 - slow)
    sa = ends.sine_a
    sb = ends.sine_b
    ca = ends.cosine_a
    cb = ends.cosine_b
    # sqrt(rho^2 - c^2) / rho, with rho - c = 2R (kappa^2 + sin^2(t)).
    cos_a = square_root(2 * R * (kappa2 + ca * ca) * (ends.rho_a + c)) / ends.rho_a
    cos_b = square_root(2 * R * (kappa2 + cb * cb) * (ends.rho_b + c)) / ends.rho_b
    limits = -ca, sa, sa * cb - ca * sb, -ends.cosine, cb, -sb
    rates = dc, dkappa2, 0.0, dkappa2, 0.0, 0.0
    return Integrand(c, kappa2, 1.0, kappa2, *limits, *rates, cos_a, cos_b)


def _farthest(torus):
    """Return the greatest u / X, twice."""
    # There the geodesic runs into the node, with a turn too sharp for the quadrature if it were
    # followed farther, or turns many times.
    return 600.0 if torus.r > torus.R else 60.0


def _swing(torus, ends, x, e):
    """Return c, 1 - k^2, k^2, k, and W of `outer` from x and X^2 - x^2."""
    r, R = torus.r, torus.R
    W = square_root(larger(ends.apart + x * x, 0.0))
    k2 = ends.sine_a * ends.sine_a + x * x
    c = 2 * R * e + (r - R if r > R else 0.0)
    rest = e + (0.0 if r >= R else (R - r) / (2 * R))
    return c, rest, k2, square_root(k2), W
