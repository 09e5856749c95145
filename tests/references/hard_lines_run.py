"""Write hard_lines_run.csv: a million hard lines against the library, each judged exactly.

    python -m tests.references.hard_lines_run

New draws of the families of `tests.hard_lines`, a quarter of an hour of one processor.
"""

import csv
from pathlib import Path

import numpy as np

from exhibits.exact_shapes import judged
from tests.hard_lines import FAMILIES, KINDS, meet

TABLE = Path(__file__).with_suffix(".csv")
COLUMNS = ["kind", "family", "lines", "met", "missed", "thin", "thick"]
LINES = 2100  # drawn at once, of each kind and family
BLOCKS = 8
SEED = 2026


def counts(kind, family):
    """Return how many lines of a family are drawn, met, missed, thin and thick."""
    total = np.zeros(5, dtype=int)
    for block in range(BLOCKS):
        rng = np.random.default_rng([SEED, KINDS.index(kind), FAMILIES.index(family), block])
        lines = family(kind, rng, LINES)
        found = meet(kind, *lines)
        wrong = [np.count_nonzero(each) for each in judged(found, kind, *lines)]
        total += [LINES, np.count_nonzero(found[0] <= found[1]), *wrong]
    return total.tolist()


def main():
    """Write the table, a row as soon as it's known."""
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for kind in KINDS:
            for family in FAMILIES:
                writer.writerow([kind, family.__name__, *counts(kind, family)])
                file.flush()


if __name__ == "__main__":
    main()
