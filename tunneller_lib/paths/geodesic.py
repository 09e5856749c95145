"""True geodesics of the torus: the inverse problem by quadrature, the direct by integration.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant; that first integral turns the inverse
problem into one equation, and the direct one, which integrates the equations themselves, checks it.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import dot, instance, positions, real
from ..surfaces import Torus
from .geodesic_classes import inner, outer, solve

AGREES = 1e-9  # rad; a turned angle that is off by more is no answer


@dataclass(frozen=True)
class Samples:
    """Points along geodesics, from first to last: made by `geodesic_direct`.

    Parameters
    ----------
    torus : Torus
        The surface.
    s : (..., n) float
        Arc lengths from the start, in m.
    position : (..., n, 2) float
        Joint positions (theta, phi), in rad; theta isn't reduced to one turn.
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
        return self.torus.point(self.position[..., 0], self.position[..., 1])

    @property
    def tangent(self):
        """Return the unit tangents (..., n, 3)."""
        theta, phi = np.moveaxis(self.position, -1, 0)
        up = np.stack(
            [-np.sin(phi) * np.cos(theta), np.cos(phi), np.sin(phi) * np.sin(theta)], axis=-1
        )
        around = np.stack([-np.sin(theta), np.zeros_like(theta), -np.cos(theta)], axis=-1)
        return np.cos(self.azimuth)[..., None] * up + np.sin(self.azimuth)[..., None] * around

    def deviation(self, position):
        """Return how far joint positions (..., m, 2) lie beside the geodesic, as (..., m) in m.

        Measured from the nearest sample, at right angles to the tangent and within the tangent
        plane, positive to the left of the way as seen from outside.
        """
        theta, phi = np.moveaxis(positions("position", position), -1, 0)
        point, samples = self.torus.point(theta, phi), self.point
        square = dot(samples, samples)[..., None, :] - 2 * point @ np.swapaxes(samples, -1, -2)
        near = np.argmin(square, axis=-1)[..., None]
        normal = self.torus.normal(self.position[..., 0], self.position[..., 1])
        across = np.cross(normal, self.tangent)
        gap = point - np.take_along_axis(samples, near, axis=-2)
        return dot(gap, np.take_along_axis(across, near, axis=-2))


@dataclass(frozen=True)
class Geodesic:
    """Shortest geodesics between pairs of points: made by `geodesic_inverse`.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad.
    length : (...) float
        In m; NaN where there is no answer.
    azimuth1, azimuth2 : (...) float
        Directions at p and q, in rad; NaN where the ends coincide or there is no answer.
    clairaut : (...) float
        rho sin(azimuth), in m, the same all along.
    kind : (...) str
        "meridian", "outer", "inner" (over the inner equator of a ring torus), "point" (the ends
        coincide), or "none" where an end isn't on the working sheet or isn't finite.
    converged : (...) bool
        Whether there is an answer; its turned angle is met to 1e-9 rad.
    """

    torus: Torus
    p: np.ndarray
    q: np.ndarray
    length: np.ndarray
    azimuth1: np.ndarray
    azimuth2: np.ndarray
    clairaut: np.ndarray
    kind: np.ndarray
    converged: np.ndarray

    def points(self, n):
        """Return n `Samples` of each geodesic, equally spaced in arc, both ends included."""
        azimuth = np.where(self.kind == "point", 0.0, self.azimuth1)
        return geodesic_direct(self.torus, self.p, azimuth, self.length, n)


def geodesic_inverse(torus, p, q):
    """Return the shortest geodesics between joint positions.

    Parameters
    ----------
    torus : Torus
        The surface: a ring, a horn, or the outer sheet of a spindle.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    geodesic : Geodesic
        Length, azimuths, Clairaut's constant, kind.

    Notes
    -----
    A shortest geodesic turns by at most pi in theta and crosses each of the circles phi = 0 and
    phi = pi at most once. That leaves two classes, and in each the turned angle grows with one
    unknown: a root each, and the shorter one is returned. That it grows was found numerically and
    isn't proved. Ends half a turn apart have a mirror image of the answer beside it. Lengths are
    right to rounding, to 3e-14 of themselves where an end is within 0.1 rad of a node: see
    tests/references for a table of hard ones.

    Examples
    --------
    >>> geodesic = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 0.4))
    >>> round(float(geodesic.length), 12), str(geodesic.kind)
    (0.63, 'meridian')
    """
    instance("torus", torus, Torus)
    p, q = np.broadcast_arrays(positions("p", p), positions("q", q))
    start, stop = _known(p).reshape(-1, 2), _known(q).reshape(-1, 2)
    phi1, phi2 = _reduced(start[:, 1]), _reduced(stop[:, 1])
    turn = _reduced(stop[:, 0] - start[:, 0])
    # The end farther from the outer equator comes first, mirrored to phi >= 0.
    swap = np.abs(phi2) > np.abs(phi1)
    a, b = np.where(swap, (phi2, phi1), (phi1, phi2))
    mirror = np.where(a < 0, -1.0, 1.0)
    a, b, angle = a * mirror, b * mirror, np.abs(turn)

    rho_a, rho_b = torus.r + torus.R * np.cos(a), torus.r + torus.R * np.cos(b)
    on_sheet = (rho_a > 0) & (rho_b > 0) & np.isfinite(angle)
    length, c, cos_a, cos_b = np.full((4, a.size), np.nan)
    kind = np.full(a.size, "none", dtype="<U8")

    def settle(mask, name, *values):
        kind[mask] = name
        for array, value in zip((length, c, cos_a, cos_b), values):
            array[mask] = np.broadcast_to(value, mask.shape)[mask]

    # On one meridian: over the outer equator, or on a ring over the inner one where that's nearer.
    over = (torus.r > torus.R) & (a - b > np.pi)
    direct, heading = np.where(
        over, (2 * np.pi - (a - b), np.ones(a.size)), (a - b, -np.ones(a.size))
    )
    settle(on_sheet & (angle == 0), "meridian", torus.R * direct, 0.0, heading, heading)
    settle(on_sheet & (angle == 0) & (direct == 0), "point", 0.0, 0.0, np.nan, np.nan)
    # The outer equator is shortest up to its conjugate point, the inner one always.
    span, narrow = torus.r + torus.R, torus.r - torus.R
    near_enough = (angle > 0) & (angle <= np.pi * np.sqrt(torus.R / span))
    settle(near_enough & (a == 0), "outer", span * angle, span, 0.0, 0.0)
    both_inside = (angle > 0) & (a == np.pi) & (np.abs(b) == np.pi) & (narrow > 0)
    settle(both_inside, "inner", narrow * angle, narrow, 0.0, 0.0)
    unsettled = on_sheet & (kind == "none")
    for name, family in (("outer", outer), ("inner", inner)):
        possible = unsettled if name == "outer" else unsettled & (b < 0) & (narrow > 0)
        index = np.flatnonzero(possible)
        if not index.size:
            continue
        found = solve(family, torus, a[index], b[index], angle[index])
        shorter = (np.abs(found.turned - angle[index]) <= AGREES) & ~(found.length >= length[index])
        index, found = index[shorter], found.where(shorter)
        length[index], c[index], kind[index] = found.length, found.c, name
        cos_a[index], cos_b[index] = found.cos_a, found.cos_b
    # The way back from the second end, where the ends were exchanged, has the opposite direction.
    back = mirror * np.where(swap, -1.0, 1.0)
    side = np.where(turn < 0, -1.0, 1.0)
    far = np.arctan2(side * c / rho_a, back * cos_a)
    near = np.arctan2(side * c / rho_b, back * cos_b)
    first, second = np.where(swap, (near, far), (far, near))
    answers = (length, first, second, side * c, kind, kind != "none")
    return Geodesic(torus, p, q, *(answer.reshape(p.shape[:-1])[()] for answer in answers))


def geodesic_direct(torus, p, azimuth, length, n=2):
    """Return geodesics of given start, direction and length.

    Parameters
    ----------
    torus : Torus
        The surface.
    p : (..., 2) float
        Joint positions (theta, phi) of the starts, in rad.
    azimuth, length : (...) float
        Directions in rad, lengths in m; they broadcast with p.
    n : int
        Number of samples, equally spaced in arc, both ends included, at least 2.

    Returns
    -------
    samples : Samples
        The last one is the end. NaN where an argument is NaN or a start isn't on the working sheet.

    Raises
    ------
    ValueError
        If n isn't a whole number of at least 2.

    Notes
    -----
    theta' = sin(alpha)/rho, phi' = cos(alpha)/R, alpha' = sin(phi) sin(alpha)/rho in arc length,
    by Dormand and Prince's method of order 8 with all geodesics in one system.
    """
    from scipy.integrate import solve_ivp  # here: it takes longer to load than numpy

    instance("torus", torus, Torus)
    if not isinstance(n, (int, np.integer)) or n < 2:
        raise ValueError(f"n: must be a whole number of at least 2 samples; got {n!r}.")
    p = _known(positions("p", p))
    azimuth, length = _known(real("azimuth", azimuth)), _known(real("length", length))
    theta, phi, azimuth, length = np.broadcast_arrays(p[..., 0], p[..., 1], azimuth, length)
    start = np.stack([theta, phi, azimuth]).reshape(3, -1)
    reach = length.ravel()
    sound = np.isfinite(start.sum(axis=0) + reach) & (torus.r + torus.R * np.cos(start[1]) > 0)

    def rates(_, state):
        _, phi, alpha = state.reshape(3, -1)
        turning = np.sin(alpha) / (torus.r + torus.R * np.cos(phi))
        rate = np.stack([turning, np.cos(alpha) / torus.R, np.sin(phi) * turning])
        return (reach[sound] * rate).ravel()

    steps = np.linspace(0, 1, n)
    track = np.full((3, start.shape[1], n), np.nan)
    if np.any(sound):
        way = solve_ivp(
            rates, (0, 1), start[:, sound].ravel(), "DOP853", steps, rtol=3e-14, atol=1e-15
        )
        track[:, sound] = way.y.reshape(3, -1, n)
    track = track.reshape(3, *theta.shape, n)
    return Samples(torus, length[..., None] * steps, np.stack(track[:2], axis=-1), track[2])


def _known(array):
    """Return an array with NaN in place of infinity, which has no direction either."""
    return np.where(np.isfinite(array), array, np.nan)


def _reduced(angle):
    """Return angles from -pi to pi, untouched where they are there already."""
    return np.where(np.abs(angle) <= np.pi, angle, np.remainder(angle + np.pi, 2 * np.pi) - np.pi)
