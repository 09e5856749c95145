"""The table of hard lines: its script, its page tried in C, the library's answers, its peers'."""

import csv
import gzip
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from exhibits.exact_shapes import exact_interval
from tests.hard_lines import FAMILIES, KINDS, meet
from tests.references import hard_lines_peers, hard_lines_table

READS = ["tests/references/*"]

HERE = Path(__file__).parent / "references"
PAGE = (HERE / "README.md").read_text(encoding="utf-8")
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
# Answers of another program, line by line: two parameters, or a dash.
ANSWERED = r"""
int meet(const char *kind, const double *s, const double *p, const double *u, double *t) {
    static FILE *file;
    char word[2][40];
    (void)kind, (void)s, (void)p, (void)u;
    if (!file) file = fopen("answers.txt", "r");
    if (!file || fscanf(file, "%39s %39s", word[0], word[1]) != 2) return 0;
    if (!strcmp(word[0], "-")) return 0;
    return sscanf(word[0], "%lf", &t[0]) + sscanf(word[1], "%lf", &t[1]) == 2;
}
"""


@pytest.fixture(scope="module")
def rows():
    """Return the table's rows."""
    with gzip.open(hard_lines_table.TABLE, "rt", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def answers(rows):
    """Return the library's answers (2, n), kind by kind."""
    found = np.empty((2, len(rows)))
    for kind in KINDS:
        places = [i for i, row in enumerate(rows) if row["kind"] == kind]
        names = hard_lines_table.SHAPE + hard_lines_table.LINE
        numbers = np.array([[float(rows[i][name]) for name in names] for i in places])
        shapes, p, u = np.split(numbers, [12, 15], axis=-1)
        found[:, places] = meet(kind, shapes, p, u)
    return found


def test_table_is_what_its_script_writes(rows):
    assert len(rows) == sum(hard_lines_table.ROWS.values()) * len(KINDS) >= 20_000
    groups = {(row["kind"], row["family"]) for row in rows}
    assert groups == {(kind, family.__name__) for kind in KINDS for family in FAMILIES}
    first = {}
    for i, row in enumerate(rows):
        first.setdefault((row["kind"], row["family"]), i)
    for k, kind in enumerate(KINDS):
        for number, family in enumerate(FAMILIES):
            rng = np.random.default_rng([hard_lines_table.SEED, k, number])
            made = hard_lines_table.rows(kind, family, rng, only=2)
            kept = rows[first[kind, family.__name__] :]
            for one, row in zip(made, kept, strict=False):
                assert one == list(row.values())


def checker(folder):
    """Return the program that the page prints, with `meet` reading answers, compiled."""
    source = re.search(r"```c\n(.*?)```", PAGE, re.DOTALL)[1] + ANSWERED
    (folder / "check.c").write_text(source, encoding="utf-8")
    options = ["-std=c99", "-O1", "-Wall", "-Werror", "-Wno-unused-result"]
    command = [COMPILER, *options, "check.c", "-o", "check", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "check"


def told(program, found):
    """Return what the program says of answers (2, n)."""
    lines = ["- -" if not a <= b else f"{a:.17g} {b:.17g}" for a, b in found.T]
    (program.parent / "answers.txt").write_text("\n".join(lines), encoding="utf-8")
    with gzip.open(hard_lines_table.TABLE, "rb") as table:
        done = subprocess.run([program], cwd=program.parent, input=table.read(), check=True,
                              capture_output=True)  # fmt: skip
    return [int(word) for word in re.findall(r"\d+", done.stdout.decode())]


@pytest.mark.skipif(COMPILER is None, reason="no C compiler here")
def test_page_is_enough_for_a_checker_in_c(tmp_path, rows, answers):
    program = checker(tmp_path)
    assert told(program, answers) == [len(rows), 0, 0, 0]
    # Faults are told: no answer, an answer for every line, an end moved by a thousandth.
    nothing = np.full_like(answers, np.nan)
    hits = sum(row["enter"] != "inf" for row in rows)
    assert told(program, nothing) == [len(rows), hits, 0, 0]
    all_met = np.where(answers[0] <= answers[1], answers, 0)
    told_all = told(program, all_met)
    assert told_all[1] == told_all[3] == 0 < told_all[2] <= len(rows) - hits
    moved = np.where(np.isfinite(answers), answers * 1.001, answers)
    assert told(program, moved)[3] > 0.3 * hits


def test_answers_of_the_table_are_ordered_and_as_deep_as_they_say(rows):
    for row in rows:
        depth, hit = float(row["depth"]), float(row["enter"]) <= float(row["leave"])
        assert (depth >= 0 and hit) or (depth <= 0 and not hit)
        assert float(row["give"]) <= float(row["give_single"]) or not hit


def test_touches_that_the_library_loses_are_misses_of_the_rounded_ray(rows):
    """A public routine gets a ray that starts outside; its rounded start may miss what p meets."""
    hits = [row for row in hard_lines_peers.asked(rows) if row["enter"] != "inf"]
    rays = [hard_lines_peers.ray_of(row) for row in hits]
    lost = 0
    for kind in KINDS:
        touches = [ray for ray in rays if ray["kind"] == kind and touching(ray)]
        numbers = [ray["shape"] + ray["origin"] + ray["direction"] for ray in touches]
        shapes, p, u = np.split(np.array(numbers), [12, 15], axis=-1)
        enter, leave = meet(kind, shapes, p, u)
        missed = ~(enter <= leave)
        lost += missed.sum()
        for i in np.flatnonzero(missed):
            assert exact_interval(kind, shapes[i], p[i], u[i]) is None
    with hard_lines_peers.TABLE.open(newline="") as file:
        ours = [row for row in csv.DictReader(file) if row["routine"] == "tunneller_lib"]
    assert lost == sum(int(row["touches lost"]) for row in ours) > 0


def touching(ray):
    """Tell whether a miss of a ray would be a touch that is lost."""
    return hard_lines_peers.verdict(ray, None, hard_lines_peers.DOUBLE) == "touch lost"
