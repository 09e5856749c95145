"""The document's equations as they stand, for a graph z = f(x, y) in the isotropic model.

They are left sides of "= 0". `u`, `v` lead from (x, y) to the centre of the top view of a conic
(8), `f` is a jet at (x, y); all broadcast. The algorithms use the adapted frame instead, where
these are shorter.
"""

import numpy as np


def eq04_terms(f, *, printed=False):
    """Return the terms of Eq. 4 (13, ...), whose sum is 0 where a line lies in the graph of `f`.

    Nine are mended: there an index of a third derivative is lost or changed in print, as the
    terms have it that are `printed`.
    """
    d = f.derivative
    a, b, c = d(2, 0), d(1, 1), d(0, 2)
    k, l, m, n = d(3, 0), d(2, 1), d(1, 2), d(0, 3)  # noqa: E741
    l1, m1 = (b, b) if printed else (l, m)
    l2 = k if printed else l
    terms = [
        c**3 * k**2,
        6 * c * k * n * b * a,
        -6 * c**2 * k * m1 * a,
        -6 * n * m1 * a**2 * b,
        9 * c * m1**2 * a**2,
        -6 * b * c**2 * l1 * k,
        12 * b**2 * l1 * n * a,
        -18 * b * c * l1 * (n if printed else m) * a,
        12 * c * m1 * b**2 * k,
        -8 * n * b**3 * k,
        9 * a * c**2 * l1**2,
        -6 * c * l2 * n * a**2,
        n**2 * a**3,
    ]
    return np.stack(terms)


def eq09(x, y, u, v, half_angle):
    """Return the condition that a conic about (x + u, y + v) stands for a cone, a number.

    The cone's `half_angle` is in rad.
    """
    return eq23(x, y, u, v) ** 2 - 4 * np.tan(half_angle) ** 2 * (u * u + v * v)


def eq11(f, u, v):
    """Return the condition for contact of order 3, in m."""
    return eq26(f, u, v) + 3 * eq25(f, u, v)


def eq12(f, u, v):
    """Return the condition for contact of order 4, with four indices mended, in m."""
    d = f.derivative
    fourth = d(4, 0) * v**4 - 4 * d(3, 1) * v**3 * u + 6 * d(2, 2) * v**2 * u**2
    fourth = fourth - 4 * d(1, 3) * v * u**3 + d(0, 4) * u**4
    third = u * v**2 * d(3, 0) + v * (v**2 - 2 * u**2) * d(2, 1)
    third = third + u * (u**2 - 2 * v**2) * d(1, 2) + u**2 * v * d(0, 3)
    second = (u**2 - v**2) * (d(2, 0) - d(0, 2)) + 4 * u * v * d(1, 1)
    return fourth + 6 * third + 3 * second


def eq14(f, x, y, u, v, half_angle):
    """Return a sixth of the Jacobian of Eqs 9 and 11 by (u, v), in m, with Eq. 15 mended.

    `f` at (x, y); `half_angle` is in rad.
    """
    d = f.derivative
    weight = eq23(x, y, u, v)
    square = np.tan(half_angle) ** 2
    # Half the derivatives of Eq. 9 by u and v.
    p = 2 * x * weight - 4 * u * square
    q = 2 * y * weight - 4 * v * square
    third = d(3, 0) * v**2 * p + d(2, 1) * v * (v * q - 2 * u * p)
    third = third + d(1, 2) * u * (u * p - 2 * v * q) + d(0, 3) * u**2 * q
    return third + (d(2, 0) - d(0, 2)) * (u * p - v * q) + 2 * d(1, 1) * (u * q + v * p)


def eq23(x, y, u, v):
    """Return the condition that a conic about (x + u, y + v) stands for a cylinder, a number."""
    return x * x + y * y + 1 + 2 * x * u + 2 * y * v


def eq25(f, u, v):
    """Return the condition that tangent planes along the conic meet above its centre, in m."""
    d = f.derivative
    return (d(2, 0) - d(0, 2)) * u * v + d(1, 1) * (v**2 - u**2)


def eq26(f, u, v):
    """Return the second condition for channel surfaces, in m; the first is Eq. 25."""
    d = f.derivative
    return d(3, 0) * v**3 - 3 * d(2, 1) * v**2 * u + 3 * d(1, 2) * v * u**2 - d(0, 3) * u**3
