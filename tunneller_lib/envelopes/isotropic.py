"""Planes as points: the isotropic model of Laguerre geometry (Envelopes of cones, section 4).

An oriented plane n.x + h = 0 with unit normal n is the point (n1, n2, h)/(n3 + 1); the tangent
planes of a surface become a surface z = f(x, y), those of a cone a conic over a circle.
"""

import numpy as np

from ..arguments import points, real
from ..exact import dot, norm
from .jet import variables


def plane_to_point(n, h):
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
        If a normal is zero, or has the direction (0, 0, -1), which has no point.

    Examples
    --------
    >>> plane_to_point((0, 0, 1), -3)
    array([ 0. ,  0. , -1.5])
    """
    n, h = points("n", n), real("h", h)
    x, y, z = np.moveaxis(n, -1, 0)
    # |n| + n3 cancels for a normal that points downwards.
    length, flat = norm(n), x * x + y * y
    denominator = np.where(z > 0, length + z, flat / (length + np.abs(z) + (length == 0)))
    if np.any(denominator == 0):
        raise ValueError("n: a normal must not be zero nor have the direction (0, 0, -1), "
                         "whose planes have no point; got one that is.")  # fmt: skip
    return np.stack(np.broadcast_arrays(x, y, h), axis=-1) / denominator[..., None]


def point_to_plane(point):
    """Return the oriented planes of points: unit normals (..., 3), constant terms (...) in m."""
    x, y, z = np.moveaxis(points("point", point), -1, 0)
    n = np.stack(normal(x, y), axis=-1)
    return n, z * (n[..., 2] + 1)


def normal(x, y):
    """Return the three components of the unit normal over (x, y) (Eq. 21), arrays or jets."""
    p = x * x + y * y + 1
    return 2 * x / p, 2 * y / p, 2 / p - 1


def sphere_point(centre, radius, x, y):
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
    m1, m2, m3 = np.moveaxis(points("centre", centre), -1, 0)
    radius, x, y = real("radius", radius), real("x", x), real("y", y)
    return (radius + m3) / 2 * (x * x + y * y) - m1 * x - m2 * y + (radius - m3) / 2


def contact_point(x, y, f, fx, fy):
    """Return the point where the plane over (x, y) touches the surface of f (Eq. 20).

    Parameters
    ----------
    x, y : float, array or Jet
        Place in the isotropic model.
    f, fx, fy : float, array or Jet
        The function and its first derivatives there, in m.

    Returns
    -------
    r : tuple of three
        Coordinates in m.
    """
    p = x * x + y * y + 1
    # Eqs 18 and 19 for r1 and r2, which says the same as the printed matrix.
    r3 = 2 * (x * fx + y * fy - f) / p
    return x * r3 - fx, y * r3 - fy, r3


def surface_points(f, x, y):
    """Return points of the surface whose tangent planes lie on a graph (Eq. 20).

    Parameters
    ----------
    f : callable
        A function of two variables, built from ordinary arithmetic, with values in m.
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
    s, t = variables(x, y)
    jet = f(s, t) + 0.0 * s  # a constant is a function, too
    first = jet.derivative(1, 0), jet.derivative(0, 1)
    return np.stack(contact_point(*np.broadcast_arrays(x, y), jet.value, *first), axis=-1)


def isotropic_derivatives(r, n):
    """Return x, y, f, fx, fy from points of a surface and unit normals there (Eqs 17 to 19).

    Parameters
    ----------
    r, n : sequence of three float, array or Jet
        Points, in m, and oriented unit normals other than (0, 0, -1).

    Returns
    -------
    x, y, f, fx, fy : float, array or Jet
        The place in the isotropic model, the function there and its derivatives.
    """
    below = n[2] + 1
    x, y = n[0] / below, n[1] / below
    f = -(n[0] * r[0] + n[1] * r[1] + n[2] * r[2]) / below
    return x, y, f, x * r[2] - r[0], y * r[2] - r[1]


def cone_planes(vertex, axis, half_angle, azimuth):
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
    vertex, axis = points("vertex", vertex), points("axis", axis)
    half_angle, azimuth = real("half_angle", half_angle), real("azimuth", azimuth)
    axis = axis / norm(axis)[..., None]
    # A unit vector across: from the coordinate axis that the cone's is farthest from.
    away = np.eye(3)[np.argmin(np.abs(axis), axis=-1)]
    first = np.cross(axis, away)
    first = first / norm(first)[..., None]
    second = np.cross(axis, first)
    round_ = np.cos(azimuth)[..., None] * first + np.sin(azimuth)[..., None] * second
    n = np.sin(half_angle)[..., None] * axis + np.cos(half_angle)[..., None] * round_
    return n, -dot(n, vertex)


def plane_azimuth(axis, half_angle, n):
    """Return azimuths (...), in rad, at which `cone_planes` gives unit normals n (..., 3).

    The axis (..., 3) and the half-angle (...) are as there, and the normals those of planes that
    touch such a cone.
    """
    half_angle, right = real("half_angle", half_angle), np.array([0.0, np.pi / 2])
    pair, _ = cone_planes((0.0, 0.0, 0.0), points("axis", axis)[..., None, :],
                          half_angle[..., None], right)  # fmt: skip
    share = np.sin(half_angle) ** 2  # of the axis in the product of any two normals
    cosine, sine = (dot(pair[..., i, :], points("n", n)) - share for i in (0, 1))
    return np.arctan2(sine, cosine)


def cone_rulings(axis, half_angle, azimuth):
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
    axis = points("axis", axis)
    axis = axis / norm(axis)[..., None]
    n, _ = cone_planes((0.0, 0.0, 0.0), axis, half_angle, azimuth)
    half_angle = real("half_angle", half_angle)[..., None]
    return (axis - np.sin(half_angle) * n) / np.cos(half_angle)
