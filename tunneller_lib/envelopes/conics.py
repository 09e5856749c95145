"""Conics over circles, which stand for cones among the planes (Envelopes of cones, section 5)."""

import numpy as np

from ..arguments import points, real
from ..exact import norm


def top_circle(axis, half_angle):
    """Return the circle over which the tangent planes of a cone lie (Proposition 6).

    Parameters
    ----------
    axis : (..., 3) float
        A vector along the axis, from the vertex into the cone.
    half_angle : (...) float
        Between axis and rulings, in rad.

    Returns
    -------
    centre : (..., 2) float
        Of the circle, in the top view.
    radius : (...) float
        Of the circle; a number, as the centre's coordinates are.

    Raises
    ------
    ValueError
        If a plane of a cone has the normal (0, 0, -1): then a line takes the circle's place.

    Examples
    --------
    >>> centre, radius = top_circle((0, 0, 2), np.pi / 6)
    >>> float(np.round(radius, 3))
    0.577
    """
    axis, half_angle = points("axis", axis), real("half_angle", half_angle)
    axis = axis / norm(axis)[..., None]
    # The planes' normals n have n.axis = sin(half_angle), with Eq. 21 for n.
    height = axis[..., 2] + np.sin(half_angle)
    if np.any(height == 0):
        raise ValueError("axis: no plane of the cone may have the normal (0, 0, -1); got one.")
    return axis[..., :2] / height[..., None], np.cos(half_angle) / np.abs(height)


def conic(point, centre, a, b, t):
    """Return points of a conic over a circle (Eq. 8).

    Parameters
    ----------
    point : (3,) float
        The conic's point at t = 0.
    centre : (2,) float
        (u, v), from that point to the circle's centre.
    a, b : float
        The third coordinate is z + a sin(t) + b (1 - cos(t)), in m.
    t : (...) float
        Parameter, in rad.

    Returns
    -------
    points : (..., 3) float
        On the conic.
    """
    (x, y, z), (u, v), t = point, centre, real("t", t)
    sin, rise = np.sin(t), 2 * np.sin(t / 2) ** 2
    return np.stack([x + v * sin + u * rise, y - u * sin + v * rise, z + a * sin + b * rise], -1)


def osculating_conic(centre, f):
    """Return z, a, b of the conic over a circle that osculates a graph (Eq. 10).

    Parameters
    ----------
    centre : (2,) float
        (u, v), from the point to the circle's centre.
    f : Jet
        The function, at the one point.

    Returns
    -------
    z, a, b : float
        Coefficients for `conic`, in m.
    """
    u, v = centre
    a = f.derivative(1, 0) * v - f.derivative(0, 1) * u
    b = f.derivative(1, 0) * u + f.derivative(0, 1) * v
    b = b + f.derivative(2, 0) * v**2 - 2 * f.derivative(1, 1) * u * v + f.derivative(0, 2) * u**2
    return f.value, a, b


def cone_vertex(point, centre, a, b):
    """Return the vertex of the cone that a conic stands for (Eq. 22).

    Parameters
    ----------
    point : (3,) float
        The conic's point at t = 0.
    centre : (2,) float
        (u, v), from that point to the circle's centre.
    a, b : float
        As in `conic`, in m.

    Returns
    -------
    vertex : (3,) float
        In m; not finite for a cylinder, where x^2 + y^2 + 1 + 2 u x + 2 v y = 0.
    """
    (x, y, z), (u, v) = point, centre
    square = u * u + v * v
    along, across = a * v + b * u, b * v - a * u
    vertex = [
        (x * x - y * y - 1) * along + 2 * x * y * across - 2 * square * (u * z + x * z + a * y),
        (y * y - x * x - 1) * across + 2 * x * y * along - 2 * square * (v * z + y * z - a * x),
        2 * x * along + 2 * y * across - 2 * square * z,
    ]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.array(vertex) / (square * (x * x + y * y + 1 + 2 * u * x + 2 * v * y))
