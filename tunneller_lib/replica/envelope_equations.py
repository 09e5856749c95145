"""The document's equations as they stand, for a graph z = f(x, y) in the isotropic model.

They are left sides of "= 0". `u`, `v` lead from (x, y) to the centre of the top view of a conic
(8), `f` is a jet at (x, y); all broadcast. The algorithms use the adapted frame instead, where
these are shorter.
"""

import numpy as np


def _weight(x, y, u, v):
    return x * x + y * y + 1 + 2 * x * u + 2 * y * v


def eq09(x, y, u, v, half_angle):
    """Return the condition that a conic about (x + u, y + v) stands for a cone, a number.

    The cone's `half_angle` is in rad.
    """
    return _weight(x, y, u, v) ** 2 - 4 * np.tan(half_angle) ** 2 * (u * u + v * v)


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
    d, weight, square = f.derivative, _weight(x, y, u, v), np.tan(half_angle) ** 2
    p, q = 2 * x * weight - 4 * u * square, 2 * y * weight - 4 * v * square
    third = d(3, 0) * v**2 * p + d(2, 1) * v * (v * q - 2 * u * p)
    third = third + d(1, 2) * u * (u * p - 2 * v * q) + d(0, 3) * u**2 * q
    return third + (d(2, 0) - d(0, 2)) * (u * p - v * q) + 2 * d(1, 1) * (u * q + v * p)


def eq23(x, y, u, v):
    """Return the condition that a conic about (x + u, y + v) stands for a cylinder, a number."""
    return _weight(x, y, u, v)


def eq24(f, x, y, u, v, radius):
    """Return the condition for a cylinder beside Eq. 23, in m.

    `f` at (x, y), the conic about (x + u, y + v); `radius` in m, positive where the normals point
    to the axis.
    """
    d = f.derivative
    second = d(2, 0) * v**2 - 2 * d(1, 1) * u * v + d(0, 2) * u**2
    height = f.value - x * d(1, 0) - y * d(0, 1) - radius
    return 2 * (u * u + v * v) * height + (x * x + y * y + 1) * second


def eq25(f, u, v):
    """Return the condition that tangent planes along the conic meet above its centre, in m."""
    d = f.derivative
    return (d(2, 0) - d(0, 2)) * u * v + d(1, 1) * (v**2 - u**2)


def eq26(f, u, v):
    """Return the second condition for channel surfaces, in m; the first is Eq. 25."""
    d = f.derivative
    return d(3, 0) * v**3 - 3 * d(2, 1) * v**2 * u + 3 * d(1, 2) * v * u**2 - d(0, 3) * u**3
