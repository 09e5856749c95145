"""Lines against rods, capsules, frusta and boxes: one promise, judged exactly."""

import numpy as np
import pytest

from exhibits.exact_shapes import exact_interval, full_size, judged, size_of
from tests.audit.long import many
from tests.hard_lines import FAMILIES, KINDS, WITH_AXES, limits, meet, shape_of
from tunneller_lib.surfaces import Box, Frustum, Rod

FAR = 1e15  # sizes from which the promise holds, as the docstrings say
LINES = many(50, 2_500)  # a family and kind, each judged in whole numbers
CONE = [0, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 0]  # of radius 4 and height 3
UNIT = [0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2]
every_kind = pytest.mark.parametrize("kind", KINDS)
every_family = pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.__name__)


@every_kind
@every_family
def test_hard_lines_keep_the_promise(family, kind):
    lines = family(kind, np.random.default_rng(1), LINES)
    assert not np.any(judged(meet(kind, *lines), kind, *lines))


def promised(kind, shapes, p, u):
    """Return for which lines (n,) the docstrings promise anything: those given near enough."""
    ends = [shapes[:, :3], shapes[:, 3:6]] if kind in WITH_AXES else [shapes[:, :3]]
    away = np.max([np.linalg.norm(p - end, axis=-1) for end in ends], axis=0)
    return away <= FAR * size_of(kind, shapes, u)


@every_kind
def test_shapes_at_their_limits_keep_the_promise_line_by_line_and_many_at_once(kind):
    # Each shape with lines of many directions through a place of its surface, and parallel ones.
    shapes, p, u = limits(kind, np.random.default_rng(21), many(25, 400))
    asked = 0
    for i in range(len(shapes)):
        shape = shape_of(kind, shapes[i])
        step = 2.0 ** np.frexp(full_size(kind, shapes[i : i + 1]) / np.abs(u[i]).max())[1]
        for points, along in ((p[i], u), (p[i] + np.outer([-2, 0, 1] * step, u[i]), u[i])):
            found = shape.meet_line(points, along)
            points, along = np.broadcast_arrays(points, along)
            alone = [shape.meet_line(*line) for line in zip(points, along, strict=True)]
            np.testing.assert_array_equal(np.transpose(alone), found)
            rows = np.tile(shapes[i], (len(points), 1))
            asked += np.sum(near := promised(kind, rows, points, along))
            wrong = judged(found, kind, rows, points, along)
            assert not np.any(wrong & near)
    assert asked > 0.8 * len(shapes) * (3 + len(u))


def test_points_without_a_size_are_met_where_they_are():
    assert Rod((1, 2, 3), (1, 2, 3), 0, "round").meet_line((1, 2, 3), (4, 5, -6)) == (0, 0)
    assert Rod((1, 2, 3), (1, 2, 3), 0, "round").meet_line((1, 2, 4), (0, 1, 0))[0] == np.inf


@pytest.mark.parametrize(("kind", "shape", "point", "way", "grown", "expected"), [
    ("frustum", CONE, (4, 0, 0), (-4, 0, 3), 0, [0, 1]),
    ("frustum", CONE, (2, 0, -1), (0, 0, 1), 0, [1, 2.5]),
    # One unit outside of it the wall's radius is 20/3 at the base, the disc's is 5.
    ("frustum", CONE, (0, 0, -1), (1, 0, 0), 1.0, [-5, 5]),
    ("frustum", CONE, (-9, 0, 1.75), (1, 0, 0), 1.0, [9 - 10 / 3, 9 + 10 / 3]),
    ("frustum", CONE, (0, 0, -9), (0, 0, 1), -0.75, [9.75, 12 - 0.75 / 0.8]),
    ("capsule", [*[0] * 6, 13, 13, *[0] * 4], (0, 5, 0), (1, 0, 0), 0, [-12, 12]),
    ("box", UNIT, (-1, 1, 3), (1, 0, -1), 0, [1, 3]),
    ("box", UNIT, (-1, 0, 5), (1, 0, -1), 0, [3, 3]),
])  # fmt: skip
def test_judge_by_hand(kind, shape, point, way, grown, expected):
    found = exact_interval(kind, shape, point, way, grown)
    assert [float(end) for end in found] == pytest.approx(expected, rel=1e-15)


def test_a_box_must_be_square():
    for edges, rule in (
        ([(0, 0, 0), (0, 1, 0), (0, 0, 1)], "not be zero"),
        ([(1, 1e-9, 0), (0, 1, 0), (0, 0, 1)], "be perpendicular"),
        ([(1e-101, 0, 0), (0, 1, 0), (0, 0, 1)], "be zero or from 1e-100"),
    ):
        with pytest.raises(ValueError, match=f"^x, y, z: must {rule}"):
            Box((0, 0, 0), *edges)
    assert Box((0, 0, 0), (1, 1e-15, 0), (0, 1, 0), (0, 0, 1))  # but for a rounding


# ---- frusta ---------------------------------------------------------------------------------


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
