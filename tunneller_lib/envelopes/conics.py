"""Conics over circles, which stand for the tangent planes of cones (Envelopes, section 5)."""

import numpy as np

from ..arguments import Angles, Coordinate, Directions, Point, bounded_array, checked
from ..kernels.exact import norm
from .functions import Centre
from .jet import Jet, derivative

_MOST = 1e60  # size of numbers, of which products of four over a small divisor are numbers


@checked
def top_circle(axis: Directions, half_angle: Angles):
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
    axis = axis / norm(axis)[..., None]
    # The planes' normals n have n.axis = sin(half_angle), with Eq. 21 for n.
    height = axis[..., 2] + np.sin(half_angle)
    if np.any(height == 0):
        raise ValueError("axis: no plane of the cone may have the normal (0, 0, -1); got one.")
    return axis[..., :2] / height[..., None], np.cos(half_angle) / np.abs(height)


@checked
def conic(point: Point, centre: Centre, a: Coordinate, b: Coordinate, t: Angles):
    """Return points of a conic over a circle (Eq. 8).

    Parameters
    ----------
    point : (3,) float
        The conic's point at t = 0, its third coordinate in m.
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
    x, y, z = point
    u, v = centre
    sin = np.sin(t)
    rise = 2 * np.sin(t / 2) ** 2  # 1 - cos(t) would cancel
    return np.stack([x + v * sin + u * rise, y - u * sin + v * rise, z + a * sin + b * rise], -1)


@checked
def osculating_conic(centre: Centre, f: Jet):
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

    Raises
    ------
    ValueError
        If the function is given at more points, or isn't smooth at the one.
    """
    if f.shape != ():
        raise ValueError(f"f: must be a jet at one point; got one at points of shape {f.shape}.")
    bounded_array("f", f.c)
    u, v = centre
    fx = derivative(f, 1, 0)
    fy = derivative(f, 0, 1)
    a = fx * v - fy * u
    b = fx * u + fy * v
    b = b + derivative(f, 2, 0) * v**2
    b = b - 2 * derivative(f, 1, 1) * u * v + derivative(f, 0, 2) * u**2
    return f.value, a, b


@checked
def cone_vertex(point: Point, centre: Centre, a: Coordinate, b: Coordinate):
    """Return the vertex of the cone that a conic stands for (Eq. 22).

    Parameters
    ----------
    point : (3,) float
        The conic's point at t = 0, its third coordinate in m.
    centre : (2,) float
        (u, v), from that point to the circle's centre.
    a, b : float
        As in `conic`, in m.

    Returns
    -------
    vertex : (3,) float
        In m.

    Raises
    ------
    ValueError
        If the conic stands for a cylinder, where x^2 + y^2 + 1 + 2 u x + 2 v y = 0; if the centre
        is the point, or a number so great that products of four aren't numbers.
    """
    x, y, z = point
    u, v = centre
    most = max(map(abs, (x, y, z, u, v, a, b)))
    if most > _MOST:
        raise ValueError(f"point, centre, a, b: must be at most {_MOST:g} in size; got {most:g}.")
    square = u * u + v * v
    if square < 1 / _MOST:
        raise ValueError(f"centre: must not be the point itself, (0, 0); got {centre}.")
    weight = x * x + y * y + 1 + 2 * u * x + 2 * v * y
    if weight == 0:
        raise ValueError("centre: must not be that of a cylinder, which has no vertex; got one.")
    # The conic's slopes a and b belong to the directions across the centre's and towards it;
    # turned into x and y they are these, times u^2 + v^2.
    along = a * v + b * u
    across = b * v - a * u
    vertex = [
        (x * x - y * y - 1) * along + 2 * x * y * across - 2 * square * (u * z + x * z + a * y),
        (y * y - x * x - 1) * across + 2 * x * y * along - 2 * square * (v * z + y * z - a * x),
        2 * x * along + 2 * y * across - 2 * square * z,
    ]
    return np.array(vertex) / (square * weight)
