"""The planted faults of `make mutants`: drawn as said, nearly all noticed, the rest explained."""

import csv
import tomllib
from collections import Counter

import pytest

from tests import mutants
from tests.mutants import REASONS, TABLE, Mutant, Places, more

READS = ["tests/mutants.*"]

ROOMS = {"arrays.py", "envelopes", "motion", "paths", "ream", "removal", "reporting", "surfaces"}
KINDS = {"branch", "constant", "exponent", "factor", "index", "sign"}
ROWS = list(csv.DictReader(TABLE.read_text().splitlines()))


def test_all_rooms_and_kinds_are_altered():
    assert len(ROWS) >= 60
    assert {row["file"].split("/")[1] for row in ROWS} == ROOMS
    assert min(Counter(row["kind"] for row in ROWS).values()) >= 6
    assert {row["kind"] for row in ROWS} == KINDS


def test_of_planted_faults_at_most_a_twentieth_survives():
    alive = [row for row in ROWS if not row["killed by"]]
    assert len(alive) <= 0.05 * len(ROWS)
    reasons = tomllib.loads(REASONS.read_text()).values()
    explained = {(entry["file"], entry["after"]) for entry in reasons}
    assert explained == {(row["file"], row["after"]) for row in alive}
    assert all(entry["why"].endswith(".") for entry in reasons)


@pytest.mark.parametrize(
    ("source", "kind", "after"),
    [
        ("a - b", "sign", "a + b"),
        ("-a", "sign", "+a"),
        ("a -= b", "sign", "a += b"),
        ("a * b", "factor", "a * 2 * b"),
        ("(a) / (b)", "exponent", "(a) * (b)"),
        ("a**2", "exponent", "a**3"),
        ("a[..., 1]", "index", "a[..., 0]"),
        ("a[0:]", "index", "a[1:]"),
        ("a[:-1]", "index", "a[:-2]"),
        ("a < b", "branch", "a >= b"),
        ("a and b and c", "branch", "a or b and c"),
        ("a = 0.99", "constant", "a = 1.00"),
        ("a = 3", "constant", "a = 4"),
    ],
)
def test_one_token_is_changed(source, kind, after):
    found = {source[:c] + new + source[c + len(old) :] for _, c, k, old, new in Places(source).found
             if k == kind}  # fmt: skip
    assert after in found


MESSAGE = "raise ValueError(f'{a + 1}')"
LOOP = "for i in range(9): pass"


@pytest.mark.parametrize(
    "source", [MESSAGE, LOOP, "'a' + b", "[a] * len(b) + [a]", "a = 1e-9", "f(x, axis=-1)"]
)
def test_messages_lists_and_tolerances_stay(source):
    assert Places(source).found == []


def test_settings_and_guards_are_never_drawn():
    places = Places("def f(a, n=48):\n    return a / (n + (n == 0)) - 2\n")
    drawn = {(kind, old) for *_, kind, old, _ in set(places.found) - set(places.idle)}
    assert drawn == {("factor", "/"), ("exponent", "/"), ("sign", "-"), ("constant", "2")}


def test_last_digit_of_a_constant():
    assert [more(n) for n in ("1", "0.5", "1.09", "9.9", "0.050")] == [
        "2", "0.6", "1.10", "10.0", "0.051"]  # fmt: skip


def test_draw_is_the_same_each_time_and_changes_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(mutants, "COPY", tmp_path)
    (tmp_path / "it.py").write_text("def f(x, y):\n    return x**2 - 3 * y\n" + "\n" * 200)
    first, second = mutants.draw("it.py"), mutants.draw("it.py")
    assert first == second and len(first) == 1  # one line has formulas
    mutant = first[0]
    before, after = mutant.lines()
    assert [a != b for a, b in zip(before, after, strict=True)] == [False, True] + [False] * 200
    assert isinstance(mutant, Mutant) and mutant.row("t")["killed by"] == "t"
