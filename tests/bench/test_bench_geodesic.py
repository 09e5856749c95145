"""How fast geodesics are found, against a boundary value solver and meshes.

The lengths of `geodesic_inverse` are right to rounding (tests/test_geodesic.py), so that what the
others return is off by as much as it differs from them; each line tells by how much.
"""

import ctypes
import importlib
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from tests.bench.conftest import best_times
from tunneller_lib.kernels import compiled
from tunneller_lib.paths import direct_problem, geodesic_direct, geodesic_inverse
from tunneller_lib.paths.direct_problem import KIND, SINES
from tunneller_lib.paths.geodesic_root import quadratures
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

MACHINE, RING = REFERENCE_MACHINE.torus, Torus(3, 1)
LOW = np.array([REFERENCE_MACHINE.theta_min, REFERENCE_MACHINE.phi_min])
HIGH = np.array([REFERENCE_MACHINE.theta_max, REFERENCE_MACHINE.phi_max])
MANY = 20_000


def random_pairs(torus, n):
    """Return ends p, q (n, 2) within the machine's limits or, on a ring, anywhere."""
    low, high = (-np.pi, np.pi) if torus is RING else (LOW, HIGH)
    return np.random.default_rng(0).uniform(low, high, (2, n, 2))


def paces(torus, others, n, rounds=3):
    """Return how many pairs per second geodesic_inverse answers, and `others()`, n at once."""
    p, q = random_pairs(torus, MANY)
    ours, theirs = best_times(lambda: geodesic_inverse(torus, p, q), others, rounds=rounds)
    return MANY / ours, n / theirs


def off(length, exact):
    """Return the median and the worst relative error of lengths, in words."""
    error = np.abs(length / exact - 1)
    return f"off by {np.median(error):.1e} in the median and {np.max(error):.1e} at worst"


@pytest.mark.parametrize("torus, where", [(MACHINE, "working sheet"), (RING, "ring")])
def test_pairs_per_second(benchmark, say, torus, where):
    p, q = random_pairs(torus, 100_000)
    geodesic = benchmark.pedantic(geodesic_inverse, (torus, p, q))
    (time,) = best_times(lambda: geodesic_inverse(torus, p, q), rounds=3)
    say(f"geodesic_inverse on the {where}, pairs per second of one core", len(p) / time)
    assert np.all(geodesic.converged)


# The same search in C, with the same answers to some roundings: bounds/geodesic_sheet.c, without
# fast-math.


@pytest.fixture
def bound(bound_in_c):
    """Return a function of ends (n, 2) on the machine's sheet to answers (4, n), in C."""
    function = bound_in_c("geodesic_sheet").geodesic_sheet
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    number = ctypes.c_double
    counts = np.ctypeslib.ndpointer(np.int64, flags="C_CONTIGUOUS")
    function.argtypes = [number, number, array, array, ctypes.c_long, array, counts, array]
    function.restype = ctypes.c_long
    rules = quadratures(ring=False, ready=True)

    def inverse(p, q):
        found = np.empty((4, len(p)))
        assert function(MACHINE.r, MACHINE.R, p, q, len(p), *rules, found) == 0
        return found

    return inverse


@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
def test_against_c(benchmark, say, note, bound, n):
    pytest.importorskip("numba", reason="what is compiled is timed")
    p, q = random_pairs(MACHINE, n)
    compiled.expect(compiled.LONG + 1, "geodesics")
    found = benchmark.pedantic(geodesic_inverse, (MACHINE, p, q), warmup_rounds=1)
    ours, of_c = best_times(
        lambda: geodesic_inverse(MACHINE, p, q), lambda: bound(p, q), rounds=5 if n > 1000 else 50
    )
    say(f"geodesic_inverse on the working sheet, {n:,} pairs, us for a pair", 1e6 * ours / n)
    say(f"the same, time over that of C, {n:,} pairs", ours / of_c)
    answers = found.length, found.azimuth1, found.azimuth2, found.clairaut
    np.testing.assert_allclose(bound(p, q), answers, rtol=1e-12, atol=1e-13)
    note(
        "geodesic inverse, working sheet, compiled", "pair", n, ours / n, bound_s=of_c / n,
        criterion="lengths, azimuths and Clairaut's constants agree to 1e-12",
    )  # fmt: skip


@pytest.fixture
def bound_of_direct(bound_in_c):
    """Return a function of starts (3, n) on the machine's sheet, and lengths, to ends, in C."""
    function = bound_in_c("geodesic_direct").geodesic_direct
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    number = ctypes.c_double
    function.argtypes = [number, number, array, array, ctypes.c_long, *[array] * 5]
    function.restype = ctypes.c_long
    tables = np.array(SINES).T.copy()

    def direct(start, length):
        found = np.empty_like(start)
        rules = *tables, *direct_problem.rules(ready=True)[1:]
        assert function(MACHINE.r, MACHINE.R, start, length, len(length), *rules, found) == 0
        return found

    return direct


@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
def test_direct_against_c(benchmark, say, note, bound_of_direct, n):
    pytest.importorskip("numba", reason="what is compiled is timed")
    p, _ = random_pairs(MACHINE, n)
    rng = np.random.default_rng(2)
    azimuth = rng.uniform(0.02, 3, n) * rng.choice([-1, 1], n)
    length = rng.uniform(0, 1.2, n)
    start = np.array([*p.T, azimuth])
    compiled.expect(compiled.LONG + 1, KIND)
    way = benchmark.pedantic(geodesic_direct, (MACHINE, p, azimuth, length), warmup_rounds=1)
    ours, of_c = best_times(
        lambda: geodesic_direct(MACHINE, p, azimuth, length),
        lambda: bound_of_direct(start, length),
        rounds=5 if n > 1000 else 50,
    )
    say(f"geodesic_direct on the working sheet, {n:,} ends, us for an end", 1e6 * ours / n)
    say(f"the same, time over that of C, {n:,} ends", ours / of_c)
    ends = [*way.position[:, 1].T, way.azimuth[:, 1]]
    np.testing.assert_allclose(bound_of_direct(start, length), ends, rtol=0, atol=1e-12)
    note(
        "geodesic direct, working sheet, compiled", "end", n, ours / n, bound_s=of_c / n,
        criterion="positions and azimuths at the end agree to 1e-12 rad",
    )  # fmt: skip


# Geodesics of an ellipsoid, a simpler problem: no quadrature is needed.


@pytest.mark.parametrize("package", ["geographiclib", "pyproj"])
@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
def test_against_an_ellipsoids(installed, benchmark, say, package, n):
    p, q = np.degrees(random_pairs(MACHINE, n))
    if package == "pyproj":
        earth = installed.Geod(ellps="WGS84")
        columns = p[:, 0], p[:, 1], q[:, 0], q[:, 1]
        one = partial(earth.inv, *(float(column[0]) for column in columns))
        theirs = one if n == 1 else partial(earth.inv, *columns)
    elif n > 1:
        pytest.skip("takes one pair at a time")
    else:
        earth = importlib.import_module("geographiclib.geodesic").Geodesic.WGS84
        theirs = partial(earth.Inverse, p[0, 1], p[0, 0], q[0, 1], q[0, 0])
    compiled.expect(compiled.LONG + 1, "geodesics")
    ends = random_pairs(MACHINE, n)
    ends = ends[:, 0] if n == 1 else ends
    benchmark.pedantic(geodesic_inverse, (MACHINE, *ends), warmup_rounds=1)
    rounds = 5 if n > 1000 else 50
    ours, other = best_times(lambda: geodesic_inverse(MACHINE, *ends), theirs, rounds=rounds)
    say(f"geodesic_inverse on the torus, {n:,} pairs, time over {package}'s on an ellipsoid",
        ours / other, package)  # fmt: skip


@pytest.mark.parametrize("package", ["geographiclib"])
def test_one_by_one_in_plain_python(installed, benchmark, note, monkeypatch, package):
    monkeypatch.setattr(compiled, "LONG", np.inf)
    n, rng = 200, np.random.default_rng(2)
    (p, q), azimuth, length = (
        random_pairs(MACHINE, n),
        rng.uniform(-3, 3, n),
        rng.uniform(0, 1.2, n),
    )
    geodesic = importlib.import_module(f"{package}.geodesic").Geodesic
    earth = geodesic(MACHINE.R, 1 / 298.257223563)
    here, there = np.degrees(p).tolist(), np.degrees(q).tolist()
    ways = list(zip(azimuth.tolist(), length.tolist(), np.degrees(azimuth).tolist(), strict=True))
    inverse, theirs, direct, their_direct = best_times(
        lambda: [geodesic_inverse(MACHINE, *pair) for pair in zip(p, q, strict=True)],
        lambda: [earth.Inverse(a[1], a[0], b[1], b[0]) for a, b in zip(here, there, strict=True)],
        lambda: [geodesic_direct(MACHINE, a, *way[:2]) for a, way in zip(p, ways, strict=True)],
        lambda: [earth.Direct(a[1], a[0], w[2], w[1]) for a, w in zip(here, ways, strict=True)],
    )
    benchmark.pedantic(geodesic_inverse, (MACHINE, p[0], q[0]))
    agree = "each right to rounding, on its own surface: a torus here, an ellipsoid there"
    for work, each, ours, other in (
        ("inverse", "pair", inverse, theirs), ("direct", "end", direct, their_direct)
    ):  # fmt: skip
        note(f"geodesic {work}, working sheet, one by one in plain Python", each, 1, ours / n,
             peer=f"{package} {work.title()}", peer_s=other / n, criterion=agree)  # fmt: skip


# A boundary value problem, as it would be put to scipy: theta, phi and azimuth over the share of
# the way, and the length a parameter. On the working sheet none of the other forms and numbers of
# nodes that were tried, with derivatives given or not, was faster by more than a tenth.

ENDS = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0]])
BOUNDARY = ENDS, np.roll(ENDS, 2, axis=0), np.zeros((4, 1))
NODES = {1e-6: 33, 1e-10: 257}


def rates(torus, _, state, length):
    """Return the derivatives of theta, phi and azimuth."""
    _, phi, alpha = state
    turning = np.sin(alpha) / (torus.r + torus.R * np.cos(phi))
    return length * np.stack([turning, np.cos(alpha) / torus.R, np.sin(phi) * turning])


def derivatives(torus, s, state, length):
    """Return the derivatives of `rates` with respect to the state and the length."""
    _, phi, alpha = state
    rho, zero = torus.r + torus.R * np.cos(phi), np.zeros_like(phi)
    turning, spread = np.sin(alpha) / rho, np.sin(phi) / rho
    by_theta = [zero, zero, zero]
    by_phi = [
        torus.R * spread * turning, zero, (np.cos(phi) + torus.R * np.sin(phi) * spread) * turning
    ]  # fmt: skip
    by_alpha = [np.cos(alpha) / rho, -np.sin(alpha) / torus.R, np.cos(alpha) * spread]
    by_state = length * np.stack([by_theta, by_phi, by_alpha], axis=1)
    return by_state, rates(torus, s, state, 1)[:, None]


def bvp_length(torus, p, q, tolerance):
    """Return the length that solve_bvp finds from the straight line in joint space, or NaN."""
    s = np.linspace(0, 1, NODES[tolerance])
    theta, phi = np.outer(p, 1 - s) + np.outer(q, s)
    east, north = (torus.r + torus.R * np.cos(phi)) * (q[0] - p[0]), torus.R * (q[1] - p[1])
    with np.errstate(all="ignore"):  # where it diverges it says so itself
        way = solve_bvp(
            partial(rates, torus),
            lambda first, last, _: np.concatenate([first[:2] - p, last[:2] - q]),
            s, np.stack([theta, phi, np.arctan2(east, north)]), p=[np.hypot(east, north).mean()],
            fun_jac=partial(derivatives, torus), bc_jac=lambda *_: BOUNDARY,
            tol=tolerance, max_nodes=20_000,
        )  # fmt: skip
    # A negative length is the same path with the azimuth turned round.
    return abs(way.p[0]) if way.success else np.nan


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_against_solve_bvp(benchmark, say, tolerance):
    p, q = random_pairs(MACHINE, 100)

    def others():
        return np.array([bvp_length(MACHINE, *pair, tolerance) for pair in zip(p, q, strict=True)])

    length = benchmark.pedantic(others)
    ours, theirs = paces(MACHINE, others, len(p), rounds=5)
    accuracy = off(length, geodesic_inverse(MACHINE, p, q).length)
    say(
        f"geodesic_inverse on the working sheet, {MANY} pairs at once, pairs per second over those "
        f"of solve_bvp one by one at {tolerance:.0e}, {accuracy}", ours / theirs, "scipy",
    )  # fmt: skip
    pairs = list(zip(p, q, strict=True))
    one, other = best_times(
        lambda: [geodesic_inverse(MACHINE, *pair) for pair in pairs], others, rounds=3
    )
    say(
        f"both one by one, solve_bvp at {tolerance:.0e}, time over that of geodesic_inverse",
        other / one, "scipy",
    )  # fmt: skip


def test_against_solve_bvp_on_a_ring(benchmark, say):
    p, q = random_pairs(RING, 200)
    # Straight lines that take the shorter way round in both angles.
    nearest = p + np.remainder(q - p + np.pi, 2 * np.pi) - np.pi

    def others():
        return np.array([bvp_length(RING, *pair, 1e-6) for pair in zip(p, nearest, strict=True)])

    found = benchmark.pedantic(others)
    ours, theirs = paces(RING, others, len(p), rounds=2)
    excess = found / geodesic_inverse(RING, p, q).length - 1
    say("geodesic_inverse on the ring, pairs per second over those of solve_bvp at 1e-06",
        ours / theirs, "scipy")  # fmt: skip
    say("solve_bvp on the ring, % that fail", 100 * np.mean(np.isnan(excess)), "scipy")
    say("solve_bvp on the ring, % longer by over 0.01 %", 100 * np.mean(excess > 1e-4), "scipy")
    assert np.nanmin(excess) > -1e-7  # nothing is shorter
    assert np.mean(excess > 1e-4) > 0.05
    assert ours >= 20 * theirs


# Meshes. Making the mesh and a solver's own preparations aren't counted, ends are vertices within
# the joints' limits, and the mesh goes on beyond these where shortest geodesics do (53 degrees).


def mesh(vertices):
    """Return joint positions, points and triangles of about so many vertices; edges all alike."""
    margin = np.array([0, np.radians(15)])
    low, high = LOW - margin, HIGH + margin
    size = (high - low) * [MACHINE.r + MACHINE.R, MACHINE.R]
    counts = np.round(size * np.sqrt(vertices / np.prod(size))).astype(int)
    axes = [np.linspace(*limits, count) for *limits, count in zip(low, high, counts, strict=True)]
    joint = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = np.arange(len(joint)).reshape(counts)
    a, b, c, d = (
        part.ravel()
        for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:])
    )
    triangles = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    return joint, MACHINE.point(*joint.T), triangles


def vertex_pairs(joint, n):
    """Return n random pairs of vertices within the joints' limits, as (n, 2) indices."""
    inside = np.flatnonzero(REFERENCE_MACHINE.within_limits(joint))
    return np.random.default_rng(1).choice(inside, (n, 2))


def exact_polyhedral(module, points, triangles):
    solver = module.PyGeodesicAlgorithmExact(points, triangles)
    return lambda start, stop: solver.geodesicDistance(start, stop)[0]


def edge_flips(module, points, triangles):
    solver = module.EdgeFlipGeodesicSolver(points, triangles)

    def length(start, stop):
        path = solver.find_geodesic_path(start, stop)
        return np.sum(np.linalg.norm(np.diff(path, axis=0), axis=-1))

    return length


def heat(module, points, triangles):
    solver = module.MeshHeatMethodDistanceSolver(points, triangles)
    return lambda start, stop: solver.compute_distance(start)[stop]


@pytest.mark.parametrize("package, solver, sizes, n, least", [
    ("pygeodesic.geodesic", exact_polyhedral, (1e3, 1e4), 10, 1000),
    ("potpourri3d", edge_flips, (1e3, 1e4, 1e5), 20, 50),
    ("potpourri3d", heat, (1e3, 1e4, 1e5), 20, 50),
])  # fmt: skip
def test_against_a_mesh(installed, benchmark, say, package, solver, sizes, n, least):
    rows = []
    for size in sizes:
        joint, points, triangles = mesh(size)
        pairs, one = vertex_pairs(joint, n), solver(installed, points, triangles)

        def others(pairs=pairs, one=one):
            return np.array([one(start, stop) for start, stop in pairs.tolist()])

        length = benchmark.pedantic(others) if size == sizes[-1] else others()
        exact = geodesic_inverse(MACHINE, *joint[pairs.T]).length
        ours, theirs = paces(MACHINE, others, n, rounds=2)
        say(
            f"geodesic_inverse on the working sheet, pairs per second over those of "
            f"{solver.__name__} on {len(joint):,} vertices, {off(length, exact)}",
            ours / theirs, package,
        )  # fmt: skip
        rows.append((len(joint), np.median(np.abs(length / exact - 1)), ours / theirs))
    count, error, ratio = np.transpose(rows)
    # The edges are as long as one over the root of the number of vertices.
    order = -2 * np.diff(np.log(error)) / np.diff(np.log(count))
    say(f"{solver.__name__}, order of its error in the edges' length", order[-1], package)
    assert np.all(order < 1) if solver is heat else np.allclose(order, 2, atol=0.3)
    assert ratio[1] >= least  # on ten thousand vertices
