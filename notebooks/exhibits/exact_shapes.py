"""One judge for lines against all shapes, in whole numbers; it imports nothing of the library.

A float is a whole number over a power of two, so that sums and products are exact. A shape is
a union of parts, and a part is where linear and quadratic forms in the line's parameter t aren't
positive. Lengths get 128 bits below their last one, to which roots are rounded so that a line
that touches counts as meeting.

Shapes are rows of twelve numbers: rod, capsule and frustum (a, b, r_a, r_b, zeros), box (corner,
three edges). Grown by a margin, a shape's planes and walls move outwards by it, a frustum ends at
its grown widest radius, and a box is that of the moved planes: no point of the grown shape is
farther from the shape than sqrt(3) margins. Shrunk, it holds the points that are a margin deep.
"""

from fractions import Fraction
from math import isqrt

import numpy as np

BITS = 128
EPS = np.finfo(float).eps
EVERYWHERE = (-1, 0), (1, 0)  # ends as whole fractions (above, below), infinite over zero


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _from(a, b):
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


def _below(slope, offset):
    """Return where slope t <= offset."""
    if slope == 0:
        return EVERYWHERE if offset >= 0 else None
    return ((-1, 0), (offset, slope)) if slope > 0 else ((-offset, -slope), (1, 0))


def _inside(A, B, C):
    """Return where A t^2 + 2 B t + C <= 0, of which A is zero or above."""
    if A == 0:
        return _below(2 * B, -C)
    square = B * B - A * C
    if square < 0:
        return None
    root = isqrt(square - 1) + 1 if square else 0  # rounded up
    return (-B - root, A), (-B + root, A)


def _beyond(A, B, C, rising):
    """Return the later half line where A t^2 + 2 B t + C <= 0, A < 0, or the earlier one."""
    root = isqrt(B * B - A * C)
    return ((B + root, -A), (1, 0)) if rising else ((-1, 0), (B - root, -A))


def _less(first, second):
    return first[0] * second[1] < second[0] * first[1]


def _common(intervals):
    """Return what intervals share, or None."""
    low, high = EVERYWHERE
    for interval in intervals:
        if interval is None:
            return None
        low = interval[0] if low[1] == 0 or _less(low, interval[0]) else low
        high = interval[1] if high[1] == 0 or _less(interval[1], high) else high
        if low[1] and high[1] and _less(high, low):
            return None
    return low, high


def _ball(centre, radius, p, u):
    q = _from(centre, p)
    return _inside(_dot(u, u), _dot(q, u), _dot(q, q) - radius * radius) if radius >= 0 else None


def _frustum(numbers, margin, p, u):
    a, b, start, end = numbers[0:3], numbers[3:6], numbers[6], numbers[7]
    v, q = _from(a, b), _from(a, p)
    vv, uv, qv = _dot(v, v), _dot(u, v), _dot(q, v)
    if vv == 0:
        return None
    planes = margin * isqrt(vv)
    parts = [_below(uv, vv + planes - qv), _below(-uv, planes + qv)]
    # Squares of the distance from the axis, times vv: A t^2 + 2 B t + C.
    A, B, C = _dot(u, u) * vv - uv * uv, _dot(q, u) * vv - qv * uv, _dot(q, q) * vv - qv * qv
    widest = max(start, end) + margin
    if start == end:  # a rod
        return _common([*parts, _inside(A, B, C - vv * widest * widest)]) if widest >= 0 else None
    if margin >= 0:
        parts.append(_inside(A, B, C - vv * widest * widest))
    # The wall's radius, times vv, is W + G t; a margin across the wall is more across the axis.
    gain = end - start
    more = margin * isqrt(vv * (vv + gain * gain))
    G, W = gain * uv, start * vv + gain * qv + more
    parts.append(_below(-G, W))
    A, B, C = vv * A - G * G, vv * B - G * W, vv * C - W * W
    parts.append(_inside(A, B, C) if A >= 0 else _beyond(A, B, C, G > 0))
    return _common(parts)


def _capsule(numbers, margin, p, u):
    a, b, wide = numbers[0:3], numbers[3:6], numbers[6] + margin
    parts = [_frustum([*a, *b, wide, wide], 0, p, u), _ball(a, wide, p, u), _ball(b, wide, p, u)]
    parts = [part for part in parts if part is not None] if wide >= 0 else []
    if not parts:
        return None
    low, high = parts[0]
    for part in parts[1:]:
        low = part[0] if _less(part[0], low) else low
        high = part[1] if _less(high, part[1]) else high
    return low, high


def _box(numbers, margin, p, u):
    q = _from(numbers[0:3], p)
    edges = [numbers[3:6], numbers[6:9], numbers[9:12]]
    parts = []
    for i in range(3):
        normal = _cross(edges[i - 2], edges[i - 1])
        wide, at, pace = _dot(edges[i], normal), _dot(q, normal), _dot(u, normal)
        if wide < 0:
            wide, at, pace = -wide, -at, -pace
        more = margin * isqrt(_dot(normal, normal))
        parts += [_below(pace, wide + more - at), _below(-pace, at + more)]
    return _common(parts)


SHAPES = {"rod": _frustum, "capsule": _capsule, "frustum": _frustum, "box": _box}


def rod_rows(a, b, radius):
    """Return rods as rows (n, 12), from ends (n, 3) and radii (n,)."""
    return np.column_stack([a, b, radius, radius, np.zeros((len(radius), 4))])


def whole(numbers):
    """Return floats, or fractions like them, as whole numbers over one power of two, and that."""
    pairs = [number.as_integer_ratio() for number in numbers]
    power = max(below for _, below in pairs)
    return [above * (power // below) for above, below in pairs], power


def exact_interval(kind, shape, p, u, margin=0.0):
    """Return where one line is inside a shape as exact `Fraction`s, or None for a miss."""
    lengths, power = whole([*shape, *p, margin])
    direction, unit = whole(u)
    lengths = [number << BITS for number in lengths]
    direction = [number << BITS for number in direction]
    found = SHAPES[kind](lengths[:12], lengths[15], lengths[12:15], direction)
    return found and [Fraction(above * unit, below * power) for above, below in found]


def exact_intervals(kind, shapes, p, u, margin=None):
    """Return `enter` and `leave` (2, n) of lines against shapes (n, 12), as the nearest floats."""
    margins = np.zeros(len(shapes)) if margin is None else margin
    out = np.empty((2, len(shapes)))
    rows = zip(shapes.tolist(), p.tolist(), u.tolist(), margins.tolist(), strict=True)
    for i, row in enumerate(rows):
        found = exact_interval(kind, *row)
        out[:, i] = (np.inf, -np.inf) if found is None else found
    return out


def size_of(kind, shapes, u):
    """Return the size (n,) by which the promise counts: what a line sees of each shape, in m."""
    if kind == "box":
        return np.linalg.norm(shapes[:, 3:], axis=-1)
    v = shapes[:, 3:6] - shapes[:, :3]
    unit = u / np.linalg.norm(u / np.abs(u).max(axis=-1, keepdims=True), axis=-1, keepdims=True)
    unit /= np.abs(u).max(axis=-1, keepdims=True)
    return shapes[:, 6:8].max(axis=-1) + np.linalg.norm(np.cross(v, unit), axis=-1)


def full_size(kind, shapes):
    """Return the size (n,) of shapes as seen from everywhere, in m."""
    if kind == "box":
        return size_of(kind, shapes, None)
    return shapes[:, 6:8].max(axis=-1) + np.linalg.norm(shapes[:, 3:6] - shapes[:, :3], axis=-1)


def judged_rods(found, lines, allowed=64 * EPS):
    """Return what `judged` says of flat rods: of lines (a, b, radius, p, u), one rod a line."""
    a, b, radius, p, u = lines
    return judged(found, "rod", rod_rows(a, b, radius), p, u, allowed)


def judged(found, kind, shapes, p, u, allowed=64 * EPS):
    """Return which answers (n,) are missed, thin and thick.

    Missed: the line meets the shape and nothing was found. Thin: even the shape shrunk by a margin
    has more of the line. Thick: even the shape grown by it has less. The margin is the allowed
    share of `size_of`.
    """
    enter, leave = found
    margin = allowed * size_of(kind, shapes, u)
    exact = exact_intervals(kind, shapes, p, u)
    least = exact_intervals(kind, shapes, p, u, -margin)
    most = exact_intervals(kind, shapes, p, u, margin)
    # An end is a float itself: so much its own last digits may be off, along the line.
    whole_size = full_size(kind, shapes)
    ends = [np.where(np.isfinite(end), np.abs(end), 0) for end in found]
    slack = 16 * EPS * np.maximum(whole_size / np.linalg.norm(u, axis=-1), np.maximum(*ends))
    empty = ~(enter <= leave)
    missed = (exact[0] <= exact[1]) & empty
    with np.errstate(invalid="ignore"):
        meant = (least[0] <= least[1]) & ~empty
        thin = meant & ((enter > least[0] + slack) | (leave < least[1] - slack))
        thick = ~empty & ~((enter >= most[0] - slack) & (leave <= most[1] + slack))
    return missed, thin, thick
