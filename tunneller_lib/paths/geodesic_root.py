"""The classes of geodesics on a torus: how far each turns, and the member that turns by an angle.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. Clairaut's c = rho sin(azimuth) is constant
along it, so that with rho = r + R cos(phi)

    d(theta) / d(phi) = R c / (rho sqrt(rho^2 - c^2)),   d(s) / d(phi) = R rho / sqrt(rho^2 - c^2).

The geodesics between these ends that have the same number of turning points, or none, make a class
with one unknown u, which stands for c. `find_root` seeks the u for which the turned angle,
the integral of d(theta), is the given one.

At a turning point rho = c, the root under the fraction vanishes, and a quadrature in phi fails. So
another variable t takes the place of phi: sin(phi/2) = k cos(t). A geodesic with turning points has
k^2 = (r + R - c) / 2R, and t = 0 where phi is greatest; on one without them k = 1. In t the
integrands stay finite. With rho = c + 2R (E + B sin^2(t)) and D = A + B sin^2(t), where A, B and E
are constants and D is cos^2(phi/2) if there are turning points, else (rho - c) / 2R,

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.

The limits of t are never computed as angles: their sines and cosines follow from those of a/2 and
b/2 by roots and quotients.

The functions take plain numbers, one geodesic at a time. They run as they stand or compiled, with
the same bits (`kernels.compiled`). A `torus` is anything that has r and R.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, smaller, square_root
from ..kernels.repeatable import area_sine, growth, sine_cosine
from .quadrature import gauss_rule

# The classes: `outer`, `inner`, and the two branches of `second`, on either side of the unknown for
# which it turns least.
OUTSIDE, INSIDE, PAST, BEFORE = range(4)

STEEP = 0.9  # of the way to the meridian: beyond, the unknown of `outer` is a logarithm
STEEPEST = 70.0  # of that way, in that logarithm: there only 1e-301 of the way is left
NARROW = 0.03  # of the larger radius: an end as near to a node, or the inner equator, needs a leg
CLOSE = 1e-5  # rad, short of what half a swing by a node turns: such ways need legs, too

# Pairs of nodes of the quadrature, by how many fifths y grows along a way (`_stretched`): on all
# tori so many that more change roundings alone, found by trial. They grow about as exp(0.8 y).
PAIRS = 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20, 24, 28
FIFTHS = len(PAIRS)
MOST_PAIRS, MOST_ON_RING = 48, 32

ROUNDS = 200  # Newton's method takes about four; halving takes sixty, and more for roots of 1e-30
NEAR = 1e-5  # rad, by which the turned angle may be off where the last step begins
AGREES = 1e-9  # rad, by which the turned angle of an answer may be off where that step ends
STEP = 1e-8  # relative: Newton's last step leaves an error of the order of its square
ROUNDING = 1e-7  # the least scale of an unknown: STEP times this, 1e-15, is a rounding


class Radii(NamedTuple):
    """r and R of a torus as plain numbers, in any unit."""

    r: float
    R: float


class Ends(NamedTuple):
    """What the classes need to know of the two ends of a geodesic.

    Parameters
    ----------
    sine_a, cosine_a, sine_b, cosine_b, sine, cosine : float
        Of a/2, of b/2 and of half their difference.
    apart : float
        sin^2(a/2) - sin^2(b/2).
    rho_a, rho_b : float
        Distances from the torus' axis, in m.
    meridian, room : float
        The limits of the unknown x of `outer`: -`meridian` stands for the meridian, `room` for the
        way that winds towards the inner equator of a ring or runs into a node.
    """

    sine_a: float
    cosine_a: float
    sine_b: float
    cosine_b: float
    sine: float
    cosine: float
    apart: float
    rho_a: float
    rho_b: float
    meridian: float
    room: float


class Integrand(NamedTuple):
    """The constants and the limits of both integrals for one value of the unknown.

    Parameters
    ----------
    c : float
        Clairaut's constant, in m.
    shape : (A, B, E)
        The other constants, as in the module's text.
    rates : (dc, dA, dB, dE)
        The derivatives of all four by the unknown.
    first : (sine, cosine)
        Of the lower limit of t, which is from -pi/2 to pi/2.
    span : (sine, cosine)
        Of the upper limit less the lower one.
    last : (sine, cosine)
        Of the upper limit, which is below pi.
    motion : (dfirst, dlast)
        The derivatives of both limits by the unknown.
    cosines : (cos_a, cos_b)
        Of the azimuths at both ends.
    """

    c: float
    shape: tuple
    rates: tuple
    first: tuple
    span: tuple
    last: tuple
    motion: tuple
    cosines: tuple


def ends_at(torus, a, b):
    """Return the `Ends` on a torus of geodesics from phi = a to b, in rad."""
    sine_a, cosine_a = sine_cosine(a / 2)
    sine_b, cosine_b = sine_cosine(b / 2)
    sine, cosine = sine_cosine((a - b) / 2)
    middle, _ = sine_cosine((a + b) / 2)
    # As this product, sin^2(a/2) - sin^2(b/2) keeps its digits however near the ends are.
    apart = middle * sine
    rho_a, rho_b = distance(torus, a, cosine_a), distance(torus, b, cosine_b)
    meridian = square_root(larger(rho_a, 0.0) / (2 * torus.R))
    # At x = X, on a ring, the geodesic winds towards the inner equator (k = 1, c = r - R); on a
    # spindle it is the meridian, through the node (c = 0).
    room = cosine_a if torus.r >= torus.R else meridian
    return Ends(
        sine_a, cosine_a, sine_b, cosine_b, sine, cosine, apart, rho_a, rho_b, meridian, room
    )


def distance(torus, phi, cosine):
    """Return the distance rho from the axis at phi, in rad, from -pi to pi.

    `cosine` is that of phi / 2.
    """
    _, level = sine_cosine(phi)
    # Near phi = pi the sum of r and R cos(phi) cancels where r is about R: r - R and
    # R (1 + cos(phi)) = 2 R cos^2(phi/2) keep the digits.
    if level < -0.5:
        # The node of a horn isn't on its sheet. There math.pi falls short of pi by what would
        # leave 1e-32 R.
        node = torus.r == torus.R and abs(phi) == math.pi
        return 0.0 if node else torus.r - torus.R + 2 * torus.R * (cosine * cosine)
    return torus.r + torus.R * level


# ---- classes -----------------------------------------------------------------


def outer(torus, ends, u):
    """Return the `Integrand` of the geodesic that descends to b, at once or after rising above a.

    Parameters
    ----------
    torus : Torus
        The surface.
    ends : Ends
        The ends.
    u : float
        The unknown. It is below zero for ways that descend at once, and least for the meridian, at
        -`ends.meridian`, or at `STEEPEST` times that on a `wide` torus.

    Notes
    -----
    sin(phi/2) = k cos(t), with t = 0 at the turning point. Let x = -k sin(t) at a, which is
    negative where the turning point lies behind a, and W = k sin(t) at b. Then
    k^2 = sin^2(a/2) + x^2, rho_a - c = 2R x^2 and rho_b - c = 2R W^2. So everything follows from x,
    and nothing cancels where x is small.

    The class ends at x = -L, the meridian, and at x = X: L is `ends.meridian`, X is `ends.room`. It
    has three parts, in which u gives x by

    - x = X tanh(u/X) for u > 0, which nears X but doesn't reach it,
    - x = u for u <= 0,
    - x = -L + w exp((u + STEEP L) / w), w = (1 - STEEP) L, for u < -STEEP L on a `wide` torus.
    """
    r, R = torus.r, torus.R
    L, X = ends.meridian, ends.room
    if wide(torus) and u < -STEEP * L:
        # The meridian, c = 0, is at x = -L. On a ring c as a difference would cancel there, and by
        # the node of a horn the smallest c still turns far: so x + L, by its logarithm, is counted.
        unit = (1 - STEEP) * L
        left = unit / (1 + growth((-STEEP * L - u) / unit))
        x, dx = left - L, left / unit
        c = 2 * R * (left * (2 * L - left))
        rest = (c - (r - R)) / (2 * R)
    else:
        # At u = 0 both parts meet with the same slope, dx = 1.
        x, dx, e = u, 1.0, (X - u) * (X + u)
        if u > 0:
            x, dx, e = _spread(torus, X, u)
            # From here on `_spread` lets x grow no more, so that its derivative is zero.
            if r <= R and u > 30 * X:
                dx = 0.0
        c, rest = _swing(torus, e)
    if rest >= 0:
        return _turning(torus, ends, x, dx, c, rest, -1.0)
    # Here c < r - R, and k^2 of `_turning` would be above 1: prolonged, the way crosses the inner
    # equator of a ring without a turning point. There cos^2(phi/2), the D of `_turning`, vanishes.
    # With k = 1, which is t = (pi - phi)/2, D = kappa^2 + sin^2(t) vanishes nowhere, where
    # kappa^2 = (r - R - c) / 2R is -`rest`.
    dk2 = 2 * x * dx
    rates = -2 * R * dk2, dk2, 0.0, dk2
    first, last = (ends.cosine_a, ends.sine_a), (ends.cosine_b, ends.sine_b)
    span = ends.sine, ends.cosine
    W = square_root(larger(ends.apart + x * x, 0.0))
    cosines = _cosines(torus, ends, c, x, -W)
    return Integrand(c, (-rest, 1.0, -rest), rates, first, span, last, (0.0, 0.0), cosines)


def second(torus, ends, u, sense):
    """Return the `Integrand` of the geodesic that turns beyond the outer equator and rises to b.

    It comes to the parallel b a second time, after descending at once or after rising above a: t
    passes pi, where phi is least, and stops at 2 pi - t_b, with sin(b/2) = k cos(t_b). Its way
    needs `legs_of_second`.

    Parameters
    ----------
    torus : Torus
        The surface.
    ends : Ends
        The ends.
    u : float
        The unknown, of either sign: far from zero, c nears 0, or r - R on a ring.
    sense : {1.0, -1.0}
        -1 if u is the negative of the unknown.
    """
    x, dx, e = _spread(torus, ends.room, abs(u))
    c, rest = _swing(torus, e)
    return _turning(torus, ends, sense * math.copysign(x, u), sense * dx, c, rest, 1.0)


def _turning(torus, ends, x, dx, c, rest, rising):
    """Return the `Integrand` of a geodesic that swings between turning points.

    It has the `x` of `outer`, whose derivative by the unknown is `dx`, Clairaut's constant `c`, and
    `rest` = 1 - k^2. `rising` is 1 if it comes to b from below, as in `second`, and else -1.
    """
    sa, sb = ends.sine_a, ends.sine_b
    k2 = sa * sa + x * x
    W = square_root(larger(ends.apart + x * x, 0.0))
    k = square_root(k2)
    # By the sine of a sum, that of the span times k^2 is W sa + x sb. Where x sb < 0 this is a
    # difference, and cancels on a short way. Times W sa - x sb, a sum there, it is
    # W^2 sa^2 - x^2 sb^2 = apart k^2, which keeps the digits.
    lower, upper = x * sb, W * sa
    across = ends.apart * k2 / (upper - lower) if lower < 0 else upper + lower
    span = across / k2, (sa * sb - W * x) / k2
    first, last = (-x / k, sa / k), (W / k, sb / k)
    dk2 = 2 * x * dx
    rates = -2 * torus.R * dk2, -dk2, dk2, 0.0
    motion = -sa * dx / k2, ratio(sb * x * dx, W * k2)
    cosines = _cosines(torus, ends, c, x, rising * W)
    return Integrand(c, (rest, k2, 0.0), rates, first, span, last, motion, cosines)


def _cosines(torus, ends, c, x, W):
    """Return the cosines of the azimuths at both ends; `x` and `W` of `outer` give their signs."""
    # sqrt(rho^2 - c^2) / rho, where rho - c is 2R x^2 at a and 2R W^2 at b: a difference would
    # cancel near a turning point.
    cos_a = x * square_root(2 * torus.R * (ends.rho_a + c)) / ends.rho_a
    return cos_a, W * square_root(2 * torus.R * (ends.rho_b + c)) / ends.rho_b


def inner(torus, ends, u):
    """Return the `Integrand` of the geodesic that rises from a over phi = pi to b + 2 pi.

    Parameters
    ----------
    torus : Torus
        The surface, a ring.
    ends : Ends
        The ends.
    u : float
        The unknown, from 0, the meridian, upwards.

    Notes
    -----
    It has no turning point: t = (phi - pi)/2. c = (r - R) tanh(u) grows towards that of the inner
    equator; the turned angle grows without limit there, about in proportion to u.
    """
    R = torus.R
    narrow = torus.r - R
    grown = growth(smaller(2 * u, 600.0))
    slow = 1 / (2 + grown)  # half of 1 - tanh(u)
    c = narrow * (grown * slow)
    kappa2 = narrow / R * slow  # (r - R - c) / 2R, whose difference would cancel
    dc = 4 * narrow * slow * (1 - slow)
    dkappa2 = -2 * kappa2 * (1 - slow)
    sa, ca, sb, cb = ends.sine_a, ends.cosine_a, ends.sine_b, ends.cosine_b
    # sqrt(rho^2 - c^2) / rho, where rho - c = 2R (kappa^2 + sin^2(t)) is no difference.
    cos_a = square_root(2 * R * (kappa2 + ca * ca) * (ends.rho_a + c)) / ends.rho_a
    cos_b = square_root(2 * R * (kappa2 + cb * cb) * (ends.rho_b + c)) / ends.rho_b
    shape = kappa2, 1.0, kappa2
    rates = dc, dkappa2, 0.0, dkappa2
    span = sa * cb - ca * sb, -ends.cosine
    return Integrand(c, shape, rates, (-ca, sa), span, (cb, -sb), (0.0, 0.0), (cos_a, cos_b))


def wide(torus):
    """Return whether the unknown of `outer` is a logarithm near the meridian, on a wide torus."""
    return torus.r > 0.9 * torus.R


def _spread(torus, X, u):
    """Return x = X tanh(u / X), its derivative and X^2 - x^2, for u from 0 upwards.

    Towards X the turned angle grows without limit on a ring, as a logarithm of X - x, and on a
    spindle the way turns ever more sharply by the node. Against u both grow evenly.
    """
    # Beyond this the turn by a node is too sharp for the quadrature, and a ring's way turns some
    # hundred times.
    farthest = 600.0 if torus.r > torus.R else 60.0
    grown = growth(smaller(2 * u / X, farthest))
    x = X * (grown / (2 + grown))
    gap = 2 * X / (2 + grown)  # X - x, which as a difference would cancel where u is great
    e = gap * (X + x)
    return x, e / (X * X), e


def _swing(torus, e):
    """Return c and 1 - k^2 by e = X^2 - x^2, as sums of terms that aren't negative."""
    r, R = torus.r, torus.R
    return 2 * R * e + larger(r - R, 0.0), e + larger(R - r, 0.0) / (2 * R)


def peaked(torus, ends, b, angle):
    """Return whether a way of `outer` may need three legs, lest its quadrature miss a peak.

    One quadrature sees one peak, about t = 0. A second one is at the end b where a way has come
    round the outside and nears a node, or the inner equator, there. And the peak itself is too
    narrow where a way passes by a node as closely as only those do that turn by an `angle` next to
    that of half a swing there. The torus, its ends and b are those of `outer`; a way of `inner`,
    which goes round the other way, has a second peak where -b is such an end.
    """
    near = smaller(ends.rho_b, 2 * torus.R * (ends.cosine_b * ends.cosine_b))
    if b < 0 and near < NARROW * larger(torus.r, torus.R):
        return True
    return half_swing_by_the_node(torus) - angle < CLOSE


def half_swing_by_the_node(torus):
    """Return the turned angle, in rad, of half a swing that just misses a spindle's node.

    It is infinite on other tori.
    """
    if torus.r >= torus.R:
        return math.inf
    return math.pi / math.sqrt((1 - torus.r / torus.R) * (1 + torus.r / torus.R))


def in_legs(way):
    """Return a way of `outer` in three legs, which begin or end where the integrands have peaks.

    The peaks are at t = 0, the turning point, and at t = pi, the one on the other side. The first
    leg goes back from t = 0 to the start, where the way begins before it; the second goes on from
    t = 0, or from the start, to the end or to the outer equator, t = pi/2; the third goes on from
    there. It is mirrored in t = pi/2, since the integrands depend on sin^2(t) alone, and so begins
    near t = 0. A leg that a way doesn't have is of no length.
    """
    (sine, cosine), (sine_b, cosine_b) = way.first, way.last
    dfirst, dlast = way.motion
    begin, up = (larger(sine, 0.0), cosine), (0.0, 1.0)
    across, along = way.span
    if sine < 0:
        begin, up = (begin[0], 1.0), (-sine, cosine)
        across, along = sine_b, cosine_b
    down, mirrored = (across, along), (1.0, 0.0)
    ddown, dmirrored = dlast, 0.0
    if cosine_b < 0:
        down, mirrored = (begin[1], begin[0]), (sine_b, -cosine_b)
        ddown, dmirrored = 0.0, -dlast
    return (
        _leg(way, begin, up, (0.0, -dfirst)),
        _leg(way, begin, down, (0.0, ddown)),
        _leg(way, mirrored, (mirrored[1], mirrored[0]), (dmirrored, 0.0)),
    )


def legs_of_second(way):
    """Return a way of `second` in three legs, none of which passes two turning points.

    They lead from the start to the outer equator, t = pi/2; on to its next crossing, t = 3 pi/2, or
    to b if b comes first; and from there to b. The integrands repeat after pi, and backwards from
    any multiple of pi/2: so each leg is moved or mirrored to one that begins in -pi/2 to pi/2 and
    ends at pi/2.
    """
    (sine, cosine), (sine_b, cosine_b) = way.first, way.last
    dfirst, dlast = way.motion
    on, up = (-sine_b, -cosine_b), (1.0, 0.0)
    don, dup = dlast, 0.0
    if cosine_b > 0:
        on, up = (-1.0, 0.0), (sine_b, cosine_b)
        don, dup = 0.0, dlast
    return (
        _leg(way, way.first, (cosine, sine), (dfirst, 0.0)),
        _leg(way, on, (on[1], on[0]), (don, 0.0)),
        _leg(way, up, (up[1], up[0]), (dup, 0.0)),
    )


def _leg(way, first, span, motion):
    """Return a part of a way, from other limits on; the span alone tells the upper one."""
    return Integrand(way.c, way.shape, way.rates, first, span, first, motion, way.cosines)


# ---- both integrals ------------------------------------------------------------


def integrate(torus, way, rules, rows):
    """Return the turned angle of a geodesic, its rate by the unknown, and the length.

    Parameters
    ----------
    torus : Radii
        The surface.
    way : Integrand
        Constants and limits.
    rules : tuple
        The `quadratures`.
    rows : (3, m) float
        Room for what the nodes add, m at least as many as there are pairs.

    Returns
    -------
    turned, rate, length : float
        In rad, rad and m.
    """
    stretched = _stretched(torus, way)
    fifths = 5 * stretched[3]
    # What isn't a number takes the last quadrature, too.
    which = int(fifths) if fifths < FIFTHS else FIFTHS
    places, count = rules[1][which]
    add_nodes(torus, way, stretched, rules[0][which], places, rows)
    turned, rate, length = 0.0, moving(torus, way), 0.0
    for k in range(count):
        turned = turned + rows[0][k]
        rate = rate + rows[1][k]
        length = length + rows[2][k]
    return turned, rate, length


def add_nodes(torus, way, stretched, nodes, places, rows):
    """Fill in what the nodes of a quadrature add to each integral, two nodes to a place.

    The quadrature runs over y, see `_stretched`. Each place of a row holds the sum of two nodes:
    one at a share of the width from the lower limit, the other as far from the upper limit. Both
    take one exponential: e^y is `first` times e^(width share) at one of them, and `last` divided by
    it at the other.

    Parameters
    ----------
    torus : Torus
        The surface.
    way : Integrand
        Constants and limits.
    stretched : tuple
        As `_stretched` returns it.
    nodes : (2, k) float
        Shares and weights.
    places : int
        How many of them are taken.
    rows : (3, k) float
        Filled with the parts of the turned angle, of its rate by the unknown, and of the length. It
        is the rate at fixed limits: `moving` returns what their motion adds.

    Notes
    -----
    Let f = c / rho sqrt(2R / ((rho + c) D)) be the integrand of the turned angle, and let primes
    mark derivatives by the unknown at fixed t. Then

        f' = (c' - c (rho' / rho + (rho' + c') / (2 (rho + c)) + D' / (2 D))) f / c.

    `density` is rho f / c dt times the weight, `by_rho` is 1 / rho, `under` is (rho + c) D.
    """
    c, (A, B, E), (dc, dA, dB, dE) = way.c, way.shape, way.rates
    first, last, half, width = stretched
    twice, half_c = 2 * torus.R, c / 2
    shares, weights = nodes[0], nodes[1]
    turned, rate, length = rows[0], rows[1], rows[2]
    for k in range(places):
        # v = tan(t/4) = a0 sinh(y), and dt = 4 a0 cosh(y) / (1 + v^2) dy.
        grown = 1 + growth(width * shares[k])
        shrunk = 1 / grown
        step = 4 * (weights[k] * (width * half))
        turned_by = rate_by = length_by = 0.0
        for above, below in (first * grown, shrunk / first), (last * shrunk, grown / last):
            v = half * (above - below)
            v2 = v * v
            flat = 1 / (1 + v2)
            sine = 4 * v * (1 - v2) * (flat * flat)
            sin2 = sine * sine
            swing, dswing = B * sin2, dB * sin2
            rho = c + twice * (E + swing)
            both = rho + c
            D = A + swing
            under = both * D
            # One division gives the quotients by rho, by rho + c and by D.
            over_all = 1 / (rho * under)
            by_rho = over_all * under
            density = square_root(twice * (over_all * rho)) * (step * (above + below) * flat)
            # Twice the derivative of log(rho sqrt((rho + c) D)), the sum in brackets in the Notes.
            drho = dc + twice * (dE + dswing)
            twice_rate = (
                2 * drho * by_rho
                + (drho + dc) * (over_all * (rho * D))
                + (dA + dswing) * (over_all * (rho * both))
            )
            turned_by = turned_by + c * by_rho * density
            rate_by = rate_by + (dc - half_c * twice_rate) * by_rho * density
            length_by = length_by + rho * density
        turned[k] = turned_by
        rate[k] = rate_by
        length[k] = length_by


def _stretched(torus, way):
    """Return e^y at both ends of a way, half of a0 and the width in y: tan(t/4) = a0 sinh(y).

    Near t = 0 the integrands have a peak, for D and rho are small there; continued to complex t
    they have singular points where D or rho is zero, at t = +-i h, and the smaller D and rho are at
    t = 0 the smaller is h. With a0 = tanh(h/4) the singular points are at y = +-i pi/2, so that the
    peak is about one unit of y wide, however narrow it is in t. With tan(t/4), unlike t itself,
    sin(t) needs no sine: it is 4 v (1 - v^2) / (1 + v^2)^2 at v = tan(t/4).
    """
    c, (A, B, E), (sine, cosine), (across, along) = way.c, way.shape, way.first, way.span
    # The tangents of a quarter of the lower limit, and of a quarter of the span.
    tangent = sine / (1 + cosine)
    tan_first = tangent / (1 + square_root(1 + tangent * tangent))
    # Of half of the span, the longer one of sine and cosine comes by a root of a sum, which doesn't
    # cancel, and the other one from it.
    long_side = square_root((1 + abs(along)) / 2)
    short_side = across / (2 * long_side)
    reach = short_side / (1 + long_side) if along > 0 else long_side / (1 + short_side)
    # By how much tan(t/4) grows: the tangent of the sum of both quarters less `tan_first`, written
    # without that difference. The denominator is never below 0.8, so that nothing cancels in it.
    rise = reach * (1 + tan_first * tan_first) / (1 - tan_first * reach)
    tan_last = tan_first + rise
    # sinh^2(h) of the nearer singular point: D or rho is zero where sin^2(t) = -sinh^2(h). From it
    # follow tanh(h/2) and then tanh(h/4), each by the formula for half of an argument.
    narrow = larger(smaller(A, E + c / (2 * torus.R)), 0.0) / B
    narrow = smaller(narrow, 1e100)
    tanh_half = square_root(narrow) / (1 + square_root(1 + narrow))
    peak = tanh_half / (1 + square_root((1 - tanh_half) * (1 + tanh_half)))
    a0 = larger(peak, 1e-30)  # which is divided by
    # sinh(y) at both limits. No way ends below t = 0: z is never negative, and z + root_z is a sum.
    x = tan_first / a0
    z = tan_last / a0
    root_x = square_root(1 + x * x)
    root_z = square_root(1 + z * z)
    # sinh of the difference of y at the ends is z root_x - x root_z. Past the turning point, x > 0,
    # it cancels, on a short way nearly all of it: there z^2 root_x^2 - x^2 root_z^2, which is
    # (z - x)(z + x), is divided by the sum.
    if x > 0:
        lead = x + root_x
        apart = rise / a0 * (x + z) / (z * root_x + x * root_z)
    else:
        lead = 1 / (root_x - x)
        apart = z * root_x - x * root_z
    return lead, z + root_z, a0 / 2, area_sine(apart)


def moving(torus, way):
    """Return what the motion of the limits adds to the rate of the turned angle.

    It is the integrand at each limit times the limit's own derivative by the unknown.
    """
    (sine, cosine), (across, along) = way.first, way.span
    upper = sine * along + cosine * across
    first = _density(torus, way, sine * sine)
    last = _density(torus, way, upper * upper)
    return way.motion[1] * last - way.motion[0] * first


def _density(torus, way, sin2):
    """Return the integrand of the turned angle at a given sin^2(t)."""
    c, (A, B, E) = way.c, way.shape
    rho = c + 2 * torus.R * (E + B * sin2)
    return c / rho * square_root(2 * torus.R / ((rho + c) * (A + B * sin2)))


# ---- the root ------------------------------------------------------------------


@cache
def rule(count):
    """Return shares of the way, and weights (count / 2,), of half of the nodes of `gauss_rule`.

    The other half has the same shares from the other end.
    """
    nodes, weights = gauss_rule(count)
    return (1 + nodes[: count // 2]) / 2, weights[: count // 2] / 2


@cache
def quadratures(ring, ready):
    """Return the quadratures of `integrate`: their nodes, and how many count.

    Parameters
    ----------
    ring : bool
        Whether the torus is one.
    ready : bool
        Whether loops are compiled. These take pairs of nodes eight at a time, some of no weight;
        plain Python takes lists, on which it is fastest.

    Returns
    -------
    nodes : (FIFTHS + 1, 2, MOST_PAIRS) float
        Shares and weights, as of `rule`.
    counts : (FIFTHS + 1, 2) int
        How many pairs a loop takes, and how many of these have a weight.
    """
    nodes = np.zeros((FIFTHS + 1, 2, MOST_PAIRS))
    counts = []
    for which, pairs in enumerate((*PAIRS, MOST_ON_RING if ring else MOST_PAIRS)):
        nodes[which, :, :pairs] = rule(2 * pairs)
        counts.append([pairs + -pairs % 8 if ready else pairs, pairs])
    return (nodes, np.array(counts)) if ready else (nodes.tolist(), counts)


def find_root(torus, ends, b, angle, begin, family, rules, rows):
    """Return the way of a class that turns by an angle, found by Newton's method in a bracket.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : Ends
        The ends.
    b, angle : float
        phi at the last end, and the turned angle, in rad.
    begin : (u, scale, low)
        The first unknown, the scale on which steps are judged, and the least unknown.
    family : int
        OUTSIDE, INSIDE, PAST or BEFORE.
    rules : tuple
        The `quadratures`.
    rows : (3, m) float
        Room for what nodes add, m at least as many as there are.

    Returns
    -------
    found : bool
        Whether there is such a way.
    length, c, cos_a, cos_b : float
        Length and Clairaut's constant, in m, and the cosines of both azimuths; else NaN.
    """
    # Over the inner equator a way comes to b from the other side.
    hard = family <= INSIDE and peaked(torus, ends, b if family == OUTSIDE else -b, angle)
    u, scale, low = begin
    high, before = math.inf, 0.0
    way = way_of(family, torus, ends, u)
    for _ in range(ROUNDS):
        turned, rate, length = integrate_way(torus, way, family, hard, rules, rows)
        miss = angle - turned
        # Along the class dlength = c dturned: so the error of u counts here by its square.
        total = length + way.c * miss
        low, high, before, step, u, done = newton(u, miss, rate, scale, low, high, before)
        way = way_of(family, torus, ends, u)  # after the last step, for c and the azimuths alone
        if done:
            # What the last step leaves: much, where the class ends before it turns so far. A rate
            # that isn't finite comes with a step of zero.
            miss -= rate * step if step != 0 else 0.0
            break
    else:
        # On what is nearly a sphere all ways of a class may turn by the same to the last digit.
        # Then Newton's steps never become small, and any u will do.
        miss *= larger(torus.r / torus.R, 1.0)
    if abs(miss) <= AGREES:
        return True, total, way.c, way.cosines[0], way.cosines[1]
    return False, math.nan, math.nan, math.nan, math.nan


def way_of(family, torus, ends, u):
    """Return the `Integrand` of a class, `family`, at u; torus, ends and u are as of `outer`."""
    if family == OUTSIDE:
        return outer(torus, ends, u)
    if family == INSIDE:
        return inner(torus, ends, u)
    return second(torus, ends, u, 1.0 if family == PAST else -1.0)


def integrate_way(torus, way, family, hard, rules, rows):
    """Return what `integrate` does for a way of a class, in legs where one quadrature won't do.

    The class is `family`; `hard` says that a way of `outer` needs legs, as those of `second` always
    do. The other arguments, torus, rules and rows, are those of `integrate`.
    """
    if family <= INSIDE and not hard:
        return integrate(torus, way, rules, rows)
    turned = rate = length = 0.0
    for leg in in_legs(way) if hard else legs_of_second(way):
        parts = integrate(torus, leg, rules, rows)
        turned, rate, length = turned + parts[0], rate + parts[1], length + parts[2]
    return turned, rate, length


def newton(u, miss, rate, scale, low, high, before):
    """Return a new bracket low, high, how far u goes, Newton's step, the next u, and if it's last.

    Parameters
    ----------
    u : float
        The unknown.
    miss, rate : float
        By how much the angle turned with u is too small, and its derivative by u, in rad.
    scale : float
        Steps are judged against it and |u|.
    low, high : float
        The bracket so far; `high` is infinite while no angle was too great.
    before : float
        How far u has come in the round before.
    """
    # The turned angle grows with u: the sign of the miss says on which side the root is.
    if miss > 0:
        low = u
    if miss < 0:
        high = u
    # Beyond the end of a class no angle changes: there rate is 0, and u is the root or none is.
    step = 0.0 if miss == 0 or rate == 0 else miss / rate
    onward = rate != 0 or abs(miss) <= AGREES
    # The bracket is halved instead where Newton's step leaves it or isn't a number, and where the
    # step goes back nearly as far as u has come: two such steps might repeat for ever. Until some
    # angle was too great, u at most doubles: a rate near zero would throw it where every rate is 0.
    if not (before == 0 or (step > 0) == (before > 0) or abs(step) <= 0.9 * abs(before)):
        onward = False
    endless = high == math.inf
    most = 2 * abs(u) + 0.5 if endless else high
    sound = onward and low <= u + step <= most
    halved = most if endless else (low + high) / 2
    # A small step isn't enough: where no way turns so far, u grows until every step is small to it.
    done = sound and abs(step) <= STEP * (abs(u) + scale) and abs(miss) < NEAR
    new = u + step if sound else halved
    return low, high, new - u, step, new, done


def start(torus, ends, a, b, angle):
    """Return where `find_root` begins for `outer`: a first guess, a scale, and the least unknown.

    The guess sets out from a in the direction of the chord to b, projected on the tangent plane at
    a. On a sphere, r = 0, this is the geodesic itself. The torus and its ends at phi = a and b are
    those of `outer`; the way turns by `angle`, in rad.
    """
    R = torus.R
    rho_a = ends.rho_a
    half, other = sine_cosine(angle / 2)
    # The chord's parts along the meridian at a, towards growing phi, and along the parallel. The
    # first one is that of the chord from a to b in one meridian plane, -R sin(a - b), and of the
    # move inwards by rho_b (1 - cos(angle)) when the parallel is followed.
    sine_a = 2 * ends.sine_a * ends.cosine_a
    up = 2 * (ends.rho_b * half * half * sine_a - R * ends.sine * ends.cosine)
    along = 2 * ends.rho_b * abs(half * other)
    size = square_root(up * up + along * along)
    sine = up / size
    # x of that direction, which rises from the parallel by an angle with this sine and the cosine
    # along / size: 2R x^2 = rho_a - c = rho_a (1 - cosine), where 1 - cosine is taken as
    # sine^2 / (1 + cosine), which keeps its digits.
    x = sine * rho_a / square_root(2 * R * rho_a * (1 + along / size))
    X = ends.room
    # From x to u by the inverse of each part of `outer`, kept off both ends of the class. Above
    # zero u = X artanh(x/X), as the area sine of share / sqrt(1 - share^2).
    guess = 0.99 * x
    if x > 0:
        share = smaller(x / X, 0.95)
        guess = X * area_sine(share / square_root((1 - share) * (1 + share)))
    # `rest` is (L + x) / L, and L + x = (L^2 - x^2) / (L - x) = c / 2R / (L - x). `far` is the
    # logarithm of (1 - STEEP) / rest: that of a square root is the area sine below, taken twice.
    if wide(torus) and x < -STEEP * ends.meridian:
        L = ends.meridian
        rest = rho_a * (along / size) / (2 * R) / (L * (L - x))
        times = square_root((1 - STEEP) / larger(smaller(rest, 1 - STEEP), 1e-299))
        far = 2 * area_sine((times - 1 / times) / 2)
        guess = -L * (STEEP + (1 - STEEP) * far)
    if not a > 0:
        guess = X / 2  # from the outer equator any way has to rise first
    # Without a scale a root near zero would be sought until its last digit, however small it is. By
    # a node the whole class is no longer than X.
    scale = smaller(ends.sine_a, X)
    return guess, scale, -(STEEPEST if wide(torus) else 1.0) * ends.meridian
