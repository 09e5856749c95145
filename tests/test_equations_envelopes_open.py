"""Envelopes of moving cones, Problems 15 and 30: what the document asks, and the answers.

The proofs are written out in the report and in notebook 58; here each of their steps is an
identity at a general point, and each example a number. The verdicts stand in
report/ledger/cone-envelopes.toml.
"""

import numpy as np
import sympy as sp

from tests import symbols_open as shared
from tests.envelopes_zoo import CURVES, GRID, RULED, pipe, ruled
from tests.symbols_envelopes import D, jet_of, p, x, y
from tests.symbols_open import SLOPE, F, M, a, e, form, kappa, q, qa, tau, w, xe, xw
from tunneller_lib.envelopes import hyperosculating_cones, recognise
from tunneller_lib.envelopes.adapted import adapted_frames
from tunneller_lib.envelopes.isotropic import contact_point, normal
from tunneller_lib.envelopes.pseudo import double_root, pseudo_envelope

READS = ["report/ledger/*"]

turn = sp.Symbol("turn", real=True)  # of the direction along its integral curve
HALF_ANGLES = np.radians([5, 20, 30, 45, 70])

# ---- Problem 15 -----------------------------------------------------------------------------

r, g0, y1, y2 = sp.symbols("r g0 y1 y2", positive=True)  # y1, y2: derivatives of g'/r
sine = sp.Symbol("sine", real=True)
root = sp.Symbol("root", positive=True)


def on_the_radius(expression):
    """Return an expression at (r, 0) of a graph of revolution, by the derivatives of g'/r."""
    radial = {
        F[4, 0]: 0, F[3, 1]: 0, F[2, 2]: y2, F[1, 3]: 0, F[0, 4]: 3 * y1 / r,
        F[3, 0]: 2 * y1 + r * y2, F[2, 1]: 0, F[1, 2]: y1, F[0, 3]: 0,
        F[2, 0]: g0 + r * y1, F[1, 1]: 0, F[0, 2]: g0, x: r, y: 0,
    }  # fmt: skip
    assert F[4, 0] not in expression.subs(a, sp.pi / 2).free_symbols  # along the radius alone
    return expression.subs(radial)


def by_sine(expression):
    """Return an expression over cos(a), as a polynomial in sin(a)."""
    divided = sp.expand(sp.expand_trig(expression) / sp.cos(a))
    return sp.expand(sp.expand(divided.subs(sp.cos(a) ** 2, 1 - sine**2)).subs(sp.sin(a), sine))


def test_problem15_multiple_conics(judge):
    # A graph of revolution: q is cos(a) times a quadratic form of sin(a) ...
    quadratic = sp.Poly(by_sine(on_the_radius(q)), sine)
    assert quadratic.degree() == 2
    # ... and A (sin(a) - root)^2, if y'' = L y' with L by the root, y being g'/r.
    L = 3 * tau * root / (1 + r**2) - 2 / r
    quadratic = quadratic.as_expr().subs(y2, L * y1)
    A = sp.Poly(quadratic, sine).LC()
    by_root = {tau: (1 - r**2) / r * root / (1 + root**2)}  # its sum with 1/root is s/tau
    assert sp.simplify((quadratic - A * (sine - root) ** 2).subs(by_root)) == 0
    # Neither A is 0 nor, with the root between 0 and 1, f_ew at it.
    assert sp.simplify(A.subs(by_root) - 3 * y1 * (1 - r**2) / (1 + root**2)) == 0
    assert shared.vanishes(on_the_radius(form(e, w)) + r * y1 * sp.sin(a) * sp.cos(a))
    # So a double conic has contact of order 4 exactly, by test_open_problems. The simple roots, at
    # sin(a) = 1 and -1, turn with the radius: D_e q is -+ q_a/r, so that (12) is
    # rho^4/p q_a (kappa -+ 1/r), and q_a is not zero there.
    for sign in (1, -1):
        here = {a: sign * sp.pi / 2}
        there = on_the_radius(D(e, q) + sign * qa / x).subs(here)
        assert shared.vanishes(there)
        edge = on_the_radius(qa).subs(here).subs(y2, L * y1)
        assert shared.vanishes(edge + sign * quadratic.subs(sine, sign))
        # kappa is +-1/r at the surface's end, or beyond it.
        bend = kappa.subs({x: r, y: 0}).subs(here)
        rest = r**2 + 2 * sign * tau * r - 1
        assert shared.vanishes((bend - sign / r) * r * (1 + r**2) - sign * rest)
        assert shared.vanishes(rest.subs(r, sp.sqrt(1 + tau**2) - sign * tau))
    # A conic over a line, tau = x.w, stands for a cone with the normal (0, 0, -1). With the roots
    # of q that is sin(a) = -1 at r = tau alone, where f_eeee = 3 y'/r: it doesn't stay.
    assert shared.vanishes((tau - xw).subs({x: r, y: 0, a: -sp.pi / 2}) - (tau - r))
    powers = sp.symbols("c:6")
    graph = sum(c * (x**2 + y**2) ** k for k, c in enumerate(powers))
    y_of_r = (graph.subs(y, 0).diff(x) / x).subs(x, r)
    assert shared.vanishes(graph.diff(y, 4).subs({y: 0, x: r}) - 3 * y_of_r.diff(r) / r)
    # The library's graph is that example: Eqs 9, 11, 12 and 14 hold twice, and no conic stays.
    satisfied = []
    contained = []
    for half_angle in HALF_ANGLES:
        f = pseudo_envelope(half_angle)
        distance = np.linspace(0.1, 0.9, 9) * np.tan(np.pi / 4 - half_angle / 2)
        cones = hyperosculating_cones(f, distance * 0.8, distance * 0.6, half_angle=half_angle)
        several = cones.multiplicity > 1
        satisfied.append(np.array_equal(np.bincount(cones.index[several]), np.full(9, 2)))
        satisfied.append(np.abs(cones.order4[several]).max() < 1e-6)
        contained.append(np.abs(cones.order4[~several]).min() < 1e-3)
        sines = double_root(half_angle, distance)
        contained.append((sines * np.sqrt(1 - sines**2)).min() < 1e-3)  # f_ew over r y'
    assert all(satisfied)
    judge("cones-problem15", any(contained))
    # A second way: values of the graph along the double conic's circle, no derivative. Over
    # 1 - cos(t) and sin(t) its even and odd half are constant to t^3 by contact of order 4, and to
    # all orders where the conic stays in the graph.
    steps = np.array([0.04, 0.02, 0.01])
    for half_angle, start in ((np.radians(20), 0.3), (np.radians(30), 0.25), (np.radians(60), 0.1)):
        sin_a = double_root(half_angle, start)
        radius = (1 + start**2) / 2 / (np.tan(half_angle) + start * sin_a)
        centre = start - radius * sin_a + 1j * radius * np.sqrt(1 - sin_a**2)
        places = centre + np.exp(1j * np.array([steps, -steps])) * (start - centre)
        f = pseudo_envelope(half_angle)
        plus, minus = f(places.real, places.imag) - f(start, 0.0)
        for half in ((plus + minus) / (1 - np.cos(steps)), (plus - minus) / np.sin(steps)):
            change = np.diff(half)
            assert 3.9 < np.log2(abs(change[0] / change[1])) < 4.15


def test_problem15_envelope_of_paraboloids(judge):
    # Lemma: this identity at a general point. A field a(x, y) with q = q_a = 0 has grad q = 0 and
    # D_e q_a = -a_e q_aa, so that (I): q_aa (kappa - a_e) = 24 (1 + tau^2) f_ew/p.
    left = D(e, qa) + kappa * shared.qaa
    right = 3 * D(w, q) + (6 * (xw - 2 * tau) * q + 4 * xe * qa) / p
    identity = shared.vanishes((left - right) * p - 24 * (1 + tau**2) * form(e, w))
    # A conic that stays turns with its field, a_e = kappa: f_ew = 0, then f_eee = 0 by q, and
    # Problem 30's answer for channels. Back: D_e f_ew = 0 and q_a = 0 give a_e = kappa.
    back = 3 * p * (form(e, e, w) + kappa * (form(w, w) - form(e, e))) + 6 * xe * form(e, w)
    steps = [identity, shared.vanishes(qa - back)]
    steps.append(shared.vanishes(D(e, form(e, w)) + turn * form(e, w).diff(a) - (
        form(e, e, w) + turn * (form(w, w) - form(e, e)))))  # fmt: skip
    # An example: a channel whose radius grows with the arc has one double conic a point, and it
    # stays; the surface is a channel. The other: one that has two, and isn't enveloped by them.
    slope = np.arcsin(0.1 / np.sqrt(1.16))
    channel = pipe(CURVES["helix"], 0.3, 0.1)
    cones = hyperosculating_cones(channel, *GRID, half_angle=slope, model="space")
    double = cones.multiplicity == 2
    assert np.array_equal(np.sort(cones.index[double]), np.arange(20))
    assert np.abs(cones.order4[double]).max() < 1e-10
    steps.append(recognise(channel, *GRID, "channel", model="space").verdict == "is")
    stays = []
    for half_angle in HALF_ANGLES:
        distance = np.linspace(0.1, 0.9, 9) * np.tan(np.pi / 4 - half_angle / 2)
        sines = double_root(half_angle, distance)
        stays.append((sines * np.sqrt(1 - sines**2)).min() < 1e-3)
        # Its spheres touch along parallels, which stand for cones of other angles.
        assert np.all(np.pi / 2 - 2 * np.arctan(distance) > half_angle + 0.01)
    judge("cones-problem15-envelope", cases={
        "where the conics lie in the graph": all(steps),
        "where Eqs 9, 11, 12 and 14 hold, no more": any(stays),
    })  # fmt: skip


# ---- Problem 30 -----------------------------------------------------------------------------


def along(expression):
    """Return the derivative along an integral curve of the field e, whose direction turns."""
    return D(e, expression) + turn * expression.diff(a)


def test_problem30_cylinders(judge):
    # The offset by R turns Eq. 24 into M(e, e) = 0; (11) and (23) don't see it.
    R = sp.Symbol("R", real=True)
    moved = {F[0, 0]: F[0, 0] + R * p / 2, F[1, 0]: F[1, 0] + R * x, F[0, 1]: F[0, 1] + R * y,
             F[2, 0]: F[2, 0] + R, F[0, 2]: F[0, 2] + R}  # fmt: skip
    eq24 = p * form(e, e) + 2 * (shared.HEIGHT - R)
    steps = [shared.vanishes(eq24.subs(moved, simultaneous=True) - M)]
    steps.append(shared.vanishes(form(e, w).subs(moved, simultaneous=True) - form(e, w)))
    # By (11), p f_eee = 6 (x.w) f_ew, the derivative of M along e is 2 f_ew (2 x.w + p turn).
    eleven = q.subs(tau, 0)
    steps.append(shared.vanishes(along(M) - eleven - 2 * form(e, w) * (2 * xw + p * turn)))
    steps.append(shared.vanishes(M.diff(a) - 2 * p * form(e, w)))  # so f_ew isn't 0 where det M < 0
    # Either the curve turns by 1/rho, which then stays, and f''' + f' = 0 in its angle ...
    bend = kappa.subs(tau, 0)
    steps.append(shared.vanishes(D(e, bend) + bend * bend.diff(a)))
    third = F[0, 0]
    for _ in range(3):
        third = D(e, third) + turn * third.diff(a)
    rest = form(e, e, e) + 3 * turn * form(e, w)
    steps.append(shared.vanishes(third + turn**2 * form(e) - rest))
    # ... or f_ew = 0, and then M along e leaves f_eee = 0: a pipe, by the next tests.
    steps.append(shared.vanishes(along(M) - p * form(e, e, e) - 2 * form(e, w) * (p * turn - xw)))
    # Seen on surfaces: those of which the equations hold are offsets of ruled ones.
    for name in RULED:
        places = adapted_frames(ruled(name, 0.1), *GRID, "space")
        found = recognise(ruled(name, 0.1), *GRID, "cylinder", model="space")
        back = places.contact + found.radius * places.axes[:, 2]
        rulings = np.stack([c + 0 * GRID[0] for c in ruled(name)(*GRID)], axis=-1)
        steps.append(found.verdict == "is" and np.abs(back - rulings).max() < 1e-9)
    judge("cones-problem30", len(steps) == 13 and all(steps))


def directions(*forms):
    """Return the sines of all angles at which forms vanish together."""
    found = sp.solve([sp.simplify(form) for form in forms], a)
    assert len(found) > 0
    return {sp.simplify(sp.sin(*angle)) for angle in found}


def paraboloid():
    """Return c = grad f - lambda x and d of the paraboloid (7) with lambda = f_ee that touches."""
    c = [slope - form(e, e) * place for slope, place in zip(SLOPE, (x, y), strict=True)]
    return c, F[0, 0] - form(e, e) * (x**2 + y**2) / 2 - c[0] * x - c[1] * y


def test_problem30_channels(judge):
    # With f_ew = f_eee = 0 along e: lambda = f_ee, c = grad f - lambda x and the paraboloid's
    # height d stay, so that one paraboloid (7) touches along the curve.
    c, d = paraboloid()
    change = form(e, e, e) + 2 * turn * form(e, w)
    steps = [shared.vanishes(along(form(e, e)) - change)]
    for k, place in enumerate((x, y)):
        steps.append(shared.vanishes(along(c[k]) - form(e, w) * w[k] + change * place))
    steps.append(shared.vanishes(along(d) - change * (x**2 + y**2) / 2 + form(e, w) * xw))
    # With the clauses: 1 + y^3 solves (26), in the direction of straight top views alone, and so
    # has no conic over a circle.
    graph = 1 + y**3
    sines = directions(form(e, w).subs(jet_of(graph)), form(e, e, e).subs(jet_of(graph)))
    judge("cones-problem30-channels", sines != {0}, right=all(steps))
    # A second way: points of that surface. Those over a line y = const lie on one sphere, which
    # touches z = 0 with the normal (0, 0, -1), and the plane of their normals goes through that.
    top = np.array([0, 1 / 2, -2 / 3, 3])
    for b in (1 / 3, 1 / 5):
        n, height, slope = np.stack(normal(top, b)), 1 + b**3, 3 * b**2
        radius = height - b * slope  # Eq. 24 with f_ee = 0
        centres = np.stack(contact_point(top, b, height, 0 * top, slope)) + radius * n
        assert np.ptp(centres, axis=1).max() < 1e-14 and abs(centres[2, 0] + radius) < 1e-14
        assert np.abs(n[1] - b * (n[2] + 1)).max() < 1e-15


def test_problem30_pipes(judge):
    # With f_ew = 0 the radius p f_ee/2 + f - x.grad f changes by p f_eee/2 along e: f_eee = 0 ...
    radius = p * form(e, e) / 2 + shared.HEIGHT
    change = p * form(e, e, e) / 2 + (p * turn - xw) * form(e, w)
    steps = [shared.vanishes(along(radius) - change)]
    # ... so it's a channel, and the radius of its sphere, lambda/2 + d, is that one: with R
    # constant the curve lies where lambda' (|x|^2 - 1)/2 + c'.x = 0, over a great circle.
    _, d = paraboloid()
    steps.append(shared.vanishes(form(e, e) / 2 + d - radius))
    sphere = sp.symbols("n1 n2 n3")
    top = [sphere[0] / (sphere[2] + 1), sphere[1] / (sphere[2] + 1)]
    flat = (top[0] ** 2 + top[1] ** 2 - 1) / 2
    flat = flat.subs(sphere[0] ** 2, 1 - sphere[1] ** 2 - sphere[2] ** 2)
    on_sphere = sp.simplify(flat.subs(sphere[0], sp.sqrt(1 - sphere[1] ** 2 - sphere[2] ** 2)))
    steps.append(sp.simplify(on_sphere + sphere[2] / (sphere[2] + 1)) == 0)  # linear over n3 + 1
    # With the clauses: a torus about a vertical axis, whose circles go through (0, 0, -1).
    far, bend, R = sp.symbols("far bend R", positive=True)
    torus = bend * (x**2 + y**2) / 2 + far * sp.sqrt(x**2 + y**2) + R - bend / 2
    at = {y: 0, x: sp.Rational(2, 3)}  # it is one of revolution
    jet, eq24 = jet_of(torus), p * form(e, e) + 2 * (shared.HEIGHT - R)
    sines = directions(*(part.subs(jet).subs(at) for part in (eq24, form(e, w))))
    judge("cones-problem30-pipes", sines != {0}, right=all(steps))
    # A second way: that torus by its own circles. Spheres of its tube's radius touch it along
    # them, and their planes hold the axis, so they are parallel to (0, 0, -1).
    ring, tube = 2.0, 0.5
    around = np.linspace(0.1, 6.2, 9)
    for turned in (0.3, 1.9):
        out = np.array([np.cos(turned), np.sin(turned), 0.0])
        n = np.cos(around)[:, None] * out + np.sin(around)[:, None] * [0.0, 0.0, 1.0]
        points = ring * out + tube * n
        implicit = (np.hypot(points[:, 0], points[:, 1]) - ring) ** 2 + points[:, 2] ** 2
        assert np.allclose(implicit, tube**2, rtol=1e-14)
        assert np.abs(points @ np.cross(out, [0.0, 0.0, 1.0])).max() < 1e-15
