"""How fast all hyperosculating cones are found, jets, cubic and verdicts together.

Ratios against the least that could be done in the same run: the 6 x 6 eigenvalues alone.
"""

import numpy as np

from tests.bench.conftest import best_times
from tunneller_lib.envelopes import hyperosculating_cones, recognise
from tunneller_lib.envelopes.blade import BladeRing
from tunneller_lib.envelopes.families import cyclide

ANGLE = np.radians(10)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)
S, T = np.random.default_rng(0).uniform(0.05, 0.95, (2, 8000))


def solve(n):
    return hyperosculating_cones(RING.coordinates, S[:n], T[:n], half_angle=ANGLE, model="space")


def test_points_per_second_in_space(benchmark, say):
    benchmark.pedantic(solve, (2000,), rounds=3)
    (best,) = best_times(lambda: solve(2000), rounds=5)
    say("hyperosculating cones in space, points per second of one core", 2000 / best)
    assert 2000 / best >= 2000


def test_points_per_second_in_the_model(benchmark, say):
    def model():
        return hyperosculating_cones(cyclide, S[:2000], T[:2000], half_angle=ANGLE)

    benchmark.pedantic(model, rounds=3)
    (best,) = best_times(model, rounds=5)
    say("hyperosculating cones in the model, points per second of one core", 2000 / best)
    assert 2000 / best >= 2000


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
