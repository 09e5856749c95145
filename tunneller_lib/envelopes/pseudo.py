"""A surface with a double cone at every point that no cone envelops (Envelopes, Problem 15).

It settles the document's Problem 15: Eqs 9, 11, 12 and 14 hold on all of it, and yet no conic of
that half-angle lies in the graph. The graph in the isotropic model is one of revolution, f = g(r):
the distance r from the origin is a number, and g is in m.
"""

import numpy as np

from ..arguments import LEAST, Coordinate, HalfAngle, checked
from .jet import Jet, series

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)


@checked
def pseudo_envelope(half_angle: HalfAngle, *, offset: Coordinate = 0.0):
    """Return f(x, y) with a double cone at every point that no cone of that half-angle envelops.

    Parameters
    ----------
    half_angle : float
        Of the cones, in rad, between 0 and pi/2.
    offset : float
        Along the normals, in m. Without it the surface's principal radii are 1 m and -1 m at
        half the distance from the origin at which it ends.

    Returns
    -------
    f : callable
        Of x and y, numbers or jets; in m. It raises ValueError where numbers don't lie between
        the origin and the circle of radius tan(pi/4 - half_angle/2); jets aren't finite there.

    Notes
    -----
    Let a be the angle of e from the radius. The form of Eq. 11, which Eq. 13 writes in another
    variable, is then cos(a) (sin(a) - root)^2 times a factor, see `double_root`. Here

        (g'/r)' = r^-2 (C c + W)^(3/2) (c + W)^(-3/(2 C))

    up to a factor, with C = cos(half_angle), c = (1 - r^2)/(1 + r^2), W^2 = c^2 + C^2 - 1. A
    constant or a multiple of r^2 added to g only shifts the surface along its axis and offsets it.

    Examples
    --------
    >>> f = pseudo_envelope(np.radians(20))
    >>> float(np.round(f(0.2, 0.15), 6))
    -0.982232
    >>> f(np.tan(np.pi / 4 - np.radians(20) / 2), 0.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: x, y: must lie between the origin and the circle of radius 0.700208; got ...
    """
    end = np.tan(np.pi / 4 - half_angle / 2)

    def f(x, y):
        square = x * x + y * y
        r = np.sqrt(square)
        moved = offset * (square + 1) / 2
        if isinstance(r, Jet):
            with np.errstate(all="ignore"):
                return series(r, _taylor(half_angle, r.value)) - moved
        if not np.all((LEAST < r) & (r < end)):
            raise ValueError(
                f"x, y: must lie between the origin and the circle of radius {end:g}; got one "
                "that doesn't."
            )
        return _taylor(half_angle, r)[0] - moved

    return f


def double_root(half_angle, r):
    """Return root = sin(a) of the double cones at r: root + 1/root = (1/r - r)/tan(half_angle)."""
    tau = np.tan(half_angle)
    s = (1 - r) * (1 + r) / r
    # The lesser of two solutions, in the form that doesn't subtract two nearly equal numbers.
    return 2 * tau / (s + np.sqrt((s - 2 * tau) * (s + 2 * tau)))


def _bend(half_angle, r):
    """Return (g'/r)', up to its factor."""
    C = np.cos(half_angle)
    S = np.sin(half_angle)
    c = (1 - r) * (1 + r) / (1 + r * r)
    W = np.sqrt((c - S) * (c + S))
    return (C * c + W) ** 1.5 * (c + W) ** (-1.5 / C) / (r * r)


def _middle(half_angle):
    """Return half the distance r at which the surface ends."""
    return np.tan(np.pi / 4 - half_angle / 2) / 2


def _integrals(half_angle, r):
    """Return the integrals of (g'/r)' and of r^2 (g'/r)' from the middle, up to the factor.

    With 2 r/(1 + r^2) = C sin(psi) the root W is C cos(psi), so that the integrand is smooth at
    the surface's end. The variable log(tan(psi/2)) removes the pole at the origin, and 40 nodes of
    Gauss's rule give all but the last one or two digits.
    """
    C = np.cos(half_angle)

    def place(r):
        sine = np.minimum(2 * r / (1 + r * r) / C, 1.0)
        return np.log(sine / (1 + np.sqrt((1 - sine) * (1 + sine))))

    start = place(_middle(half_angle))
    half = ((place(r) - start) / 2)[..., None]
    tangent = np.exp(start + half * (1 + _NODES))
    sine = 2 * tangent / (1 + tangent**2)
    cosine = (1 - tangent) * (1 + tangent) / (1 + tangent**2)
    c = np.sqrt((1 - C * sine) * (1 + C * sine))
    r = C * sine / (1 + c)
    step = (1 + r * r) / 2 * C * cosine * sine / c  # dr by the logarithm
    piece = _bend(half_angle, r) * step * half * _WEIGHTS
    return piece.sum(axis=-1), (r * r * piece).sum(axis=-1)


def _taylor(half_angle, r):
    """Return the six Taylor coefficients of g to order 5 at distances r (...), in m."""
    r = np.asarray(r)
    middle = _middle(half_angle)
    # With y = g'/r, whose derivative is `_bend` times a factor, y is one integral and g, by parts,
    # another, both from the middle. There y is 0 and the principal radii are g and g + p r y'/2:
    # with g = -1 m the factor makes them -1 m and 1 m.
    factor = 4 / ((1 + middle**2) * middle * _bend(half_angle, middle))
    first, second = _integrals(half_angle, r)
    y = factor * first  # g'/r
    g = -1 + (r * r * y - factor * second) / 2
    # Further derivatives take no integrals: that of `_bend` is L times itself, so y'' = L y'. L
    # holds the root, whose derivatives follow from root + 1/root = (1/r - r)/tau.
    tau = np.tan(half_angle)
    p = 1 + r * r
    root = double_root(half_angle, r)
    root1 = p * root**2 / (tau * r * r * (1 - root) * (1 + root))
    L = 3 * tau * root / p - 2 / r
    root2 = 2 * (root1**2 / root - root**2 / (tau * r**3)) / ((1 - root) * (1 + root))
    by_p = root1 * p - 2 * r * root  # p^2 times the derivative of root/p
    dL = 3 * tau * by_p / p**2 + 2 / r**2
    ddL = 3 * tau * (p * (root2 * p - 2 * root) - 4 * r * by_p) / p**3 - 4 / r**3
    # y's derivatives, each from the one before; then g's from g' = r y, over the factorials.
    y1 = factor * _bend(half_angle, r)
    y2 = L * y1
    y3 = (dL + L * L) * y1
    y4 = (ddL + 3 * L * dL + L**3) * y1
    fourth = (3 * y2 + r * y3) / 24
    fifth = (4 * y3 + r * y4) / 120
    return [g, r * y, (y + r * y1) / 2, (2 * y1 + r * y2) / 6, fourth, fifth]
