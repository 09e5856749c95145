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


def test_keep_sorts_by_numbers_and_not_by_their_digits(kept):
    rows = kept(*(ROW | {"n": n} for n in (1_000_000, 20, 1000)))
    assert [row["n"] for row in rows] == ["20", "1000", "1000000"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [("", "–"), ("2.5", "2.50 s"), ("0.0123", "12.3 ms"), ("5.93e-09", "5.93 ns"),
     ("0.000172", "172 µs"), ("1e-10", "0.100 ns"), ("3100", "3100 s")],
)  # fmt: skip
def test_shown_has_three_digits_and_a_fitting_unit(seconds, text):
    assert times.shown(seconds) == text


def test_markdown_has_a_line_for_each_work_that_with_the_most_at_once():
    rows = [ROW | {"n": "1000000"}, ROW | {"n": "20"}]
    head, rule, line = times.markdown(rows).splitlines()
    assert head.count("|") == rule.count("|") == line.count("|")
    assert line.startswith("| a cut, by the ball | 1,000,000 | 20.0 µs |")


def test_with_table_changes_nothing_but_what_is_between_its_marks(kept):
    kept(ROW)
    begin, end = "<!-- times: begin -->\n", "<!-- times: end -->\n"
    text = f"before\n{begin}old{end}after\n"
    new = times.with_table(text)
    assert new.startswith(f"before\n{begin}") and new.endswith(f"{end}after\n")
    assert "old" not in new and "| a cut, by the ball |" in new
    assert times.with_table(new) == new


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


def test_growth_is_drawn_from_its_tables(tmp_path):
    growth = pytest.importorskip("tests.bench.growth", reason="matplotlib isn't installed")
    compare = pytest.importorskip("report.compare", reason="the report's packages are missing")
    (tmp_path / "growth.svg").write_bytes(growth.drawing_svg(growth.draw()))
    assert compare.agree(growth.PICTURE, tmp_path / "growth.svg")
