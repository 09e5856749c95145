"""The faults of `make mutants`: of each kind and room, nearly all noticed, the rest explained."""

import tomllib
from collections import Counter

import pytest

from tests.audit import mutants
from tests.audit.mutant_kinds import KINDS, Places, rules_in
from tests.audit.mutants import REASONS, TABLE

READS = ["tests/audit/mutants.*", "tunneller_lib/*"]

ROOMS = {"envelopes", "job", "milling", "motion", "paths", "ream", "removal", "surfaces"}
HEAD, ROWS = mutants.read_table(TABLE.read_text(encoding="utf-8"))


def test_all_rooms_and_kinds_are_altered():
    assert len(ROWS) >= 400
    assert {mutants.room(row["file"]) for row in ROWS} >= ROOMS
    assert {row["kind"] for row in ROWS} == KINDS
    assert min(Counter(row["kind"] for row in ROWS).values()) >= 4


def test_head_has_the_seed_and_the_scores():
    assert HEAD[0] == f"seed {mutants.SEED}"
    met = HEAD[1].removeprefix("survivors met ")
    assert met in mutants.MET
    again = mutants.head(ROWS, mutants.SEED, met, HEAD[-1])
    assert again.splitlines() == [f"# {line}" for line in HEAD] and HEAD[-1].startswith("judged 20")


def test_of_planted_faults_at_most_a_twentieth_survives():
    alive = [row for row in ROWS if not row["killed by"]]
    assert len(alive) <= 0.05 * len(ROWS)
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8")).values()
    explained = {(entry["file"], entry["after"]) for entry in reasons}
    assert explained == {(row["file"], row["after"]) for row in alive}
    assert all(entry["why"].endswith(".") for entry in reasons)
    # A fault of a line that is gone can't be planted any more: its module is judged anew.
    for row in alive:
        lines = (mutants.ROOT / row["file"]).read_text(encoding="utf-8").splitlines()
        assert row["before"] in [line.strip() for line in lines], row


@pytest.mark.parametrize(
    ("source", "kind", "after"),
    [
        ("a - b", "sign", "a + b"),
        ("a * b", "factor", "a * 2 * b"),
        ("(a) / (b)", "exponent", "(a) * (b)"),
        ("a**2", "exponent", "a**3"),
        ("a[..., 1]", "index", "a[..., 0]"),
        ("a < b", "branch", "a >= b"),
        ("a and b and c", "branch", "a or b and c"),
        ("a = 0.99", "constant", "a = 1.00"),
        ("a = 1e-9", "tolerance", "a = 1e-6"),
        ("A = 8 * np.finfo(float).eps", "tolerance", "A = 8 * (1e3 * np.finfo(float).eps)"),
        ("def f(a, n=48): pass", "default", "def f(a, n=2 * 48): pass"),
        ("def f(*, w: Literal['u', 'd'] = 'u'): pass", "default",
         "def f(*, w: Literal['u', 'd'] = \"d\"): pass"),
        ("class A:\n    n: int = 3", "default", "    n: int = 2 * 3"),
        ("if a <= 0: raise E", "range", "if a < 0: raise E"),
        ("if a == 0 or b: raise E", "range", "if a == 0 and b: raise E"),
        ("if a: raise E(b)", "guard", "if a: E(b)"),
        ("rods.check_differ(a, b)", "guard", "0 and rods.check_differ(a, b)"),
        ('raise E("a, b: must differ.")', "message", 'raise E("a, b: need not differ.")'),
        ('raise E("size: above 0.")', "message", 'raise E("argument: above 0.")'),
    ],
)  # fmt: skip
def test_one_place_is_changed(source, kind, after):
    lines = source.split("\n")
    found = [lines[n - 1][:c] + new + lines[n - 1][c:].removeprefix(old)
             for n, c, k, old, new in Places(source).found if k == kind]  # fmt: skip
    assert after in found


TYPES = """
Finite = Number()
Length = Number(LEAST, MOST, "m")
Angle = Number(unit="rad")
Points = Array("(..., 3) float", "m", last="x, y, z")
"""
ROD = """
from .arguments import Angle, Finite, Length, Points, Whole, checked
@checked
def f({}): pass
"""


@pytest.mark.parametrize(
    ("rule", "others"),
    [
        ("a: Length", {"a: Finite", "a: Angle", "a: object"}),
        ("a: Finite", {"a: Length", "a: object"}),  # an angle is as finite
        ("a: Points", {"a: object"}),
        ("a: Points | None", {"a: Points", "a: object | None"}),
        ("a: Rod", {"a: object"}),
        ('a: Literal["u", "d"]', {'a: Literal["u"]'}),
        ("a: Whole(1, MOST)", {"a: Whole(1 - 1, MOST)", "a: Whole(1 + 1, MOST)",
                               "a: Whole(1, 2 * MOST)"}),
    ],
)  # fmt: skip
def test_rule_gives_way_to_another_that_is_at_hand(rule, others):
    source = ROD.format(rule)
    line = source.splitlines()[3]
    places = [place for place in Places(source, rules_in(TYPES)).found if place[2] == "rule"]
    found = {line[:c] + new + line[c:].removeprefix(old) for _, c, _, old, new in places}
    assert found == {f"def f({other}): pass" for other in others}
    assert Places(source.replace("@checked", ""), rules_in(TYPES)).found == []


PRINTED = "print(f'{a + 1}')"
LOOP = "for i in range(9): pass"


@pytest.mark.parametrize(
    "source",
    [PRINTED, LOOP, "'a' + b", "[a] * len(b) + [a]", "f(x, axis=-1)", "def f(a=None): pass"],
)
def test_lists_and_what_is_printed_stay(source):
    assert Places(source).found == []


@pytest.mark.parametrize(
    "divisor", ["(n + (n == 0))", "np.maximum(n, 1e-9)", "np.clip(n, 1e-30, n)"]
)
def test_guards_against_zero_are_never_drawn(divisor):
    places = Places(f"def f(a, n):\n    return a / {divisor} - 2\n")
    drawn = {(kind, old) for *_, kind, old, _ in set(places.found) - set(places.idle)}
    assert drawn == {("factor", "/"), ("exponent", "/"), ("sign", "-"), ("constant", "2")}
