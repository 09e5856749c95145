"""The tangent-sphere path: a chord projected normally onto the torus (section 3.3)."""

import numpy as np
from numpy.polynomial import legendre

from ..arrays import norm, pairs

# Samples of the path's speed along a chord: 1e-12 of the length within usual joint limits, less
# on thin rings whose chord passes close to the ring circle.
ORDER = 48


def project_chord(torus, p, q, n, *, spacing="chord"):
    """Return points of the tangent-sphere path between two joint positions.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends P and Q, in rad; they broadcast.
    n : int
        Number of points, both ends included, at least 2.
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
        If n is below 2, `spacing` is another word or a position isn't (theta, phi).

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
    p, q = pairs("p", p), pairs("q", q)
    if not isinstance(n, (int, np.integer)) or n < 2:
        raise ValueError(f"n: must be a whole number of at least 2 points; got {n!r}.")
    u = np.linspace(0, 1, n)
    if spacing == "chord":
        t = u
    elif spacing == "tangent":
        b = _half_angle(torus, p, q)[..., None]
        tan = np.where(b > 0, np.tan(b), 1)
        t = np.where(b > 0, (1 + np.tan(b * (2 * u - 1)) / tan) / 2, u)
    elif spacing == "arc":
        t = _equal_arcs(torus, p, q, u)
    else:
        raise ValueError(f'spacing: must be "chord", "tangent" or "arc"; got {spacing!r}.')
    start, chord = _chord(torus, p, q)
    t = np.broadcast_to(t, (*chord.shape[:-1], n))
    m = start[..., None, :] + t[..., None] * chord[..., None, :]
    return np.stack(torus.angles(m), axis=-1)


def projected_length(torus, p, q):
    """Return the length (...) of the tangent-sphere path between joint positions, in m.

    Gauss-Legendre quadrature of the foot's exact speed; p and q as in `project_chord`.
    """
    nodes, weights = legendre.leggauss(ORDER)
    return np.sum(weights * _speed(torus, pairs("p", p), pairs("q", q), (1 + nodes) / 2), -1) / 2


def _chord(torus, p, q):
    start = torus.point(p[..., 0], p[..., 1])
    return start, torus.point(q[..., 0], q[..., 1]) - start


def _half_angle(torus, p, q):
    """Return half the angle between the normals at the ends."""
    first = torus.normal(p[..., 0], p[..., 1])
    last = torus.normal(q[..., 0], q[..., 1])
    return np.arctan2(norm(last - first), norm(last + first))


def _speed(torus, p, q, t):
    """Return |dN/dt| of the foot N of M(t), from the rates of its two angles."""
    start, chord = _chord(torus, p, q)
    chord = np.broadcast_to(chord, np.broadcast_shapes(start.shape, chord.shape))[..., None, :]
    m = start[..., None, :] + t[..., None] * chord
    rho = np.hypot(m[..., 0], m[..., 2])
    turning = (m[..., 2] * chord[..., 0] - m[..., 0] * chord[..., 2]) / rho**2
    rho_rate = (m[..., 0] * chord[..., 0] + m[..., 2] * chord[..., 2]) / rho
    beyond = rho - torus.r
    distance = np.hypot(beyond, m[..., 1])
    swinging = (beyond * chord[..., 1] - m[..., 1] * rho_rate) / distance**2
    parallel = torus.r + torus.R * beyond / distance
    return np.hypot(torus.R * swinging, parallel * turning)


def _equal_arcs(torus, p, q, u):
    """Return t (..., n) at which the path has run the shares u of its length, by Newton.

    The speed's Legendre series, fitted at Gauss nodes, is integrated term by term.
    """
    nodes, weights = legendre.leggauss(ORDER)
    speed = _speed(torus, p, q, (1 + nodes) / 2)
    norms = np.arange(ORDER) + 0.5
    series = np.moveaxis((speed * weights) @ legendre.legvander(nodes, ORDER - 1) * norms, -1, 0)
    arc = legendre.legint(series, lbnd=-1)
    length = legendre.legval(1.0, arc)[..., None]
    x = np.broadcast_to(2 * u - 1, (*length.shape[:-1], len(u)))
    for _ in range(8):  # from equal chord steps; quadratic, so the last steps change nothing
        left = u * length - _series(x, arc)
        x = np.clip(x + left / np.where(length > 0, _series(x, series), 1), -1, 1)
    return (1 + x) / 2


def _series(x, coefficients):
    return legendre.legval(x, coefficients[..., None], tensor=False)
