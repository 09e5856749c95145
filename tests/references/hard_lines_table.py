"""Write hard_lines.csv.gz: lines against solids, with exact answers.

    python -m tests.references.hard_lines_table

The shapes and lines are those of `tests.hard_lines`, the answers of `exhibits.exact_shapes`.
"""

import csv
import gzip
import io
from pathlib import Path

import numpy as np

from exhibits.exact_shapes import EPS, exact_interval, exact_intervals
from tests import hard_lines as lines

TABLE = Path(__file__).with_name("hard_lines.csv.gz")
SEED = 23
# Whole numbers take little room in the file, those of full mantissa a lot.
ROWS = {family: 55 if family in (lines.leaning, lines.floats, lines.proportions, lines.sizes,
                                  lines.ordinary, lines.scaled, lines.far, lines.from_far)
        else 200 if family is lines.limits else 655 for family in lines.FAMILIES}  # fmt: skip
SHAPE = [f"s{i}" for i in range(1, 13)]
LINE = ["px", "py", "pz", "ux", "uy", "uz"]
COLUMNS = ["kind", "family", *SHAPE, *LINE, "enter", "leave", "depth", "give", "give_single"]
SINGLE = 2.0**-23


def size_of(kind, shape):
    """Return the size of a shape (12,), in m.

    The wider radius and the length, or a box's diagonal.
    """
    if kind == "box":
        return float(np.linalg.norm(shape[3:]))
    return float(max(shape[6:8]) + np.linalg.norm(shape[3:6] - shape[:3]))


def depth(kind, shape, p, u, size):
    """Return how deep a line goes into a shape, in m, or how far it misses it as a negative one.

    That is the margin by which the shape may shrink, or must grow, until the line touches it; to
    two digits, towards zero, and zero below 1e-20 of the size.
    """
    sign = -1 if exact_interval(kind, shape, p, u) is None else 1

    def still(margin):
        return (exact_interval(kind, shape, p, u, -sign * margin) is not None) == (sign > 0)

    low, high = -20.0, 3.0
    if not still(10.0**low * size):
        return 0.0
    while high - low > 0.005:
        middle = (low + high) / 2
        low, high = (middle, high) if still(10.0**middle * size) else (low, middle)
    return sign * 10.0**low * size


def gives(kind, shapes, p, u, sizes, eps):
    """Return how far the ends (n,) move, in the parameter, if the surface moves 64 eps of size."""
    enter, leave = exact_intervals(kind, shapes, p, u)
    moved = [exact_intervals(kind, shapes, p, u, sign * 64 * eps * sizes) for sign in (-1, 1)]
    # What shrinks to nothing may end anywhere in the exact interval, or where that is empty too,
    # anywhere in the grown one.
    with np.errstate(invalid="ignore"):
        least, most = moved
        gone = least[0] > least[1]
        most_of = np.maximum(enter - most[0], most[1] - leave)
        least_of = np.where(gone, leave - enter, np.maximum(least[0] - enter, leave - least[1]))
    return np.where(enter <= leave, np.maximum(most_of, least_of), 0.0)


def rounded_up(number):
    """Return a number as a text of two digits that isn't below it."""
    return f"{1.06 * number:.1e}"


def rows(kind, family, rng, only=None):
    """Yield the rows of one family as texts, all or only so many."""
    shapes, p, u = (part[:only] for part in family(kind, rng, ROWS[family]))
    sizes = np.array([size_of(kind, shape) for shape in shapes])
    ends = exact_intervals(kind, shapes, p, u)
    double = gives(kind, shapes, p, u, sizes, EPS)
    single = gives(kind, shapes, p, u, sizes, SINGLE)
    for i in range(len(shapes)):
        line = shapes[i].tolist(), p[i].tolist(), u[i].tolist()
        numbers = [number for part in line for number in part] + ends[:, i].tolist()
        deep = depth(kind, shapes[i], p[i], u[i], sizes[i])
        numbers = [f"{number:.17g}" for number in numbers]
        numbers = [min(text, repr(float(text)).removesuffix(".0"), key=len) for text in numbers]
        yield [kind, family.__name__, *numbers, f"{deep:.1e}" if deep else "0",
               rounded_up(double[i]), rounded_up(single[i])]  # fmt: skip


def main():
    """Write the table, the same bytes each time."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for kind in lines.KINDS:
        for number, family in enumerate(lines.FAMILIES):
            rng = np.random.default_rng([SEED, lines.KINDS.index(kind), number])
            writer.writerows(rows(kind, family, rng))
    with open(TABLE, "wb") as file, gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
        packed.write(text.getvalue().encode())


if __name__ == "__main__":
    main()
