"""A jet's derivatives in turning directions: binary forms in the direction, and their size."""

from itertools import pairwise
from math import comb

import numpy as np

from .jet import derivative


def derivative_along(f, angle, e, w=0):
    """Return a jet's derivatives `e` times along e, `w` times along w, at direction angles.

    Parameters
    ----------
    f : Jet
        At n points.
    angle : (n or 1, m) float
        Angles of e = (cos, sin), in rad; w = (-sin, cos) is e turned by a right angle.
    e, w : int
        How often by each; at most 4 together.

    Returns
    -------
    derivative : (n, m) float
        A binary form in e of degree e + w.
    """
    c, s = np.cos(angle), np.sin(angle)
    degree = e + w
    form = [derivative(f, degree - k, k)[:, None] for k in range(degree + 1)]
    # Each way takes one index of the symmetric tensor of derivatives: a degree less is left.
    for x, y in [(c, s)] * e + [(-s, c)] * w:
        form = [x * first + y * second for first, second in pairwise(form)]
    return form[0]


def frobenius(f, degree):
    """Return the Frobenius norms (n,) of a jet's tensors of derivatives of one degree."""
    form = [derivative(f, degree - k, k) for k in range(degree + 1)]
    # As often as a derivative is an entry of the tensor: binomial coefficients.
    weights = np.cumprod([1.0, *((degree - k) / (k + 1) for k in range(degree))])
    return np.sqrt(sum(weight * entry**2 for weight, entry in zip(weights, form, strict=True)))


def frobenius_along(f, angle, width, degree):
    """Return Frobenius norms (n, m) of derivatives by e and by w as long as a width.

    Parameters
    ----------
    f, angle
        As for `derivative_along`.
    width : (n, m) float
        The length of w; with 1 the norm is `frobenius`.
    degree : int
        Of the derivatives, at most 4.

    Returns
    -------
    norm : (n, m) float
        In the unit of the derivatives.
    """
    terms = (
        comb(degree, k) * (width**k * derivative_along(f, angle, degree - k, k)) ** 2
        for k in range(degree + 1)
    )
    return np.sqrt(sum(terms))


def principal(f):
    """Return a Hessian's eigenvalues (n,), low and high, and the low one's direction, 0 to pi."""
    a = derivative(f, 2, 0)
    b = derivative(f, 1, 1)
    c = derivative(f, 0, 2)
    mean = (a + c) / 2
    half = np.hypot((a - c) / 2, b)
    # Half of arctan2(2 b, a - c) is the direction of the high one.
    return mean - half, mean + half, np.arctan2(2 * b, a - c) / 2 + np.pi / 2


def principal_values(f):
    """Return the Hessian's eigenvalues (n, 2), the low one first."""
    return np.stack(principal(f)[:2], axis=-1)
