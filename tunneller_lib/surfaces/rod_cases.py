"""Hard lines, by generator: through rims, along walls and planes, tangent, far, degenerate.

Each generator takes a random generator and a number n and returns a, b (n, 3), radius (n,),
p, u (n, 3): rods, and for each a line. A rim or a touch is at t = 0 unless another word is said.
"""

import numpy as np

TRIPLES = np.array([[16, 63], [33, 56], [25, 60], [39, 52], [0, 65]])  # x^2 + y^2 = 65^2


def _rotations(rng, n):
    """Return whole matrices (n, 3, 3) whose columns are perpendicular and of length N (n,)."""
    w, x, y, z = rng.integers(-9, 10, (4, n))
    w = np.where((w == 0) & (x == 0) & (y == 0) & (z == 0), 1, w)
    N = w * w + x * x + y * y + z * z
    rows = [[N - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), N - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), N - 2 * (x * x + y * y)]]  # fmt: skip
    return np.moveaxis(np.array(rows), -1, 0), N


def _whole_rods(rng, n):
    """Return rods of whole numbers: a, b, radius, matrices, points of the rim about a, normals."""
    matrix, N = _rotations(rng, n)
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
    return (a + away) * scale[:, None], (b + away) * scale[:, None], radius * scale, \
        (p + away) * scale[:, None], u  # fmt: skip


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
    off = np.roll(np.pad(TRIPLES[rng.integers(0, 5, n)] * (reach // 65)[:, None],
                         ((0, 0), (1, 0))), 0, axis=1)  # fmt: skip
    off = np.stack([np.roll(row, k) for row, k in zip(off, axes[0])])
    return _as_lines(a, b, reach, a + off, unit[axes[1]] * rng.choice([-2, 1], n)[:, None])


def _float_rods(rng, n):
    scale = 10.0 ** rng.uniform(-6, 6, n)
    a, v = rng.normal(size=(2, n, 3)) * scale[:, None]
    radius = scale * 10.0 ** rng.uniform(-2, 2, n)
    side = np.cross(v, rng.normal(size=(n, 3)))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    return a, a + v, radius, side * radius[:, None]


def float_rims(rng, n):
    """Lines through a rim as near as floats come to it, axes and directions of full mantissa."""
    a, b, radius, side = _float_rods(rng, n)
    return a, b, radius, np.where(rng.random(n)[:, None] < 0.5, a, b) + side, \
        rng.normal(size=(n, 3))  # fmt: skip


def vertical_lines(rng, n):
    """The document's setting: lines along z, through the upper rim of a leaning rod."""
    a, b, radius, side = _float_rods(rng, n)
    up = np.where((b - a)[:, 2:] > 0, b, a)
    return a, b, radius, up + side, np.broadcast_to([0.0, 0.0, 1.0], (n, 3)).copy()


def nearly_parallel(rng, n):
    """Lines through a rim that lean against the axis by 1e-16 to 1e-3."""
    a, b, radius, side = _float_rods(rng, n)
    lean = 10.0 ** rng.uniform(-16, -3, n)[:, None] * rng.normal(size=(n, 3))
    v = b - a
    return a, b, radius, a + side, v + lean * np.linalg.norm(v, axis=-1, keepdims=True)


def nearly_vertical(rng, n):
    """Lines along z through the rims of rods whose axes run 1e-14 to 1e-9 of the radius."""
    radius, upright = 10.0 ** rng.uniform(-6, 6, n), np.array([0.0, 0.0, 1.0])
    turn = rng.uniform(0, 2 * np.pi, (2, n))
    v = radius * np.stack([*(10.0 ** rng.uniform(-14, -9, n) * [np.cos(turn[0]), np.sin(turn[0])]),
                           rng.choice([-1, 1], n) * 10.0 ** rng.uniform(-1, 4, n)])  # fmt: skip
    # About the origin no digit of the tilt is lost; the other half is anywhere.
    a = radius[:, None] * rng.normal(size=(n, 3)) * rng.integers(0, 2, n)[:, None]
    b = a + v.T
    side = np.cross(b - a, np.stack([np.cos(turn[1]), np.sin(turn[1]), 0 * radius], axis=-1))
    side *= (radius / np.linalg.norm(side, axis=-1))[:, None]
    return a, b, radius, np.where(rng.random(n)[:, None] < 0.5, a, b) + side, \
        np.broadcast_to(upright, (n, 3)).copy()  # fmt: skip


def very_short(rng, n):
    """Lines of any direction through the rims of rods 1e-16 to 1e-9 of their radius long."""
    radius = 10.0 ** rng.uniform(-6, 6, n)
    v = rng.normal(size=(n, 3))
    side = np.cross(v, rng.normal(size=(n, 3)))
    side *= (radius / np.linalg.norm(side, axis=-1))[:, None]
    v *= (radius * 10.0 ** rng.uniform(-16, -9, n) / np.linalg.norm(v, axis=-1))[:, None]
    a = v * rng.uniform(-2, 2, n)[:, None]
    u = np.where(rng.random(n)[:, None] < 0.5, rng.normal(size=(n, 3)), [0.0, 0.0, 1.0])
    return a, a + v, radius, np.where(rng.random(n)[:, None] < 0.5, a, a + v) + side, u


def nearly_level(rng, n):
    """Lines through a rim that lean against the end's plane by 1e-16 to 1e-3."""
    a, b, radius, side = _float_rods(rng, n)
    v = b - a
    across = np.cross(v, rng.normal(size=(n, 3)))
    lean = 10.0 ** rng.uniform(-16, -3, n)[:, None] * v
    return a, b, radius, b + side, across + lean


def from_far(rng, n):
    """Lines through a rim, given by a point up to 1e9 sizes away."""
    a, b, radius, p, u = float_rims(rng, n)
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    size = radius + np.linalg.norm(b - a, axis=-1)
    return a, b, radius, p + u * (size * 10.0 ** rng.uniform(0, 9, n))[:, None], u


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
