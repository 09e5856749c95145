"""Taylor coefficients of the elementary functions against mpmath's."""

import numpy as np
import pytest
from mpmath import mp

from tunneller_lib.envelopes import elementary

NAMES = ["log", "exp", "sin", "cos", "sinh", "cosh", "tan", "tanh", "arctan"]
POINTS = [0.3, 0.9, 1.4, 2.5]


def exact(function, x):
    with mp.workdps(50):
        return [float(c) for c in mp.taylor(function, mp.mpf(x), 5)]


def check(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14 * np.max(np.abs(expected)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("x", POINTS)
def test_coefficients_are_those_of_mpmath(name, x):
    function = {"arctan": mp.atan}.get(name) or getattr(mp, name)
    check(getattr(elementary, name)(x), exact(function, x))
    if name != "log":
        check(getattr(elementary, name)(-x), exact(function, -x))


@pytest.mark.parametrize("x", POINTS)
@pytest.mark.parametrize("p", [0.5, 2.0, -1.5, 4.0, 6.0])
def test_powers_are_those_of_mpmath(x, p):
    check(elementary.power(x, p), exact(lambda y: y**p, x))
    check(elementary.reciprocal(-x), exact(lambda y: 1 / y, -x))


def test_tanh_keeps_its_digits_where_it_is_nearly_one():
    found = elementary.tanh(18.0)[1]  # 1 - t^2 has none left
    assert found == pytest.approx(float(mp.sech(18) ** 2), rel=1e-14)


def test_arrays_have_the_coefficients_of_their_points():
    for name in NAMES:
        many = np.array(getattr(elementary, name)(np.array(POINTS)))
        for place, x in enumerate(POINTS):
            np.testing.assert_allclose(many[:, place], getattr(elementary, name)(x), rtol=1e-14)
