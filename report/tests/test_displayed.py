"""Where displays stand: equations in the order of report/equations.toml, figures by the ledger."""

import re
import tomllib

import pytest

from report.sources import ROOT
from tests.verdicts import DOCUMENTS, ledger

READS = ["report/equations.toml", "report/ledger/*", "report/*.typ"]

EQUATIONS = tomllib.loads((ROOT / "report" / "equations.toml").read_text(encoding="utf-8"))
LEDGER = {id: row for document in DOCUMENTS for id, row in ledger(document).items()}
SOURCES = {
    path: path.read_text(encoding="utf-8")
    for path in [
        *(ROOT / "report" / f"{name}.typ" for name in ("report", "supplement")),
        *(ROOT / "report" / "sections").glob("*.typ"),
    ]
}


def in_order():
    """Return the sections' texts as the supplement includes them."""
    names = re.findall(r'#include "([^"]+)"', SOURCES[ROOT / "report" / "supplement.typ"])
    return [SOURCES[ROOT / "report" / name] for name in names]


def test_every_equation_stands_in_the_supplement_once_and_in_its_order():
    uses = re.findall(r'#(?:judged|displayed)\("([^"]+)"\)', "\n".join(in_order()))
    assert uses == list(EQUATIONS)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_no_display_is_set_by_hand(path):
    text = re.sub(r"\\.|//[^\n]*|`[^`]*`", "", SOURCES[path])
    formulas = text.split("$")[1::2]
    assert text.count("$") % 2 == 0
    assert [f for f in formulas if f[:1].isspace() and f[-1:].isspace()] == []
    assert "math.equation" not in text


@pytest.mark.parametrize("id", re.findall(r'#judged\("([^"]+)"\)', "".join(SOURCES.values())))
def test_judged_equation_has_the_number_of_its_row(id):
    where = LEDGER[EQUATIONS[id].get("row", id)]["where"]
    first, _, last = re.search(r"\bEqs?\.? (\d+)( (?:to|and) (\d+))?", where).groups()
    assert int(first) <= int(id[-2:]) <= int(last or first)


def parts(place):
    return set(place.split(", "))


# What a document's figure, table or listing is called where it stands here, and by its rows.
SOURCE = re.compile(r'\bsource: "([^"]+)"|#unsourced\("([^"]+)"')
SUPPLEMENT = "".join(text for path, text in SOURCES.items() if path.stem != "report")
FOUND = {one or other for one, other in SOURCE.findall(SUPPLEMENT)}


@pytest.mark.parametrize("source", sorted(FOUND))
def test_what_stands_in_the_concordance_has_a_row(source):
    assert any(parts(source) <= parts(row["where"]) for row in LEDGER.values())


def shown(place):
    """Return whether a part of a place is a figure, a table or a listing."""
    return bool(re.fullmatch(r"Fig\. \d+|diagram|table|listing", place))


@pytest.mark.parametrize(
    "id", [id for id, row in LEDGER.items() if any(map(shown, parts(row["where"])))]
)
def test_figures_tables_and_listings_stand_in_the_concordance(id):
    assert any(parts(source) <= parts(LEDGER[id]["where"]) for source in FOUND)
