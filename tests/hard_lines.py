"""Hard lines against rods, capsules, frusta and boxes, by family.

A family takes a kind, a random generator and a number n, and returns shapes (n, 12) as
`exhibits.exact_shapes` reads them, points and directions (n, 3). It uses sums, products, quotients
and roots alone, whose last bits are the same on every processor.

Most shapes are whole: a whole rotation, whose columns are N long, takes whole rims, corners and
touches to exact places.
"""

import numpy as np

from exhibits.rod_cases import TRIPLES, whole_rotations
from tunneller_lib.surfaces import Box, Frustum, Rod
from tunneller_lib.surfaces.rod import meet_rods

KINDS = ("rod", "capsule", "frustum", "box")
WITH_AXES = ("rod", "capsule", "frustum")
BALL = np.array([[2, 3, 6], [6, 2, 3], [3, 6, 2], [0, 0, 7]])  # 7 from the origin
SHARES = (0, 0, 1, 2, 3, 4, 4)  # quarters of the way along the axis


class Whole:
    """Whole shapes of a kind, and on each a point with its normal and two directions beside it."""

    def __init__(self, kind, rng, n):
        self.kind = kind
        matrix, N = whole_rotations(rng, n, most=4)
        e1, e2, e3 = np.moveaxis(matrix, -1, 0)
        at = rng.integers(-25, 26, (n, 3)) * 4
        # A quarter of the shapes are long, a quarter are flat.
        proportion = rng.integers(0, 4, n)
        wide = np.where(proportion == 0, 16, 16 * rng.integers(1, 5, n))
        high = np.where(proportion == 1, 4, 4 * rng.integers(1, 60, n) * 65)
        self.share = rng.choice(SHARES, n)
        self.end = e3
        if kind == "box":
            size = np.stack([wide * 65, wide * rng.integers(1, 65, n), high], axis=-1)
            edges = np.moveaxis(matrix, -1, 1) * size[..., None]
            self.shapes = np.concatenate([at, edges.reshape(n, 9)], axis=-1)
            # A point of the face e1, inside it, on an edge or a corner.
            turn = rng.choice([-1, 1], n)[:, None]
            other = rng.choice(SHARES, n)
            self.point = at + np.where(turn > 0, edges[:, 0], 0)
            self.point += edges[:, 1] // 4 * other[:, None] + edges[:, 2] // 4 * self.share[:, None]
            self.normal, self.side, self.ruling = turn * e1, e2, e3
            self.size = N * (size.sum(axis=-1))
            return
        v = e3 * high[:, None]
        unit = 455 if kind == "capsule" else 65
        start = wide * unit * N
        taper = rng.choice([0, 0, 1, 2, 3, 5, 8], n) if kind == "frustum" else np.full(n, 4)
        end = start // 4 * taper
        if kind == "frustum":  # and upside down
            swap = rng.random(n) < 0.5
            start, end = np.where(swap, end, start), np.where(swap, start, end)
        pair = TRIPLES[rng.integers(0, len(TRIPLES), n)] * rng.choice([-1, 1], (n, 2))
        pair = np.where(rng.random(n)[:, None] < 0.5, pair, pair[:, ::-1])
        pair = pair * (unit // 65)
        out = pair[:, :1] * e1 + pair[:, 1:] * e2  # a unit times N long
        self.side = pair[:, :1] * e2 - pair[:, 1:] * e1
        steps = start // (unit * N), end // (unit * N)
        first, last = (out * step[:, None] for step in steps)
        self.shapes = np.concatenate(
            [at, at + v, start[:, None], end[:, None], np.zeros((n, 4))], axis=-1
        )
        self.ruling = v + last - first
        self.point = at + first + self.ruling // 4 * self.share[:, None]
        self.normal = out * high[:, None] + e3 * (unit * (steps[0] - steps[1]))[:, None]
        self.size = np.maximum(start, end) + high * N
        if kind == "capsule":  # half of the points are on the balls
            quad = BALL[rng.integers(0, len(BALL), n)] * 65 * rng.choice([-1, 1], (n, 3))
            upper = quad[:, 2] > 0
            away = np.einsum("nij,nj->ni", matrix, quad)
            ball = rng.random(n)[:, None] < 0.5
            centre = np.where(upper[:, None], at + v, at)
            self.point = np.where(ball, centre + away * steps[0][:, None], self.point)
            self.normal = np.where(ball, away, self.normal)
            side = np.cross(e1, away)
            ball &= np.any(side, axis=-1)[:, None]
            self.side = np.where(ball, side, self.side)
            self.ruling = np.where(ball, np.cross(away, side), self.ruling)

    def lines(self, u, shift=0):
        """Return the shapes with lines along u through their points, moved by a shift."""
        if u.dtype.kind == "i":
            u = u // np.maximum(np.gcd.reduce(u, axis=-1), 1)[:, None]
        u = np.array(u, dtype=float)
        u[np.all(u == 0, axis=-1)] = 1
        return self.shapes.astype(float), self.point + np.asarray(shift, dtype=float), u


def powers(rng, low, high, shape):
    """Return numbers of any mantissa, about 10^low to 10^high."""
    steps = rng.integers(round(low * 10 / 3), round(high * 10 / 3) + 1, shape)
    return np.ldexp(rng.uniform(0.5, 1, shape), steps)


def lengths(v):
    return np.sqrt(v[:, 0] ** 2 + v[:, 1] ** 2 + v[:, 2] ** 2)


def some(rng, n):
    """Return whole directions (n, 3)."""
    return rng.integers(-29, 30, (n, 3))


def touches(kind, rng, n):
    """Any line through a whole point of a rim, a wall, an end, a face or an edge."""
    return Whole(kind, rng, n).lines(some(rng, n))


def tangents(kind, rng, n):
    """Lines in the tangent plane of such a point, which touch or run along the surface."""
    whole = Whole(kind, rng, n)
    turn = rng.integers(-5, 6, (2, n, 1))
    return whole.lines(whole.side * turn[0] + whole.ruling * turn[1])


def rulings(kind, rng, n):
    """Lines along a ruling or an edge, in the surface."""
    whole = Whole(kind, rng, n)
    return whole.lines(whole.ruling * rng.choice([-3, 1], n)[:, None])


def ends(kind, rng, n):
    """Lines in the plane across the axis, through such a point."""
    whole = Whole(kind, rng, n)
    turn = rng.integers(-5, 6, (2, n, 1))
    across = np.cross(whole.end, whole.side)
    return whole.lines(whole.side * turn[0] + across * turn[1])


def axial(kind, rng, n):
    """Lines along the axis, through such a point."""
    whole = Whole(kind, rng, n)
    return whole.lines(whole.end * rng.choice([-3, 1], n)[:, None])


def tips(kind, rng, n):
    """Lines through the ends of the axis, or a box's corners: tips of cones among them."""
    whole = Whole(kind, rng, n)
    if kind == "box":
        edges = whole.shapes[:, 3:].reshape(n, 3, 3)
        whole.point = whole.shapes[:, :3] + (edges * rng.integers(0, 2, (n, 3, 1))).sum(axis=1)
    else:
        whole.point = np.where(rng.random(n)[:, None] < 0.5, whole.shapes[:, :3],
                               whole.shapes[:, 3:6])  # fmt: skip
    u = np.where(rng.random(n)[:, None] < 0.3, whole.ruling, some(rng, n))
    return whole.lines(u)


def grazes(kind, rng, n):
    """Tangents moved in or out by 2^-52 to 2^-20 of the shape."""
    whole = Whole(kind, rng, n)
    turn = rng.integers(-5, 6, (2, n, 1))
    move = whole.size * 2.0 ** -rng.integers(20, 53, n) * rng.choice([-1, 1, 1], n)
    move /= lengths(whole.normal.astype(float))
    return whole.lines(whole.side * turn[0] + whole.ruling * turn[1], whole.normal * move[:, None])


def leaning(kind, rng, n):
    """Lines that lean by 2^-53 to 2^-10 against a ruling, an axis, an end or an edge."""
    whole = Whole(kind, rng, n)
    which = rng.integers(0, 3, n)[:, None]
    u = np.select([which == 0, which == 1], [whole.ruling, whole.end], whole.side).astype(float)
    lean = lengths(u) * 2.0 ** -rng.integers(10, 54, n)
    return whole.lines(u + rng.normal(size=(n, 3)) * lean[:, None])


def far(kind, rng, n):
    """The first three with everything up to 2^50 away: coordinates are still exact."""
    family = [touches, tangents, rulings][rng.integers(0, 3)]
    shapes, p, u = family(kind, rng, n)
    room = np.floor(np.log2(2.0**52 / np.abs(np.concatenate([shapes, p], axis=-1)).max()))
    away = np.rint(rng.uniform(-1, 1, (n, 3)) * 2.0**51)
    away *= 2.0 ** -rng.integers(0, 30, n)[:, None]
    away = np.rint(away) * (room >= 0)
    shapes[:, :3] += away
    if kind in WITH_AXES:
        shapes[:, 3:6] += away
    return shapes, p + away, u


def from_far(kind, rng, n):
    """Touches and tangents, given by a point up to 2^50 steps away."""
    family = [touches, tangents][rng.integers(0, 2)]
    shapes, p, u = family(kind, rng, n)
    steps = np.floor(powers(rng, 0, 15, n)) * rng.choice([-1, 1], n)
    return shapes, p + u * steps[:, None], u


def scaled(kind, rng, n):
    """All of these at scales from 2^-300 to 2^300, the direction at one of its own."""
    family = [touches, tangents, rulings, grazes, leaning, tips][rng.integers(0, 6)]
    shapes, p, u = family(kind, rng, n)
    scale = 2.0 ** rng.integers(-300, 301, n)[:, None]
    return shapes * scale, p * scale, u * 2.0 ** rng.integers(-280, 280, n)[:, None]


def _floats(kind, rng, n, spread, placed=1):
    """Return shapes of full mantissa whose sizes differ by 10^spread, and a point on each.

    Those that are placed are anywhere, the others begin at the origin, so that their axes keep
    every digit.
    """
    high, start, end = sizes = powers(rng, -spread, spread, (3, n))
    axis, other = rng.normal(size=(2, n, 3))
    axis *= (high / lengths(axis))[:, None]
    side = np.cross(axis, other)
    side /= lengths(side)[:, None]
    at = rng.normal(size=(n, 3)) * sizes.max(axis=0)[:, None] * np.reshape(placed, (-1, 1))
    if kind == "box":
        third = np.cross(axis, side)
        third /= lengths(third)[:, None]
        edges = np.stack([axis, side * start[:, None], third * end[:, None]], axis=1)
        shapes = np.concatenate([at, edges.reshape(n, 9)], axis=-1)
        return shapes, at + (edges * rng.choice([0, 0.5, 1], (n, 3, 1))).sum(axis=1)
    end = np.where(rng.random(n) < 0.3, 0, end) if kind == "frustum" else start
    shapes = np.concatenate([at, at + axis, start[:, None], end[:, None], np.zeros((n, 4))], -1)
    share = rng.choice([0, 0.3, 1], n)
    wide = start + share * (end - start)
    return shapes, at + axis * share[:, None] + side * wide[:, None]


def floats(kind, rng, n):
    """Lines through the surface as near as floats come to it."""
    shapes, p = _floats(kind, rng, n, 1)
    return shapes, p, rng.normal(size=(n, 3))


def proportions(kind, rng, n):
    """The same of shapes from needles to wafers, sizes of 10^-9 to 10^9 in one shape."""
    shapes, p = _floats(kind, rng, n, 9, placed=rng.integers(0, 2, n))
    u = rng.normal(size=(n, 3))
    axis = shapes[:, 3:6] - (shapes[:, :3] if kind in WITH_AXES else 0)
    length = lengths(axis)
    unit = axis / np.where(length > 0, length, 1)[:, None]
    # A third of the lines nearly along the axis, and a third nearly across it.
    along = np.sum(u * unit, axis=-1)[:, None] * unit
    lean = powers(rng, -16, 0, n)[:, None]
    which = rng.integers(0, 3, n)[:, None]
    u = np.select([which == 0, which == 1], [along + lean * u, u - along + lean * u], u)
    # Lengths below the last digit of the place are none.
    if kind in WITH_AXES:
        gone = length == 0
        shapes[gone, 3:6] = shapes[gone, :3] + np.maximum(np.abs(shapes[gone, :3]), 1)
    return shapes, p, u


def sizes(kind, rng, n):
    """Lines through shapes about the origin whose every size is between 1e-99 and 1e99."""
    shapes, p = _floats(kind, rng, n, 99, placed=0)
    return shapes, p, rng.normal(size=(n, 3)) * powers(rng, -90, 90, n)[:, None]


def ordinary(kind, rng, n):
    """Lines between random points near a shape."""
    shapes, _ = _floats(kind, rng, n, 0.5)
    reach = np.abs(shapes[:, 3:]).max(axis=-1)[:, None]
    first, last = shapes[:, :3] + rng.normal(size=(2, n, 3)) * reach
    return shapes, first, last - first


def limits(kind, rng, n):
    """Lines through the surfaces of shapes that a docstring only just allows.

    Each size is zero where it may be, a last digit of the others, as great, or at either end of the
    range: discs without a corner, balls, segments, cones' tips, rods of hardly any length.
    """
    matrix, N = whole_rotations(rng, n, most=4)
    e1, e2, e3 = np.moveaxis(matrix, -1, 0)
    # All sizes are these shares of one scale; shapes at the origin keep every digit of them.
    scale = 2.0 ** rng.choice([0, 0, -320, 320], n)
    tiny = np.where(scale < 1, 0.0, 2.0 ** -rng.integers(40, 61, n))
    first, last, high = rng.choice([1.0, 1.0, 4.0, 0.0, -1.0, -1.0], (3, n))
    first, last, high = (np.where(size < 0, tiny, size) for size in (first, last, high))
    if kind in ("rod", "capsule"):
        last = first
    else:  # frusta have an axis, boxes have edges
        high = np.where(high == 0, 1, high)
        last = np.where(rng.random(n) < 0.3, first, last)
    if kind == "box":
        first, last = np.where(first == 0, 1, first), np.where(last == 0, 1, last)
    first, last, high = first * scale, last * scale, high * scale
    share = rng.choice([0, 0.5, 1], n)
    # Around the axis by a whole triple; beside it by one of a sphere.
    pair = rng.choice([[3, 4], [4, 3], [5, 0], [0, 5]], n) * rng.choice([-1, 1], (n, 2))
    out = pair[:, :1] * e1 + pair[:, 1:] * e2  # 5 N long
    side = pair[:, :1] * e2 - pair[:, 1:] * e1
    at = rng.integers(-9, 10, (n, 3)) * scale[:, None] * rng.integers(0, 2, n)[:, None]
    r1, r2, h, m = (size[:, None] for size in (first, last, high, share))
    if kind == "box":
        edges = e1 * r1, e2 * r2, e3 * h
        shapes = np.concatenate([at, *edges], axis=-1)
        p = at + sum(edge * rng.choice([0, 0.5, 1], (n, 1)) for edge in edges)
    else:
        radii = 5 * N[:, None] * np.concatenate([r1, r2], axis=-1)
        shapes = np.concatenate([at, at + e3 * h, radii, np.zeros((n, 4))], axis=-1)
        p = at + e3 * (h * m) + out * (r1 + (r2 - r1) * m)
    way = rng.integers(0, 5, n)[:, None]
    u = np.choose(way, [e3, side, out + 5 * e3, out, some(rng, n)])
    # Seen end-on a needle has no size, or one so small that nothing is promised.
    needle = (kind in WITH_AXES) & (1e15 * np.maximum(first, last) < 2 * high)
    end_on = np.all(np.cross(u, e3) == 0, axis=-1)
    u = np.where((needle & end_on)[:, None], out + 5 * e3, u).astype(float)
    u[np.all(u == 0, axis=-1)] = 1
    return shapes, p, u


FAMILIES = (touches, tangents, rulings, ends, axial, tips, grazes, leaning, far, from_far, scaled,
            floats, proportions, sizes, ordinary, limits)  # fmt: skip


def shape_of(kind, row):
    """Return a shape of the library."""
    a, b = row[:3], row[3:6]
    if kind == "box":
        return Box(a, b, row[6:9], row[9:])
    if kind == "frustum":
        return Frustum(a, b, *row[6:8])
    return Rod(a, b, row[6], ends="round" if kind == "capsule" else "flat")


def meet(kind, shapes, p, u):
    """Return where lines enter and leave shapes (n, 12), one shape a line, as the library says."""
    if kind in ("rod", "capsule"):
        ends = "round" if kind == "capsule" else "flat"
        return meet_rods(shapes[:, :3], shapes[:, 3:6], shapes[:, 6], p, u, ends=ends)
    lines = zip(shapes, p, u, strict=True)
    found = [shape_of(kind, row).meet_line(point, way) for row, point, way in lines]
    return tuple(np.array(found).reshape(-1, 2).T)
