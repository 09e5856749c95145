"""Geodesics of the torus as they come from either problem, and the direct one by integration.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Angles, Lengths, Positions, Rule, checked, positions
from ..exact import dot
from ..surfaces import Torus
from .bounds import Count, check_points

STEP = 0.08  # tube radii, the longest step of an integration
MANY_TURNS = 30.0  # rad
LONGEST = 200  # tube radii, of a geodesic that is integrated: two seconds


def _rows_of_positions(name, value):
    array = positions(name, value)
    if array.ndim < 2:
        raise ValueError(f"{name}: must be lists (..., m, 2) of positions; got {array.shape}.")
    return array


Ways = Annotated[ArrayLike, Rule("(..., m, 2) float", _rows_of_positions, "rad")]


@dataclass(frozen=True)
class GeodesicPoints:
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
        return Torus.point.unchecked(self.torus, *self._angles)  # which may be NaN

    @property
    def tangent(self):
        """Return the unit tangents (..., n, 3)."""
        meridian, parallel = Torus.tangents.unchecked(self.torus, *self._angles)
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
            In m, from the nearest of the points, at right angles to the tangent and within the
            tangent plane, positive to the left of the way as seen from outside.

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
        point = Torus.point.unchecked(self.torus, theta, phi)
        # Of |P - N|^2 the square of P is the same for all N; a product of matrices does the rest.
        on_way = self.point
        square = dot(on_way, on_way)[..., None, :] - 2 * point @ np.swapaxes(on_way, -1, -2)
        near = np.argmin(square, axis=-1)[..., None]
        normal = Torus.normal.unchecked(self.torus, *self._angles)
        across = np.cross(normal, self.tangent)
        on_way = np.broadcast_to(on_way, (*leading, *on_way.shape[-2:]))
        across = np.broadcast_to(across, on_way.shape)
        gap = point - np.take_along_axis(on_way, near, axis=-2)
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
        coincide), or "none" where an end isn't on the working sheet.
    converged : (...) bool
        Whether there is an answer; its turned angle is met to 1e-9 rad.
    certificate : (...) str
        Why it is the shortest: "meridian", "only" or "first"; empty where there is no answer, and
        of rivals. See `geodesic_inverse`.
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
        return self.certificate != ""

    @checked
    def points(self, n: Count):
        """Return points of each geodesic, equally spaced in arc.

        Parameters
        ----------
        n : int
            Number of points, both ends included, from 2 to a million, and at most 5 million of
            all geodesics together.

        Returns
        -------
        points : GeodesicPoints
            As by `geodesic_direct`; NaN where there is no answer.
        """
        azimuth = np.where(self.kind == "point", 0.0, self.azimuth1)
        return geodesic_direct.unchecked(self.torus, self.p, azimuth, self.length, n)


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
        In m, at most 200 tube radii; a negative one goes backwards.
    n : int
        Number of points, equally spaced in arc, both ends included, from 2 to a million, and at
        most 5 million of all geodesics together.

    Returns
    -------
    points : GeodesicPoints
        The last one is the end. NaN where a start isn't on the working sheet, and for all of them
        where the solver gives up, as it may close by a node. A meridian is followed through a node
        onto the inner sheet.

    Raises
    ------
    ValueError
        If a length is above 200 tube radii, or n isn't a whole number of at least 2.

    Notes
    -----
    theta' = sin(alpha)/rho, phi' = cos(alpha)/R, alpha' = sin(phi) sin(alpha)/rho in arc length,
    by Dormand and Prince's method of order 8 with all geodesics in one system.

    Examples
    --------
    >>> way = geodesic_direct(Torus(0.1, 0.9), (0, -0.3), 0.0, 0.63)
    >>> way.position[-1].round(12)
    array([0. , 0.4])
    """
    from scipy.integrate import solve_ivp  # here: it takes longer to load than numpy

    theta, phi, azimuth, length = np.broadcast_arrays(p[..., 0], p[..., 1], azimuth, length)
    check_points(n, theta.shape)
    start = np.stack([theta, phi, azimuth]).reshape(3, -1)
    # After many turns rounding moves an angle by more than the solver's tolerance, which then takes
    # ever smaller steps: whole turns are taken off first and put back last.
    turned = np.abs(start) > MANY_TURNS
    turns = np.where(turned, start - reduced(start), 0)
    start = np.where(turned, reduced(start), start)
    whole = length.ravel()
    # Geodesics of no answer (`Geodesic.points`) have neither direction nor length.
    sound = np.isfinite(azimuth + length).ravel() & (torus.r + torus.R * np.cos(start[1]) > 0)
    start = start[:, sound]
    whole = whole[sound]
    longest = np.max(np.abs(whole), initial=0)
    if longest > LONGEST * torus.R:
        raise ValueError(
            f"length: must be at most {LONGEST} tube radii, {LONGEST * torus.R:g} m, for it is "
            f"followed in steps of at most {STEP} of them; got {longest:g} m."
        )

    def rates(_, state):
        _, phi, alpha = state.reshape(3, -1)
        turning = np.sin(alpha) / (torus.r + torus.R * np.cos(phi))
        rate = np.stack([turning, np.cos(alpha) / torus.R, np.sin(phi) * turning])
        return (whole * rate).ravel()

    steps = np.linspace(0, 1, n)
    found = np.full((3, sound.size, n), np.nan)
    if np.any(sound):
        # The solver looks at the mean error of all; short steps keep the worst as small.
        step = STEP * torus.R / max(longest, STEP * torus.R)
        way = solve_ivp(
            rates, (0, 1), start.ravel(), "DOP853", steps, rtol=3e-14, atol=1e-15, max_step=step
        )
        if way.success:
            found[:, sound] = way.y.reshape(3, -1, n)
    found = np.where(turned[..., None], found + turns[..., None], found)
    found = found.reshape(3, *theta.shape, n)
    position = np.stack(found[:2], axis=-1)
    return GeodesicPoints(torus, length[..., None] * steps, position, found[2])


def reduced(angle):
    """Return angles from -pi to pi, untouched where they are there already."""
    return np.where(np.abs(angle) <= np.pi, angle, np.remainder(angle + np.pi, 2 * np.pi) - np.pi)
