"""The README: its lines run and say what stands beside them, its links lead somewhere."""

import re
import shlex
import subprocess
import sys

import numpy as np
import pytest

from report import lists
from report.sources import ROOT
from tests.bench import times
from tunneller_lib.surfaces import Torus

READS = ["README.md", "Makefile", "notebooks/*", "report/numbers/*", "tests/bench/times.*"]

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```", TEXT, re.M | re.S)
COMMANDS = [line.split("  #")[0].strip() for kind, block in BLOCKS if not kind
            for line in block.splitlines()]  # fmt: skip
[PYTHON] = [block for kind, block in BLOCKS if kind == "python"]


def test_lines_of_the_library_print_what_stands_beside_them(capsys):
    space = {}
    for line in PYTHON.splitlines():
        code, _, said = line.partition("  # ")
        exec(code, space)
        printed = capsys.readouterr().out.strip()
        assert printed == (said if code.startswith("print") else ""), line


@pytest.mark.parametrize("command", [c for c in COMMANDS if c.startswith("make")])
def test_make_knows_the_targets(command):
    tried = subprocess.run([*shlex.split(command), "--dry-run"], cwd=ROOT, capture_output=True)
    assert tried.returncode == 0


PROGRAMS = [c for c in COMMANDS if "tunneller_lib" in c and c.startswith((".venv", "plain"))]


@pytest.mark.parametrize("command", PROGRAMS)
def test_programs_are_called_rightly(command):
    _, *rest = shlex.split(command)
    if "-m" in rest:  # a simulation takes seconds, a GIF minutes: test_command runs them
        rest.append("--help")
    done = subprocess.run([sys.executable, *rest], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout, done.stderr


def test_line_for_builders_prints_the_foot_of_a_point_on_the_torus():
    [command] = [c for c in PROGRAMS if c.startswith("plain/bin/python -c")]
    _, *rest = shlex.split(command)
    done = subprocess.run([sys.executable, *rest], cwd=ROOT, capture_output=True, text=True)
    printed = [float(word) for word in done.stdout.strip().strip("[]").split()]
    assert len(printed) == 3 and np.isfinite(printed).all()
    np.testing.assert_allclose(printed, Torus(r=0.08, R=0.80).foot((0.5, 0.2, 0.1)), atol=1e-8)


def test_the_test_to_try_is_there():
    [(file, name)] = re.findall(r"`\.venv/bin/python -m pytest (\S+) -k (\w+)`", TEXT)
    assert f"def test_{name}(" in (ROOT / file).read_text(encoding="utf-8")


def test_links_lead_to_files():
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert target.startswith("https://") or (ROOT / target).exists(), target


def test_the_list_of_targets_is_complete():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^(\w+):.*##", makefile, re.M))
    told = set(re.findall(r"`(?:make )?(\w+)`|^make (\w+)", TEXT, re.M))
    assert targets <= {name for pair in told for name in pair}


def test_make_help_and_the_page_fetch_the_same():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    fetched = r"\(fetches (\d+ MB) of Pyodide once, or else open-webui's wheel with it, (\d+ MB)\)$"
    line = rf"^live:.*{fetched}"
    [told] = re.findall(line, makefile, re.M)
    release, wheel = told
    assert f"The build fetches {release} once from Pyodide's release" in TEXT
    assert f"a wheel of {wheel} from PyPI" in TEXT


def test_the_table_of_times_is_that_of_the_last_runs():
    assert times.with_table(TEXT) == TEXT
    works = {row["work"] for row in times.read()}
    assert works and all(f"| {work}, " in TEXT for work in works)


def test_rows_of_the_table_of_times_are_whole():
    for row in times.read():
        assert tuple(row) == times.COLUMNS
        assert int(row["n"]) > 0 and float(row["here_s"]) > 0
        assert all(row[name] for name in ("work", "each", "criterion", "date", "processor", "load"))
        assert bool(row["peer"]) == bool(row["peer_s"])


def test_layout_names_every_room():
    layout = TEXT.split("\n## Layout\n")[1]
    library = ROOT / "tunneller_lib"
    for path in library.glob("*/__init__.py"):
        assert f" {path.parent.name}/ " in layout


def test_findings_are_those_of_the_chapters():
    assert "<!-- found: begin -->" in TEXT
    assert lists.with_findings(TEXT) == TEXT, "run `make report`"


@pytest.mark.parametrize("missing", ["begin", "end"])
def test_block_without_its_marks_is_refused(missing):
    text = "".join(f"<!-- found: {mark} -->\n" for mark in ("begin", "end"))
    assert lists.with_block(f"a\n{text}b\n", "found", "new").splitlines() == [
        "a", "<!-- found: begin -->", "", "new", "", "<!-- found: end -->", "b"
    ]  # fmt: skip
    with pytest.raises(ValueError, match=r"^text: must have the lines <!-- found: begin --> and"):
        lists.with_block(text.replace(missing, "other"), "found", "new")
