"""The direct problem: geodesics of a torus from given starts, directions and lengths.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant, and with it arc length s and turned angle
are integrals over one variable t (`geodesic_root`). The integrands depend on sin^2(t) alone, so
that they repeat after pi: half a swing between turning points, or one round of a ring's tube. And
they repeat backwards from pi/2. So both integrals are wanted from t = 0 to pi/2 only.

Their peak at t = 0 is spread by t = width sinh(y). This range of y is divided into panels of equal
width, and on each panel both integrals are Chebyshev series in x, from -1 to 1. The arc length is
solved for the place, the place tells the rest: a geodesic of any length costs the same time.

Below `followed` lengths are in tube radii, rho = r + cos(phi).

`follow_each` loops over geodesics, in plain Python or compiled, with the same bits.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Angles, Array, Lengths, Positions, checked
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
from .geodesic_root import PI_REST, Radii, distance

ALONG_MERIDIAN = 4e-16  # the sine of an azimuth that is 0 or pi to its last digit
STEEP = 0.1  # a sine below which Clairaut's constant has more digits of it than the azimuth
TERMS = 24  # of the series of a panel
PANEL = 1.2  # greatest width of a panel: the integrands' singular points are pi/2 off the real line
STEP = 1e-8  # of x: Newton's last step leaves an error of the order of its square
NARROWEST = 1e-30  # width of a peak: below it c is r - R to its last digit
WIDEST = 3.0  # the same: a wider peak needs no spreading
MOST_PANELS = 60  # for the narrowest peak, where y goes up to 70

ROUNDS = 30  # Newton's method takes about four
BLOCK = 8192  # points at a time: any number of points needs the same room
EACH, POINT = 7e-5, 1.2e-5  # s in plain Python for a geodesic, and for each of its points
KIND = "points of geodesics"  # of work, for `compiled`
LATE = 0.9  # of the angle from t = 0 to pi/2: a start beyond counts by what is left of it
ROOM = (2, TERMS), (3, MOST_PANELS + 1), (2, MOST_PANELS, TERMS + 1)


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
        return torus_point(self.torus, *self._angles)  # unchecked, for angles may be NaN

    @property
    def tangent(self):
        """Return the unit tangents (..., n, 3)."""
        meridian, parallel = torus_tangents(*self._angles)
        cos = np.cos(self.azimuth)[..., None]
        sin = np.sin(self.azimuth)[..., None]
        return cos * meridian + sin * parallel

    @property
    def _angles(self):
        return self.position[..., 0], self.position[..., 1]

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
        normal = torus_normal(*self._angles)
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
    exp(length / sqrt(R (r - R))) times.

    Examples
    --------
    >>> way = geodesic_direct(Torus(0.1, 0.9), (0, -0.3), 0.0, 0.63)
    >>> way.position[-1].round(12)
    array([0. , 0.4])
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
    theta, phi, azimuth, length = np.broadcast_arrays(p[..., 0], p[..., 1], azimuth, length)
    check_ratio(torus)
    check_points(n, theta.shape)
    s = length[..., None] * _shares(n)
    given = np.empty((6, theta.size))
    given[0], given[1], given[2] = theta.ravel(), phi.ravel(), azimuth.ravel()
    given[3:5] = reduced(given[1:3])
    given[5] = math.nan if clairaut is None else np.ravel(clairaut) / torus.R
    position, azimuth = trace(torus, given, s.reshape(-1, n))
    return GeodesicPoints(torus, s, position.reshape(*s.shape, 2), azimuth.reshape(s.shape))


@lru_cache(4)
def _shares(n):
    """Return n equally spaced shares of a way, from 0 to 1, which may not be written to."""
    shares = np.linspace(0, 1, n)
    shares.flags.writeable = False
    return shares


@checked
def half_swing(torus: Torus, clairaut: Lengths):
    """Return the turned angle and the length of geodesics from one turning point to the next.

    Parameters
    ----------
    torus : Torus
        The surface, r / R from 1e-100 to 1e100.
    clairaut : (...) float
        rho at the turning points, in m, above zero and above r - R, and at most r + R.

    Returns
    -------
    turned, length : (...) float
        In rad and m.

    Raises
    ------
    ValueError
        If such a geodesic doesn't swing, or r / R is out of proportion.

    Notes
    -----
    The turned angle, which the report calls T(c), falls as c grows, from infinity, or from
    pi / sqrt(1 - (r / R)^2) on a spindle, to pi / sqrt(1 + r / R) on the outer equator.

    Examples
    --------
    >>> turned, length = half_swing(Torus(3, 1), 4)
    >>> round(float(turned / np.pi), 12), round(float(length / np.pi), 12)
    (0.5, 2.0)
    >>> half_swing(Torus(3, 1), 2)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: clairaut: must be above 2 m and at most r + R = 4 m, or nothing swings; ...
    """
    check_ratio(torus)
    narrow = max(torus.r - torus.R, 0)
    wide = torus.r + torus.R
    if np.any((clairaut <= narrow) | (clairaut > wide)):
        raise ValueError(
            f"clairaut: must be above {narrow:g} m and at most r + R = {wide:g} m, or nothing "
            f"swings; got {clairaut.min():g} to {clairaut.max():g} m."
        )
    halves = np.empty((2, clairaut.size))
    sines = (clairaut.ravel() / wide).tolist()
    compiled.call_plain(_swing_each, torus.r / torus.R, sines, *_plain_room(), *halves, **PLAIN)
    turned, length = halves.reshape(2, *clairaut.shape)
    return turned, torus.R * length


# ---- orbits ------------------------------------------------------------------


class Orbit(NamedTuple):
    """The constants of a geodesic: rho = c + 2 (E + B sin^2(t)), and D = A + B sin^2(t).

    Lengths are in tube radii: the constants are those of `geodesic_root` for R = 1. The integrands
    have a peak at t = 0, about `width` wide in t. `free` tells whether the geodesic goes round the
    tube; if it swings instead, D is cos^2(phi/2). `panels` is the number of panels, a float, and
    `step` their width in y.
    """

    c: np.ndarray
    A: np.ndarray
    B: np.ndarray
    E: np.ndarray
    width: np.ndarray
    free: np.ndarray
    panels: np.ndarray
    step: np.ndarray


class Start(NamedTuple):
    """Where a geodesic begins on its orbit.

    Parameters
    ----------
    phi : (...) float
        From -pi to pi, in rad.
    rising : (...) float
        1 where phi grows at first, else -1.
    t : (...) float
        From -pi/2 to pi/2, once `begun` times pi is taken off.
    begun : (...) float
        A whole number.
    """

    phi: np.ndarray
    rising: np.ndarray
    t: np.ndarray
    begun: np.ndarray


@cache
def panel_rule():
    """Return nodes as shares of a panel (TERMS,), and a matrix (TERMS, TERMS + 1) for integrals.

    It takes an integrand's values at the nodes to the Chebyshev series of the integral from the
    panel's begin.
    """
    # A value at cos(a), a = (k + 1/2) pi / TERMS, adds 2 cos(j a) / TERMS to term j. The integral
    # of the polynomial T_j is T_(j+1) / (2j + 2) - T_(j-1) / (2j - 2): so to term j of the integral
    # the value adds a difference of cosines, 2 sin(j a) sin(a) / (j TERMS).
    k = np.arange(TERMS)[:, None]
    j = np.arange(1, TERMS + 1)
    turns = (j * (2 * k + 1) + 2 * TERMS) % (4 * TERMS) - 2 * TERMS
    angles = turns * (math.pi / (2 * TERMS))
    pairs = [[sine_cosine(angle) for angle in row] for row in angles.tolist()]
    sines, cosines = np.moveaxis(np.array(pairs), -1, 0)
    series = 2 / TERMS * sines * sines[:, :1] / j
    # Nothing is taken off the last term; what the product above takes off doubles it at the nodes.
    series[:, -1] /= 2
    begin = np.sum(np.where(j % 2, series, -series), axis=1, keepdims=True)
    return (1 + cosines[:, 0]) / 2, np.concatenate([begin, series], axis=1)


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
    """Return the `Orbit` of a geodesic, and its `Start`.

    It begins at phi, from -pi to pi, in rad, where r + cos(phi) is above zero and the rest is
    `placed` as by `headed`, by an azimuth of this sine, above zero, and cosine.
    """
    half_sine, half_cosine, rho = placed
    c = rho * sine
    slope = cosine * square_root(rho / (2 * (1 + sine)))  # its square is (rho - c) / 2
    k2 = half_sine * half_sine + slope * slope
    # 1 - k^2. On a ring it is a difference. Where it is small it is off by some roundings of
    # cos^2(phi/2), which are small for a start near the inner equator; (1 - r + c) / 2 would be off
    # by a rounding of c there. On a spindle or a horn the latter is a sum, which can't cancel.
    rest = half_cosine * half_cosine - slope * slope if r > 1 else (1 - r + c) / 2
    free = rest < 0
    A = larger(abs(rest), NARROWEST * NARROWEST)
    B = 1.0 if free else k2
    E = A if free else 0.0
    # The integrands are singular where D or rho is zero: there sin(t) is i times this width.
    width = within(square_root(ratio(smaller(A, E + c / 2), B)), NARROWEST, WIDEST)
    reach = area_sine(math.pi / 2 / width)
    panels = whole_part(reach / PANEL + 0.5)
    orbit = Orbit(c, A, B, E, width, free, panels, reach / panels)
    upward = -1.0 if cosine < 0 else 1.0
    if free:
        # Round the tube phi falls as pi - 2t, or grows as 2t - pi, until t = pi/2 at the outer
        # equator. A start `beyond` that, at t > pi/2, has t - pi instead, counted back from the
        # next t = 0: near the inner equator t is small and mustn't be a difference near pi/2.
        beyond = -1.0 if -upward * phi < 0 else 1.0
        t = beyond * (((math.pi - abs(phi)) + PI_REST) / 2)
        return orbit, Start(phi, upward, t, (1 - beyond) / 2)
    # Between turning points sin(phi/2) = k cos(t), and the slope is -k sin(t), above zero while phi
    # grows. For phi < 0 t is counted from the lower turning point: from -pi if that is behind the
    # start, from pi if it is ahead. So counted, t makes both formulas change their signs.
    begun = 0.0
    if half_sine < 0:
        begun = -1.0 if slope > 0 else 1.0
    t = arctangent(slope if half_sine < 0 else -slope, abs(half_sine))
    return orbit, Start(phi, upward, t, begun)


def whole_part(x):
    """Return the nearest whole number, as a float."""
    return (x + WHOLE) - WHOLE if abs(x) < 2.0**51 else x  # from 2^52 on all floats are whole


def rates(orbit, y):
    """Return the derivatives of arc length and turned angle by x, at y of a panel."""
    c, A, B, E, width, _, _, step = orbit
    grown = growth(y)
    shrunk = grown / (1 + grown)
    sine, _ = sine_cosine(width * ((grown + shrunk) / 2))
    dt = width * (1 + (grown - shrunk) / 2) * (step / 2)
    sin2 = sine * sine
    rho = c + 2 * (E + B * sin2)
    density = square_root(2 / ((rho + c) * (A + B * sin2))) * dt
    return rho * density, c / rho * density


def series_sum(x, terms):
    """Return the sum of Chebyshev's polynomials of x, from -1 to 1, times `terms`."""
    twice = 2 * x
    b = before = 0.0
    for k in range(TERMS, 0, -1):
        b, before = (terms[k] - before) + twice * b, b
    return (terms[0] - before) + x * b


def solved(wanted, whole, terms):
    """Return the x, from -1 to 1, at which the sum of a series is `wanted`; at 1 it is `whole`."""
    x = 2 * wanted / whole - 1
    for _ in range(ROUNDS):
        # Clenshaw's recurrence gives the sum and its derivative for Newton's step. On a panel the
        # derivative changes so little that the step needs no bracket but the panel.
        twice = 2 * x
        b = before = db = dbefore = 0.0
        for k in range(TERMS, 0, -1):
            db, dbefore = (2 * b - dbefore) + twice * db, db
            b, before = (terms[k] - before) + twice * b, b
        missing = wanted - ((terms[0] - before) + x * b)
        moved = within(x + missing / ((b - dbefore) + x * db), -1.0, 1.0)
        onward = abs(moved - x) > STEP
        x = moved
        if not onward:
            break
    return x


def point_at(orbit, start, swings, y, sign):
    """Return phi and the azimuth, in rad, of a point on an `orbit` with this `start`.

    `swings`, a whole number, counts half swings from t = 0; from there the point is at y, before
    (-1) or behind (1) as `sign` tells.
    """
    grown = growth(y)
    t = sign * orbit.width * ((grown + grown / (1 + grown)) / 2)
    sine, cosine = sine_cosine(t)
    sin2 = sine * sine
    rho = orbit.c + 2 * (orbit.E + orbit.B * sin2)
    # The cosine is sqrt(rho^2 - c^2) / rho. rho - c is 2 (E + B sin^2(t)), no difference.
    slope = square_root(2 * (rho + orbit.c)) / rho
    if orbit.free:
        phi = start.phi + 2 * start.rising * (t - start.t + math.pi * (swings - start.begun))
        onward = start.rising * square_root(orbit.E + sin2)
    else:
        # Half a swing on, phi and the cosine of the azimuth are mirrored.
        across = (1 - 2 * (swings % 2.0)) * square_root(orbit.B)
        phi = 2 * arctangent(across * cosine, square_root(orbit.A + orbit.B * sin2))
        onward = -across * sine
    return phi, arctangent(orbit.c / rho, slope * onward)


def begun_at(orbit, start, count, edges, series):
    """Return the length and the angle of a geodesic from t = 0 to its start, for `point_on`.

    Parameters
    ----------
    orbit, start : Orbit, Start
        As by `orbit_of`.
    count, edges, series
        As filled in by `tabulate`.

    Returns
    -------
    before, turned : float
        Arc length and turned angle from t = 0.
    left : float
        What the turned angle lacks at the start of that at the next crossing of the outer equator.
    crossing : float
        Which crossing that is, in half swings, if `left` has more digits than the angle; else NaN.
    """
    y = area_sine(abs(start.t) / orbit.width) / orbit.step  # panels from t = 0
    panel = min(int(y), count - 1)
    x = 2 * (y - panel) - 1
    sign = -1.0 if start.t < 0 else 1.0
    length = series_sum(x, series[0][panel])
    gained = series_sum(x, series[1][panel])
    before = sign * (edges[0][panel] + length)
    turned = sign * (edges[1][panel] + gained)
    left = sign * (edges[2][panel] - gained)
    return before, turned, left, sign / 2 if abs(turned) > LATE * edges[1][count] else math.nan


def point_on(orbit, start, begun, s, count, edges, series):
    """Return by how much theta has grown, phi and the azimuth, in rad, of the point at s.

    Whole half swings are taken off the arc length from t = 0. What remains, at most half of one to
    either side of t = 0, ends on one panel, whose series is solved for the place.

    Parameters
    ----------
    orbit, start : Orbit, Start
        As by `orbit_of`.
    begun : tuple
        As by `begun_at`.
    s : float
        Arc length from the start.
    count, edges, series
        As filled in by `tabulate`.
    """
    before, turned, left, crossing = begun
    whole = 2 * edges[0][count]  # the length of half a swing, or of a round
    rest = s + before
    swings = whole_part(rest / whole)
    rest = rest - swings * whole
    sign = -1.0 if rest < 0 else 1.0
    size = smaller(abs(rest), edges[0][count])
    panel = 0
    while panel < count - 1 and edges[0][panel + 1] <= size:
        panel += 1
    low = edges[0][panel]
    x = solved(size - low, edges[0][panel + 1] - low, series[0][panel])
    gained = series_sum(x, series[1][panel])
    if swings + sign / 2 == crossing:
        # The start and the point are beside the same crossing. Both turned angles may be great and
        # nearly the same, as by the node of a horn; what they lack at the crossing is small.
        beyond = left - sign * (edges[2][panel] - gained)
    else:
        beyond = sign * (edges[1][panel] + gained) - turned + swings * (2 * edges[1][count])
    y = orbit.step * (panel + (1 + x) / 2)
    place, azimuth = point_at(orbit, start, swings + start.begun, y, sign)
    return beyond, place, azimuth


def tabulate(orbit, shares, integral, values, edges, series):
    """Return the number of an orbit's panels after filling in both integrals on each of them.

    Parameters
    ----------
    orbit : Orbit
        The geodesic's.
    shares, integral, values
        As of `follow_each`.
    edges
        Filled where panels begin and end: the arc length and the turned angle from t = 0, and what
        is left of that angle to t = pi/2.
    series
        Filled with the gains of both integrals on each panel.
    """
    count = int(orbit.panels)
    edges[0][0] = edges[1][0] = edges[2][count] = 0.0
    for panel in range(count):
        length, turned = _add_panel(orbit, panel, shares, integral, values, series)
        edges[0][panel + 1] = edges[0][panel] + length
        edges[1][panel + 1] = edges[1][panel] + turned
        edges[2][panel] = turned
    for panel in range(count - 1, -1, -1):
        edges[2][panel] = edges[2][panel + 1] + edges[2][panel]
    return count


def _add_panel(orbit, panel, shares, integral, values, series):
    """Return both integrals over a panel after filling in their series.

    The terms of a series are sums over the nodes. Numpy adds along an axis that isn't the last one
    node after the other, as the loops of `_in_loops` do; so the bits are the same.
    """
    _, integral = panel_rule()
    values = np.array([rates(orbit, orbit.step * (panel + share)) for share in shares])
    sums = np.add.reduce(integral[:, None] * values[..., None], axis=0)
    series[0][panel], series[1][panel] = sums.tolist()
    return series_sum(1.0, series[0][panel]), series_sum(1.0, series[1][panel])


def _in_loops(orbit, panel, shares, integral, values, series):
    """Return what `_add_panel` does, by loops that are to be compiled; `values` is their room."""
    for k in range(TERMS):
        values[0][k], values[1][k] = rates(orbit, orbit.step * (panel + shares[k]))
    for one in range(2):
        terms = series[one][panel]
        for j in range(TERMS + 1):
            terms[j] = integral[0][j] * values[one][0]
        for k in range(1, TERMS):
            for j in range(TERMS + 1):
                terms[j] += integral[k][j] * values[one][k]
    return series_sum(1.0, series[0][panel]), series_sum(1.0, series[1][panel])


# ---- loops over geodesics ------------------------------------------------------

PARTS = {**NUMBERS, "ratio": divided, "_add_panel": _in_loops}
# Compiled, these become part of their callers, so that several nodes and terms run at once.
INLINED = "growth", "two_to_bits", "rates", "series_sum", "tabulate", "_in_loops"


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
    position = np.empty((*s.shape, 2))
    azimuth = np.empty(s.shape)
    compiled.expect(EACH * len(s) + POINT * s.size, KIND)
    ready = compiled.ready(KIND)

    def fill(block):
        # Copies in one order that may be written to, so that one compiled form serves all calls.
        starts, lengths = np.array(given[:, block], order="C"), np.array(s[block], order="C")
        filled = position[block], azimuth[block]
        sizes = torus.r / torus.R, torus.R
        if ready:
            room = *panel_rule(), *(np.empty(shape) for shape in ROOM)
            compiled.call(follow_each, *sizes, starts, lengths, *room, *filled, **PARTS)
        else:
            lists = starts.tolist(), lengths.tolist()
            compiled.call_plain(follow_each, *sizes, *lists, *_plain_room(), *filled, **PLAIN)

    compiled.each_block(fill, len(s), max(BLOCK // s.shape[1], 1), KIND)
    return position, azimuth


def _plain_room():
    """Return the room that `follow_each` needs in plain Python; there `values` needs none."""
    shares, _ = panel_rule()
    edges = [[0.0] * (MOST_PANELS + 1) for _ in range(3)]
    return shares.tolist(), None, None, edges, [[None] * MOST_PANELS for _ in range(2)]


@loop(inlined=INLINED)
def follow_each(r, R, given, s, shares, integral, values, edges, series, position, azimuths):
    """Fill in points of geodesics, one geodesic after the other.

    Parameters
    ----------
    r, R : float
        r / R of the torus, and R in m.
    given, s
        As of `trace`.
    shares, integral
        The `panel_rule`.
    values, edges, series
        Room of the shapes `ROOM`: for what nodes add to both integrals, what both are where panels
        begin and what is left of the second, and what they gain from there, as series.
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
            count = tabulate(orbit, shares, integral, values, edges, series)
            begun = begun_at(orbit, start, count, edges, series)
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
                    turned, place, direction = point_on(
                        orbit, start, begun, ways[k] / R, count, edges, series
                    )
                    turned = side * turned
                    direction = side * direction
                # The whole turns that were taken off are put back.
                found = turned + theta, place + (phi - near), direction + (azimuth - whither)
            position[i][k][0] = found[0]
            position[i][k][1] = found[1]
            azimuths[i][k] = found[2]


def _swing_each(r, sines, shares, integral, values, edges, series, turned, lengths):
    """Fill in turned angles, and lengths in tube radii, of half swings over the outer equator.

    `sines` are those of the azimuths by which they cross it; the rest is as of `follow_each`.
    """
    for i in range(len(sines)):
        cosine = square_root((1 - sines[i]) * (1 + sines[i]))
        orbit, _ = orbit_of(r, 0.0, (0.0, 1.0, r + 1), sines[i], cosine)
        count = tabulate(orbit, shares, integral, values, edges, series)
        turned[i] = 2 * edges[1][count]
        lengths[i] = 2 * edges[0][count]
