"""Laps in ground that pushes back end, whatever the machine, the ground, its picks and the step."""

import numpy as np
import pytest

from tests.audit.long import many
from tests.controllers import job_with
from tunneller_lib.job import read_job
from tunneller_lib.ream import face
from tunneller_lib.ream.cutting import simulate

READS = ["tunneller_lib/job/reference.toml"]
EXAMPLE = "tunneller_lib/job/reference.toml"
GROUNDS = 2e6, 5e6, 20e6, 80e6, 250e6  # J/m^3
SCALES = 0.6, 0.8, 1.0, 1.2, 1.4  # of the machine and its section


def drawn(rng):
    """Return a legal job: 1 to 3 laps of a machine in a ground, coarsely planned and modelled."""
    example = read_job(EXAMPLE)
    scale = float(rng.choice(SCALES))
    sizes = {name: scale * example.machine[name]
             for name in ("r", "R", "cutter_radius", "depth", "height")}  # fmt: skip
    job = job_with(
        example,
        machine=sizes,
        section={"a": scale * example.section["a"]},
        ground={"energy": float(rng.choice(GROUNDS)), "normal": float(rng.uniform(0.2, 2.0)),
                "ripple": float(rng.choice([0.0, 0.3, 0.6, 0.99]))},
        limits={"power": 3e3 * scale**2},
        controller={"gain": float(rng.uniform(4.0, 10.0)) / max(scale, 1.0)},
        plan={"laps": int(rng.integers(1, 4)), "advance": float(rng.uniform(0.02, 0.1)),
              "tolerance": 3e-3 * scale, "rest": 0.3, "arm_radius": 0.05},
        wall={"along": 60, "around": 120, "thickness": 0.3 * scale},
    )  # fmt: skip
    try:
        job.planned  # noqa: B018
    except ValueError:  # refused by its own key, before it is simulated
        return drawn(rng)
    if job.planned.laps * job.planned.ticks.sum() > 60_000:  # hard ground, for long
        return drawn(rng)
    return job


@pytest.mark.parametrize("seed", range(many(5, 225)))
def test_any_laps_in_ground_end_and_remove_what_the_force_is_for(seed):
    job = drawn(np.random.default_rng(seed))
    cut = job.simulated()
    assert len(cut.lap_volumes) == job.planned.laps and np.all(cut.lap_volumes > 0)
    # The force of a tick, its mean, is that of the rate at which the tick removes ground.
    ground = job.pushing
    first = int(job.planned.entry.ticks.sum())
    pulse = ground.pulse(job.planned.tick * (first + np.arange(len(cut.force)) + 0.5))
    taken = cut.force / ground.force(pulse) * job.planned.tick
    assert taken.sum() == pytest.approx(cut.removed.sum(), rel=1.1 * face.CLOSE)


def test_example_with_two_laps_leaves_no_more_on_the_second_than_on_the_first():
    job = job_with(read_job(EXAMPLE), plan={"laps": 2}, wall={"along": 100, "around": 180})
    cut = simulate(job.planned, *job.axes, arm=job.arm, ground=job.pushing, shape=(100, 180))
    under = [-off.min() for off in cut.lap_deviations]
    assert 0.3 * under[0] < under[1] < 1.1 * under[0] < 3e-3
    assert cut.lap_volumes[1] < 0.5 * cut.lap_volumes[0]
