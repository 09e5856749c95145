"""What one answer costs alone, among a thousand and among a million, for the table of times."""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tests.bench.test_bench_envelopes import solve
from tests.bench.test_bench_geodesic import RING, random_pairs
from tunneller_lib.kernels import compiled
from tunneller_lib.paths import geodesic_inverse

PROVED = "lengths right to rounding, with the reason why no path is shorter"
# What each answers with: the kind of its loops, its unit, what it says, the call, the most at once.
WORKS = {
    "geodesic inverse, ring, compiled": (
        "geodesics", "pair", PROVED, lambda p, q: geodesic_inverse(RING, p, q),
        lambda n: random_pairs(RING, n), 100_000,
    ),
    "hyperosculating cones of a blade, in space, compiled": (
        "cones", "point", "all cones with their certificates", solve, lambda n: (n,), 8000
    ),
}  # fmt: skip


@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
@pytest.mark.parametrize("work", WORKS)
def test_one_a_thousand_and_a_million(benchmark, note, work, n):
    pytest.importorskip("numba", reason="what is compiled is timed")
    kind, each, criterion, call, given, most = WORKS[work]
    compiled.expect(compiled.LONG + 1, kind)
    n = min(n, most)
    about = tuple(given(n))
    if n == 1:
        about = tuple(one[0] if isinstance(one, np.ndarray) else one for one in about)
    many = max(30 // n, 1)  # calls in a round, for a clock that tells microseconds
    benchmark.pedantic(call, about, rounds=1)
    (best,) = best_times(lambda: [call(*about) for _ in range(many)], rounds=9 if n <= 1000 else 2)
    note(work, each, n, best / many / n, criterion=criterion)
