"""Planes as points: the isotropic model of Laguerre geometry (Envelopes of cones, section 4).

An oriented plane n.x + h = 0 with unit normal n is the point (n1, n2, h)/(n3 + 1); the tangent
planes of a surface become a surface z = f(x, y), those of a cone a conic over a circle.
"""

import numpy as np

from ..arguments import (
    Angles,
    Coordinate,
    Directions,
    Lengths,
    Point,
    Points,
    Reals,
    bounded_array,
    checked,
)
from ..kernels.exact import dot, norm
from .adapted import contact_point, normal
from .functions import Centre, Function, UnitVectors, one_number
from .jet import Jet, derivative, jet_variables

_MOST = 1e60  # greatest size of numbers: products of four over a divisor 1/_MOST stay finite


@checked
def plane_to_point(n: Directions, h: Lengths):
    """Return the points of oriented planes n.x + h = 0 (Eq. 6).

    Parameters
    ----------
    n : (..., 3) float
        Oriented normals, of any length but zero.
    h : (...) float
        Constant terms of the equations, in m times the normal's length.

    Returns
    -------
    point : (..., 3) float
        The first two coordinates are numbers, the third is in m.

    Raises
    ------
    ValueError
        If a normal is zero, or has the direction (0, 0, -1), which has no point, or is so near
        to it that the point's coordinates aren't numbers.

    Examples
    --------
    >>> plane_to_point((0, 0, 1), -3)
    array([ 0. ,  0. , -1.5])
    """
    x, y, z = np.moveaxis(n, -1, 0)
    length = norm(n)
    flat = x * x + y * y
    # |n| + n3 cancels for a normal that points downwards.
    denominator = np.where(z > 0, length + z, flat / (length + np.abs(z)))
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        point = np.stack(np.broadcast_arrays(x, y, h), axis=-1) / denominator[..., None]
    if not np.all(np.isfinite(point)):
        raise ValueError(
            "n: a normal must not have the direction (0, 0, -1), whose planes have no point; "
            "got one that has."
        )
    return point


@checked
def point_to_plane(point: Points):
    """Return the oriented planes n.x + h = 0 of points, the inverse of `plane_to_point`.

    Parameters
    ----------
    point : (..., 3) float
        The first two coordinates are numbers, the third is in m.

    Returns
    -------
    n : (..., 3) float
        Unit normals.
    h : (...) float
        Constant terms, in m.
    """
    x, y, z = np.moveaxis(point, -1, 0)
    n = np.stack(normal(x, y), axis=-1)
    return n, z * (n[..., 2] + 1)


@checked
def sphere_point(centre: Points, radius: Lengths, x: Reals, y: Reals):
    """Return the third coordinate of the paraboloid that stands for a sphere (Eq. 7).

    Parameters
    ----------
    centre : (..., 3) float
        Of the sphere, in m.
    radius : (...) float
        In m, positive where normals point inwards, negative outwards, 0 for the planes through
        a point.
    x, y : (...) float
        Where to evaluate.

    Returns
    -------
    z : (...) float
        In m.
    """
    m1, m2, m3 = np.moveaxis(centre, -1, 0)
    return (radius + m3) / 2 * (x * x + y * y) - m1 * x - m2 * y + (radius - m3) / 2


@checked
def surface_points(f: Function(2), x: Reals, y: Reals):
    """Return points of the surface whose tangent planes lie on a graph (Eq. 20).

    Parameters
    ----------
    f : callable
        A function of two variables, built from ordinary arithmetic, with values in m. What it
        raises itself passes through.
    x, y : (...) float
        Places in the isotropic model.

    Returns
    -------
    points : (..., 3) float
        In m.

    Examples
    --------
    >>> surface_points(lambda x, y: (x * x + y * y + 1) / 2, 0.6, 0.8)  # a sphere about (0, 0, 0)
    array([-0.6, -0.8,  0. ])
    """
    x, y = np.broadcast_arrays(x, y)
    s, t = jet_variables(x, y)
    with np.errstate(all="ignore"):
        jet = one_number("f", f(s, t), s) + 0.0 * s  # a constant is a function, too
        fx = derivative(jet, 1, 0)
        fy = derivative(jet, 0, 1)
        points = np.stack(contact_point(x, y, jet.value, fx, fy), axis=-1)
    if not np.all(np.isfinite(points)):
        raise ValueError("f: must be defined and smooth at every place; got one where it isn't.")
    return points


@checked
def cone_planes(vertex: Points, axis: Directions, half_angle: Angles, azimuth: Angles):
    """Return the tangent planes of cones, as normals and constant terms.

    Parameters
    ----------
    vertex, axis : (..., 3) float
        Vertex in m, and a vector along the axis from the vertex into the cone.
    half_angle : (...) float
        Angle between axis and rulings, in rad.
    azimuth : (...) float
        Which plane, in rad about the axis.

    Returns
    -------
    n : (..., 3) float
        Unit normals that point into the cone.
    h : (...) float
        Constant terms, in m.
    """
    axis = axis / norm(axis)[..., None]
    # A unit vector across the axis, made from the coordinate axis that is farthest from it.
    away = np.eye(3)[np.argmin(np.abs(axis), axis=-1)]
    first = np.cross(axis, away)
    first = first / norm(first)[..., None]
    second = np.cross(axis, first)
    # The normals lean from the axis by the complement of the half-angle.
    round_ = np.cos(azimuth)[..., None] * first + np.sin(azimuth)[..., None] * second
    n = np.sin(half_angle)[..., None] * axis + np.cos(half_angle)[..., None] * round_
    return n, -dot(n, vertex)


@checked
def plane_azimuth(axis: Directions, half_angle: Angles, n: UnitVectors):
    """Return the azimuths at which `cone_planes` gives the normals of planes that touch a cone.

    Parameters
    ----------
    axis : (..., 3) float
        A vector along the axis, from the vertex into the cone.
    half_angle : (...) float
        Angle between axis and rulings, in rad.
    n : (..., 3) float
        Unit normals that point into the cone.

    Returns
    -------
    azimuth : (...) float
        In rad, from -pi to pi.
    """
    right = np.array([0.0, np.pi / 2])
    pair, _ = cone_planes(np.zeros(3), axis[..., None, :], half_angle[..., None], right)
    share = np.sin(half_angle) ** 2  # what the parts along the axis add to each product
    cosine, sine = (dot(pair[..., i, :], n) - share for i in (0, 1))
    return np.arctan2(sine, cosine)


@checked
def cone_rulings(axis: Directions, half_angle: Angles, azimuth: Angles):
    """Return unit vectors along rulings, in the planes that `cone_planes` gives for these.

    Parameters
    ----------
    axis : (..., 3) float
        A vector along the axis, from the vertex into the cone.
    half_angle : (...) float
        Angle between axis and rulings, in rad.
    azimuth : (...) float
        Which ruling, in rad about the axis.

    Returns
    -------
    ruling : (..., 3) float
        From the vertex into the cone.
    """
    axis = axis / norm(axis)[..., None]
    n, _ = cone_planes(np.zeros(3), axis, half_angle, azimuth)
    half_angle = half_angle[..., None]
    # In the plane of axis and normal the ruling is the unit vector at right angles to the normal.
    return (axis - np.sin(half_angle) * n) / np.cos(half_angle)


# ---- conics over circles, which stand for the tangent planes of cones (section 5) ----------------


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
    point, centre, a, b : (3,) float, (2,) float, float, float
        As in `conic`.

    Returns
    -------
    vertex : (3,) float
        In m.

    Raises
    ------
    ValueError
        If the conic stands for a cylinder, where x^2 + y^2 + 1 + 2 u x + 2 v y = 0; if the circle's
        centre is the point itself; or if a number is above 1e60, so that products could overflow.

    Notes
    -----
    By Eq. 7 with radius 0 the planes through a vertex V are the points
    z = V3 (x^2 + y^2 - 1)/2 - V1 x - V2 y. On the circle x^2 + y^2 is linear in x and y. So the
    conic lies in a plane, whose height at the point and whose slopes give V.
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
    # In the conic's plane z rises by b along (u, v) and by a along (v, -u), which is across. These
    # are its slopes along x and y, times u^2 + v^2.
    along_x = a * v + b * u
    along_y = b * v - a * u
    # The terms in a y and a x stand for v along_x - u along_y, which is a (u^2 + v^2).
    vertex = [
        (x * x - y * y - 1) * along_x + 2 * x * y * along_y - 2 * square * (u * z + x * z + a * y),
        (y * y - x * x - 1) * along_y + 2 * x * y * along_x - 2 * square * (v * z + y * z - a * x),
        2 * x * along_x + 2 * y * along_y - 2 * square * z,
    ]
    return np.array(vertex) / (square * weight)
