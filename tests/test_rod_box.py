"""Boxes against rods: line by line where the box is thin, by a search and by support elsewhere."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.audit.long import many
from tunneller_lib.surfaces import Rod, meet_box

KINDS = ("any", "vertical", "level", "along x", "along y", "nearly vertical", "nearly level")


def rod_of(kind, rng, ends, scale=1.0):
    """Return a rod whose axis is of a kind."""
    v = rng.normal(size=3)
    v[:2] *= {"vertical": 0, "nearly vertical": 1e-9}.get(kind, 1)
    v[2] *= {"level": 0, "along x": 0, "along y": 0, "nearly level": 1e-9}.get(kind, 1)
    v *= {"along x": [1, 0, 1], "along y": [0, 1, 1]}.get(kind, 1)
    a = rng.normal(size=3)
    return Rod(a * scale, (a + v) * scale, rng.uniform(0.1, 1) * scale, ends=ends)


def searched(rod, low, high, side):
    """Return the highest (or lowest) point by zooming in on a concave height over the section."""
    best, where = -np.inf, None
    first, last = low.copy(), high.copy()
    for _ in range(60):
        x, y = (np.linspace(*ends, 13) for ends in zip(first, last, strict=True))
        grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((13, 13))], axis=-1)
        enter, leave = rod.meet_line(grid, (0, 0, 1))
        height = side * (leave if side > 0 else enter)
        height = np.where(np.isfinite(height), height, -np.inf)
        i, j = np.unravel_index(np.argmax(height), height.shape)
        if height[i, j] == -np.inf:
            return where, best
        best, where = max(best, height[i, j]), (x[i], y[j])
        span = (last - first) / 3
        first = np.maximum(low, np.array(where) - span)
        last = np.minimum(high, np.array(where) + span)
    return where, best


@pytest.mark.parametrize("ends", ["flat", "round"])
@pytest.mark.parametrize("kind", KINDS)
def test_meet_box_is_what_a_search_finds(kind, ends):
    rng = np.random.default_rng(0)
    met = 0
    for _ in range(15):
        rod = rod_of(kind, rng, ends)
        low = np.array(rod.a)[:2] + rng.normal(size=2)
        high = low + rng.uniform(0.05, 2, 2)
        bottom, top = meet_box(rod, low, high)
        place, height = searched(rod, low, high, 1)
        if place is None:
            continue
        met += 1
        assert top >= height - 1e-9
        assert top <= height + 1e-4 or ends == "flat"  # a search halts at edges
        assert bottom <= -searched(rod, low, high, -1)[1] + 1e-9
        assert np.isfinite(top) and np.isfinite(bottom) and bottom <= top
    assert met >= 2


@pytest.mark.parametrize("ends", ["flat", "round"])
@settings(max_examples=many(8, 200))
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS), st.sampled_from([1e-6, 1.0, 1e6]))
def test_top_is_a_point_of_the_rod_in_the_box(ends, seed, kind, scale):
    # Halve the box towards its highest part until it is a point: the rod must be there.
    rng = np.random.default_rng(seed)
    rod = rod_of(kind, rng, ends, scale)
    centre = (np.array(rod.a) + np.array(rod.b))[:2] / 2 + rng.normal(size=2) * 0.3 * scale
    low, high = centre - 0.3 * scale, centre + rng.uniform(0, 0.5) * scale
    top = meet_box(rod, low, high)[1]
    if top == -np.inf:
        return
    for step in range(60):
        cut = [low.copy(), high.copy()]
        cut[0][step % 2] = cut[1][step % 2] = (low + high)[step % 2] / 2
        tops = meet_box(rod, np.array([low, cut[0]]), np.array([cut[1], high]))[1]
        low, high = (low, cut[1]) if tops[0] >= tops[1] else (cut[0], high)
    assert meet_box(rod, low, high)[1] == pytest.approx(top, abs=1e-12 * scale)
    tip = np.array([*(low + high) / 2, top])
    stretch = 1e-8 * rod.axis
    grown = Rod(rod.a - stretch, rod.b + stretch, rod.radius + 1e-8 * scale, ends=ends)
    assert grown.contains(tip)


def test_meet_box_of_a_point_is_a_line():
    rng = np.random.default_rng(1)
    for kind in KINDS:
        for ends in ("flat", "round"):
            rod = rod_of(kind, rng, ends)
            xy = np.array(rod.a)[:2] + rng.normal(size=(500, 2)) * 0.7
            enter, leave = rod.meet_line(np.insert(xy, 2, 0, axis=-1), (0, 0, 1))
            bottom, top = meet_box(rod, xy, xy)
            clear = np.isfinite(enter) & (leave - enter > 1e-3)
            np.testing.assert_allclose(bottom[clear], enter[clear], atol=1e-6)
            np.testing.assert_allclose(top[clear], leave[clear], atol=1e-6)
            assert np.all(np.isfinite(top) >= np.isfinite(leave))


@pytest.mark.parametrize("ends", ["flat", "round"])
def test_meet_box_of_parts_is_the_greatest(ends):
    rng = np.random.default_rng(2)
    for kind in KINDS:
        rod = rod_of(kind, rng, ends)
        low = np.array(rod.a)[:2] + rng.normal(size=(300, 2))
        high = low + rng.uniform(0, 1.5, (300, 2))
        middle = (low + high) / 2
        bottom, top = meet_box(rod, low, high)
        cut = [np.stack([middle[:, 0], end[:, 1]], axis=-1) for end in (high, low)]
        parts = [meet_box(rod, low, cut[0]), meet_box(rod, cut[1], high)]
        np.testing.assert_allclose(np.minimum(*(p[0] for p in parts)), bottom, atol=1e-12)
        np.testing.assert_allclose(np.maximum(*(p[1] for p in parts)), top, atol=1e-12)


def test_meet_box_by_hand():
    post = Rod((0, 0, 1), (0, 0, 5), 2)
    assert meet_box(post, (-9, -9), (9, 9)) == (1, 5)
    assert meet_box(post, (-0.1, -0.1), (0.1, 0.1)) == (1, 5)
    assert meet_box(post, (2, -9), (9, 9)) == (1, 5)  # touches the wall
    assert meet_box(post, (2.1, -9), (9, 9)) == (np.inf, -np.inf)
    lying = Rod((0, 0, 0), (8, 0, 0), 2)
    assert meet_box(lying, (3, -1), (4, 9)) == (-2, 2)
    np.testing.assert_allclose(meet_box(lying, (3, 1), (4, 9)), (-np.sqrt(3), np.sqrt(3)))
    assert meet_box(Rod((0, 0, 0), (0, 0, 0), 1, ends="round"), (-1, -1), (1, 1)) == (-1, 1)
    assert meet_box(Rod((0, 0, 0), (0, 0, 0), 1), (-1, -1), (1, 1)) == (np.inf, -np.inf)


def test_wrong_input_is_told():
    rod = Rod((0, 0, 0), (1, 0, 0), 1)
    for call, message in (
        (lambda: meet_box("rod", (0, 0), (1, 1)), "solid: must be of class Rod or Frustum or Box"),
        (lambda: meet_box(rod, (0, 0, 0), (1, 1)), "low: the last axis must hold x, y"),
        (lambda: meet_box(rod, (0, np.nan), (1, 1)), "low: must hold finite numbers"),
        (lambda: meet_box(rod, (0, 2), (1, 1)), "low: must not be above high"),
    ):
        with pytest.raises(ValueError, match=f"^{message}"):
            call()
