"""A whole lap: set-values, axes and wall; and that laps cost what they should."""

import re
import resource
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.job import read_job
from tunneller_lib.motion import Lag, Loop
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, plan, simulate
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "notebooks" / "reference.toml"
SHAPE = 400, 720
LIMITS = Limits(feed=0.06, acceleration=0.5)


def job(laps=1):
    circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    return plan(circuit, LIMITS, tolerance=1e-3, laps=laps, advance=0.04 * (laps > 1))


def run(lap):
    loop = Loop(10.0, lap.tick, feedforward=1.0, delay=1, count=lap.count)
    return simulate(lap, [Lag(0.5, 0.02)] * 2, [loop] * 2, shape=SHAPE)


def spent(lap):
    start = time.process_time()
    run(lap)
    return time.process_time() - start


def test_a_lap_of_ten_thousand_ticks(benchmark, say):
    lap = job()
    assert lap.ticks.sum() > 10_000
    seconds = benchmark.pedantic(spent, args=(lap,), rounds=2)
    tracemalloc.start()
    run(lap)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    say(f"a lap of {lap.ticks.sum()} ticks on {SHAPE[0]} x {SHAPE[1]} rays, CPU s", seconds)
    say("its greatest memory, MB", peak / 1e6)


@pytest.mark.parametrize("laps", [4])
def test_laps_cost_in_proportion(benchmark, say, laps):
    one, many = job(), job(laps)
    spent(one)
    several = benchmark.pedantic(spent, args=(many,), rounds=1)
    alone = np.min([spent(one) for _ in range(2)])
    say(f"{laps} laps over {laps} times one", several / (laps * alone))


def test_a_lap_with_everything_on(benchmark, say):
    def everything():
        start = time.process_time()
        read_job(REFERENCE).simulated()
        return time.process_time() - start

    everything()  # compiles what it needs
    seconds = benchmark.pedantic(everything, rounds=1)
    say("the reference job, planned and cut with ground, arm and oil, CPU s", seconds)


def processor_seconds(*command):
    """Return the processor time of a command of Python's, and what it wrote to stderr."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ran = subprocess.run(
        [sys.executable, *command], cwd=ROOT, check=True, capture_output=True, text=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, ran.stderr


def test_the_command_cuts_the_reference_job(benchmark, say, note, tmp_path):
    # As somebody calls it: Python, imports, what is compiled and kept, budget, files and picture.
    command = ["-m", "tunneller_lib", "cut", REFERENCE, "--out", tmp_path]
    benchmark.pedantic(processor_seconds, command, rounds=1)  # compiles what it needs
    seconds = min(processor_seconds(*command)[0] for _ in range(3))
    say("the command `tunneller cut` on the reference job, CPU s", seconds)
    note(
        "`tunneller cut` of the reference job", "job", 1, seconds,
        criterion="the whole command, with its imports and the picture of the wall",
    )  # fmt: skip
    imports = []
    for _ in range(3):
        _, told = processor_seconds("-X", "importtime", *command)
        each = re.findall(r"^import time: +(\d+) \|", told, re.MULTILINE)
        imports.append(sum(map(int, each)) / 1e6)
    say("of it the imports, s on the clock", min(imports))
