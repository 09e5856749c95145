"""Envelopes of moving cones, section 3: ruled surfaces, Eqs 3 and 4.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

from types import SimpleNamespace

import numpy as np
import sympy as sp

from exhibits.envelope_equations import eq04_terms
from tests.envelopes_zoo import GENERAL, GRID, RULED, ruled
from tests.symbols_envelopes import CUBIC, NAMES, D, F, at, jet_of, u, v, values, x, y, zero
from tunneller_lib.envelopes.adapted import adapted_frames, tangent_graph
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.jet import Jet, jet_variables

READS = ["report/ledger/*"]

QUADRATIC = F("xx") * u**2 + 2 * F("xy") * u * v + F("yy") * v**2
_a, _b, _c = F("xx"), F("xy"), F("yy")
_k, _l, _m, _n = F("xxx"), F("xxy"), F("xyy"), F("yyy")
_GRAPH = SimpleNamespace(derivative=lambda i, j: NAMES[i, j])
EQ4, EQ4_PRINTED = (eq04_terms(_GRAPH, printed=printed).sum() for printed in (False, True))


def test_ruled_surfaces_as_limits(judge):
    tends = []
    for lines in RULED.values():

        def motion(s, lines=lines):
            """Carry a cone with its vertex on the line's own point and its axis along it."""
            point, velocity, along, rate = (np.array(c, float) for c in lines(s))
            size = np.linalg.norm(along)
            axis = along / size
            turn = np.cross(axis, rate / size)
            second = np.cross(turn, axis) / np.linalg.norm(turn)
            return point, velocity, [axis, second, np.cross(axis, second)], turn

        for s, far in ((0.3, 0.4), (0.6, -0.7)):
            vertex, velocity, (axis, second, third), turn = motion(s)
            move = velocity + far * np.cross(turn, axis)  # of the ruling's point beside it
            u = np.arctan2(-move @ second, move @ third)  # the azimuth of its tangent plane
            gaps = [np.linalg.norm(moving_cone(motion, angle)(u, s) - vertex - far * axis)
                    for angle in (1e-3, 1e-4, 1e-5)]  # fmt: skip
            tends.append(np.allclose(np.divide(gaps[:2], gaps[1:]), 10, rtol=0.02, atol=0))
            # The plane is the ruled surface's, turned by the angle.
            n = np.cos(u) * second + np.sin(u) * third
            tends.append(abs(n @ axis) < 1e-12 and abs(n @ move) < 1e-12)
    judge("cones-ruled-limit", len(tends) == 24 and all(tends))


def test_eq03_line_contact(judge):
    first = D((u, v), F(""))
    second = D((u, v), first)
    assert zero(first - F("x") * u - F("y") * v)
    agrees = [zero(second - QUADRATIC), zero(D((u, v), second) - CUBIC)]
    # z + w t has no second and no third derivative.
    judge("cones-eq03", all(agrees))


def test_eq04_resultant(judge):
    resultant = sp.resultant(QUADRATIC.subs(v, 1), CUBIC.subs(v, 1), u)

    def is_resultant(form):
        return sp.expand(resultant - form) == 0

    judge("cones-eq04", is_resultant(EQ4_PRINTED), right=is_resultant(EQ4))
    assert len(EQ4.args) == 13 and len({*EQ4.args} - {*EQ4_PRINTED.args}) == 9  # nine terms
    # A second way, whole numbers: over two lines (p, q), (r, s) it's the cubic at the one times
    # the cubic at the other.
    wrong = 0
    for p1, q1, p2, q2, *cubic in np.random.default_rng(4).integers(-9, 10, (30, 8)).tolist():
        here = dict(zip((_k, _l, _m, _n), cubic, strict=True))
        here |= {_a: p1 * p2, _b: sp.Rational(p1 * q2 + p2 * q1, 2), _c: q1 * q2}
        both = CUBIC.subs(here).subs({u: q1, v: -p1}) * CUBIC.subs(here).subs({u: q2, v: -p2})
        assert EQ4.subs(here) == both
        wrong += EQ4_PRINTED.subs(here) != both
    assert wrong > 25


def test_solutions_that_jump(judge):
    second = x * u**3 - sp.Abs(x) * v**3
    lines = {}
    for place in (2, -2, 0):
        system = [e.subs({x: place, u: 1}) for e in (u**2 - v**2, second)]  # u = 0 gives v = 0
        roots = [root for root in sp.roots(system[0], v) if system[1].subs(v, root) == 0]
        lines[place] = {(1, root) for root in roots}
    judge("cones-jump", lines == {2: {(1, 1)}, -2: {(1, -1)}, 0: {(1, 1), (1, -1)}})


def test_four_solutions_on_the_circle(judge):
    # A solution is multiple where the form and the circle have one tangent. There the form's value
    # and this determinant would vanish together; they do so only with fxx fyy - fxy^2 = 0.
    circle = u**2 + v**2
    determinant = sp.expand(QUADRATIC.diff(u) * v - QUADRATIC.diff(v) * u)
    saddle = sp.expand(_a * _c - _b**2)
    rest = QUADRATIC * ((_a + _c) * circle - QUADRATIC)
    identity = determinant**2 + 4 * saddle * circle**2 - 4 * rest
    simple = sp.expand(identity) == 0
    four = []
    for numbers in ((1, 0, -1), (0, 1, 0), (2, 3, 1), (-1, 2, 5)):
        form = QUADRATIC.subs(dict(zip((_a, _b, _c), numbers, strict=True)))
        solutions = sp.solve([form, circle - 1], [u, v])
        four.append(len(set(solutions)) == 4 and all(s.is_real for pair in solutions for s in pair))
    judge("cones-four-solutions", simple and all(four))


def test_discriminant_of_the_asymptotic_directions(judge):
    printed = _a * _c - _b**2
    determinant = sp.hessian(QUADRATIC, (u, v)).det() / 4
    discriminant = sp.discriminant(QUADRATIC.subs(v, 1), u)
    judge("cones-discriminant", readings={
        "the form's determinant": sp.expand(determinant - printed) == 0,
        "the polynomial's discriminant": sp.expand(discriminant - printed) == 0,
    })  # fmt: skip


def _meets_eq4(surface):
    """Return at which of four points Eq. 4 holds on a surface and K <= 0."""
    found = adapted_frames(surface, *GRID, "space")
    graph = tangent_graph(found, found.smooth)
    meets = []
    for k in range(0, 20, 5):
        jet = Jet(graph.c[:, k : k + 1])
        scale = 1e-9 * (1 + np.max(np.abs(list(values(jet).values())))) ** 5
        left, hessian = at(EQ4, jet), at(_a * _c - _b**2, jet)
        assert np.isfinite([left, hessian, scale]).all()
        meets.append(abs(left) < scale and hessian <= 0)
    return meets


def test_theorem4_ruled_surfaces(judge):
    meets = [np.all(_meets_eq4(ruled(name))) for name in RULED]
    others = [np.any(_meets_eq4(surface)) for surface in GENERAL.values()]
    judge("cones-thm4", len(meets) == 6 and all(meets) and len(others) == 3 and not any(others))
    # K <= 0 is needed: x^2 + y^2 divides both forms here, and no real line does.
    jet = (lambda a, b: (a * a + b * b) * (0.5 + a))(*jet_variables(0.0, 0.0))
    assert at(EQ4, jet) == 0 and at(_a * _c - _b**2, jet) > 0


def test_remark5_rulings_depend_analytically_on_the_point(judge):
    # b^2 - ac > 0 keeps the two asymptotic directions apart, so that each is a formula in the
    # second derivatives without a branch; the one that is a ruling's stays straight.
    b2 = F("xy") ** 2 - F("xx") * F("yy")
    slopes = [(-F("xy") + sign * sp.sqrt(b2)) / F("yy") for sign in (1, -1)]
    formulas = [zero(QUADRATIC.subs({u: 1, v: slope})) for slope in slopes]
    straight = []
    for graph, ruling in ((y / x, (x, y)), (sp.atan2(y, x), (x, y)), (y / x, (sp.S(0), sp.S(1)))):
        forms = jet_of(graph)
        assert sp.simplify(b2.subs(forms).subs({x: 2, y: 3})) > 0
        along = {u: ruling[0], v: ruling[1]}
        assert zero(QUADRATIC.subs(forms).subs(along)) and zero(CUBIC.subs(forms).subs(along))
        # Straight: its direction changes along itself by a multiple of itself.
        change = [ruling[0] * w.diff(x) + ruling[1] * w.diff(y) for w in ruling]
        straight.append(zero(change[0] * ruling[1] - change[1] * ruling[0]))
    judge("cones-rem5", all(formulas) and len(straight) == 3 and all(straight))
