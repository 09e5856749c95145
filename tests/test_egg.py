"""The sewer section and its offsets: arcs, blends, area, perimeter, depth."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.audit.long import many
from tests.shapes import log_uniform
from tunneller_lib.surfaces import Egg

SCALES = pytest.mark.parametrize("a", [1e-3, 0.5, 1e6])
OFFSETS = pytest.mark.parametrize("share", [-2, 0, 0.36, 0.4999, 0.5, 0.75, 0.999])
eggs = st.builds(Egg, log_uniform(1e-3, 1e6))


def polygon(section, n=20_000):
    """Return points of a section, evenly over each arc, so that every blend is one of them."""
    arcs = pairwise(section.blends)
    return section.point(np.concatenate([np.linspace(*arc, n, endpoint=False) for arc in arcs]))


def shoelace(points):
    y, z = points.T
    return np.sum(y * np.roll(z, -1) - z * np.roll(y, -1)) / 2


def to_curve(curve, points):
    """Return the distances of points from a polygon's corners."""
    return np.array([np.min(np.linalg.norm(curve - p, axis=-1)) for p in points])


@SCALES
def test_point_at_the_blends_and_extremes(a):
    egg, sides = Egg(a), np.arctan2(3, 4)
    roof, wall = np.pi * a, 3 * a * sides
    invert = egg.perimeter - roof - 2 * wall
    np.testing.assert_allclose(np.diff(egg.blends), [roof, wall, invert, wall], rtol=1e-14)
    corners = [(1, 0), (-1, 0), (-0.4, -1.8), (0.4, -1.8), (1, 0)]
    np.testing.assert_allclose(egg.point(egg.blends), np.multiply(a, corners), atol=1e-15 * a)
    crown_and_invert = egg.point([roof / 2, roof / 2 + egg.perimeter / 2])
    np.testing.assert_allclose(crown_and_invert, [(0, a), (0, -2 * a)], atol=2e-15 * a)


@SCALES
def test_point_fills_a_box_of_2a_by_3a(a):
    points = polygon(Egg(a))
    np.testing.assert_allclose(np.ptp(points, axis=0), [2 * a, 3 * a], rtol=1e-8)


@OFFSETS
def test_point_is_continuous_and_smooth_over_the_blends(share):
    section = Egg(0.5).offset(0.5 * share)
    gap = 1e-12
    before, after = section.blends[:-1] - gap, section.blends[:-1] + gap
    np.testing.assert_allclose(section.point(before), section.point(after), atol=1e-11)
    turn = np.linalg.norm(section.normal(before) - section.normal(after), axis=-1)
    corner = np.arange(len(section.arcs)) == 2
    if share >= 0.5:  # the walls meet below in a corner, as straight as they come to it
        assert np.all(turn[~corner] <= 1e-8) and turn[2] > (0.1 if share > 0.5 else 1)
    else:
        assert np.all(turn <= 1e-6)


@given(eggs, st.floats(-3, 3), st.floats(0, 1e-3))
def test_point_moves_by_arc_length_along_the_tangent(egg, turns, step):
    s = turns * egg.perimeter
    chord = egg.point(s + step * egg.a) - egg.point(s)
    length = np.linalg.norm(chord)
    assert length <= step * egg.a * (1 + 1e-9) + 1e-14 * egg.a
    assert length >= step * egg.a * (1 - step**2) - 1e-14 * egg.a
    assert abs(chord @ egg.normal(s)) <= 2 * step**2 * egg.a + 1e-14 * egg.a


@given(eggs, st.floats(0, 1), st.integers(-3, 3))
def test_point_repeats_with_the_perimeter(egg, share, turns):
    s = share * egg.perimeter
    apart = egg.point(s + turns * egg.perimeter) - egg.point(s)
    assert np.linalg.norm(apart) <= 1e-14 * egg.perimeter


@SCALES
@OFFSETS
def test_area_and_perimeter_against_a_polygon(a, share):
    section = Egg(a).offset(share * a)
    points = polygon(section)
    sides = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=-1)
    assert section.perimeter == pytest.approx(np.sum(sides), rel=1e-8)
    assert section.area == pytest.approx(shoelace(points), rel=1e-8)


@given(eggs, st.floats(-3, 0.4999))
def test_offset_obeys_steiner(egg, share):
    d, section = share * egg.a, egg.offset(share * egg.a)
    L, A = egg.perimeter, egg.area
    assert section.perimeter == pytest.approx(L - 2 * np.pi * d, rel=1e-12)
    assert section.area == pytest.approx(A - L * d + np.pi * d**2, rel=1e-11, abs=1e-14 * A)


@SCALES
@OFFSETS
def test_offset_is_at_its_distance_inside(a, share):
    egg = Egg(a)
    section = egg.offset(share * a)
    points = section.point(np.linspace(0, section.perimeter, many(100, 400)))
    np.testing.assert_allclose(egg.depth(*points.T), share * a, atol=1e-12 * a)
    far = to_curve(polygon(egg, 4000), points)
    np.testing.assert_allclose(far, abs(share) * a, atol=1e-3 * a)


@pytest.mark.parametrize("share", [0.5, 0.6, 0.75, 0.99])
def test_offset_beyond_degeneration_has_its_corner(share):
    a, d = 0.7, 0.7 * share
    section = Egg(a).offset(d)
    assert len(section.arcs) == 3
    corner = (0, -np.sqrt((3 * a - d) ** 2 - 4 * a**2))
    np.testing.assert_allclose(section.point(section.blends[2]), corner, atol=1e-15)


def test_offset_passes_its_degeneration_continuously():
    below, above = (Egg(1).offset(0.5 + gap) for gap in (-1e-12, 1e-12))
    assert [len(s.arcs) for s in (below, above)] == [4, 3]
    assert below.perimeter == pytest.approx(above.perimeter, abs=1e-10)
    assert below.area == pytest.approx(above.area, abs=1e-10)


@pytest.mark.parametrize("share", [1, 1 + 1e-15, 2, 1e9])
def test_offset_of_the_roof_radius_or_more_is_refused(share):
    with pytest.raises(ValueError, match=r"^d: must be below the roof's radius a = 0.5 m, or noth"):
        Egg(0.5).offset(0.5 * share)


@OFFSETS
def test_depth_against_sampled_distance(share):
    a = 0.5
    section = Egg(a).offset(share * a)
    low, high = [-1.5 * a, -2.8 * a], [1.5 * a, 1.8 * a]
    points = np.random.default_rng(1).uniform(low, high, (many(120, 400), 2))
    curve = polygon(section, 5000)
    depth = section.depth(*points.T)
    step = np.max(np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=-1))
    missed = to_curve(curve, points) ** 2 - depth**2  # what the samples miss, by Pythagoras
    assert np.all((-1e-14 < missed) & (missed < step**2 + 1e-10))
    edges, away = np.roll(curve, -1, axis=0) - curve, points[:, None] - curve
    inside = np.all(edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0] > 0, axis=-1)
    clear = np.abs(depth) > 1e-6
    np.testing.assert_array_equal((depth > 0)[clear], inside[clear])


@SCALES
@OFFSETS
def test_depth_on_the_curve_is_zero_and_along_the_normal_it_falls(a, share):
    section = Egg(a).offset(share * a)
    s = section.perimeter * np.linspace(0, 1, 500, endpoint=False) + 1e-4 * a
    point, normal = section.point(s), section.normal(s)
    np.testing.assert_allclose(section.depth(*point.T), 0, atol=1e-12 * a)
    inward = [-1e-4] if share < 0.5 else []  # inside a corner the other wall may be nearer
    for out in (*inward, 1e-3, 1, 1e6):
        found = section.depth(*(point + out * a * normal).T)
        np.testing.assert_allclose(found, -out * a, rtol=1e-12, atol=1e-12 * a)


@pytest.mark.parametrize("y, z, depth", [
    (0, 0, 1),  # the roof's centre: the whole roof is equally near
    (0, -1.5, 0.5),  # the invert's
    (2, 0, -1), (-2, 0, -1),  # the walls' own centres, outside
    (0, 5, -4), (0, -7, -5), (0, -1, 3 - 5**0.5), (1, 0, 0), (0.4, -1.8, 0),
])  # fmt: skip
def test_depth_at_special_points(y, z, depth):
    assert Egg(1).depth(y, z) == pytest.approx(depth, abs=1e-15)


def test_depth_beyond_a_corner_is_measured_to_it():
    section = Egg(1).offset(0.75)
    corner = section.point(section.blends[2])
    assert section.depth(*(corner - [0, 3])) == pytest.approx(-3, abs=1e-14)


def test_depth_broadcasts():
    assert Egg(1).depth(np.zeros((4, 1)), np.zeros(5)).shape == (4, 5)
    assert np.ndim(Egg(1).depth(0, 0)) == 0
    assert Egg(1).point(np.zeros((4, 5))).shape == (4, 5, 2)
