"""The planner and the calculator of the pages: the same answers as the command and the library."""

import re
from dataclasses import fields

import numpy as np
import pytest

from report.live import planner
from report.sources import ROOT
from tests.pictures import pixels
from tunneller_lib.__main__ import main
from tunneller_lib.job import reader
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import Torus

READS = ["notebooks/*.toml"]

REFERENCE = (ROOT / "notebooks" / "reference.toml").read_text()


# A line of the job, left out or not, and the words behind it.
LINE = re.compile(r"^(?:# )?(?:\[(\w+)\]|(\w+) = \S.*?)(?:\s+# (.+))?$")


def said():
    """Return the words behind each line of the reference job by the line's table and name."""
    table, words = None, {}
    for line in REFERENCE.split("\n"):
        if not (found := LINE.match(line)):
            continue
        if found[1]:
            table = found[1]
        elif table:
            assert (table, found[2]) not in words
            words[table, found[2]] = found[3]
    return words


def quick():
    """Return the reference job, soon done: few rays, axes without oil, no ground."""
    text = re.sub(r"power = 3e3.*?(?=\n# \[hydraulics\])", "", REFERENCE, flags=re.S)
    soon = {"step = 5e-3": "step = 1e-2", "rest = 1.0": "rest = 0.2", '"T3"': '"T0"',
            "along = 200": "along = 40", "around = 360": "around = 60"}  # fmt: skip
    for old, new in soon.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


@pytest.fixture
def planned(tmp_path, monkeypatch):
    monkeypatch.setattr(planner, "HERE", tmp_path / "planned")
    return tmp_path


def test_planner_prints_and_writes_what_the_command_does(planned, capsys):
    code, printed, files = planner.cut(quick(), "mine.toml")
    (planned / "mine.toml").write_text(quick())
    assert code == main(["cut", str(planned / "mine.toml"), "--out", str(planned / "out")]) == 0
    told = capsys.readouterr().out
    assert printed == told.partition(f"{planned}/out")[0].strip("\n") and "each alone" in printed
    written = sorted((planned / "out").iterdir())
    assert sorted(files) == sorted(["plan.png", *(path.name for path in written)])
    for path in written:
        if path.name not in ("wall.png", "manifest.txt"):  # which lists the page's plan.png, too
            assert files[path.name] == path.read_bytes(), path.name
    for name in ("plan.png", "wall.png", "laps.png"):
        assert pixels(files[name]).std() > 10


def test_reference_job_has_a_line_for_each_name_of_a_job_which_says_its_unit_first():
    sizes = {name: unit for _, own in reader.SHAPES.values() for name, unit in own.items()}
    known = {field.name: getattr(reader, field.name.upper(), sizes) for field in fields(reader.Job)}
    del known["stamp"]  # which says what the file was
    known["section"] = {"shape": reader.TEXT} | sizes
    words = said()
    assert {(table, name.removesuffix("_deg")) for table, name in words} == {
        (table, name) for table, units in known.items() for name in units
    }
    for (table, name), line in words.items():
        key = name.removesuffix("_deg")
        unit = getattr(known[table][key], "unit", known[table][key])
        unit = unit.replace("rad", "deg" if name != key else "rad")
        assert unit in ("", reader.TEXT) or line.startswith(f"{unit}, "), (table, name)


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ("R = 0.80", "R = 800", 1, "refused: [machine] R: must be from 0.001 to 20 m; got 800."),
        ("gain = 10 ", "gain = 90 ", 1, "refused: [controller] gain"),
        ("[section]", "[sectoin]", 2, "wrong: [sectoin]: is no table of a job"),
    ],
)
def test_planner_refuses_as_the_command_does(planned, capsys, old, new, code, said):
    assert REFERENCE.count(old) == 1
    assert planner.cut(REFERENCE.replace(old, new), "a.toml") == (code, "", {})
    assert said in capsys.readouterr().err and list((planned / "planned").iterdir()) == []


def test_calculator_returns_all_digits_and_way_and_end_agree():
    start = {"r": 0.08, "R": 0.8, "theta": 0.0, "phi": -30.0}
    way, paths = planner.geodesic_of(start | {"theta2": 60.0, "phi2": 35.0})
    exact = geodesic_inverse(Torus(0.08, 0.8), (0, np.radians(-30)), np.radians([60, 35]))
    assert float(way["length / m"]) == exact.length and way["certificate"] == "only"
    known = {"azimuth": float(way["azimuth at the start / deg"]), "length": exact.length}
    end, same = planner.geodesic_of(start | known)
    assert float(end["theta at the end / deg"]) == pytest.approx(60, rel=1e-12)
    assert float(end["phi at the end / deg"]) == pytest.approx(35, rel=1e-12)
    assert list(paths) == ["geodesic", "projected chord", "corrected chord"]
    for name, path in paths.items():
        assert np.shape(path) == (planner.DRAWN, 2)
        np.testing.assert_allclose(path, same[name], atol=1e-9)
        np.testing.assert_allclose([path[0], path[-1]], [(0, -30), (60, 35)], atol=1e-9)
    off = [np.abs(np.subtract(path, paths["geodesic"])).max() for path in paths.values()]
    assert off[1] > 2 and off[2] < 0.1  # degrees


def test_calculator_draws_no_chord_where_there_is_none():
    through_the_centre = {"theta": 0, "phi": 0, "theta2": 180, "phi2": 0}
    _, paths = planner.geodesic_of({"r": 0.08, "R": 0.8} | through_the_centre)
    assert list(paths) == ["geodesic"]
