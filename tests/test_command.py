"""The command line: jobs that are read, refused and run; what goes where."""

import io
import json
import re
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.controllers import job_with
from tunneller_lib.__main__ import main, tell
from tunneller_lib.job import read_job, results, tables
from tunneller_lib.job.results import summary_text
from tunneller_lib.job.tables import Size
from tunneller_lib.motion import Compressible, Integrator, Lag, Rigid
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Body, Egg, Machine
from tunneller_lib.terminal import fit

READS = ["report/guide/command.md"]

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "tunneller_lib" / "job" / "reference.toml"
# The reference, soon done.
QUICK = {"feed = 0.1 ": "feed = 0.2 ", "step = 5e-3": "step = 1e-2", "rest = 1.0": "rest = 0.2",
         "along = 200": "along = 40", "around = 360": "around = 60", '"T3"': '"T0"'}  # fmt: skip
HORSESHOE = """shape = "pieces"
pieces = [
  {kind = "arc", y = 0, z = 0, radius = 0.5, start = 0, sweep_deg = 180},
  {kind = "line", y = -0.5, z = 0, heading_deg = -90, length = 0.4},
  {kind = "arc", y = -0.25, z = -0.4, radius = 0.25, start_deg = 180, sweep_deg = 90},
  {kind = "line", y = -0.25, z = -0.65, heading = 0, length = 0.5},
  {kind = "arc", y = 0.25, z = -0.4, radius = 0.25, start_deg = -90, sweep_deg = 90},
  {kind = "line", y = 0.5, z = -0.4, heading_deg = 90, length = 0.4},
]"""
EGG = 'shape = "egg"'


def write_job(folder, changes=(), *, quick=True):
    """Write a job like the reference, with some of its text changed, and return its file."""
    text = REFERENCE.read_text()
    if quick:  # T0 feels no ground
        text = re.sub(r"power = 3e3.*?(?=\n# \[hydraulics\])", "", text, flags=re.DOTALL)
    for old, new in ((QUICK if quick else {}) | dict(changes)).items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "job.toml").write_text(text)
    return folder / "job.toml"


@pytest.fixture
def job(tmp_path):
    """Return `write_job` into the test's own folder."""
    return partial(write_job, tmp_path)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """Return the quick job, and its cut."""
    made = read_job(write_job(tmp_path_factory.mktemp("quick")))
    return made, made.simulated()


def run(capsys, *arguments):
    """Return exit code, standard output and standard error of a command."""
    code = main([str(argument) for argument in arguments])
    return code, *capsys.readouterr()


# What a job says


def test_reference_job_is_the_reference_machine():
    job = read_job(REFERENCE)
    assert Machine(**job.machine) == REFERENCE_MACHINE
    plan = job.planned
    assert plan.circuit.section.arcs == Egg(0.5).arcs and plan.count == 2 * np.pi / 2**16
    assert (plan.tick, plan.laps, plan.advance) == (0.005, 1, 0.04)
    plants, loops = job.axes
    assert all(isinstance(plant, Compressible) for plant in plants)
    assert loops[0].gain == 10 and loops[0].count == plan.count and job.error is None


def test_job_takes_the_tiers(job):
    for tier, kind in (("T0", Integrator), ("T1", Lag), ("T2", Rigid)):
        # Without a tick of its own the loop has the usual one.
        made = read_job(job({'"T3"': f'"{tier}"', "tick = 5e-3": "# tick"}, quick=False))
        assert ({*map(type, made.axes[0])}, made.arm, made.axes[1][0].tick) == ({kind}, None, 5e-3)
    # The cutter's full speed of 0.4 m/s at the end of an arm of 0.8 m.
    assert read_job(job()).axes[0][0].gain == 0.5


def test_job_takes_everything_that_the_reference_only_names(job):
    changed = job({"# [stance]": "[stance]", "# pitch_deg = 0": "pitch_deg = 1",
                   "# yaw_deg = 0": "yaw = 0.01", "# volume": "volume", "# flow": "flow",
                   "# valve = 0.8": "valve = 0.8",
                   "# encoder_deg": "encoder", "# [pose]": "[pose]", "# y = 1e-3": "y = 1e-3",
                   "# z = -5e-4": "z = -5e-4",
                   "# roll_deg": "roll_deg"})  # fmt: skip
    made = read_job(changed)
    assert made.planned.circuit.pitch == np.radians(1) and made.planned.circuit.yaw == 0.01
    assert made.planned.limits.volume == 2e-4 and made.planned.limits.flow == 1e-4
    assert made.axes[1][0].count == 0
    assert made.error.y == 1e-3 and made.error.roll == np.radians(0.1)


BODY = {f"# {line}": line for line in (
    "[body]", "length = 1.2", "width = 0.3", "low = -0.25", "high = 0.15", "holder_radius",
    "holder_length")}  # fmt: skip


def test_job_takes_a_body(job):
    assert read_job(REFERENCE).made.body is None
    made = read_job(job(BODY))
    assert made.made == replace(REFERENCE_MACHINE, body=Body(1.2, 0.3, -0.25, 0.15, 0.12, 0.25))
    parts = {part.name: part.least for part in made.planned.clearances}
    assert list(parts) == ["arm", "holder", "box", "cutter"] and parts.pop("cutter") < 0
    assert min(parts.values()) > 0.05


def test_job_takes_pieces_of_a_drawing_s_digits_within_its_snap(job):
    drawn = HORSESHOE.replace("length = 0.4}", "length = 0.400000001}", 1)
    changes = {EGG: drawn, "a = 0.5 ": "#"}
    assert 1e-11 < read_job(job(changes)).planned.circuit.section.slack < 1e-8
    with pytest.raises(ValueError, match=r"^\[section\] pieces: \d of 6 doesn't begin where the"):
        read_job(job(changes | {"a = 0.5 ": "snap = 1e-12 #"})).planned  # noqa: B018


# Each job is asked for by the command: the exit code, and the sentence that is told.
WRONG = [
    # what can't be read
    ({"r = 0.08": "r : 0.08"}, 2, r"isn't TOML; Expected '=' after a key.*line 8"),
    ({"phi_max_deg": "phi_max_dge"}, 2, r"_dge: isn't known; 'phi_max_deg' is meant, perhaps\.$"),
    ({"phi_max_deg = 40": "phi_max_deg = 40\nphi_max = 0.7"}, 2,
     r"^\[machine\] phi_max: is given in radians and in degrees\.$"),
    ({"theta_min_deg = -60": ""}, 2, r"theta_min: is missing \(rad, or theta_min_deg\)\.$"),
    ({EGG: 'shape = "pieces"', "a = 0.5 ": 'pieces = [{kind = "line", y = 0}]\n#'}, 2,
     r"^\[section\.pieces 1\] z: is missing \(m\)\.$"),
    ({"[wall]": "[walls]"}, 2, r"^\[walls\]: is no table of a job; 'wall' is meant, perhaps\.$"),
    # values of another kind or unit
    ({"feed = 0.2 ": 'feed = "0.2 m/s" '}, 1, r"feed: must be a number in m/s; got '0\.2 m/s'\.$"),
    ({"laps = 1": "laps = 1.5"}, 1, r"^\[plan\] laps: must be a whole number; got 1\.5\.$"),
    ({'"T0"': '"T9"'}, 1, r'^\[controller\] plant: must be "T0", "T1", "T2" or "T3"; got \'T9\''),
    ({"theta_min_deg = -60": "theta_min = -60"}, 1,
     r"must be at most 3\.2 rad in size; got -60\. In degrees its name ends in _deg\.$"),
    ({"tolerance = 1e-3 ": "tolerance = 1e-7 "}, 1,
     r"at least the 8\.4e-05 m that a count moves the cutter; got 1e-07 m with "),
    # that can't be
    ({"height = -0.36": "height = -0.9"}, 1,
     r" \[machine\] height: may be from -0\.\d+ to -?0\.\d+ m"),
    ({EGG: 'shape = "pieces"', "a = 0.5 ":
      'pieces = [{kind = "line", y = 0, z = 0, heading = 0, length = 1}]\n#'}, 1,
     r"^\[section\] pieces: 1 of 1 isn't met: it isn't closed; the gap is 1 m\.$"),
    ({"along = 40": "along = 2001", "around = 60": "around = 2000"}, 1,
     r"^\[wall\] along, around: must be at most 4000000 rays together; got 2001 x 2000\.$"),
    ({"# [hydraulics]": "", "# volume = 2e-4": "power = 3e3"}, 1, r"\] power: needs a table"),
]  # fmt: skip


BOX = """shape = "pieces"
pieces = [
  {kind = "line", y = -0.4, z = -0.8, heading = 0, length = 0.8},
  {kind = "line", y = 0.4, z = -0.8, heading_deg = 90, length = 1},
  {kind = "line", y = 0.4, z = 0.2, heading_deg = 180, length = 0.8},
  {kind = "line", y = -0.4, z = 0.2, heading_deg = -90, length = 1},
]"""
ONE_ARC = 'shape = "pieces"\npieces = [{kind = "arc", y = 0, z = 0, radius = %s, start = 0, %s}]'
# Ranges that a value must keep, none of which has a unit "1".
RANGES = [
    ({"depth = 0.02": "depth = 0"}, "[machine] depth: must be from 0.0001 to 1 m, or no ground "),
    ({"feedforward = 1": "feedforward = 100"}, "] feedforward: must be from 0 to 2; got 100."),
    ({"# valve = 0.8 ": "valve = 1.5 "}, "[limits] valve: must be from 0.001 to 1; got 1.5."),
    ({"gain = 10": "gain = 0"}, "[controller] gain: must be from 0.01 to 10000 1/s; got 0."),
    ({"rest = 0.2": "rest = -1"}, "[plan] rest: must be from 0 to 60 s; got -1."),
    ({"advance = 0.04": "advance = -0.04"}, "[plan] advance: must be from 0 to 2 m; got -0.04."),
    ({"delay = 1 ": "delay = -1 "}, "delay: must be one whole number from 0 to 100; got -1."),
    ({"# trip = 5e-3": "trip = 0"}, "[controller] trip: must be from 1e-05 to 1 m; got 0."),
    ({"# encoder_deg = 0": "encoder_deg = -1"}, "encoder_deg: must be 0 or from "),
    ({EGG: ONE_ARC % (0.5, "sweep_deg = -360"), "a = 0.5 ": "#"},
     "sweep_deg: must be from 0.001 to 360 degrees, since pieces run counter-clockwise"),
    ({EGG: ONE_ARC % (-0.5, "sweep_deg = 360"), "a = 0.5 ": "#"},
     "[section.pieces 1] radius: must be from 0.001 to 100 m; got -0.5."),
    ({EGG: BOX, "a = 0.5 ": "#"}, "each bend must be wider than 0.18 m, the cutter_radius less the "
     "depth; got a corner; an arc of 0.19 m in its place would do."),
    ({EGG: ONE_ARC % (0.15, "sweep_deg = 360"), "a = 0.5 ": "#"}, "got a bend of 0.15 m; an arc"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), RANGES)
def test_value_out_of_its_range_is_told_the_range(job, changes, sentence):
    with pytest.raises(ValueError) as refused:
        read_job(job(changes)).checked  # noqa: B018
    assert sentence in str(refused.value)


# Jobs whose refusal names another value: by the words that say the cause, and the tables that hold
# the value instead. The plant is T0 unless they say another.
MENDED = [
    # A valve is fully open.
    ({"limits": {"feed": 1.0}}, "theta's valve is fully open for", {"limits": {"feed": 0.34}}),
    ({"limits": {"feed": 1.0}, "controller": {"plant": "T1"}}, "valve is fully open",
     {"limits": {"feed": 0.34}}),
    ({"limits": {"feed": 1.0}, "controller": {"plant": "T2"}}, "valve is fully open",
     {"limits": {"valve": 0.8}}),
    ({"limits": {"feed": 1.0}, "controller": {"plant": "T3"}}, "valve is fully open",
     {"limits": {"valve": 0.8}}),
    ({"hydraulics": {"valve_leak": 1e-10}, "controller": {"plant": "T3"}}, "lics] valve_leak",
     {"hydraulics": {"valve_leak": 1e-13}}),
    # A loop is unstable.
    ({"controller": {"gain": 1000}}, "gain: must be below the 200 1/s from which theta's",
     {"controller": {"gain": 100}}),
    ({"controller": {"plant": "T3", "gain": 60}}, "tick and delay; got 60 1/s, 12 1/s",
     {"controller": {"gain": 12}}),
    # A wall doesn't show the cut, or hold it.
    ({"plan": {"laps": 100, "advance": 0.3}}, "[wall] along: rays along the tunnel must be at most",
     {"wall": {"along": 697}}),
    ({"plan": {"laps": 3}, "wall": {"along": 10}}, "got 10 on 0.759 m", {"wall": {"along": 19}}),
    ({"wall": {"around": 3}}, "[wall] around: rays round it", {"wall": {"around": 46}}),
    ({"wall": {"thickness": 0.01}}, "[wall] thickness: must be at least",
     {"wall": {"thickness": 0.055}}),
    # A plan that no machine would run.
    ({"plan": {"laps": 2, "advance": 0.0}}, "all cut the same groove; got 0 m",
     {"plan": {"advance": 0.04}}),
    ({"plan": {"tolerance": 0.1}}, "[plan] tolerance: in air the cutter is up to",
     {"plan": {"tolerance": 0.002}}),
    ({"plan": {"laps": 5000}}, "laps: must take at most 5000000 ticks", {}),
    ({"plan": {"arm_radius": 0.1800001}}, "an arm of 0.18 m is 1e-07 m in the wall at the begin",
     {"plan": {"arm_radius": 0.17}}),
    # Joint limits.
    ({"controller": {"plant": "T3"},
      "machine": {"theta_min": np.radians(-70), "theta_max": np.radians(60)}},
     "[machine] theta_min, theta_max: the lift can't serve these limits; stroke: 0.202 m",
     {"machine": {"theta_min": np.radians(-55), "theta_max": np.radians(38)}}),
    ({"controller": {"plant": "T3"},
      "machine": {"theta_min": np.radians(-70), "theta_max": np.radians(60)}},
     "[hydraulics] lift_dead_length = 0.141", {"hydraulics": {"lift_dead_length": 0.141}}),
    ({"controller": {"plant": "T3"}, "machine": {"phi_max": np.radians(50)}},
     "phi_min_deg = -40 with phi_max_deg = 40", {"machine": {"phi_max": np.radians(40)}}),
    ({"machine": {"theta_min": np.radians(-20)}}, "theta_min_deg = -51 would do",
     {"machine": {"theta_min": np.radians(-51)}}),
    # Cylinders.
    ({"controller": {"plant": "T3"}, "hydraulics": {"supply": 1e6}}, "the usual 1.6e+07 Pa",
     {"hydraulics": {"supply": 1.6e7}}),
    ({"controller": {"plant": "T2"}, "hydraulics": {"swing_arm_pivot": 0.3}}, "the usual 0.07 m",
     {"hydraulics": {"swing_arm_pivot": 0.07}}),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence", "mended"), MENDED)
def test_value_that_a_refusal_names_passes_the_whole_check(job, changes, sentence, mended):
    wrong = job_with(read_job(job()), **changes)
    with pytest.raises(ValueError) as refused:
        wrong.checked  # noqa: B018
    said = str(refused.value)
    assert sentence in said and said.endswith("would do.")
    for keys in mended.values():
        for key, value in keys.items():
            angle = key.startswith(("theta", "phi"))
            assert f"{np.degrees(value):.0f}" in said if angle else f" {value:g}" in said
    if mended:
        assert isinstance(job_with(wrong, **mended).checked, list)


@pytest.mark.parametrize(("changes", "key", "value"), [
    ({"controller": {"feedforward": 0.5}}, "[controller] trip", {"controller": {"trip": 0.018}}),
    ({"controller": {"feedforward": 0.0, "gain": 4.0}}, "[controller] feedforward",
     {"controller": {"feedforward": 1.0}}),
    ({"controller": {"operations": 1e3}}, "[controller] operations", {}),
    ({"controller": {"encoder": 0.017}}, "[controller] trip", {"controller": {"trip": 0.012}}),
])  # fmt: skip
def test_what_only_the_controller_cannot_keep_costs_only_its_files(job, changes, key, value):
    made = job_with(read_job(job()), **changes)
    (left_out,) = made.checked
    assert left_out.startswith(f"the controller's files are left out; {key}: ")
    assert left_out.endswith("would do.") and made.exported.program is None
    if value:
        assert job_with(made, **value).checked == []


def test_cut_without_a_controller_writes_all_else_and_warns_as_its_dry_run(capsys, job, tmp_path):
    path = job({"feedforward = 1": "feedforward = 0", "gain = 10": "gain = 5"})
    dry = json.loads(run(capsys, "cut", path, "--dry-run", "--json")[1])
    code, said, told = run(capsys, "cut", path, "--out", tmp_path / "cut", "--json")
    (sentence,) = dry["warnings"]
    assert code == 0 and sentence in json.loads(said)["warnings"]
    assert f"warning: {sentence}\n" in told
    of_the_controller = {
        name for name in FILES if name.startswith(("controller", "blocks", "line"))
    }
    assert {one.name for one in (tmp_path / "cut").iterdir()} == FILES - of_the_controller


@pytest.mark.parametrize("changes", [
    {"limits": {"power": 30.0}}, {"controller": {"encoder": 0.017}},
    {"hydraulics": {"piston_leak": 1e-8, "valve_leak": 1e-10}},
])  # fmt: skip
def test_the_ends_of_ranges_have_a_plan(changes):
    assert job_with(read_job(REFERENCE), **changes).planned.lap_time > 0


@pytest.mark.parametrize(("changes", "code", "sentence"), WRONG)
def test_wrong_job_is_told_in_a_sentence(capsys, job, changes, code, sentence):
    ended, said, told = run(capsys, "cut", job(changes), "--dry-run", "--json")
    ((how, why),) = json.loads(said).items()
    assert (ended, how) == (code, ("refused", "wrong")[code - 1])
    assert told.splitlines()[-1] == f"{how}: {why}"
    assert re.search(sentence, why) and why.endswith(".") and not why.endswith("..")


ODD_FILES = [
    (b"a = " + b"[" * 3000, "bytes.toml: isn't TOML; "),
    (b"# a\n" * 25_001, "is larger than a job may be, 100000 bytes."),
    (b'["a\\u001b[31mb"]', r"[a\x1b[31mb]: is no table of a job; known are machine, "),
    (b"machine = " + b"[" * 90 + b"]" * 90, "machine: must be a table, [machine]; got [[[[[[[...]"),
    (b"\xff\xfe", "bytes.toml: isn't TOML; 'utf-8' codec can't decode"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "sentence"), ODD_FILES)
def test_file_that_nobody_would_write_is_told_in_a_short_sentence(tmp_path, content, sentence):
    (tmp_path / "bytes.toml").write_bytes(content)
    with pytest.raises(ValueError) as wrong:
        read_job(tmp_path / "bytes.toml")
    told = str(wrong.value)
    assert sentence in told and told.isprintable() and len(told) < 600


# What is run

FILES = {"budget.csv", "plan.csv", "knots.csv", "setpoints.csv", "setvalues.csv", "line.st",
         "line.c",
         "controller.c", "controller.h", "controller.st", "blocks.st", "controller.xml",
         "section.dxf", "wall.stl", "wall.png", "laps.png", "manifest.txt"}  # fmt: skip


def test_cut_answers_in_json_and_writes_its_files(capsys, job, tmp_path):
    out = tmp_path / "cut"
    asked = job({"# [pose]": "[pose]", "# y = 1e-3": "y = 1e-3"})
    code, said, told = run(capsys, "cut", asked, "--out", out, "--json")
    answer = json.loads(said)
    guide = (ROOT / "report/guide/command.md").read_text(encoding="utf-8")
    guide = guide.partition("## What `--json`")[2]
    assert code == 0 and all(f"`{name}`" in guide for name in answer)
    assert all(0 <= share <= 1 for share in answer["limits_used"].values())
    assert answer["times_s"]["all"] > answer["lap_time_s"] > answer["times_s"]["straight"]
    sources = ["knots", "projected chord", "corners", "setpoints", "counts", "feed ripple",
               "following", "encoder", "pose"]  # fmt: skip
    assert [fault["source"] for fault in answer["faults"]] == sources
    assert all(0 <= fault["rms_m"] < 0.01 for fault in answer["faults"])
    assert answer["faults"][-1]["closed_m"] == pytest.approx(1e-3, rel=0.01)
    assert {Path(name).name for name in answer["files"]} == FILES == {p.name for p in out.iterdir()}
    for step in ("planning ...", "planned: ", "simulating 1 x", "cutting: lap 1 of 1",
                 "budget: source 9 of 9", "writing "):  # fmt: skip
        assert step in told
    assert answer["warnings"] == []
    # T0 has no cylinder.
    assert [row["what"] for row in answer["machine"]] == ["valve of theta", "valve of phi"]
    arm, cutter = answer["clearances"]
    assert arm == {"part": "arm", "clearance_m": pytest.approx(0.08), "at_m": 0.0}
    assert cutter["clearance_m"] == pytest.approx(-0.02)
    assert "\nFUNCTION_BLOCK" in (out / "line.st").read_text()
    assert (out / "budget.csv").read_text().count("\n") == 10


def test_dry_run_answers_with_the_plan_alone(capsys, job, tmp_path):
    path = job()
    code, said, told = run(capsys, "cut", path, "--dry-run", "--json")
    answer = json.loads(said)
    assert code == 0 and "simulating" not in told and list(tmp_path.iterdir()) == [path]
    assert answer["files"] == [] and answer["knots"] > 30 and "faults" not in answer
    code, said, _ = run(capsys, "cut", path, "--dry-run")
    assert code == 0 and said.startswith(f"{answer['knots']} knots, ")
    assert "clear of the wall, in mm: arm 80.0; the cutter reaches 20.0 into it\n" in said


def test_example_is_a_job_that_is_read_from_standard_input(capsys, monkeypatch):
    code, said, _ = run(capsys, "example")
    assert code == 0 and said == REFERENCE.read_text(encoding="utf-8")
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(said.encode())))
    made = read_job("-")
    assert made == read_job(REFERENCE) and ", job stdin, " in made.stamp


def test_cut_has_a_row_and_a_line_for_a_first_lap_and_for_one_beside_another(job):
    """In air both leave the same, but for how the joints settle; the second removes a strip."""
    made = read_job(job({"laps = 1": "laps = 3"}))
    cut = made.simulated()
    numbers = results.summarise(made, cut)
    assert numbers["underbreak_m"] == max(0, -cut.deviation.min())
    first, last = numbers["each_lap"]
    assert (first["lap"], last["lap"], numbers["setpoints"]) == (1, 3, len(made.planned.s) - 1)
    assert last["removed_m3"] < 0.6 * first["removed_m3"]
    third = cut.deviation[2 * int(made.planned.ticks.sum()) :]
    assert last["over_m"] == max(0, third.max()) and last["under_m"] == max(0, -third.min())
    assert "\nlap 3, beside another: overbreak " in summary_text(numbers)


def test_overshoot_where_the_cutter_enters_counts(quick):
    made, cut = quick
    outward = made.planned.circuit.profile.normal(0.0)
    beyond = cut.before[-1:] + 5e-3 * np.array([0.0, *outward])
    numbers = results.summarise(made, replace(cut, before=np.concatenate([cut.before, beyond])))
    assert numbers["overbreak_m"] == pytest.approx(5e-3, rel=0.05)
    assert any(line.startswith("the overbreak of 5") for line in numbers["warnings"])


def test_cut_looks_at_its_folder_before_it_simulates(capsys, job, tmp_path):
    (tmp_path / "file").touch()
    code, said, told = run(capsys, "cut", job(), "--out", tmp_path / "file" / "cut", "--json")
    assert code == 2 and str(tmp_path / "file") in json.loads(said)["wrong"]
    assert "planning" not in told


@pytest.mark.parametrize("file", ["...toml", "tunnel.v2.toml"])
def test_job_writes_into_a_folder_of_its_own_under_build(job, tmp_path, monkeypatch, file):
    job().rename(tmp_path / file)
    monkeypatch.setattr("tunneller_lib.atomic_write.output", lambda path: asked.append(path))
    asked = []
    with pytest.raises(TypeError):  # with None instead of a folder to write into
        main(["cut", str(tmp_path / file)])
    assert asked[0].parent == Path("build") and asked[0].name in ("toml", "job", "tunnel.v2")


def test_litres_of_a_cut_are_those_that_its_ground_has_lost(quick):
    made, cut = quick
    lines = cut.wall.lines
    begins = made.planned.circuit.section.ray(np.arctan2(lines.sin, lines.cos))
    lost = DexelGrid(lines, begins, cut.wall.high.max(axis=0)).volume - cut.wall.volume
    assert results.summarise(made, cut)["removed_m3"] == pytest.approx(lost, rel=1e-9)
    assert cut.plunged > 0.003 * cut.removed.sum() > 0


def test_cut_tells_people_in_millimetres(capsys, job, tmp_path):
    code, said, _ = run(capsys, "cut", job(), "--out", tmp_path / "cut")
    lines = said.splitlines()
    assert code == 0 and "setpoints" in lines[0] and lines[1].startswith("1 x ")
    table = next(i for i, line in enumerate(lines) if line.startswith("each alone")) + 1
    knots = lines[table].split()
    assert "limits used: feed 100 %, acceleration 100 %" in lines
    assert "time with a valve fully open: theta 0 %, phi 0 %" in lines
    assert any(line.startswith("lap 1, in whole ground: overbreak 0.") for line in lines)
    assert knots[0] == "knots" and knots[5:11] == "largest 1.00 [plan] tolerance x 0.50".split()
    assert 0.4 <= float(knots[11]) <= 0.6 and knots[12:] == ["your", "choice"]
    assert float(knots[1]) < float(knots[2]) < 1  # chords keep inside


def test_command_names_the_package_that_it_lacks():
    code = f"import sys; sys.modules['numpy'] = None; sys.path.insert(0, {str(ROOT)!r}); "
    code += "from tunneller_lib.__main__ import main; sys.exit(main())"
    helped, done = (
        subprocess.run([sys.executable, "-c", code, *asked], text=True, capture_output=True)
        for asked in (["--help"], ["cut", str(REFERENCE), "--json"])
    )
    assert helped.returncode == 0
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert done.stderr.startswith('wrong: the package numpy is missing; pip install "." in')
    assert json.loads(done.stdout)["wrong"] + "\n" == done.stderr.removeprefix("wrong: ")


@pytest.mark.parametrize(("error", "code", "answer"), [
    (KeyboardInterrupt(), 130, {"interrupted": True}),
    (MemoryError(), 1, {"refused": "the job needs more memory than there is."}),
    (PermissionError(13, "Permission denied", "cut"), 2, {"wrong": "cut: Permission denied."}),
])  # fmt: skip
def test_command_that_is_stopped_answers_in_json(capsys, monkeypatch, error, code, answer):
    def stop(*_):
        raise error

    monkeypatch.setattr("tunneller_lib.job.read_job", stop)
    ended, said, told = run(capsys, "cut", REFERENCE, "--json")
    assert ended == code and json.loads(said) == answer
    assert told.count("\n") == 1 and told.startswith(next(iter(answer)))


def test_answer_is_json_where_a_number_is_not_finite(capsys):
    tell({"has": np.inf, "rows": [{"needs": -np.inf, "x": 1.5}, (np.nan, 2)], "n": 3, "s": "a"})
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {
        "has": None, "rows": [{"needs": None, "x": 1.5}, [None, 2]], "n": 3, "s": "a"
    }  # fmt: skip


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has /dev/full")
def test_an_answer_that_finds_no_room_is_told():
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-m", "tunneller_lib", "example"], cwd=ROOT,
                              text=True, stdout=full, stderr=subprocess.PIPE)  # fmt: skip
    assert done.returncode == 2 and done.stderr == "wrong: No space left on device.\n"


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="Linux has /dev/zero")
def test_endless_file_is_refused_before_it_is_read(capsys):
    assert run(capsys, "cut", "/dev/zero")[0] == 2


def test_limits_of_plausible_sizes_pass_and_what_is_next_to_them_is_refused():
    sizes = {"power": Size("W", 20.0, 1e7), "turn": Size("rad", most=3.2, signed=True),
             "encoder": Size("rad", 1e-9, 0.1, zero=True)}  # fmt: skip
    for value in (20, 20.0, 1e7):
        tables.read_table("limits", {"power": value}, sizes)
    wrong = np.nextafter(20, 0), np.nextafter(1e7, 1e8), 5e-324, 1e300, 10**300, 0, -20.0
    for value in (*wrong, np.inf, np.nan):
        with pytest.raises(ValueError, match=r"\] power: must be from 20 to 1e\+07 W; got"):
            tables.read_table("limits", {"power": value}, sizes)
    tables.read_table("limits", {"encoder": 0}, sizes)
    with pytest.raises(ValueError, match=r"\] encoder: must be 0 or from 1e-09 to 0.1 rad; got -0"):
        tables.read_table("limits", {"encoder": -1e-3}, sizes)
    for value in (3.2, -3.2):
        tables.read_table("limits", {"turn": value}, sizes)
        with pytest.raises(ValueError, match=r"turn: must be at most 3\.2 rad"):
            tables.read_table("limits", {"turn": 1.01 * value}, sizes)
    assert tables.read_table("limits", {"turn_deg": 90}, sizes) == {"turn": np.pi / 2}


# Lines that no terminal obeys.

OBEYED = "a\x1b[2Jb\r\x07\n\x85\u202ec"  # clears, returns, rings, turns the writing's direction


@given(st.text(st.characters()), st.integers(10, 60))
def test_any_text_becomes_one_printable_line_of_bounded_length(text, most):
    line = fit(text, most)
    assert line.isprintable() and len(line) <= most
    if text.isprintable() and len(text) <= most:
        assert line == text


@pytest.mark.parametrize("arguments", [("cut", f"{OBEYED}.toml"), (OBEYED,)])
def test_a_name_that_a_terminal_would_obey_is_spelled_out(capsys, arguments):
    try:
        code = main([str(one) for one in arguments])
    except SystemExit as end:  # of wrong usage
        code = end.code
    said, told = capsys.readouterr()
    assert code == 2 and said == ""
    assert all(line.isprintable() for line in told.split("\n"))
    assert "\\x1b[2J" in told and len(told) < 1200
