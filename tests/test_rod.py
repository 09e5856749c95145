"""Lines and boxes against rods: whole numbers as reference, hard lines by generator, by hand."""

import numpy as np
import pytest

from exhibits.rod_cases import GENERATORS
from tests.audit.long import many
from tests.draws import EPS
from tests.test_equations_rod import distance_outside
from tunneller_lib.surfaces import Rod, meet_box
from tunneller_lib.surfaces.rod import meet_rods
from tunneller_lib.surfaces.rod_interval import frame

MANY = many(40_000, 400_000)  # lines a generator and kind of ends; the report says so: test_words
every_generator = pytest.mark.parametrize("lines_of", GENERATORS, ids=lambda g: g.__name__)
every_end = pytest.mark.parametrize("ends", ["flat", "round"])
TOUCHING = {"whole_rims", "far_rims", "tangents", "end_planes", "rim_tangents", "along_an_axis"}


def margin(a, b, radius, p, u):
    """Return by how much the docstring lets a rod's surface be off."""
    return 64 * EPS * (radius + frame(a.T, b.T, u.T).run)


@every_end
@every_generator
def test_meet_rods_of_many_hard_lines(lines_of, ends):
    # Each of these lines meets its rod, as whole numbers say, and its two ends are on the surface.
    lines = lines_of(np.random.default_rng(2), MANY)
    a, b, radius, p, u = lines
    enter, leave = meet_rods(*lines, ends=ends)
    hit = enter <= leave
    assert hit.all() or lines_of.__name__ not in TOUCHING
    assert np.all((enter == np.inf) & (leave == -np.inf) | hit)
    speed = np.linalg.norm(u, axis=-1)
    farther = np.where(hit, np.maximum(np.abs(enter), np.abs(leave)), 0)
    whole = radius + np.linalg.norm(b - a, axis=-1)
    slack = 16 * EPS * np.maximum(whole, farther * speed) + margin(*lines)
    for t in (enter, leave):
        off = distance_outside(a, b, radius, p + np.where(hit, t, 0)[:, None] * u, ends)
        # The point itself is rounded at the size of its coordinates.
        noise = 16 * EPS * (np.abs(p).max(axis=-1) + np.abs(np.where(hit, t, 0)) *
                            np.abs(u).max(axis=-1))  # fmt: skip
        assert np.all(np.abs(off[hit]) <= (slack + noise)[hit])


def test_meet_line_touches_the_rim_of_a_nearly_vertical_rod_where_it_is():
    axis = (-3.8534266197128644e-14, 3.084093971681962e-14, 16.978424326584722)
    rod = Rod((0, 0, 0), axis, 0.08605578297597163)
    point = (-0.07904269999452951, 0.03402718561959727, 16.978424326584722)
    enter, leave = rod.meet_line(point, (0, 0, 1.0))
    assert enter <= leave <= 1e-14


def test_meet_line_of_a_rod_shorter_than_its_rounding_keeps_to_its_disc():
    # A disc tilted by half a right angle: its shadow is as wide as 0.7071.
    rod = Rod((0, 0, 0), (1e-15, 0, 1e-15), 1.0)
    enter, leave = rod.meet_line((0.9, 0, 0), (0, 0, 1.0))
    assert leave < enter
    enter, leave = rod.meet_line((0.7, 0, 0), (0, 0, 1.0))
    assert enter == pytest.approx(-0.7) and leave == pytest.approx(-0.7)


# ---- boxes that come down on a rod --------------------------------------------------------------

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
    for _ in range(26):
        x, y = (np.linspace(*ends, 13) for ends in zip(first, last, strict=True))
        grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((13, 13))], axis=-1)
        enter, leave = rod.meet_line(grid, (0, 0, 1))
        height = side * (leave if side > 0 else enter)
        height = np.where(np.isfinite(height), height, -np.inf)
        i, j = np.unravel_index(np.argmax(height), height.shape)
        if height[i, j] == -np.inf:
            return where, best
        best, where = max(best, height[i, j]), (x[i], y[j])
        span = (last - first) / 6
        first = np.maximum(low, np.array(where) - span)
        last = np.minimum(high, np.array(where) + span)
    return where, best


@pytest.mark.parametrize("ends", ["flat", "round"])
@pytest.mark.parametrize("kind", POSES)
def test_meet_box_is_what_a_search_finds(kind, ends):
    rng = np.random.default_rng(0)
    met = 0
    for _ in range(many(4, 60)):
        rod = rod_of(kind, rng, ends)
        low = np.array(rod.a)[:2] + rng.uniform(-1, 0.1, 2)
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
    with pytest.raises(ValueError, match=r"^low: must not be above high .*; got a"):
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
