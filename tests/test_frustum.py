"""Lines against truncated cones: a bisection on the definition, the rod as a limit, hard lines."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.exact_shapes import judged
from tunneller_lib.surfaces import Frustum, Rod
from tunneller_lib.surfaces.rod import meet_rods

EMPTY = (np.inf, -np.inf)


def depth(frustum, points):
    """Return how far points are inside all three surfaces, from the definition."""
    a, v = np.array(frustum.a), np.subtract(frustum.b, frustum.a)
    length = np.linalg.norm(v)
    along = (points - a) @ v / length
    off = np.linalg.norm((points - a) - along[..., None] * v / length, axis=-1)
    wide = frustum.radius_a + (frustum.radius_b - frustum.radius_a) * along / length
    return np.minimum(np.minimum(along, length - along), wide - off)


def random_frustum(rng, scale=1.0):
    a, b = rng.normal(size=(2, 3)) * scale
    radii = rng.uniform(0, 1, 2) * scale * rng.choice([[1, 1], [0, 1], [1, 0]])
    return Frustum(a, b, *radii)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-6, 1.0, 1e6]))
def test_meet_line_ends_on_the_surface(seed, scale):
    rng = np.random.default_rng(seed)
    frustum = random_frustum(rng, scale)
    p, aim = rng.normal(size=(2, 60, 3)) * scale
    u = aim - p
    enter, leave = frustum.meet_line(p, u)
    hit = enter <= leave
    t = np.where(hit, (enter, leave), 0)
    at = p + t[..., None] * u
    assert np.all(
        np.abs(depth(frustum, at[:, hit])) <= 1e-13 * scale * 10 + 1e-13 * np.abs(at).max()
    )
    # Nothing of the line outside the interval is inside, and everything in it is.
    share = np.linspace(-3, 4, 301)[:, None]
    inside = depth(frustum, p + share[..., None] * u)
    within = (share >= enter) & (share <= leave)
    assert np.all(inside[~within] <= 1e-9 * scale) and np.all(inside[within] >= -1e-9 * scale)


def test_equal_radii_make_a_rod():
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b = rng.normal(size=(2, 3))
        p, u = rng.normal(size=(2, 500, 3))
        frustum, rod = Frustum(a, b, 0.4, 0.4), Rod(a, b, 0.4)
        np.testing.assert_allclose(frustum.meet_line(p, u), rod.meet_line(p, u), atol=1e-7)


def test_meet_line_at_rims_tangents_and_the_apex():
    # Whole numbers: radius 4 to 0 over a height of 3, so that its rulings are 5 long.
    cone = Frustum((0, 0, 0), (0, 0, 3), 4, 0)
    cases = {
        ((4, 0, -1), (0, 0, 1)): (1, 1),  # touches the rim from outside
        ((0, 4, -1), (0, 0, 1)): (1, 1),
        ((2, 0, -1), (0, 0, 1)): (1, 2.5),
        ((0, 0, -1), (0, 0, 1)): (1, 4),  # through the apex
        ((-5, 0, 3), (1, 0, 0)): (5, 5),  # touches the apex
        ((-5, 0, 0), (1, 0, 0)): (1, 9),  # in the base
        ((-5, 4, 0), (1, 0, 0)): (5, 5),  # touches the rim in the base's plane
        ((4, 0, 0), (-4, 0, 3)): (0, 1),  # a ruling
        ((4, 0, 0), (4, 0, -3)): (-1, 0),
        ((0, 0, 3), (1, 0, 1)): (-3, 0),  # steeper than a ruling, out at the apex
        ((0, 0, 3), (2, 0, -1)): (0, 0),
        ((-5, 0, 3.0000001), (1, 0, 0)): EMPTY,
        ((5, 0, 5), (0, 0, 1)): EMPTY,  # the other nappe is no part of it
        ((0, 0, 4), (1, 0, 0)): EMPTY,
        ((0, 5, 1), (1, 0, 0)): EMPTY,
    }
    for (p, u), expected in cases.items():
        np.testing.assert_allclose(cone.meet_line(p, u), expected, atol=1e-14)
        power = 2.0**40
        big = Frustum((0, 0, 0), (0, 0, 3 * power), 4 * power, 0)
        found = np.array(big.meet_line(np.multiply(p, power), u))
        np.testing.assert_array_equal(found, np.multiply(cone.meet_line(p, u), power))


def test_hard_lines_are_never_missed():
    # Points of the rims and of the wall, in whole numbers, and any line through them.
    rng = np.random.default_rng(1)
    cone = Frustum((0, 0, 0), (0, 0, 3), 8, 4)
    turn = np.array([[3, 4], [4, 3], [-3, 4], [5, 0], [0, -5]]) / 5
    for z, radius in ((0, 8), (3, 4), (1.5, 6)):
        p = np.insert(radius * turn, 2, z, axis=-1)
        u = rng.integers(-9, 10, (2000, 5, 3)) + 0.0
        u[np.all(u == 0, axis=-1)] = 1
        enter, leave = cone.meet_line(p, u)
        assert np.all(enter <= 1e-13) and np.all(leave >= -1e-13)
    # Lines along rulings, within the wall.
    ruling = np.insert(-4 * turn, 2, 3, axis=-1)
    enter, leave = cone.meet_line(np.insert(8 * turn, 2, 0, axis=-1), ruling)
    assert np.all(enter <= leave)
    assert np.all(np.abs(leave * 1) <= 1 + 1e-12)


def test_a_line_nearly_along_a_ruling_leaves_the_wall_before_the_tip_that_it_passes():
    # One of a million hard lines: by rounding the wall was as far away all along, and the answer
    # ended at the tip, which the line passes at 450 roundings of the size.
    a = [4.209124715513e50, 3.507603929594167e50, 5.846006549323612e50]
    b = [3.044132530363791e53, 1.5234693067537332e53, 3.8583643225535837e52]
    radii = [5.4718621301669e52, 0.0]
    p = [7.529656435528812e51, -3.039923405648278e50, -5.366634012279076e52]
    u = [4.911527105864659e29, 2.5253976801423366e29, 1.526147954681498e29]
    lines = [np.array([row]) for row in ([*a, *b, *radii, *[0] * 4], p, u)]
    found = Frustum(a, b, *radii).meet_line(p, u)
    faults = judged([np.array([end]) for end in found], "frustum", *lines)
    assert not np.any(faults) and found[1] < 2.0**79 * (1 - 1e-13)


def test_swap_keeps_the_answer():
    rng = np.random.default_rng(2)
    for _ in range(50):
        one = random_frustum(rng)
        other = Frustum(one.b, one.a, one.radius_b, one.radius_a)
        p, u = rng.normal(size=(2, 200, 3))
        np.testing.assert_allclose(one.meet_line(p, u), other.meet_line(p, u), atol=1e-6)


def test_contains_agrees_with_the_definition():
    rng = np.random.default_rng(3)
    for _ in range(20):
        frustum, points = random_frustum(rng), rng.normal(size=(500, 3))
        far = np.abs(depth(frustum, points)) > 1e-12
        np.testing.assert_array_equal(
            frustum.contains(points)[far], depth(frustum, points)[far] > 0
        )


def test_frustum_between_rods():
    rng = np.random.default_rng(4)
    frustum = Frustum((0, 0, 0), (1, 2, 2), 0.3, 0.9)
    p, u = rng.normal(size=(2, 2000, 3))
    mid = frustum.meet_line(p, u)
    thin, thick = (meet_rods(frustum.a, frustum.b, r, p, u) for r in (0.3, 0.9))
    assert np.all(thick[0] <= mid[0] + 1e-12) and np.all(mid[0] <= thin[0] + 1e-12)
    assert np.all(thick[1] >= mid[1] - 1e-12) and np.all(mid[1] >= thin[1] - 1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Frustum((0, 0, 0), (0, 0, 0), 1, 1), "b: must differ from a"),
        (lambda: Frustum((0, 0, 0), (0, 0, 1), -1, 1), "radius_a: must be one finite number"),
        (lambda: Frustum((0, 0, 0), (0, 0, 1), 1, np.nan), "radius_b: must be one finite number"),
        (lambda: Frustum((0, 0), (0, 0, 1), 1, 1), "a: the last axis must hold"),
        (lambda: Frustum((0, 0, 0), (0, 0, 1), 1e-101, 1), "radius_a: must be zero or from 1e-100"),
        (lambda: Frustum((0, 0, 0), (0, 0, 1e-101), 1, 1), "b - a: must be zero or from 1e-100"),
        (lambda: Frustum((0, 0, 0), (0, 0, 1), 1, 1).meet_line((0, 0, 0), (0, 0, 0)), "direction"),
    ],
)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
