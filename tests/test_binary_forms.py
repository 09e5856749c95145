"""Forms in two variables: what they are at random places is what their arithmetic says."""

import numpy as np
import pytest

from tunneller_lib.envelopes import binary_forms as forms

PLACES = np.random.default_rng(3).normal(size=(2, 50))
A = 0.7
B = -1.3


def form(degree, seed=0):
    return tuple(np.random.default_rng((degree, seed)).normal(size=degree + 1).tolist())


def at(p, place=PLACES):
    """Return a form's values, term by term."""
    h, k = place
    degree = len(p) - 1
    return sum(p[i] * h ** (degree - i) * k**i for i in range(degree + 1))


def test_product_is_that_of_the_values():
    p, q = form(1), form(1, 1)
    np.testing.assert_allclose(at(forms.product11(p, q)), at(p) * at(q), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("function", "degrees"), [
    (forms.plus12, (3, 1, 2)), (forms.plus13, (4, 1, 3)), (forms.plus22, (4, 2, 2)),
])  # fmt: skip
def test_product_is_added(function, degrees):
    z, p, q = map(form, degrees, (0, 1, 2))
    found = function(z, p, q)
    assert len(found) == len(z)
    np.testing.assert_allclose(at(found), at(z) + at(p) * at(q), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("function", "degree"), [
    (forms.sum1, 1), (forms.sum2, 2), (forms.sum3, 3),
])  # fmt: skip
def test_sum_has_both_factors(function, degree):
    p, q = form(degree), form(degree, 1)
    np.testing.assert_allclose(at(function(A, p, B, q)), A * at(p) + B * at(q), atol=1e-12)


def test_plus_has_one_factor():
    p, q = form(2), form(2, 1)
    np.testing.assert_allclose(at(forms.plus(p, B, q)), at(p) + B * at(q), atol=1e-12)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_forms_are_put_for_the_variables(degree):
    h, k, p = form(1), form(1, 1), form(degree)
    squares = forms.product11(h, h), forms.product11(h, k), forms.product11(k, k)
    found = {
        2: lambda: forms.replaced2(p, squares),
        3: lambda: forms.replaced3(p, h, k, squares),
        4: lambda: forms.replaced4(p, squares),
    }[degree]()
    assert len(found) == degree + 1
    np.testing.assert_allclose(at(found), at(p, (at(h), at(k))), rtol=1e-10, atol=1e-10)
