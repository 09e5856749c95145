"""The exported C99 against the library in closed loop, tick by tick."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.bench.conftest import best_times
from tests.controllers import Driven, c99_program, closed_loop, differences, followed, with_program
from tunneller_lib.job import read_job

REFERENCE_JOB = Path(__file__).parents[1] / "references" / "reference_job.toml"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")


@pytest.mark.skipif(not COMPILER, reason="no C compiler on this machine")
@pytest.mark.parametrize("plant", ["T0", "T1", "T2", "T3"])
def test_closed_loop_tick_by_tick(benchmark, say, tmp_path, plant):
    whole = read_job(REFERENCE_JOB)
    wanted = replace(whole, controller={**whole.controller, "plant": plant})
    path = c99_program(COMPILER, tmp_path, with_program(wanted), "-std=c99", "-O2")
    track = followed(wanted)
    controller = Driven(path)
    found = benchmark.pedantic(closed_loop, args=(controller, wanted, len(track.command)), rounds=1)
    assert controller.close() == 0
    wrong, away, opened = differences(found, track, wanted.planned.count)
    say(f"{plant}: set-values that differ from the library's, of {len(found):,}", wrong)
    say(f"{plant}: positions differ by, rad", away)
    # A computed setpoint may be a part of a count off where its rounding meets a tie.
    part = wanted.planned.count / wanted.planned.fineness
    assert wrong == 0 and away < 2 * part and opened < 1e-5
    (python,) = best_times(lambda: followed(wanted), rounds=1)
    say(f"{plant}: the library's own run of the same, s", python)
