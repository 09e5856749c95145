"""The exported C99 of random jobs, with sanitizers, in closed loop with the library's axes."""

import shutil
import subprocess
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from tests.controllers import (
    SANITIZERS,
    Driven,
    build,
    c99_program,
    closed_loop,
    differences,
    followed,
    moved,
    random_jobs,
    with_program,
)
from tests.long import many
from tunneller_lib.job import read_job
from tunneller_lib.ream import carve

READS = ["tests/references/reference_job.toml"]

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
OPTIONS = "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic", "-O1"
# Setpoints from tables are the library's. One that the slow task computes is, too, but where its
# rounding to parts of a count meets a tie: then it is a part off, and the slope with it.
STORED, COMPUTED, OPENED = 1e-12, 2.0, 1e-5  # rad; parts of a count; of the valve


@pytest.fixture(scope="module")
def options(tmp_path_factory):
    """Return the compiler's options, sanitizers among them where it has them."""
    if not COMPILER:
        pytest.skip("no C compiler on this machine")
    try:
        build(COMPILER, tmp_path_factory.mktemp("try"), "int main(void) { return 0; }", *SANITIZERS)
    except subprocess.CalledProcessError:
        return OPTIONS
    return *OPTIONS, *SANITIZERS


@pytest.fixture
def driven(tmp_path, options):
    """Return a function that compiles a job's controller and starts it."""
    programs = []

    def start(wanted, **how):
        folder = tmp_path / str(len(programs))
        folder.mkdir()
        path = c99_program(COMPILER, folder, with_program(wanted, **how), *options)
        programs.append(Driven(path))
        return programs[-1]

    yield start
    assert [program.close() for program in programs] == [0] * len(programs)


def part_of_a_count(lap):
    """Return the angle, in rad, to which the setpoints of a plan's controller are rounded."""
    return lap.count / min(moves.fineness for moves in (lap, lap.entry, lap.leave))


def test_random_jobs_in_closed_loop_are_the_librarys(driven):
    kinds = []
    for number, wanted in enumerate(islice(random_jobs(5), many(3, 20))):
        setpoints = ("computed", "stored")[number % 2]
        kinds.append((wanted.controller["plant"], wanted.plan["path"], wanted.section["shape"]))
        controller = driven(wanted, setpoints=setpoints)
        track = followed(wanted)
        found = closed_loop(controller, wanted, len(track.command))
        wrong, away, opened = differences(found, track, wanted.planned.count)
        near, open_by = STORED, STORED
        if setpoints == "computed":
            near, open_by = COMPUTED * part_of_a_count(wanted.planned), OPENED
        assert wrong == 0 and away < near and opened < open_by, (number, kinds[-1])
        c = controller.c
        assert c.nStarved == c.nTripped == 0
        # What the scan after the last one says: all moves are made.
        controller.fast()
        assert (c.bDone, c.nMode) == (1, 0)
        assert np.ptp(found[:, 0]) > 1000
    assert len(set(kinds)) == len(kinds) or len(kinds) > 12


def test_closed_loop_with_oil_leaves_the_librarys_wall(driven):
    wanted = read_job(REFERENCE_JOB)
    wanted = replace(wanted, controller={**wanted.controller, "plant": "T3"})
    lap = wanted.planned
    track = followed(wanted)
    found = closed_loop(driven(wanted), wanted, len(track.command))
    wrong, away, opened = differences(found, track, lap.count)
    assert wrong == 0 and away < COMPUTED * part_of_a_count(lap) and opened < OPENED
    first = int(lap.entry.ticks.sum())
    whole = slice(first, first + int(lap.ticks.sum()) + 1)
    ways = found[whole, 2:4], track.position[whole]
    walls = [carve(lap, way, shape=(100, 180)).overbreak for way in ways]
    assert abs(walls[0].max()) < 1e-3  # the wall that is wanted was reached
    np.testing.assert_allclose(walls[0], walls[1], atol=1e-9)


@pytest.mark.parametrize("stored", [False, True])
def test_any_use_of_the_inputs_stays_within_bounds(driven, stored):
    """Whatever is pressed when: no sanitizer objects, and set-values stay on or inside the way."""
    rng = np.random.default_rng(3)
    wanted = next(islice(random_jobs(8), 1))
    controller = driven(wanted, setpoints="stored" if stored else "computed")
    lap = wanted.planned
    modes = set()

    def press(n, c):
        if n % 40 == 0:
            c.bRun, c.bHold, c.bReset = map(int, rng.random(3) < (0.9, 0.3, 0.5))
            c.bRetract = int(n > 3000 and rng.random() < 0.2)
            c.nOverride = int(rng.integers(0, 257))
        if n % 1000 == 999:
            c.nActualTheta += 50_000  # a trip
        modes.add(c.nMode)

    found = closed_loop(controller, wanted, 6000, ahead=1, before=press)
    assert modes == {0, 1, 2, 3}
    every = moved(lap)[0] / lap.count
    assert np.all(found[:, :2] >= np.floor(every.min(axis=0)) - 1)
    assert np.all(found[:, :2] <= np.ceil(every.max(axis=0)) + 1)
    assert np.all(np.abs(found[:, 4:6]) <= 1)
