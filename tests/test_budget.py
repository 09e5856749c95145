"""The error budget: each fault alone against its closed form, what halves it, and their sum."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.audit.long import many
from tests.controllers import job_with
from tunneller_lib.job import read_job
from tunneller_lib.job.remedies import changed, halved_by
from tunneller_lib.motion import (
    Compressible,
    Integrator,
    Lag,
    Loop,
    Resonance,
    Rigid,
    follow,
    reference_axes,
)
from tunneller_lib.motion.plant import NoLinearForm, Plant, ValveResonance
from tunneller_lib.motion.stability import gain_limit
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Case, Limits, Pose, budget, halving, plan, starved, trailing
from tunneller_lib.ream.error_budget import Fault
from tunneller_lib.ream.sensitivity import rounding_passed
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

READS = ["notebooks/reference.toml"]

REFERENCE = Path(__file__).resolve().parents[1] / "notebooks" / "reference.toml"
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TILTED = cutting_circuit(REFERENCE_MACHINE, Egg(0.5), pitch=0.03, yaw=-0.04)
AXES = reference_axes(REFERENCE_MACHINE)
BITS16 = 2 * np.pi / 2**16
POSE = Pose(y=3e-3, z=-2e-3, roll=3e-3, pitch=2e-3, yaw=-4e-3)
P, FED = {"feedforward": 0.0}, {"feedforward": 1.0}


@cache
def job(circuit=CIRCUIT, *, feed=0.06, acceleration=0.5, **options):
    limits = Limits(feed=feed, acceleration=acceleration)
    return plan(circuit, limits, **({"tolerance": 1e-3, "rest": 0.5} | options))


LAP = job()
LATE = starved(LAP, [Task("line", 5000, 400)], 150_000)


def pair(gains=(10.0, 10.0), **options):
    return [Loop(gain, 0.005, **({"delay": 1, "count": BITS16} | options)) for gain in gains]


# Options of a lap and its source, and how near the closed form is.
CLOSED = [
    *(("knots", {"tolerance": t}, 0.01) for t in (3e-3, 1e-3, 2e-4)),
    *(("projected chord", {"tolerance": t}, 0.025) for t in (3e-3, 1e-3)),  # of short chords
    ("projected chord", {"tolerance": 2e-4}, 0.004),
    *(("corners", {"tolerance": t}, 0.006) for t in (3e-3, 1e-3, 2e-4)),
    *(("setpoints", {"step": step}, 1e-3) for step in (2e-2, 5e-3)),
    *(("counts", {"count": 2 * np.pi / 2**bits}, 0.025) for bits in (13, 16)),  # over one lap
    # The mean acceleration of a move stands for that of its middle.
    *(("feed ripple", {"acceleration": a}, 0.02) for a in (0.5, 0.1)),
]


@pytest.mark.parametrize("circuit", [CIRCUIT, TILTED], ids=["aligned", "tilted"])
@pytest.mark.parametrize(("source", "options", "near"), CLOSED)
def test_each_source_of_a_plan_alone_leaves_its_closed_form(circuit, source, options, near):
    fault = Case(job(circuit, **options)).fault(source)
    assert fault.source == source
    assert fault.measured == pytest.approx(fault.closed, rel=near)
    assert fault.along == (source == "feed ripple")
    if source == "knots":
        assert fault.under > fault.over  # chords keep inside


@pytest.mark.parametrize("tolerance", [3e-3, 1e-3, 2e-4])
def test_corrected_chords_leave_hardly_anything_and_have_no_closed_form(tolerance):
    plain, corrected = (
        Case(job(TILTED, tolerance=tolerance, path=path)).fault(path)
        for path in ("projected chord", "corrected chord")
    )
    assert corrected.measured < plain.measured / 100
    assert corrected.closed is None and corrected.ratio is None


PLANTS = {"T0": [Integrator(0.5)] * 2, "T1": [Lag(0.5, 0.02)] * 2, "T2": [*map(Rigid, AXES)],
          "resonance": [Resonance(0.5, 100.0, 0.15)] * 2,
          "and valve": [ValveResonance(0.5, 0.5, 90.0, 0.2, 0.01)] * 2}  # fmt: skip


@pytest.mark.parametrize("tier", PLANTS)
@pytest.mark.parametrize("gains", [(10.0, 10.0), (10.0, 8.0), (8.0, 12.0)][:: many(2, 1)])
@pytest.mark.parametrize("options", [P, FED])
def test_following_alone_leaves_its_series_in_the_lag(tier, gains, options):
    fault = Case(LAP, PLANTS[tier], pair(gains, **options)).fault("following")
    # Equal gains lag along the path. Others lag across it, of which the series lacks the third
    # order, and where the bend jumps they overshoot by micrometres.
    missed = 0.003 if gains[0] == gains[1] else 0.055
    assert fault.measured == pytest.approx(fault.closed, rel=missed)


def test_following_of_compressible_oil_is_worse_where_the_pressures_change_sides():
    loops = pair(**FED)
    fault = Case(LAP, [Compressible(a) for a in AXES], loops).fault("following")
    slow = Case(LAP, PLANTS["T2"], loops).fault("following")
    assert slow.measured < 1.06 * slow.closed < 1.06 * fault.closed  # the oil is late, too
    assert fault.measured > 3 * fault.closed
    rate = np.gradient(CIRCUIT.position(LAP.places)[:, 0])
    worst = np.argmax(np.abs(fault.deviation))
    turns = np.flatnonzero(np.diff(np.sign(rate[:-200])) != 0)
    assert 0 < np.min(np.abs(worst - turns)) < 250  # just after theta turns back


@pytest.mark.parametrize("feedforward", [0.0, 1.0])
def test_encoder_in_slow_motion_is_half_a_count(feedforward):
    count, gain, tick = 1e-3, 10.0, 0.01
    slow = 1e-4 * count * gain  # rad/s: the axis settles long before the next count
    wanted = slow * tick * np.arange(300_000)
    loop = Loop(gain, tick, count=count, feedforward=feedforward)
    track = follow(Integrator(0.5), loop, wanted, slopes=np.full(len(wanted) - 1, slow))
    assert track.largest_error == pytest.approx(count / 2, rel=0.05)
    # Each tick at the edge of a count is a step of Kv T counts, forth and back.
    step = gain * tick
    square = count**2 / 12 * ((1 - step) ** 2 + step**2)
    assert track.rms_error == pytest.approx(np.sqrt(square), rel=0.05)


@pytest.mark.parametrize(("delay", "passes"), [
    (0, lambda g: g / (2 - g)), (1, lambda g: g * (1 + g) / ((1 - g) * (2 + g))),
])  # fmt: skip
def test_encoder_in_fast_motion_is_white_noise_to_the_loop(delay, passes):
    """What a tick's share of the error passes on of it, and with the answer a tick later."""
    count, tick, share = 1e-3, 0.01, 0.2
    rates = np.linspace(10, 11, 400, endpoint=False) * count / tick
    loop = Loop(share / tick, tick, count=count, delay=delay)
    passed = rounding_passed(Integrator(0.5), loop, rates, np.zeros(400))
    assert passed.mean() == pytest.approx(passes(share) / 12, rel=0.02)


# The extremes of all feeds, resolutions and tiers tried, and some between.
@pytest.mark.parametrize(
    ("tier", "feed", "bits", "ratio"),
    [("T0", 0.03, 16, 1.43), ("T0", 0.06, 12, 1.42), ("T1", 0.03, 14, 1.23), ("T1", 0.06, 14, 1.09),
     ("T1", 0.06, 16, 0.89), ("T1", 0.2, 13, 0.65), ("T2", 0.06, 16, 1.12)],
)  # fmt: skip
def test_encoder_is_off_the_linear_theory_by_half_at_most(tier, feed, bits, ratio):
    count = 2 * np.pi / 2**bits
    lap = job(feed=feed, count=count)
    fault = Case(lap, PLANTS[tier], pair(count=count, **FED)).fault("encoder")
    assert 0.6 < fault.ratio < 1.5
    assert fault.ratio == pytest.approx(ratio, abs=0.06)  # which rounding leads is a chance


@pytest.mark.parametrize("circuit", [CIRCUIT, TILTED], ids=["aligned", "tilted"])
@pytest.mark.parametrize("turn", [-2e-3, 2e-3])
@pytest.mark.parametrize(
    ("shift", "axis"), [("z", "pitch"), ("y", "yaw"), ("y", "roll"), ("z", "roll")]
)
def test_pose_alone_leaves_the_normal_part_of_a_small_rigid_motion(circuit, shift, axis, turn):
    """With either sign: a turn the other way round would leave less or more beside a shift."""
    fault = Case(job(circuit), pose=Pose(**{shift: 2e-3, axis: turn})).fault("pose")
    assert fault.measured == pytest.approx(fault.closed, rel=3e-3)


# Plants that the library doesn't know


class Unspoken(Plant):
    """A lag that can be run but has no linear form to show."""

    lag = Lag(0.5, 0.02)
    command, rest, numbers, functions = lag.command, lag.rest, lag.numbers, lag.functions


def test_a_plant_without_a_linear_form_gets_no_closed_form_and_no_verdict_on_stability():
    plant, loops = [Unspoken()] * 2, pair(**FED)
    for source in ("following", "encoder"):
        fault, same = (Case(LAP, one, loops).fault(source) for one in (plant, PLANTS["T1"]))
        assert fault.closed is None and same.closed > 0
        np.testing.assert_array_equal(fault.deviation, same.deviation)
    for call in (lambda: trailing(LAP, plant, loops), lambda: gain_limit(plant[0], loops[0])):
        with pytest.raises(NoLinearForm, match=r"^plant: must have a linear form, .*Unspoken"):
            call()
    assert follow(plant, pair(count=0.0), LAP.setvalues).stable == (None, None)


# The whole


T0 = Integrator(0.5)
REFUSED = {
    "loop: must be without integral": lambda: budget(LAP, T0, pair(integral=1.0)),
    "plan: must not wait": lambda: budget(LATE, T0, pair()),
    "source: must be one of those .*counts, feed ripple; got": lambda: Case(LAP).fault("pose"),
}


@pytest.mark.parametrize("message", REFUSED)
def test_budget_refuses_what_its_closed_forms_lack(message):
    with pytest.raises(ValueError, match=f"^{message}"):
        REFUSED[message]()


def test_budget_adds_up_to_all_together():
    loops, plant, said = pair(**FED), [Lag(0.5, 0.02)] * 2, []
    faults = budget(LAP, plant, loops, pose=POSE, say=said.append)
    assert [(fault.source, fault.kind) for fault in faults] == [
        ("knots", "chosen"), ("projected chord", "paper"), ("corners", "chosen"),
        ("setpoints", "machine"), ("counts", "machine"), ("feed ripple", "machine"),
        ("following", "machine"), ("encoder", "machine"), ("pose", "chosen"),
    ]  # fmt: skip
    assert said == [f"budget: source {k} of 9" for k in range(1, 10)]
    total = np.zeros(len(LAP.setvalues))
    for fault in (fault for fault in faults if not fault.along):
        total[: len(fault.deviation)] += fault.deviation
    track = follow(plant, loops, LAP.setvalues, slopes=LAP.slopes)
    centre = LAP.centres(track.position, pose=POSE)
    together = -CIRCUIT.profile.depth(centre[:, 1], centre[:, 2])
    assert np.abs(together).max() > 3e-3
    # What is left is the product of knots and following: corners at knots, cut by the lag.
    assert np.abs(total - together).max() < 0.4e-3
    assert np.sqrt(np.mean((total - together) ** 2)) < 0.05e-3


# What halves a fault

ODD = Fault("odd", "machine", np.array([0.0, 2e-3]), None, remedies=(("this", 0.5), ("that", 0.5)))


@pytest.mark.parametrize(
    ("powers", "found", "runs"),
    [
        ({"this": 1.0}, ("this", 0.5, 0.5), 1),
        ({"this": 2.0}, ("this", 0.71, 0.71**2), 2),  # half of it would quarter the fault
        ({"this": 0.4}, ("this", 0.18, 0.18**0.4), 2),
        ({"this": 0.0, "that": 1.0}, ("that", 0.5, 0.5), 2),  # changes nothing
        ({"this": -1.0, "that": 1.0}, ("that", 0.5, 0.5), 2),  # makes it worse
        ({"this": 0.3, "that": 1.0}, ("that", 0.5, 0.5), 2),  # a tenth would be needed
        ({"this": 0.0, "that": 0.0}, None, 2),
    ],
)
def test_a_remedy_is_what_a_run_confirms_and_says_what_is_left(powers, found, runs):
    asked = []

    def again(what, factor):
        asked.append((what, factor))
        return replace(ODD, deviation=ODD.deviation * factor ** powers[what])

    remedy = halving(ODD, again)
    assert len(asked) == runs and (remedy is None) == (found is None)
    if found is not None:
        assert remedy.what == found[0] and remedy[1:] == pytest.approx(found[1:], rel=1e-9)


def test_each_key_that_cut_says_does_to_the_job_what_it_says():
    """By the job with the key changed, planned and run anew."""
    job = job_with(
        read_job(REFERENCE),
        controller={"plant": "T1", "gain": 8.0, "feedforward": 0.5, "encoder": np.radians(0.02)},
        limits={"feed": 0.06}, pose={"y": 1e-3, "roll": np.radians(0.1)},
    )  # fmt: skip

    def case(job):
        return Case(job.planned, *job.axes, job.error, job.arm, job.pushing)

    before = case(job)
    found = [before.fault(source) for source in before.sources]
    said = halved_by(job, found)
    assert sum(key is not None for key, _, _ in said) >= 7
    assert said[before.sources.index("following")][0] == "[controller] gain"
    for fault, (key, factor, left) in zip(found, said, strict=True):
        if key is None:
            assert factor is left is None
            continue
        table, name = re.fullmatch(r"\[(\w+)\] ?(\w*)", key).groups()
        keys = getattr(job, table)
        scaled = {one: factor * keys[one] for one in ([name] if name else keys)}
        after = case(job_with(job, **{table: scaled})).fault(fault.source)
        assert 0.4 <= left <= 0.6
        assert after.measured == pytest.approx(left * fault.measured, rel=1e-3), fault.source


def test_no_key_is_named_that_a_job_lacks():
    job = read_job(REFERENCE)
    assert changed(job, "power", 0.5).limits["power"] == 1.5e3
    assert changed(job, "encoder", 0.5).plan["count"] == job.plan["count"] / 2
    del job.limits["power"], job.plan["step"]
    assert changed(job, "power", 0.5) is None
    assert changed(job, "step", 0.5).plan["step"] == 2.5e-3  # half of what a plan takes unless told
