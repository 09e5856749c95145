"""How fast all hyperosculating cones are found, jets, cubic and verdicts together.

Ratios against what could be done in the same run: the 6 x 6 eigenvalues alone, and the compiled
core in C, to the same bits, as a bound: bounds/hyperosculate.c, without fast-math.
"""

import ctypes

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.envelopes import (
    cone_directions,
    cone_loops,
    hyperosculating_cones,
    jet_variables,
    recognise,
)
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.kernels import compiled
from tunneller_lib.kernels.elementwise import NUMBERS
from tunneller_lib.milling.blade import BladeRing

ANGLE = np.radians(10)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)
S, T = np.random.default_rng(0).uniform(0.05, 0.95, (2, 8000))


def solve(n):
    return hyperosculating_cones(RING.coordinates, S[:n], T[:n], half_angle=ANGLE, model="space")


SURFACES = {"space": RING.coordinates, "isotropic": cyclide}


@pytest.fixture(params=["numpy", "compiled"])
def way(request, monkeypatch):
    """Fix the way that loops go, whatever the work, and return its name."""
    if request.param == "compiled":
        pytest.importorskip("numba", reason="what is compiled is timed")
    monkeypatch.setattr(compiled._Work, "compiled", request.param == "compiled")
    amount = np.inf if request.param == "compiled" else -np.inf
    monkeypatch.setattr(compiled._Work, "of_kind", {"cones": amount})
    return request.param


@pytest.mark.parametrize("model", SURFACES)
@pytest.mark.parametrize("count", [1, 1000, 1_000_000])
def test_points_per_second(benchmark, say, way, count, model):
    s, t = np.random.default_rng(0).uniform(0.05, 0.95, (2, count))

    def found():
        return hyperosculating_cones(SURFACES[model], s, t, half_angle=ANGLE, model=model)

    found()  # what is compiled is compiled
    cones = benchmark.pedantic(found, rounds=1)
    assert np.count_nonzero(cones.count) > 0.9 * count
    (best,) = best_times(found, rounds={1: 200, 1000: 10}.get(count, 1))
    about = f"hyperosculating cones, {model}, {count} points, {way}"
    say(f"{about}, us a point", 1e6 * best / count)


def test_compiled_core_against_c(benchmark, say, note, bound_in_c, way):
    function = bound_in_c("hyperosculate").fill_cones
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    function.argtypes = [array, ctypes.c_long, ctypes.c_double, array, array, array]
    function.restype = None
    x, y = jet_variables(S, T)
    shapes = np.stack(np.broadcast_arrays(*cone_loops.shape_in_the_model(S, T, cyclide(x, y).c)))
    shapes = np.ascontiguousarray(shapes.T)
    rho = 0.5 / np.tan(ANGLE)
    samples = [np.array(c) for c in (cone_directions._COSINES, cone_directions._SINES)]
    mine, theirs = np.empty((2, len(S), 6, 5))

    def ours():
        if way == "compiled":
            compiled.call(cone_loops.fill_cones, shapes, rho, mine, **NUMBERS)
        else:
            with np.errstate(all="ignore"):
                mine[:] = np.moveaxis(np.array(cone_loops.cones_of(shapes.T, rho)), -1, 0)

    def bound():
        function(shapes, len(S), rho, *samples, theirs)

    benchmark.pedantic(ours, rounds=1)
    best, limit = best_times(ours, bound, rounds=5)
    np.testing.assert_array_equal(mine, theirs)
    say(f"cones of {len(S)} points by their forms, {way}, us a point", 1e6 * best / len(S))
    say(f"cones by their forms, {way}, time over that of C, the same bits", best / limit)
    note(
        f"cones at a point, its forms known, {way}", "point", len(S), best / len(S),
        bound_s=limit / len(S), criterion="the same bits",
    )  # fmt: skip


def test_time_is_linear_in_points(benchmark, say):
    benchmark.pedantic(solve, (8000,), rounds=3)
    few, many = best_times(lambda: solve(2000), lambda: solve(8000), rounds=5)
    say("hyperosculating cones, time of 8000 points over four times that of 2000", many / few / 4)
    assert many / few / 4 < 1.5


def test_against_the_eigenvalues_alone(benchmark, say):
    companions = np.random.default_rng(1).normal(size=(2000, 6, 6))
    benchmark.pedantic(np.linalg.eigvals, (companions,), rounds=3)
    whole, least = best_times(lambda: solve(2000), lambda: np.linalg.eigvals(companions), rounds=5)
    say("hyperosculating cones, time over that of as many 6 x 6 eigenvalues", whole / least)


def test_recognition(benchmark, say):
    def cone():
        return recognise(cyclide, S[:2000], T[:2000], "cone")

    benchmark.pedantic(cone, rounds=3)
    (best,) = best_times(cone, rounds=5)
    say("cones of unknown angle recognised, points per second of one core", 2000 / best)
