"""Developable surfaces as the tangents of a curve: their planes and osculating cones."""

import numpy as np

from ..arguments import real
from ..exact import dot, norm
from .jet import variables


def derivatives(curve, s):
    """Return a curve's point, velocity, acceleration and third derivative, each (..., 3) float.

    Parameters
    ----------
    curve : callable
        Of its parameter: three coordinates in m, in ordinary arithmetic.
    s : (...) float
        Parameters.
    """
    s = variables(real("s", s), 0.0)[0]
    r = [c + 0.0 * s for c in curve(s)]  # a constant coordinate is no jet
    return [np.stack([c.derivative(order, 0) for c in r], axis=-1) for order in range(4)]


def _binormal(velocity, acceleration):
    b = np.cross(velocity, acceleration)
    if not np.all(norm(b) > 0):
        raise ValueError("curve: must have no point of inflexion among those asked; got one.")
    return b


def tangent_planes(curve, s):
    """Return the tangent planes of the surface that a curve's tangents make.

    They are the osculating planes of the curve.

    Parameters
    ----------
    curve : callable
        As for `derivatives`, without points of inflexion.
    s : (...) float
        Parameters.

    Returns
    -------
    n : (..., 3) float
        Unit normals, along the binormals.
    h : (...) float
        Constant terms, in m.

    Raises
    ------
    ValueError
        If one of the points is one of inflexion.
    """
    point, velocity, acceleration, _ = derivatives(curve, s)
    n = _binormal(velocity, acceleration)
    n = n / norm(n)[..., None]
    return n, -dot(n, point)


def osculating_cone(curve, s):
    """Return the cone that osculates a curve's tangents along one of them.

    Parameters
    ----------
    curve : callable
        As for `derivatives`, without points of inflexion.
    s : (...) float
        Parameters.

    Returns
    -------
    vertex : (..., 3) float
        The curve's point, in m.
    axis : (..., 3) float
        Unit vector, so directed that the surface's tangent planes are oriented as the cone's.
    half_angle : (...) float
        In rad, up to pi: above pi/2 the tangent touches the half that `axis` points away from.

    Raises
    ------
    ValueError
        If one of the points is one of inflexion.

    Notes
    -----
    Envelopes of cones, section 4: second-order contact along the tangent. The axis is the Darboux
    vector, torsion times tangent plus curvature times binormal. Where their ratio is stationary
    the normals keep to the cone's by an order more, but the planes don't: as the curve is regular
    they leave the vertex by curvature times torsion over 6 times the arc's third power.

    Examples
    --------
    >>> _, axis, half_angle = osculating_cone(lambda s: [np.cos(s), np.sin(s), s], 0.3)
    >>> axis.round(12) + 0.0, float(half_angle * 180 / np.pi)
    (array([0., 0., 1.]), 45.0)
    """
    point, velocity, acceleration, third = derivatives(curve, s)
    speed, b = norm(velocity), _binormal(velocity, acceleration)
    curvature, torsion = norm(b) / speed**3, dot(b, third) / dot(b, b)
    axis = (torsion / speed)[..., None] * velocity + (curvature / norm(b))[..., None] * b
    return point, axis / norm(axis)[..., None], np.arctan2(curvature, torsion)
