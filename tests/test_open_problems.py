"""What the answers to Problems 15 and 30 say besides, and the surface that settles Problem 15."""

import numpy as np
import pytest
from mpmath import mp

from tests import symbols_open as shared
from tests.symbols_envelopes import EQ9, EQ11, EQ12, EQ25, UT, VT, D, at, eq14, p
from tests.symbols_open import a, e, form, kappa, q, qa, qaa, rho, vanishes, w, xe
from tunneller_lib.envelopes import hyperosculating_cones, jet_variables
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.pseudo import pseudo_envelope


def bending(theta):
    """Return the example's derivative of g'/r, up to a factor, as a function of the radius."""
    C, S = mp.cos(theta), mp.sin(theta)

    def bend(k):
        c = (1 - k * k) / (1 + k * k)
        W = mp.sqrt(c * c - S * S)
        return (C * c + W) ** 1.5 * (c + W) ** (-3 / (2 * C)) / k**2

    return bend


def once_round(expression):
    """Return the derivative by the angle along the conic's own circle."""
    return rho * D(e, expression) + expression.diff(a)


def test_circle_keeps_its_radius():
    assert vanishes(once_round(kappa))


def test_eq12_is_the_derivative_of_eq11_along_the_circle():
    # (11) is rho^3 q/p; and where q = 0 what is left of (12) is rho^3/p (rho D_e q + q_a).
    eleven = rho**2 * (rho * form(e, e, e) + 3 * form(e, w))
    assert shared.vanishes_at_fractions(eleven - rho**3 * q / p)
    twelve = rho**3 * (rho * D(e, q) + qa) / p
    rest = 2 * rho**4 * xe * q / p**2
    assert shared.vanishes_at_fractions(once_round(eleven) - twelve + rest)


def test_theorem_a_prime_order_five_is_a_square():
    # With q, q_a and grad q zero, so D_e q_a = -a_e q_aa and D_e D_e q = a_e^2 q_aa, the second
    # derivative along the circle is rho^2 q_aa (kappa - a_e)^2: order 5 makes the field's curve the
    # conic's circle. By (I) the gap's fifth coefficient follows, -4.8 rho^5 ... f_ew^2/q_aa.
    twice = once_round(once_round(q))
    parts = rho**2 * D(e, D(e, q)) + 2 * rho * D(e, qa) + qaa + rho * D(w, q)
    assert shared.vanishes_at_fractions(twice - parts)


def test_example31_has_an_isolated_double_root_whose_conic_stays():
    """So f_ew = 0 can't be asked of a double root at one point; (I) needs it on an open set."""
    x, y = 1.2, 1.6  # on |(x, y)| = cot(theta), for tan(theta) = 1/2
    f = cyclide(*jet_variables(x, y))
    u, v = -x / 2, -y / 2  # the contained conic, Example 10
    here = {"x": x, "y": y, "u": u, "v": v, "tan": 0.5}
    for left in (EQ9, EQ11, EQ12, eq14(UT, VT)):
        assert abs(at(left, f, **here)) < 1e-14
    assert abs(at(EQ25, f, **here)) == pytest.approx(6 / 25, rel=1e-12)  # f_ew, for |(u, v)| = 1


@pytest.mark.parametrize("degrees", [1, 5, 20, 45, 80, 89])
def test_pseudo_envelope_in_forty_digits(degrees):
    half_angle = np.radians(degrees)
    f = pseudo_envelope(half_angle)
    with mp.workdps(40):
        theta = mp.mpf(half_angle)
        bend = bending(theta)
        end = mp.tan(mp.pi / 4 - theta / 2)
        middle = end / 2
        factor = 4 / ((1 + middle**2) * middle * bend(middle))
        for share in ("0.01", "0.3", "0.7", "0.999"):
            r = end * mp.mpf(share)
            y = factor * mp.quad(bend, [middle, (middle + r) / 2, r])
            more = mp.quad(lambda k: k * k * bend(k), [middle, (middle + r) / 2, r])
            value = -1 + (r * r * y - factor * more) / 2
            assert f(float(r), 0.0) == pytest.approx(float(value), rel=1e-13)
            bends = [factor * mp.diff(bend, r, k) for k in range(4)]
            slopes = [
                r * y,
                y + r * bends[0],
                *(k * bends[k - 2] + r * bends[k - 1] for k in (2, 3, 4)),
            ]
            # Both terms of the fourth and of the fifth cancel near the axis.
            sizes = [*slopes[:3], bends[1], bends[2]]
            jet, higher = (f(*jet_variables(0.0, float(r), **o)) for o in ({}, {"order": 5}))
            found = [*(jet.derivative(0, k) for k in (1, 2, 3, 4)), higher.derivative(0, 5)]
            for k, share in enumerate((1e-10, 1e-10, 1e-9, 1e-9, 1e-8)):
                assert found[k] == pytest.approx(float(slopes[k]), abs=share * abs(float(sizes[k])))


def test_pseudo_envelope_has_its_radii_in_the_middle_and_an_offset_beside():
    half_angle = np.radians(20)
    middle = np.tan(np.radians(35)) / 2
    for offset in (0.0, 0.4, -2.0):
        jet = pseudo_envelope(half_angle, offset=offset)(*jet_variables(middle, 0.0))
        height = jet.value - middle * jet.derivative(1, 0)
        radii = [(1 + middle**2) * jet.derivative(*k) / 2 + height for k in ((2, 0), (0, 2))]
        assert np.allclose(radii, [1 - offset, -1 - offset], rtol=0, atol=1e-13)


def test_pseudo_envelope_ends():
    f = pseudo_envelope(np.radians(20))
    end = np.tan(np.radians(35))
    assert np.isfinite(f(np.array([0.1, end * (1 - 1e-12)]), 0.0)).all()
    for x in (0.0, end * 1.001, 5.0):
        with pytest.raises(ValueError, match=r"^x, y: must lie between the origin and the circle"):
            f(x, 0.0)
    found = hyperosculating_cones(f, [0.0, 0.3, 0.9], 0.0, half_angle=0.3)
    assert list(found.state) == ["outside", "regular", "outside"]
