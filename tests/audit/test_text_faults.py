"""The table of faults planted in words: head, kinds, and a reason for each that survived."""

import csv
import tomllib

from tests.audit.text_faults import KINDS, REASONS, SEED, TABLE, draw, head

LINES = TABLE.read_text(encoding="utf-8").splitlines(keepends=True)
ROWS = list(csv.DictReader(line for line in LINES if not line.startswith("# ")))
SURVIVORS = [row for row in ROWS if not row["noticed by"]]


def test_head_and_kinds_are_those_of_the_rows():
    above = [line[2:-1] for line in LINES if line.startswith("# ")]
    assert head(ROWS, SEED, above[-1]).splitlines() == [f"# {line}" for line in above]
    assert above[-1].startswith("judged 20")
    assert len({row["kind"] for row in ROWS}) == len(KINDS)


def test_at_most_a_twentieth_survives_and_each_has_its_reason():
    assert len(SURVIVORS) <= 0.05 * len(ROWS)
    why = tomllib.loads(REASONS.read_text(encoding="utf-8")).values()
    assert sorted(row["before"] for row in why) == sorted(row["before"] for row in SURVIVORS)
    assert all(row["why"].endswith(".") for row in why)


def test_draw_is_the_same_each_time():
    first = draw()
    assert first == draw() and len({fault.kind for fault in first}) == len(KINDS)
