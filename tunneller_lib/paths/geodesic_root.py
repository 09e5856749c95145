"""The geodesic of a class between two given ends: a quadrature and Newton's method."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from .geodesic_classes import outer

NODES_OF_WORKING_SHEET = 20  # of the quadrature, where no geodesic comes near a node of the torus

BLOCK = 4096  # pairs at a time, so that the quadrature's arrays stay in the cache
ROUNDS = 100  # Newton's method takes about four; halving a bracket takes sixty
NEAR = 1e-5  # rad
STEP = 1e-8  # relative; what a last step of this size leaves is of the order of its square
ROUNDING = 1e-7  # a scale: steps of STEP times this, 1e-15, are made of rounding

_leggauss = cache(legendre.leggauss)  # an eigenvalue problem each time


class Root(NamedTuple):
    """Geodesics of a class, (n,) each.

    `turned` is the turned angle in rad, `length` in m, `c` Clairaut's constant in m; `cos_a` and
    `cos_b` are the cosines of the azimuths at a and b.
    """

    turned: np.ndarray
    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


def solve(family, torus, a, b, angle, low=None):
    """Return the geodesics of a class whose turned angle is the given one.

    Parameters
    ----------
    family : callable
        `outer`, `inner` or `second`: a function of torus, a, b and the unknown.
    torus : Torus
        The surface.
    a, b : (n,) float
        Angles phi of the ends, in rad, |b| <= a.
    angle : (n,) float
        Turned angles, in rad, above zero.
    low : (n,) float, optional
        Where the unknown starts from if not from the class's least.

    Returns
    -------
    root : Root
        With the turned angle that was reached, to be compared with the given one; NaN where
        Newton's method doesn't settle.
    """
    count = _nodes_for(torus, a, angle)
    starts = range(0, a.size, BLOCK)
    if low is None:
        guess, scale, low = _start(family, torus, a, b, angle)
    else:
        guess = low + 0.25
        scale = np.full_like(low, ROUNDING)
    pairs = np.stack([a, b, angle, guess, scale, low])
    blocks = [_newton(family, torus, *pairs[:, k : k + BLOCK], count) for k in starts]
    return Root(*np.concatenate([np.empty((5, 0)), *blocks], axis=1))


def _nodes_for(torus, a, angle):
    """Return how many nodes the quadrature needs, found by doubling them until nothing changed.

    One number for all geodesics from `a` (n,) that turn by `angle` (n,), in rad.
    """
    if torus.r <= torus.R / 4 and np.all(a <= 1) and np.all(angle <= 2):
        return NODES_OF_WORKING_SHEET
    return 64 if torus.r > torus.R else 96


def integrate(torus, integrand, count):
    """Return the turned angle of geodesics, its rate by the unknown, and the length.

    Parameters
    ----------
    torus : Torus
        The surface.
    integrand : Integrand
        Constants and limits of n geodesics.
    count : int
        Number of nodes of a Gauss-Legendre quadrature.

    Returns
    -------
    turned, rate, length : (n,) float
        In rad, rad and m.

    Notes
    -----
    Near t = 0 the integrands have a peak: where D or rho is zero they have singular points, which
    lie off the real line, the nearer the smaller both are at t = 0. t = a0 sinh(y), with a0 their
    distance, stretches the peak to unit width, however narrow it is.
    """
    nodes, weights = _leggauss(count)
    c, A, B, E, first, span = integrand.at[..., None]
    dc, dA, dB, dE, dfirst, dlast = integrand.rate[..., None]
    # The nearer of D = 0 and rho = 0; where the way begins past the peak, their distance from its
    # beginning. The bounds: zero isn't divided by, and three or more would stretch nothing.
    peak = np.sqrt(np.maximum(np.minimum(A, E + c / (2 * torus.R)), 0) / B)
    a0 = np.clip(np.hypot(peak, np.maximum(first, 0)), 1e-30, 3)
    x = first / a0
    z = (first + span) / a0
    # Far from the turning point arcsinh z - arcsinh x cancels, on a short way nearly all of it:
    # there it is the arcsinh of z sqrt(1 + x^2) - x sqrt(1 + z^2), and that difference the
    # difference of the squares, (z - x)(z + x), over the sum.
    shared = np.where(x > 0, z * np.hypot(1, x) + x * np.hypot(1, z), 1)
    low = np.arcsinh(x)
    width = np.where(x > 0, np.arcsinh(span / a0 * (x + z) / shared), np.arcsinh(z) - low)
    grown = np.exp(low + width * (1 + nodes) / 2)  # one exponential for both sinh and cosh
    t = a0 / 2 * (grown - 1 / grown)
    step = weights * width * a0 / 4 * (grown + 1 / grown)

    def terms(t):
        tan2 = np.tan(t) ** 2  # with AVX-512 numpy has it much faster than the sine
        sin2 = tan2 / (1 + tan2)
        rho = c + 2 * torus.R * (E + B * sin2)
        D = A + B * sin2
        return sin2, rho, D, np.sqrt(2 * torus.R / ((rho + c) * D))

    sin2, rho, D, density = terms(t)
    density *= step
    # The rate of c / (rho sqrt((rho + c) D)) by the unknown, from its logarithm.
    drho = dc + 2 * torus.R * (dE + dB * sin2)
    spread = drho / rho + (drho + dc) / (2 * (rho + c)) + (dA + dB * sin2) / (2 * D)
    rate = np.sum((dc - c * spread) / rho * density, axis=-1)
    for end, speed in ((first + span, dlast), (first, -dfirst)):  # the limits move, too
        _, rho_end, _, density_end = terms(end)
        rate += (speed * c / rho_end * density_end)[..., 0]
    turned = np.sum(c / rho * density, axis=-1)
    length = np.sum(rho * density, axis=-1)
    if integrand.onward is None:
        return turned, rate, length
    onward = integrate(torus, integrand.onward, count)
    return turned + onward[0], rate + onward[1], length + onward[2]


def _newton(family, torus, a, b, angle, u, scale, low, count):
    """Return the rows of a `Root`, each sought from u and within a bracket."""
    high = np.full_like(a, np.inf)
    left = np.arange(a.size)
    found = np.full((5, a.size), np.nan)
    for _ in range(ROUNDS):
        integrand = family(torus, a, b, u)
        turned, rate, length = integrate(torus, integrand, count)
        miss = angle - turned
        # The turned angle grows with u: the sign of the miss says on which side the root is.
        low = np.where(miss > 0, u, low)
        high = np.where(miss < 0, u, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(miss == 0, 0, miss / rate)
        # A step that leaves the bracket, or isn't a number, gives way to halving it; while nothing
        # was too far yet, u doubles.
        sound = (low <= u + step) & (u + step <= high)
        halved = np.where(np.isinf(high), 2 * np.abs(u) + 0.5, (low + high) / 2)
        new = np.where(sound, u + step, halved)
        # The second condition: where nothing turns so far, u grows until any step is small.
        done = sound & (np.abs(step) <= STEP * (np.abs(u) + scale)) & (np.abs(miss) < NEAR)
        if np.any(done):
            end = family(torus, a[done], b[done], new[done])
            # For a given angle the length is stationary in c: what u lacked hardly matters.
            reached = turned + rate * step
            total = length + integrand.at[0] * miss
            found[:, left[done]] = reached[done], total[done], end.at[0], end.cos_a, end.cos_b
            if np.all(done):
                break
        # The others go on without those that are done.
        a, b, angle, u, scale, low, high, left = (
            array[~done] for array in (a, b, angle, new, scale, low, high, left)
        )
    return found


def _start(family, torus, a, b, angle):
    """Return a first guess, the scale of the unknown near zero, and its least value."""
    if family is not outer:
        return np.full_like(a, 0.5), np.zeros_like(a), np.zeros_like(a)
    # The chord's elevation in the tangent plane at a, which is the answer on a sphere. Its part
    # towards growing phi is the meridian's, and what the parallel bends inwards meanwhile.
    rho_a = torus.r + torus.R * np.cos(a)
    rho_b = torus.r + torus.R * np.cos(b)
    up = torus.R * np.sin(b - a) + 2 * rho_b * np.sin(angle / 2) ** 2 * np.sin(a)
    tilt = np.arctan2(up, rho_b * np.abs(np.sin(angle)))
    # x of that azimuth: rho_a - c = 2R x^2 with c = rho_a cos(tilt), 1 - cos as sin^2 / (1 + cos).
    x = np.sin(tilt) * rho_a / np.sqrt(2 * torus.R * rho_a * (1 + np.cos(tilt)))
    X = np.cos(a / 2) if torus.r >= torus.R else np.sqrt(rho_a / (2 * torus.R))
    # From x to u, kept off both ends of the class.
    guess = np.where(x > 0, X * np.arctanh(np.clip(x / X, 0, 0.95)), 0.99 * x)
    guess = np.where(a > 0, guess, X / 2)  # from the outer equator it has to rise somehow
    # Steps are judged against |u| and this scale, lest a root near zero be sought for ever. With
    # b > 0 so large a scale would let them end too early near the inner equator, where roots are
    # small themselves; one that asks for steps of rounding size doesn't.
    scale = np.where(b <= 0, np.sin(a / 2), ROUNDING)
    return guess, scale, -np.sqrt(rho_a / (2 * torus.R))
