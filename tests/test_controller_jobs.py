"""The exported motion generator of random jobs: it keeps what they ask, or says what it can."""

import re
import subprocess

import numpy as np
import pytest

from tests.audit.long import many
from tests.controllers import COMPILER, WIRED, build, job_with, with_program
from tunneller_lib.job.controller_texts import c99_header, c99_text

READS = ["tests/references/reference_job.toml"]

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
    """Return a random job that has a plan.

    Ticks are of 0.1 ms to 0.1 s, steps of 0.2 to 20 mm, counts of 12 to 24 bits.
    """
    tick = float(np.round(10 ** rng.uniform(-4, -1), 5))
    feed = 10 ** rng.uniform(-3, np.log10(0.3))  # m/s
    if 3.2 / feed / tick > MOST_TICKS:
        return random_job(rng)
    wanted = job_with(
        # The axes of this test are a tick behind.
        controller={"plant": "T0", "gain": min(10.0, 0.3 / tick),
                    "trip": max(5e-3, 2 * feed * tick)},
        limits={"feed": feed, "acceleration": 10 ** rng.uniform(-1, 0.5)},
        plan={
            "tick": tick, "step": 10 ** rng.uniform(np.log10(2e-4), np.log10(0.02)),
            "count": 2 * np.pi / 2 ** int(rng.integers(12, 25)), "laps": int(rng.integers(1, 3)),
            "advance": 0.02, "tolerance": 2e-3,
            "path": str(rng.choice(["projected chord", "corrected chord"])),
        },
    )  # fmt: skip
    try:
        wanted.planned  # noqa: B018
    except ValueError:  # steps within a tick, counts beyond the tolerance
        return random_job(rng)
    return wanted


def with_its_value(wanted, sentence):
    """Return a job in which the value stands that a refusal names."""
    said = re.fullmatch(r"\[(\w+)\] (\w+): .* ([-+.e\d]+)(?: \S+)? would do\.", sentence)
    assert said, sentence
    table, key, value = said.groups()
    return job_with(wanted, **{table: {key: float(value)}})


@pytest.mark.skipif(not COMPILER, reason="no C compiler on this machine")
# 18 and 20: a lap whose first moves take a tick each, behind a step; a ring that nearly runs low.
@pytest.mark.parametrize("seed", sorted({*range(many(0, 200)), 18, 20}))
def test_any_job_runs_in_its_time_or_is_refused_with_a_value_that_does(tmp_path, seed):
    rng = np.random.default_rng(seed)
    wanted = random_job(rng)
    keys, made = [], None
    while not made:
        try:
            made = with_program(wanted)
        except ValueError as error:
            keys.append(str(error).partition(":")[0])
            assert len(set(keys)) == len(keys)  # each value did
            wanted = with_its_value(wanted, str(error))
    plan = wanted.planned
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
    wanted = job_with(controller={"encoder": encoder})
    (given,) = set(re.findall(r"rEncoder : LREAL := (.*);", with_program(wanted).text))
    assert float(given) == (encoder or wanted.planned.count)


REFUSED = [
    ({"controller": {"trip": 1e-5}}, r"^\[controller\] trip: .* without a fault; got 1e-05 m, "),
    ({"controller": {"feedforward": 0.0, "gain": 4.0}}, r"^\[controller\] feedforward: the "
     r"following error asks for a trip of 0\.041 m in a cut 0\.02 m deep; got 0, 1 would do\.$"),
    ({"limits": {"feed": 1.0}}, r"^\[limits\] valve: theta's valve is fully open for .*, 0\.8 "),
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
    wanted = job_with(**changes)
    with pytest.raises(ValueError, match=sentence) as refused:
        with_program(wanted)
    if "would do" in str(refused.value):
        with_program(with_its_value(wanted, str(refused.value)))
