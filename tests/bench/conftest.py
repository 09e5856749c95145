"""What the benchmarks share: fair timing, and one line for each result.

Each ratio is of the best of several rounds in which both sides take turns, in processor time, so
that a busy moment of the computer hits both, and threads count for what they are.
"""

import ctypes
import importlib
import os
import platform
import shutil
import subprocess
import time
from datetime import date
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from tests.bench import growth, times

BOUNDS = Path(__file__).parent / "bounds"
FLAGS = "-O3 -march=x86-64-v3 -ffp-contract=off -fno-math-errno -shared -fPIC".split()
NOTED = pytest.StashKey[list]()


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


@pytest.fixture
def bound_in_c(tmp_path):
    """Return a function that compiles a file of bounds/, by its name, and returns the library."""
    compiler = shutil.which("gcc")
    if not compiler:
        pytest.skip("no gcc on this machine")

    def compile_and_load(name):
        library = tmp_path / f"{name}.so"
        source = BOUNDS / f"{name}.c"
        subprocess.run([compiler, *FLAGS, source, "-o", library, "-lm"], check=True)
        return ctypes.CDLL(str(library))

    return compile_and_load


@pytest.fixture
def note(request, benchmark):
    """Return a function that keeps a row of the table of times, see `times.COLUMNS`.

    `work` names it, `each` one of the `n` that one call answers; times are processor seconds by
    each. `peer` is a package, or a package and what of it is called; `criterion` says what both
    sides agree in.
    """

    def keep(work, each, n, here, *, criterion, peer="", peer_s=None, bound_s=None):
        package, _, call = peer.partition(" ")
        row = {
            "work": work,
            "each": each,
            "n": n,
            "here_s": here,
            "peer": f"{package} {version(package)} {call}".strip() if peer else "",
            "peer_s": peer_s,
            "bound_s": bound_s,
        }
        # Three digits are more than a run on a busy machine repeats.
        row |= {k: f"{row[k]:.3g}" if row[k] else "" for k in ("here_s", "peer_s", "bound_s")}
        row |= {
            "criterion": criterion,
            "date": date.today().isoformat(),
            "processor": processor(),
            "versions": ", ".join(
                f"{name} {version(name)}" for name in ("numpy", "scipy", "numba")
            ),
            "load": f"{os.getloadavg()[0]:.1f}",
        }
        request.config.stash.setdefault(NOTED, []).append(row)

    return keep


def pytest_sessionfinish(session):
    """Keep the rows that were noted."""
    if noted := session.config.stash.get(NOTED, None):
        times.keep(noted)
        text = times.PAGE.read_text(encoding="utf-8")
        times.PAGE.write_text(times.with_table(text), encoding="utf-8")
        growth.write()
