"""How fast a grid of intervals is cut: a circuit of ticks, and balls against a mesh library.

The circuit is cut in C, too, to the same bits, as a bound: bounds/dexel.c, without fast-math.

manifold3d subtracts balls from a block as meshes, called by its own interface. Which side is the
faster depends on what is asked of both, so that each ratio names its criterion: the same error of
the volume, by meshes of the ball's volume, or surfaces that are as far from the true ball, the mesh
by the sagitta of its sides and the grid by that between neighbouring lines. Of one ball such a mesh
has the volume with any number of sides; of sixty that overlap it hasn't.
"""

import ctypes

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.kernels import compiled
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Rod

TICKS = 10_000


def circuit_of_ticks():
    """Return a wall of 400 x 720 rays about the egg, and the centres of a circuit of ticks."""
    egg = Egg(0.5)
    angle = (np.arange(720) + 0.5) * np.pi / 360
    low, high = np.zeros(720), np.full(720, 1.5)
    for _ in range(60):
        middle = (low + high) / 2
        inside = egg.depth(middle * np.cos(angle), middle * np.sin(angle)) > 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    s = np.linspace(0, egg.offset(REFERENCE_MACHINE.offset).perimeter, TICKS + 1)
    circuit = cutting_circuit(REFERENCE_MACHINE, egg)
    _, centres = circuit.arm(circuit.position(s))
    return DexelGrid.radial(0.3, 1.2, low, low + 0.1, (400, 720)), centres


@pytest.fixture
def bound(bound_in_c):
    """Return `cut_path` in C, of the arrays of a grid."""
    function = bound_in_c("dexel").cut_path
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    whole, number = ctypes.c_long, ctypes.c_double
    function.argtypes = [array, whole, number, *[whole] * 3, *[array] * 6, number]
    function.restype = number

    def cut_path(grid, centres, radius):
        lines = grid.lines
        return function(
            centres, len(centres) - 1, radius, *grid.low.shape[1:], len(grid.low), grid.low,
            grid.high, lines.x, lines.cos, lines.sin, grid._nearest, lines.cell,
        )  # fmt: skip

    return cut_path


@pytest.mark.parametrize("way", ["whole arrays", "compiled"])
@pytest.mark.parametrize("count", [1, 1000, TICKS])
def test_circuit_of_ticks_against_c(benchmark, say, note, bound, monkeypatch, count, way):
    if way == "compiled":
        pytest.importorskip("numba", reason="what is compiled is timed")
    # No amount of work changes the way meanwhile.
    monkeypatch.setattr(compiled._Work, "compiled", way == "compiled")
    amount = np.inf if way == "compiled" else -np.inf
    monkeypatch.setattr(compiled._Work, "of_kind", {"grid": amount})
    tunnel, centres = circuit_of_ticks()
    centres = np.ascontiguousarray(centres[: count + 1])
    radius = REFERENCE_MACHINE.cutter_radius
    # Both cut as many copies, made before the clock runs.
    rounds = 5 if count < TICKS else 2
    grids = [tunnel.copy() for _ in range(2 * rounds)]
    ours, theirs = iter(grids[:rounds]), iter(grids[rounds:])
    removed = benchmark.pedantic(tunnel.copy().cut_path, (centres, radius), rounds=1)
    mine, limit = best_times(
        lambda: next(ours).cut_path(centres, radius),
        lambda: bound(next(theirs), centres, radius),
        rounds=rounds,
    )
    for grid in grids[rounds:]:
        np.testing.assert_array_equal(grid.low, grids[0].low)
        np.testing.assert_array_equal(grid.high, grids[0].high)
    assert 0 < removed == pytest.approx(bound(tunnel, centres, radius), rel=1e-12)
    about = f"{count} capsules on 400 x 720 rays, {way}"
    say(f"{about}, us a capsule", 1e6 * mine / count)
    say(f"{about}, time over that of C, all intervals the same to the last bit", mine / limit)
    note(
        f"ball swept through 400 x 720 rays, {way}", "capsule", count, mine / count,
        bound_s=limit / count, criterion="the same intervals to the last bit",
    )  # fmt: skip


SPACING = 2 / 120  # of the grid's lines
SMALL, LARGE = 0.25, 0.7  # radii of the balls


def grid_of(radius, places, n=120):
    """Return what balls take from a block of 2 m, cut on n by n lines."""
    block = DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (n, n))
    return sum(block.cut(Rod(place, place, radius, ends="round")) for place in places)


def mesh_of(manifold3d, radius, places, sides):
    """Return what meshes of a ball's volume take from the same block, in one operation."""
    ball = manifold3d.Manifold.sphere(radius, sides)
    ball = ball.scale([(4 / 3 * np.pi * radius**3 / ball.volume()) ** (1 / 3)] * 3)
    block = manifold3d.Manifold.cube((2, 2, 2), True)
    balls = [ball.translate(place) for place in places]
    left = manifold3d.Manifold.batch_boolean([block, *balls], manifold3d.OpType.Subtract)
    return 8 - left.volume()


def sides_for(error, of_sides):
    """Return the fewest sides, a multiple of four, from which on the error is at most that given.

    From which on: at the next two numbers as well, for an error may pass zero by chance.
    """

    def enough(fours):
        return max(of_sides(4 * (fours + more)) for more in range(3)) <= error

    many = 1
    while not enough(many):  # a mesh grows with the square of its sides
        many *= 2
    few = many // 2
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (few, middle) if enough(middle) else (middle, many)
    return 4 * many


def moved(places):
    """Return balls at eight places each, moved together by less than a line's distance."""
    return places + np.random.default_rng(0).uniform(-SPACING, SPACING, (8, 1, 3)) / 2


ONE = np.zeros((1, 3))
SIXTY = np.random.default_rng(1).uniform(-0.7, 0.7, (60, 3))


@pytest.mark.parametrize("package", ["manifold3d"])
@pytest.mark.parametrize("same", ["error of the volume", "distance of surfaces"])
@pytest.mark.parametrize(
    ("radius", "places", "what"), [(LARGE, ONE, "one ball"), (SMALL, SIXTY, "sixty balls")]
)
def test_balls_against_manifold(installed, benchmark, say, note, radius, places, what, same):
    if same == "error of the volume":
        exact = 4 / 3 * np.pi * radius**3 if len(places) == 1 else grid_of(radius, places, 600)
        errors = [grid_of(radius, some) / exact - 1 for some in moved(places)]
        allowed = np.sqrt(np.mean(np.square(errors)))
        sides = sides_for(allowed, lambda n: abs(mesh_of(installed, radius, places, n) / exact - 1))
    else:
        allowed = SPACING**2 / (4 * radius)  # the sagitta across a square of lines, in m
        sides = sides_for(allowed, lambda n: radius * (1 - np.cos(np.pi / n)))
    benchmark.pedantic(grid_of, (radius, places), rounds=3)
    ours, theirs = best_times(
        lambda: grid_of(radius, places), lambda: mesh_of(installed, radius, places, sides), rounds=5
    )
    say(f"{what}, {same} that is allowed, in millionths (of the volume, of a metre)", 1e6 * allowed)
    say(f"{what}, time of manifold3d with {sides} sides over that of the grid, at the same {same}",
        theirs / ours, "manifold3d")  # fmt: skip
    if same == "error of the volume":
        note(
            f"{what} out of a block, 120 x 120 lines", "ball", len(places), ours / len(places),
            peer="manifold3d batch_boolean", peer_s=theirs / len(places),
            criterion="the same error of the volume",
        )  # fmt: skip
