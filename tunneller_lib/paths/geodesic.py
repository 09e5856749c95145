"""Geodesics of the torus as they come from either problem, and the direct one by integration.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import instance, positions, real
from ..exact import dot
from ..surfaces import Torus

STEP = 0.08  # tube radii, the longest step of an integration


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
        meridian, parallel = self.torus.tangents(self.position[..., 0], self.position[..., 1])
        cos, sin = np.cos(self.azimuth)[..., None], np.sin(self.azimuth)[..., None]
        return cos * meridian + sin * parallel

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
    certificate : (...) str
        Why it is the shortest: "meridian", "curvature", or "compared"; empty where there is no
        answer. See `geodesic_inverse`.
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
    certificate: np.ndarray

    @property
    def certified(self):
        """Return where it is proved that nothing is shorter, as (...) bool."""
        return np.isin(self.certificate, ["meridian", "curvature"])

    def points(self, n):
        """Return n `Samples` of each geodesic, equally spaced in arc, both ends included."""
        azimuth = np.where(self.kind == "point", 0.0, self.azimuth1)
        return geodesic_direct(self.torus, self.p, azimuth, self.length, n)


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
        The last one is the end. NaN where an argument is NaN or a start isn't on the working sheet,
        and for all of them where the solver gives up, as it may close by a node. A meridian is
        followed through a node onto the inner sheet.

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
    p = known(positions("p", p))
    azimuth, length = known(real("azimuth", azimuth)), known(real("length", length))
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
        # The solver looks at the mean error of all; short steps keep the worst as small.
        longest = np.max(np.abs(reach[sound]))
        step = STEP * torus.R / longest if longest > 0 else np.inf
        way = solve_ivp(
            rates, (0, 1), start[:, sound].ravel(), "DOP853", steps,
            rtol=3e-14, atol=1e-15, max_step=step,
        )  # fmt: skip
        if way.success:
            track[:, sound] = way.y.reshape(3, -1, n)
    track = track.reshape(3, *theta.shape, n)
    return Samples(torus, length[..., None] * steps, np.stack(track[:2], axis=-1), track[2])


def known(array):
    """Return an array with NaN in place of infinity, which has no direction either."""
    return np.where(np.isfinite(array), array, np.nan)
