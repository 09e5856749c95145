"""The loop over lines for `compiled.call`, by the same formulas as for rows of lines."""

import math

from .elementwise import NUMBERS
from .vectors import differences


def quick(shape, q, u):
    """Return no `enter` and `leave`, and that they aren't sure: for shapes without a quick way.

    A shape's own quick way takes this one's place. Its parameters are a point, counted from the
    shape's start, in m, and a direction, three floats each.
    """
    return math.inf, -math.inf, False


def careful(shape, p, u):
    """Return `enter` and `leave` by a shape's careful way, for which this name stands."""
    raise NotImplementedError


def meet_lines(shape, plain, points, directions, enter, leave):
    """Fill in where lines enter and leave one shape.

    Parameters
    ----------
    shape : NamedTuple
        Its `start`, in m, is one of the shape's points.
    plain : bool
        Whether the quick way may decide.
    points, directions : (n, 3) or (1, 3) float
        Points of the lines, in m, and their directions; a single one is for all lines.
    enter, leave : (n,) float
        Filled with the answers.
    """
    for i in range(len(enter)):
        k = i if len(points) > 1 else 0
        p = (points[k][0], points[k][1], points[k][2])
        k = i if len(directions) > 1 else 0
        u = (directions[k][0], directions[k][1], directions[k][2])
        # The careful way costs several times as much: it is asked only where the other isn't sure.
        sure = False
        if plain:
            first, last, sure = quick(shape, differences(p, shape.start), u)
        if not sure:
            first, last = careful(shape, p, u)
        enter[i] = first
        leave[i] = last


# Numbers may be NaN here, as of a line beside a shape, and of any size. So these functions differ
# from those of other loops.


def root_or_none(x):
    """Return the square root, which is NaN below zero."""
    return math.sqrt(x) if x >= 0 else math.nan


def power_of(x):
    """Return the exponent of the power of two next above a size."""
    return math.frexp(x)[1]


# What `compiled.call` puts in the place of what formulas call.
FOR_LINES = {**NUMBERS, "square_root": root_or_none, "power_above": power_of, "scaled": math.ldexp}
