"""How fast set-values are made and laps are run."""

from functools import partial

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.bench.conftest import best_times
from tunneller_lib import compiled
from tunneller_lib.motion import (
    Compressible,
    Lag,
    Loop,
    Push,
    arm_of,
    axes_of,
    follow,
    line_ticks,
    polyline,
    time_bresenham,
    usual_sizes,
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


@pytest.fixture
def at_once(monkeypatch):
    """Compile from the first loop on."""
    pytest.importorskip("numba", reason="what is compiled is timed")
    monkeypatch.setattr(compiled._Work, "compiled", True)


LAG_LOOPS = {
    "linear": Loop(10.0, 0.005, feedforward=1.0),
    "counts, limit and delay": Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT),
}


@pytest.mark.parametrize("kind", LAG_LOOPS)
def test_lag_against_lfilter(benchmark, say, at_once, kind):
    # The peer filters as many numbers by as many states: the linear loop's work alone, without
    # the commands, the rounding and the states that `follow` gives.
    values = np.tile(lap()[0][:, 0], 20)
    slopes = np.diff(values) / 0.005
    loop = LAG_LOOPS[kind]
    plant = Lag(0.5, 0.02)
    run = partial(follow, plant, loop, values, slopes=slopes)
    b, a = [0.0, 1e-3, 9e-4], [1.0, -1.7, 0.75]
    benchmark.pedantic(run, rounds=3)
    ours, theirs = best_times(run, lambda: lfilter(b, a, values), rounds=15)
    say(f"{kind} lag, us a tick", 1e6 * ours / len(values))
    say(f"{kind} lag, time over that of lfilter of order two", ours / theirs, "scipy")


def test_oil_a_tick(benchmark, say, at_once):
    values, slopes = lap()
    axes = axes_of(REFERENCE_MACHINE, usual_sizes(REFERENCE_MACHINE))
    plants = [Compressible(axis) for axis in axes]
    arm = arm_of(REFERENCE_MACHINE, usual_sizes(REFERENCE_MACHINE))
    push = Push(damper=2e4, lever=(0.88, 0.8), across=(0.2, -0.1))
    loop = LAG_LOOPS["counts, limit and delay"]
    alone = partial(follow, plants, loop, values, slopes=slopes)
    both = partial(alone, arm=arm, push=push)
    benchmark.pedantic(alone, rounds=2)
    both()
    times = best_times(alone, both, rounds=5)
    say("T3, us a tick and axis", 1e6 * times[0] / TICKS / 2)
    say("both joints with arm and ground, us a tick", 1e6 * times[1] / TICKS)
