"""Cutters lowered onto points and triangles: by hand, by definition, and judged exactly."""

import numpy as np
import pytest

from tests.audit.long import many
from tests.exact_facets import meets
from tests.exact_shapes import EPS
from tunneller_lib.surfaces import Box, Cutter, Frustum, Rod, RoundedDisc

CUTTERS = {
    "ball": Cutter.ball(3, 20),
    "bull": Cutter.bull(3, 1, 20),
    "flat": Cutter.flat(3, 20),
    "drill": Cutter.cone(3, np.radians(59), 20),
    "tapered": Cutter.cone(3, np.radians(10), 30, tip=1),
    "blade": Cutter((Box((-3, -0.5, 0), (6, 0, 0), (0, 1, 0), (0, 0, 20)),)),
    "leaning pick": Cutter(
        (Frustum((0, 0, 0.5), (4, 0, 6), 0.2, 2), Rod((4, 0, 6), (8, 0, 12), 2))
    ),
}
every_cutter = pytest.mark.parametrize("cutter", CUTTERS.values(), ids=CUTTERS)


def cloud(seed, n=400):
    rng = np.random.default_rng(seed)
    return rng.uniform([-10, -10, -2], [10, 10, 2], (n, 3))


def test_mills_reach_from_their_tip_to_the_end_of_their_shank():
    for cutter in (CUTTERS["ball"], CUTTERS["flat"], CUTTERS["drill"]):
        along = [part.meet_line((0, 0, 100), (0, 0, 1)) for part in cutter.parts]
        heights = 100 + np.array([(low, high) for low, high in along])
        assert heights.min() == pytest.approx(0, abs=1e-12)
        assert heights.max() == pytest.approx(20)


@every_cutter
def test_cutter_comes_to_rest_on_a_point(cutter):
    # Where it rests no point is inside, and a little lower one is.
    points, places = cloud(1), np.random.default_rng(2).uniform(-6, 6, (40, 2))
    heights = cutter.drop(points, places)
    assert np.isfinite(heights).all()
    small = 1e-9
    for lift, inside in ((small, False), (-small, True)):
        for place, height in zip(places, heights, strict=True):
            tip = np.array([*place, height + lift])
            enter, leave = cutter.meet_line(points - tip, (0, 0, 1))
            assert np.any((enter <= 0) & (leave >= 0)) == inside


def test_profiles_by_hand():
    away = np.array([0.0, 1, 2, 2.9, 3])
    places = np.stack([-away, 0 * away], axis=-1)
    origin = [(0, 0, 0)]
    np.testing.assert_allclose(
        CUTTERS["ball"].drop(origin, places), np.sqrt(9 - away**2) - 3, atol=8 * EPS
    )
    np.testing.assert_allclose(
        CUTTERS["bull"].drop(origin, places),
        np.sqrt(1 - np.maximum(away - 2, 0) ** 2) - 1, atol=16 * EPS,
    )  # fmt: skip
    np.testing.assert_array_equal(CUTTERS["flat"].drop(origin, places), 0 * away)
    np.testing.assert_allclose(
        CUTTERS["drill"].drop(origin, places), -away / np.tan(np.radians(59)), atol=32 * EPS
    )
    np.testing.assert_allclose(
        CUTTERS["tapered"].drop(origin, places),
        -np.maximum(away - 1, 0) / np.tan(np.radians(10)), atol=1e-13,
    )  # fmt: skip
    assert np.all(CUTTERS["drill"].drop(origin, [(3.0001, 0), (0, -4)]) == -np.inf)


@every_cutter
def test_drop_of_parts_and_blocks_is_the_highest(cutter, monkeypatch):
    points, places = cloud(3), cloud(4, 30)[:, :2]
    whole = cutter.drop(points, places)
    parts = [cutter.drop(part, places) for part in (points[:150], points[150:])]
    np.testing.assert_array_equal(np.maximum(*parts), whole)
    monkeypatch.setattr("tunneller_lib.surfaces.cutter.BLOCK", 1000)
    np.testing.assert_array_equal(cutter.drop(points, places.reshape(5, 6, 2)).ravel(), whole)
    assert cutter.drop(np.empty((0, 3)), (0, 0)) == -np.inf


def mesh(seed, n=7):
    """Return corners and triangles of a rough ground."""
    rng = np.random.default_rng(seed)
    along = np.linspace(-9, 9, n)
    x, y = np.meshgrid(along, along, indexing="ij")
    points = np.stack([x, y, rng.uniform(-1, 1, (n, n))], axis=-1).reshape(-1, 3)
    points[:, :2] += rng.uniform(-0.5, 0.5, (n * n, 2))
    number = np.arange(n * n).reshape(n, n)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(three, axis=-1).reshape(-1, 3)
                            for three in ((a, b, c), (a, c, d))])  # fmt: skip
    return points, faces


def rows_of(cutter):
    """Return the parts of a cutter as the judge's kinds and rows."""
    for part in cutter.parts:
        if isinstance(part, Box):
            yield "box", [*part.corner, *part.x, *part.y, *part.z]
        elif isinstance(part, RoundedDisc):
            yield "rounded", [*part.centre, *part.axis, part.radius, part.corner, 0, 0, 0, 0]
        elif isinstance(part, Frustum):
            yield "frustum", [*part.a, *part.b, part.radius_a, part.radius_b, 0, 0, 0, 0]
        else:
            kind = "capsule" if part.ends == "round" else "rod"
            yield kind, [*part.a, *part.b, part.radius, part.radius, 0, 0, 0, 0]


@every_cutter
def test_drop_on_triangles_is_exact(cutter):
    # A little lower it's in a triangle, a little higher in none: 64 roundings of cutter and mesh.
    points, faces = mesh(5)
    places = np.random.default_rng(6).uniform(-5, 5, (many(2, 20), 2))
    heights = cutter.drop(points, places, faces=faces)
    size = 60.0  # m, of the greatest part, a triangle and the distance between them
    margin = 64 * EPS * size
    for place, height in zip(places, heights, strict=True):
        triangles = points[faces] - [*place, 0]
        lowest = [[float(x) for x in (*corners.min(axis=0), *corners.max(axis=0))]
                  for corners in triangles]  # fmt: skip
        near = [np.all(np.abs([b[0], b[1]]) < 12) and b[5] > height - 1 for b in lowest]
        slack = 16 * EPS * size
        for t, grow, expected in (
            (-height + slack, margin, True),
            (-height - slack, -margin, False),
        ):
            met = any(
                meets(kind, [float(x) for x in row], triangle, [0.0, 0.0, 1.0], t, grow)
                for kind, row in rows_of(cutter)
                for triangle in triangles[near]
            )
            assert met == expected


def test_drop_on_triangles_by_hand():
    # A roof of 45 degrees: on its face, over its lower edge, and beyond.
    roof, faces = [(-90, 0, 0), (90, 0, 0), (0, 400, 400)], [(0, 1, 2)]
    half = np.sqrt(0.5)
    above = {
        "ball": 3 / half - 3,
        "flat": 3.0,
        "bull": 2 + 1 / half - 1,
        "drill": 3 - 3 / np.tan(np.radians(59)),
    }
    for name, height in above.items():
        found = CUTTERS[name].drop(roof, [(0, 10), (0, -3.5)], faces=faces)
        np.testing.assert_allclose(found, [10 + height, -np.inf], rtol=64 * EPS)
    # A level edge that the axis is 2 beside; and over an upright triangle, which is edges alone.
    for edge in ([(-90, 2, 0), (90, 2, 0), (0, 2, -9)], [(-90, 2, 0), (90, 2, 0), (0, 200, -9000)]):
        found = {name: float(CUTTERS[name].drop(edge, (0, 0), faces=faces)) for name in above}
        assert found["flat"] == 0 == found["bull"]
        assert found["ball"] == pytest.approx(np.sqrt(5) - 3, rel=64 * EPS)
        assert found["drill"] == pytest.approx(-2 / np.tan(np.radians(59)), rel=64 * EPS)


def test_cone_on_a_slanting_edge():
    # Over the edge the height is 1 + x/4 - sqrt(x^2 + 1); opencamlib 2023.1.11 has 0.0076.
    edge = [(-4, 1, 0), (4, 1, 2), (0, 9, -9)]
    found = Cutter.cone(3, np.pi / 4, 20).drop(edge, (0, 0), faces=[(0, 1, 2)])
    assert found == pytest.approx(1 - np.sqrt(15) / 4, rel=64 * EPS)


WRONG = [
    (lambda: Cutter(()), "parts: must be a list of Rod or Frustum"),
    (lambda: Cutter((1,)), r"parts\[0\]: must be of class Rod or Frustum"),
    (lambda: Cutter.ball(3, 5), "length: must be at least 6 m; got 5"),
    (lambda: Cutter.ball(0, 5), "radius: must be one finite number above zero"),
    (lambda: Cutter.bull(3, 4, 9), "corner: must not be above the radius 3 m; got 4"),
    (lambda: Cutter.bull(3, 2, 3), "length: must be at least 4 m; got 3"),
    (
        lambda: Cutter.cone(3, 1.6, 9),
        "half_angle: must lie between 0 and pi/2, both left out; got 1.6",
    ),
    (lambda: Cutter.cone(3, 0.5, 5), "length: must be at least"),
    (lambda: Cutter.cone(3, 0.5, 9, tip=3), "tip: must be below the shank's 3 m; got 3"),
    (lambda: CUTTERS["flat"].drop([(0, 0)], (0, 0)), "points: the last axis must hold x, y, z"),
    (lambda: CUTTERS["flat"].drop([(0, 0, 0)], (0, 0), faces=[(0, 0, 1)]), "faces: must name one"),
    (lambda: CUTTERS["flat"].drop([(0, 0, 0)], (0, 0), faces=[0, 0]), "faces: must have the shape"),
    (lambda: CUTTERS["flat"].drop([(0, 0, 0)], (0, np.nan)), "places: must hold finite numbers"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
