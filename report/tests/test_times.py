"""The tables of times: what many answers cost grows no faster than their number."""

import pytest

from tests.bench import times

READS = ["tests/bench/*"]

GROWN = (
    1.25  # of what one of many takes, over one of fewer; n log n would give 2.3 from 10^3 to 10^7
)


def test_geodesics_take_time_and_memory_in_proportion_to_their_number():
    growth = pytest.importorskip("tests.bench.growth", reason="matplotlib isn't installed")
    pairs, seconds, memory = growth.growth()
    assert pairs == [10.0**power for power in range(8)]
    for sizes, least in ((seconds, 1e3), (memory, 1e4)):
        each = [size / n for n, size in zip(pairs, sizes, strict=True) if n >= least]
        assert all(more <= GROWN * min(each[:i]) for i, more in enumerate(each) if i)
    assert memory[-1] <= growth.LIMIT * pairs[-1]


def test_more_at_once_takes_less_time_for_each():
    by_work = {}
    for row in times.read():
        by_work.setdefault(row["work"], []).append(float(row["here_s"]))
    for work, (first, *others) in by_work.items():
        assert all(each <= GROWN * first for each in others), work
