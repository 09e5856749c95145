"""Jets against mpmath, in other variables, and what they refuse."""

import operator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from tunneller_lib.envelopes.jet import Jet, by_slopes, differentiated, exponents, jet_variables

FUNCTIONS = {
    "rational": lambda m, x, y: y**2 / (x**2 + y**2),
    "polynomial": lambda m, x, y: 3 * x**4 - x**3 * y + 2 * (x - y) ** 5 / 7 - y + 1,
    "roots": lambda m, x, y: m.sqrt(1 + x * x + 2 * y) / (2 + x * y) ** 0.3,
    "negative powers": lambda m, x, y: (x + 2 * y) ** -3 + 1 / (x * y),
    "exponential": lambda m, x, y: m.exp(-x * y) * m.log(3 + x - y),
    "power of jets": lambda m, x, y: (1 + x) ** y,
    "base and jet": lambda m, x, y: 2.5 ** (x - y),
    "trigonometric": lambda m, x, y: m.sin(2 * x) * m.cos(x - y),
    "angle": lambda m, x, y: m.atan(3 * x - y),
    "distance": lambda m, x, y: m.hypot(x, y - 2),
}


def exact(function, x, y, every):
    """Return derivatives by 60-digit differences in mpmath."""
    with mp.workdps(60):
        parts = [mp.diff(lambda a, b: function(mp, a, b), (mp.mpf(x), mp.mpf(y)), orders)
                 for orders in every]  # fmt: skip
        return np.array([float(part) for part in parts])


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("point", [(0.7, 0.4), (0.05, 1.3)])
def test_jet_has_the_derivatives_of_mpmath(name, point):
    function = FUNCTIONS[name]
    four = function(np, *jet_variables(*point))
    five = function(np, *jet_variables(*point, order=5))
    every = exponents(5)
    expected = exact(function, *point, every)
    found = np.array([five.derivative(i, j) for i, j in every])
    for degree in range(6):
        of_degree = [k for k, orders in enumerate(every) if sum(orders) == degree]
        bound = 1e-11 * np.abs(expected[of_degree]).max() + 1e-12
        assert np.abs(found - expected)[of_degree].max() <= bound
    np.testing.assert_allclose(four.c, five.c[:15], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_jet_keeps_its_digits_at_any_scale(scale):
    def function(m, x, y):
        return m.sqrt((x / scale) ** 2 + (y / scale) ** 2 + 1)

    expected = exact(lambda m, a, b: m.sqrt(a**2 + b**2 + 1), 0.3, -0.8, exponents(4))
    jet = function(np, *jet_variables(0.3 * scale, -0.8 * scale))
    found = [jet.derivative(i, j) * scale ** (i + j) for i, j in exponents(4)]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-13)


def test_jet_takes_numbers_and_arrays_on_either_side():
    x, _ = jet_variables(np.array([1.0, 2.0]), 0.5)
    step = np.array([3.0, 4.0])
    for a, b in [(x + step, step + x), (x * step, step * x), (2 - x, -(x - 2)), (+x, x)]:
        np.testing.assert_array_equal(a.c, b.c)
    np.testing.assert_allclose((step / x).c, (step * x**-1).c, rtol=1e-15)
    np.testing.assert_allclose(np.square(x).c, np.power(x, 2).c)


def test_points_of_jets_broadcast_as_arrays_do():
    x, y = jet_variables(0.4, 0.9)
    step = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert np.hypot(x, y + step).shape == (2, 3)
    for k in np.ndindex(2, 3):
        np.testing.assert_array_equal((x * y * step).c[:, *k], (x * y * step[k]).c)
        np.testing.assert_array_equal((step - x).c[:, *k], (step[k] - x).c)
    fifteen = np.arange(15.0)  # as many points as coefficients
    np.testing.assert_array_equal((x * fifteen).derivative(1, 0), fifteen)


def test_whole_powers_are_smooth_at_zero_and_others_are_not():
    x, y = jet_variables([0.0, 1.0], [0.0, 1.0])
    assert np.isfinite((x**3 + y**0 + x**1).c).all()
    assert (x**4).derivative(4, 0)[0] == 24
    for jet in (1 / x, np.log(x), (x * x + y * y) ** 0.5, x**0.5):
        assert not np.isfinite(jet.c[:, 0]).all()


@pytest.mark.parametrize(
    ("call", "got"),
    [
        (np.abs, "absolute"),
        (lambda x: x > 0, "greater"),
        (np.add.reduce, "add.reduce"),
        (lambda x: np.sin(x, where=True), "sin with where="),
        (lambda x: operator.iadd(np.zeros(()), x), "add with out="),
    ],
)
def test_functions_out_of_reach_are_refused(call, got):
    with pytest.raises(ValueError, match=rf"^surface: must be built from .* got {got}\.$"):
        call(jet_variables(1.0, 2.0)[0])


def test_operators_in_place_make_another_jet():
    x, y = jet_variables([0.3, 0.5], [1.0, 2.0])
    kept = x.c.copy()
    for name in ("add", "sub", "mul", "truediv", "pow"):
        made = getattr(operator, f"i{name}")(x, y)
        np.testing.assert_array_equal(made.c, getattr(operator, name)(x, y).c)
        np.testing.assert_array_equal(x.c, kept)


@given(st.integers(0, 10_000), st.sampled_from([1e-5, 1.0, 1e5]), st.sampled_from([4, 5]))
def test_a_jet_in_other_variables_is_that_of_its_function_of_them(seed, scale, order):
    """f(x, y) is known, and so are x and y as functions of h and k, with a sound Jacobian."""
    c = np.random.default_rng(seed).uniform(-1, 1, (2, len(exponents(order)), 1))
    c[0, 1] += 3
    c[1, 2] += 3
    x, y = (Jet((one.T / [scale ** (i + j) for i, j in exponents(order)]).T) for one in c)

    def f(x, y):
        return np.sin(0.3 * x + 0.5) / (2 + 0.2 * y)

    fx = 0.3 * np.cos(0.3 * x + 0.5) / (2 + 0.2 * y)
    fy = -0.2 * np.sin(0.3 * x + 0.5) / (2 + 0.2 * y) ** 2
    found = by_slopes(x, y, *(Jet(slope.c[: len(exponents(order - 1))]) for slope in (fx, fy)))
    expected = f(*jet_variables(x.value, y.value, order=order))
    np.testing.assert_allclose(found.c[1:], expected.c[1:], atol=1e-11)
    assert found.value == 0


def test_jets_in_other_variables_are_not_finite_where_the_jacobian_vanishes():
    x, y = jet_variables([0.0, 1.0], [0.0, 1.0])
    f = by_slopes(x * x, y, 2 * x, y)
    assert not np.isfinite(f.c[:, 0]).all() and np.isfinite(f.c[:, 1]).all()


def test_of_two_jets_the_lower_order_is_that_of_the_result():
    x, y = jet_variables([0.3, 0.5], [1.0, 2.0])
    f = np.exp(x * y)
    slope = differentiated(f, 0)
    for found, expected in ((x * slope, x * y * f), (slope * x, x * y * f), (x - slope, x - y * f)):
        assert found.order == 3
        np.testing.assert_allclose(found.c, expected.c[:10], rtol=1e-13, atol=1e-14)
