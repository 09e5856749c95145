"""Points along geodesics of given starts and directions, by quadrature, however long they are.

With Clairaut's constant c the arc length s and the turned angle are integrals over one variable t
(geodesic_classes). Their integrands depend on sin^2(t) alone: they repeat after half a swing
between turning points, or after one round of a ring's tube, and backwards after half of that. So
both integrals are tabulated from t = 0 to pi/2, as series; s is solved for t, and t tells the rest.
Lengths are in tube radii here, rho = r/R + cos(phi).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.polynomial.legendre import legval

from ..arguments import Lengths, checked
from ..surfaces import Torus
from .bounds import check_ratio

TERMS = 24  # of the series of a panel
PANEL = 1.2  # greatest width of a panel: the integrands' singular points are pi/2 off the real line
ROUNDS = 30  # Newton's method takes about four
BLOCK = 40000
NARROWEST = 1e-30  # of a peak: where c is next to r - R to more digits than it has


class _Orbit(NamedTuple):
    """What stays the same along geodesics, each (n, 1): rho = c + 2 (E + B sin^2(t)).

    D = A + B sin^2(t) is cos^2(phi/2) between turning points, the peak at t = 0 is about `width`
    wide, and `free` says who goes round the tube.
    """

    c: np.ndarray
    A: np.ndarray
    B: np.ndarray
    E: np.ndarray
    width: np.ndarray
    free: np.ndarray

    def at(self, t):
        """Return rho, sin^2(t) and D."""
        sin2 = np.sin(t) ** 2
        return self.c + 2 * (self.E + self.B * sin2), sin2, self.A + self.B * sin2

    def rates(self, t):
        """Return by how much s and the turned angle grow with t."""
        rho, _, D = self.at(t)
        density = np.sqrt(2 / ((rho + self.c) * D))
        return rho * density, self.c / rho * density


class _Table(NamedTuple):
    """Arc length and turned angle from t = 0 to pi/2, over t = width sinh(y).

    `step` (n, 1) is the width of a panel in y, `edges` (2, n, m + 1) what both integrals are where
    panels begin and end, `series` (2, TERMS + 1, n, m) Legendre series of what each panel adds.
    """

    step: np.ndarray
    edges: np.ndarray
    series: np.ndarray

    def within(self, panel):
        """Return what both integrals are (2, n, p) where panels begin, and their series there."""
        row = np.arange(len(panel))[:, None]
        return self.edges[:, row, panel], self.series[:, :, row, panel]


@checked
def half_swing(torus: Torus, clairaut: Lengths):
    """Return what geodesics turn, and how long they are, from one turning point to the next.

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
    """
    check_ratio(torus)
    narrow = max(torus.r - torus.R, 0)
    wide = torus.r + torus.R
    if np.any((clairaut <= narrow) | (clairaut > wide)):
        raise ValueError(
            f"clairaut: must be above {narrow:g} m and at most r + R = {wide:g} m, or nothing "
            f"swings; got {clairaut.min():g} to {clairaut.max():g} m."
        )
    sine = clairaut.reshape(-1, 1) / wide
    orbit, _ = _orbit(torus.r / torus.R, 0 * sine, sine, np.sqrt((1 - sine) * (1 + sine)))
    length, turned = 2 * _tabulate(orbit).edges[:, :, -1].reshape(2, *clairaut.shape)
    return turned, torus.R * length


def trace(ratio, phi, sine, cosine, s):
    """Return points of geodesics that leave the meridian.

    Parameters
    ----------
    ratio : float
        r / R.
    phi : (n,) float
        Angles of the starts, from -pi to pi, in rad, with ratio + cos(phi) > 0.
    sine, cosine : (n,) float
        Of the azimuths at the starts, the sine above zero.
    s : (n, p) float
        Arc lengths from the starts, over the radius of the tube.

    Returns
    -------
    turned, phi, azimuth : (n, p) float
        The turned angle, phi counted on round the tube, and the azimuth from 0 to pi, in rad.
    """
    found = np.empty((3, *s.shape))
    rows = max(BLOCK // s.shape[1], 1)
    for first in range(0, len(s), rows):
        block = slice(first, first + rows)
        start = (values[block, None] for values in (phi, sine, cosine))
        found[:, block] = _trace(ratio, *start, s[block])
    return found


def _trace(ratio, phi, sine, cosine, s):
    orbit, t = _orbit(ratio, phi, sine, cosine)
    table = _tabulate(orbit)
    whole, turn = 2 * table.edges[:, :, -1:]  # of half a swing, or of a round
    begun = np.round(t / np.pi)
    t -= np.pi * begun
    before, turned = _integrals(orbit, table, t)
    rest = s + before
    swings = np.round(rest / whole)
    there, beyond = _solve(orbit, table, rest - swings * whole)
    turned = beyond - turned + swings * turn
    swings += begun
    # Half a swing on, phi and the cosine of the azimuth are mirrored.
    side = 1 - 2 * np.mod(swings, 2)
    rho, sin2, D = orbit.at(there)
    between = 2 * np.arctan2(side * np.sqrt(orbit.B) * np.cos(there), np.sqrt(D))
    rising = np.copysign(1, cosine)
    round_tube = phi + 2 * rising * (there - t + np.pi * (swings - begun))
    # rho^2 - c^2 is (rho - c)(rho + c), and rho - c that of the swing, which doesn't cancel.
    slope = np.sqrt(2 * (rho + orbit.c)) / rho
    cosine = np.where(
        orbit.free,
        rising * slope * np.sqrt(orbit.E + sin2),
        -side * slope * np.sqrt(orbit.B) * np.sin(there),
    )
    azimuth = np.arctan2(orbit.c / rho, cosine)
    return turned, np.where(orbit.free, round_tube, between), azimuth


def _orbit(ratio, phi, sine, cosine):
    """Return the orbits of geodesics, and t (n, 1) of their starts."""
    rho = ratio + np.cos(phi)
    c = rho * sine
    slope = cosine * np.sqrt(rho / (2 * (1 + sine)))  # its square is (rho - c) / 2
    k2 = np.sin(phi / 2) ** 2 + slope**2
    # 1 - k^2: on a ring the difference of two numbers that are small where it is; else a sum.
    rest = np.cos(phi / 2) ** 2 - slope**2 if ratio > 1 else (1 - ratio + c) / 2
    free = rest < 0
    A = np.maximum(np.abs(rest), NARROWEST**2)
    B = np.where(free, 1, k2)
    E = np.where(free, A, 0)
    with np.errstate(divide="ignore"):
        width = np.clip(np.sqrt(np.minimum(A, E + c / 2) / B), NARROWEST, 3)
    # Between turning points sin(phi/2) = k cos(t). Round the tube phi falls as pi - 2t, or grows
    # as its negative.
    falling = -np.copysign(1, cosine) * phi
    t = np.where(free, (np.pi - falling) / 2, np.arctan2(-slope, np.sin(phi / 2)))
    return _Orbit(c, A, B, E, width, free), t


@cache
def _rule():
    """Return Gauss's nodes (TERMS,), and what makes of values there the integral's series."""
    nodes, weights = legendre.leggauss(TERMS)
    values = legendre.legvander(nodes, TERMS - 1)
    series = values.T * weights * (np.arange(TERMS)[:, None] + 0.5)
    return nodes, legendre.legint(series, lbnd=-1, axis=0)


def _tabulate(orbit):
    nodes, integral = _rule()
    reach = np.arcsinh(np.pi / 2 / orbit.width)
    panels = int(np.ceil(np.max(reach, initial=PANEL) / PANEL))  # one at least, also of none
    step = reach / panels
    y = step * (np.arange(panels)[:, None] + (1 + nodes) / 2).ravel()
    rates = np.stack(orbit.rates(orbit.width * np.sinh(y)))
    rates *= step / 2 * orbit.width * np.cosh(y)
    series = rates.reshape(2, len(y), panels, TERMS) @ integral.T
    edges = np.cumsum(np.sum(series, axis=-1), axis=-1)  # every Legendre polynomial is 1 at 1
    edges = np.concatenate([np.zeros_like(edges[..., :1]), edges], axis=-1)
    return _Table(step, edges, np.ascontiguousarray(np.moveaxis(series, -1, 1)))


def _integrals(orbit, table, t):
    """Return s and the turned angle (2, n, p) from 0 to t, from -pi/2 to pi/2."""
    y = np.arcsinh(np.abs(t) / orbit.width) / table.step
    panel = np.minimum(y.astype(int), table.series.shape[3] - 1)
    begun, series = table.within(panel)
    x = 2 * (y - panel) - 1
    return np.copysign(begun + [legval(x, one, tensor=False) for one in series], t)


def _solve(orbit, table, s):
    """Return t and the turned angle (n, p) where the arc length from t = 0 is s."""
    edges = table.edges[0]
    size = np.minimum(np.abs(s), edges[:, -1:])
    panel = np.sum(edges[:, 1:-1, None] <= size[:, None], axis=1)
    begun, series = table.within(panel)
    wanted = size - begun[0]
    x = 2 * wanted / legval(1.0, series[0], tensor=False) - 1
    for _ in range(ROUNDS):
        t = orbit.width * np.sinh(table.step * (panel + (1 + x) / 2))
        # dt/dy is the root of width^2 + t^2.
        rate = orbit.rates(t)[0] * np.hypot(orbit.width, t) * table.step / 2
        missing = wanted - legval(x, series[0], tensor=False)
        moved = np.clip(x + missing / rate, -1, 1)
        done = np.max(np.abs(moved - x), initial=0) <= 1e-8  # what is left is of its square
        x = moved
        if done:
            break
    t = orbit.width * np.sinh(table.step * (panel + (1 + x) / 2))
    turned = begun[1] + legval(x, series[1], tensor=False)
    return np.copysign(t, s), np.copysign(turned, s)
