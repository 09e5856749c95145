"""The verdicts of `recognise` on thousands of random surfaces, as the report shows them."""

import csv

from tests.audit.recognise_many import HEAD, TABLE
from tests.envelopes_random import KINDS

READS = ["tests/audit/recognised.csv"]


def test_table_of_verdicts_on_thousands_has_no_wrong_one_and_tells_nearly_always():
    """What the report shows; `python -m tests.audit.recognise_many` makes it."""
    lines = [line for line in TABLE.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    total = sum(int(row[verdict]) for row in rows for verdict in HEAD[3:])
    assert total >= 5000 and {row["class"] for row in rows} == set(KINDS)
    for exact in (True, False):
        part = [row for row in rows if (row["surface"] == "member") == exact]
        assert sum(int(row[verdict]) for row in part for verdict in HEAD[3:]) == total / 2
        assert sum(int(row["is not" if exact else "is"]) for row in part) == 0
        for kind in KINDS:
            clear = [
                row for row in part if row["class"] == kind and row["near parabolic"] == "False"
            ]
            untold = sum(int(row["cannot tell"]) for row in clear)
            assert untold <= 0.05 * sum(int(row[verdict]) for row in clear for verdict in HEAD[3:])
