"""What `recognise` weighs: conditions on a direction, the errors of each, and what zeros they have.

The conditions stand against the document's statements, the bounds against what errors do.
"""

import operator
from functools import cache, partial
from itertools import pairwise, product

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

from tests.audit.long import many
from tests.envelopes_random import member, near_miss, placed, window
from tests.symbols_envelopes import D, x, y
from tests.symbols_open import F, M, a, e, form, kappa, q, qa, tau, w
from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet
from tunneller_lib.envelopes.evidence import (
    RUNS,
    Forms,
    RoughJet,
    errors,
    rough_frames,
    spread_in_two,
    weigh,
    zeros,
)
from tunneller_lib.envelopes.families import channel, helix, moving_cone, screwing
from tunneller_lib.envelopes.jet import Jet, derivative_along, exponents, frobenius, principal
from tunneller_lib.envelopes.kinds import KINDS, turn_of_eq11

EPS = np.finfo(float).eps
POINTS = 12

JET = Jet(np.random.default_rng(5).normal(size=(15, POINTS)))
OFF = Jet(1e-9 * np.abs(np.random.default_rng(6).normal(size=(15, POINTS))))
ANGLES = np.random.default_rng(7).uniform(0, 2 * np.pi, (POINTS, 5))

# ---- two conditions of each class -----------------------------------------------------------

CLASSES = {"ruled": 0.0, "cylinder": 0.3, "channel": 0.0, "pipe": 0.3, "cone": 0.5}


def assert_bounded(bounding, kind, jets, sizes, slack):
    """Assert that conditions change by what `bounding` says, or no less than a quarter of it."""
    around = np.linspace(0, 2 * np.pi, 181)[None]

    def both(f, size):
        forms = KINDS[kind].conditions(f, OFF, size)
        return np.stack([forms.first(around), forms.second(around)])

    still = both(JET, CLASSES[kind])
    moved = np.abs([both(f, size) - still for f, size in product(jets, sizes)])
    found, bounds = moved.max(axis=(0, -1)), np.stack([bounding.off_first, bounding.off_second])
    assert np.all(found <= bounds * (1 + slack) + 1e-15) and np.all(found >= bounds / 4)


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("kind", CLASSES)
def test_errors_bound_what_wrong_coefficients_do(kind, degree):
    places = [k for k, exponents in enumerate(exponents(4)) if sum(exponents) == degree]
    off = np.zeros_like(JET.c)
    off[places] = OFF.c[places]
    jets = []
    for signs in product((-1, 1), repeat=len(places)):
        moved = off.copy()
        moved[places] *= np.array(signs)[:, None]
        jets.append(Jet(JET.c + moved))
    size = CLASSES[kind]
    assert_bounded(KINDS[kind].conditions(JET, Jet(off), size), kind, jets, [size], 1e-6)


@pytest.mark.parametrize("kind", ["cylinder", "pipe", "cone"])
def test_errors_bound_what_an_unsure_size_does(kind):
    size, unsure = CLASSES[kind], 1e-6
    bounding = KINDS[kind].conditions(JET, Jet(0 * JET.c), size, unsure)
    assert_bounded(bounding, kind, [JET], [size - unsure, size + unsure], 1e-4)


@pytest.mark.parametrize("share", [1e-3, 1.0])
def test_order_4_is_compared_with_its_terms_or_a_share_of_the_jet(share):
    rho, along = 1 / (2 * np.tan(0.5)), partial(derivative_along, JET, ANGLES)
    terms = [rho**2 * along(4, 0), 6 * rho * along(2, 1), 3 * (along(0, 2) - along(2, 0))]
    whole = rho**2 * frobenius(JET, 4) + 6 * rho * frobenius(JET, 3) + 3 * frobenius(JET, 2)
    size = KINDS["cone"].conditions(JET, OFF, 0.5, floor=share).size(ANGLES)
    expected = np.maximum(sum(np.abs(term) for term in terms), share * whole[:, None])
    np.testing.assert_allclose(size, expected, rtol=1e-13)


def test_an_umbilic_says_nothing_of_channels():
    """Every direction is principal there, and in some of them f_eee vanishes."""
    f = Jet(np.zeros((15, 1)))
    f.c[6:10] = [[0.3], [0.2], [-0.4], [0.5]]
    f.c[[3, 5]] = 1.0
    assert KINDS["channel"].residual(f, None) == (0.0, None)
    f.c[5] = 1.001
    assert KINDS["channel"].residual(f, None)[0] > 0.05


# ---- zeros of what is known to some error ---------------------------------------------------


def test_polynomial_may_vanish_where_twice_its_error_reaches_zero():
    off = np.full(4, 1e-6)
    height = off * [0.5, 1.9, 2.1, 3.0]
    angle, spread, several = zeros(lambda a: height[:, None] + 1 - np.cos(a), 1, off)
    at = np.abs(angle) < 0.1
    assert np.any(at, axis=1).tolist() == [True, True, False, False]
    assert several[at].all()
    # The zero of a double root known to e lies within sqrt(2 e) of it, and farther it isn't sought.
    assert np.all(spread[at] >= np.sqrt(2 * 1e-6)) and np.all(spread[at] < 0.02)


@pytest.mark.parametrize("off", [1e-12, 1e-4])
def test_simple_zeros_lie_within_their_spread(off):
    rng = np.random.default_rng(3)
    shift = rng.uniform(-0.9, 0.9, 50)
    angle, spread, several = zeros(lambda a: np.cos(a) - shift[:, None], 1, np.full(50, off))
    true = np.arccos(shift + off * rng.choice([-1, 1], 50))
    away = np.abs(np.cos(angle) - np.cos(true)[:, None]) / np.abs(np.sin(true))[:, None]
    known = ~np.isnan(angle)
    assert not several[known].any() and known.sum() == 100
    assert np.all(away[known] <= spread[known]) and np.all(spread[known] < 20 * off)


@pytest.mark.parametrize("apart", [1e-7, 1.9e-5])
def test_zeros_that_come_as_one_are_both_within_its_spread(apart):
    """Nearer than 2e-5 they come as a double one amid them, where the polynomial isn't zero."""
    off = np.array([1e-16])
    angle, spread, several = zeros(lambda a: np.cos(a - 0.3) - np.cos(apart / 2), 1, off)
    near = np.abs(angle - 0.3) < 1e-4
    for zero in (0.3 - apart / 2, 0.3 + apart / 2):
        assert np.any(np.abs(angle - zero)[near] <= spread[near])
    assert several[near].all()


@pytest.mark.parametrize(("aside", "refutes"), [(1e-5, False), (1e-2, True)])
def test_a_zero_that_may_be_off_refutes_only_beyond_what_that_makes_of_the_second_form(
    aside, refutes
):
    """The first form is known to 1e-4, so that its zero may be 1e-4 rad aside."""
    one = np.ones(1)
    forms = Forms(np.cos, lambda a: np.cos(a + aside), 1, 1e-4 * one, 0 * one, np.ones_like)
    assert weigh(forms, 1e-2).refutes == refutes


@pytest.mark.parametrize("size", [1e-6, 1.0])
def test_points_are_spread_unless_one_conic_or_one_orbit_holds_them(size):
    s, t = size * np.random.default_rng(4).uniform(-1, 1, (2, 20))
    angle = np.linspace(0, 5, 20)
    normals = np.stack([s / size, t / size, np.full(20, 2.0)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    assert spread_in_two(s, t, None) and spread_in_two(s, t, normals)
    band = np.stack([np.cos(angle), np.sin(angle), 1 + 0.02 * t / size], axis=-1)
    band /= np.linalg.norm(band, axis=-1, keepdims=True)
    assert spread_in_two(s, t, band)  # about a circle, and wide enough
    for turn in (angle, 5e-6 * angle):  # a circle, and an arc that is hardly turned
        circle = np.stack([np.cos(turn), np.sin(turn), np.ones(20)], axis=-1) / np.sqrt(2)
        assert not spread_in_two(s, t, circle)
    assert not spread_in_two(size * np.cos(angle), 2 * size * np.sin(angle), normals)
    for nearly in (0.0, 1e-5):  # a parabola, and a band about it that is as narrow
        assert not spread_in_two(s, s * s / size + nearly * t, None)


# ---- random rounding ------------------------------------------------------------------------


@pytest.mark.parametrize("operate", [operator.add, operator.sub, operator.mul, operator.truediv])
@pytest.mark.parametrize("other", [Jet(np.full((15, 1000), 0.7)), 0.7, np.full(1000, 0.7)])
def test_every_operator_turns_either_operand_by_a_rounding_at_most(operate, other):
    jet = Jet(np.ones((15, 1000)))
    rough = RoughJet(jet.c, np.random.default_rng(1))
    for found, exact in ((operate(rough, other), operate(jet, other)),
                         (operate(other, rough), operate(other, jet))):  # fmt: skip
        assert isinstance(found, RoughJet)
        assert np.mean(found.c != exact.c) > 0.05  # some roundings hide a turn
    turned = (rough + 0.0).c[0] - 1  # a sum of one term
    assert 0.5 * EPS <= np.abs(turned).max() <= 2 * EPS and turned.min() < 0 < turned.max()


@pytest.mark.parametrize("order", [4, 5])
def test_errors_of_a_torus_are_some_hundreds_of_roundings(order):
    def torus(s, t):
        return [(2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)]

    s, t = np.random.default_rng(7).uniform(0.2, 0.8, (2, 30))
    exact = isotropic_jet(adapted_frames(torus, s, t, "space"), slice(None))
    off = errors(isotropic_jet(rough_frames(torus, s, t, "space", order), slice(None)))
    size = np.abs(exact.c[3:]).max()
    bends = off.c[3:6].max(axis=0)  # of the curvatures
    assert off.c.shape[1] == len(s) and np.all(bends > EPS * size / 10)
    assert np.median(bends) < 500 * EPS * size


# ---- sizes that stand still over the surface ------------------------------------------------


@cache
def determinants(kind):
    """Return what `gradients` should: of a jet in its adapted frame, the angle and tau.

    They are the derivatives along e and w of two equations, put together with those by the angle.
    """
    first, second = (q, D(e, q) + kappa * qa) if kind == "cone" else (q.subs(tau, 0), M)
    parts = [first.diff(a) * D(way, second) - second.diff(a) * D(way, first) for way in (e, w)]
    symbols = [symbol for (i, j), symbol in F.items() if i + j > 1]
    flat = {x: 0, y: 0, F[0, 0]: 0, F[1, 0]: 0, F[0, 1]: 0}
    return sp.lambdify([a, tau, *symbols], [part.subs(flat) for part in parts])


def adapted_jet(rng):
    """Return a random jet of order 5 in an adapted frame."""
    c = rng.normal(size=(21, 1))
    c[:3] = 0.0
    return Jet(c)


@pytest.mark.parametrize("kind", ["cone", "cylinder"])
@pytest.mark.parametrize("seed", range(4))
def test_gradient_of_a_size_is_that_of_the_documents_equations(kind, seed):
    """Of a half-angle by Eqs 11 and 12, of a cylinder's radius by 11, 23 and 24."""
    rng = np.random.default_rng(seed)
    f, angle = adapted_jet(rng), rng.uniform(-np.pi, np.pi)
    here = {a: angle} | {symbol: f.derivative(i, j)[0] for (i, j), symbol in F.items()}
    slope = 0.0 if kind == "cylinder" else float((-form(e, e, e) / (6 * form(e, w))).subs(here))
    values = [f.derivative(i, j)[0] for i, j in F if i + j > 1]
    found = [value.item() for value, _ in KINDS[kind].gradients(f, np.array([[angle]]))]
    assert found == pytest.approx(determinants(kind)(angle, slope, *values), rel=1e-10)


@pytest.mark.parametrize(("kind", "power"), [("pipe", 1), ("cylinder", 1), ("cone", 0)])
def test_errors_of_radii_are_lengths_and_those_of_half_angles_are_not(kind, power):
    """The jet's unit is m: in a unit 1024 times smaller a radius has 1024 times the error."""
    rng = np.random.default_rng(8)
    f = np.repeat(adapted_jet(rng).c, RUNS, axis=1) * (1 + 1e-9 * rng.normal(size=(21, RUNS)))
    angle = np.array([[0.3, 0.3 + np.pi / 2]])
    metre, smaller = (KINDS[kind].steadiness(Jet(unit * f), angle, 1.0).off for unit in (1, 1024))
    assert np.all(metre > 1e-12)
    np.testing.assert_array_equal(smaller, metre * 1024.0**power)


def test_both_principal_directions_are_found_again_near_those_of_the_middle():
    turn = principal(JET)[2][:, None]
    both = np.add(turn, [0.0, np.pi / 2])
    found = KINDS["pipe"].found_again(JET, both + 0.3)
    np.testing.assert_allclose(found, both, atol=1e-12)


@pytest.mark.parametrize(("share", "simple"), [(1e-6, False), (1e-4, True)])
def test_a_cone_is_a_simple_one_from_a_share_of_the_slopes_terms_on(share, simple):
    """Without errors: below a hundred-thousandth two cones may be one that counts twice."""
    f = adapted_jet(np.random.default_rng(11))

    def slope(angle):
        value, terms = turn_of_eq11(f, np.array([[angle]]))
        return (value / terms).item()

    every = pairwise(np.linspace(-np.pi, np.pi, 400))
    ends = next(ends for ends in every if slope(ends[0]) < 0 < slope(ends[1]))
    angle = brentq(lambda a: slope(a) - share, *ends, xtol=1e-15)
    runs = Jet(np.repeat(f.c, RUNS, axis=1))
    assert bool(KINDS["cone"].simple(runs, np.full((RUNS, 1), angle))) is simple


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("kind", ["cylinder", "pipe", "cone"])
def test_verdicts_without_a_size_are_right_in_windows_down_to_a_hundred_millionth(kind, size):
    for seed in range(many(1, 3)):
        for make, expected in ((member, "is"), (near_miss, "is not")):
            rng = np.random.default_rng((seed, make is member))
            surface, _ = make(kind, rng)
            points = window(surface, rng, size)
            found = recognise(placed(surface, rng, 3.0), *points, kind, model="space")
            assert found.verdict == expected


def test_half_angle_that_opens_slowly_is_refused_in_a_small_window():
    _, data = member("cone", np.random.default_rng(1))
    cone = data["motion"], data["half_angle"]
    points = window(moving_cone(*cone), np.random.default_rng(2), 1e-6)
    for rate, verdict in ((1e-1, "is not"), (1e-5, "is not"), (0.0, "is")):
        found = recognise(moving_cone(*cone, rate=rate), *points, "cone", model="space")
        assert found.verdict == verdict
    assert found.half_angle == pytest.approx(data["half_angle"], rel=1e-9)


@pytest.mark.parametrize(("window", "verdict"), [(0.6, "is"), (0.1, "is"), (1e-4, "cannot tell")])
def test_spheres_that_grow_evenly_have_one_cone_along_their_circles(window, verdict):
    surface = channel(lambda s: helix(s, 0.4), 0.2, growth=0.6)
    s, t = np.array([[0.4], [1.0]]) + window * np.random.default_rng(1).uniform(-1, 1, (2, 30))
    found = recognise(surface, s, t, "cone", model="space")
    assert found.verdict == verdict
    if verdict == "is":
        assert found.half_angle == pytest.approx(np.arcsin(0.6 / np.hypot(1.0, 0.4)), rel=1e-12)


@pytest.mark.parametrize(("motion", "half_angle", "middle", "window", "other"), [
    ((0.186, 0.0, 1.2), 0.7, (0.45, 0.35), 0.5, np.pi / 2 - 1.2),  # of revolution: both are right
    ((1.588, -0.691, 1.271), 0.782, (0.11, 1.59), 0.0075, 0.7778),  # too small to tell them apart
])  # fmt: skip
def test_sizes_that_pass_as_well_are_named_in_the_reason(motion, half_angle, middle, window, other):
    grid = np.mgrid[-0.5:0.5:5j, -0.5:0.5:6j]
    s, t = np.array(middle)[:, None, None] + window * grid[::-1]
    found = recognise(moving_cone(screwing(*motion), half_angle), s, t, "cone", model="space")
    named = [found.half_angle, float(found.because.rpartition(" ")[2].rstrip("."))]
    assert found.verdict == "is" and "; so they do with " in found.because
    assert sorted(named) == pytest.approx(sorted([half_angle, other]), abs=1e-4)
