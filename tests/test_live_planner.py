"""The planner and the calculator of the pages: the same answers as the command and the library."""

import re

import numpy as np
import pytest

from report.live import planner
from report.sources import ROOT
from tests.pictures import pixels
from tunneller_lib.__main__ import main
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import Torus

READS = ["notebooks/*"]

REFERENCE = (ROOT / "notebooks" / "reference.toml").read_text()


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
    for path in (planned / "out").iterdir():
        if path.suffix != ".png":
            assert files[path.name] == path.read_bytes(), path.name
    for name in ("plan.png", "wall.png"):
        assert pixels(files[name]).std() > 10


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ("R = 0.80", "R = 800", 2, "wrong: [machine] R: must be at most 50 m; got 800."),
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
    way = planner.geodesic_of(start | {"theta2": 60.0, "phi2": 35.0})
    exact = geodesic_inverse(Torus(0.08, 0.8), (0, np.radians(-30)), np.radians([60, 35]))
    assert float(way["length / m"]) == exact.length and way["certificate"] == "only"
    known = {"azimuth": float(way["azimuth at the start / deg"]), "length": exact.length}
    end = planner.geodesic_of(start | known)
    assert float(end["theta at the end / deg"]) == pytest.approx(60, rel=1e-12)
    assert float(end["phi at the end / deg"]) == pytest.approx(35, rel=1e-12)
