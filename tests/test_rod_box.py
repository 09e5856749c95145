"""Boxes that come down on a rod, against a search over lines and by hand."""

import numpy as np
import pytest

from tests.audit.long import many
from tunneller_lib.surfaces import Rod, meet_box

EPS = np.finfo(float).eps

POSES = ("any", "vertical", "level", "along x", "along y", "nearly vertical", "nearly level")


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
@pytest.mark.parametrize("kind", POSES)
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
    with pytest.raises(ValueError, match=r"^low: must not be above high"):
        meet_box(post, (0, 2), (1, 1))


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
