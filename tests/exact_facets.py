"""The judge of facets: whether one that is moved so far has a point in common with a solid.

Each decision is of one place. An edge that is moved is a straight line, whose interval in the solid
`exhibits.exact_shapes` finds in whole numbers. If no edge meets the solid, the solid's section by
the facet's plane is inside the facet or apart from it, and one point tells which: that point is
between the solid's outermost ones along the facet's normal, found in 60 digits.
"""

from fractions import Fraction

import mpmath
import numpy as np

from exhibits.exact_shapes import EPS, exact_interval, full_size

DIGITS = 60


def _vector(numbers):
    return np.array([mpmath.mpf(x.numerator) / x.denominator for x in map(Fraction, numbers)])


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def _cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]])  # fmt: skip


def _unit(v):
    length = mpmath.sqrt(_dot(v, v))
    return v / length if length else v


def support(kind, shape, normal, margin):
    """Return a point of a solid that is outermost along a unit vector, in 60 digits."""
    margin = mpmath.mpf(float(margin))
    first, second = _vector(shape[0:3]), _vector(shape[3:6])
    if kind == "box":
        edges = [second, _vector(shape[6:9]), _vector(shape[9:12])]
        edges = [edge + 2 * margin * _unit(edge) for edge in edges]
        first = first - margin * sum((_unit(edge) for edge in edges), 0 * first)
        return sum((edge for edge in edges if _dot(edge, normal) > 0), first)
    start, end = (mpmath.mpf(float(number)) for number in shape[6:8])
    axis = _unit(second if kind == "rounded" else second - first)
    flat = _unit(normal - _dot(normal, axis) * axis)
    if kind == "rounded":
        return first + start * flat + (end + margin) * normal
    if kind == "capsule":
        candidates = [first + (start + margin) * normal, second + (start + margin) * normal]
    else:
        # The wall moves by the margin across itself, and ends where the moved discs are.
        v = second - first
        length = mpmath.sqrt(_dot(v, v))
        gain = (end - start) / length
        more = margin * mpmath.sqrt(1 + gain**2)
        widest = max(start, end) + margin
        places = [-margin, length + margin]
        if gain and margin > 0:  # where it comes out of the widest cylinder
            places.append((widest - start - more) / gain)
        candidates = []
        for place in places:
            radius = max(min(start + gain * place + more, widest), 0)
            candidates.append(first + place * axis + radius * flat)
    return max(candidates, key=lambda point: _dot(point, normal))


def meets(kind, shape, facet, u, t, margin):
    """Return whether a facet (k, 3), moved by t along u, meets a solid grown by a margin."""
    t = Fraction(t)
    moved = [[Fraction(x) + t * Fraction(v) for x, v in zip(corner, u, strict=True)]
             for corner in facet.tolist()]  # fmt: skip
    count = len(moved)
    for i in range(count if count > 2 else count - 1):
        start, end = moved[i], moved[(i + 1) % count]
        way = [b - a for a, b in zip(start, end, strict=True)]
        found = exact_interval(kind, shape, start, way if any(way) else [1, 0, 0], margin)
        if found and found[0] <= any(way) and found[1] >= 0:
            return True
    return count > 2 and _holds_section(kind, shape, moved, margin)


def _holds_section(kind, shape, corners, margin):
    with mpmath.workdps(DIGITS):
        corners = [_vector(corner) for corner in corners]
        normal = _unit(_cross(corners[1] - corners[0], corners[2] - corners[0]))
        if not any(normal):
            return False
        highest = support(kind, shape, normal, margin)
        lowest = support(kind, shape, -normal, margin)
        above, below = (_dot(point - corners[0], normal) for point in (highest, lowest))
        if not below <= 0 <= above:
            return False
        point = lowest if above == below else (highest * -below + lowest * above) / (above - below)
        inside = True
        for first, second in zip(corners, corners[1:] + corners[:1], strict=True):
            inside &= _dot(_cross(second - first, point - first), normal) >= 0
        return inside


def judged_facets(found, kind, shapes, facets, u, roundings=64):
    """Return which answers (n,) are missed or too late, and which invented or too early.

    The promise counts by the size of the solid, of the facet, and how far off its first corner
    passes.
    """
    late, early = np.zeros((2, len(shapes)), dtype=bool)
    sizes = full_size(kind, shapes)
    for i, (shape, facet, way) in enumerate(zip(shapes.tolist(), facets, u.tolist(), strict=True)):
        start = np.subtract(facet[0], shape[:3])
        unit = np.divide(way, np.linalg.norm(way))
        passes = np.linalg.norm(start - (start @ unit) * unit)
        margin = roundings * EPS * (sizes[i] + np.abs(facet - facet[0]).max() + passes)
        enter, leave = found[0][i], found[1][i]
        if not enter <= leave:
            continue
        for end, outward in ((enter, -1), (leave, 1)):
            slack = 16 * EPS * max(sizes[i] / np.linalg.norm(way), abs(end))
            late[i] |= meets(kind, shape, facet, way, end + outward * slack, -margin)
            # A facet that only touches may have passed by so much farther on.
            later = end - outward * slack, end
            early[i] |= not any(meets(kind, shape, facet, way, t, margin) for t in later)
    return late, early
