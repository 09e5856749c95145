"""Developable surfaces made by the tangents of a curve: their planes and osculating cones."""

import numpy as np

from ..arguments import Reals, checked
from ..kernels.exact import dot, norm
from .functions import Function, coordinates
from .jet import derivative, jet_variables

_LEAST = 1e-60
_MOST = 1e60  # in m: products of five derivatives are sound floats


@checked
def curve_derivatives(curve: Function(1), s: Reals):
    """Return a curve's point, velocity, acceleration and third derivative.

    Parameters
    ----------
    curve : callable
        Of its parameter: three coordinates in m, in ordinary arithmetic. What it raises itself
        passes through.
    s : (...) float
        Parameters.

    Returns
    -------
    derivatives : list of four (..., 3) float
        In m, by powers of the parameter's unit.

    Raises
    ------
    ValueError
        If the curve isn't defined and smooth at a parameter, or returns something else.
    """
    s, _ = jet_variables(s, np.zeros(()))
    with np.errstate(all="ignore"):
        r = [c + 0.0 * s for c in coordinates("curve", curve(s), s)]  # a constant is no jet
    found = [np.stack([derivative(c, order, 0) for c in r], axis=-1) for order in range(4)]
    if not np.all(np.abs(found) <= _MOST):
        raise ValueError(
            "curve: must be defined and smooth at every parameter, its derivatives at most "
            f"{_MOST:g} in size; got one where they aren't."
        )
    return found


def _binormal(velocity, acceleration):
    b = np.cross(velocity, acceleration)
    if not np.all((norm(velocity) > _LEAST) & (norm(b) > _LEAST)):
        raise ValueError("curve: must have no point of inflexion among those asked; got one.")
    return b


@checked
def tangent_planes(curve: Function(1), s: Reals):
    """Return the tangent planes of the surface that a curve's tangents make.

    They are the osculating planes of the curve.

    Parameters
    ----------
    curve : callable
        As for `curve_derivatives`, without points of inflexion.
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
        As by `curve_derivatives`, or if one of the points is one of inflexion.

    Examples
    --------
    >>> helix = lambda s: [1e-29 * np.cos(s), 1e-29 * np.sin(s), 1e-29 * s]  # however small
    >>> tangent_planes(helix, 0.0)[0].round(6) + 0.0
    array([ 0.      , -0.707107,  0.707107])
    """
    point, velocity, acceleration, _ = curve_derivatives(curve, s)
    n = _binormal(velocity, acceleration)
    n = n / norm(n)[..., None]
    return n, -dot(n, point)


@checked
def osculating_cone(curve: Function(1), s: Reals):
    """Return the cone that osculates a curve's tangents along one of them.

    Parameters
    ----------
    curve : callable
        As for `curve_derivatives`, without points of inflexion.
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
        As by `curve_derivatives`, or if one of the points is one of inflexion.

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
    point, velocity, acceleration, third = curve_derivatives(curve, s)
    b = _binormal(velocity, acceleration)
    speed = norm(velocity)
    curvature = norm(b) / speed**3
    torsion = dot(b, third) / dot(b, b)
    axis = (torsion / speed)[..., None] * velocity + (curvature / norm(b))[..., None] * b
    return point, axis / norm(axis)[..., None], np.arctan2(curvature, torsion)
