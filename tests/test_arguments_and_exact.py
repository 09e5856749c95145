"""Validation, and the arithmetic that keeps digits, judged in fractions and by mpmath."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp, mpf

from tests.draws import EPS
from tunneller_lib import arguments
from tunneller_lib.kernels import exact

numbers = st.floats(-1e9, 1e9).map(lambda x: round(x, 60))
vectors = st.tuples(*[numbers] * 3)


class Column:
    """What pandas' columns of numbers that may be missing are to numpy: arrays of objects."""

    def __init__(self, *values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype or object)


MISSING = type("MISSING", (), {"__bool__": lambda self: [][0]})()  # no number, as pandas' NA


def test_numbers_that_might_be_missing_pass_where_none_is():
    for value in (Column(1, 2), np.ma.masked_array([1, 2], [False, False])):
        np.testing.assert_array_equal(arguments.real("x", value), [1.0, 2.0])
        np.testing.assert_array_equal(arguments.whole("x", value, 0, 9), [1, 2])
    for value in (Column(1, MISSING), np.ma.masked_array([1.0, 2.0], [False, True])):
        with pytest.raises(ValueError, match=r"^x: must hold real numbers in a regular array; got"):
            arguments.real("x", value)
        with pytest.raises(ValueError, match=r"^x: must hold whole numbers from 0 to 9; got "):
            arguments.whole("x", value, 0, 9)


@pytest.mark.parametrize("value", [3, 2.5, np.float64(1e-100), np.int8(1)])
def test_positive_and_finite_return_a_plain_float(value):
    assert type(arguments.positive("x", value)) is type(arguments.finite("x", value)) is float


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


@pytest.mark.parametrize("scale", [1e-3, 1, 1e6])
@pytest.mark.parametrize("gap", [0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1, 1e3, 1e6])
def test_radius_and_excess_against_mpmath(scale, gap):
    rng = np.random.default_rng(0)
    for r in scale * rng.uniform(1, 4, 200):
        reach, angle = r * abs(1 + rng.choice([-1, 1]) * gap), rng.uniform(-4, 4)
        x, z = reach * np.cos(angle), reach * np.sin(angle)
        found, excess = exact.radius_and_excess(x, z, r)
        with mp.workdps(40):
            rho = mp.sqrt(mpf(x) ** 2 + mpf(z) ** 2)
            assert abs(found - rho) <= 2 * EPS * rho
            assert abs(excess - (rho - mpf(r))) <= 8 * EPS * abs(rho - mpf(r)) + 1e-22 * r


def test_checked_call_refuses_what_the_function_itself_would():
    @arguments.checked
    def add(x: arguments.Reals, y: arguments.Reals = 0, *, scale: arguments.Finite = 1):
        return scale * (x + y)

    assert add(1, 2, scale=3) == add(y=2, scale=3, x=1) == 9
    for positional, options, why in (
        ((1, 2, 3), {}, "too many positional"),  # the third is an option, given by name only
        ((1,), {"x": 2}, "multiple values"),
        ((), {"y": 2}, "missing"),
        ((1,), {"z": 2}, "unexpected"),
    ):
        with pytest.raises(TypeError, match=why):
            add(*positional, **options)
