"""What the benchmarks share: times of functions that take turns, and how a ratio is told.

Each ratio is of the best of several rounds in which both sides take turns, so that a busy moment
of the computer hits both.
"""

import platform
import time
from pathlib import Path

import numpy as np
import pytest


def processor():
    """Return the name of the processor, where the system tells."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def best_times(*functions, rounds=15):
    """Return the least time of each function over rounds in which they take turns, in s."""
    times = []
    for _ in range(rounds):
        for function in functions:
            start = time.perf_counter()
            function()
            times.append(time.perf_counter() - start)
    return np.min(np.reshape(times, (rounds, -1)), axis=0)


@pytest.fixture
def say(capsys, benchmark):
    def print_and_keep(what, ratio):
        benchmark.extra_info[what] = ratio
        with capsys.disabled():
            print(f"\n{what}: {ratio:.3g} (numpy {np.__version__}, {processor()})")

    return print_and_keep
