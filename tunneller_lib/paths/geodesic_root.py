"""The classes of geodesics on a torus: the turned angle of each, and its root.

A geodesic runs from phi = a >= 0 to phi = b, |b| <= a. Clairaut's c = rho sin(azimuth) is constant
along it, so that with rho = r + R cos(phi)

    d(theta) / d(phi) = R c / (rho sqrt(rho^2 - c^2)),   d(s) / d(phi) = R rho / sqrt(rho^2 - c^2).

The root vanishes at a turning point, where rho = c, and a quadrature in phi would fail there. In
all classes sin(phi/2) or cos(phi/2) is a multiple of cos(t), and t takes the place of phi: with
D = A + B sin^2(t) and rho = c + 2R (E + B sin^2(t)),

    angle = sqrt(2R) int c / (rho sqrt((rho + c) D)) dt,
    length = sqrt(2R) int rho / sqrt((rho + c) D) dt.

No angle is needed: sines and cosines of t follow from those of a/2 and b/2 by roots and quotients.

The functions take plain numbers, one geodesic at a time. They run as they stand or compiled, with
the same bits (`kernels.compiled`). A `torus` is whatever has r and R.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, smaller, square_root
from ..kernels.repeatable import area_sine, growth, sine_cosine
from .quadrature import gauss_rule

# The classes: `outer`, `inner`, and `second` on either side of its least turned angle.
OUTSIDE, INSIDE, PAST, BEFORE = range(4)

STEEP = 0.9  # of the way to the meridian: from there on `outer` counts what is left of it
STEEPEST = 70.0  # of that way: what is left there is 1e-301 of it
NARROW = 0.32  # of R: what is nearer to the axis there than that needs a leg of its own
CLOSE = 1e-5  # rad
PI_REST = 1.2246467991473532e-16  # what pi is more than the double next to it

NODES_OF_WORKING_SHEET = 20  # of the quadrature, where no geodesic comes near a node of the torus
NODES = 96
NODES_OF_RING = 64

ROUNDS = 200  # Newton's method takes about four; halving takes sixty, and more for roots of 1e-30
NEAR = 1e-5  # rad
AGREES = 1e-9  # rad; a turned angle that is off by more is no answer
STEP = 1e-8  # relative; what a last step of this size leaves is of the order of its square
ROUNDING = 1e-7  # a scale: steps of STEP times this, 1e-15, are made of rounding


class Radii(NamedTuple):
    """r and R of a torus as plain numbers, in any unit."""

    r: float
    R: float


class Ends(NamedTuple):
    """The two ends of a geodesic, as far as the classes need them.

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
    """The constants and limits of both integrals for one value of the unknown.

    Parameters
    ----------
    c : float
        Clairaut's constant, in m.
    shape : (A, B, E)
        The other constants.
    rates : (dc, dA, dB, dE)
        The derivatives of all four by the unknown.
    first : (sine, cosine)
        Of the lower limit of t, which is from -pi/2 to pi/2.
    span : (sine, cosine)
        Of the difference of both limits.
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
    # A product has the difference of the squares to its last digits, near ends or not.
    apart = middle * sine
    rho_a, rho_b = rho(torus, a, cosine_a), rho(torus, b, cosine_b)
    meridian = square_root(larger(rho_a, 0.0) / (2 * torus.R))
    # On a ring the geodesic of x = X winds towards the inner equator (k = 1, c = r - R), on a
    # spindle it is the meridian, through the node (c = 0).
    room = cosine_a if torus.r >= torus.R else meridian
    return Ends(
        sine_a, cosine_a, sine_b, cosine_b, sine, cosine, apart, rho_a, rho_b, meridian, room
    )


def rho(torus, phi, cosine):
    """Return the `distance` at phi, or zero at the node of a horn, which isn't on its sheet."""
    far = distance(torus, phi, cosine)
    return 0.0 if torus.r == torus.R and phi == math.pi else far


def distance(torus, phi, cosine):
    """Return rho at phi, in rad, from -pi to pi, by the `cosine` of phi / 2 as well."""
    _, level = sine_cosine(phi)
    # Where r and R cos(phi) nearly cancel on a horn, r - R and R (1 + cos(phi)) keep the digits.
    if level < -0.5:
        return torus.r - torus.R + 2 * torus.R * (cosine * cosine)
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
        The unknown, from the meridian, -70 or -1 times `ends.meridian`, upwards: below zero for
        ways that descend at once.

    Notes
    -----
    sin(phi/2) = k cos(t), with t = 0 at the turning point. Let x = -k sin(t) at a, which is
    negative where the turning point is behind, and W = k sin(t) at b. Then k^2 = sin^2(a/2) + x^2,
    rho_a - c = 2R x^2 and rho_b - c = 2R W^2: nothing cancels where x is small, and all follows
    from x.
    """
    r, R = torus.r, torus.R
    L, X = ends.meridian, ends.room
    if wide(torus) and u < -STEEP * L:
        # The meridian, c = 0, is at x = -L. On a ring c would be a difference, which cancels
        # there, and by the node of a horn the least c turns far: u counts x + L by its logarithm.
        unit = (1 - STEEP) * L
        left = unit / (1 + growth((-STEEP * L - u) / unit))
        x, dx = left - L, left / unit
        c = 2 * R * (left * (2 * L - left))
        rest = (c - (r - R)) / (2 * R)
    else:
        # Below zero the class has no end, and x = u joins without a bend.
        x, dx, e = u, 1.0, (X - u) * (X + u)
        if u > 0:
            x, dx, e = _spread(torus, X, u)
            if r <= R and u > 30 * X:  # the class ends by the node, and nothing turns farther
                dx = 0.0
        c, rest = _swing(torus, e)
    if rest >= 0:
        return _turning(torus, ends, x, dx, c, rest, -1.0)
    # k > 1, c < r - R: prolonged, it would cross the inner equator, without a turning point. D
    # would vanish there in that form; t = (pi - phi)/2, cos(phi/2) = sin(t), has no such place.
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
        The unknown, any number: far from zero, c nears 0, or r - R on a ring.
    sense : {1.0, -1.0}
        -1 if it is the negative of the unknown that is given.
    """
    x, dx, e = _spread(torus, ends.room, abs(u))
    c, rest = _swing(torus, e)
    return _turning(torus, ends, sense * math.copysign(x, u), sense * dx, c, rest, 1.0)


def _turning(torus, ends, x, dx, c, rest, rising):
    """Return the `Integrand` of a geodesic between turning points, by x and by dx, its rate.

    `rest` is 1 - k^2, and `rising` 1 where the way rises to b, as of `second`, or -1.
    """
    sa, sb = ends.sine_a, ends.sine_b
    k2 = sa * sa + x * x
    W = square_root(larger(ends.apart + x * x, 0.0))
    k = square_root(k2)
    # The sine of the span times k^2 is W sa + x sb. Where x sb < 0 that is a difference; its
    # product with the sum, W^2 sa^2 - x^2 sb^2, is apart k^2.
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
    """Return the cosines of the azimuths at both ends, of which x and W have the signs."""
    # sqrt(rho^2 - c^2) / rho, with rho - c = 2R x^2 at a and 2R W^2 at b.
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
    It has no turning point: t = (phi - pi)/2. c = (r - R) tanh(u) grows to that of the inner
    equator, on which a geodesic turns the farther the nearer it comes, again as a logarithm.
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
    # sqrt(rho^2 - c^2) / rho, with rho - c = 2R (kappa^2 + sin^2(t)).
    cos_a = square_root(2 * R * (kappa2 + ca * ca) * (ends.rho_a + c)) / ends.rho_a
    cos_b = square_root(2 * R * (kappa2 + cb * cb) * (ends.rho_b + c)) / ends.rho_b
    shape = kappa2, 1.0, kappa2
    rates = dc, dkappa2, 0.0, dkappa2
    span = sa * cb - ca * sb, -ends.cosine
    return Integrand(c, shape, rates, (-ca, sa), span, (cb, -sb), (0.0, 0.0), (cos_a, cos_b))


def wide(torus):
    """Return whether `outer` counts by a logarithm what is left of the way to the meridian."""
    return torus.r > 0.9 * torus.R


def _spread(torus, X, u):
    """Return x = X tanh(u / X), its derivative and X^2 - x^2, for u from 0 upwards.

    On a ring the turned angle grows without limit towards X, as a logarithm, and on a spindle the
    way turns ever more sharply by the node: this spreads both out.
    """
    # Beyond the farthest the geodesic runs into the node, with a turn too sharp for the
    # quadrature, or turns many times.
    farthest = 600.0 if torus.r > torus.R else 60.0
    grown = growth(smaller(2 * u / X, farthest))
    x = X * (grown / (2 + grown))
    gap = 2 * X / (2 + grown)  # X - x, which would cancel where u is great
    e = gap * (X + x)
    return x, e / (X * X), e


def _swing(torus, e):
    """Return c and 1 - k^2 by e = X^2 - x^2, from which nothing is taken that would cancel."""
    r, R = torus.r, torus.R
    return 2 * R * e + larger(r - R, 0.0), e + larger(R - r, 0.0) / (2 * R)


def peaked(torus, ends, b, angle):
    """Return whether a way of `outer` may need three legs, lest its quadrature miss a peak.

    The torus, its ends and b are those of `outer`. A way needs legs where it nears a node, or an
    inner equator, at its end at b, too, or passes by a node so closely as only ways do that turn by
    an `angle` next to what half a swing turns there.
    """
    near = smaller(ends.rho_b, 2 * torus.R * (ends.cosine_b * ends.cosine_b))
    if b < 0 and near < NARROW * torus.R:
        return True
    return half_swing_by_the_node(torus) - angle < CLOSE


def half_swing_by_the_node(torus):
    """Return the turned angle of half a swing that just misses the node, in rad."""
    if torus.r >= torus.R:
        return math.inf
    return math.pi / math.sqrt((1 - torus.r / torus.R) * (1 + torus.r / torus.R))


def in_legs(way):
    """Return a way of `outer` in three legs, which begin or end where the integrands have peaks.

    To the turning point, t = 0; on to the outer equator, t = pi/2; and to the end, from where it
    is mirrored, for the integrands repeat backwards. Legs that a way doesn't have are of no length.
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
    """Return a way of `second` in three legs, none with more than one turning point.

    Down to the outer equator, on to its next crossing or to b, and up from there. The integrands
    repeat after pi, and backwards from any multiple of pi/2: each leg is mirrored to where t is in
    [-pi/2, pi/2], and ends at pi/2.
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
    """Return a part of a way between other limits; the upper one is given by the span alone."""
    return Integrand(way.c, way.shape, way.rates, first, span, first, motion, way.cosines)


# ---- both integrals ------------------------------------------------------------


def integrate(torus, way, nodes, rows):
    """Return the turned angle of a geodesic, its rate by the unknown, and the length.

    Parameters
    ----------
    torus : Radii
        The surface.
    way : Integrand
        Constants and limits.
    nodes : (shares and weights, count)
        A quadrature's, of which so many count, see `rule`.
    rows : (3, m) float
        Room for what nodes add.

    Returns
    -------
    turned, rate, length : float
        In rad, rad and m.
    """
    shares, count = nodes
    add_nodes(torus, way, shares, rows)
    rate = folded(rows[1], count) + moving(torus, way)
    return folded(rows[0], count), rate, folded(rows[2], count)


def add_nodes(torus, way, nodes, rows):
    """Write down what nodes at shares of the way from both of its ends add to each integral.

    Parameters
    ----------
    torus : Torus
        The surface.
    way : Integrand
        Constants and limits.
    nodes : (2, k) float
        Shares and weights.
    rows : (3, k) float
        Filled with parts of the turned angle, of its rate by the unknown, and of the length.
    """
    c, (A, B, E), (dc, dA, dB, dE) = way.c, way.shape, way.rates
    first, last, half, width = _stretched(torus, way)
    twice, half_c = 2 * torus.R, c / 2
    shares, weights = nodes[0], nodes[1]
    turned, rate, length = rows[0], rows[1], rows[2]
    for k in range(len(shares)):
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
            # One quotient has those by rho, both and D.
            all_ = 1 / (rho * under)
            by_rho = all_ * under
            density = square_root(twice * (all_ * rho)) * (step * (above + below) * flat)
            # The rate of c / (rho sqrt((rho + c) D)) by the unknown, twice, from its logarithm.
            drho = dc + twice * (dE + dswing)
            twice_rate = (
                2 * drho * by_rho
                + (drho + dc) * (all_ * (rho * D))
                + (dA + dswing) * (all_ * (rho * both))
            )
            turned_by = turned_by + c * by_rho * density
            rate_by = rate_by + (dc - half_c * twice_rate) * by_rho * density
            length_by = length_by + rho * density
        turned[k] = turned_by
        rate[k] = rate_by
        length[k] = length_by


def _stretched(torus, way):
    """Return by which substitution the integrals of a way are taken.

    Near t = 0 the integrands have a peak: where D or rho is zero they have singular points, which
    lie off the real line, the nearer the smaller both are at t = 0. With tan(t/4) = a0 sinh(y),
    and a0 their distance, the peak is stretched to unit width, however narrow it is; and sin(t) is
    4 v (1 - v^2) / (1 + v^2)^2 at v = tan(t/4), without a sine.
    """
    c, (A, B, E), (sine, cosine), (across, along) = way.c, way.shape, way.first, way.span
    tangent = sine / (1 + cosine)  # of half of the lower limit
    first = tangent / (1 + square_root(1 + tangent * tangent))
    # Half of the span, by the root of what doesn't cancel.
    long_side = square_root((1 + abs(along)) / 2)
    short_side = across / (2 * long_side)
    reach = short_side / (1 + long_side) if along > 0 else long_side / (1 + short_side)
    width = reach * (1 + first * first) / (1 - first * reach)  # tan(t/4) grows by it
    last = first + width
    # sinh(h) where D or rho is zero, at t = i h, the nearer of both; then tan(i h/4) / i.
    narrow = larger(smaller(A, E + c / (2 * torus.R)), 0.0) / B
    narrow = smaller(narrow, 1e100)
    half = square_root(narrow) / (1 + square_root(1 + narrow))
    peak = half / (1 + square_root((1 - half) * (1 + half)))
    # Where the way begins past the peak, their distance from its beginning; zero isn't divided by.
    past = larger(first, 0.0)
    a0 = larger(square_root(peak * peak + past * past), 1e-30)
    x = first / a0
    z = last / a0
    root_x = square_root(1 + x * x)
    root_z = square_root(1 + z * z)
    # The hyperbolic sine of the difference of y. Far from the turning point it cancels, on a short
    # way nearly all of it: there it is the difference of the squares, (z - x)(z + x), over the sum.
    if x > 0:
        lead = x + root_x
        apart = width / a0 * (x + z) / (z * root_x + x * root_z)
    else:
        lead = 1 / (root_x - x)
        apart = z * root_x - x * root_z
    return lead, z + root_z, a0 / 2, area_sine(apart)


def moving(torus, way):
    """Return what the motion of the limits adds to the rate of the turned angle."""
    (sine, cosine), (across, along) = way.first, way.span
    upper = sine * along + cosine * across
    first = _density(torus, way, sine * sine)
    last = _density(torus, way, upper * upper)
    return way.motion[1] * last - way.motion[0] * first


def _density(torus, way, sin2):
    """Return the rate of the turned angle by t."""
    c, (A, B, E) = way.c, way.shape
    rho = c + 2 * torus.R * (E + B * sin2)
    return c / rho * square_root(2 * torus.R / ((rho + c) * (A + B * sin2)))


def folded(row, count):
    """Return the sum of the first so many values of a row, which changes.

    The order is kept: halves are added to each other as long as they are even, several at a time
    where a compiler can.
    """
    while count % 2 == 0:
        count = count // 2
        for k in range(count):
            row[k] += row[count + k]
    total = row[0]
    for k in range(1, count):
        total = total + row[k]
    return total


# ---- the root ------------------------------------------------------------------


@cache
def rule(count):
    """Return shares of the way, and weights, of Gauss and Legendre's quadrature (count / 2,).

    The other half has the same shares from the end.
    """
    nodes, weights = gauss_rule(count)
    return (1 + nodes[: count // 2]) / 2, weights[: count // 2] / 2


@cache
def quadratures(ring, ready):
    """Return the rules that `near_side` wants, for loops that are `ready`, compiled, or plain.

    Compiled, nodes go eight at a time, of which some may have no weight. Plain Python is fastest
    on lists.
    """
    found = []
    for count in (NODES_OF_WORKING_SHEET, NODES_OF_RING if ring else NODES, NODES):
        shares, weights = rule(count)
        rest = -len(shares) % 8
        padded = np.stack([np.pad(shares, (0, rest), mode="edge"), np.pad(weights, (0, rest))])
        found.append((padded if ready else [shares.tolist(), weights.tolist()], count // 2))
    return tuple(found)


def find_root(torus, ends, a, b, angle, begin, family, rules, rows):
    """Return the way of a class that turns by an angle.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : Ends
        The ends.
    a, b, angle : float
        phi at the ends, and the turned angle, in rad.
    begin : (u, scale, low)
        As by `start`.
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
    # Few nodes do where they, doubled, change nothing: near enough to a sphere, far from the node.
    sheet = torus.r <= torus.R / 4 and a <= 1 and angle <= 2
    hard = family == OUTSIDE and not sheet and peaked(torus, ends, b, angle)
    nodes = rules[0] if sheet else rules[1]
    u, scale, low = begin
    high, before = math.inf, 0.0
    way = way_of(family, torus, ends, u)
    for _ in range(ROUNDS):
        turned, rate, length = integrate_way(torus, way, family, hard, nodes, rows)
        miss = angle - turned
        # For a given angle the length is stationary in c: what u lacked hardly matters.
        total = length + way.c * miss
        low, high, before, step, u, done = newton(u, miss, rate, scale, low, high, before)
        way = way_of(family, torus, ends, u)  # after the last step for c and the azimuths alone
        if done:
            # The class may end before it turns so far. A level start has no rate.
            miss -= rate * step if step != 0 else 0.0
            break
    else:
        # On what is nearly a sphere all ways of a class may turn by the same to the last digit:
        # then any u will do, however far the last step was.
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


def integrate_way(torus, way, family, hard, nodes, rows):
    """Return what `integrate` does for a way of a class, in legs where one quadrature won't do.

    The class is `family`; `hard` says that a way of `outer` needs legs, as those of `second` always
    do. The other arguments, torus, nodes and rows, are those of `integrate`.
    """
    if family <= INSIDE and not hard:
        return integrate(torus, way, nodes, rows)
    turned = rate = length = 0.0
    for leg in in_legs(way) if hard else legs_of_second(way):
        parts = integrate(torus, leg, nodes, rows)
        turned, rate, length = turned + parts[0], rate + parts[1], length + parts[2]
    return turned, rate, length


def newton(u, miss, rate, scale, low, high, before):
    """Return a new bracket low, high, how far u goes, a step, the next u, and whether it was last.

    `miss` is by how much the angle that is turned with the unknown u is too small, `rate` what it
    gains with u, both in rad; u came `before` far to where it is, and is of some `scale`.
    """
    # The turned angle grows with u: the sign of the miss says on which side the root is.
    if miss > 0:
        low = u
    if miss < 0:
        high = u
    # Beyond the end of a class nothing changes, and the end may be the answer.
    step = 0.0 if miss == 0 or rate == 0 else miss / rate
    onward = rate != 0 or abs(miss) <= AGREES
    # A step that leaves the bracket, or isn't a number, gives way to halving it, and so does one
    # that goes back nearly as far as u came, lest two swing to and fro for ever; while nothing was
    # too far yet, u doubles at most, for a rate near zero would throw it where none comes back.
    if not (before == 0 or (step > 0) == (before > 0) or abs(step) <= 0.9 * abs(before)):
        onward = False
    endless = high == math.inf
    most = 2 * abs(u) + 0.5 if endless else high
    sound = onward and low <= u + step <= most
    halved = most if endless else (low + high) / 2
    # The second condition: where nothing turns so far, u grows until any step is small.
    done = sound and abs(step) <= STEP * (abs(u) + scale) and abs(miss) < NEAR
    new = u + step if sound else halved
    return low, high, new - u, step, new, done


def start(torus, ends, a, b, angle):
    """Return a first guess for `outer`, the scale of the unknown near zero, and its least value.

    On a `torus`, between `ends` at phi = a and b, for a way that turns by an `angle`, in rad.
    """
    R = torus.R
    rho_a = ends.rho_a
    half, other = sine_cosine(angle / 2)
    # The chord's elevation in the tangent plane at a, which is the answer on a sphere. Its part
    # towards growing phi is the meridian's, and what the parallel bends inwards meanwhile.
    sine_a = 2 * ends.sine_a * ends.cosine_a
    up = 2 * (ends.rho_b * half * half * sine_a - R * ends.sine * ends.cosine)
    along = 2 * ends.rho_b * abs(half * other)
    size = square_root(up * up + along * along)
    sine = up / size
    # x of that azimuth: rho_a - c = 2R x^2 with c = rho_a cos(tilt), 1 - cos as sin^2 / (1 + cos).
    x = sine * rho_a / square_root(2 * R * rho_a * (1 + along / size))
    X = ends.room
    # From x to u, kept off both ends of the class.
    guess = 0.99 * x
    if x > 0:
        share = smaller(x / X, 0.95)
        guess = X * area_sine(share / square_root((1 - share) * (1 + share)))
    # Near the meridian u counts by its logarithm what x lacks of it: c / 2R over their sum.
    if wide(torus) and x < -STEEP * ends.meridian:
        L = ends.meridian
        rest = rho_a * (along / size) / (2 * R) / (L * (L - x))
        times = square_root((1 - STEEP) / larger(smaller(rest, 1 - STEEP), 1e-299))
        far = 2 * area_sine((times - 1 / times) / 2)
        guess = -L * (STEEP + (1 - STEEP) * far)
    if not a > 0:
        guess = X / 2  # from the outer equator it has to rise somehow
    # Steps are judged against |u| and this scale, lest a root near zero be sought for ever. With
    # b > 0 so large a scale would let them end too early near the inner equator, where roots are
    # small themselves; one that asks for steps of rounding size doesn't.
    # By a node the whole class is no longer than X.
    scale = smaller(ends.sine_a if b <= 0 else ROUNDING, X)
    return guess, scale, -(STEEPEST if wide(torus) else 1.0) * ends.meridian
