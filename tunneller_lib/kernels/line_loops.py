"""The loop over lines for `compiled.call`, by the formulas that serve rows of lines, too."""

import math

from .elementwise import NUMBERS
from .vectors import differences


def quick(shape, q, u):
    """Return `enter` and `leave`, and that they aren't sure, for shapes without a quick way.

    The quick way of a shape takes this one's place. Parameters: a point counted from the shape's
    start, in m, and a direction, three floats each.
    """
    return math.inf, -math.inf, False


def careful(shape, p, u):
    """Return `enter` and `leave`: the name stands for a shape's careful way, with p as given."""
    raise NotImplementedError


def meet_lines(shape, plain, points, directions, enter, leave):
    """Fill in where lines enter and leave one shape.

    Parameters
    ----------
    shape : NamedTuple
        Its `start`, in m, is one of its points.
    plain : bool
        Whether the quick way may decide.
    points, directions : (n, 3) or (1, 3) float
        Points of the lines, in m, and their directions; one may be the same for all.
    enter, leave : (n,) float
        To be filled.
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


# Numbers may be NaN here, as beside a shape, and of any size: so these differ from those that
# other loops have.


def root_or_none(x):
    """Return the square root, which is NaN below zero."""
    return math.sqrt(x) if x >= 0 else math.nan


def power_of(x):
    """Return the power of two next above a size."""
    return math.frexp(x)[1]


# What `compiled.call` puts in the place of what formulas call.
FOR_LINES = {**NUMBERS, "square_root": root_or_none, "power_above": power_of, "scaled": math.ldexp}
