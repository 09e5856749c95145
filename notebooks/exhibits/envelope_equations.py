"""The document's equations as they stand, for a graph z = f(x, y) in the isotropic model.

They are left sides of "= 0". `u`, `v` lead from (x, y) to the centre of the top view of a conic
(8), `f` is a jet at (x, y); all broadcast. The algorithms use the adapted frame instead, where
these are shorter.
"""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from tunneller_lib.arguments import Angle, Lengths, Rule, bounded_array, checked
from tunneller_lib.envelopes.jet import Jet

FARTHEST = 1e30  # Eq. 12 has products of four coordinates and a derivative


def _coordinates(name, value):
    """Return `value` as a float array (...) of coordinates in the model, at most 1e30 in size."""
    array = bounded_array(name, value)
    if array.size and np.abs(array).max() > FARTHEST:
        raise ValueError(
            f"{name}: must hold coordinates of at most {FARTHEST:g} in size; "
            f"got {np.abs(array).max():g}."
        )
    return array


Coordinates = Annotated[ArrayLike, Rule("(...) float", _coordinates)]


def _check_places(f, *coordinates):
    """Raise ValueError where a jet's points and the coordinates don't broadcast."""
    shapes = [np.shape(f.value), *map(np.shape, coordinates)]
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        came = ", ".join(map(str, shapes))
        raise ValueError(f"f: its points must broadcast with the others; got {came}.") from None


def _weight(x, y, u, v):
    return x * x + y * y + 1 + 2 * x * u + 2 * y * v


@checked
def eq04_terms(f: Jet, *, printed: bool = False):
    """Return the terms of Eq. 4 (13, ...), whose sum is 0 where a line lies in the graph of `f`.

    Nine are mended: there an index of a third derivative is lost or changed in print, as the
    terms have it that are `printed`.
    """
    d = f.derivative
    a, b, c = d(2, 0), d(1, 1), d(0, 2)
    k, l, m, n = d(3, 0), d(2, 1), d(1, 2), d(0, 3)  # noqa: E741
    l1, m1 = (b, b) if printed else (l, m)
    l2 = k if printed else l
    return np.stack(
        [
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
    )


@checked
def eq09(x: Coordinates, y: Coordinates, u: Coordinates, v: Coordinates, half_angle: Angle):
    """Return the condition that a conic about (x + u, y + v) stands for a cone, a number.

    The cone's `half_angle` is in rad.
    """
    return _weight(x, y, u, v) ** 2 - 4 * np.tan(half_angle) ** 2 * (u * u + v * v)


@checked
def eq11(f: Jet, u: Coordinates, v: Coordinates):
    """Return the condition for contact of order 3, in m."""
    return eq26.unchecked(f, u, v) + 3 * eq25.unchecked(f, u, v)


@checked
def eq12(f: Jet, u: Coordinates, v: Coordinates):
    """Return the condition for contact of order 4, with four indices mended, in m."""
    _check_places(f, u, v)
    d = f.derivative
    fourth = d(4, 0) * v**4 - 4 * d(3, 1) * v**3 * u + 6 * d(2, 2) * v**2 * u**2
    fourth = fourth - 4 * d(1, 3) * v * u**3 + d(0, 4) * u**4
    third = u * v**2 * d(3, 0) + v * (v**2 - 2 * u**2) * d(2, 1)
    third = third + u * (u**2 - 2 * v**2) * d(1, 2) + u**2 * v * d(0, 3)
    second = (u**2 - v**2) * (d(2, 0) - d(0, 2)) + 4 * u * v * d(1, 1)
    return fourth + 6 * third + 3 * second


@checked
def eq14(f: Jet, x: Coordinates, y: Coordinates, u: Coordinates, v: Coordinates, half_angle: Angle):
    """Return a sixth of the Jacobian of Eqs 9 and 11 by (u, v), in m, with Eq. 15 mended.

    `f` at (x, y); `half_angle` is in rad.
    """
    _check_places(f, x, y, u, v)
    d = f.derivative
    weight = _weight(x, y, u, v)
    square = np.tan(half_angle) ** 2
    # Half the derivatives of Eq. 9 by u and v.
    p = 2 * x * weight - 4 * u * square
    q = 2 * y * weight - 4 * v * square
    third = d(3, 0) * v**2 * p + d(2, 1) * v * (v * q - 2 * u * p)
    third = third + d(1, 2) * u * (u * p - 2 * v * q) + d(0, 3) * u**2 * q
    return third + (d(2, 0) - d(0, 2)) * (u * p - v * q) + 2 * d(1, 1) * (u * q + v * p)


@checked
def eq23(x: Coordinates, y: Coordinates, u: Coordinates, v: Coordinates):
    """Return the condition that a conic about (x + u, y + v) stands for a cylinder, a number."""
    return _weight(x, y, u, v)


@checked
def eq24(f: Jet, x: Coordinates, y: Coordinates, u: Coordinates, v: Coordinates, radius: Lengths):
    """Return the condition for a cylinder beside Eq. 23, in m.

    `f` at (x, y), the conic about (x + u, y + v); `radius` in m, positive where the normals point
    to the axis.
    """
    _check_places(f, x, y, u, v, radius)
    d = f.derivative
    second = d(2, 0) * v**2 - 2 * d(1, 1) * u * v + d(0, 2) * u**2
    height = f.value - x * d(1, 0) - y * d(0, 1) - radius
    return 2 * (u * u + v * v) * height + (x * x + y * y + 1) * second


@checked
def eq25(f: Jet, u: Coordinates, v: Coordinates):
    """Return the condition that tangent planes along the conic meet above its centre, in m."""
    _check_places(f, u, v)
    d = f.derivative
    return (d(2, 0) - d(0, 2)) * u * v + d(1, 1) * (v**2 - u**2)


@checked
def eq26(f: Jet, u: Coordinates, v: Coordinates):
    """Return the second condition for channel surfaces, in m; the first is Eq. 25."""
    _check_places(f, u, v)
    d = f.derivative
    return d(3, 0) * v**3 - 3 * d(2, 1) * v**2 * u + 3 * d(1, 2) * v * u**2 - d(0, 3) * u**3
