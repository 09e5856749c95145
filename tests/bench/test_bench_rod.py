"""How fast parallel lines are held against a rod, and how rightly: slab, three surfaces, meshes.

Lines over the square about a leaning rod, along z or each of its own direction. Each ratio is of
the best of several rounds in which both sides take turns. The meshes have 64 sides: pyvista (VTK)
answers line by line; embree, called by its own interface, is asked for the entry alone, in single
precision, where the library finds entry and exit in double; open3d finds both, in single precision.

The same lines are met in C, too, as a bound: bounds/rod.c, without fast-math, does the quick
formulas alone and check nothing. What they are sure of must have the library's bits.
"""

import ctypes
from collections import defaultdict

import numpy as np
import pytest
import pyvista

from exhibits.rod_methods import METHODS
from tests.bench.conftest import best_times
from tunneller_lib.kernels import compiled
from tunneller_lib.surfaces import Box, Frustum, Rod

ROD = Rod((0, 0, 0), (90, 0, 120), 25)
LINES = 500_000
SIDES = 64
rng = np.random.default_rng(0)
POINTS = np.insert(rng.uniform([-70, -115], [160, 115], (LINES, 2)), 2, -50.0, axis=-1)
CLOSE = np.insert(rng.uniform([-20, -25], [110, 25], (LINES, 2)), 2, -50.0, axis=-1)
UP = np.array([0.0, 0.0, 1.0])


def slab(p):
    """Return the slab method for lines along z, written for speed, what is common taken out."""
    enter, leave = np.empty(len(p)), np.empty(len(p))
    v = ROD.axis
    vsq, h2 = v @ v, v[0] ** 2 + v[1] ** 2
    for i in range(0, len(p), 16384):
        x, y = p[i : i + 16384, 0], p[i : i + 16384, 1]
        vq = x * v[0] + y * v[1]
        b = vq * v[2]
        with np.errstate(invalid="ignore"):
            root = np.sqrt(b * b + h2 * (vq * vq + (ROD.radius**2 - x * x - y * y) * vsq))
        low = np.maximum((b - root) / h2, -vq / v[2])
        high = np.minimum((b + root) / h2, (vsq - vq) / v[2])
        hit = low <= high
        enter[i : i + 16384] = np.where(hit, low, np.inf)
        leave[i : i + 16384] = np.where(hit, high, -np.inf)
    return enter - p[:, 2], leave - p[:, 2]


def mesh(start=25, end=25):
    """Return a frustum about the rod's axis with 64 sides, as vertices and triangles."""
    turn = np.arange(SIDES) * 2 * np.pi / SIDES
    unit = ROD.axis / ROD.length
    side = np.outer(np.cos(turn), [0, 1, 0]) + np.outer(np.sin(turn), np.cross(unit, [0, 1, 0]))
    rims = [np.array(ROD.a) + start * side, np.array(ROD.b) + end * side]
    vertices = np.concatenate([*rims, [ROD.a], [ROD.b]])
    i, j = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    wall = [np.stack([i, j, i + SIDES], axis=-1), np.stack([j, j + SIDES, i + SIDES], axis=-1)]
    lids = [np.stack([np.full(SIDES, 2 * SIDES), j, i], axis=-1),
            np.stack([np.full(SIDES, 2 * SIDES + 1), i + SIDES, j + SIDES], axis=-1)]  # fmt: skip
    return vertices, np.concatenate([*wall, *lids])


@pytest.mark.parametrize("points", [POINTS, CLOSE], ids=["all about", "close"])
def test_parallel_lines_against_the_slab_method(benchmark, say, points):
    benchmark.pedantic(ROD.meet_line, (points, UP), rounds=3)
    exact, other = best_times(lambda: ROD.meet_line(points, UP), lambda: slab(points), rounds=7)
    say("parallel lines, millions per second", len(points) / exact / 1e6)
    share = np.mean(np.isfinite(ROD.meet_line(points, UP)[0]))
    say("share of the lines that meet the rod", share)
    say("exact, lines per second over those of the slab method", other / exact)
    assert exact <= 2 * other


def test_parallel_lines_against_the_printed_methods(benchmark, say):
    benchmark.pedantic(ROD.meet_line, (POINTS, UP), rounds=3)
    for method in ("slab", "three-surfaces"):
        exact, other = best_times(
            lambda: ROD.meet_line(POINTS, UP),
            lambda method=method: METHODS[method](ROD.a, ROD.b, ROD.radius, POINTS, UP), rounds=5,
        )  # fmt: skip
        say(f"exact, lines per second over those of {method} for any lines", other / exact)


SLANTED = np.insert(rng.normal(0, 0.3, (LINES, 2)), 2, 1.0, axis=-1)


@pytest.mark.parametrize("package", ["embreex.rtcore_scene"])
@pytest.mark.parametrize("what", ["one direction", "a direction a line"])
def test_entries_against_embree(installed, benchmark, say, what):
    from embreex.mesh_construction import TriangleMesh

    vertices, faces = mesh()
    scene = installed.EmbreeScene()
    TriangleMesh(scene, vertices[faces].astype(np.float32))
    directions = UP if what == "one direction" else SLANTED
    rays = np.broadcast_to(directions, POINTS.shape).astype(np.float32)
    points = POINTS.astype(np.float32)
    benchmark.pedantic(ROD.meet_line, (POINTS, directions), rounds=3)
    ours, theirs = best_times(
        lambda: ROD.meet_line(POINTS, directions),
        lambda: scene.run(points, rays, query="DISTANCE"), rounds=7,
    )  # fmt: skip
    say(f"{what}, entry and exit in double over embree's entry in single precision, time",
        ours / theirs, "embreex")  # fmt: skip
    entry, first = ROD.meet_line(POINTS, directions)[0], scene.run(points, rays, query="DISTANCE")
    both = np.isfinite(entry) & (first < 1e6)
    assert np.mean(np.isfinite(entry) == (first < 1e6)) > 0.99
    error = np.median(np.abs(first[both] - entry[both]))
    say(f"{what}, embree's error of the entry, median / m", error, "embreex")


@pytest.fixture
def either_way(way, monkeypatch):
    """Have lines met by whole rows, or by compiled loops, whatever is met meanwhile."""
    if way == "compiled":
        pytest.importorskip("numba", reason="what is compiled is timed")
    monkeypatch.setattr(compiled._Work, "compiled", way == "compiled")
    amount = np.inf if way == "compiled" else -np.inf
    monkeypatch.setattr(compiled._Work, "of_kind", defaultdict(lambda: amount))


def bound(library, shape, radii):
    """Return a function of points and directions: the answers of a library in C."""
    function = library.meet_lines
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    marks = np.ctypeslib.ndpointer(np.int8)
    function.argtypes = [ctypes.c_long, *[array] * 7, marks]
    sizes = np.array(shape.a), np.array(shape.b), np.array(radii, dtype=float)

    def meet(points, directions):
        enter, leave = np.empty((2, len(points)))
        sure = np.empty(len(points), dtype=np.int8)
        function(len(points), *sizes, points, directions, enter, leave, sure)
        return enter, leave, sure

    return meet


@pytest.mark.parametrize("way", ["whole rows", "compiled"])
@pytest.mark.parametrize("count", [1, 1000, 1_000_000])
def test_any_lines_against_c(benchmark, say, note, bound_in_c, either_way, count, way):
    shape = ROD
    meet = bound(bound_in_c("rod"), shape, [25, 25])
    # The first of all is nearly parallel to the axis, which C leaves undecided.
    points, directions = np.resize(POINTS[1:], (count, 3)), np.resize(SLANTED[1:], (count, 3))
    few = max(1000 // count, 1)  # of calls that are timed together
    benchmark.pedantic(shape.meet_line, (points, directions), rounds=1)
    ours, limit = best_times(
        lambda: [shape.meet_line(points, directions) for _ in range(few)],
        lambda: [meet(points, directions) for _ in range(few)],
        rounds=7,
    )
    enter, leave, sure = meet(points, directions)
    decided = sure == 1
    assert np.mean(decided) > 0.95
    np.testing.assert_array_equal(
        np.array(shape.meet_line(points, directions))[:, decided], [enter[decided], leave[decided]]
    )
    about = f"{count} lines against a rod, {way}"
    say(f"{about}, ns a line", 1e9 * ours / few / count)
    say(f"{about}, time over that of C, all sure answers the same to the last bit", ours / limit)
    note(
        f"any lines against a rod, {way}", "line", count, ours / few / count,
        bound_s=limit / few / count, criterion="the same bits where C is sure",
    )  # fmt: skip


@pytest.mark.parametrize("package", ["open3d"])
@pytest.mark.parametrize("way", ["whole rows", "compiled"])
@pytest.mark.parametrize("points", [POINTS, CLOSE], ids=["all about", "close"])
def test_any_lines_against_open3d(installed, benchmark, say, either_way, points, way):
    # Both find where each line enters and leaves, with one thread: in double precision against the
    # exact shape, and in single precision against 64 sides, by open3d's own call for all hits.
    shape = ROD
    vertices, faces = mesh()
    tensor = installed.core.Tensor
    scene = installed.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(tensor(vertices.astype(np.float32)), tensor(faces.astype(np.uint32)))
    rays = tensor(np.concatenate([points, SLANTED], axis=-1).astype(np.float32))
    benchmark.pedantic(shape.meet_line, (points, SLANTED), rounds=3)
    ours, theirs = best_times(
        lambda: shape.meet_line(points, SLANTED), lambda: scene.list_intersections(rays), rounds=7
    )
    say(f"any lines, {way}, entry and exit in double over open3d's all hits in single, time",
        ours / theirs, "open3d")  # fmt: skip
    met = np.isfinite(shape.meet_line(points, SLANTED)[0])
    assert np.mean(met == (scene.count_intersections(rays).numpy() > 0)) > 0.99
    assert ours <= (1 if way == "compiled" else 2) * theirs


def test_parallel_lines_against_vtk(benchmark, say):
    vertices, faces = mesh()
    body = pyvista.PolyData.from_regular_faces(vertices, faces)
    few = POINTS[:2_000]
    benchmark.pedantic(ROD.meet_line, (POINTS, UP), rounds=3)
    exact, other = best_times(
        lambda: ROD.meet_line(POINTS, UP),
        lambda: [body.ray_trace(p, p + 300 * UP) for p in few], rounds=3,
    )  # fmt: skip
    ratio = (other / len(few)) / (exact / len(POINTS))
    say("exact, lines per second over those of pyvista's ray_trace", ratio, "pyvista")


SOLIDS = {
    "rod": ROD,
    "capsule": Rod(ROD.a, ROD.b, 25, ends="round"),
    "frustum": Frustum(ROD.a, ROD.b, 25, 10),
    "box": Box((-20, -15, 0), (40, 0, 0), (0, 30, 0), (0, 0, 50)),
}
DIRECTIONS = {
    "any": (0.1, 0.2, 1.0),
    "nearly axial": (0.6, 0.0, 0.8 + 1e-9),
    "nearly upright": (0.0, 1e-9, 1.0),
}


@pytest.mark.parametrize("way", ["plain", "compiled"])
@pytest.mark.parametrize("line", DIRECTIONS)
@pytest.mark.parametrize("name", SOLIDS)
def test_one_line_at_a_time(benchmark, say, either_way, name, line, way):
    point, direction = np.array([6.0, 4.0, -3.0]), np.array(DIRECTIONS[line])
    meet_line = SOLIDS[name].meet_line
    benchmark.pedantic(meet_line, (point, direction), rounds=3)
    (many,) = best_times(lambda: [meet_line(point, direction) for _ in range(50)], rounds=31)
    say(f"{name}, {line} line, {way}: one call with its checks / us", many / 50 * 1e6)
