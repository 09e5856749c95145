"""Hard lines, by generator: through rims, along walls and planes, tangent, far, degenerate.

Each generator takes a random generator and a number n and returns a, b (n, 3), radius (n,),
p, u (n, 3): rods, and for each a line. A rim or a touch is at t = 0 unless another word is said.

They use sums, products, quotients and roots alone: sin, exp or a power have other last bits on
other processors, and hard lines are hard in their last bits.
"""

import numpy as np

from tunneller_lib.arguments import Whole

Count = Whole(1, 1_000_000)
TRIPLES = np.array([[16, 63], [33, 56], [25, 60], [39, 52], [0, 65]])  # x^2 + y^2 = 65^2


def whole_rotations(rng, n, most=9):
    """Return whole matrices (n, 3, 3) whose columns are perpendicular and of length N (n,).

    They are rotations, times N, of quaternions whose parts are whole and at most `most`.
    """
    w, x, y, z = rng.integers(-most, most + 1, (4, n))
    w = np.where((w == 0) & (x == 0) & (y == 0) & (z == 0), 1, w)
    N = w * w + x * x + y * y + z * z
    # The quaternion (w, x, y, z) as a rotation, its rows times N.
    rows = [[N - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), N - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), N - 2 * (x * x + y * y)]]  # fmt: skip
    return np.moveaxis(np.array(rows), -1, 0), N


def _whole_rods(rng, n):
    """Return rods of whole numbers: a, b, radius, matrices, points of the rim about a, normals."""
    matrix, N = whole_rotations(rng, n)
    grow = rng.integers(1, 5, n)
    pair = TRIPLES[rng.integers(0, len(TRIPLES), n)] * rng.choice([-1, 1], (n, 2))
    pair = np.where(rng.random(n)[:, None] < 0.5, pair, pair[:, ::-1])
    normal = np.einsum("nij,nj->ni", matrix[..., :2], pair)  # of length 65 N
    a = rng.integers(-999, 1000, (n, 3))
    b = a + matrix[..., 2] * rng.integers(1, 400, n)[:, None]
    return a, b, 65 * N * grow, matrix, a + normal * grow[:, None], normal


def _as_lines(*arrays):
    return tuple(np.asarray(array, dtype=float) for array in arrays)


def _some(rng, n):
    """Return whole directions, none zero."""
    u = rng.integers(-99, 100, (n, 3))
    u[np.all(u == 0, axis=-1)] = 1
    return u


def whole_rims(rng, n):
    """Lines of any direction through points that are exactly on a rim."""
    a, b, radius, _, rim, _ = _whole_rods(rng, n)
    upper = rng.random(n)[:, None] < 0.5
    return _as_lines(a, b, radius, rim + np.where(upper, b - a, 0), _some(rng, n))


def far_rims(rng, n):
    """The same far from the origin, at any scale."""
    a, b, radius, p, u = whole_rims(rng, n)
    away = rng.integers(-(2**30), 2**30, (n, 3))
    scale = 2.0 ** rng.integers(-60, 60, n)
    a, b, p = ((point + away) * scale[:, None] for point in (a, b, p))
    return a, b, radius * scale, p, u


def tangents(rng, n):
    """Lines that touch the wall in one point."""
    a, b, radius, matrix, rim, normal = _whole_rods(rng, n)
    side = np.cross(matrix[..., 2], normal)
    share = rng.integers(1, 50, (2, n))
    u = side * share[0][:, None] + (b - a) * rng.integers(-3, 4, n)[:, None]
    return _as_lines(a, b, radius, rim + matrix[..., 2] * rng.integers(0, 2, n)[:, None], u)


def rulings(rng, n):
    """Lines along the wall: in it, and beside it by what a float can tell."""
    a, b, radius, matrix, rim, _ = _whole_rods(rng, n)
    lines = list(_as_lines(a, b, radius, rim, matrix[..., 2] * rng.choice([-3, 1], n)[:, None]))
    lines[2] *= 1 + rng.integers(-1, 2, n) * 2.0**-50
    return tuple(lines)


def end_planes(rng, n):
    """Lines in an end's plane, through a point of its rim."""
    a, b, radius, matrix, rim, _ = _whole_rods(rng, n)
    turn = rng.integers(-9, 10, (2, n, 1))
    turn[0, np.all(turn == 0, axis=0)[:, 0]] = 1
    u = matrix[..., 0] * turn[0] + matrix[..., 1] * turn[1]
    return _as_lines(a, b, radius, rim + np.where(rng.random(n)[:, None] < 0.5, b - a, 0), u)


def rim_tangents(rng, n):
    """Lines that touch a rim in one point, in the end's plane."""
    a, b, radius, matrix, rim, normal = _whole_rods(rng, n)
    return _as_lines(a, b, radius, rim, np.cross(matrix[..., 2], normal))


def along_an_axis(rng, n):
    """Rods along x, y or z, lines along another or the same, at whole distances."""
    reach = rng.integers(1, 9, n) * 65
    axes = rng.integers(0, 3, (2, n))
    unit = np.eye(3, dtype=int)
    a = rng.integers(-99, 100, (n, 3))
    b = a + unit[axes[0]] * rng.integers(1, 400, n)[:, None]
    off = np.pad(TRIPLES[rng.integers(0, 5, n)] * (reach // 65)[:, None], ((0, 0), (1, 0)))
    off = np.take_along_axis(off, (np.arange(3) - axes[0][:, None]) % 3, axis=1)  # x to the axis
    return _as_lines(a, b, reach, a + off, unit[axes[1]] * rng.choice([-2, 1], n)[:, None])


def _sizes(rng, low, high, n):
    """Return numbers of any mantissa between powers of two about 10^low and 10^high."""
    powers = rng.integers(round(low * 10 / 3), round(high * 10 / 3), n)  # 2^10 is about 10^3
    return np.ldexp(rng.uniform(1, 2, n), powers)


def _on_circle(rng, n):
    """Return points (n, 2) of the unit circle."""
    x, y = rng.normal(size=(2, n))
    return np.stack([x, y], axis=-1) / np.sqrt(x * x + y * y)[:, None]


def _lengths(v):
    """Return the lengths (n,) of vectors (n, 3), summed in one order everywhere."""
    x, y, z = np.moveaxis(v, -1, 0)
    return np.sqrt(x * x + y * y + z * z)


def _float_rods(rng, n):
    scale = _sizes(rng, -6, 6, n)
    a, v = rng.normal(size=(2, n, 3)) * scale[:, None]
    radius = scale * _sizes(rng, -2, 2, n)
    side = np.cross(v, rng.normal(size=(n, 3)))
    side /= _lengths(side)[:, None]
    return a, a + v, radius, side * radius[:, None]


def float_rims(rng, n):
    """Lines through a rim as near as floats come to it, axes and directions of full mantissa."""
    a, b, radius, side = _float_rods(rng, n)
    p = np.where(rng.random(n)[:, None] < 0.5, a, b) + side
    return a, b, radius, p, rng.normal(size=(n, 3))


def vertical_lines(rng, n):
    """The document's setting: lines along z, through the upper rim of a leaning rod."""
    a, b, radius, side = _float_rods(rng, n)
    up = np.where((b - a)[:, 2:] > 0, b, a)
    return a, b, radius, up + side, np.broadcast_to([0.0, 0.0, 1.0], (n, 3)).copy()


def nearly_parallel(rng, n):
    """Lines through a rim that lean against the axis by 1e-16 to 1e-3."""
    a, b, radius, side = _float_rods(rng, n)
    lean = _sizes(rng, -16, -3, n)[:, None] * rng.normal(size=(n, 3))
    v = b - a
    return a, b, radius, a + side, v + lean * _lengths(v)[:, None]


def nearly_vertical(rng, n):
    """Lines along z through the rims of rods whose axes run 1e-14 to 1e-9 of the radius."""
    radius = _sizes(rng, -6, 6, n)
    towards = _on_circle(rng, n)
    across = _on_circle(rng, n)
    run = _sizes(rng, -14, -9, n)
    rise = rng.choice([-1, 1], n) * _sizes(rng, -1, 4, n)
    v = radius[:, None] * np.concatenate([run[:, None] * towards, rise[:, None]], axis=-1)
    # About the origin no digit of the tilt is lost; the other half is anywhere.
    a = radius[:, None] * rng.normal(size=(n, 3)) * rng.integers(0, 2, n)[:, None]
    b = a + v
    side = np.cross(b - a, np.pad(across, ((0, 0), (0, 1))))
    side *= (radius / _lengths(side))[:, None]
    p = np.where(rng.random(n)[:, None] < 0.5, a, b) + side
    return a, b, radius, p, np.broadcast_to([0.0, 0.0, 1.0], (n, 3)).copy()


def very_short(rng, n):
    """Lines of any direction through the rims of rods 1e-16 to 1e-9 of their radius long."""
    radius = _sizes(rng, -6, 6, n)
    v = rng.normal(size=(n, 3))
    side = np.cross(v, rng.normal(size=(n, 3)))
    side *= (radius / _lengths(side))[:, None]
    v *= (radius * _sizes(rng, -16, -9, n) / _lengths(v))[:, None]
    a = v * rng.uniform(-2, 2, n)[:, None]
    u = np.where(rng.random(n)[:, None] < 0.5, rng.normal(size=(n, 3)), [0.0, 0.0, 1.0])
    return a, a + v, radius, np.where(rng.random(n)[:, None] < 0.5, a, a + v) + side, u


def nearly_level(rng, n):
    """Lines through a rim that lean against the end's plane by 1e-16 to 1e-3."""
    a, b, radius, side = _float_rods(rng, n)
    v = b - a
    across = np.cross(v, rng.normal(size=(n, 3)))
    lean = _sizes(rng, -16, -3, n)[:, None] * v
    return a, b, radius, b + side, across + lean


def from_far(rng, n):
    """Lines through a rim, given by a point up to 1e9 sizes away."""
    a, b, radius, p, u = float_rims(rng, n)
    u /= _lengths(u)[:, None]
    size = radius + _lengths(b - a)
    return a, b, radius, p + u * (size * _sizes(rng, 0, 9, n))[:, None], u


def degenerate(rng, n):
    """Rods without length or radius, met by lines through their ends."""
    a, b, radius, p, u = whole_rims(rng, n)
    which = rng.integers(0, 3, n)
    radius = np.where(which == 0, 0.0, radius)
    b = np.where(which[:, None] == 1, a, b)
    return a, b, radius, np.where((which == 0)[:, None], a, p), u


GENERATORS = (
    whole_rims, far_rims, tangents, rulings, end_planes, rim_tangents, along_an_axis, float_rims,
    vertical_lines, nearly_parallel, nearly_vertical, nearly_level, very_short, from_far,
    degenerate,
)  # fmt: skip
