"""The command line: jobs that are read, refused and run; what goes where."""

import gc
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kit import figure
from tunneller_lib.__main__ import main, missing, own_name, parser
from tunneller_lib.job import WrongJob, read_job, results, wall_plot
from tunneller_lib.job.atomic_write import check_writable
from tunneller_lib.job.csv_tables import read_csv
from tunneller_lib.job.results import summary_text
from tunneller_lib.motion import Compressible, Integrator, Lag, Rigid
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Body, Egg, Machine

READS = ["notebooks/reference.toml"]

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "notebooks" / "reference.toml"
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


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch, tmp_path):
    """Let what a command writes by default be of the test, and leave a visitor's build/ alone."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def job(tmp_path):
    """Return a function that writes a job like the reference, with some of its text changed."""

    def write(changes=None, *, quick=True):
        text = REFERENCE.read_text()
        if quick:  # T0 feels no ground
            text = re.sub(r"power = 3e3.*?(?=\n# \[hydraulics\])", "", text, flags=re.DOTALL)
        for old, new in ((QUICK if quick else {}) | (changes or {})).items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path = tmp_path / "job.toml"
        path.write_text(text)
        return path

    return write


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


def test_job_without_a_wall_takes_the_usual_rays(job):
    made = read_job(job({"[wall]": "[stance]", "along = 40": "", "around = 60": "",
                         "thickness = 0.1": ""}))  # fmt: skip
    assert made.wall == {"along": 200, "around": 360} and made.limit == 1.5e-3


def test_job_takes_the_tiers(job):
    for tier, kind in (("T0", Integrator), ("T1", Lag), ("T2", Rigid)):
        plants, _ = read_job(job({'"T3"': f'"{tier}"'}, quick=False)).axes
        assert all(isinstance(plant, kind) for plant in plants)
    assert plants[0].axis.valve_lag == 0.004


def test_job_takes_everything_that_the_reference_only_names(job):
    changed = job({"# [stance]": "[stance]", "# pitch_deg = 0": "pitch_deg = 1",
                   "# yaw_deg = 0": "yaw = 0.01", "# volume": "volume", "# flow": "flow",
                   "# valve = 0.8": "valve = 0.8", "# integral = 0": "integral = 1",
                   "# encoder_deg": "encoder", "# [pose]": "[pose]", "# y = 1e-3": "y = 1e-3",
                   "# z = -5e-4": "z = -5e-4",
                   "# roll_deg": "roll_deg"})  # fmt: skip
    made = read_job(changed)
    assert made.planned.circuit.pitch == np.radians(1) and made.planned.circuit.yaw == 0.01
    assert made.planned.limits.volume == 2e-4 and made.planned.limits.flow == 1e-4
    assert made.axes[1][0].integral == 1 and made.axes[1][0].count == 0
    assert made.error.y == 1e-3 and made.error.roll == np.radians(0.1)


SIZES = (
    "length = 1.2",
    "width = 0.3",
    "low = -0.25",
    "high = 0.15",
    "holder_radius",
    "holder_length",
)
BODY = {f"# {line}": line for line in ("[body]", *SIZES)}


def test_job_takes_a_body(job):
    assert read_job(REFERENCE).made.body is None
    made = read_job(job(BODY))
    assert made.made == replace(REFERENCE_MACHINE, body=Body(1.2, 0.3, -0.25, 0.15, 0.12, 0.25))
    parts = {part.name: part.least for part in made.planned.clearances}
    assert list(parts) == ["arm", "holder", "box", "cutter"] and parts.pop("cutter") < 0
    assert min(parts.values()) > 0.05


def test_job_warns_of_a_body_that_only_its_pose_moves_into_the_wall(job):
    about = {"# width = 0.3": "width = 0.74", "# [pose]": "[pose]", "# y = 1e-3": "y = 2e-2"}
    made = read_job(job(BODY | about))
    assert 0 < made.planned.clearances[2].least < 0.01
    (warning,) = results._colliding(made)
    assert re.fullmatch(
        r"the machine's box is 0\.0\d\d m in the wall, where it stands by \[pose\]\.", warning
    )
    assert results._colliding(read_job(job(BODY))) == []


def test_job_takes_pieces_and_circles(job):
    pieces = read_job(job({EGG: HORSESHOE, "a = 0.5 ": "# a"}))
    assert len(pieces.planned.circuit.section.arcs) == 6
    circle = read_job(job({EGG: 'shape = "circle"', "a = 0.5 ": "radius = 0.5"}))
    assert circle.planned.circuit.section.perimeter == pytest.approx(np.pi)


def test_job_takes_pieces_of_a_drawing_s_digits(job):
    """A mouth profile to nine decimals, whose pieces miss each other by half a nanometre."""
    down = np.arctan2(0.875, 0.3)
    arcs = [
        (0, 0, 0.5, 0, np.pi),
        (-0.3, 0, 0.2, np.pi, down),
        (0, 0.875, 1.125, np.pi + down, np.pi - 2 * down),
        (0.3, 0, 0.2, -down, down),
    ]
    names = "y", "z", "radius", "start", "sweep"
    rows = [", ".join(f"{name} = {value:.9f}" for name, value in zip(names, arc, strict=True))
            for arc in arcs]  # fmt: skip
    pieces = ", ".join(f'{{kind = "arc", {row}}}' for row in rows)
    changes = {EGG: 'shape = "pieces"', "a = 0.5 ": f"pieces = [{pieces}] #",
               "height = -0.36": "height = 0"}  # fmt: skip
    section = read_job(job(changes)).planned.circuit.section
    assert 1e-11 < section.slack < 1e-8
    changes["a = 0.5 "] = f"pieces = [{pieces}]\nsnap = 1e-12 #"
    with pytest.raises(
        ValueError, match=r"^\[section\] pieces: \d of 4 doesn't begin where the last"
    ):
        read_job(job(changes)).planned  # noqa: B018
    with pytest.raises(WrongJob, match=r"^\[section\] snap: isn't known; known are a"):
        read_job(job({"a = 0.5 ": "a = 0.5\nsnap = 1e-6 #"}))


WRONG = [
    ({"r = 0.08": "r : 0.08"}, r"job\.toml: isn't TOML; Expected '=' after a key.*line 8"),
    ({"r = 0.08": "q = 0.08"}, r"^\[machine\] q: isn't known; known are r, R, theta_min"),
    ({"cutter_radius": "cutter_radios"}, r"cutter_radios: isn't known; 'cutter_radius' is meant"),
    ({"phi_max_deg": "phi_max_dge"}, r"phi_max_dge: isn't known; 'phi_max_deg' is meant, "),
    ({"depth = 0.02": "depth_deg = 1"}, r"^\[machine\] depth_deg: isn't known; 'depth' is meant"),
    ({"phi_max_deg = 40": "phi_max_deg = 40\nphi_max = 0.7"},
     r"^\[machine\] phi_max: is given in radians and in degrees\.$"),
    ({"height = -0.36": ""}, r"^\[machine\] height: is missing \(m\)\.$"),
    ({"theta_min_deg = -60": ""}, r"^\[machine\] theta_min: is missing \(rad, or theta_min_deg\)"),
    ({EGG: 'shape = "circle"'}, r"^\[section\] a: isn't known; known are radius\.$"),
    ({EGG: 'shape = "pieces"', "a = 0.5 ": "#"}, r"pieces: must be a list of tables"),
    ({EGG: 'shape = "pieces"', "a = 0.5 ": 'pieces = [{kind = "line", y = 0}]\n#'},
     r"^\[section\.pieces 1\] z: is missing \(m\)\.$"),
    ({"feed = 0.2 ": "jerk = 5\nfeed = 0.2 "},
     r"^\[limits\] jerk: isn't known; known are feed, acceleration, volume, flow, valve, power\.$"),
    ({"[wall]": "[walls]"}, r"^\[walls\]: is no table of a job; 'wall' is meant, perhaps\.$"),
    ({"[limits]": "[[limits]]"}, r"^limits: must be a table, \[limits\]; got \["),
    ({"[controller]": "[pose]"}, r"^\[controller\]: is missing\.$"),
]  # fmt: skip
WRONG_KINDS = [
    ({"feed = 0.2 ": 'feed = "0.2 m/s" '},
     r"^\[limits\] feed: must be a number in m/s; got '0\.2 m/s'\.$"),
    ({"theta_max_deg = 35": "theta_max_deg = true"},
     r"^\[machine\] theta_max_deg: must be a number in degrees; got True\.$"),
    ({"laps = 1": "laps = 1.5"}, r"^\[plan\] laps: must be a whole number; got 1\.5\.$"),
    ({"feedforward = 1 ": "feedforward = [1] "}, r"feedforward: must be a plain number; got \[1\]"),
    ({'"T0"': '"T9"'}, r'^\[controller\] plant: must be "T0", "T1", "T2" or "T3"; got \'T9\'\.$'),
    ({'"T0"': "0"}, r"^\[controller\] plant: must be a text; got 0\.$"),
    ({EGG: 'shape = "oval"'}, r'shape: must be "egg", "circle" or "pieces"; got \'oval\'\.$'),
    ({EGG: 'shape = "pieces"', "a = 0.5 ": 'pieces = [{kind = "spline"}]\n#'},
     r'^\[section\.pieces 1\] kind: must be "arc" or "line"; got \'spline\'\.$'),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), WRONG)
def test_job_that_cannot_be_read_is_told_in_a_sentence(job, changes, sentence):
    with pytest.raises(WrongJob, match=sentence):
        read_job(job(changes))


@pytest.mark.parametrize(("changes", "sentence"), WRONG_KINDS)
def test_value_of_the_wrong_kind_is_refused_in_a_sentence(job, changes, sentence):
    with pytest.raises(ValueError, match=sentence) as refused:
        read_job(job(changes))
    assert not isinstance(refused.value, WrongJob)


ODD_FILES = [
    (b"a = " + b"[" * 3000, "is nested too deeply for a job."),
    (b"a = 1" + b"0" * 3990, "a: must be a number of at most 64 bits."),
    (b"a = 1" + b"0" * 200 + b"_0" * 3000, "has a line of more than 4000 characters."),
    (b"# " + b"a" * 4000, "has a line of more than 4000 characters."),
    (b"# a\n" * 25_001, "is larger than a job may be, 100000 bytes."),
    (b"[machine]\nr = 0x" + b"f" * 3900, "machine.r: must be a number of at most 64 bits."),
    (b"[machine]\nr = 18446744073709551616", "machine.r: must be a number of at most 64 bits."),
    (b"[wall]\nalong = -9223372036854775809", "wall.along: must be a number of at most 64 bits."),
    (b"[section]\npieces = [{y = 1e3}, {y = 99999999999999999999}]",
     "section.pieces.y: must be a number of at most 64 bits."),
    (b'["a\\u001b[31mb"]', r"a\x1b[31mb: must be a name of printable characters."),
    (b'[machine]\n"r\\n" = 1', r"r\n: must be a name of printable characters."),
    (b'[section]\nshape = "\\u202egge"', "section.shape: must be a text of printable characters; "),
    (b'[controller]\nplant = "T0\\u0007"', "controller.plant: must be a text of printable "),
    (b".".join([b"a"] * 90) + b" = 1", "[a]: is no table of a job; known are machine, "),
    (b'["' + b"a" * 3000 + b'"]', "[" + "a" * 99 + "..." + "a" * 98 + "]: is no table of a job;"),
    (b"machine = " + b"[" * 90 + b"]" * 90, "machine: must be a table, [machine]; got [[[[[[[...]"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "sentence"), ODD_FILES)
def test_file_that_nobody_would_write_is_told_in_a_short_sentence(tmp_path, content, sentence):
    (tmp_path / "job.toml").write_bytes(content)
    with pytest.raises(ValueError) as wrong:
        read_job(tmp_path / "job.toml")
    told = str(wrong.value)
    assert sentence in told and told.isprintable() and len(told) < 600


def test_file_whose_name_a_terminal_would_obey_is_told_legibly(tmp_path):
    with pytest.raises(
        WrongJob, match=r"a\\x1b\[2J\\n\.toml: can't be read; No such file"
    ) as wrong:
        read_job(tmp_path / "a\x1b[2J\n.toml")
    assert str(wrong.value).isprintable()


def test_piece_that_is_refused_is_told_by_its_number(job):
    pieces = '[{kind = "line", y = 0, z = 0, heading = 0, length = nan}]'
    path = job({EGG: 'shape = "pieces"', "a = 0.5 ": f"pieces = {pieces}\n#"})
    with pytest.raises(ValueError, match=r"^\[section\.pieces 1\] length: must be"):
        read_job(path)


def test_job_may_begin_with_a_mark_of_its_encoding(tmp_path):
    (tmp_path / "job.toml").write_bytes(b"\xef\xbb\xbf" + REFERENCE.read_bytes())
    assert read_job(tmp_path / "job.toml") == read_job(REFERENCE)


def test_job_without_a_readable_file(tmp_path):
    with pytest.raises(WrongJob, match=r"none\.toml: can't be read; No such file"):
        read_job(tmp_path / "none.toml")
    with pytest.raises(WrongJob, match=r"^a\\x00b: can't be read; it isn't the name of a file\.$"):
        read_job("a\0b")
    with pytest.raises(ValueError, match=r"^path: must be of class str or Path; got 7\.$"):
        read_job(7)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(WrongJob, match=r"bytes\.toml: is no text in UTF-8\.$"):
        read_job(tmp_path / "bytes.toml")


# What is run

FILES = {"budget.csv", "knots.csv", "setpoints.csv", "setvalues.csv", "line.st", "line.c",
         "controller.c", "controller.h", "controller.st", "controller.xml",
         "section.dxf", "wall.vtp", "wall.stl", "wall.png", "laps.png", "manifest.txt"}  # fmt: skip


def machine_stands_below(answer):
    """Assert that what a machine has and needs follows what else people are told."""
    # T0 has no cylinder.
    assert [row["what"] for row in answer["machine"]] == ["valve of theta", "valve of phi"]
    numbers = {name: value for name, value in answer.items() if name != "files"}
    pump = {"what": "pump", "has": 2.5e-3, "needs": 1e-3, "unit": "m^3/s"}
    plain, whole = (summary_text(numbers | {"machine": rows}).splitlines() for rows in ([], [pump]))
    assert whole[: len(plain)] == plain
    assert [line.split() for line in whole[len(plain) :]] == [
        [], ["the", "machine", "has", "needs"], ["pump", "0.0025", "0.001", "m^3/s"]
    ]  # fmt: skip
    in_step = {"what": "in step, theta", "has": 1.6e4, "needs": 2.7e4, "unit": "N s/m"}
    bears = in_step | {"what": "in step, phi", "has": 3e4}
    said = summary_text(numbers | {"machine": [pump, in_step, bears]}).splitlines()
    assert said[: len(whole)] == whole
    assert [" ".join(line.split()) for line in said[len(whole) :]] == [
        "in step, theta 1.6e+04 2.7e+04 N s/m, less than needed",
        "in step, phi 3e+04 2.7e+04 N s/m",
        "in step: the ground's damper where picks follow each other in one track;",
        "a joint that has less would chatter in it, at any feed; the budget is of picks that",
        "don't follow each other in one track",
    ]


def test_cut_answers_in_json_and_writes_its_files(capsys, job, tmp_path):
    out = tmp_path / "cut"
    code, said, told = run(capsys, "cut", job({"# [pose]": "[pose]", "# y = 1e-3": "y = 1e-3"}),
                           "--out", out, "--json")  # fmt: skip
    assert code == 0
    answer = json.loads(said)
    numbers = {"knots", "setpoints", "ticks", "laps"}
    lengths = {"lap_time_s", "removed_m3", "overbreak_m", "underbreak_m"}
    tables = {"times_s", "limits_used", "saturated_share", "each_lap"}
    assert set(answer) == {
        *numbers, *lengths, *tables, "faults", "files", "machine", "clearances", "warnings"
    }  # fmt: skip
    assert all(0 <= share <= 1 for share in answer["limits_used"].values())
    assert answer["times_s"]["all"] > answer["lap_time_s"] > answer["times_s"]["straight"]
    assert all(isinstance(answer[name], int) for name in numbers)
    assert all(isinstance(answer[name], float) for name in lengths)
    sources = ["knots", "projected chord", "corners", "setpoints", "counts", "feed ripple",
               "following", "encoder", "pose"]  # fmt: skip
    assert [fault["source"] for fault in answer["faults"]] == sources
    assert all(0 <= fault["rms_m"] < 0.01 for fault in answer["faults"])
    pose = answer["faults"][-1]
    assert pose["closed_m"] == pytest.approx(1e-3, rel=0.01)
    assert {Path(name).name for name in answer["files"]} == FILES == {p.name for p in out.iterdir()}
    for step in ("planning ...", "planned: ", "simulating 1 x ", "cutting: lap 1 of 1",
                 "budget: source 9 of 9", "writing "):  # fmt: skip
        assert step in told
    assert answer["warnings"] == []
    machine_stands_below(answer)
    arm, cutter = answer["clearances"]
    assert arm == {"part": "arm", "clearance_m": pytest.approx(0.08), "at_m": 0.0}
    assert cutter["clearance_m"] == pytest.approx(-0.02)
    line = "clear of the wall, in mm: arm 80.0, cutter -20.0"
    numbers = {name: value for name, value in answer.items() if name != "files"}
    assert line in summary_text(numbers).splitlines()
    about, columns = read_csv((out / "setvalues.csv").read_text())
    assert len(columns["tick"]) == answer["ticks"] + 1 and about["tick_s"] == 0.005
    assert "\nFUNCTION_BLOCK" in (out / "line.st").read_text()
    assert (out / "budget.csv").read_text().count("\n") == 11


def test_cut_warns_of_what_is_hardly_meant(capsys, job, tmp_path):
    code, said, told = run(capsys, "cut", job({"tolerance = 1e-3": "tolerance = 0.03"}),
                           "--out", tmp_path / "cut", "--json")  # fmt: skip
    (asked,) = json.loads(said)["warnings"]
    assert code == 0 and told.splitlines()[-1] == f"warning: {asked}"
    assert asked.startswith("[plan] tolerance: 0.03 m isn't below the depth of cut 0.02 m; ")
    code, said, told = run(capsys, "cut", job({"# [pose]": "[pose]", "# y = 1e-3": "y = 1e-2"}),
                           "--out", tmp_path / "cut", "--json")  # fmt: skip
    assert code == 0 and told.splitlines()[-2:] == [
        f"warning: {warning}" for warning in json.loads(said)["warnings"]]  # fmt: skip
    for name, line in zip(("over", "under"), told.splitlines()[-2:], strict=True):
        worst = 1e3 * json.loads(said)[f"{name}break_m"]
        assert line == (f"warning: the {name}-break of {worst:.3g} mm is {worst:.2g} times the "
                        "tolerance of 1 mm; above 3 times this is said.")  # fmt: skip


def test_cut_has_a_row_and_a_line_for_a_first_lap_and_for_one_beside_another(job):
    """In air both leave the same, but for how the joints settle; the second removes a strip."""
    made = read_job(job({"laps = 1": "laps = 3"}))
    cut = made.simulated()
    numbers = results.summarise(made, cut)
    first, last = numbers["each_lap"]
    assert (first["lap"], last["lap"]) == (1, 3)
    assert last["removed_m3"] < 0.6 * first["removed_m3"]
    every = int(made.planned.ticks.sum())
    third = cut.deviation[2 * every :]
    assert last["over_m"] == max(0, third.max()) and last["under_m"] == max(0, -third.min())
    assert len(third) == every + 1 and cut.lap_deviations.shape == (3, every + 1)
    whole, beside = summary_text(numbers).splitlines()[3:5]
    assert whole.startswith("lap 1, in whole ground: overbreak ")
    assert beside.startswith("lap 3, beside another: overbreak ")
    _, ax = figure(height=6)
    lines = wall_plot.draw_laps(ax, cut, tolerance=1e-3)
    np.testing.assert_array_equal(lines[1].get_ydata(), 1e3 * third)
    assert [line.get_label() for line in lines] == ["lap 1", "lap 3, beside another"]
    alone = replace(cut, plan=replace(cut.plan, laps=1), centres=cut.centres[: every + 1])
    assert len(wall_plot.draw_laps(ax, alone, tolerance=1e-3)) == 1


@pytest.mark.parametrize(("tolerance", "said"), [(1e-3, False), (5e-4, True)])
def test_several_times_the_tolerance_is_three_times(job, tolerance, said):
    made = read_job(job({"tolerance = 1e-3": f"tolerance = {tolerance}"}))
    for over, under in ((3.01e-3, 0), (0, 2.99e-3)):
        found = results._warnings(made, over, under)
        assert bool(found) == (said or over > 3e-3)


def test_overshoot_where_the_cutter_enters_counts(job):
    made = read_job(job())
    cut = made.simulated()
    outward = made.planned.circuit.profile.normal(0.0)
    beyond = cut.before[-1:] + 5e-3 * np.array([0.0, *outward])
    numbers = results.summarise(made, replace(cut, before=np.concatenate([cut.before, beyond])))
    assert numbers["overbreak_m"] == pytest.approx(5e-3, rel=0.05)
    assert any(line.startswith("the overbreak of 5") for line in numbers["warnings"])


def test_cut_warns_of_rays_too_far_apart(capsys, job, tmp_path):
    path = job({"along = 200": "along = 3", "around = 360": "around = 12"})
    code, said, _ = run(capsys, "cut", path, "--out", tmp_path / "cut", "--json")
    along, around = (line for line in json.loads(said)["warnings"] if line.startswith("[wall]"))
    assert code == 0
    # Half a groove is half a chord of the ball; the section's length goes by twelve.
    assert around == "[wall] around: 12 rays are 330 mm apart, and half a groove is 87 mm wide."
    # The ground reaches from the first place of the cutter to the last, and a radius on.
    circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    at = circuit.point(np.linspace(0, circuit.profile.perimeter, 2001))
    apart = (np.ptp(at[:, 0]) + 2 * REFERENCE_MACHINE.cutter_radius) / 3
    assert along.startswith(f"[wall] along: 3 rays are {1e3 * apart:.0f} mm apart")


def test_cut_refuses_an_integral_before_it_plans(capsys, job, tmp_path):
    path = job({"# integral = 0": "integral = 1"})
    code, said, told = run(capsys, "cut", path, "--out", tmp_path / "cut")
    assert code == 1 and not said and "planning" not in told
    assert told.startswith("refused: [controller] integral: must be 0, ")
    assert told.endswith("; got 1.\n")


def test_cut_looks_at_its_folder_before_it_simulates(capsys, job, tmp_path):
    (tmp_path / "file").touch()
    why = f"can't be written; {tmp_path / 'file'} is no folder."
    code, said, told = run(capsys, "cut", job(), "--out", tmp_path / "file" / "cut", "--json")
    assert code == 2 and json.loads(said)["wrong"].endswith(why) and "simulat" not in told


@pytest.mark.parametrize(
    ("file", "name"),
    [("...toml", "job"), ("....toml", "job"), ("..", "job"), ("a/../...toml", "job"),
     (".toml", ".toml"), ("tunnel.v2.toml", "tunnel.v2"), ("a/b.toml", "b"), ("..a.toml", "..a")],
)  # fmt: skip
def test_job_writes_inside_a_folder_of_its_own(file, name):
    assert own_name(Path(file)) == name
    for out in (
        Path("build") / own_name(Path(file)),
        Path("build") / f"{own_name(Path(file))}.gif",
    ):
        assert (ROOT / out).resolve().parent == (ROOT / "build").resolve()


def test_job_called_by_dots_alone_is_cut_into_a_folder_of_its_own(capsys, job, tmp_path):
    job().rename(tmp_path / "...toml")
    code, _, _ = run(capsys, "cut", "...toml", "--json")
    assert code == 0 and {path.name for path in (tmp_path / "build" / "job").iterdir()} == FILES
    assert {path.name for path in tmp_path.iterdir()} == {"build", "...toml"}
    assert [path.name for path in (tmp_path / "build").iterdir()] == ["job"]


def test_folder_that_is_read_only_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(PermissionError, match=f"can't be written; {tmp_path} is read-only"):
        check_writable(tmp_path / "cut" / "budget.csv")


def test_cut_tells_people_in_millimetres(capsys, job, tmp_path):
    code, said, _ = run(capsys, "cut", job(), "--out", tmp_path / "cut")
    assert code == 0
    lines = said.splitlines()
    assert "setpoints" in lines[0] and "1 x " in lines[1] and "underbreak" in lines[2]
    table = next(i for i, line in enumerate(lines) if line.startswith("each alone")) + 1
    assert [line.split()[0] for line in lines[table : table + 8]] == [
        "knots", "tangent", "corners", "setpoints", "counts", "feed", "following", "encoder"
    ]  # fmt: skip
    assert {Path(line).name for line in lines[-len(FILES) :]} == FILES
    times = next(line for line in lines if line.startswith("time in s: "))
    assert lines[3].startswith("lap 1, in whole ground: overbreak 0.")
    assert all(part in times for part in ("straight ", "corners ", "entry ", "exit ", "all "))
    used = next(line for line in lines if line.startswith("limits used: "))
    assert "feed 100 %" in used and "acceleration 100 %" in used
    assert "time with a valve fully open: theta 0 %, phi 0 %" in lines
    knots, corners, counts = (lines[table + k].split()[5:] for k in (0, 2, 4))
    assert knots[:6] == ["largest", "1.00", "[plan]", "tolerance", "x", "0.50"]
    assert corners[:1] + corners[2:6] == ["largest", "[plan]", "tolerance", "x", "0.50"]
    assert counts[:1] + counts[2:6] == ["rms", "[plan]", "count_deg", "x", "0.50"]
    assert all(0.4 <= float(row[6]) <= 0.6 for row in (knots, corners, counts))
    assert knots[7:] == corners[7:] == ["your", "choice"]


REFUSED = [
    ({EGG: 'shape = "circle"', "a = 0.5 ": "radius = 0.7"}, "machine: can't cut this section; wid"),
    ({"a = 0.5 ": "a = -1 "}, "[section] a: must be"),
    ({"depth = 0.02": "depth = -0.02"}, "[machine] depth: must be one finite number, not below"),
    ({"along = 40": "along = -2"}, "[wall] along, around: must hold whole numbers"),
    ({"thickness = 0.1": "thickness = -1"}, "[wall] thickness: must be"),
    ({"delay = 1": "delay = -1"}, "[controller] delay: must be one whole number from 0 to 100"),
    ({"# [pose]": "[pose]", "# y = 1e-3": "y = inf"}, "[pose] y: must be"),
    ({"# [stance]": "[stance]", "# pitch_deg = 0 ": "pitch_deg = nan "},
     "[stance] pitch_deg: must be one finite number; got nan."),
    ({"# [stance]": "[stance]", "# yaw_deg = 0 ": "yaw = inf "},
     "[stance] yaw: must be one finite number; got inf."),
    ({"gain = 10": "gain = 1000"}, "loop: must be stable; that of theta isn't at its gain"),
    ({"arm_radius = 0.1": "arm_radius = 0.3"}, "[plan] arm_radius: an arm of 0.3 m is"),
    (BODY | {"# width = 0.3": "width = 0.9"}, "[body] its box is 0.0"),
    (BODY | {"# high = 0.15": "high = -0.3"}, "[body] low: must be below high; got -0.25 and -0.3"),
    ({"# path = \"corrected": "path = \"correct"}, "[plan] path: must be \"projected chord\" or"),
    ({"theta_min_deg = -60": "theta_min_deg = 60"}, "[machine] theta_min_deg: must be below theta_"
     "max_deg, both in degrees from -180 to 180; got 60 and 35."),
    ({"theta_min_deg = -60": "theta_min = 1"}, "[machine] theta_min: must be below theta_max, both "
     "in rad from -pi to pi; got 1 and 0.610865."),
    ({"count_deg = 0.0054931640625": "count_deg = 0"},
     "[plan] count_deg: must be one finite number above zero; got 0."),
    ({"count_deg = 0.0054931640625": "count_deg = -1"},
     "[plan] count_deg: must be one finite number, not below zero; got -1."),
    ({"# encoder_deg = 0": "encoder_deg = 10"},
     "[controller] encoder_deg: must be from 5.72958e-08 to 5.72958 degrees; got 10. If that "),
    ({"# encoder_deg = 0": "encoder = -1"},
     "[controller] encoder: must be from 0 to 0.1 rad; got -1."),
    ({"tick = 5e-3": "tick = 0"}, "[plan] tick: must be"),
    ({"# [hydraulics]": "", "# volume = 2e-4": "power = 3e3"}, "[limits] power: needs the ground"),
    ({"along = 40": "along = 100000", "around = 60": "around = 100000"},
     "[wall] along, around: 100000 x 100000 rays, with all that is made of them, need 5e+03 GB"),
    ({"a = 0.5 ": "a = 0.9 "}, "machine: can't cut this section; width, half width"),
    ({"feed = 0.2": "feed = nan"}, "[limits] feed: must be one finite number above zero; got nan."),
    ({EGG: 'shape = "pieces"', "a = 0.5 ":
      'pieces = [{kind = "line", y = 0, z = 0, heading = 0, length = 1}]\n#'},
     "[section] pieces: 1 of 1 isn't met: it isn't closed; the gap is 1 m."),
]  # fmt: skip


# Ten wrong jobs and the whole sentence that is said of each.
ADVICE = [
    ({"R = 0.80 ": "R = 800"},
     "[machine] R: must be from 0.01 to 20 m; got 800. If that is in mm, it is 0.8 m."),
    ({"depth = 0.02 ": "depth = 20"},
     "[machine] depth: must be at most 1 m; got 20. If that is in mm, it is 0.02 m."),
    ({"tick = 5e-3 ": "tick = 5"},
     "[plan] tick: must be at most 0.5 s; got 5. If that is in ms, it is 0.005 s."),
    ({"feed = 0.2 ": "feed = 100"},
     "[limits] feed: must be from 0.0001 to 1 m/s; got 100. If that is in mm/s, it is 0.1 m/s"),
    ({"acceleration = 0.5": "acceleration = 500"},
     "[limits] acceleration: must be from 0.0001 to 50 m/s^2; got 500. If that is in mm/s^2, "
     "it is 0.5 m/s^2."),
    ({"theta_min_deg = -60": "theta_min = -60"},
     "[machine] theta_min: must be at most 3.2 rad in size; got -60. In degrees its name is "
     "theta_min_deg."),
    ({"tolerance = 1e-3 ": "tolerance = 1 "},
     "[plan] tolerance: must be at most 0.1 m; got 1. If that is in mm, it is 0.001 m."),
    ({"tolerance = 1e-3 ": "tolerance = 1e-7 "},
     "[plan] tolerance: must be at least what a count of 0.00549 degrees moves the cutter, "
     "8.4e-05 m; got 1e-07 m."),
    ({"tolerance = 1e-3 ": "tolerance = 1e-7 ", "count_deg = 0.0054931640625": ""},
     "[plan] tolerance: must be at least what a count of 9.59e-05 rad moves the cutter, 8.4e-05 m; "
     "got 1e-07 m."),
    ({"height = -0.36": "height = -0.9"}, "[machine] height: may be from -"),
    ({"a = 0.5 ": "a = 0.9 "}, " m. Another [machine] height doesn't help."),
    ({"gain = 10 ": "gain = 1000 "}, "the gain must be below "),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), ADVICE)
def test_cut_says_what_was_meant_or_what_is_allowed(capsys, job, tmp_path, changes, sentence):
    code, said, told = run(capsys, "cut", job(changes), "--out", tmp_path / "cut", "--json")
    assert code == 1 and sentence in told.splitlines()[-1]
    assert sentence in " ".join(json.loads(said).values())


@pytest.mark.parametrize(("changes", "sentence"), REFUSED)
def test_cut_refuses_a_job_with_one_and_a_sentence(capsys, job, tmp_path, changes, sentence):
    code, said, told = run(capsys, "cut", job(changes), "--out", tmp_path / "cut", "--json")
    assert code == 1 and set(json.loads(said)) == {"refused"}
    assert json.loads(said)["refused"].startswith(sentence)
    assert told.splitlines()[-1].startswith(f"refused: {sentence}")
    assert not (tmp_path / "cut").exists()


def test_cut_ends_with_two_where_it_cannot_understand(capsys, job, tmp_path):
    code, said, told = run(capsys, "cut", tmp_path / "none.toml")
    assert code == 2 and not said and told.startswith("wrong: ") and told.count("\n") == 1
    code, said, _ = run(capsys, "cut", job({"laps = 1": "lapse = 1"}), "--json")
    assert code == 2 and json.loads(said)["wrong"].startswith("[plan] lapse: isn't known; 'laps'")


# What is said of a value is one code, of whatever is wrong with it; another of what can't be read.
@pytest.mark.parametrize(("old", "new", "code"), [
    ("R = 0.80 ", "R = -1 ", 1), ("R = 0.80 ", "R = 1600 ", 1), ("R = 0.80 ", "R = nan ", 1),
    ("R = 0.80 ", "R = '1' ", 1), ("R = 0.80 ", "R = 99999999999999999999 ", 1),
    ("laps = 1 ", "laps = 0 ", 1), ("laps = 1 ", "laps = 1.5 ", 1), ("laps = 1 ", "laps = [] ", 1),
    ('"T0"', '"T9"', 1), ('"T0"', "0", 1), ('"T0"', '"\\u0007"', 1), (EGG, 'shape = "oval"', 1),
    ("a = 0.5 ", "a = 0.9 ", 1), ("gain = 10 ", "gain = 1000 ", 1),
    ("R = 0.80 ", "", 2), ("R = 0.80 ", "Q = 0.80 ", 2), ("laps = 1 ", "laps = ", 2),
    ("laps = 1 ", "lapse = 1 ", 2), ("[wall]", "[walls]", 2), ("[wall]", "[[wall]]", 2),
    (EGG, "", 2), ("laps = 1 ", "laps = 1\nlaps = 2 ", 2),
])  # fmt: skip
def test_code_is_one_for_a_value_and_two_for_what_cannot_be_read(capsys, job, tmp_path, old, new,
                                                                 code):  # fmt: skip
    ended, said, told = run(capsys, "cut", job({old: new}), "--out", tmp_path / "cut", "--json")
    assert (ended, list(json.loads(said))) == (code, ["refused" if code == 1 else "wrong"])
    assert told.splitlines()[-1].startswith(("refused: ", "wrong: ")[code - 1])
    assert not (tmp_path / "cut").exists()


@pytest.mark.parametrize("arguments", [[], ["dig"], ["cut"], ["cut", "a.toml", "--share", "1"]])
def test_command_refuses_wrong_usage(capsys, arguments):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    said, told = capsys.readouterr()
    assert end.value.code == 2 and not said and "error: " in told


def test_garbage_is_left_at_the_end_of_a_process_of_its_own_alone(capsys, monkeypatch, tmp_path):
    left, usual = [], gc.get_threshold()
    monkeypatch.setattr("atexit.register", left.append)
    arguments = ["cut", str(tmp_path / "missing.toml")]
    assert main(arguments) == 2 and left == [] and gc.get_threshold() == usual
    monkeypatch.setattr(sys, "argv", ["tunneller", *arguments])
    assert main() == 2 and left == [gc.freeze]


def test_help_names_the_commands_and_the_exit_codes(capsys):
    with pytest.raises(SystemExit) as end:
        parser().parse_args(["--help"])
    said = capsys.readouterr().out
    assert end.value.code == 0
    words = "cut", "with 1", "with 2", "130"
    assert all(word in said for word in words)


def without(package, *arguments):
    """Run the command line in a process that lacks a package."""
    code = f"import sys; sys.modules[{package!r}] = None; sys.path.insert(0, {str(ROOT)!r}); "
    code += "from tunneller_lib.__main__ import main; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", code, *arguments], text=True, capture_output=True)


@pytest.mark.parametrize("package", ["numpy", "scipy", "matplotlib"])
def test_help_needs_no_package(package):
    done = without(package, "--help")
    assert done.returncode == 0 and "COMMAND" in done.stdout and not done.stderr


def test_command_names_the_package_that_it_lacks():
    done = without("numpy", "cut", str(REFERENCE), "--json")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert done.stderr.startswith('wrong: the package numpy is missing; pip install "." in')
    assert json.loads(done.stdout)["wrong"] + "\n" == done.stderr.removeprefix("wrong: ")


@pytest.mark.parametrize(("package", "drawn"), [("matplotlib", False), ("pyvista", True)])
def test_cut_draws_its_wall_with_matplotlib_alone(job, tmp_path, package, drawn):
    done = without(package, "cut", str(job()), "--out", str(tmp_path / "cut"))
    assert done.returncode == 0
    left = 'wall.png is left out: the package matplotlib is missing; pip install ".[picture]" in'
    assert ((tmp_path / "cut" / "wall.png").exists(), left in done.stderr) == (drawn, not drawn)


def test_command_names_a_package_that_cannot_be_loaded():
    error = ImportError("cannot import name 'a' from 'PIL'.\nHelp.", name="PIL.Image")
    why = "cannot import name 'a' from 'PIL'"
    assert missing(error) == f"the package pillow can't be loaded; {why}."


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


def test_answer_that_nobody_reads_stops_nothing():
    code = "import tunneller_lib.__main__ as m; input(); m.tell('one'); m.tell('two'); print('end')"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, text=True, stdin=-1,
                               stdout=-1, stderr=-1)  # fmt: skip
    process.stdout.close()
    told = process.stderr
    process.stdin.write("go\n")
    process.stdin.close()
    assert process.wait(30) == 0 and told.read() == ""
    told.close()


def test_process_ends_with_a_sentence_and_its_code(tmp_path):
    (tmp_path / "job.toml").write_text("[machine")
    done = subprocess.run([sys.executable, "-m", "tunneller_lib", "cut", tmp_path / "job.toml",
                           "--out", tmp_path / "out"], cwd=ROOT, text=True,
                          capture_output=True)  # fmt: skip
    assert done.returncode == 2 and not done.stdout
    assert "isn't TOML" in done.stderr and "Traceback" not in done.stderr


def test_command_line_brings_pictures_only_when_they_are_made():
    code = "import sys; from tunneller_lib.__main__ import parser; parser(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True)
    brought = set(done.stdout.split())
    assert not {"numpy", "matplotlib"} & brought
