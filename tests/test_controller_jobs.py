"""The exported motion generator of random jobs: it keeps what they ask, or says what it can."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.audit.long import many
from tests.controllers import WIRED, build, with_program
from tunneller_lib.job import read_job
from tunneller_lib.job.controller_texts import c99_header, c99_text

READS = ["tests/references/reference_job.toml"]

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
MOST_TICKS = many(3e5, 1.5e6)  # of a job, or the planner's arrays are large
RUN = """
#include <stdio.h>
static int32_t counts(int32_t set)
{
    return (int32_t)floor(set * rCount / rEncoder + 0.5);
}
int main(void)
{
    int32_t first = -1, steps = 0, scans;
    tunneller.bEnable = true;
    tunneller.nActualTheta = counts(BEGIN_THETA);
    tunneller.nActualPhi = counts(BEGIN_PHI);
    for (scans = 0; !tunneller.bDone && !tunneller.bError; ++scans) {
        if (scans % SLOW == 0) fb_setpoints(&setpoints, &ring);
        tunneller.bStart = scans > 2;
        tunneller.bStepDone = tunneller.bStepRequest;
        steps += tunneller.bStepRequest;
        fb_tunneller(&tunneller, &ring);
        tunneller.nActualTheta = counts(tunneller.nSetTheta);
        tunneller.nActualPhi = counts(tunneller.nSetPhi);
        if (tunneller.nTick >= 0 && tunneller.nScale > 0 && first < 0) first = scans;
    }
    printf("%ld %ld %ld\\n", (long)(scans - 1 - first), (long)steps, (long)tunneller.nErrorId);
    return 0;
}
"""


def random_job(rng):
    """Return a random job: ticks of 0.1 ms to 0.1 s, steps of 0.2 to 20 mm, 12 to 24 bits."""
    whole = read_job(REFERENCE_JOB)
    while True:
        tick = float(np.round(10 ** rng.uniform(-4, -1), 5))
        feed = 10 ** rng.uniform(-3, np.log10(0.3))  # m/s
        if 3.2 / feed / tick < MOST_TICKS:
            break
    return replace(
        whole,
        # The axes of this test are a tick behind.
        controller={**whole.controller, "plant": "T0", "gain": min(10.0, 0.3 / tick),
                    "trip": max(5e-3, 2 * feed * tick)},
        limits={**whole.limits, "feed": feed, "acceleration": 10 ** rng.uniform(-1, 0.5)},
        plan={
            **whole.plan, "tick": tick, "step": 10 ** rng.uniform(np.log10(2e-4), np.log10(0.02)),
            "count": 2 * np.pi / 2 ** int(rng.integers(12, 25)), "laps": int(rng.integers(1, 3)),
            "advance": 0.02, "tolerance": 2e-3,
            "path": str(rng.choice(["projected chord", "corrected chord"])),
        },
    )  # fmt: skip


def with_its_value(wanted, sentence):
    """Return a job in which the value stands that a refusal names."""
    said = re.fullmatch(r"\[(\w+)\] (\w+): .* ([-+.e\d]+)(?: m| s| rad)? would do\.", sentence)
    assert said, sentence
    table, key, value = said.groups()
    return replace(wanted, **{table: {**getattr(wanted, table), key: float(value)}})


@pytest.mark.skipif(not COMPILER, reason="no C compiler on this machine")
# 18 and 20: a lap whose first moves take a tick each, behind a step; a ring that nearly runs low.
@pytest.mark.parametrize("seed", sorted({*range(many(5, 200)), 18, 20}))
def test_any_job_runs_in_its_time_or_is_refused_with_a_value_that_does(tmp_path, seed):
    rng = np.random.default_rng(seed)
    wanted = random_job(rng)
    while True:
        try:
            plan = wanted.planned
            break
        except ValueError:  # the plan's own: steps within a tick, counts beyond the tolerance
            wanted = random_job(rng)
    keys = []
    while True:
        try:
            made = with_program(wanted)
            break
        except ValueError as error:
            keys.append(str(error).partition(":")[0])
            wanted = with_its_value(wanted, str(error))
            plan = wanted.planned
    assert len(set(keys)) == len(keys)  # each value did
    (tmp_path / "controller.h").write_text(c99_header(made))
    begin = np.rint(plan.entry.setvalues[0] / plan.count).astype(int)
    options = [f"-DBEGIN_THETA={begin[0]}", f"-DBEGIN_PHI={begin[1]}", f"-DSLOW={made.slow}"]
    program = build(COMPILER, tmp_path, c99_text(made) + WIRED + RUN, "-std=c99", "-O1",
                    "-fsanitize=undefined", "-fno-sanitize-recover=all", *options)  # fmt: skip
    done = subprocess.run([program], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    scans, steps, error = map(int, done.stdout.split())
    ticks = int(plan.entry.ticks.sum() + plan.laps * plan.ticks.sum() + plan.leave.ticks.sum())
    assert (steps, error) == (plan.laps - 1, 0)
    # The hand-over of a step takes a scan besides.
    assert abs(scans - ticks - steps) <= 1


@pytest.mark.parametrize("encoder", [0.0, 2e-4])
def test_encoder_is_exported_as_it_is_and_an_ideal_one_with_the_counts_of_the_plan(encoder):
    whole = read_job(REFERENCE_JOB)
    made = with_program(replace(whole, controller={**whole.controller, "encoder": encoder}))
    (given,) = set(re.findall(r"rEncoder : LREAL := (.*);", made.text))
    assert float(given) == (encoder or whole.planned.count)


REFUSED = [
    ({"controller": {"trip": 1e-5}}, r"^\[controller\] trip: .* without a fault; got 1e-05 m, "),
    ({"controller": {"feedforward": 0.0, "gain": 4.0}}, r"^\[controller\] trip: .* would do\.$"),
    ({"controller": {"operations": 1e3}}, r"^\[controller\] operations: the slow task takes "),
    ({"limits": {"feed": 0.3, "acceleration": 2.0}, "controller": {"trip": 0.05, "gain": 3.0},
      "plan": {"tick": 0.05, "count": 1.5e-7, "step": 0.02}},
     r"^\[plan\] count: in a tick a joint moves \d+, and may move 65534; .* rad would do\.$"),
    # A tick just too short for a change of the scale by its least part, and for the ring.
    ({"limits": {"acceleration": 1e-4, "feed": 0.3}, "plan": {"tick": 2.7e-3}},
     r"^\[plan\] tick: to stop takes \d+ ticks, and may take 32768; .* s would do\.$"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), REFUSED)
def test_what_cannot_be_kept_is_refused_with_what_can(changes, sentence):
    whole = read_job(REFERENCE_JOB)
    wanted = replace(
        whole, **{table: {**getattr(whole, table), **keys} for table, keys in changes.items()}
    )
    with pytest.raises(ValueError, match=sentence) as refused:
        with_program(wanted)
    if "would do" in str(refused.value):
        with_program(with_its_value(wanted, str(refused.value)))
