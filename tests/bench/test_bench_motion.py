"""How fast set-values are made and laps are run."""

import ctypes
from functools import partial

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.bench.conftest import best_times
from tunneller_lib.kernels import compiled
from tunneller_lib.motion import Compressible, Lag, Loop, Push, follow, polyline, time_bresenham
from tunneller_lib.motion.oil import PHASE
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.motion.ticks import Control, control_of
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
    line, rounded, formula = best_times(
        lambda: time_bresenham(*ends, ticks),
        lambda: np.rint(np.linspace(*ends, ticks + 1, axis=-1)),
        lambda: each_move(plain_formula, *ends, ticks),
    )
    say(f"time_bresenham, {moves}, times as fast as a plain loop over its formula", formula / line)
    say(f"a rounded linspace, {moves}, times as fast as a loop over the formula", formula / rounded)
    say(f"time_bresenham, {moves}, time over that of a rounded linspace", line / rounded)
    assert formula >= 8 * line and line <= 3 * rounded


@pytest.fixture
def at_once(monkeypatch):
    """Compile from the first loop on."""
    pytest.importorskip("numba", reason="what is compiled is timed")
    monkeypatch.setattr(compiled._Work, "compiled", True)
    monkeypatch.setattr(compiled._Work, "of_kind", {"axes": np.inf})


LAG_LOOPS = {
    "linear": Loop(10.0, 0.005, feedforward=1.0),
    "counts, limit and delay": Loop(10.0, 0.005, feedforward=1.0, delay=1, count=COUNT),
}


class ControlInC(ctypes.Structure):
    """A `Control` as bounds/lag.c has it."""

    _fields_ = [(name, ctypes.c_double) for name in Control._fields[:-1]]
    _fields_ += [(Control._fields[-1], ctypes.c_long)]


@pytest.fixture
def lag_in_c(bound_in_c):
    """Return a function that runs a lag under a loop in C and returns states and commands."""
    run_lag = bound_in_c("lag").run_lag
    array = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
    control = ctypes.POINTER(ControlInC)
    run_lag.argtypes = [
        array, ctypes.c_double, control, *[array] * 3, ctypes.c_long, *[array] * 2
    ]  # fmt: skip
    run_lag.restype = None

    def prepared(plant, loop, setvalues, slopes):
        numbers = plant.numbers(loop.tick)
        rows = np.array(numbers.rows)
        control = ControlInC(*control_of(loop))

        def run():
            states = np.empty((len(setvalues), 2))
            states[0] = setvalues[0], 0.0
            commands = np.empty(len(slopes))
            run_lag(
                rows, numbers.steady, control, np.zeros(1 + loop.delay),
                setvalues, slopes, len(slopes), states, commands,
            )  # fmt: skip
            return states, commands

        return run

    return prepared


@pytest.mark.parametrize("n", [1, 1000, 1_000_000])
@pytest.mark.parametrize("kind", LAG_LOOPS)
def test_lag_against_lfilter(benchmark, say, note, at_once, lag_in_c, kind, n):
    # The peer filters as many numbers by as many states: the linear loop's work alone, without
    # the commands, the rounding and the states that `follow` gives.
    values = np.resize(lap()[0][:, 0], n + 1)
    slopes = np.diff(values) / 0.005
    loop = LAG_LOOPS[kind]
    plant = Lag(0.5, 0.02)
    run = partial(follow, plant, loop, values, slopes=slopes)
    b, a = [0.0, 1e-3, 9e-4], [1.0, -1.7, 0.75]
    track = benchmark.pedantic(run, rounds=3)
    bound = lag_in_c(plant, loop, values, slopes)
    states, commands = bound()
    np.testing.assert_array_equal(track.states[0], states)
    np.testing.assert_array_equal(track.command, commands)
    many = max(1000 // n, 1)  # calls in a round, for a clock that tells microseconds
    times = best_times(
        *(
            lambda once=once: [once() for _ in range(many)]
            for once in (run, lambda: lfilter(b, a, values), bound)
        ),
        rounds=15 if n < 1_000_000 else 5,
    )
    ours, theirs, limit = times / many / n
    say(f"{kind} lag, {n} ticks, us a tick", 1e6 * ours)
    say(f"{kind} lag, {n} ticks, time over that of lfilter of order two", ours / theirs, "scipy")
    say(f"{kind} lag, {n} ticks, time over that of C", ours / limit)
    note(
        f"lag in a position loop, {kind}", "tick", n, ours,
        peer="scipy lfilter of order two", peer_s=theirs, bound_s=limit,
        criterion="states and commands of C to the last bit; the peer filters one column",
    )  # fmt: skip


@pytest.mark.parametrize("n", [1, 1000, TICKS])
def test_oil_a_tick(benchmark, say, note, at_once, n):
    values, slopes = lap()
    values = values[: n + 1]
    slopes = slopes[:n]
    axes = axes_of(REFERENCE_MACHINE, usual_sizes(REFERENCE_MACHINE))
    plants = [Compressible(axis) for axis in axes]
    arm = arm_of(REFERENCE_MACHINE, usual_sizes(REFERENCE_MACHINE))
    push = Push(damper=2e4, lever=(0.88, 0.8), across=(0.2, -0.1))
    loop = LAG_LOOPS["counts, limit and delay"]
    alone = partial(follow, plants, loop, values, slopes=slopes)
    both = partial(alone, arm=arm, push=push)
    benchmark.pedantic(alone, rounds=2)
    both()
    first, second = best_times(alone, both, rounds=5 if n == TICKS else 15)
    say(f"T3, {n} ticks, us a tick and axis", 1e6 * first / n / 2)
    say(f"both joints with arm and ground, {n} ticks, us a tick", 1e6 * second / n)
    criterion = f"steps of Runge and Kutta's method of at most {PHASE:g} rad of the resonance"
    note("compressible oil", "tick and axis", n, first / n / 2, criterion=criterion)
    note("both joints with arm and ground", "tick", n, second / n, criterion=criterion)
