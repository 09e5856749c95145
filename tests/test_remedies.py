"""What a cut says that halves its faults: each said is done to the job, and halves them."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.job import read_job
from tunneller_lib.job.remedies import changed, halved_by
from tunneller_lib.ream import budget
from tunneller_lib.ream.faults import Fault, following_fault
from tunneller_lib.ream.remedies import halving

READS = ["notebooks/reference.toml"]

REFERENCE = Path(__file__).resolve().parents[1] / "notebooks" / "reference.toml"
ODD = Fault("odd", np.array([0.0, 2e-3]), "largest", None, (("this", 0.5), ("that", 0.5)))


def falling(**powers):
    """Return how a fault of 2 mm goes with powers of what is changed, and what was asked for."""
    asked = []

    def again(what, factor):
        asked.append((what, factor))
        return replace(ODD, deviation=ODD.deviation * factor ** powers[what])

    return again, asked


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
    again, asked = falling(**powers)
    remedy = halving(ODD, again)
    assert len(asked) == runs
    if found is None:
        assert remedy is None
    else:
        assert remedy.what == found[0] and remedy[1:] == pytest.approx(found[1:], rel=1e-9)


def test_a_remedy_that_cannot_be_had_is_none():
    assert halving(ODD, lambda what, factor: None) is None
    still = replace(ODD, deviation=np.zeros(2))
    assert halving(still, lambda what, factor: pytest.fail("asked")) is None


def with_key(text, key, factor):
    """Return the text of a job whose key, as `cut` says it, is multiplied by a factor."""
    table, _, name = key.partition("] ")
    begin = text.index(f"\n{table.rstrip(']')}]")
    end = text.find("\n\n", begin)
    lines = text[begin:end].split("\n")
    for i, line in enumerate(lines):
        own, equals, value = line.partition(" = ")
        if equals and not own.startswith("#") and own in (name, *([own] if not name else [])):
            number = re.match(r"[-+.\de]+", value)[0]
            lines[i] = f"{own} = {factor * float(number)!r}"
    assert lines != text[begin:end].split("\n"), key
    return text[:begin] + "\n".join(lines) + text[end:]


OTHERS = {
    "concrete, T3": {},
    "T1 that stands elsewhere": {
        '"T3"': '"T1"', "gain = 10 ": "gain = 8 ", "feed = 0.1 ": "feed = 0.06 ",
        "# encoder_deg = 0 ": "encoder_deg = 0.02 ", "# [pose]": "[pose]", "# y = 1e-3": "y = 1e-3",
        "# roll_deg = 0.1": "roll_deg = 0.1", "feedforward = 1 ": "feedforward = 0.5 ",
    },
    "mortar, T3, corrected chords": {
        "20e6": "5e6", "# path": "path", "tolerance = 1e-3": "tolerance = 3e-3",
        "gain = 10 ": "gain = 7 ",
    },
    "T2": {'"T3"': '"T2"', "acceleration = 0.5": "acceleration = 0.2",
           "step = 5e-3": "step = 1e-2"},
}  # fmt: skip


@pytest.mark.parametrize("name", OTHERS)
def test_each_key_that_cut_says_does_to_the_job_what_it_says(name, tmp_path):
    """By the job's text with the key changed, read, planned and run anew."""
    text = REFERENCE.read_text()
    for old, new in OTHERS[name].items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)

    def faults(text):
        path = tmp_path / "job.toml"
        path.write_text(text)
        job = read_job(path)
        given = dict(pose=job.error, arm=job.arm, ground=job.pushing)
        return job, budget(job.planned, *job.axes, **given)

    job, found = faults(text)
    said = halved_by(job, found)
    assert sum(key is not None for key, _, _ in said) >= 6
    again = {}
    for number, (fault, (key, factor, left)) in enumerate(zip(found, said, strict=True)):
        if key is None:
            assert factor is left is None
            continue
        if (key, factor) not in again:
            again[key, factor] = faults(with_key(text, key, factor))[1]
        after = again[key, factor][number]
        assert 0.4 <= left <= 0.6 and after.source == fault.source
        assert after.measured == pytest.approx(left * fault.measured, rel=1e-3), fault.source


def test_no_key_is_named_that_a_job_lacks():
    job = read_job(REFERENCE)
    assert changed(job, "power", 0.5).limits["power"] == 1.5e3
    del job.limits["power"]
    assert changed(job, "power", 0.5) is None
    assert changed(job, "encoder", 0.5).plan["count"] == job.plan["count"] / 2
    del job.plan["step"]
    assert changed(job, "step", 0.5).plan["step"] == 2.5e-3  # half of what a plan takes unless told


def test_no_gain_is_named_at_which_a_loop_is_unstable(tmp_path):
    text = REFERENCE.read_text().replace("gain = 10 ", "gain = 16 ")
    (tmp_path / "job.toml").write_text(text)
    job = read_job(tmp_path / "job.toml")
    plants, loops = job.axes
    fault = following_fault(job.planned, plants, loops)
    ((key, factor, _),) = halved_by(job, [replace(fault, remedies=(("gain", 2.0),))])[:1]
    assert key is None or 16 * factor < 24
