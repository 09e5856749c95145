"""How fast set-values are made and laps are run."""

import numpy as np

from tests.bench.conftest import best_times
from tunneller_lib.motion import (
    Compressible,
    Lag,
    Loop,
    polyline,
    reference_axes,
    simulate,
    time_bresenham,
)
from tunneller_lib.motion.interpolate import line_ticks
from tunneller_lib.surfaces import REFERENCE_MACHINE

TICKS = 10_000
STOP = 654_321
RNG = np.random.default_rng(0)
STARTS, STOPS = RNG.integers(-(2**16), 2**16, (2, 500, 2))
COUNT = 2 * np.pi / 2**16


def plain_loop():
    return list(line_ticks(0, STOP, TICKS))


def lap():
    """Return set-values of a smooth lap of both joints, and their slopes, over 10^4 ticks."""
    turn = np.linspace(0, 2 * np.pi, 101)
    joints = np.radians(np.stack([-10 + 30 * np.sin(turn), 35 * np.sin(2 * turn)], axis=1))
    values = polyline(np.rint(joints / COUNT).astype(int), [TICKS // 100] * 100) * COUNT
    return values, np.diff(values, axis=0) / 0.005


def test_line_against_the_plain_loop(benchmark, say):
    benchmark(time_bresenham, 0, STOP, TICKS)
    line, loop = best_times(lambda: time_bresenham(0, STOP, TICKS), plain_loop)
    say("time_bresenham, set-values per second over those of the loop tick by tick", loop / line)
    assert loop >= 4 * line


def test_line_against_linspace(benchmark, say):
    benchmark(time_bresenham, STARTS, STOPS, 200)
    for what, ends, ticks in [("one move", (0, STOP), TICKS), ("1000 moves", (STARTS, STOPS), 200)]:
        line, rounded = best_times(
            lambda ends=ends, ticks=ticks: time_bresenham(*ends, ticks),
            lambda ends=ends, ticks=ticks: np.rint(np.linspace(*ends, ticks + 1, axis=-1)),
        )
        say(f"time_bresenham, time over that of a rounded linspace, {what}", line / rounded)
        assert line <= 3 * rounded


def test_lap_with_a_lag(benchmark, say):
    values, slopes = lap()
    loop = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT)
    run = lambda: simulate(Lag(0.5, 0.02), loop, values, slopes=slopes)  # noqa: E731
    benchmark.pedantic(run, rounds=3)
    (time,) = best_times(run, rounds=5)
    say("10^4 ticks of two axes with T1, s", time)
    assert time < 0.1


def test_lap_with_compressible_oil(benchmark, say):
    values, slopes = lap()
    loop = Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT)
    plants = [Compressible(axis) for axis in reference_axes(REFERENCE_MACHINE)]
    run = lambda: simulate(plants, loop, values, slopes=slopes)  # noqa: E731
    benchmark.pedantic(run, rounds=1)
    (time,) = best_times(run, rounds=2)
    say("10^4 ticks of two axes with T3, s", time)
    assert time < 5
