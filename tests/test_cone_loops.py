"""Cones at a point, by their forms: the residuals along their directions, and rounding in them."""

from math import comb, factorial

import numpy as np
import pytest

from tunneller_lib.envelopes.cone_loops import cones_of, order_four_along

RHO = 0.8


def along(p, c, s):
    """Return a form's value."""
    degree = len(p) - 1
    return sum(p[i] * c ** (degree - i) * s**i for i in range(degree + 1))


def derivatives(forms, c, s):
    """Return f_ee, f_ww, f_eee, f_ew, f_eew and f_eeee for e = (c, s), numbers or rows of them.

    By the forms' values: as e goes to e + x w a form of degree d goes to a polynomial in x, whose
    coefficient of x^k is the derivative k times along w, and d - k times along e, over k! (d - k)!.
    """
    x = np.linspace(-1, 1, 5)

    def coefficients(p):
        degree = len(p) - 1
        values = along(p, c - np.multiply.outer(x, s), s + np.multiply.outer(x, c))
        found = np.polynomial.polynomial.polyfit(x, values, degree)
        return [found[k] * factorial(k) * factorial(degree - k) for k in range(degree + 1)]

    two, three, four = map(coefficients, forms)
    return two[0], two[2], three[0], two[1], three[1], four[0]


def norm_of(p):
    """Return the root of the squares of all derivatives, each as often as it is one."""
    d = len(p) - 1
    own = [p[i] * factorial(d - i) * factorial(i) for i in range(d + 1)]
    return np.sqrt(sum(comb(d, i) * own[i] ** 2 for i in range(d + 1)))


def shape_of(forms):
    return (0.0,) * 14 + tuple(coefficient for form in forms for coefficient in form)


def random_forms(case):
    rng = np.random.default_rng(case)
    return [tuple(rng.normal(size=degree + 1).tolist()) for degree in (2, 3, 4)]


@pytest.mark.parametrize("case", range(20))
def test_cones_are_in_contact_of_order_three_and_none_is_left_out(case):
    forms = random_forms(case)
    found = cones_of(shape_of(forms), RHO)
    assert len(found) == 6
    there = [cone for cone in found if cone[2]]
    for c, s, _, fee, residual in there:
        ee, ww, eee, ew, eew, eeee = derivatives(forms, c, s)
        assert abs(RHO * eee + 3 * ew) < 1e-9
        assert fee == pytest.approx(ee, abs=1e-9)
        terms = RHO**2 * eeee, 6 * RHO * eew, 3 * (ww - ee)
        assert residual == pytest.approx(sum(terms) / sum(map(abs, terms)), abs=1e-9)
    turns = np.linspace(0, 2 * np.pi, 2001)
    _, _, eee, ew, _, _ = derivatives(forms, np.cos(turns), np.sin(turns))
    signs = np.sign(RHO * eee + 3 * ew)
    assert sum(cone[2] for cone in there) == np.count_nonzero(np.diff(signs))


def test_forms_that_vanish_have_no_cones():
    forms = (2.0, 0.0, 2.0), (0.0,) * 4, (1.0,) * 5  # a sphere: every direction would do
    assert not any(cone[2] for cone in cones_of(shape_of(forms), RHO))
    less = (2.0, 1e-9, 2.0), (0.0,) * 4, (1.0,) * 5
    assert sum(cone[2] for cone in cones_of(shape_of(less), RHO)) == 4


def test_residual_of_terms_that_all_but_vanish_is_one_of_a_thousandth_of_the_forms():
    small = 1e-10
    forms = (1.0, 0.0, 1.0), (0.0, 0.0, 0.0, 2.0), (small, 0.0, 0.0, 0.0, 3.0)
    floor = RHO**2 * norm_of(forms[2]) + 6 * RHO * norm_of(forms[1]) + 3 * norm_of(forms[0])
    [flat] = [cone for cone in cones_of(shape_of(forms), RHO) if cone[2] and cone[0] > 0.9]
    assert flat[2] == 3 and flat[4] == pytest.approx(RHO**2 * 24 * small / (1e-3 * floor), rel=1e-3)


def test_terms_are_counted_as_a_floor_at_least():
    forms = random_forms(20)
    *_, usual = order_four_along(forms, RHO, 0.0, 0.6, 0.8)
    *_, floored = order_four_along(forms, RHO, 1e6, 0.6, 0.8)
    ee, ww, _, _, eew, eeee = derivatives(forms, 0.6, 0.8)
    total = RHO**2 * eeee + 6 * RHO * eew + 3 * (ww - ee)
    assert floored == pytest.approx(total / 1e6, rel=1e-9) and abs(floored) < abs(usual)
