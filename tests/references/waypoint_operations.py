"""Write waypoint_operations.csv: what the waypoints of waypoints.st cost, counted as they run.

    python -m tests.references.waypoint_operations

Sums, products and changes of sign are simple; roots, sines and the like are functions. Neither
indices nor comparisons count.
"""

from contextlib import ExitStack
from pathlib import Path
from unittest.mock import patch

from tests import structured_text
from tests.references import tables
from tests.references.controller_cycles import waypoints_text

TABLE = Path(__file__).with_suffix(".csv")
COLUMNS = ["points", "simple", "divisions", "functions"]
KINDS = {"/": "divisions", **dict.fromkeys(("SQRT", "SIN", "COS", "ATAN2"), "functions"),
         **dict.fromkeys("+-*", "simple")}  # fmt: skip
ENDS = {"ring": 0.08, "tube": 0.8, "thetaP": 0.1, "phiP": 0.2, "thetaQ": 0.7, "phiQ": -0.3}


def counting(kind, operate, done):
    """Return an operation on numbers that tells of what kind it is each time that it is done."""

    def counted(*numbers):
        if isinstance(numbers[0], float):
            done.append(kind)
        return operate(*numbers)

    return counted


def waypoints(points):
    """Return the block of so many waypoints; its text is parsed once, for a thousand."""
    return structured_text.FunctionBlock(waypoints_text(1000), {"999": str(points - 1)})


def rows():
    """Yield the rows of the table, a segment of so many points each."""
    for points in (3, 9, 32):
        done = []
        with ExitStack() as stack:
            for table in (structured_text.OPERATORS, structured_text.FUNCTIONS):
                known = table.keys() & KINDS
                stack.enter_context(
                    patch.dict(
                        table, {key: counting(KINDS[key], table[key], done) for key in known}
                    )
                )
            waypoints(points)(**ENDS)
        yield [points, *map(done.count, COLUMNS[1:])]


if __name__ == "__main__":
    tables.write(TABLE, COLUMNS, rows())
