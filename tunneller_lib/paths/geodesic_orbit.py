"""A geodesic of given start and direction: its orbit, and both integrals along it as series.

With Clairaut's constant c the arc length s and the turned angle are integrals over one variable t
(geodesic_classes). Their integrands depend on sin^2(t) alone: they repeat after half a swing
between turning points, or after one round of a ring's tube, and backwards after half of that. So
both integrals are wanted from t = 0 to pi/2 only, where t = width sinh(y) spreads their peak:
panels of equal width in y have a series each, over x from -1 to 1. Lengths are in tube radii here,
rho = r + cos(phi). All is element by element, for floats, arrays or compiled loops.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, smaller, square_root, where, within
from ..kernels.repeatable import WHOLE, arctangent, area_sine, growth, sine_cosine
from .geodesic_classes import distance
from .geodesic_pair import PI_REST, Radii

TERMS = 24  # of the series of a panel
PANEL = 1.2  # greatest width of a panel: the integrands' singular points are pi/2 off the real line
STEP = 1e-8  # of x: what is left after such a step is of its square
NARROWEST = 1e-30  # of a peak: where c is next to r - R to more digits than it has
WIDEST = 3.0
MOST_PANELS = 60  # for the narrowest peak, about which pi/2 is 70 wide in y


class Heading(NamedTuple):
    """How a geodesic sets out.

    `cosine` is the azimuth's, `rising` is 1 where phi grows at first, else -1; `on_sheet` tells
    where the start is on the working sheet.
    """

    cosine: np.ndarray
    rising: np.ndarray
    on_sheet: np.ndarray


class Orbit(NamedTuple):
    """What stays the same along a geodesic: rho = c + 2 (E + B sin^2(t)).

    D = A + B sin^2(t) is cos^2(phi/2) between turning points, the peak at t = 0 is about `width`
    wide, `free` says who goes round the tube. There are so many `panels`, a float, `step` wide.
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
        From -pi/2 to pi/2, so many whole rounds of pi off.
    begun : (...) float
        These rounds.
    """

    phi: np.ndarray
    rising: np.ndarray
    t: np.ndarray
    begun: np.ndarray


@cache
def panel_rule():
    """Return nodes as shares of a panel (TERMS,), and what series values there make of an integral.

    The nodes are those of Chebyshev's polynomials; (TERMS, TERMS + 1) numbers make the integral
    from the panel's begin as a sum of such.
    """
    # At cos(a), a = (k + 1/2) pi / TERMS, a value adds 2 cos(j a) / TERMS to term j, whose integral
    # adds, over 2j, to the next one, and takes from the one before.
    k = np.arange(TERMS)[:, None]
    j = np.arange(1, TERMS + 1)
    turns = (j * (2 * k + 1) + 2 * TERMS) % (4 * TERMS) - 2 * TERMS
    sines, cosines = sine_cosine(turns * (math.pi / (2 * TERMS)))
    series = 2 / TERMS * sines * sines[:, :1] / j
    series[:, -1] /= 2  # there is no term behind the last
    begin = np.sum(np.where(j % 2, series, -series), axis=1, keepdims=True)
    return (1 + cosines[:, 0]) / 2, np.concatenate([begin, series], axis=1)


def headed(r, phi, azimuth):
    """Return the `Heading` of a geodesic from phi by an azimuth, both in rad, from -pi to pi."""
    _, cosine = sine_cosine(azimuth)
    _, half_cosine = sine_cosine(phi / 2)
    rho = distance(Radii(r, 1.0), phi, half_cosine)
    return Heading(cosine, where(cosine < 0, -1.0, 1.0), rho > 0)


def orbit_of(r, phi, sine, cosine):
    """Return the `Orbit` of a geodesic, and its `Start`.

    From phi, from -pi to pi, in rad, where r + cos(phi) is above zero, by an azimuth of this sine,
    above zero, and cosine.
    """
    half_sine, half_cosine = sine_cosine(phi / 2)
    rho = distance(Radii(r, 1.0), phi, half_cosine)
    c = rho * sine
    slope = cosine * square_root(rho / (2 * (1 + sine)))  # its square is (rho - c) / 2
    k2 = half_sine * half_sine + slope * slope
    # 1 - k^2: on a ring the difference of two numbers that are small where it is; else a sum.
    rest = half_cosine * half_cosine - slope * slope if r > 1 else (1 - r + c) / 2
    free = rest < 0
    A = larger(abs(rest), NARROWEST * NARROWEST)
    B = where(free, 1.0, k2)
    E = where(free, A, 0.0)
    width = within(square_root(ratio(smaller(A, E + c / 2), B)), NARROWEST, WIDEST)
    reach = area_sine(math.pi / 2 / width)
    panels = whole_part(reach / PANEL + 0.5)
    orbit = Orbit(c, A, B, E, width, free, panels, reach / panels)
    # Between turning points sin(phi/2) = k cos(t). Round the tube phi falls as pi - 2t, or grows
    # as its negative.
    rising = where(cosine < 0, -1.0, 1.0)
    falling = -rising * phi
    # Next to where a round begins t is small, and it is no difference of pi and another angle.
    beyond = where(falling < 0, -1.0, 1.0)
    round_tube = beyond * (((math.pi - abs(phi)) + PI_REST) / 2)
    opposed = half_sine < 0
    swing = arctangent(where(opposed, slope, -slope), abs(half_sine))
    half = where(opposed, where(slope > 0, -1.0, 1.0), 0.0)
    begun = where(free, (1 - beyond) / 2, half)
    return orbit, Start(phi, rising, where(free, round_tube, swing), begun)


def whole_part(x):
    """Return the whole number, a float, that is nearest."""
    return where(abs(x) < 2.0**51, (x + WHOLE) - WHOLE, x)  # there are no others farther out


def rates(orbit, y):
    """Return by how much the arc length and the turned angle grow with x at y of a panel."""
    grown = growth(y)
    shrunk = grown / (1 + grown)
    t = orbit.width * ((grown + shrunk) / 2)
    dt = orbit.width * (1 + (grown - shrunk) / 2) * (orbit.step / 2)
    sine, _ = sine_cosine(t)
    rho, _, D = at(orbit, sine)
    density = square_root(2 / ((rho + orbit.c) * D)) * dt
    return rho * density, orbit.c / rho * density


def at(orbit, sine):
    """Return rho, sin^2(t) and D at t of this sine."""
    sin2 = sine * sine
    return orbit.c + 2 * (orbit.E + orbit.B * sin2), sin2, orbit.A + orbit.B * sin2


def panel_place(orbit, t):
    """Return how many panels t, from 0 to pi/2, is from t = 0."""
    return area_sine(t / orbit.width) / orbit.step


def series_sum(x, terms):
    """Return the sum of Chebyshev's polynomials of x, from -1 to 1, times `terms`."""
    twice = 2 * x
    b = 0 * x
    before = 0 * x
    for k in range(TERMS, 0, -1):
        b, before = (terms[k] - before) + twice * b, b
    return (terms[0] - before) + x * b


def nearer(x, wanted, terms):
    """Return the next x of Newton's method for a `wanted` sum of a series, and if it's the last."""
    twice = 2 * x
    b = 0 * x
    before = 0 * x
    db = 0 * x  # their derivatives
    dbefore = 0 * x
    for k in range(TERMS, 0, -1):
        db, dbefore = (2 * b - dbefore) + twice * db, db
        b, before = (terms[k] - before) + twice * b, b
    missing = wanted - ((terms[0] - before) + x * b)
    moved = within(x + missing / ((b - dbefore) + x * db), -1.0, 1.0)
    return moved, abs(moved - x) <= STEP


def point_at(orbit, start, swings, y, sign):
    """Return phi and the azimuth, in rad, of a point on an `orbit` with this `start`.

    It is so many `swings`, a whole number, from t = 0, and then at y, on the side of this `sign`.
    """
    grown = growth(y)
    t = sign * orbit.width * ((grown + grown / (1 + grown)) / 2)
    sine, cosine = sine_cosine(t)
    rho, sin2, D = at(orbit, sine)
    # Half a swing on, phi and the cosine of the azimuth are mirrored.
    side = 1 - 2 * (swings % 2.0)
    across = side * square_root(orbit.B)
    between = 2 * arctangent(across * cosine, square_root(D))
    round_tube = start.phi + 2 * start.rising * (t - start.t + math.pi * (swings - start.begun))
    # rho^2 - c^2 is (rho - c)(rho + c), and rho - c that of the swing, which doesn't cancel.
    slope = square_root(2 * (rho + orbit.c)) / rho
    onward = where(orbit.free, start.rising * square_root(orbit.E + sin2), -across * sine)
    azimuth = arctangent(orbit.c / rho, slope * onward)
    return where(orbit.free, round_tube, between), azimuth
