"""What every solid can tell of itself, and where planes touch it."""

import numpy as np

from ..kernels.exact import accurate_products
from ..kernels.vectors import scalar_products, unit_and_speed, vector_products


class Solid:
    """A convex solid; its `meet_line` tells where lines enter and leave it.

    Its `hull` is a point (3,) of the solid, in m, and a list of the discs and balls whose convex
    hull the solid is. Each has a centre (3,), counted from that point, a unit vector (3,) along its
    axis, or None for a ball, and a radius, in m. An empty solid has none. Its `capsule`, two ends
    (3,) and a radius, holds the solid: nothing outside of the capsule can meet it.
    """


def hull_of_ends(a, b, radius_a, radius_b, *, round_ends=False):
    """Return the `hull` of a solid between discs or balls about its ends a and b, (3,) in m.

    Their radii are `radius_a` and `radius_b`, in m, and `round_ends` says whether they are balls.
    """
    v = np.subtract(b, a)
    if not (round_ends or np.any(v)):
        return np.array(a), []  # a flat rod without length is empty
    axis = None if round_ends else np.array(unit_and_speed(v)[0])
    return np.array(a), [(np.zeros(3), axis, radius_a), (v, axis, radius_b)]


def outermost(parts, normal):
    """Yield points (3, n), counted from the point of a `hull`, that may be its outermost.

    Of each of its parts they are those which reach farthest along the unit vectors `normal` (3, n),
    and against them.
    """
    for centre, axis, radius in parts:
        out = radius * (normal if axis is None else nearest_in_disc(normal, axis))
        yield centre[:, None] + out
        if radius:
            yield centre[:, None] - out


def nearest_in_disc(normal, axis):
    """Return the unit vectors (3, n) in a disc's plane that are nearest to `normal`, or zero.

    They are zero where `normal` is along the disc's axis.

    Examples
    --------
    >>> nearly_along = np.array([[3e-200, 0.0], [4e-200, 0.0], [1.0, 1.0]])
    >>> (nearest_in_disc(nearly_along, np.array([0.0, 0.0, 1.0])) + 0.0).round(12)
    array([[0.6, 0. ],
           [0.8, 0. ],
           [0. , 0. ]])
    """
    aside = np.stack(accurate_products(np.broadcast_to(axis[:, None], normal.shape), normal))
    # They are brought near 1 by a power of two first: the squares of small ones would underflow.
    exponent = np.frexp(np.abs(aside).max(axis=0))[1]
    aside = np.ldexp(aside, -exponent)
    length = np.sqrt(scalar_products(aside, aside))
    aside = aside / np.where(length > 0, length, 1)
    return np.stack(np.broadcast_arrays(*vector_products(aside, axis[:, None])))
