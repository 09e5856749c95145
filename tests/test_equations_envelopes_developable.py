"""Envelopes of moving cones, section 2: developable surfaces, Eqs 1 and 2.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

from bisect import bisect
from fractions import Fraction

import numpy as np
import sympy as sp

from tests.envelopes_zoo import CURVES, DEVELOPABLE, GENERAL, GRID, MOTIONS, RULED
from tests.symbols_envelopes import D, F, t, u, v, x, y, zero
from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.adapted import adapted_frames

READS = ["report/ledger/*"]


def test_eq01_derivative_along_the_ruling(judge):
    fxx, fxy, fyy = F("xx"), F("xy"), F("yy")
    length = sp.sqrt(fyy**2 + fxy**2)
    form = fxx * fyy / length + fxy * (-fxy / length)
    judge("cones-eq01", zero(form - (fxx * fyy - fxy**2) / length))


def test_eq02_derivative_along_the_curve(judge):
    a, b = sp.Function("a")(t), sp.Function("b")(t)
    one = F("xx") * a + F("xy") * b
    third = F("xxx") * a**2 + 2 * F("xxy") * a * b + F("xyy") * b**2
    left = D((a, b), one) + one.diff(t)
    first_display = zero(left - third - F("xx") * a.diff(t) - F("xy") * b.diff(t))
    # The next display: the third-order part follows from the derivative of K by x.
    K = F("xx") * F("yy") - F("xy") ** 2
    shown = F("xxx") * F("yy") - 2 * F("xxy") * F("xy") + F("xyy") * F("xx")
    assert zero(D((1, 0), K) - shown)
    # With K = 0 it is the part of third order in (2), along (fyy, -fxy).
    along = {u: F("yy"), v: -F("xy")}
    part = (F("xxx") * u**2 + 2 * F("xxy") * u * v + F("xyy") * v**2).subs(along)
    next_display = zero(shown * F("yy") - part - F("xyy") * K)
    judge("cones-eq02", first_display and next_display)


def test_theorem2_developable_surfaces(judge):
    counts = [len(zoo) for zoo in (DEVELOPABLE, GENERAL, RULED, MOTIONS, CURVES)]
    assert counts == [8, 3, 6, 6, 6]
    curvature = {name: recognise(surface, *GRID, "developable", model="space").residual
                 for name, surface in (DEVELOPABLE | GENERAL).items()}  # fmt: skip
    vanishes = [curvature[name] < 1e-10 for name in DEVELOPABLE]
    differs = [curvature[name] > 1e-3 for name in GENERAL]
    judge("cones-thm2", len(vanishes) == 8 and all(vanishes) and all(differs))
    # The tangent plane stays along a ruling.
    s, w = np.full(7, 0.4), np.linspace(0.1, 0.7, 7)
    for surface in DEVELOPABLE.values():
        normals = adapted_frames(surface, s, w, "space").axes[:, 2]
        assert np.abs(normals - normals[0]).max() < 1e-12


def test_example1_boundary_of_positive_measure(judge):
    """The fat Cantor set: stage k leaves 2^k intervals shorter than 2^-k, of total above 1/2."""
    stage, gaps, lengths = [(Fraction(0), Fraction(1))], [], []
    for k in range(9):
        lengths.append(sum(b - a for a, b in stage))
        assert lengths[-1] == (1 + Fraction(1, 2**k)) / 2  # towards a half
        assert len(stage) == 2**k and all(b - a <= Fraction(1, 2**k) for a, b in stage)
        half = Fraction(1, 2 * 4 ** (k + 1))  # of the piece that is taken out of each middle
        middles = [((a + b) / 2 - half, (a + b) / 2 + half) for a, b in stage]
        gaps += middles
        cut = zip(stage, middles, strict=True)
        stage = [part for (a, b), (c, e) in cut for part in ((a, c), (e, b))]
    # So a gap, where a smooth g is above 0, is within 2^-k of any place that stays: all of the
    # set, where g vanishes, is boundary. Every derivative of such a g is 0 at a gap's ends.
    ends = sorted(end for gap in gaps for end in gap)
    near = [(a, max(bisect(ends, a) - 1, 0)) for a, _ in stage]
    away = [min(abs(end - a) for end in ends[k : k + 2]) for a, k in near]
    boundary = len(away) == 2**9 and max(away) < Fraction(1, 2**8)
    judge("cones-ex1", boundary and min(lengths) > Fraction(1, 2))
    bump = sp.exp(-1 / x)
    assert all(sp.limit(bump.diff(x, order), x, 0, "+") == 0 for order in range(3))
    column = sp.Function("h")(x)  # f depends on x only
    assert zero(column.diff(x, x) * column.diff(y, y) - column.diff(x, y) ** 2)


def test_remark3_at_each_point_of_example1(judge):
    # The graph of Example 1, at each of its points: the plane there touches along x = x0.
    x0 = sp.Symbol("x0")
    column = sp.Function("h")
    plane = column(x0) + column(x0).diff(x0) * (x - x0)
    touches = [zero((column(x) - plane).subs(x, x0)), plane.diff(y) == 0,
               zero((column(x) - plane).diff(x).doit().subs(x, x0).doit())]  # fmt: skip
    # So it does on the developable surfaces at hand, wherever they are looked at.
    s, here = np.linspace(0.2, 0.9, 8), np.full(8, 0.3)
    for surface in DEVELOPABLE.values():
        one, other = (adapted_frames(surface, s, w, "space").axes[:, 2] for w in (here, 2 * here))
        touches.append(np.abs(np.sum(one * other, axis=-1)).min() > 1 - 1e-12)
    judge("cones-rem3", len(touches) == 11 and all(touches))


def test_vanishing_second_derivative(judge):
    # fxx = 0 leaves f = x a(y) + b(y); the equation makes a constant.
    a, b = sp.Function("a")(y), sp.Function("b")(y)
    form = x * a + b
    assert form.diff(x, 2) == 0
    K = sp.expand(form.diff(x, 2) * form.diff(y, 2) - form.diff(x, y) ** 2)
    only_constant = zero(K + a.diff(y) ** 2)  # 0 just where a' is
    slope = sp.Symbol("slope")
    cylinder = form.subs(a, slope).doit()
    # Along the direction (1, 0, slope) it is moved into itself, with one tangent plane.
    step = sp.Symbol("step")
    same = zero(cylinder.subs(x, x + step) - cylinder - slope * step)
    constant = all(zero(cylinder.diff(c).diff(x)) for c in (x, y))
    judge("cones-fxx-zero", only_constant and same and constant)
    assert (x * y).diff(x, 2) == 0 and (x * y).diff(x, y) == 1
