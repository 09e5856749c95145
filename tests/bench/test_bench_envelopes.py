"""How fast all hyperosculating cones are found, jets, zeros and verdicts together."""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.envelopes import hyperosculating_cones, recognise
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.milling import BladeRing

ANGLE = np.radians(10)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)
S, T = np.random.default_rng(0).uniform(0.05, 0.95, (2, 8000))


def solve(n):
    return hyperosculating_cones(RING.coordinates, S[:n], T[:n], half_angle=ANGLE, model="space")


@pytest.mark.parametrize("count", [1, 1000, 8000])
def test_points_per_second(benchmark, say, note, count):
    cones = benchmark.pedantic(solve, (count,), rounds=1)
    assert np.count_nonzero(cones.count) > 0.9 * count
    (best,) = best_times(lambda: solve(count), rounds={1: 200, 1000: 10}.get(count, 3))
    work = "hyperosculating cones of a blade, in space"
    say(f"{work}, {count} points, us a point", 1e6 * best / count)
    note(work, "point", count, best / count, criterion="all cones with their verdicts")


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
