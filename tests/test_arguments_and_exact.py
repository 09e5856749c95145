"""Validation, and the arithmetic that keeps digits, judged in fractions and by mpmath."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp, mpf

from tests.shapes import EPS
from tunneller_lib import arguments
from tunneller_lib.kernels import exact

numbers = st.floats(-1e9, 1e9).map(lambda x: round(x, 60))
vectors = st.tuples(*[numbers] * 3)


@pytest.mark.parametrize(
    "value", [1, 1.5, True + 1, [1, 2], [[1.0]], [], np.nan, [np.inf], np.float32(2)]
)
def test_real_takes_numbers_of_any_shape(value):
    found = arguments.real("x", value)
    assert found.dtype == float and found.shape == np.shape(value)


def test_real_does_not_copy_what_is_float_already():
    value = np.ones(3)
    assert arguments.real("x", value) is value


class Column:
    """What pandas' columns of numbers that may be missing are to numpy: arrays of objects."""

    def __init__(self, *values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype or object)


MISSING = type("MISSING", (), {"__bool__": lambda self: [][0]})()  # no number, as pandas' NA


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (Column(1, 2), [1, 2]),
        (Column(1.5, np.float64(2)), [1.5, 2]),
        (Column(np.int64(7), 8.5), [7, 8.5]),
        (Column(), []),
        (Column([1, 2], [3, 4]), [[1, 2], [3, 4]]),
        (np.ma.masked_array([1.0, 2.0]), [1.0, 2.0]),
        (np.ma.masked_array([1, 2], [False, False]), [1, 2]),
    ],
)
def test_numbers_that_might_be_missing_pass_where_none_is(value, expected):
    found = arguments.real("x", value)
    assert type(found) is np.ndarray and found.dtype == float
    np.testing.assert_array_equal(found, expected)
    if np.asarray(expected).dtype.kind == "i":
        np.testing.assert_array_equal(arguments.whole("x", value, 0, 9), expected)


@pytest.mark.parametrize(
    "value",
    [
        Column(1, MISSING), Column(1, None), Column(True, 2), Column("1", 2), Column(1j),
        Column(1, [2]), Column(10**400), np.ma.masked_array([1.0, 2.0], [False, True]),
    ],
)  # fmt: skip
def test_a_missing_number_is_refused(value):
    with pytest.raises(ValueError, match=r"^x: must hold real numbers in a regular array; got "):
        arguments.real("x", value)
    with pytest.raises(ValueError, match=r"^x: must hold whole numbers from 0 to 9; got "):
        arguments.whole("x", value, 0, 9)


@given(numbers, numbers)
def test_two_product_is_error_free(a, b):
    product, lost = map(Fraction, map(float, exact.two_product(a, b)))
    assert product + lost == Fraction(a) * Fraction(b)


@given(numbers, numbers)
def test_two_sum_is_error_free(a, b):
    total, lost = map(Fraction, map(float, exact.two_sum(a, b)))
    assert total + lost == Fraction(a) + Fraction(b)


@given(numbers, numbers, numbers, st.integers(-4, 4))
def test_difference_of_products_keeps_its_digits(a, b, c, ulps):
    assume(a and b and c)
    d = a * b / c
    d += ulps * float(np.spacing(d))  # a b and c d agree to a few roundings
    truth = Fraction(a) * Fraction(b) - Fraction(c) * Fraction(d)
    found = Fraction(float(exact.difference_of_products(a, b, c, d)))
    least = Fraction(EPS) ** 2 * (abs(Fraction(a) * Fraction(b)) + abs(Fraction(c) * Fraction(d)))
    assert abs(found - truth) <= Fraction(2 * EPS) * abs(truth) + 2 * least


@given(vectors, vectors)
def test_cross_keeps_its_digits(a, b):
    (ax, ay, az), (bx, by, bz) = (map(Fraction, v) for v in (a, b))
    truth = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    found = exact.cross(np.array(a), np.array(b))
    np.testing.assert_allclose(found, [float(c) for c in truth], rtol=4 * EPS, atol=1e-14)


@given(vectors, vectors)
def test_dot_is_right_to_three_roundings_of_its_terms_and_norm_to_four(a, b):
    terms = [Fraction(x) * Fraction(y) for x, y in zip(a, b, strict=True)]
    found = Fraction(float(exact.dot(np.array(a), np.array(b))))
    least = 3 * Fraction(5e-324)  # where products leave the range of normal numbers
    assert abs(found - sum(terms)) <= 3 * Fraction(EPS) * sum(map(abs, terms)) + least
    assert exact.norm(np.array(a)) == pytest.approx(float(np.linalg.norm(a)), rel=4 * EPS)


@pytest.mark.parametrize("scale", [1e-3, 1, 1e6])
@pytest.mark.parametrize("gap", [0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1, 1e3, 1e6])
def test_radius_and_excess_against_mpmath(scale, gap):
    rng = np.random.default_rng(0)
    with mp.workdps(40):
        for r, angle, side in zip(
            scale * rng.uniform(1, 4, 200),
            rng.uniform(-4, 4, 200),
            rng.choice([-1, 1], 200),
            strict=True,
        ):
            reach = r * abs(1 + side * gap)
            x, z = reach * np.cos(angle), reach * np.sin(angle)
            rho = mp.sqrt(mpf(x) ** 2 + mpf(z) ** 2)
            found, excess = exact.radius_and_excess(x, z, np.float64(r))
            assert abs(found - rho) <= 2 * EPS * rho
            assert abs(excess - (rho - mpf(r))) <= 8 * EPS * abs(rho - mpf(r)) + 1e-22 * r


@pytest.mark.parametrize("value", [0.0, 1e-100, -1.0, 1e100])
def test_sizes_and_near_points_take_what_has_a_square(value):
    arguments.sizes("x", value)
    assert arguments.near_points("x", [value] * 3).tolist() == [value] * 3


@pytest.mark.parametrize("value", [9e-101, -9e-101, 2e100, 1e-320])
def test_sizes_and_near_points_refuse_what_has_none(value):
    with pytest.raises(ValueError, match=r"^x: must be zero or from 1e-100 to 1e[+]100 in size, "):
        arguments.sizes("x", np.array([1.0, value]))
    if abs(value) > 1:
        with pytest.raises(ValueError, match=r"^x: must hold numbers of at most 1e[+]100 in size"):
            arguments.near_points("x", [1.0, 0, value])


def test_function_that_takes_other_arguments_is_refused():
    @arguments.checked
    def tell(say: Callable[[str], object]):
        return say("a")

    assert tell(str.upper) == "A" and tell(lambda text, times=2: times * text) == "aa"
    assert tell(print) is None  # written in C, or of any arguments
    for other in (lambda: 0, lambda text, times: 0, lambda *, text: 0):
        with pytest.raises(ValueError, match=r"^say: must be a function of 1 argument; got <"):
            tell(other)
    with pytest.raises(ValueError, match=r"^say: must be a function; got 'a'\.$"):
        tell("a")


@pytest.mark.parametrize(
    ("given", "options", "why"),
    [
        ((1, 2, 3), {}, "too many positional"),  # the third is an option, given by name only
        ((1,), {"x": 2}, "multiple values"),
        ((), {"y": 2}, "missing"),
        ((1,), {"z": 2}, "unexpected"),
    ],
)
def test_checked_call_refuses_what_the_function_itself_would(given, options, why):
    @arguments.checked
    def add(x: arguments.Reals, y: arguments.Reals = 0, *, scale: arguments.Finite = 1):
        return scale * (x + y)

    assert add(1, 2, scale=3) == add(y=2, scale=3, x=1) == 9
    with pytest.raises(TypeError, match=why):
        add(*given, **options)


@pytest.mark.parametrize("rows", [0, 1, 8192, 8193, 30_000])
def test_blocks_that_fit_the_cache_hold_all_rows_in_order(rows):
    sizes = []

    def double(block):
        sizes.append(len(block))
        return 2 * block

    given = np.arange(3.0 * rows).reshape(rows, 3)
    np.testing.assert_array_equal(exact.in_blocks(double, given, given.shape[-1]), 2 * given)
    assert max(sizes, default=0) * 3 * 8 <= 2**18  # a quarter of a MiB, of rows of three


@pytest.mark.parametrize("axes", [4, 8, 64])
def test_array_of_many_axes_is_shown_by_its_shape(axes):
    """At once: numpy would write the ends of each axis, in minutes."""
    many = np.broadcast_to(0.5, (7,) * min(axes - 1, 8) + (1,) * (axes - 9) + (7,))
    text = arguments.shown(many)
    assert text.startswith("an array of shape (7, 7, 7, 7") and len(text) <= 100
    assert arguments.shown(many[(0,) * (axes - 1)]).startswith("array([0.5, 0.5, 0.5, 0.5")
