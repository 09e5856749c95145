"""How fast the torus answers, against the least that could be done and against the quartics."""

import numpy as np
import pytest

from exhibits import quartics
from exhibits.quartics import foot_quartic
from tests.bench.conftest import best_times
from tunneller_lib.surfaces import Torus

TORUS = Torus(0.08, 0.8)
POINTS = np.random.default_rng(0).uniform(-1, 1, (100_000, 3))
FEW = 2_000


def arctan2_pair():
    x, y, z = POINTS.T
    return np.arctan2(z, x), np.arctan2(y, x)


def numpy_roots():
    return [np.roots(c) for c in foot_quartic(TORUS, POINTS[:FEW])]


def test_foot_against_an_arctan2_pair(benchmark, say):
    benchmark(TORUS.foot, POINTS)
    foot, pair = best_times(lambda: TORUS.foot(POINTS), arctan2_pair)
    say("foot, time over that of a pair of arctan2", foot / pair)
    assert foot <= 3 * pair


def test_foot_against_numpy_roots(benchmark, say):
    benchmark.pedantic(numpy_roots, rounds=3)
    foot, roots = best_times(lambda: TORUS.foot(POINTS), numpy_roots, rounds=5)
    ratio = (roots / FEW) / (foot / len(POINTS))
    say("foot, points per second over those of numpy.roots", ratio)
    assert ratio >= 50


@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
def test_meet_line_by_number(benchmark, note, n):
    a, b = np.random.default_rng(0).uniform(-1, 1, (2, n, 3))
    benchmark.pedantic(TORUS.meet_line, (a, b), rounds=1)
    many = max(100 // n, 1)  # calls in a round, for a clock that tells microseconds
    (best,) = best_times(
        lambda: [TORUS.meet_line(a, b) for _ in range(many)], rounds=9 if n < 1_000_000 else 2
    )
    note(
        "line against a torus", "line", n, best / many / n,
        criterion="all real roots, to the bounds of tests/test_torus_line.py",
    )  # fmt: skip


def test_meet_line_against_the_quartic(benchmark, say):
    a, b = POINTS[:20_000], POINTS[20_000:40_000]
    benchmark.pedantic(TORUS.meet_line, (a, b), rounds=3)
    exact, quartic = best_times(
        lambda: TORUS.meet_line(a, b), lambda: quartics.meet_line(TORUS, a, b), rounds=5
    )
    say("meet_line, time of the exact method over that of the quartic", exact / quartic)
