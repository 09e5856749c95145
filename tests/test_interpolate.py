"""The integer line: exact rounding, its recurrence, polylines, parabolas, spectrum, rivals."""

import sys
from fractions import Fraction
from itertools import islice
from math import floor, gcd

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exhibits.interpolators import INTERPOLATORS, listing
from tunneller_lib.motion import (
    polyline,
    polyline_slopes,
    rounding_spectrum,
    tick_counts,
    time_bresenham,
)
from tunneller_lib.motion.interpolate import line_ticks
from tunneller_lib.motion.ramp import rest_to_rest, rest_to_rest_ticks

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


@ties
def test_line_ticks_are_the_closed_form_of_all_short_moves(tie):
    for ticks in range(1, 65):
        moves = time_bresenham(-9, np.arange(-256, 257) - 9, ticks, tie=tie)
        for difference in range(-256, 257):
            assert list(line_ticks(-9, difference - 9, ticks, tie=tie)) == moves[
                difference + 256].tolist()  # fmt: skip


@ties
def test_time_bresenham_of_ten_thousand_long_moves(tie):
    ends = np.random.default_rng(4).integers(-(2**30), 2**30, (19, 550, 2))
    for ticks, (start, stop) in enumerate(np.moveaxis(ends, -1, 1), 1):
        lines = time_bresenham(start, stop, ticks, tie=tie)
        expected = quotients((stop - start)[:, None] * np.arange(ticks + 1), ticks, tie)
        np.testing.assert_array_equal(lines, start[:, None] + expected)
        for one, other, line in zip(start.tolist(), stop.tolist(), lines.tolist(), strict=True):
            assert line == list(line_ticks(one, other, ticks, tie=tie))


@pytest.mark.parametrize("ends", [(0, HIGH), (LOW, -1), (HIGH, 0), (-1, LOW), (7, -8)])
def test_time_bresenham_of_very_many_ticks(ends):
    ticks = 3_000_001
    line = time_bresenham(*ends, ticks)
    slope = Fraction(ends[1] - ends[0], ticks)
    for n in [0, 1, 2, ticks // 2, ticks - 1, ticks, *range(5, ticks, 99_991)]:
        assert line[n] == nearest(ends[0] + n * slope, "up")


@ties
@given(counts, counts, st.integers(1, 300))
def test_time_bresenham_keeps_half_a_count_and_its_ends(tie, start, stop, ticks):
    line = time_bresenham(start, stop, ticks, tie=tie)
    assert (line[0], line[-1], line.dtype) == (start, stop, np.int64)
    twice_off = 2 * (ticks * (line - start) - np.arange(ticks + 1) * (stop - start))
    assert np.max(np.abs(twice_off)) <= ticks
    steps = np.diff(line)
    assert np.ptp(steps) <= 1


@ties
@given(counts, counts, st.integers(1, 300))
def test_time_bresenham_retraces_a_reversed_move(tie, start, stop, ticks):
    there = time_bresenham(start, stop, ticks, tie=tie)
    back = time_bresenham(stop, start, ticks, tie=tie)
    np.testing.assert_array_equal(back, there[::-1])


@given(counts, counts, st.integers(1, 300))
def test_time_bresenham_ties_mirror_each_other(start, stop, ticks):
    up = time_bresenham(start, stop, ticks)
    np.testing.assert_array_equal(time_bresenham(-start, -stop, ticks, tie="down"), -up)


def test_time_bresenham_is_a_drawn_line_where_an_axis_takes_every_step():
    # The line of 1965, in the first octant: x is the cardinal axis and moves by one.
    for dx, dy in [(10, 3), (7, 7), (12, 5), (9, 0)]:
        decision, y, drawn = 2 * dy - dx, 0, []
        for _ in range(dx + 1):
            drawn.append(y)
            if decision >= 0:
                y, decision = y + 1, decision - 2 * dx
            decision += 2 * dy
        x, line = time_bresenham([0, 0], [dx, dy], dx)
        assert (x.tolist(), line.tolist()) == (list(range(dx + 1)), drawn)


def test_time_bresenham_broadcasts_and_leaves_its_arguments():
    start, stop = np.array([[0], [5]]), np.array([10, -3, 7])
    kept = start.copy(), stop.copy()
    lines = time_bresenham(start, stop, 6)
    assert lines.shape == (2, 3, 7)
    np.testing.assert_array_equal(lines[1, 2], time_bresenham(5, 7, 6))
    assert all(np.array_equal(a, b) for a, b in zip((start, stop), kept, strict=True))
    small = time_bresenham(np.int8(-100), np.int8(100), np.int32(1))
    assert small.tolist() == [-100, 100]


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


def test_polyline_slopes_lead_from_knot_to_knot():
    knots, ticks = np.array([[0, 5], [7, -9], [7, 0], [-30, 2]]), [3, 5, 8]
    slopes = polyline_slopes(knots, ticks)
    assert slopes.shape == (16, 2)
    np.testing.assert_allclose(
        np.cumsum(slopes, axis=0)[np.cumsum(ticks) - 1], knots[1:] - knots[0]
    )
    assert np.all(np.abs(np.diff(polyline(knots, ticks), axis=0) - slopes) < 1)


@given(st.lists(st.floats(0.0051, 3.0), min_size=1, max_size=200))
def test_tick_counts_do_not_drift(durations):
    times = np.concatenate([[0], np.cumsum(durations)])
    clock = np.concatenate([[0], np.cumsum(tick_counts(times, 0.005))]) * 0.005
    assert np.max(np.abs(clock - times)) <= 0.0025 * (1 + 1e-9)


def exact_parabola(start, stop, ticks):
    values = []
    for n in range(ticks + 1):
        share = Fraction(2 * n * n, ticks**2) if 2 * n <= ticks else (
            1 - Fraction(2 * (ticks - n) ** 2, ticks**2))  # fmt: skip
        values.append(nearest(start + share * (stop - start), "up"))
    return values


@given(counts, counts, st.integers(1, 60).map(lambda m: 2 * m))
def test_rest_to_rest_is_the_exact_parabola_rounded(start, stop, ticks):
    expected = exact_parabola(start, stop, ticks)
    assert rest_to_rest(start, stop, ticks).tolist() == expected
    assert list(rest_to_rest_ticks(start, stop, ticks)) == expected


@pytest.mark.parametrize("ends", [(LOW, -1), (0, HIGH), (HIGH, 0), (3, 3), (0, 1), (0, -1)])
def test_rest_to_rest_of_the_longest_ramp(ends):
    ramp = rest_to_rest(*ends, 65534)
    assert ramp.tolist() == list(rest_to_rest_ticks(*ends, 65534))
    assert (ramp[0], ramp[-1]) == ends
    n = 12345
    exact = ends[0] + Fraction(2 * n * n, 65534**2) * (ends[1] - ends[0])
    assert ramp[n] == nearest(exact, "up")


def farthest(ticks):
    """Return the largest whole number that a generator's functions hold while it runs."""
    largest = 0

    def watch(frame, event, _):
        nonlocal largest
        if "motion" in frame.f_code.co_filename:
            for held in frame.f_locals.values():
                for number in held if isinstance(held, tuple) else (held,):
                    largest = max(largest, abs(number) if type(number) is int else 0)
        return watch

    before = sys.gettrace()
    sys.settrace(watch)
    try:
        list(islice(ticks, 700))
    finally:
        sys.settrace(before)
    return largest


@pytest.mark.parametrize("call", [line_ticks, rest_to_rest_ticks])
@pytest.mark.parametrize("ends", [(LOW, -1), (0, HIGH), (HIGH, 0), (-1, LOW), (0, 7)])
@pytest.mark.parametrize("ticks", [2, 100, 65532, 65534])
def test_moves_tick_by_tick_stay_within_32_bits(call, ends, ticks):
    assert farthest(call(*ends, ticks)) <= HIGH + 1


def test_rest_to_rest_broadcasts():
    ramps = rest_to_rest([[0], [100]], [50, -50, 0], 10)
    assert ramps.shape == (2, 3, 11)
    np.testing.assert_array_equal(ramps[1, 2], rest_to_rest(100, 0, 10))


@pytest.mark.parametrize("ticks", [2, 3, 16, 17, 60, 97])
def test_rounding_spectrum_is_that_of_the_line(ticks):
    for difference in range(-40, 200):
        if gcd(difference, ticks) == 1:
            exact = np.arange(ticks) * Fraction(difference, ticks)
            error = (time_bresenham(0, difference, ticks)[:-1] - exact).astype(float)
            found = np.abs(np.fft.rfft(error)) / ticks
            np.testing.assert_allclose(rounding_spectrum(difference, ticks), found, atol=1e-13)


# ---- the rivals -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", INTERPOLATORS)
def test_rivals_have_one_interface(name):
    starts, stops = np.array([0, 5, 30, -7]), np.array([100, 30, 5, -7])
    lines = INTERPOLATORS[name](starts, stops, 50)
    assert lines.shape == (4, 51)
    np.testing.assert_array_equal(lines[:, 0], starts)
    for line, start, stop in zip(lines, starts, stops, strict=True):
        np.testing.assert_array_equal(INTERPOLATORS[name](start, stop, 50), line)


def worst(name, difference, ticks):
    exact = np.arange(ticks + 1) * (difference / ticks)
    return np.max(np.abs(INTERPOLATORS[name](0, difference, ticks) - exact))


def test_rivals_err_as_their_kind_does():
    difference, ticks = 20_011, 60_000
    assert worst("integer line", difference, ticks) <= 0.5
    assert worst("listing", difference, ticks) < 0.5 + 1e-6
    assert 0.9 < worst("floor of the line", difference, ticks) < 1
    assert worst("whole slope only", difference, ticks) == difference
    # A slope in steps of 2^-16 counts is off by up to half a step, cut off by up to a whole one.
    assert worst("Q16.16, rounded", difference, ticks) < 0.5 + ticks / 2**17 + 1e-9
    assert worst("Q16.16, truncated", difference, ticks) < 1 + ticks / 2**16 + 1e-9
    for rival in ("DDA, single precision", "listing, single precision"):
        assert worst(rival, difference, ticks) > worst(rival, difference // 60, ticks // 60)
    assert worst("DDA, single precision", difference, ticks) > 3


def test_listing_in_exact_arithmetic_is_the_line_with_ties_down():
    def exact_listing(start, stop, ticks):
        slope = Fraction(stop - start, ticks)
        y, e = start, Fraction(0)
        for _ in range(ticks + 1):
            if e > HALF:
                y, e = y + 1, e - 1
            yield y
            y, e = y + floor(slope), e + slope - floor(slope)

    for ticks in range(1, 40):
        for difference in range(-60, 61):
            line = time_bresenham(3, 3 + difference, ticks, tie="down").tolist()
            assert list(exact_listing(3, 3 + difference, ticks)) == line


def test_listing_has_the_last_sample_that_rounding_would_put_off():
    assert 1000.4 - 1000.1 < 0.3
    assert listing(1000.1, 1000.4, 0, 3, 0.1)[0].size == 4


def test_listing_in_double_precision_is_mildly_wrong():
    moves = time_bresenham(0, np.arange(-200, 201), 30, tie="down")
    found = INTERPOLATORS["listing"](0, np.arange(-200, 201), 30)
    assert 0 < np.mean(found != moves) < 0.1
    assert np.max(np.abs(found - moves)) == 1  # a tie that rounding errors tip over


# ---- wrong input ----------------------------------------------------------------------------


@pytest.mark.parametrize("ticks", [0, -1, 2**31, 1.0, "2", None, [1, 2], True], ids=repr)
@pytest.mark.parametrize("call", [time_bresenham, rest_to_rest])
def test_ticks_must_be_one_whole_number(call, ticks):
    with pytest.raises(ValueError, match=r"^ticks: must .*; got .*\.$"):
        call(0, 10, ticks)


@pytest.mark.parametrize("value", [0.5, 2.0, np.nan, "1", None, 2**31, LOW - 1, 10**30], ids=repr)
@pytest.mark.parametrize("call", [time_bresenham, rest_to_rest])
def test_counts_must_be_whole_and_of_32_bits(call, value):
    with pytest.raises(ValueError, match=r"^start: must hold whole numbers from -2147483648"):
        call(value, 0, 10)
    with pytest.raises(ValueError, match=r"^stop: must hold whole numbers from -2147483648"):
        call(0, value, 10)


def test_a_difference_beyond_32_bits_is_refused():
    for ends in [(LOW, 0), (-1, HIGH), (LOW, HIGH)]:
        if not LOW <= ends[1] - ends[0] <= HIGH:
            with pytest.raises(ValueError, match=r"^stop - start: must hold whole numbers"):
                time_bresenham(*ends, 10)
    with pytest.raises(ValueError, match=r"^knots\[1:\] - knots\[:-1\]: must"):
        polyline([[LOW], [HIGH]], [5])


def test_more_set_values_than_an_array_may_hold_are_refused():
    # 16 GiB were asked for without a word.
    for call in (lambda: time_bresenham(0, 1, HIGH), lambda: polyline([[0], [1]], [HIGH]),
                 lambda: time_bresenham(0, np.zeros(1000, int), 10**5),
                 lambda: polyline(np.zeros((3, 2000), int), [10_000, 10_000]),
                 lambda: polyline_slopes([[0], [1]], [HIGH])):  # fmt: skip
        with pytest.raises(
            ValueError,
            match=r"^ticks: .* at most 33554432 in all, and `motion.interpolate.line_tick",
        ):
            call()
    with pytest.raises(
        ValueError, match=r"^ticks: .* and `motion.ramp.rest_to_rest_ticks` yields them"
    ):
        rest_to_rest(0, np.zeros(1000, int), 65534)
    assert list(islice(line_ticks(0, 1, HIGH), 3)) == [0, 0, 0]


def test_ramps_refuse_odd_and_too_many_ticks():
    for ticks in (3, 65536):
        with pytest.raises(ValueError, match=r"^ticks: must"):
            rest_to_rest(0, 10, ticks)


def test_polylines_refuse_what_does_not_fit():
    for knots, ticks in [([[0], [1]], [1, 2]), ([0, 1], [1]), ([[0]], []), ([[0], [1]], 3)]:
        with pytest.raises(ValueError, match=r"^(knots|ticks): must"):
            polyline(knots, ticks)
    with pytest.raises(ValueError, match=r"segments; got \(3, 2\) for \(3,\)\.$"):
        polyline(np.zeros((3, 2), int), [1, 2, 3])
    with pytest.raises(ValueError, match=r"^ticks: must hold whole numbers from 1"):
        polyline([[0], [1]], [0])
    with pytest.raises(ValueError, match=r'^tie: must be "up" or "down"; got'):
        time_bresenham(0, 1, 1, tie=["up"])


def test_tick_counts_refuse_times_that_do_not_ascend():
    for times in ([0, 0.01, 0.011], [0, 1, 0.5], [1.0], 3.0, [0, np.nan]):
        with pytest.raises(ValueError, match=r"^times: "):
            tick_counts(times, 0.005)
    for tick in (0, -1, np.inf):
        with pytest.raises(ValueError, match=r"^tick: must be one finite number above zero"):
            tick_counts([0, 1], tick)


def test_rounding_spectrum_refuses_a_common_factor():
    with pytest.raises(ValueError, match=r"difference: must have no common factor with 12 ticks"):
        rounding_spectrum(8, 12)


@pytest.mark.parametrize("difference", [-32_001, -7, 1, 2, 31_999])
@pytest.mark.parametrize("ticks", [3, 7, 1000])
def test_fixed_point_slopes_are_rounded_or_cut_off(difference, ticks):
    slope = Fraction(difference, ticks) * 2**16
    for name, step, half in (
        ("Q16.16, rounded", floor(slope + Fraction(1, 2)), 2**15),
        ("Q16.16, truncated", floor(slope), 0),
    ):
        expected = [(n * step + half) >> 16 for n in range(ticks + 1)]
        found = INTERPOLATORS[name](-5, difference - 5, ticks)
        assert (found + 5).tolist() == expected


@pytest.mark.parametrize("call", [time_bresenham, rest_to_rest])
def test_moves_that_do_not_broadcast_are_refused(call):
    with pytest.raises(
        ValueError, match=r"^start, stop: .* must broadcast|^\w+: must broadcast with"
    ):
        call([0, 1], [1, 2, 3], 10)


@pytest.mark.parametrize("call", [line_ticks, rest_to_rest_ticks])
def test_moves_tick_by_tick_are_of_one_axis(call):
    with pytest.raises(ValueError, match=r"^stop: must be one whole number from -2147483648 to"):
        list(call(0, [1, 2], 10))
    with pytest.raises(ValueError, match=r"^start: must be one whole number from -2147483648 to"):
        list(call([0, 1], [1, 2, 3], 10))
