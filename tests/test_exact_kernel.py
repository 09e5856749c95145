"""Lines against rods, capsules, frusta and boxes: one promise, one judge in whole numbers."""

import tracemalloc

import numpy as np
import pytest

from tests.audit.long import many
from tests.exact_shapes import EPS, exact_interval, exact_intervals, full_size, judged, size_of
from tests.hard_lines import (
    FAMILIES,
    KINDS,
    WITH_AXES,
    Whole,
    limits,
    ordinary,
    scaled,
    sizes,
    some,
)
from tunneller_lib.surfaces import Box, Frustum, Rod, RoundedDisc, meet_box
from tunneller_lib.surfaces.box import meet_boxes
from tunneller_lib.surfaces.frustum import meet_frusta
from tunneller_lib.surfaces.rod import meet_rods
from tunneller_lib.surfaces.rounded_disc import meet_rounded_discs

FAR = 1e15  # sizes from which the promise holds, as the docstrings say
LINES = many(75, 2_500)  # a family and kind, each judged in whole numbers
MIDDLING = [
    f for f in FAMILIES if f not in (scaled, sizes, limits)
]  # not at the range's ends already
every_kind = pytest.mark.parametrize("kind", KINDS)
every_family = pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.__name__)


def fewer(kind, n):
    """Return how many lines of a kind are judged: halving takes the judge fifty times as long."""
    return max(n // 25, 1) if kind == "rounded" else n


def meet(kind, shapes, p, u):
    """Return where lines enter and leave shapes (n, 12)."""
    a, b, radius, other = shapes[..., :3], shapes[..., 3:6], shapes[..., 6], shapes[..., 7]
    if kind == "box":
        return meet_boxes(a, b, shapes[..., 6:9], shapes[..., 9:], p, u)
    if kind == "frustum":
        return meet_frusta(a, b, radius, other, p, u)
    if kind == "rounded":
        return meet_rounded_discs(a, b, radius, other, p, u)
    return meet_rods(a, b, radius, p, u, ends="round" if kind == "capsule" else "flat")


@every_kind
@every_family
def test_kernel_keeps_its_promise(family, kind):
    lines = family(kind, np.random.default_rng(1), fewer(kind, LINES))
    missed, thin, thick = judged(meet(kind, *lines), kind, *lines)
    assert not missed.any() and not thin.any() and not thick.any()


def shape_of(kind, row):
    """Return a shape of the library."""
    a, b = row[:3], row[3:6]
    if kind == "box":
        return Box(a, b, row[6:9], row[9:])
    if kind == "frustum":
        return Frustum(a, b, *row[6:8])
    if kind == "rounded":
        return RoundedDisc(a, b, *row[6:8])
    return Rod(a, b, row[6], ends="round" if kind == "capsule" else "flat")


@every_kind
@every_family
def test_quick_way_leaves_hard_lines_to_the_careful_one(family, kind):
    # One shape at a time, each with its hard line and the ordinary lines beside it.
    lines = family(kind, np.random.default_rng(6), fewer(kind, many(8, 300)))
    found = np.array([
        shape_of(kind, row).meet_line(p[None], u[None]) for row, p, u in zip(*lines, strict=True)
    ])[..., 0].T  # fmt: skip
    assert not np.any(judged(found, kind, *lines))
    with_one = np.array([
        shape_of(kind, row).meet_line(p[None], u) for row, p, u in zip(*lines, strict=True)
    ])[..., 0].T  # fmt: skip
    assert not np.any(judged(with_one, kind, *lines))


@every_kind
@every_family
def test_one_line_has_the_bits_of_many(family, kind):
    # In floats or in rows, the quick way's answers and the careful one's.
    shapes, p, u = family(kind, np.random.default_rng(11), fewer(kind, many(38, 300)))
    rows = list(zip(shapes, p, u, strict=True))
    each = [meet(kind, *(part[None] for part in row)) for row in rows]
    np.testing.assert_array_equal(np.concatenate(each, axis=-1), meet(kind, shapes, p, u))
    for row, point, way in rows:
        shape = shape_of(kind, row)
        alone = shape.meet_line(point, way)
        assert all(type(end) is np.float64 for end in alone)
        both = np.stack([point, point + way])
        beside = shape.meet_line(both, np.stack([way, way]))
        np.testing.assert_array_equal(alone, np.array(beside)[:, 0])
        # One direction for all, as a raster has it.
        np.testing.assert_array_equal(shape.meet_line(both, way), beside)


def promised(kind, shapes, p, u):
    """Return for which lines (n,) the docstrings promise anything: those given near enough."""
    ends = [shapes[:, :3], shapes[:, 3:6]] if kind in WITH_AXES else [shapes[:, :3]]
    away = np.max([np.linalg.norm(p - end, axis=-1) for end in ends], axis=0)
    return away <= FAR * size_of(kind, shapes, u)


@every_kind
def test_shapes_at_their_limits_keep_the_promise_line_by_line_and_many_at_once(kind):
    # Each shape with lines of many directions through a place of its surface, and parallel ones.
    shapes, p, u = limits(kind, np.random.default_rng(21), many(40, 400))
    every = 4 if kind == "rounded" else 1  # whose judge takes twenty times as long
    asked = 0
    for i in range(0, len(shapes), every):
        shape = shape_of(kind, shapes[i])
        step = 2.0 ** np.frexp(full_size(kind, shapes[i : i + 1]) / np.abs(u[i]).max())[1]
        for points, along in ((p[i], u[::every]), (p[i] + np.outer([-2, 0, 1] * step, u[i]), u[i])):
            found = shape.meet_line(points, along)
            points, along = np.broadcast_arrays(points, along)
            alone = [shape.meet_line(*line) for line in zip(points, along, strict=True)]
            np.testing.assert_array_equal(np.transpose(alone), found)
            rows = np.tile(shapes[i], (len(points), 1))
            asked += np.sum(near := promised(kind, rows, points, along))
            wrong = judged(found, kind, rows, points, along)
            assert not np.any(wrong & near)
    assert asked > 0.8 * len(shapes[::every]) * (3 + len(u[::every]))


def test_points_without_a_size_are_met_where_they_are():
    assert RoundedDisc((1, 2, 3), (1, 1, 0), 0, 0).meet_line((1, 2, 3), (4, 5, -6)) == (0, 0)
    assert Rod((1, 2, 3), (1, 2, 3), 0, "round").meet_line((1, 2, 3), (4, 5, -6)) == (0, 0)
    assert RoundedDisc((1, 2, 3), (1, 1, 0), 0, 0).meet_line((1, 2, 4), (0, 1, 0))[0] == np.inf


def far_away(kind, rng, n):
    """Return touches given by points as far away as the promise allows, exactly on their lines."""
    whole = Whole(kind, rng, n)
    turn = rng.integers(-5, 6, (2, n, 1))
    tangent = whole.side * turn[0] + whole.ruling * turn[1]
    which = rng.integers(0, 3, n)[:, None]
    shapes, p, u = whole.lines(np.select([which == 0, which == 1], [tangent, whole.ruling],
                                         some(rng, n)))  # fmt: skip
    # The touch is at the origin, where multiples of the direction are exact.
    shapes[:, :3] -= p
    if kind in WITH_AXES:
        shapes[:, 3:6] -= p
    steps = FAR * size_of(kind, shapes, u) / np.linalg.norm(u, axis=-1)
    power = np.frexp(steps)[1] - (53 - np.frexp(np.abs(u).max(axis=-1))[1])  # all that fit beside u
    steps = np.ldexp(np.floor(np.ldexp(steps, -power) * rng.uniform(0.9, 1, n)), power)
    return shapes, u * (steps * rng.choice([-1, 1], n))[:, None], u


@every_kind
def test_promise_holds_for_points_1e15_sizes_away(kind):
    shapes, p, u = lines = far_away(kind, np.random.default_rng(23), fewer(kind, many(400, 4000)))
    away = np.linalg.norm(p, axis=-1) / size_of(kind, shapes, u)
    assert np.all((away > 0.8 * FAR) & (away < 1.01 * FAR))
    enter, leave = exact_intervals(kind, *lines)
    assert np.all(enter <= leave)
    assert not np.any(judged(meet(kind, *lines), kind, *lines))
    for row, point, way in list(zip(*lines, strict=True))[:20]:
        alone = np.array(shape_of(kind, row).meet_line(point, way))
        assert not np.any(judged(alone[:, None], kind, row[None], point[None], way[None]))


@pytest.mark.parametrize("kind", WITH_AXES)
@pytest.mark.parametrize("ratio", [1e3, 1e9, FAR])
def test_promise_holds_for_needles_seen_end_on(kind, ratio):
    # As long as 1e15 sizes: what lines nearly along the axis see of them is as wide as they are.
    rng, n = np.random.default_rng(24), many(200, 2000)
    axis, other, a = rng.normal(size=(3, n, 3))
    axis *= ratio / np.linalg.norm(axis, axis=-1, keepdims=True)
    side = np.cross(axis, other)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    radii = np.repeat(rng.uniform(0.5, 1, (n, 1)), 2, axis=-1)
    if kind == "frustum":
        radii[:, 1] *= rng.choice([0, 0.5, 1], n)
    b = a + axis
    start = rng.integers(0, 2, n)
    p = np.where(start[:, None], b, a) + side * radii[np.arange(n), start][:, None]
    lean = rng.choice([0, 2.0**-3, 1, 8], n)[:, None] * rng.normal(size=(n, 3))
    lines = np.concatenate([a, b, radii, np.zeros((n, 4))], axis=-1), p, (b - a) + lean
    found = meet(kind, *lines)
    assert np.mean(found[0] <= found[1]) > 0.5
    assert not np.any(judged(found, kind, *lines))


@every_kind
@pytest.mark.parametrize("far", [0, 3, 1e4])
@pytest.mark.parametrize("proportion", [1e-3, 0.3, 1, 4, 1e3])
def test_many_lines_against_one_shape(kind, proportion, far):
    # Through points about its surface, from near and from far, and between points anywhere.
    rng = np.random.default_rng(7)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    edges = turn * np.array([[1.0], [proportion], [rng.uniform(0.2, 2)]])
    at = rng.normal(size=3)
    row = np.array([*at, *edges.ravel()])
    if kind != "box":
        row = np.array([*at, *(at + edges[0]), proportion, proportion, 0, 0, 0, 0])
        row[7] *= rng.uniform(0, 1) if kind == "frustum" else 1
    shape, n = shape_of(kind, row), many(30, 4000)
    n = max(n // 100, 4) if kind == "rounded" else n
    p = (
        at + rng.normal(size=(n, 3)) @ edges
        if kind == "box"
        else (at + rng.uniform(-0.2, 1.2, (n, 1)) * edges[0] + rng.normal(size=(n, 3)) * proportion)
    )
    u = rng.normal(size=(n, 3))
    u[::3] = turn[rng.integers(0, 3, len(u[::3]))]  # along the axis or an edge, within rounding
    p = p - far * u
    shapes = np.tile(row, (n, 1))
    assert not np.any(judged(shape.meet_line(p, u), kind, shapes, p, u))
    for one in (u[0], u[1]):
        assert not np.any(judged(shape.meet_line(p, one), kind, shapes, p, np.tile(one, (n, 1))))


@every_kind
@pytest.mark.parametrize("family", MIDDLING, ids=lambda f: f.__name__)
def test_kernel_scales_by_powers_of_two_bit_for_bit(family, kind):
    shapes, p, u = family(kind, np.random.default_rng(2), 200)
    found = meet(kind, shapes, p, u)
    for power in (-90, 7):
        k = 2.0**power
        np.testing.assert_array_equal(meet(kind, shapes * k, p * k, u), np.multiply(found, k))
        np.testing.assert_array_equal(np.multiply(meet(kind, shapes, p, u * k), k), found)


@every_kind
def test_judge_notices_each_fault(kind):
    # An answer emptied, one end moved inwards or outwards by more than the promise.
    n = many(200, 600) if kind != "rounded" else many(24, 60)
    lines = ordinary(kind, np.random.default_rng(3), n)
    shapes, _, u = lines
    enter, leave = exact_intervals(kind, *lines)
    chord = leave - enter
    hit = chord * np.linalg.norm(u, axis=-1) > 0.1 * size_of(kind, shapes, u)
    assert hit.sum() >= 5
    step = np.where(hit, chord / 100, 0)
    wrong = [
        (np.where(hit, np.inf, enter), np.where(hit, -np.inf, leave)),
        (enter + step, leave),
        (enter - step, leave),
    ]
    for found, fault in zip(wrong, range(3), strict=True):
        verdicts = judged(found, kind, *lines)
        np.testing.assert_array_equal(verdicts[fault], hit)
    assert not np.any(judged((enter, leave), kind, *lines))
    # A hit invented for a line that misses.
    missing = enter > leave
    verdicts = judged((np.where(missing, 0.0, enter), np.where(missing, 0.0, leave)), kind, *lines)
    assert verdicts[2][missing].all() and missing.sum() >= 5


def test_judge_by_hand():
    # A cone of radius 4 and height 3, in whole numbers; a ball; a unit box.
    cone = [0, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 0]
    assert exact_interval("frustum", cone, (-5, 0, 3), (1, 0, 0)) == [5, 5]
    assert exact_interval("frustum", cone, (4, 0, 0), (-4, 0, 3)) == [0, 1]
    assert exact_interval("frustum", cone, (0, 0, 4), (1, 0, 0)) is None
    assert exact_interval("frustum", cone, (2, 0, -1), (0, 0, 1)) == [1, 2.5]
    # One unit outside of it the wall's radius is 20/3 at the base, the disc's is 5.
    grown = exact_interval("frustum", cone, (0, 0, -1), (1, 0, 0), 1.0)
    assert [float(end) for end in grown] == [-5, 5]
    grown = exact_interval("frustum", cone, (-9, 0, 1.75), (1, 0, 0), 1.0)
    assert [float(end) for end in grown] == pytest.approx([9 - 10 / 3, 9 + 10 / 3], rel=1e-15)
    shrunk = exact_interval("frustum", cone, (0, 0, -9), (0, 0, 1), -0.75)
    assert [float(end) for end in shrunk] == pytest.approx([9.75, 12 - 0.75 / 0.8], rel=1e-15)
    ball = [0, 0, 0, 0, 0, 0, 13, 13, 0, 0, 0, 0]
    assert exact_interval("capsule", ball, (0, 5, 0), (1, 0, 0)) == [-12, 12]
    box = [0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2]
    assert exact_interval("box", box, (-1, 1, 3), (1, 0, -1)) == [1, 3]
    assert exact_interval("box", box, (-1, 0, 5), (1, 0, -1)) == [3, 3]
    assert exact_interval("box", box, (-1, 0, 5.5), (1, 0, -1)) is None


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9, 1e-12])
def test_flat_cones_keep_their_chords(height):
    # Lines that slant through a cone much wider than high, which lost up to 0.6 of its radius.
    rng = np.random.default_rng(5)
    n = 500
    angle = rng.uniform(0, 2 * np.pi, n)
    unit = np.stack([np.cos(angle), np.sin(angle), height * rng.normal(size=n)], axis=-1)
    p = np.insert(rng.uniform(-0.5, 0.5, (n, 2)), 2, height * rng.uniform(0, 0.4, n), axis=-1)
    shapes = np.tile([0, 0, 0, 0, 0, height, 1, 0, 0, 0, 0, 0], (n, 1))
    found = Frustum((0, 0, 0), (0, 0, height), 1, 0).meet_line(p, unit)
    exact = exact_intervals("frustum", shapes, p, unit)
    assert not np.any(judged(found, "frustum", shapes, p, unit))
    # Rounding places the wall to eps of the radius, and so an end to that over the slope between
    # line and wall, which is the height in the median.
    assert np.median(np.abs(np.subtract(found, exact))) <= 64 * EPS / height


AXES = [(12, 3, 4), (8, 9, 12), (12, 4, 3), (8, 12, 9), (15, 12, 16), (3, 4, 0), (0, 3, 4)]


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_meet_box_touches_flat_rods_at_their_sides(axis, side):
    # In whole numbers: how far a disc reaches along x is its radius times a whole ratio.
    rng = np.random.default_rng(6)
    v = np.array(axis)
    wide, length = round(np.hypot(*v[1:])), round(np.linalg.norm(v))
    for _ in range(many(20, 50)):
        step = rng.integers(1, 40)
        a = rng.integers(-999, 1000, 3)
        b = a + v * rng.integers(1, 300)
        end = b if side > 0 else a
        tip = end + side * step * np.array([wide**2, -v[0] * v[1], -v[0] * v[2]])
        low = tip[:2] - (5 if side < 0 else 0, 5)
        bottom, top = meet_box(Rod(a, b, int(step * wide * length)), low, low + np.array([5, 10]))
        assert bottom <= top
        # A touch in a point of the rim, but for a lying axis: there it's a ruling or a disc.
        if v[0] and v[2]:
            size = step * wide * length + np.linalg.norm(b - a)
            # Within the guard beside the touch the rim has risen by the root of it.
            assert abs(top - tip[2]) <= 8 * np.sqrt(EPS) * size


BOX = Box((1, 2, 3), (2, 0, 0), (0, 2, 0), (0, 0, 2))


@every_kind
def test_memory_a_line_with_a_shape_of_its_own_is_at_most_64_bytes(kind):
    n = 300_000 if kind != "rounded" else 100_000
    rng = np.random.default_rng(8)
    p, u = rng.normal(size=(2, n, 3))
    row = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1] if kind == "box" else [0, 0, 0, 1, 0, 0, 0.5, 0.4]
    shapes = np.tile(np.array([*row, *[0] * (12 - len(row))], dtype=float), (n, 1))
    tracemalloc.start()
    meet(kind, shapes, p, u)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most <= 64 * n


def test_a_box_by_hand():
    cases = {
        ((0, 3, 4), (1, 0, 0)): (1, 3),
        ((0, 2, 3), (1, 0, 0)): (1, 3),  # along an edge
        ((0, 3, 3), (1, 0, 0)): (1, 3),  # in a face
        ((0, 2, 4), (1, 0, 1)): (1, 1),  # touches an edge
        ((0, 1, 2), (1, 1, 1)): (1, 3),  # through two corners
        ((0, 3, 2), (1, -1, 1)): (1, 1),  # touches a corner
        ((0, 3, 2.999999), (1, 0, 0)): (np.inf, -np.inf),
    }
    for (p, u), expected in cases.items():
        assert BOX.meet_line(p, u) == expected


def test_a_rounded_disc_holds_the_points_within_its_corner_s_radius_of_the_disc():
    disc = RoundedDisc((0.1, 0.2, 0.3), (0.0, 0.0, 5.0), 0.03, 0.01)  # m
    away = {  # beside the axis and along it, in m
        (0.0, 0.0): True, (0.02, 0.0099): True, (0.02, 0.0101): False, (0.0399, 0.0): True,
        (0.0401, 0.0): False, (0.037, 0.007): True, (0.038, 0.007): False, (0.0, -0.0099): True,
    }  # fmt: skip
    turn = np.random.default_rng(4).uniform(0, 2 * np.pi, len(away))
    beside, along = np.array(list(away)).T
    way = np.stack([beside * np.cos(turn), beside * np.sin(turn), along], axis=-1)
    points = way + np.array([0.1, 0.2, 0.3])
    assert disc.contains(points).tolist() == list(away.values())
    assert disc.contains((0.1, 0.2, 0.31)) and disc.contains((0.14, 0.2, 0.3))  # on the surface
