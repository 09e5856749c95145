"""The integer line: exact rounding, polylines, spectrum, rivals."""

from fractions import Fraction
from math import floor, gcd

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tunneller_lib.motion import polyline, rounding_spectrum, tick_counts, time_bresenham

LOW, HIGH = -(2**31), 2**31 - 1
HALF = Fraction(1, 2)
ties = pytest.mark.parametrize("tie", ["up", "down"])
counts = st.integers(-(2**30), 2**30 - 1)


def nearest(exact, tie):
    """Return exact rational numbers rounded to whole ones."""
    return floor(exact + HALF) if tie == "up" else -floor(HALF - exact)


def quotients(whole, ticks, tie):
    """Return whole numbers in an array over ticks, rounded to whole ones."""
    rest = np.array([nearest(Fraction(m, ticks), tie) for m in range(ticks)])
    return whole // ticks + rest[whole % ticks]


@ties
def test_time_bresenham_is_exact_rounding_of_all_short_moves(tie):
    # A start only shifts the line, so one start does for all moves and a sample of them for all.
    for ticks in range(1, 65):
        moves = time_bresenham(0, np.arange(-256, 257), ticks, tie=tie)
        expected = quotients(np.arange(-256, 257)[:, None] * np.arange(ticks + 1), ticks, tie)
        np.testing.assert_array_equal(moves, expected)
        for start in (LOW + 256, -77, -1, 1, 123456, HIGH - 256):
            shifted = time_bresenham(start, start + np.arange(-256, 257), ticks, tie=tie)
            np.testing.assert_array_equal(shifted - start, moves)


@pytest.mark.parametrize("ends", [(0, HIGH), (LOW, -1), (HIGH, 0), (-1, LOW), (7, -8)])
def test_time_bresenham_of_very_many_ticks(ends):
    ticks = 3_000_001
    line = time_bresenham(*ends, ticks)
    slope = Fraction(ends[1] - ends[0], ticks)
    for n in [0, 1, 2, ticks // 2, ticks - 1, ticks, *range(5, ticks, 99_991)]:
        assert line[n] == nearest(ends[0] + n * slope, "up")


@ties
@given(counts, counts, st.integers(1, 300))
def test_time_bresenham_keeps_half_a_count_and_its_ends_there_and_back(tie, start, stop, ticks):
    line = time_bresenham(start, stop, ticks, tie=tie)
    assert (line[0], line[-1], line.dtype) == (start, stop, np.int64)
    twice_off = 2 * (ticks * (line - start) - np.arange(ticks + 1) * (stop - start))
    assert np.max(np.abs(twice_off)) <= ticks and np.ptp(np.diff(line)) <= 1
    np.testing.assert_array_equal(time_bresenham(stop, start, ticks, tie=tie), line[::-1])
    other = {"up": "down", "down": "up"}[tie]
    np.testing.assert_array_equal(time_bresenham(-start, -stop, ticks, tie=other), -line)


@given(st.lists(st.tuples(counts, counts), min_size=2, max_size=9), st.data())
def test_polyline_chains_without_residue(knots, data):
    ticks = data.draw(st.lists(st.integers(1, 40), min_size=len(knots) - 1,
                               max_size=len(knots) - 1))  # fmt: skip
    whole = polyline(knots, ticks)
    pieces = [
        time_bresenham(a, b, n).T for a, b, n in zip(knots[:-1], knots[1:], ticks, strict=True)
    ]
    expected = np.concatenate([piece[:-1] for piece in pieces] + [np.array(knots[-1:])])
    np.testing.assert_array_equal(whole, expected)
    np.testing.assert_array_equal(whole[np.cumsum([0, *ticks])], knots)


@given(st.lists(st.floats(0.0051, 3.0), min_size=1, max_size=200))
def test_tick_counts_do_not_drift(durations):
    times = np.concatenate([[0], np.cumsum(durations)])
    clock = np.concatenate([[0], np.cumsum(tick_counts(times, 0.005))]) * 0.005
    assert np.max(np.abs(clock - times)) <= 0.0025 * (1 + 1e-9)


@pytest.mark.parametrize("ticks", [2, 3, 16, 17, 60, 97])
def test_rounding_spectrum_is_that_of_the_line(ticks):
    for difference in range(-40, 200):
        if gcd(difference, ticks) == 1:
            exact = np.arange(ticks) * Fraction(difference, ticks)
            error = (time_bresenham(0, difference, ticks)[:-1] - exact).astype(float)
            found = np.abs(np.fft.rfft(error)) / ticks
            np.testing.assert_allclose(rounding_spectrum(difference, ticks), found, atol=1e-13)


# ---- wrong input ----------------------------------------------------------------------------


@pytest.mark.parametrize(("call", "said"), [
    (lambda: time_bresenham(LOW, HIGH, 10), r"stop - start: must hold whole numbers from"),
    # 16 GiB were asked for without a word.
    (lambda: time_bresenham(0, 1, HIGH), r"ticks: set-values must be at most 33554432 in all; g"),
    (lambda: polyline([[0], [1]], [2**15], parts=2**16), r"ticks: must be at most 16384 with 655"),
    (lambda: tick_counts([0, 0.01, 0.011], 0.005), r"times: each segment must take at least one t"),
    (lambda: rounding_spectrum(8, 12), r"difference: must have no common factor with 12 ticks; go"),
])  # fmt: skip
def test_moves_refuse_what_does_not_fit_an_array_or_a_controller(call, said):
    with pytest.raises(ValueError, match=f"^{said}"):
        call()
