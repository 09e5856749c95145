"""Lines against rods in whole numbers, the judge of all methods.

Floats are whole numbers over a power of two, so that every sum and product here is exact; the
only root is taken to 2^-128, rounded so that a line that touches counts as meeting.
"""

import math
from math import isqrt

import numpy as np

ROOT_BITS = 128


def _whole_rows(rows):
    """Return rows of floats (n, k) as lists of whole numbers, each row over its power of two.

    The exponents (n,) are of what a row's numbers are over.
    """
    mantissa, exponent = np.frexp(rows)
    units = np.ldexp(mantissa, 53).astype(np.int64)
    # A zero has no exponent of its own, and must not be the least.
    least = np.where(units != 0, exponent, 2000).min(axis=-1, keepdims=True)
    up = np.where(units != 0, exponent - least, 0)
    numbers = [
        [unit << shift for unit, shift in zip(*row, strict=True)]
        for row in zip(units.tolist(), up.tolist(), strict=True)
    ]
    return numbers, (53 - least[:, 0]).tolist()


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _from(a, b):
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


def _quadratic(A, B, C):
    """Return where A t^2 + 2 B t + C <= 0, A >= 0, as two fractions (above, below), or None."""
    # The line is parallel to the axis: all of it is inside, or none.
    if A == 0:
        return ((-1, 0), (1, 0)) if C <= 0 else None
    D = B * B - A * C
    if D < 0:
        return None
    # The root in more bits than any answer has, rounded up: the interval is never too short.
    root = isqrt(D << 2 * ROOT_BITS) + 1 if D else 0
    B <<= ROOT_BITS
    A <<= ROOT_BITS
    return (-B - root, A), (-B + root, A)


def _less(first, second):
    return first[0] * second[1] < second[0] * first[1]


def _common(first, second):
    """Return the intersection of two intervals of fractions, or None."""
    if first is None or second is None:
        return None
    low = _greater(first[0], second[0])
    high = first[1] if _less(first[1], second[1]) else second[1]
    return None if _less(high, low) else (low, high)


def _greater(first, second):
    """Return the greater of two fractions; one over zero is infinite."""
    if first[1] == 0 and second[1] == 0:
        return first if first[0] > second[0] else second
    return second if _less(first, second) else first


def _flat(a, b, radius, margin, p, u):
    """Return the interval in a rod that is grown by a margin, or shrunk by a negative one."""
    v = _from(a, b)
    q = _from(a, p)
    vv = _dot(v, v)
    uv = _dot(u, v)
    qv = _dot(q, v)
    wide = radius + margin
    if vv == 0 or wide < 0:
        return None
    # |q + t u|^2 less its square along v, at most wide^2; times vv, so that nothing is divided.
    B = _dot(q, u) * vv - qv * uv
    wall = _quadratic(_dot(u, u) * vv - uv * uv, B, (_dot(q, q) - wide * wide) * vv - qv * qv)
    # A length of the axis that is right to 1e-18 moves the planes by the margin.
    more = margin * isqrt(vv << 128) // 2**64
    # Between the discs' planes 0 <= (q + t u) v <= vv, each moved by the margin.
    low = -more - qv
    high = vv + more - qv
    if uv == 0:
        return wall if low <= 0 <= high else None
    planes = ((low, uv), (high, uv)) if uv > 0 else ((-high, -uv), (-low, -uv))
    return _common(wall, planes) if low <= high else None


def _number(fraction, power):
    """Return a fraction times a power of two as the nearest float, infinite where it is beyond."""
    above, below = fraction
    if below == 0:
        return np.inf * above
    if power > 0:
        above <<= power
    else:
        below <<= -power
    try:
        return above / below
    except OverflowError:
        return np.inf if above > 0 else -np.inf


def exact_intervals(a, b, radius, p, u, *, margin=0.0):
    """Return where lines enter and leave rods, one rod a line: the floats nearest to the truth.

    Parameters
    ----------
    a, b : (..., 3) float
        Ends of the axes, in m.
    radius : (...) float
        Of the rods, in m.
    p, u : (..., 3) float
        A point, in m, and the direction of each line.
    margin : (...) float
        Grows the rods, in radius and in length at both ends; shrinks them below zero. In m.

    Returns
    -------
    intervals : (2, ...) float
        `enter` and `leave`; ``inf`` and ``-inf`` for a line that misses.
    """
    a, b, radius, p, u, margin = (np.asarray(x, dtype=float) for x in (a, b, radius, p, u, margin))
    shape = np.broadcast_shapes(*(x.shape[:-1] for x in (a, b, p, u)), radius.shape, margin.shape)
    count = math.prod(shape)
    a, b, p, u = (np.broadcast_to(x, (*shape, 3)).reshape(count, 3) for x in (a, b, p, u))
    sizes = [np.broadcast_to(x, shape).reshape(count, 1) for x in (radius, margin)]
    # Lengths share a power of two; the direction has its own, which is undone at the end.
    rows, shift = _whole_rows(np.concatenate([a, b, p, *sizes], axis=-1))
    directions, unit = _whole_rows(u)
    out = np.empty((2, count))
    for i, (row, direction) in enumerate(zip(rows, directions, strict=True)):
        found = _flat(row[0:3], row[3:6], *row[9:], row[6:9], direction)
        power = unit[i] - shift[i]
        out[:, i] = (np.inf, -np.inf) if found is None else [_number(f, power) for f in found]
    return out.reshape(2, *shape)


def rounding(found, lines):
    """Return by how much an end may be off by the rounding of its own parameter, (...) float.

    Arguments found and lines as of `judge`; in lengths of the direction.
    """
    a, b, radius, _, u = lines
    speed = np.linalg.norm(u, axis=-1)
    size = (radius + np.linalg.norm(b - a, axis=-1)) / speed
    ends = [np.where(np.isfinite(end), np.abs(end), 0) for end in found]
    return 16 * np.finfo(float).eps * np.maximum(size, np.maximum(*ends))


def judge(found, lines, margin):
    """Return which of the intervals found for lines are missed, thin or thick.

    Parameters
    ----------
    found : (enter, leave)
        What a method says, (...) float each.
    lines : (a, b, radius, p, u)
        Rods and lines, as `exact_intervals` takes them.
    margin : (...) float
        What a method may be off, in m.

    Returns
    -------
    missed, thin, thick : (...) bool
        The line meets the rod and the answer is empty; the rod shrunk by the margin has more of
        the line; the rod grown by the margin has less.
    """
    enter, leave = found
    exact = exact_intervals(*lines)
    least = exact_intervals(*lines, margin=-margin)
    most = exact_intervals(*lines, margin=margin)
    slack = rounding(found, lines)
    empty = ~(enter <= leave)
    missed = (exact[0] <= exact[1]) & empty
    meant = (least[0] <= least[1]) & ~empty
    with np.errstate(invalid="ignore", over="ignore"):
        thin = meant & ((enter > least[0] + slack) | (leave < least[1] - slack))
        thick = ~empty & ~((enter >= most[0] - slack) & (leave <= most[1] + slack))
    return missed, thin, thick
