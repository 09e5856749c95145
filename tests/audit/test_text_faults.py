"""The table of faults planted in words: all kinds, nearly all noticed, the others explained."""

import csv
import re
import tomllib

from tests.audit.text_faults import COLUMNS, DOCUMENTS, KINDS, REASONS, SEED, TABLE, draw, head

READS = [
    "README.md",
    "report/equations.toml",
    "report/ledger/*",
    "report/numbers/*",
    "report/*.typ",
    "report/sections/*",
    "tests/text_faults.*",
]

LINES = TABLE.read_text(encoding="utf-8").splitlines(keepends=True)
HEAD = "".join(line for line in LINES if line.startswith("# "))
ROWS = list(csv.DictReader(line for line in LINES if not line.startswith("# ")))
SURVIVORS = [row for row in ROWS if not row["noticed by"]]
WHY = tomllib.loads(REASONS.read_text(encoding="utf-8"))


def test_table_has_its_columns_seed_and_scores():
    assert list(ROWS[0]) == COLUMNS
    assert HEAD == head(ROWS, SEED)


def test_at_least_a_hundred_of_all_kinds_were_planted():
    assert len(ROWS) >= 100 and len({tuple(row.values()) for row in ROWS}) == len(ROWS)
    kinds = {row["kind"] for row in ROWS}
    assert len(kinds) == len(KINDS)
    assert {row["file"].split("/")[-1] for row in ROWS} >= {f"{name}.toml" for name in DOCUMENTS}


def test_at_most_a_twentieth_survives():
    assert len(SURVIVORS) <= 0.05 * len(ROWS)


def test_what_survives_has_its_reason():
    keys = ["kind", "file", "before", "after"]
    listed = [[row[key] for key in keys] for row in WHY.values()]
    assert sorted(listed) == sorted([row[key] for key in keys] for row in SURVIVORS)
    assert all(list(row) == [*keys, "why"] and row["why"].endswith(".") for row in WHY.values())


def test_what_noticed_a_fault_is_a_test():
    for row in ROWS:
        assert re.fullmatch(r"(tests/test_\w+\.py(::.+)?)?", row["noticed by"])


def test_draw_is_the_same_each_time_and_changes_its_file():
    first, second = draw(), draw()
    assert first == second and len(first) >= 100
    assert len({fault.kind for fault in first}) == len(KINDS)
