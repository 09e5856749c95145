"""What commands say: lines that no terminal obeys, JSON that any reader takes, named files."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tunneller_lib.__main__ import main, tell
from tunneller_lib.job import say
from tunneller_lib.job.atomic_write import replacement
from tunneller_lib.terminal import LONGEST, fit

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "tunneller_lib" / "job" / "reference.toml"
OBEYED = "a\x1b[2Jb\r\x07\n\x85\u202ec"  # clears, returns, rings, turns the writing's direction
TOLD = r"a\x1b[2Jb\r\x07\n\x85\u202ec"


@given(st.text(st.characters()), st.integers(10, 60))
def test_any_text_becomes_one_printable_line_of_bounded_length(text, most):
    line = fit(text, most)
    assert line.isprintable() and len(line) <= most
    if text.isprintable() and len(text) <= most:
        assert line == text


def test_progress_is_a_line_that_no_terminal_obeys(capsys):
    say(f"writing {OBEYED}")
    say("begin " + "x" * 100_000 + " end.")
    told = capsys.readouterr().err.splitlines()
    assert told[0] == f"writing {TOLD}" and len(told) == 2 and len(told[1]) == LONGEST
    assert told[1].startswith("begin x") and told[1].endswith("x end.")


@pytest.mark.parametrize("arguments", [
    ("cut", f"{OBEYED}.toml"),
    ("cut", REFERENCE, "--out", f"{REFERENCE}/{OBEYED}"),
    (OBEYED,),
])  # fmt: skip
def test_a_name_that_a_terminal_would_obey_is_spelled_out(capsys, arguments):
    try:
        code = main([str(one) for one in arguments])
    except SystemExit as end:  # of wrong usage
        code = end.code
    said, told = capsys.readouterr()
    assert code == 2 and said == ""
    assert all(line.isprintable() for line in told.split("\n"))
    assert "\\x1b[2J" in told and len(told) < 1200


def refuse_constants(name):
    pytest.fail(f"{name} is no JSON")


def test_answer_is_json_where_a_number_is_not_finite(capsys):
    answer = {"has": np.inf, "rows": [{"needs": -np.inf, "x": 1.5}, (np.nan, 2)], "n": 3, "s": "a"}
    tell(answer)
    said = capsys.readouterr().out
    assert json.loads(said, parse_constant=refuse_constants) == {
        "has": None, "rows": [{"needs": None, "x": 1.5}, [None, 2]], "n": 3, "s": "a"
    }  # fmt: skip


def command(*arguments, **streams):
    """Run the command line in a process, with these streams."""
    streams = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE} | streams
    return subprocess.run([sys.executable, "-m", "tunneller_lib", *map(str, arguments)],
                          cwd=ROOT, text=True, **streams)  # fmt: skip


full_device = pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has /dev/full")


ANSWER = """
import sys
import tunneller_lib.__main__ as command
command.run_cut = lambda options: {"files": ["wall.stl"]}
sys.exit(command.main())
"""


@full_device
@pytest.mark.parametrize("more", [(), ("--json",)])
def test_an_answer_that_finds_no_room_names_where_it_went(more):
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-c", ANSWER, "cut", "job.toml", *more], cwd=ROOT,
                              text=True, stdout=full, stderr=subprocess.PIPE)  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == f"wrong: standard output: {os.strerror(errno.ENOSPC)}.\n"


@full_device
def test_a_reason_that_finds_no_room_still_ends_with_its_code(tmp_path):
    with open("/dev/full", "w") as full:
        done = command("cut", tmp_path / "none.toml", stderr=full)
        assert done.returncode == 2
        done = command("cut", tmp_path / "none.toml", "--json", stdout=full)
    assert done.returncode == 2 and done.stderr.startswith("wrong: ")
    assert done.stderr.count("\n") == 1


def test_a_file_that_finds_no_room_is_named(tmp_path):
    # As write(2) says it: without a name.
    with pytest.raises(OSError) as full, replacement(tmp_path / "knots.csv"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert full.value.filename == str(tmp_path / "knots.csv")
    # Nor is the passing name of a file on its way of any use to a reader.
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError) as taken, replacement(tmp_path / "folder") as new:
        new.write_text("x")
    assert taken.value.filename == str(tmp_path / "folder") and not new.exists()
