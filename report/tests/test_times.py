"""The tables of times: rows are kept beside others, shown with three digits; how times grow."""

import pytest

from tests.bench import times

READS = ["tests/bench/*"]

ROW = dict.fromkeys(times.COLUMNS, "some") | {
    "work": "a cut", "each": "ball", "n": 1, "here_s": "2e-05", "peer": "", "peer_s": "",
    "bound_s": "1e-05", "load": "1.5",
}  # fmt: skip


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Return a function that keeps rows in a table of its own, and returns all of them."""
    monkeypatch.setattr(times, "TABLE", tmp_path / "times.csv")

    def keep(*rows):
        times.keep(rows)
        return times.read()

    return keep


def test_keep_puts_a_row_in_the_place_of_the_older_one(kept):
    kept(ROW, ROW | {"n": 1000}, ROW | {"work": "another"})
    rows = kept(ROW | {"here_s": "3e-05"})
    assert [(row["work"], row["n"], row["here_s"]) for row in rows] == [
        ("a cut", "1", "3e-05"), ("a cut", "1000", "2e-05"), ("another", "1", "2e-05")
    ]  # fmt: skip


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
