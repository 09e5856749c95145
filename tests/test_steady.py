"""Gradients of a tool's size against the document's equations, differentiated by sympy."""

from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

from tests.audit.long import many
from tests.envelopes_random import member, near_miss, placed, window
from tests.symbols_open import D, F, M, a, e, form, kappa, q, qa, tau, w, x, y
from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.jet import Jet
from tunneller_lib.envelopes.rough import RUNS
from tunneller_lib.envelopes.steady import _simple, _turn, gradients, steadiness


@cache
def determinants(kind):
    """Return what `gradients` should: of a jet in its adapted frame, the angle and tau.

    They are the derivatives along e and w of two equations, put together with those by the angle.
    """
    first, second = (q, D(e, q) + kappa * qa) if kind == "cone" else (q.subs(tau, 0), M)
    parts = [first.diff(a) * D(way, second) - second.diff(a) * D(way, first) for way in (e, w)]
    symbols = [symbol for (i, j), symbol in F.items() if i + j > 1]
    flat = {x: 0, y: 0, F[0, 0]: 0, F[1, 0]: 0, F[0, 1]: 0}
    exact = sp.lambdify([a, tau, *symbols], [part.subs(flat) for part in parts])

    def value(f, angle, slope):
        return exact(angle, slope, *(f.derivative(i, j)[0] for i, j in F if i + j > 1))

    return value


def random_jet(rng):
    """Return a jet of order 5 in an adapted frame, and an angle."""
    c = rng.normal(size=(21, 1))
    c[:3] = 0.0
    return Jet(c), rng.uniform(-np.pi, np.pi)


def found(kind, f, angle):
    return [value.item() for value, _ in gradients(kind, f, np.array([[angle]]))]


@pytest.mark.parametrize("seed", range(5))
def test_gradient_of_a_half_angle_is_that_of_eqs_11_and_12(seed):
    f, angle = random_jet(np.random.default_rng(seed))
    at = {a: angle} | {symbol: f.derivative(i, j)[0] for (i, j), symbol in F.items()}
    slope = float((-form(e, e, e) / (6 * form(e, w))).subs(at))
    exact = determinants("cone")(f, angle, slope)
    assert found("cone", f, angle) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("seed", range(5))
def test_gradient_of_a_cylinders_radius_is_that_of_eqs_11_23_and_24(seed):
    f, angle = random_jet(np.random.default_rng(seed))
    exact = determinants("cylinder")(f, angle, 0.0)
    assert found("cylinder", f, angle) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize(("kind", "power"), [("pipe", 1), ("cylinder", 1), ("cone", 0)])
def test_errors_of_radii_are_lengths_and_those_of_half_angles_are_not(kind, power):
    """The jet's unit is m: in a unit 1024 times smaller a radius has 1024 times the error."""
    rng = np.random.default_rng(8)
    f = np.repeat(random_jet(rng)[0].c, RUNS, axis=1) * (1 + 1e-9 * rng.normal(size=(21, RUNS)))
    angle = np.array([[0.3, 0.3 + np.pi / 2]])
    metre, smaller = (steadiness(kind, Jet(scale * f), angle, 1.0).off for scale in (1.0, 1024.0))
    assert np.all(metre > 1e-12)
    np.testing.assert_array_equal(smaller, metre * 1024.0**power)


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4, 1e-2, 1.0])
@pytest.mark.parametrize("kind", ["cylinder", "pipe", "cone"])
def test_verdicts_without_a_size_are_right_in_windows_down_to_a_hundred_millionth(kind, size):
    verdicts = []
    seeds = many(1, 3)
    for seed in range(seeds):
        for exact, make in ((True, member), (False, near_miss)):
            rng = np.random.default_rng((seed, exact))
            surface, _ = make(kind, rng)
            points = window(surface, rng, size)
            verdicts.append(
                recognise(placed(surface, rng, 3.0), *points, kind, model="space").verdict
            )
    assert verdicts == ["is", "is not"] * seeds


def test_half_angle_that_opens_slowly_is_refused_in_a_small_window():
    _, data = member("cone", np.random.default_rng(1))
    rng = np.random.default_rng(2)
    points = window(moving_cone(data["motion"], data["half_angle"]), rng, 1e-6)
    for rate in (1e-1, 1e-3, 1e-5):
        surface = moving_cone(data["motion"], data["half_angle"], rate=rate)
        assert recognise(surface, *points, "cone", model="space").verdict == "is not"
    surface = moving_cone(data["motion"], data["half_angle"])
    found = recognise(surface, *points, "cone", model="space")
    assert found.verdict == "is"
    assert found.half_angle == pytest.approx(data["half_angle"], rel=1e-9)


@pytest.mark.parametrize(("share", "simple"), [(1e-7, False), (1e-6, False), (1e-4, True)])
def test_a_cone_is_a_simple_one_from_a_share_of_the_slopes_terms_on(share, simple):
    """Without errors: below a hundred-thousandth two cones may be one that counts twice."""
    f, _ = random_jet(np.random.default_rng(11))

    def slope(angle):
        value, terms = _turn(f, np.array([[angle]]))
        return (value / terms).item()

    every = np.linspace(-np.pi, np.pi, 400)
    first = next(k for k in range(399) if slope(every[k]) < 0 < slope(every[k + 1]))
    angle = brentq(lambda a: slope(a) - share, every[first], every[first + 1], xtol=1e-15)
    runs = Jet(np.repeat(f.c, RUNS, axis=1))
    assert bool(_simple(runs, np.full((RUNS, 1), angle))) is simple
