"""`tunneller identify`: logs of an axis, as CSV, and what is said of them."""

import json

import numpy as np
import pytest

from tests.test_identify import TICK, axis_log, openings, set_values
from tunneller_lib.__main__ import main
from tunneller_lib.job.logged import identify_log
from tunneller_lib.motion import Lag, Loop, follow

READS = []

RNG = np.random.default_rng(7)
VALVE = openings(RNG)
VALVE[:20] = 0.0
POSITION, SPEED = axis_log(Lag(0.5, 0.02), VALVE, 1)
WANTED = set_values(RNG)
ACTUAL = follow(Lag(0.5, 0.02), Loop(10.0, TICK, feedforward=0.5), WANTED,
                slopes=np.diff(WANTED) / TICK).position  # fmt: skip


def csv(**columns):
    """Return a log with times and columns of these names."""
    rows = zip(*columns.values(), strict=True)
    lines = [
        ",".join([f"{TICK * n:.6f}", *map(repr, map(float, row))]) for n, row in enumerate(rows)
    ]
    return "\n".join(["# a log", ",".join(["time_s", *columns]), *lines, ""])


def noisy(values, size):
    return values + size * np.random.default_rng(9).standard_normal(len(values))


@pytest.mark.parametrize(
    "columns",
    [{"valve": VALVE, "speed_rad_s": noisy(SPEED, 2e-3)},
     {"valve": VALVE, "position_rad": noisy(POSITION, 1e-4), "pressure": SPEED}],
    ids=["speed", "position"],
)  # fmt: skip
def test_log_of_an_axis(columns):
    found = identify_log(csv(**columns))
    assert found["columns"] == list(columns)[:2] and found["rows"] == len(VALVE)
    assert found["tick_s"] == pytest.approx(TICK) and found["delay"] == 1
    assert found["gain_unit"] == "rad/s"
    assert abs(found["gain"] - 0.5) < 4 * found["gain_error"] < 0.01
    assert abs(found["lag_s"] - 0.02) < 4 * found["lag_error_s"] < 2e-3


def test_command_says_what_a_log_of_a_loop_tells(tmp_path, capsys):
    path = tmp_path / "log.csv"
    path.write_text(csv(set_rad=WANTED, actual_rad=noisy(ACTUAL, 2e-5)), encoding="utf-8")
    assert main(["identify", str(path), "--feedforward", "0.5"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{len(WANTED)} rows, 5 ms apart: set_rad and actual_rad"
    assert [line.split()[0] for line in said[1:]] == ["gain", "lag", "delay", "left"]
    assert said[1].endswith("1/s") and " ± " in said[1] and said[2].endswith("ms")
    assert main(["identify", str(path), "--feedforward", "0.5", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["gain"] == pytest.approx(10, rel=0.02)
    assert found["rms"] == pytest.approx(2e-5, rel=0.1)


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "must have a heading; got none."),
        ("time,valve\n1,2\n", "must have the columns time_s, valve, speed_rad_s; or "),
        (
            "time_s;valve;speed_rad_s\n0,005;0,1;0,2\n",
            "its columns must be separated by commas, decimals by points; got the heading "
            "'time_s;valve;speed_rad_s'.",
        ),
        ("time_s\tvalve\n0\t1\n", "its columns must be separated by commas, decimals by points"),
        (
            csv(valve=VALVE, speed_rad_s=SPEED).replace("\n0.01", "\n0.012"),
            "time_s must rise by steps even to 1 %; got steps from ",
        ),
        (
            csv(valve=VALVE, speed_rad_s=SPEED).replace("\n0.0", "\n-0.0"),
            "time_s must rise by steps even to 1 %; got steps from ",
        ),
        (
            csv(valve=VALVE, speed_rad_s=SPEED).replace("\n0.000000", "\ninf"),
            "time_s must be finite times; got [inf, 0.005, 0.01].",
        ),
        ("time_s,valve,speed_rad_s\n", "must have 20 to 200000 rows; got 0."),
        ("time_s,valve,speed_rad_s\n0,1,1\n1,1,1\n", "must have 20 to 200000 rows; got 2."),
        ("time_s,valve,speed_rad_s\n0,1,x\n", "column 'speed_rad_s' must hold numbers"),
        (
            "time_s,valve,speed_rad_s\n0,1,1\n0,1\n",
            "line 3 must have 3 numbers, one under each name; got 2.",
        ),
        ("\x80", "is no text in UTF-8."),
    ],
)
def test_file_that_is_no_log_is_named(tmp_path, capsys, text, said):
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode("latin-1"))
    assert main(["identify", str(path)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"wrong: {path}: {said}") and told.count("\n") == 1


@pytest.mark.parametrize(
    "text, said",
    [
        (csv(valve=0 * VALVE, speed_rad_s=SPEED), "valve: must move the axis; got a column that"),
        (csv(valve=VALVE, position_rad=0 * VALVE), "position_rad: must be of an axis that moves;"),
        (
            csv(valve=VALVE, speed_rad_s=SPEED * np.nan),
            "speed_rad_s: must hold finite numbers; got",
        ),
        (
            csv(set_rad=WANTED[400:], actual_rad=ACTUAL[400:]),
            "set_rad: must stay the same in the first 10 rows, since a log of a loop must begin",
        ),
        (
            csv(set_rad=WANTED, actual_rad=ACTUAL + 0.1 * np.arange(len(WANTED))),
            "actual_rad: must rest in the first ",
        ),
    ],
)
def test_logs_that_tell_nothing_are_refused_in_a_sentence(tmp_path, capsys, text, said):
    path = tmp_path / "log.csv"
    path.write_text(text)
    assert main(["identify", str(path)]) == 1
    assert capsys.readouterr().err.startswith(f"refused: {said}")


def test_feedforward_of_an_axis_is_refused(tmp_path, capsys):
    path = tmp_path / "log.csv"
    path.write_text(csv(valve=VALVE, speed_rad_s=SPEED))
    assert main(["identify", str(path), "--feedforward", "0.5"]) == 1
    told = capsys.readouterr().err
    assert told == "refused: feedforward: must be 0 for an axis' log; got 0.5.\n"


def test_log_may_have_blanks_after_commas_and_blank_lines():
    plain = csv(valve=VALVE, speed_rad_s=SPEED)
    assert identify_log(plain.replace(",", ", ") + "\n \n") == identify_log(plain)


def test_help_says_what_a_log_must_be(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "a log of a loop must begin at rest, for at least 10 rows" in said
    assert "0 by default" in said
