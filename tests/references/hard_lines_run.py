"""Write hard_lines_run.csv: a million hard lines against the library, each judged exactly.

    python -m tests.references.hard_lines_run

New draws of the families of `tests.hard_lines`, a quarter of an hour of one processor.
"""

from itertools import product
from pathlib import Path

import numpy as np

from exhibits.exact_shapes import judged
from tests.hard_lines import FAMILIES, KINDS, meet
from tests.references import tables

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


if __name__ == "__main__":
    tables.write(
        TABLE, COLUMNS, ([k, f.__name__, *counts(k, f)] for k, f in product(KINDS, FAMILIES))
    )
