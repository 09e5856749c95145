"""A second opinion on the report's numbers: each is computed anew, without the library.

A test takes its formula from a textbook or from first principles and imports nothing of ours; what
it finds must round to the digits that the report prints.
"""

import json
from decimal import Decimal
from pathlib import Path

import pytest

NUMBERS = Path(__file__).resolve().parents[2] / "report" / "numbers"


@pytest.fixture
def printed():
    """Return a function that finds what the report prints: a number, or a cell of a table.

    A number by its chapter and name; a cell by the table's name, the row's number or first entry
    and the column. It equals what is at most half of its last printed digit away.
    """

    def find(chapter, name, row=None, column=None):
        recorded = json.loads((NUMBERS / f"{chapter}.json").read_text())
        if row is None:
            entry = recorded["numbers"][name]
            value, text = entry["value"], entry["text"]
        else:
            table = recorded["tables"][name]
            first = [cells[0] for cells in table["text"]]
            at = row if isinstance(row, int) else first.index(row)
            k = table["columns"].index(column)
            value, text = table["rows"][at][k], table["text"][at][k]
        last = 10.0 ** Decimal(text.replace("−", "-")).as_tuple().exponent
        return pytest.approx(value, rel=0, abs=last / 2)

    return find


@pytest.fixture(autouse=True)
def _own(request):
    """Fail where a module of second opinions has taken something of ours."""
    for thing in vars(request.module).values():
        home = getattr(thing, "__module__", None) or getattr(thing, "__name__", "")
        assert home.partition(".")[0] not in ("tunneller_lib", "kit", "exhibits"), home
