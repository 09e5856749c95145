"""Cutters lowered onto points: profiles by hand, and the definition of coming to rest."""

import numpy as np
import pytest

from tests.exact_shapes import EPS
from tunneller_lib.surfaces import Box, Cutter, Frustum, Rod

CUTTERS = {
    "ball": Cutter.ball(3, 20),
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


WRONG = [
    (lambda: Cutter(()), "parts: must be rods, frusta or boxes, one at least; got"),
    (lambda: Cutter((1,)), "parts: must be rods, frusta or boxes"),
    (lambda: Cutter.ball(3, 5), "length: must be at least 6 m; got 5"),
    (lambda: Cutter.ball(0, 5), "radius: must be one finite number above zero"),
    (lambda: Cutter.cone(3, 1.6, 9), "half_angle: must be below pi/2 rad; got 1.6"),
    (lambda: Cutter.cone(3, 0.5, 5), "length: must be at least"),
    (lambda: Cutter.cone(3, 0.5, 9, tip=3), "tip: must be below the shank's 3 m; got 3"),
    (lambda: CUTTERS["flat"].drop([(0, 0)], (0, 0)), "points: the last axis must hold x, y, z"),
    (lambda: CUTTERS["flat"].drop([(0, 0, 0)], (0, np.nan)), "places: must hold finite numbers"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
