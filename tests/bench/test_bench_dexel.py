"""How fast a grid of intervals is cut: a circuit of ticks, and balls against a mesh library.

manifold3d subtracts balls from a block as meshes, called by its own interface. Which side is the
faster depends on what is asked of both, so that each ratio names its criterion: the same error of
the volume, by meshes of the ball's volume, or surfaces that are as far from the true ball, the mesh
by the sagitta of its sides and the grid by that between neighbouring lines. Of one ball such a mesh
has the volume with any number of sides; of sixty that overlap it hasn't.
"""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Rod

TICKS = 10_000


def test_circuit_of_ticks_on_rays(benchmark, say):
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

    def cut():
        tunnel = DexelGrid.radial(0.3, 1.2, low, low + 0.1, (400, 720))
        return tunnel.cut_path(centres, REFERENCE_MACHINE.cutter_radius)

    assert benchmark.pedantic(cut, rounds=1) > 0
    say("10 000 capsules on 400 x 720 rays, s", best_times(cut, rounds=3)[0])


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
@pytest.mark.parametrize(
    ("radius", "places", "what"), [(LARGE, ONE, "one ball"), (SMALL, SIXTY, "sixty balls")]
)
def test_balls_against_manifold_at_the_same_error_of_the_volume(
    installed, benchmark, say, radius, places, what
):
    exact = 4 / 3 * np.pi * radius**3 if len(places) == 1 else grid_of(radius, places, 600)
    errors = [grid_of(radius, some) / exact - 1 for some in moved(places)]
    error = np.sqrt(np.mean(np.square(errors)))
    sides = sides_for(error, lambda n: abs(mesh_of(installed, radius, places, n) / exact - 1))
    benchmark.pedantic(grid_of, (radius, places), rounds=3)
    ours, theirs = best_times(
        lambda: grid_of(radius, places), lambda: mesh_of(installed, radius, places, sides), rounds=5
    )
    say(f"{what}, relative error of the volume allowed, in millionths", 1e6 * error)
    say(f"{what}, time of manifold3d with {sides} sides over that of the grid, at the same error "
        "of the volume", theirs / ours, "manifold3d")  # fmt: skip


@pytest.mark.parametrize("package", ["manifold3d"])
@pytest.mark.parametrize(
    ("radius", "places", "what"), [(LARGE, ONE, "one ball"), (SMALL, SIXTY, "sixty balls")]
)
def test_balls_against_manifold_at_the_same_distance_of_surfaces(
    installed, benchmark, say, radius, places, what
):
    sagitta = SPACING**2 / (4 * radius)  # across a square of lines
    sides = sides_for(sagitta, lambda n: radius * (1 - np.cos(np.pi / n)))
    benchmark.pedantic(grid_of, (radius, places), rounds=3)
    ours, theirs = best_times(
        lambda: grid_of(radius, places), lambda: mesh_of(installed, radius, places, sides), rounds=5
    )
    say(f"{what}, distance of both surfaces from the balls / mm", 1e3 * sagitta)
    say(f"{what}, time of manifold3d with {sides} sides over that of the grid, at the same "
        "distance of surfaces", theirs / ours, "manifold3d")  # fmt: skip
