"""What the benchmarks share: fair timing, and one line for each result.

Each ratio is of the best of several rounds in which both sides take turns, in processor time, so
that a busy moment of the computer hits both, and threads count for what they are.
"""

import importlib
import platform
import time
from importlib.metadata import version
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
    """Return the least processor time of each function, which take turns over rounds, in s."""
    times = []
    for _ in range(rounds):
        for function in functions:
            start = time.process_time()
            function()
            times.append(time.process_time() - start)
    return np.min(np.reshape(times, (rounds, -1)), axis=0)


@pytest.fixture
def installed(package):
    """Return a module that only the benchmarks need, or fail and say how to get it.

    A test that asks for it names it as its parameter `package`, and asks before it asks for
    `benchmark`.
    """
    try:
        return importlib.import_module(package)
    except ImportError as error:
        missing = f"{package} can't be imported ({error}); `make bench` installs it."
    pytest.fail(missing, pytrace=False)


@pytest.fixture
def say(capsys, benchmark):
    """Return a function that prints and keeps a result, with what it was measured on."""

    def print_and_keep(what, value, *packages):
        benchmark.extra_info[what] = value
        shown = f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"
        names = ("numpy", *(package.split(".")[0] for package in packages))
        versions = ", ".join(f"{name} {version(name)}" for name in names)
        with capsys.disabled():
            print(f"\n{what}: {shown} ({versions}, {processor()})")

    return print_and_keep
