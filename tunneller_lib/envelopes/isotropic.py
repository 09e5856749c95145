"""Planes as points: the isotropic model of Laguerre geometry (Envelopes of cones, section 4).

An oriented plane n.x + h = 0 with unit normal n is the point (n1, n2, h)/(n3 + 1); the tangent
planes of a surface become a surface z = f(x, y), those of a cone a conic over a circle.
"""

import numpy as np

from ..arguments import Angles, Directions, Lengths, Points, Reals, checked
from ..kernels.exact import dot, norm
from .functions import Function, UnitVectors, one_number
from .graph_forms import contact_point, normal
from .jet import derivative, jet_variables


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
    """Return the oriented planes n.x + h = 0 of points, what `plane_to_point` undoes.

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
    # A unit vector across: from the coordinate axis that the cone's is farthest from.
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
    """Return at which azimuths `cone_planes` gives the normals of planes that touch a cone.

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
    share = np.sin(half_angle) ** 2  # of the axis in the product of any two normals
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
