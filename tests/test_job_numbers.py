"""What a job leaves out, what its sums hold, and which unit a number is taken to be in."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.examples.job import _JOB
from tunneller_lib.job import read_job
from tunneller_lib.job.results import summarise
from tunneller_lib.ream.cutting import simulate
from tunneller_lib.removal import DexelGrid

READS = ["notebooks/reference.toml"]
COARSE = _JOB.read_text(encoding="utf-8")
REFERENCE = Path(__file__).parents[1] / "notebooks" / "reference.toml"
IN_GROUND = """
power = 3e3

[ground]
energy = 20e6
pick_speed = 2.0
normal = 0.5
"""


def job_of(path, *changes):
    """Return the job of the examples with lines put in the place of others."""
    text = COARSE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return read_job(path)


def test_litres_of_a_cut_are_those_that_its_ground_has_lost(tmp_path):
    job = job_of(tmp_path / "job.toml")
    cut = simulate(job.planned, *job.axes, shape=(40, 60), thickness=0.3)
    assert cut.plunged > 0.01 * cut.removed.sum() > 0
    lines, left = cut.wall.lines, cut.wall
    begins = job.planned.circuit.section.ray(np.arctan2(lines.sin, lines.cos))
    lost = DexelGrid(lines, begins, left.high.max(axis=0)).volume - left.volume
    assert summarise(job, cut)["removed_m3"] == pytest.approx(lost, rel=1e-9)


def test_a_job_in_ground_asks_for_the_share_of_its_valves_that_the_reference_says(tmp_path):
    [said] = re.findall(r"^# valve = (\S+)", REFERENCE.read_text(encoding="utf-8"), re.MULTILINE)
    oily = ('plant = "T0"', 'plant = "T3"'), ("feed = 1.0", "feed = 0.1")
    plain, given, more = (
        job_of(tmp_path / "job.toml", *oily, ("acceleration = 20\n", f"acceleration = 1\n{line}"
                                              + IN_GROUND)).planned
        for line in ("", f"valve = {said}\n", "valve = 0.9\n")
    )  # fmt: skip
    assert plain.limits.valve == given.limits.valve == float(said) == 0.8
    assert plain.lap_time == given.lap_time
    assert more.limits.valve == 0.9


def test_a_flow_in_litres_a_minute_is_given_in_cubic_metres_a_second(tmp_path):
    # 90 litres a minute are 0.09 m^3 in 60 s.
    with pytest.raises(ValueError, match=r"If that is in l/min, it is 0\.0015 m\^3/s\.$"):
        job_of(tmp_path / "job.toml", ("acceleration = 20", "acceleration = 20\nflow = 90"))
