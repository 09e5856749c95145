"""Grids of intervals against exact volumes and sets of intervals kept line by line."""

import tracemalloc
from itertools import pairwise

import numpy as np
import pytest

from tunneller_lib.removal import DexelGrid
from tunneller_lib.removal import grid as grids
from tunneller_lib.surfaces import Rod


def block(n=40, m=50):
    return DexelGrid.cartesian((-1, -1.2, -1), (1, 1.2, 1), (n, m))


def wall(n=40, m=90, inner=0.5, outer=0.8):
    return DexelGrid.radial(-1, 1, inner, outer, (n, m))


GRIDS = {"cartesian": block, "radial": wall, "massive": lambda: wall(inner=0.0)}
every_grid = pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)


def rods(rng, n, ends=("flat", "round")):
    """Return rods, capsules and balls of all sizes in and about the grids."""
    out = []
    for _ in range(n):
        a, b = rng.uniform(-1, 1, (2, 3))
        kind = rng.integers(0, 4)
        b = np.stack([b, a, np.add(a, (0.5, 0, 0)), np.add(a, (0, 0, 0.7))])[kind]
        out.append(Rod(a, b, rng.uniform(0.02, 0.6), ends=rng.choice(ends)))
    return out


def lines_of(grid):
    """Return one point and the direction of each line (n, m, 3), from their meaning."""
    x, lines = grid.lines.x, grid.lines
    if lines.rays:
        angle = (np.arange(len(lines.cos)) + 0.5) / len(lines.cos) * 2 * np.pi
        unit = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=-1)
        start = np.zeros_like(unit)
    else:
        start = np.stack([0 * lines.aside, lines.aside, 0 * lines.aside], axis=-1)
        unit = np.broadcast_to([0.0, 0.0, 1.0], start.shape)
    points = start[None] + x[:, None, None] * np.array([1.0, 0, 0])
    return points, np.broadcast_to(unit, points.shape).copy()


@every_grid
def test_cut_leaves_what_no_shape_meets(grid):
    """On each line, at heights a little beside all places where a shape or the grid begins."""
    grid, shapes = grid(), rods(np.random.default_rng(0), 12)
    whole = grid.copy()
    for shape in shapes:
        grid.cut(shape)
    assert len(grid.low) > 1
    points, unit = lines_of(grid)
    met = np.clip([shape.meet_line(points, unit) for shape in shapes], -9, 9)
    enter, leave = np.moveaxis(met, 1, 0)
    ends = np.concatenate([enter, leave, whole.low, whole.high])
    height = np.concatenate([ends - 1e-9, ends + 1e-9])[:, None]

    def among(low, high):
        return np.any((low < height) & (height < high), axis=1)

    wanted = among(whole.low, whole.high) & ~among(enter, leave)
    sure = np.all(np.abs(height - ends) > 5e-10, axis=1)  # two ends may be in one place
    np.testing.assert_array_equal(among(grid.low, grid.high)[sure], wanted[sure])
    assert 0.01 < wanted[sure].mean() < 0.9


@every_grid
def test_removed_and_left_are_the_initial_volume(grid):
    grid = grid()
    initial, removed = grid.volume, 0.0
    for shape in rods(np.random.default_rng(1), 60):
        before = grid.volume
        taken = grid.cut(shape)
        assert abs(grid.volume + taken - before) < 1e-13 * initial
        removed += taken
    assert abs(grid.volume + removed - initial) < 1e-13 * initial


def test_cut_path_is_the_sum_of_its_moves():
    rng = np.random.default_rng(3)
    path = np.add(np.cumsum(rng.uniform(-0.1, 0.1, (30, 3)), axis=0), (0, 0.3, 0.4))
    path = np.vstack([path, path[-1] + (0, 0, 0.3), path[-1] - (0, 0, 0.2)])  # up and down
    for grid in (block(), wall()):
        moves, first = grid.copy(), grid.volume
        expected = sum(moves.cut(Rod(a, b, 0.2, ends="round")) for a, b in pairwise(path))
        assert grid.cut_path(path, 0.2) == pytest.approx(expected, abs=1e-14)
        assert grid.volume == pytest.approx(moves.volume, abs=1e-14)
        assert grid.volume < first
        assert grid.cut_path(path[:1], 0.2) < 1e-15


def test_wrong_grids_and_cuts_are_refused():
    for message, call in {
        "low: must be below high": lambda: DexelGrid.cartesian((0, 0, 0), (1, 0, 1), (2, 2)),
        "start: must be below stop": lambda: DexelGrid.radial(1, 0, 1, 2, (2, 2)),
        "inner: must not be above outer": lambda: DexelGrid.radial(0, 1, [1, 3], 2, (2, 2)),
        "low: must broadcast to 40 x 90": lambda: DexelGrid(wall().lines, [0, 0], 1),
    }.items():
        with pytest.raises(ValueError, match=f"^{message}"):
            call()


def errors_of(make, volume, sizes):
    """Return the errors of a cut's volume at several sizes, rms over shifts of the grid."""
    rng = np.random.default_rng(4)
    shifts = rng.uniform(-1, 1, (16, 3))
    return [
        np.sqrt(np.mean([(make(n, shift / n) / volume - 1) ** 2 for shift in shifts]))
        for n in sizes
    ]


BESIDE = np.array([0, 0.8, 0.5])


def ball_in_wall(n, shift):
    grid = DexelGrid.radial(-1, 1, 0.2, 2, (n, 3 * n))
    return grid.cut(Rod(shift + BESIDE, shift + BESIDE, 0.4, ends="round"))


ALONG, OBLIQUE = np.array([0.3, 0, 0.2]), np.array([0.3, 0.15 * (np.sqrt(5) - 1), 0.2])


def capsule_in_block(half):
    def make(n, shift):
        grid = DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (n, n))
        return grid.cut(Rod(shift - half, shift + half, 0.3, ends="round"))

    return make, np.pi * 0.3**2 * (0.4 + 2 * np.linalg.norm(half))


@pytest.mark.parametrize(
    ("make", "volume", "least", "most"),
    [
        (ball_in_wall, 4 / 3 * np.pi * 0.4**3, 1.8, 2.2),
        # Straight sides of the shadow: 3/2 along the grid, up to 2 elsewhere.
        (*capsule_in_block(ALONG), 1.4, 1.65),
        (*capsule_in_block(OBLIQUE), 1.75, 2.2),
    ],
    ids=["ball on rays", "capsule along the grid", "capsule oblique"],
)
def test_volumes_converge_at_their_order(make, volume, least, most):
    sizes = np.array([20, 40, 80, 160])
    order = -np.polyfit(np.log(sizes), np.log(errors_of(make, volume, sizes)), 1)[0]
    assert least < order < most


def test_degenerate_cuts_remove_nothing():
    at, origin = (0, 0.6, 0), (0, 0, 0)
    nothing = [
        Rod(at, at, 0.1),
        Rod(origin, (0, 1, 0.2), 0),
        Rod((9, 9, 9), (9, 9, 8), 1),
        Rod(origin, origin, 0, ends="round"),
    ]
    for grid in (block(), wall(), wall(inner=0.0)):
        assert [grid.cut(rod) for rod in nothing] == [0] * 4 and len(grid.low) == 1
        assert grid.cut_path(np.empty((0, 3)), 0.1) == 0


def test_grid_too_large_is_refused_with_the_size_that_fits(monkeypatch):
    def allow(count):
        memory = {"SC_PHYS_PAGES": 2 * count, "SC_PAGE_SIZE": 1}  # half of the computer's
        monkeypatch.setattr("os.sysconf", memory.__getitem__)

    allow(1_000_000_000)
    message = r"shape: 200000 x 200000 lines with room for 1 interval each need 1.28e.*, and 1 GB"
    with pytest.raises(ValueError, match=message):
        DexelGrid.cartesian((0, 0, 0), (1, 1, 1), (200_000, 200_000))
    with pytest.raises(ValueError, match=r"5590 x 5590 would fit\.$"):
        DexelGrid.radial(0, 1, 1, 2, (200_000, 200_000))
    allow(64_000)
    full = block(40, 50)  # one slot fits, a second one doesn't
    full.cut(Rod((0, 0, 0), (0, 0, 1), 0.1))
    with pytest.raises(ValueError, match="room for 2 intervals"):
        full.cut(Rod((0.5, 0, 0), (0.5, 0, 0), 0.1, ends="round"))


@pytest.mark.parametrize("radial", [False, True])
def test_memory_stays_within_what_is_refused_by(radial):
    # Intervals, room to grow, and the work on one block of lines whatever their number.
    n, work = (700, 900), 300 * grids.BLOCK
    tracemalloc.start()
    grid = wall(*n, inner=0.2, outer=2.0) if radial else block(*n)
    grid.cut(Rod((0, 0, 0), (0.3, 0.2, 0.4), 0.9))
    grid.cut_path([[0, 0.1, 0], [0.1, 0.1, 0.1]], 0.95)
    assert grid.volume > 0
    grid.cut(Rod((0, 0, 0.9), (0, 0, 0.9), 0.05, ends="round"))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(grid.low) >= 2 and peak < 32 * grid.low.size + work
