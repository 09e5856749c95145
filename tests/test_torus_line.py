"""Line meets torus, judged in whole numbers: Eq. 5 corrected, over points on a dyadic grid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.audit.long import many
from tests.draws import EPS, directions
from tests.shapes import eq2, off_surface, tori
from tunneller_lib.surfaces import Torus

GRID = 2.0**-40
FINE = 2.0**-60  # a few roundings are told apart on it
KINDS = (
    "random", "in the ring's plane", "in a meridian plane", "through the centre", "from afar",
    "parallel to the axis", "along the tunnel", "afar, both points", "points close together",
)  # fmt: skip


def on_grid(values, grid=GRID):
    return np.round(np.asarray(values) / grid) * grid


def whole(values, grid=GRID):
    """Return floats on the grid as Python integers, which hold any product of them."""
    return np.vectorize(int, otypes=[object])(np.asarray(values) / grid)


def gridded(ratio, grid=GRID):
    """Return a torus of R/r = ratio and r + R near 1 whose radii are on the grid."""
    return Torus(*on_grid([1 / (1 + ratio), ratio / (1 + ratio)], grid))


def quartic(torus, a, b, grid=GRID):
    """Return the coefficients of Eq. 5, T2 and T0 corrected, highest first, in whole numbers."""
    (r, R), a, b = (whole(values, grid) for values in ([torus.r, torus.R], a, b))
    u = b - a
    t4, t3 = np.sum(u * u, -1), np.sum(a * u, -1)
    t2, ring = np.sum(a * a, -1) - r * r - R * R, 4 * r * r
    a2, u2 = a[..., 1], u[..., 1]
    return (t4**2, 4 * t3 * t4, ring * u2**2 + 2 * t2 * t4 + 4 * t3**2,
            2 * ring * a2 * u2 + 4 * t2 * t3, t2**2 - ring * (R**2 - a2**2))  # fmt: skip


def count_real_roots(a, b, c, d, e):
    """Return how many real roots quartics have, from the signs of their invariants."""
    first = 12 * a * e - 3 * b * d + c**2
    second = 72 * a * c * e + 9 * b * c * d - 27 * a * d**2 - 27 * e * b**2 - 2 * c**3
    discriminant = 4 * first**3 - second**2
    assert np.all(discriminant != 0)
    four = 64 * a**3 * e - 16 * (a * c) ** 2 + 16 * a * b**2 * c - 16 * a**2 * b * d - 3 * b**4
    all_or_none = np.where((8 * a * c < 3 * b**2) & (four < 0), 4, 0)
    return np.where(discriminant < 0, 2, all_or_none)


def follow(a, b, t):
    """Return a + t (b - a) (n, k, 3) in whole numbers, and the unit (n, k, 1) they count."""
    mantissa, exponent = np.frexp(t[..., None])
    steps = np.vectorize(int, otypes=[object])(mantissa * 2.0**53)
    unit = 2 ** (53 - exponent.astype(object))
    a, u = whole(a)[:, None], (whole(b) - whole(a))[:, None]
    return a * unit + steps * u, unit


def judge(torus, a, b, t):
    """Assert that t holds all real roots, each at rounding level, for lines on the grid."""
    found = np.sum(~np.isnan(t), axis=-1)
    np.testing.assert_array_equal(found, count_real_roots(*quartic(torus, a, b)))
    np.testing.assert_array_equal(t, np.sort(t, axis=-1))
    for n in (2, 4):
        line = found == n
        if np.any(line):
            roots = t[line][:, :n]
            numbers, unit = follow(a[line], b[line], roots)
            points = (numbers / unit).astype(float) * GRID
            way = np.abs(roots) * np.linalg.norm(b - a, axis=-1)[line, None]
            off = off_surface(torus, points) / (torus.r + torus.R + way)
            assert np.max(off) <= 8 * EPS
            numbers, unit = follow(a[line], b[line], (roots[:, 1:] + roots[:, :-1]) / 2)
            radii = [whole(c) * unit[..., 0] for c in (torus.r, torus.R)]
            between = eq2(*radii, *np.moveaxis(numbers, -1, 0))
            assert np.all((between < 0) == [True, False, True][: n - 1])


def lines(kind, rng, n):
    """Return points a and b of n lines of a kind, on the grid, near a torus of r + R = 1."""
    a, b = rng.uniform(-1, 1, (2, n, 3))
    if kind == "in the ring's plane":
        a[:, 1] = b[:, 1] = 0
    elif kind == "in a meridian plane":
        a[:, 2] = b[:, 2] = 0
    elif kind == "through the centre":
        b = -(2.0 ** rng.integers(-3, 3, n)[:, None]) * on_grid(a)
    elif kind == "parallel to the axis":
        b = a + np.array([0, 1, 0])
    elif kind == "along the tunnel":
        b = a + np.array([1, 0, 0])
    elif kind == "from afar":
        a = b + 10 ** rng.uniform(1, 6, (n, 1)) * directions(rng, n)
    elif kind == "afar, both points":
        away = 10 ** rng.uniform(1, 6, (n, 1)) * directions(rng, n)
        a, b = a + away, a + 2 * away
    elif kind == "points close together":
        b = a + 1e-6 * directions(rng, n)
    return on_grid(a), on_grid(b)


@pytest.mark.parametrize("kind", KINDS)
def test_meet_line_finds_all_of_random_and_special_lines(kind):
    for ratio in np.geomspace(0.2, 1e4, many(10, 20)):
        torus, rng = gridded(ratio), np.random.default_rng(int(1000 * ratio))
        a, b = lines(kind, rng, many(400, 5_000) if kind == "random" else many(100, 150))
        judge(torus, a, b, torus.meet_line(a, b))


def beside_tangents(torus, seed, n, roundings):
    """Return points a and b of lines that pass n tangents at so many roundings of r + R, and where.

    Lines outside come first, then as many inside; where is the share of the way from a to b.
    Tangents that almost osculate are left out: beside those three meetings lie close together.
    """
    rng = np.random.default_rng(seed)
    theta, phi = rng.uniform(-np.pi, np.pi, (2, n))
    normal = torus.normal(theta, phi)
    u = np.cross(normal, directions(rng, n))
    u = u / np.linalg.norm(u, axis=-1, keepdims=True)
    along = np.sum(u * np.stack([-np.sin(theta), 0 * theta, -np.cos(theta)], axis=-1), axis=-1)
    meridian, parallel = torus.curvatures(theta, phi)
    bent = np.abs(meridian * (1 - along**2) + parallel * along**2) > 0.01
    away = roundings * EPS * normal[bent]
    point = torus.point(theta, phi)[bent] + np.stack([away, -away])
    before, after = rng.uniform(0.1, 1, (2, bent.sum(), 1))
    a, b = (on_grid(end, FINE) for end in (point - before * u[bent], point + after * u[bent]))
    return a, b, (before / (before + after))[:, 0]


@pytest.mark.parametrize("roundings", [14, 30, 1e3, 1e6])
@pytest.mark.parametrize("ratio", [0.2, 0.7, 1.5, 10, 1e4])
def test_meet_line_tells_lines_that_pass_from_lines_that_cut(ratio, roundings):
    torus = gridded(ratio, FINE)
    a, b, _ = beside_tangents(torus, 6, 400, roundings)
    outside, inside = exact = count_real_roots(*quartic(torus, a, b, FINE))
    assert np.all(np.abs(outside - inside) == 2) and len(outside) > 350
    np.testing.assert_array_equal(np.sum(~np.isnan(torus.meet_line(a, b)), axis=-1), exact)


@pytest.mark.parametrize("roundings", [0.5, 2, 4])
@pytest.mark.parametrize("ratio", [0.2, 0.7, 1.5, 10, 1e4])
def test_meet_line_counts_what_passes_within_roundings_as_contact(ratio, roundings):
    torus = gridded(ratio, FINE)
    a, b, where = beside_tangents(torus, 7, 400, roundings)
    near = np.abs(torus.meet_line(a, b) - where[:, None]) <= 1e-5
    assert np.all(np.sum(near, axis=-1) >= 2)


# Radii, a point and a direction in whole numbers, tangent there.
TANGENTS = {
    "outer equator, along the axis": (3, 5, (8, 0, 0), (0, 1, 0)),
    "outer equator, oblique": (3, 5, (0, 0, 8), (3, 4, 0)),
    "hole, along the axis": (5, 3, (2, 0, 0), (0, 1, 0)),
    "hole, oblique": (5, 3, (-2, 0, 0), (0, 2, 1)),
    "top": (5, 3, (3, 3, 4), (7, 0, -2)),
    "meridian, outside": (1, 5, (4, 4, 0), (-4, 3, 0)),
    "meridian, inside": (20, 5, (17, 4, 0), (4, 3, 0)),
    "oblique, turned": (25, 25, (24, 20, 32), (-12 + 4, 15, -16 - 3)),
    "lemon sheet": (3, 5, (2, 0, 0), (0, 2, 1)),
    "nearly a sphere": (1, 8192, (8193, 0, 0), (0, 5, 9)),
    "thin tube": (8192, 1, (8193, 0, 0), (0, 5, 9)),
    "thin tube, from inside": (8192, 1, (8191, 0, 0), (0, 0, 1)),
}


@pytest.mark.parametrize("steps", [0, 1, -3, 1000, 10**6])
@pytest.mark.parametrize("name", TANGENTS)
def test_meet_line_finds_exact_tangents_twice(name, steps):
    r, R, point, u = TANGENTS[name]
    start = steps * (r + R)  # 10^6 steps: the line is given from 10^6 R away
    a = np.array(point) - start * np.array(u)
    t = Torus(r, R).meet_line(a, a + u)
    T4, T3, T2, T1, T0 = map(int, quartic(Torus(r, R), a, a + u))
    assert (((T4 * start + T3) * start + T2) * start + T1) * start + T0 == 0
    assert ((4 * T4 * start + 3 * T3) * start + 2 * T2) * start + T1 == 0
    q1 = T3 + 2 * start * T4  # the quartic over (t - start)^2
    q0 = T2 + 2 * start * q1 - start**2 * T4
    assert np.sum(~np.isnan(t)) == (4 if q1**2 >= 4 * T4 * q0 else 2)
    apart = np.sort(np.abs(t[~np.isnan(t)] - start))[:2] * np.linalg.norm(u)
    assert np.all(apart <= 4 * EPS**0.5 * (r + R) + 8 * EPS * abs(start) * np.linalg.norm(u))


@pytest.mark.parametrize("r, R, point, u", [
    (5, 1, (4, 0, 0), (0, 1, 2)),  # fourfold: x = 4, y = t, z = 2 t gives 25 t^4
    (5, 4, (1, 0, 0), (0, 2, 1)),
    (5, 3, (3, 3, 4), (4, 0, -3)),
    (15, 5, (12, 4, 0), (-4, -3, 10)),  # threefold, and one more
    (15, 5, (12, -4, 0), (-4, 3, -10)),
])  # fmt: skip
@pytest.mark.parametrize("steps", [0, 1, 1000])
def test_meet_line_finds_asymptotic_tangents(r, R, point, u, steps):
    torus, a = Torus(r, R), np.array(point) - steps * np.array(u)
    T4, T3, T2, T1, T0 = map(int, quartic(torus, point, np.add(point, u)))
    assert T0 == T1 == T2 == 0
    expected = {0.0, -T3 / T4}
    t = torus.meet_line(a, a + u)
    t = t[~np.isnan(t)] - steps
    blur = 4 * EPS ** (1 / 4 if T3 == 0 else 1 / 3)
    assert len(t) >= 2
    for root in expected:
        assert np.min(np.abs(t - root)) <= blur
    assert all(min(abs(root - e) for e in expected) <= blur for root in t)


@given(tori, st.integers(-80, 80), st.integers(0, 2**32 - 1))
def test_meet_line_scales_with_powers_of_two(torus, exponent, seed):
    scale = 2.0**exponent
    a, b = (torus.r + torus.R) * np.random.default_rng(seed).uniform(-1, 1, (2, 4, 3))
    scaled = Torus(torus.r * scale, torus.R * scale)
    np.testing.assert_array_equal(scaled.meet_line(a * scale, b * scale), torus.meet_line(a, b))


def test_meet_line_refuses_points_that_coincide():
    with pytest.raises(
        ValueError, match=r"^a, b: must differ, or there is no line; got a pair that coincides[.]$"
    ):
        Torus(1, 2).meet_line([(1, 2, 3), (1, 2, 4)], (1, 2, 3))
