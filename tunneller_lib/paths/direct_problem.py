"""The direct problem: geodesics of a torus from given starts, directions and lengths.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant, and with it arc length s and turned angle
are integrals over one variable t (`geodesic_root`). The integrands depend on sin^2(t) alone, so
that they repeat after pi: half a swing between turning points, or one round of a ring's tube. And
they repeat backwards from pi/2.

So each integral is a mean growth and a series of sines of even multiples of t. The arc length is
solved for the place, the place tells the rest: a geodesic of any length costs the same time. Few
terms do where the integrands' peak at t = 0 is wide; tan(t) = k tan(x) makes it wider, and the
series are in x. Where it is narrow, t = width sinh(y) spreads it, and the range from t = 0 to pi/2
is divided into panels of equal width in y, over which the integrals are taken by quadratures.

Below `followed` lengths are in tube radii, rho = r + cos(phi).

`follow_each` loops over geodesics, in plain Python or compiled, with the same bits.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Angles, Array, Lengths, Positions, checked, none_outside
from ..kernels import compiled
from ..kernels.compiled import loop
from ..kernels.elementwise import (
    NUMBERS,
    PLAIN,
    divided,
    larger,
    ratio,
    smaller,
    square_root,
    within,
)
from ..kernels.exact import dot
from ..kernels.repeatable import WHOLE, arctangent, area_sine, growth, reduced, sine_cosine
from ..surfaces import Torus
from ..surfaces.torus import torus_normal, torus_point, torus_tangents
from .bounds import Count, check_points, check_ratio
from .geodesic_root import Radii, distance, rule

ALONG_MERIDIAN = 4e-16  # the sine of an azimuth that is 0 or pi to its last digit
STEEP = 0.1  # a sine below which Clairaut's constant has more digits of it than the azimuth
# Terms of the series of sines, and from which k^2 = tanh(h) on, see `orbit_of`, so many do: the
# first term left out is about exp(-2 terms artanh(k)) / (2 terms) of the mean, less than 5e-17.
TERMS = 8, 10, 12, 14, 16, 20, 24, 32, 48, 64
SINES = tuple((terms, round(math.tanh(17.4 / terms) ** 2, 3)) for terms in TERMS)
PANEL, PANEL_PAIRS = 1.2, 12  # greatest width of a panel, and pairs of nodes of its quadrature
MOST_PANELS = 60  # by the narrowest peak, where y goes up to 70
STEP = 1e-8  # Newton's last step leaves an error of the order of its square
NARROWEST = 1e-30  # width of a peak: below it c is r - R to its last digit
ROUNDS = 30  # Newton's method takes three to eight
BLOCK = 8192  # points at a time: any number of points needs the same room
EACH, POINT = 3e-5, 1.2e-5  # s in plain Python for a geodesic, and for each of its points
KIND = "points of geodesics"  # of work, for `compiled`
LATE = 0.9  # of the angle from t = 0 to pi/2: a start beyond counts by what is left of it


Ways = Array("(..., m, 2) float", "rad", last="theta, phi")


@dataclass(frozen=True, eq=False)
class GeodesicPoints:
    """Points along geodesics, from first to last: made by `geodesic_direct`.

    Parameters
    ----------
    torus : Torus
        The surface.
    s : (..., n) float
        Arc lengths from the start, in m.
    position : (..., n, 2) float
        Joint positions (theta, phi), in rad; neither is reduced to one turn.
    azimuth : (..., n) float
        Directions, in rad.
    """

    torus: Torus
    s: np.ndarray
    position: np.ndarray
    azimuth: np.ndarray

    @property
    def point(self):
        """Return the points (..., n, 3), in m."""
        # Unchecked, for angles may be NaN.
        return torus_point(self.torus, *np.moveaxis(self.position, -1, 0))

    @property
    def tangent(self):
        """Return the unit tangents (..., n, 3)."""
        meridian, parallel = torus_tangents(*np.moveaxis(self.position, -1, 0))
        cos = np.cos(self.azimuth)[..., None]
        sin = np.sin(self.azimuth)[..., None]
        return cos * meridian + sin * parallel

    @checked
    def deviation(self, position: Ways):
        """Return how far joint positions lie beside the geodesic.

        Parameters
        ----------
        position : (..., m, 2) float
            Joint positions (theta, phi), in rad; the leading axes broadcast with the geodesics'.

        Returns
        -------
        deviation : (..., m) float
            In m, from the tangent at the nearest of the points, within the tangent plane there:
            positive to the left of the way as seen from outside.

        Raises
        ------
        ValueError
            If the leading axes don't broadcast with the geodesics'.

        Examples
        --------
        >>> three = geodesic_direct(Torus(0.1, 0.9), np.zeros((3, 2)), 0.0, 0.9)
        >>> three.deviation(np.zeros((2, 1, 2)))  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ValueError: position: its leading axes must broadcast with those of the ..., (3,); got (2,).
        """
        own = self.s.shape[:-1]
        try:
            leading = np.broadcast_shapes(position.shape[:-2], own)
        except ValueError:
            raise ValueError(
                f"position: its leading axes must broadcast with those of the geodesics, {own}; "
                f"got {position.shape[:-2]}."
            ) from None
        theta, phi = np.moveaxis(position, -1, 0)
        point = torus_point(self.torus, theta, phi)
        # |P - N|^2 = P^2 - 2 (P.N - N^2 / 2), of which P^2 is the same for all N; so one product of
        # matrices finds the nearest.
        on_way = self.point
        nearness = point @ np.swapaxes(on_way, -1, -2)
        nearness -= dot(on_way, on_way)[..., None, :] / 2
        near = np.argmax(nearness, axis=-1)[..., None]
        normal = torus_normal(*np.moveaxis(self.position, -1, 0))
        across = np.cross(normal, self.tangent)
        on_way = np.broadcast_to(on_way, (*leading, *on_way.shape[-2:]))
        across = np.broadcast_to(across, on_way.shape)
        gap = point - np.take_along_axis(on_way, near, axis=-2)
        return dot(gap, np.take_along_axis(across, near, axis=-2))


@checked
def geodesic_direct(torus: Torus, p: Positions, azimuth: Angles, length: Lengths, n: Count = 2):
    """Return geodesics of given start, direction and length.

    Parameters
    ----------
    torus : Torus
        The surface.
    p : (..., 2) float
        Joint positions (theta, phi) of the starts, in rad.
    azimuth : (...) float
        Directions, in rad; they broadcast with p.
    length : (...) float
        In m; a negative one goes backwards.
    n : int
        Number of points, equally spaced in arc, both ends included, from 2 to a million, and at
        most 5 million of all geodesics together.

    Returns
    -------
    points : GeodesicPoints
        The last point is the end; it is NaN, as all are, where a start isn't on the working sheet.
        A geodesic whose azimuth is a meridian's to the last digit goes through a node onto the
        inner sheet; any other one turns before the node.

    Raises
    ------
    ValueError
        If r / R isn't from 1e-100 to 1e100, or n isn't a whole number of at least 2.

    Notes
    -----
    theta' = sin(alpha)/rho, phi' = cos(alpha)/R, alpha' = sin(phi) sin(alpha)/rho in arc length.
    Clairaut's constant turns them into quadratures, which repeat after half a swing or a round of
    the tube: a geodesic of any length takes as long as a short one. Angles are right to some
    roundings, and to length / sqrt(R (r + R)) of them on a long way, along which an error of the
    start grows. Near the inner equator of a ring, where neighbours part, it grows
    exp(length / sqrt(R (r - R))) times. Next to a node theta is right to roundings of R / rho.

    Examples
    --------
    >>> way = geodesic_direct(Torus(0.1, 0.9), (0, -0.3), 0.0, 0.63)
    >>> way.position[-1].round(12)
    array([0. , 0.4])
    >>> geodesic_direct(Torus(0.1, 0.9), np.zeros((6, 2)), 0, 1, 10**6)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: n: must ask for at most 5000000 points of all ...; got 1000000 of each of 6.
    """
    return followed(torus, p, azimuth, length, n)


def followed(torus, p, azimuth, length, n, clairaut=None):
    """Return points of geodesics as `geodesic_direct` does.

    Parameters
    ----------
    torus, p, azimuth, length, n
        As of `geodesic_direct`.
    clairaut : (...) float, optional
        rho times the sine of the azimuth, in m. Near a meridian it has digits that the azimuth
        lacks: they tell whether the way goes through a node or turns before it.
    """
    shape = np.broadcast(p[..., 0], azimuth, length).shape
    check_ratio(torus)
    check_points(n, shape)
    s, given = np.empty((*shape, n)), np.empty((6, *shape))
    s[...] = length[..., None] * _shares(n)
    given[0], given[1], given[2] = p[..., 0], p[..., 1], azimuth
    given = given.reshape(6, -1)
    near = none_outside(given[1:3], -math.pi, math.pi)
    given[3:5] = given[1:3] if near else reduced(given[1:3])
    given[5] = math.nan if clairaut is None else np.ravel(clairaut) / torus.R
    position, azimuth = trace(torus, given, s.reshape(-1, n))
    return GeodesicPoints(torus, s, position.reshape(*s.shape, 2), azimuth.reshape(s.shape))


@lru_cache(4)
def _shares(n):
    """Return n equally spaced shares of a way, from 0 to 1, which may not be written to."""
    return np.linspace(0, 1, n)


# ---- orbits ------------------------------------------------------------------


class Orbit(NamedTuple):
    """The constants of a geodesic: rho = c + 2 (E + B sin^2(t)), and D = A + B sin^2(t).

    Lengths are in tube radii: the constants are those of `geodesic_root` for R = 1. The integrands
    are singular where sin(t) is i times `width`, which is how wide their peak at t = 0 is;
    `stretch` and `level` follow from it. `free` tells whether the geodesic goes round the tube; if
    it swings instead, D is cos^2(phi/2).
    """

    c: float
    A: float
    B: float
    E: float
    width: float
    stretch: float
    level: int
    free: bool


def headed(r, phi, azimuth, c):
    """Return sine and cosine of a geodesic's azimuth at its start, and where that is.

    Parameters
    ----------
    r : float
        r / R of the torus.
    phi, azimuth : float
        Those of the start, in rad, from -pi to pi.
    c : float
        Clairaut's constant, over R, or NaN where it isn't known.

    Returns
    -------
    sine, cosine : float
        Of the azimuth; the sine is zero along a meridian.
    placed : tuple
        Sine and cosine of half of phi, and the distance from the axis; this is above zero only
        where the start is on the working sheet.
    """
    sine, cosine = sine_cosine(azimuth)
    half_sine, half_cosine = sine_cosine(phi / 2)
    rho = distance(Radii(r, 1.0), phi, half_cosine)
    if c == c:
        # Near a meridian the azimuth's own rounding is most of its sine.
        if abs(sine) <= STEEP:
            sine = ratio(c, rho)
    elif abs(sine) <= ALONG_MERIDIAN:
        sine = 0.0
    return sine, cosine, (half_sine, half_cosine, rho)


def orbit_of(r, phi, placed, sine, cosine):
    """Return the `Orbit` of a geodesic, and where it starts on this.

    Parameters
    ----------
    r, phi : float
        r / R of the torus, and the start's phi, from -pi to pi, in rad.
    placed : tuple
        As by `headed`: the start is on the working sheet.
    sine, cosine : float
        Of the azimuth there, the sine above zero.

    Returns
    -------
    orbit : Orbit
        Its constants.
    start : (rising, across, along, begun)
        1 if phi grows at first, else -1; what is in proportion to the sine and to the cosine of t,
        from -pi/2 to pi/2 once `begun`, a whole number of half swings, pi each, is taken off.
    """
    half_sine, half_cosine, rho = placed
    c = rho * sine
    slope = cosine * square_root(rho / (2 * (1 + sine)))  # its square is (rho - c) / 2
    k2 = half_sine * half_sine + slope * slope
    # 1 - k^2. On a spindle or a horn it is a sum, which can't cancel. On a ring both forms are
    # differences: where small, they are off by roundings of c, or of cos^2(phi/2).
    square = half_cosine * half_cosine
    rest = (1 - r + c) / 2 if r <= 1 or c <= square else square - slope * slope
    free = rest < 0
    A = larger(abs(rest), NARROWEST * NARROWEST)
    B = 1.0 if free else k2
    E = A if free else 0.0
    # The integrands are singular where D or rho is zero: there sin(t) is i times this width.
    width = larger(square_root(ratio(smaller(A, E + c / 2), B)), NARROWEST)
    # In x, with tan(t) = k tan(x), both integrands are smoothest if the peak's singular points,
    # tan(t) = i tanh(h), sinh(h) = `width`, lie as far off the real line as those that come with x,
    # tan(x) = i / k. So k^2 is tanh(h), and both are artanh(k) off it.
    stretch = square_root(1 / square_root(1 + 1 / (width * width)))
    orbit = Orbit(c, A, B, E, width, stretch, level_of(stretch), free)
    upward = -1.0 if cosine < 0 else 1.0
    if free:
        # Round the tube phi falls as pi - 2t, or grows as 2t - pi, until t = pi/2 at the outer
        # equator. A start `beyond` that, at t > pi/2, has t - pi instead, counted back from the
        # next t = 0: near the inner equator t is small and mustn't be a difference near pi/2.
        beyond = -1.0 if -upward * phi < 0 else 1.0
        return orbit, (upward, beyond * half_cosine, abs(half_sine), (1 - beyond) / 2)
    # Between turning points sin(phi/2) = k cos(t), and the slope is -k sin(t), above zero while phi
    # grows. For phi < 0 t is counted from the lower turning point: from -pi if that is behind the
    # start, from pi if it is ahead. So counted, t makes both formulas change their signs.
    begun = 0.0
    if half_sine < 0:
        begun = -1.0 if slope > 0 else 1.0
    across = slope if half_sine < 0 else -slope
    return orbit, (upward, across, abs(half_sine), begun)


def whole_part(x):
    """Return the nearest whole number, as a float; beyond 2^51, the next one below."""
    return (x + WHOLE) - WHOLE if abs(x) < 2.0**51 else x - x % 1.0


def rates(orbit, sin2, dt):
    """Return by how much arc length and turned angle grow where t grows by `dt`."""
    rho = orbit.c + 2 * (orbit.E + orbit.B * sin2)
    density = square_root(2 / ((rho + orbit.c) * (orbit.A + orbit.B * sin2))) * dt
    return rho * density, orbit.c / rho * density


def point_at(orbit, rising, swings, t, sine, cosine):
    """Return phi and the azimuth, in rad, of a point on an `orbit` along which phi is `rising`.

    `swings`, a whole number, counts half swings from t = 0; from there the point is at `t`, whose
    sine and cosine are given. Only free orbits need t itself.
    """
    sin2 = sine * sine
    rho = orbit.c + 2 * (orbit.E + orbit.B * sin2)
    # The cosine is sqrt(rho^2 - c^2) / rho. rho - c is 2 (E + B sin^2(t)), no difference.
    slope = square_root(2 * (rho + orbit.c)) / rho
    if orbit.free:
        phi = rising * (2 * t + math.pi * (2 * swings - 1))
        onward = rising * square_root(orbit.E + sin2)
    else:
        # Half a swing on, phi and the cosine of the azimuth are mirrored.
        across = (1 - 2 * (swings % 2.0)) * square_root(orbit.B)
        phi = 2 * arctangent(across * cosine, square_root(orbit.A + orbit.B * sin2))
        onward = -across * sine
    return phi, arctangent(orbit.c / rho, slope * onward)


# ---- series of sines, for wide peaks -----------------------------------------


@cache
def sine_rule(terms):
    """Return a list of sin^2 of nodes, and a matrix (terms, 1, terms): from values to integrals.

    The matrix takes an integrand's values at nodes between 0 and pi/2 to the mean growth of its
    integral, and to the factors of sin(2 x), sin(4 x), .. that are added to it.
    """
    # The value at x = (k + 1/2) pi / (2 terms) adds 2 cos(2 j x) / terms to the factor of
    # cos(2 j x), half as much for j = 0; the integral of that cosine is sin(2 j x) / 2j.
    k = np.arange(terms)[:, None]
    j = np.arange(1, terms)
    turns = (j * (2 * k + 1) + 2 * terms) % (4 * terms) - 2 * terms
    cosines = [[sine_cosine(n * (math.pi / (2 * terms)))[1] for n in row] for row in turns.tolist()]
    sines = [sine_cosine(n * (math.pi / (4 * terms)))[0] for n in range(1, 2 * terms, 2)]
    factors = np.array(cosines) / (j * terms)
    matrix = np.concatenate([np.full((terms, 1), 1 / terms), factors], axis=1)
    return [sine * sine for sine in sines], matrix[:, None]


def level_of(stretch):
    """Return which of `SINES` the series of an orbit needs, or -1 where none will do."""
    for level in range(len(SINES)):
        if stretch * stretch >= SINES[level][1]:
            return level
    return -1


def rates_in_x(orbit, square):
    """Return the derivatives of arc length and turned angle by x, where sin^2(x) is `square`."""
    k = orbit.stretch
    slope = k / (1 - (1 - k * k) * square)  # dt / dx
    return rates(orbit, k * square * slope, slope)


def _add_sines(orbit, rules, values, series):
    """Fill in the series of both integrals.

    The terms of a series are sums over the nodes. Numpy adds along an axis that isn't the last one
    node after the other, as the loops of `_in_loops` do; so the bits are the same.
    """
    squares, matrix = sine_rule(TERMS[orbit.level])
    found = np.array([rates_in_x(orbit, square) for square in squares])
    series[0], series[1] = np.add.reduce(matrix * found[..., None], axis=0).tolist()


def _in_loops(orbit, rules, values, series):
    """Do what `_add_sines` does, by loops that are to be compiled; `values` is their room."""
    terms = TERMS[orbit.level]
    squares, matrix = rules[1][orbit.level], rules[2][orbit.level]
    for k in range(terms):
        values[0][k], values[1][k] = rates_in_x(orbit, squares[k])
    for one in range(2):
        for j in range(terms):
            series[one][j] = matrix[0][j] * values[one][0]
        for k in range(1, terms):
            for j in range(terms):
                series[one][j] += matrix[k][j] * values[one][k]


def series_sum(x, sine, cosine, terms, factors):
    """Return a series at x: mean growth times x, and `factors` times sines of even multiples.

    The sine and the cosine are those of 2x.
    """
    twice = 2 * cosine
    b = before = 0.0
    for j in range(terms - 1, 0, -1):
        b, before = (factors[j] - before) + twice * b, b
    return factors[0] * x + sine * b


def place_in_sines(orbit, size, terms, series):
    """Return x, from 0 to pi/2, its sine and cosine, where the arc length from t = 0 is `size`."""
    mean, first, second = series[0][0], series[0][1], series[0][2]
    # The first guess is a step of Newton's method with two terms of the series, whose slope may
    # vanish by a peak.
    x = size / mean
    sine, cosine = sine_cosine(2 * x)
    slope = larger(mean + 2 * first * cosine + 4 * second * (1 - 2 * sine * sine), mean / 2)
    x = within(x - (first + 2 * second * cosine) * sine / slope, 0.0, math.pi / 2)
    for _ in range(ROUNDS):
        sine, cosine = sine_cosine(x)
        square = sine * sine
        found = series_sum(x, 2 * sine * cosine, 1 - 2 * square, terms, series[0])
        slope, _ = rates_in_x(orbit, square)
        moved = within(x + (size - found) / slope, 0.0, math.pi / 2)
        onward = abs(moved - x) > STEP
        x = moved
        if not onward:
            break
    return x, *sine_cosine(x)


# ---- quadratures, for narrow peaks ---------------------------------------------


def rates_in_y(orbit, y):
    """Return the derivatives of arc length and turned angle by y, where t = width sinh(y)."""
    grown = growth(y)
    shrunk = grown / (1 + grown)
    sine, _ = sine_cosine(orbit.width * ((grown + shrunk) / 2))
    return rates(orbit, sine * sine, orbit.width * (1 + (grown - shrunk) / 2))


def gains(orbit, low, high, nodes):
    """Return by how much arc length and turned angle grow from y = low to high, on one panel."""
    length = turned = 0.0
    for k in range(PANEL_PAIRS):
        for share in nodes[0][k], 1 - nodes[0][k]:
            of_length, of_angle = rates_in_y(orbit, low + share * (high - low))
            length = length + nodes[1][k] * of_length
            turned = turned + nodes[1][k] * of_angle
    return (high - low) * length, (high - low) * turned


def tabulate(orbit, nodes, edges):
    """Return the number of an orbit's panels, as a float, and their width in y.

    `edges` is filled with arc lengths and turned angles from t = 0 to where panels begin and end,
    and with what is left of that angle from there to t = pi/2.
    """
    reach = area_sine(math.pi / 2 / orbit.width)
    count = whole_part(reach / PANEL + 0.5)
    last, step = int(count), reach / count
    edges[0][0] = edges[1][0] = edges[2][last] = 0.0
    for panel in range(last):
        length, turned = gains(orbit, step * panel, step * (panel + 1), nodes)
        edges[0][panel + 1] = edges[0][panel] + length
        edges[1][panel + 1] = edges[1][panel] + turned
        edges[2][panel] = turned
    for panel in range(last - 1, -1, -1):
        edges[2][panel] = edges[2][panel + 1] + edges[2][panel]
    return count, step


def place_on_panels(orbit, size, count, step, nodes, edges):
    """Return y where the arc length from t = 0 is `size`, its panel, and the angle on this."""
    panel = 0
    while panel < count - 1 and edges[0][panel + 1] <= size:
        panel += 1
    low, high = step * panel, step * (panel + 1)
    size = size - edges[0][panel]
    y = low + size / (edges[0][panel + 1] - edges[0][panel]) * step
    for _ in range(ROUNDS):
        # On a panel the rate changes so little that the step needs no bracket but the panel.
        length, gained = gains(orbit, low, y, nodes)
        rate, turning = rates_in_y(orbit, y)
        moved = within(y + (size - length) / rate, low, high)
        gained = gained + turning * (moved - y)
        onward = abs(moved - y) > STEP
        y = moved
        if not onward:
            break
    return y, panel, gained


# ---- points on orbits ----------------------------------------------------------


def prepare(orbit, rules, edges, values, series):
    """Fill in the series of an orbit, or its panels' edges; return as `tabulate`, or zeros."""
    if orbit.level < 0:
        return tabulate(orbit, rules[0], edges)
    _add_sines(orbit, rules, values, series)
    return 0.0, 0.0


def begun_at(orbit, start, panels, nodes, edges, series):
    """Return what `point_on` needs to know of a geodesic's start and of half a swing.

    Returns
    -------
    before, turned : float
        Arc length and turned angle from t = 0 to the start.
    left : float
        What the turned angle lacks at the start of that at the next crossing of the outer equator.
    crossing : float
        Which crossing that is, in half swings, if `left` has more digits than the angle; else NaN.
    whole, turn : float
        Arc length and turned angle of half a swing, or of a round.
    """
    _, across, along, _ = start
    sign = -1.0 if across < 0 else 1.0
    if orbit.level >= 0:
        x, terms = arctangent(abs(across), orbit.stretch * along), TERMS[orbit.level]
        sine, cosine = sine_cosine(2 * x)
        before = series_sum(x, sine, cosine, terms, series[0])
        turned = series_sum(x, sine, cosine, terms, series[1])
        whole, turn = math.pi * series[0][0], math.pi * series[1][0]
        left = turn / 2 - turned
    else:
        count, step = panels
        y = area_sine(arctangent(abs(across), along) / orbit.width)
        panel = int(smaller(y / step, count - 1))
        length, gained = gains(orbit, step * panel, y, nodes)
        before, turned = edges[0][panel] + length, edges[1][panel] + gained
        left = edges[2][panel] - gained
        whole, turn = 2 * edges[0][int(count)], 2 * edges[1][int(count)]
    crossing = sign / 2 if turned > LATE * turn / 2 else math.nan
    return sign * before, sign * turned, sign * left, crossing, whole, turn


def point_on(orbit, start, begun, s, panels, nodes, edges, series):
    """Return by how much theta has grown, phi and the azimuth, in rad, of the point at s.

    Whole half swings are taken off the arc length from t = 0. What remains, half of one at most to
    either side of t = 0 but for roundings, is solved for the place.

    Parameters
    ----------
    orbit, start : tuple
        As by `orbit_of`.
    begun : tuple
        As by `begun_at`.
    s : float
        Arc length from the start.
    panels, nodes, edges, series
        What `prepare` returned, the panels' quadrature, and what it filled in.
    """
    before, turned, left, crossing, whole, turn = begun
    rest = s + before
    swings = whole_part(rest / whole)
    rest = rest - swings * whole
    sign, size = -1.0 if rest < 0 else 1.0, smaller(abs(rest), whole / 2)
    if orbit.level >= 0:
        terms = TERMS[orbit.level]
        x, sine, cosine = place_in_sines(orbit, size, terms, series)
        gained = series_sum(x, 2 * sine * cosine, 1 - 2 * sine * sine, terms, series[1])
        lacking = turn / 2 - gained
        across = orbit.stretch * sine
        far = square_root(across * across + cosine * cosine)
        sine, cosine = across / far, cosine / far
        t = arctangent(sine, cosine) if orbit.free else 0.0
    else:
        y, panel, gained = place_on_panels(orbit, size, *panels, nodes, edges)
        gained, lacking = edges[1][panel] + gained, edges[2][panel] - gained
        grown = growth(y)
        t = orbit.width * ((grown + grown / (1 + grown)) / 2)
        sine, cosine = sine_cosine(t)
    if swings + sign / 2 == crossing:
        # The start and the point are beside the same crossing. Both turned angles may be great and
        # nearly the same, as by the node of a horn; what they lack at the crossing is small.
        beyond = left - sign * lacking
    else:
        beyond = sign * gained - turned + swings * turn
    swings = swings + start[3]
    place, azimuth = point_at(orbit, start[0], swings, sign * t, sign * sine, cosine)
    return beyond, place, azimuth


# ---- loops over geodesics ------------------------------------------------------

PARTS = {**NUMBERS, "ratio": divided, "_add_sines": _in_loops}
# Compiled, these become part of their callers, so that several nodes and terms run at once.
INLINED = "growth", "two_to_bits", "rates", "rates_in_x", "rates_in_y", "gains", "_in_loops"


def trace(torus, given, s):
    """Return points of geodesics.

    Parameters
    ----------
    torus : Torus
        The surface.
    given : (6, n) float
        theta, phi and azimuths at the starts, in rad; phi and azimuths again, reduced to -pi to pi;
        Clairaut's constants over R, or NaN. A start that isn't finite has no answer.
    s : (n, p) float
        Arc lengths from the starts, in m.

    Returns
    -------
    position, azimuth : (n, p, 2) and (n, p) float
        In rad, continued from those given; NaN where there is no answer.
    """
    position, azimuth = np.empty((*s.shape, 2)), np.empty(s.shape)
    compiled.expect(EACH * len(s) + POINT * s.size, KIND)
    ready = compiled.ready(KIND)
    sizes = torus.r / torus.R, torus.R

    def fill(block):
        if ready:
            # Copies in one order that may be written to, so that one compiled form serves all.
            starts, lengths = np.array(given[:, block], order="C"), np.array(s[block], order="C")
            room = rules(True), np.empty((3, MOST_PANELS + 1)), *np.empty((2, 2, TERMS[-1]))
            filled = position[block], azimuth[block]
            compiled.call(follow_each, *sizes, starts, lengths, *room, *filled, **PARTS)
        else:
            starts, lengths = given[:, block].tolist(), s[block].tolist()
            filled = [[[0.0, 0.0] for _ in row] for row in lengths], [row.copy() for row in lengths]
            edges = [[0.0] * (MOST_PANELS + 1) for _ in range(3)]
            room = rules(False), edges, None, [None, None]
            compiled.call_plain(follow_each, *sizes, starts, lengths, *room, *filled, **PLAIN)
            position[block], azimuth[block] = filled

    compiled.each_block(fill, len(s), max(BLOCK // s.shape[1], 1), KIND)
    return position, azimuth


@cache
def rules(ready):
    """Return shares and weights of `gains`, and nodes and matrices of all `SINES`.

    Plain Python takes the former as lists and asks `sine_rule` for the latter.
    """
    shares, weights = rule(2 * PANEL_PAIRS)
    if not ready:
        return [shares.tolist(), weights.tolist()], None, None
    squares = np.zeros((len(TERMS), TERMS[-1]))
    matrices = np.zeros((len(TERMS), TERMS[-1], TERMS[-1]))
    for level, terms in enumerate(TERMS):
        squares[level, :terms], matrix = sine_rule(terms)
        matrices[level, :terms, :terms] = matrix[:, 0]
    return np.stack([shares, weights]), squares, matrices


@loop(inlined=INLINED)
def follow_each(r, R, given, s, rules, edges, values, series, position, azimuths):
    """Fill in points of geodesics, one geodesic after the other.

    Parameters
    ----------
    r, R : float
        r / R of the torus, and R in m.
    given, s
        As of `trace`.
    rules
        As by `rules`.
    edges, values, series
        Room for `tabulate` and `_add_sines`.
    position, azimuths
        Filled with what `trace` returns.
    """
    for i in range(len(s)):
        theta, phi, azimuth = given[0][i], given[1][i], given[2][i]
        near, whither = given[3][i], given[4][i]
        ways = s[i]
        sine, cosine, placed = headed(r, near, whither, given[5][i])
        last = whither + ways[len(ways) - 1] / R
        sound = placed[2] > 0 and last - last == 0  # neither infinite nor not a number
        side = -1.0 if sine < 0 else 1.0
        leaving = sound and sine != 0
        if leaving:
            orbit, start = orbit_of(r, near, placed, side * sine, cosine)
            panels = prepare(orbit, rules, edges, values, series)
            known = panels, rules[0], edges, series
            begun = begun_at(orbit, start, *known)
        for k in range(len(ways)):
            if not sound:
                found = math.nan, math.nan, math.nan
            elif ways[k] == 0:  # the start itself, to its last digit
                found = theta, phi, azimuth
            else:
                # Along a meridian phi grows or falls with the arc; there is no swing to look up.
                along = -ways[k] / R if cosine < 0 else ways[k] / R
                turned, place, direction = 0.0, near + along, whither
                if leaving:
                    turned, place, direction = point_on(orbit, start, begun, ways[k] / R, *known)
                    turned, direction = side * turned, side * direction
                # The whole turns that were taken off are put back.
                found = turned + theta, place + (phi - near), direction + (azimuth - whither)
            position[i][k][0], position[i][k][1], azimuths[i][k] = found
