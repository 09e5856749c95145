"""How fast set-values are made and laps are run."""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.motion import (
    Compressible,
    Lag,
    Loop,
    follow,
    line_ticks,
    polyline,
    reference_axes,
    time_bresenham,
)
from tunneller_lib.surfaces import REFERENCE_MACHINE

TICKS = 10_000
STOP = 654_321
RNG = np.random.default_rng(0)
STARTS, STOPS = RNG.integers(-(2**16), 2**16, (2, 500, 2))
COUNT = 2 * np.pi / 2**16


def plain_formula(start, stop, ticks):
    """Return the closed form of one move, value by value."""
    difference, first = stop - start, ticks // 2
    return [start + (n * difference + first) // ticks for n in range(ticks + 1)]


def each_move(function, starts, stops, ticks):
    """Call a function of one move for each of many."""
    return [
        function(*ends, ticks)
        for ends in zip(np.ravel(starts).tolist(), np.ravel(stops).tolist(), strict=True)
    ]


MOVES = {"one move": (0, STOP, TICKS), "1000 moves": (STARTS, STOPS, 200)}


def lap():
    """Return set-values of a smooth lap of both joints, and their slopes, over 10^4 ticks."""
    turn = np.linspace(0, 2 * np.pi, 101)
    joints = np.radians(np.stack([-10 + 30 * np.sin(turn), 35 * np.sin(2 * turn)], axis=1))
    values = polyline(np.rint(joints / COUNT).astype(int), [TICKS // 100] * 100) * COUNT
    return values, np.diff(values, axis=0) / 0.005


@pytest.mark.parametrize("moves", MOVES)
def test_line_against_plain_loops_and_linspace(benchmark, say, moves):
    *ends, ticks = MOVES[moves]
    benchmark(time_bresenham, *ends, ticks)
    line, rounded, formula, sums = best_times(
        lambda: time_bresenham(*ends, ticks),
        lambda: np.rint(np.linspace(*ends, ticks + 1, axis=-1)),
        lambda: each_move(plain_formula, *ends, ticks),
        lambda: each_move(lambda *move: list(line_ticks(*move)), *ends, ticks),
    )
    say(f"time_bresenham, {moves}, times as fast as a plain loop over its formula", formula / line)
    say(f"time_bresenham, {moves}, times as fast as the loop of additions", sums / line)
    say(f"a rounded linspace, {moves}, times as fast as a loop over the formula", formula / rounded)
    say(f"time_bresenham, {moves}, time over that of a rounded linspace", line / rounded)
    assert min(formula, sums) >= 8 * line and line <= 3 * rounded


def test_lap_with_a_lag(benchmark, say):
    values, slopes = lap()
    loop = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT)
    run = lambda: follow(Lag(0.5, 0.02), loop, values, slopes=slopes)  # noqa: E731
    benchmark.pedantic(run, rounds=3)
    (time,) = best_times(run, rounds=5)
    say("10^4 ticks of two axes with T1, s", time)
    assert time < 0.1


def test_lap_with_compressible_oil(benchmark, say):
    values, slopes = lap()
    loop = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT)
    plants = [Compressible(axis) for axis in reference_axes(REFERENCE_MACHINE)]
    run = lambda: follow(plants, loop, values, slopes=slopes)  # noqa: E731
    benchmark.pedantic(run, rounds=1)
    (time,) = best_times(run, rounds=2)
    say("10^4 ticks of two axes with T3, s", time)
    assert time < 5
