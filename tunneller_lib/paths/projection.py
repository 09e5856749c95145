"""The tangent-sphere path: a chord projected normally onto the torus (section 3.3)."""

from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from ..arguments import Positions, checked
from ..exact import norm, radius_and_excess
from ..surfaces import Torus
from .bounds import Count, check_on_sheet, check_points
from .quadrature import gauss_rule

ORDER = 48  # samples of the path's speed along a chord
RESOLVED = 1e-9  # largest share of the last terms in the speed's Legendre series


@checked
def project_chord(
    torus: Torus,
    p: Positions,
    q: Positions,
    n: Count,
    *,
    spacing: Literal["chord", "tangent", "arc"] = "chord",
):
    """Return points of the tangent-sphere path between two joint positions.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends P and Q, in rad; they broadcast.
    n : int
        Number of points, both ends included, from 2 to a million, and at most 5 million of all
        paths together.
    spacing : {"chord", "tangent", "arc"}
        Equal steps along the chord, as the document does; equal steps of angle as seen from the
        centre of a sphere through P and Q with the normals' half-angle b, which needs two
        tangents; or equal arcs of the path itself.

    Returns
    -------
    path : (..., n, 2) float
        Joint positions (theta, phi) of the feet of M(t) on the working sheet, in rad.

    Raises
    ------
    ValueError
        If n is below 2 or asks for too many points, `spacing` is another word, or a position isn't
        (theta, phi) or isn't on the working sheet, r + R cos(phi) >= 0. With equal arcs also where
        a chord passes so close to the axis or to the ring circle that its length can't be told.

    Notes
    -----
    Tunnelling robot, sections 3.3 and 3.3.1: "intervals corresponding to a fairly equal
    separation of successive points". The tangent reparametrisation is
    t = (1 + tan(b (2u - 1)) / tan(b)) / 2, exact on a sphere. Where a chord crosses the axis
    or the ring circle its foot jumps, and there is no path.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Torus
    >>> project_chord(Torus(0.1, 0.9), (0, -0.3), (0, 0.3), 3).round(12) + 0.0
    array([[ 0. , -0.3],
           [ 0. ,  0. ],
           [ 0. ,  0.3]])
    """
    check_on_sheet(torus, p, q)
    start, chord = _chord(torus, p, q)
    check_points(n, chord.shape[:-1])
    u = np.linspace(0, 1, n)
    if spacing == "chord":
        t = u
    elif spacing == "tangent":
        # Where both normals are the same, as of a chord without length, equal steps are the limit.
        b = _half_angle(torus, p, q)[..., None]
        tan = np.where(b > 0, np.tan(b), 1)
        t = np.where(b > 0, (1 + np.tan(b * (2 * u - 1)) / tan) / 2, u)
    else:
        t = _equal_arcs(torus, p, q, u)
    t = np.broadcast_to(t, (*chord.shape[:-1], n))
    m = start[..., None, :] + t[..., None] * chord[..., None, :]
    return np.stack(Torus.angles.unchecked(torus, m), axis=-1)


@checked
def projected_length(torus: Torus, p: Positions, q: Positions):
    """Return the length of the tangent-sphere path between joint positions.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    length : (...) float
        In m, to about 1e-9 of itself, to rounding on the reference machine: Gauss-Legendre
        quadrature of the foot's exact speed.

    Raises
    ------
    ValueError
        If an end isn't on the working sheet, or a chord passes so close to the axis or to the
        ring circle, where its foot jumps, that the quadrature doesn't settle.
    """
    check_on_sheet(torus, p, q)
    return _speed_series(torus, p, q)[0]


def _chord(torus, p, q):
    """Return where chords begin (..., 3), and the vectors (..., 3) to their ends."""
    start = Torus.point.unchecked(torus, p[..., 0], p[..., 1])
    return start, Torus.point.unchecked(torus, q[..., 0], q[..., 1]) - start


def _half_angle(torus, p, q):
    """Return half the angle between the normals at the ends."""
    first = Torus.normal.unchecked(torus, p[..., 0], p[..., 1])
    last = Torus.normal.unchecked(torus, q[..., 0], q[..., 1])
    return np.arctan2(norm(last - first), norm(last + first))


def _speed(torus, p, q, t):
    """Return |dN/dt| of the foot N of M(t), from the rates of its two angles."""
    start, chord = _chord(torus, p, q)
    chord = np.broadcast_to(chord, np.broadcast_shapes(start.shape, chord.shape))[..., None, :]
    x, y, z = np.moveaxis(start[..., None, :] + t[..., None] * chord, -1, 0)
    dx, dy, dz = np.moveaxis(chord, -1, 0)
    rho, beyond = radius_and_excess(x, z, torus.r)
    distance = np.hypot(beyond, y)
    turning = (z * dx - x * dz) / rho**2
    swinging = (beyond * dy - y * (x * dx + z * dz) / rho) / distance**2
    parallel = torus.r + torus.R * beyond / distance
    return np.hypot(torus.R * swinging, parallel * turning)


def _speed_series(torus, p, q):
    """Return the Legendre series (ORDER, ...) of the speed in x = 2t - 1, from -1 to 1.

    Its first term is the mean speed over t from 0 to 1, and so the path's length.
    """
    nodes, weights = gauss_rule(ORDER)
    with np.errstate(invalid="ignore", divide="ignore"):  # a chord through the axis or the ring
        speed = _speed(torus, p, q, (1 + nodes) / 2)
    basis = legendre.legvander(nodes, ORDER - 1) * (np.arange(ORDER) + 0.5)
    series = np.moveaxis((speed * weights) @ basis, -1, 0)
    tail = np.max(np.abs(series[-4:]), axis=0)
    settled = tail <= RESOLVED * series[0] + np.finfo(float).tiny  # also for a chord of no length
    if not np.all(settled):
        raise ValueError(
            "p, q: a chord must keep away from the axis and from the ring circle, where its foot "
            "jumps; got one that passes through or close by."
        )
    return series


def _equal_arcs(torus, p, q, u):
    """Return t (..., n) at which the path has run the shares u of its length.

    The speed's series is integrated term by term and inverted by Newton's method, each root kept
    in a bracket.
    """
    series = _speed_series(torus, p, q)
    arc = legendre.legint(series, lbnd=-1)
    wanted = 2 * series[0][..., None] * u
    x = np.broadcast_to(2 * u - 1, wanted.shape)
    low, high = np.full(wanted.shape, -1.0), np.full(wanted.shape, 1.0)
    for _ in range(60):
        left = wanted - _series(x, arc)
        if np.all(np.abs(left) <= 1e-15 * wanted[..., -1:]):
            break
        low, high = np.where(left > 0, x, low), np.where(left < 0, x, high)
        speed = _series(x, series)
        newton = x + left / np.where(speed > 0, speed, 1)
        x = np.where((low <= newton) & (newton <= high), newton, (low + high) / 2)
    return (1 + x) / 2


def _series(x, coefficients):
    return legendre.legval(x, coefficients[..., None], tensor=False)
