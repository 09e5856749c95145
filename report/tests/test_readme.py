"""The README and its guide: lines run and say what stands beside them, links lead somewhere."""

import re
import shlex
import subprocess
from importlib.util import find_spec

import numpy as np
import pytest

from report import lists
from report.site import machine
from report.sources import ROOT
from tests.bench import times
from tunneller_lib.__main__ import main
from tunneller_lib.surfaces import REFERENCE_MACHINE

READS = [
    "README.md", "CONTRIBUTING.md", "Makefile", "notebooks/*.toml", "report/guide/*",
    "report/ledger/*", "report/numbers/*", "tests/bench/times.*",
]  # fmt: skip

README = ROOT / "README.md"
GUIDE = {
    path: path.read_text(encoding="utf-8") for path in (ROOT / "report" / "guide").glob("*.md")
}
TEXT = README.read_text(encoding="utf-8")
ALL = "\n".join([TEXT, *GUIDE.values()])
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```", ALL, re.M | re.S)
COMMANDS = [line.split("  #")[0].strip() for kind, block in BLOCKS if not kind
            for line in block.splitlines()]  # fmt: skip
PYTHON = [block for kind, block in BLOCKS if kind == "python"]


@pytest.mark.parametrize("block", PYTHON, ids=len)
def test_lines_of_the_library_print_what_stands_beside_them(capsys, block):
    space = {}
    for line in block.splitlines():
        code, _, said = line.partition("  # ")
        exec(code, space)
        printed = capsys.readouterr().out.strip()
        assert printed == (said if code.startswith("print") else ""), line


@pytest.mark.parametrize("command", [c for c in COMMANDS if c.startswith("make")])
def test_make_knows_the_targets(command):
    tried = subprocess.run([*shlex.split(command), "--dry-run"], cwd=ROOT, capture_output=True)
    assert tried.returncode == 0


def test_programs_run_as_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    printed = [c for c in COMMANDS if re.match(r"\S*tunneller |\S*python -m tunneller_lib ", c)]
    assert len(printed) >= 5
    for command in printed:
        _, rest = re.split(r"tunneller(?:_lib)? ", command, maxsplit=1)
        call, _, file = rest.partition(" > ")
        dry = ["--dry-run"] if call.startswith("cut") else []  # test_command runs it to its end
        assert main([*shlex.split(call), *dry]) == 0
        said = capsys.readouterr().out
        assert said
        if file:
            (tmp_path / file).write_text(said)


def test_modules_and_targets_that_are_told_of_are_there():
    text = f"{ALL}\n{(ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')}"
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    assert set(re.findall(r"`make (?:[A-Z]+=\S+ )?(\w+)", text)) <= targets
    for name in re.findall(r"python -m ((?:report|tests)[\w.]*)", text):
        assert find_spec(name), name


def test_the_test_to_try_is_there():
    [(file, name)] = re.findall(r"`\.venv/bin/python -m pytest (\S+) -k (\w+)`", TEXT)
    assert f"def test_{name}(" in (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", [README, *GUIDE], ids=lambda path: path.name)
def test_links_lead_to_files(path):
    for target in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8")):
        assert target.startswith("https://") or (path.parent / target).exists(), target


def test_the_first_command_comes_soon_and_the_whole_is_short():
    assert len(TEXT.partition("```")[0].split()) <= 150 and len(TEXT.split()) <= 1200


def test_the_list_of_targets_is_complete():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^(\w+):.*##", makefile, re.M))
    told = set(re.findall(r"`(?:make )?(\w+)`|^make (\w+)", ALL, re.M))
    assert targets <= {name for pair in told for name in pair}


def test_the_table_of_times_is_that_of_the_last_runs():
    text = times.PAGE.read_text(encoding="utf-8")
    assert times.with_table(text) == text
    works = {row["work"] for row in times.read()}
    assert works and all(f"| {work}, " in text for work in works)


def test_findings_are_those_of_the_chapters_and_the_ledger():
    assert lists.with_findings(TEXT) == TEXT, "run `make report`"


@pytest.mark.parametrize("missing", ["begin", "end"])
def test_block_without_its_marks_is_refused(missing):
    text = "".join(f"<!-- found: {mark} -->\n" for mark in ("begin", "end"))
    assert lists.with_block(f"a\n{text}b\n", "found", "new").splitlines() == [
        "a", "<!-- found: begin -->", "", "new", "", "<!-- found: end -->", "b"
    ]  # fmt: skip
    with pytest.raises(ValueError, match=r"^text: must have the lines <!-- found: begin --> and"):
        lists.with_block(text.replace(missing, "other"), "found", "new")


def test_moving_machine_follows_the_circuit_on_its_arm():
    drawing = machine.moving_machine()
    places = re.search(r'<polyline class="arm".*?values="([^"]+)"', drawing)[1].split(";")
    arms = np.array([[p.split(",") for p in place.split()] for place in places], dtype=float)
    assert arms.shape == (machine.PLACES, 3, 2)
    assert np.ptp(arms[:, 0], axis=0).max() == 0  # it stands
    assert np.linalg.norm(arms[0, 2] - arms[-1, 2]) < 1  # it closes
    longest = np.linalg.norm(arms[:, 2] - arms[:, 1], axis=1).max()
    assert longest <= machine.SCALE * REFERENCE_MACHINE.R + 0.2
