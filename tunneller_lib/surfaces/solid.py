"""What all solids answer, and where planes touch those that end in discs or balls."""

import numpy as np

from ..kernels.exact import accurate_products
from ..kernels.vectors import scalar_products, unit_and_speed, vector_products


class Solid:
    """A convex solid: lines meet it by `meet_line`, planes touch it at its `outermost` points.

    `outermost(normal)`, of unit vectors (3, n), returns a point (3,) of the solid and the ways
    (3, n) from there, in m, to the points that may reach farthest along the normals or against
    them; an empty solid has none. `capsule`, its ends (3,) and its radius, holds the solid:
    whatever is outside of it can't meet the solid.
    """


def outermost_of_ends(a, b, radius_a, radius_b, normal, *, round_ends=False):
    """Return what `Solid.outermost` does for a solid between discs or balls about a and b.

    Parameters: the ends a and b, (3,), and the radii there, `radius_a` and `radius_b`, in m; the
    unit vectors `normal` (3, n); and `round_ends`, whether balls end the solid.
    """
    v = np.subtract(b, a)
    ends = (np.zeros(3), radius_a), (v, radius_b)
    if round_ends:
        found = [reach for end, radius in ends for reach in both_ways(end, radius * normal)]
    elif np.any(v):
        axis = np.array(unit_and_speed(v)[0])
        found = [
            reach
            for end, radius in ends
            for reach in both_ways(end, radius * nearest_in_disc(normal, axis))
        ]
    else:
        found = []  # a flat rod without length is empty
    return np.array(a), found


def both_ways(centre, out):
    """Return the points (3, n) that lie `out` (3, n) from a centre (3,), and their opposites."""
    return centre[:, None] + out, centre[:, None] - out


def nearest_in_disc(normal, axis):
    """Return the unit vectors (3, n) in a disc that are nearest to others, or zero for its axis."""
    aside = np.stack(accurate_products(np.broadcast_to(axis[:, None], normal.shape), normal))
    # To unit length by way of a power of two, lest squares of what is small be lost.
    exponent = np.frexp(np.abs(aside).max(axis=0))[1]
    aside = np.ldexp(aside, -exponent)
    length = np.sqrt(scalar_products(aside, aside))
    aside = aside / np.where(length > 0, length, 1)
    return np.stack(np.broadcast_arrays(*vector_products(aside, axis[:, None])))
