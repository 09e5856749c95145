"""Geodesics of the torus as they come from either problem, and the direct one.

Azimuths count from growing phi towards growing theta. Along a geodesic Clairaut's
c = rho sin(azimuth), rho = r + R cos(phi), is constant.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Angles, Lengths, Positions, Rule, checked, positions
from ..kernels.exact import dot
from ..kernels.repeatable import reduced, sine_cosine
from ..surfaces import Torus
from .bounds import Count, check_points, check_ratio
from .geodesic_pair import CERTIFICATES, INNER, KINDS, NONE, POINT, rho, turn_and_ends
from .geodesic_trace import trace

ALONG_MERIDIAN = 4e-16  # a sine of an azimuth: how far the nearest number may be from pi
STEEP = 0.1  # the same: below, Clairaut's constant tells more digits of it than an azimuth near pi


def _rows_of_positions(name, value):
    array = positions(name, value)
    if array.ndim < 2:
        raise ValueError(f"{name}: must be lists (..., m, 2) of positions; got {array.shape}.")
    return array


Ways = Annotated[ArrayLike, Rule("(..., m, 2) float", _rows_of_positions, "rad")]


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


@dataclass(frozen=True, eq=False)
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
    kind_code, certificate_code : (...) uint8
        What `kind` and `certificate` say in words.
    """

    torus: Torus
    p: np.ndarray
    q: np.ndarray
    length: np.ndarray
    azimuth1: np.ndarray
    azimuth2: np.ndarray
    clairaut: np.ndarray
    kind_code: np.ndarray
    certificate_code: np.ndarray

    @property
    def kind(self):
        """Return kinds as (...) str.

        "meridian", "outer", "inner" (over the inner equator of a ring torus, or through the node
        of a horn), "point" (the ends coincide), or "none" where an end isn't on the working sheet.
        """
        return KINDS[self.kind_code]

    @property
    def certificate(self):
        """Return why each is the shortest, as (...) str: see `geodesic_inverse`.

        "meridian", "only" or "first"; empty where there is no answer, and of rivals.
        """
        return CERTIFICATES[self.certificate_code]

    @property
    def converged(self):
        """Return where there is an answer, whose turned angle is met to 1e-9 rad, as (...) bool."""
        return self.kind_code != NONE

    @property
    def certified(self):
        """Return where it is proved that nothing is shorter, as (...) bool."""
        return self.certificate_code != 0

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
            As by `geodesic_direct`; NaN where there is no answer. On a ring that is nearly a horn,
            or very wide, geodesics by the inner equator part so fast that the last point lies
            beside q: by 3e-7 m on Torus(1 + 1e-7, 1), by 0.01 m on r = 100 R. The length holds.
        """
        azimuth = np.where(self.kind_code == POINT, 0.0, self.azimuth1)
        way = _followed(self.torus, self.p, azimuth, self.length, n, self.clairaut)
        if self.torus.r == self.torus.R:
            # Through the node of a horn, where the meridians of both ends meet.
            turn, phi, _ = turn_and_ends(self.p, self.q).T.reshape(3, *self.p.shape[:-1], 1)
            passed = way.s > self.torus.R * (np.pi - abs(phi))
            through = (self.kind_code == INNER)[..., None] & passed
            way.position[..., 0] += np.where(through, turn, 0.0)
        return way


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
        The last one is the end. NaN where a start isn't on the working sheet. A meridian, to the
        last digit of its azimuth, is followed through a node onto the inner sheet; any other
        geodesic turns before the node.

    Raises
    ------
    ValueError
        If r / R isn't from 1e-100 to 1e100, or n isn't a whole number of at least 2.

    Notes
    -----
    theta' = sin(alpha)/rho, phi' = cos(alpha)/R, alpha' = sin(phi) sin(alpha)/rho in arc length.
    Clairaut's constant turns them into quadratures (`geodesic_trace`), which repeat after half a
    swing or a round of the tube: a geodesic of any length takes as long as a short one. Angles are
    right to some roundings, and to one of length / sqrt(R (r + R)), for what a last digit of the
    start moves grows along the way; near the inner equator of a ring, where neighbours part, that
    is exp(length / sqrt(R (r - R))) times as much.

    Examples
    --------
    >>> way = geodesic_direct(Torus(0.1, 0.9), (0, -0.3), 0.0, 0.63)
    >>> way.position[-1].round(12)
    array([0. , 0.4])
    """
    return _followed(torus, p, azimuth, length, n)


def _followed(torus, p, azimuth, length, n, clairaut=None):
    """Return points of geodesics as `geodesic_direct` does.

    With `clairaut`, rho times the sine of the azimuth, for each, it follows ways that a node parts
    from the meridian, however near they are to it.
    """
    theta, phi, azimuth, length = np.broadcast_arrays(p[..., 0], p[..., 1], azimuth, length)
    check_ratio(torus)
    check_points(n, theta.shape)
    s = length[..., None] * np.linspace(0, 1, n)
    given = np.stack([theta, phi, azimuth]).reshape(3, -1, 1)
    near = reduced(given[1:, :, 0])
    sine, _ = sine_cosine(near[1])
    if clairaut is None:
        sine = np.where(abs(sine) <= ALONG_MERIDIAN, 0.0, sine)
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            steep = np.ravel(clairaut) / rho(torus, near[0])
        sine = np.where(abs(sine) <= STEEP, steep, sine)
    found = trace(torus.r / torus.R, np.stack([*near, sine]), s.reshape(-1, n) / torus.R)
    # Whole turns were taken off, and are put back.
    found[0] += given[0]
    found[1:] += given[1:] - near[..., None]
    begins = (s.reshape(-1, n) == 0) & np.isfinite(found)
    theta, phi, azimuth = np.where(begins, given, found).reshape(3, *s.shape)
    return GeodesicPoints(torus, s, np.stack([theta, phi], axis=-1), azimuth)
