"""The table of times that `make bench` writes: how its rows are kept, and the page on times.

Each benchmark that calls the fixture `note` gives a row to times.csv, beside those of other
benchmarks and in the place of its own older one. `python -m tests.bench.times` writes the table of
the page anew.
"""

import csv
import io
from pathlib import Path

from report.lists import with_block
from report.sources import ROOT

TABLE = Path(__file__).with_name("times.csv")
PAGE = ROOT / "report" / "guide" / "times.md"
# What was done, to how many at once, and by each in processor time: s here, of the best peer and of
# the bound in C, empty where there is none; what both sides agree in; when and on what it ran.
COLUMNS = (
    "work", "each", "n", "here_s", "peer", "peer_s", "bound_s", "criterion",
    "date", "processor", "versions", "load",
)  # fmt: skip


def read():
    """Return the rows that are kept, dicts of text by `COLUMNS`."""
    if not TABLE.exists():
        return []
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def keep(rows):
    """Keep rows, each in the place of an older one of the same work and number."""
    merged = {(row["work"], int(row["n"])): row for row in [*read(), *rows]}
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    table.writerows(merged[key] for key in sorted(merged))
    TABLE.write_text(text.getvalue(), encoding="utf-8")


def shown(seconds):
    """Return a time in s, as text, for people: three digits and a fitting unit."""
    if not seconds:
        return "–"
    size = float(seconds)
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if size * factor >= 1:
            return f"{_digits(size * factor)} {unit}"
    return f"{_digits(size * 1e9)} ns"


def _digits(size):
    """Return a positive size with three digits, and no power of ten."""
    return f"{size:#.3g}".rstrip(".") if size < 999.5 else f"{size:.0f}"


def markdown(rows):
    """Return the table for the page: of each work the row with the most at once."""
    most = {row["work"]: row for row in sorted(rows, key=lambda row: int(row["n"]))}
    lines = [["work", "at once", "here", "best peer", "C"], ["---", "--:", "--:", "---", "--:"]]
    for row in sorted(most.values(), key=lambda row: row["work"]):
        peer = f"{shown(row['peer_s'])}, {row['peer']}" if row["peer"] else "–"
        work = f"{row['work']}, by the {row['each']}"
        here, bound = shown(row["here_s"]), shown(row["bound_s"])
        lines.append([work, f"{int(row['n']):,}", here, peer, bound])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def with_table(text):
    """Return the page's text with the table between its marks made anew."""
    rows = read()
    ran = sorted({(row["date"], row["processor"]) for row in rows})
    where = "; ".join(f"{date} on {processor}" for date, processor in ran)
    loads = [float(row["load"]) for row in rows]
    where += f", at loads of {min(loads):.0f} to {max(loads):.0f}"
    return with_block(text, "times", f"{markdown(rows)}\n\nRuns: {where}.")


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
