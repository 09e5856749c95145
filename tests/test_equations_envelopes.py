"""Envelopes of moving cones, claim by claim: one proof a row of report/ledger/cone-envelopes.toml.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved.
"""

from fractions import Fraction
from itertools import pairwise
from math import comb, factorial

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq, minimize

from tests.envelopes_zoo import CURVES, DEVELOPABLE, GENERAL, GRID, MOTIONS, RULED, pipe, ruled
from tests.shapes import directions
from tunneller_lib.envelopes import hyperosculating_cones, recognise
from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet, model_jet, tangent_graph
from tunneller_lib.envelopes.blade import BladeRing, cone_distance
from tunneller_lib.envelopes.conics import cone_vertex, conic, osculating_conic
from tunneller_lib.envelopes.developable import osculating_cone, tangent_planes
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.fit import fit_planes, mean_frame, tilted
from tunneller_lib.envelopes.hyperosculate import order_four
from tunneller_lib.envelopes.isotropic import (
    cone_planes,
    contact_point,
    isotropic_derivatives,
    normal,
    plane_to_point,
    point_to_plane,
    sphere_point,
    surface_points,
)  # fmt: skip
from tunneller_lib.envelopes.jet import Jet, differentiated, jet_variables

x, y, u, v, t, g, tan = sp.symbols("x y u v t g tan", real=True)
f = sp.Function("f")(x, y)
p, W = 1 + x**2 + y**2, 1 + x**2 + y**2 + 2 * x * u + 2 * y * v
ANGLE, SMALL = np.radians(30), np.radians(20)


def d(*order):
    """Return a partial derivative of f."""
    return f.diff(*order)


# The graph's derivatives as plain symbols, for polynomial identities.
NAMES = {(i, j): sp.Symbol(f"f{'x' * i}{'y' * j}") for i in range(5) for j in range(5 - i)}
PLAIN = {d(*([(x, i)] if i else []), *([(y, j)] if j else [])): s
         for (i, j), s in sorted(NAMES.items(), reverse=True) if i + j}  # fmt: skip


def plain(expression):
    for derivative, symbol in sorted(PLAIN.items(), key=lambda pair: -len(str(pair[1]))):
        expression = expression.subs(derivative, symbol)
    return sp.expand(expression)


def F(name):
    return NAMES[name.count("x"), name.count("y")]


def on_circle(expression, order):
    """Return the derivative at t = 0 along the circle (8), of an expression in x and y."""
    X = x + v * sp.sin(t) + u * (1 - sp.cos(t))
    Y = y - u * sp.sin(t) + v * (1 - sp.cos(t))
    # Derivatives by the chain rule: d/dt along a motion with x' = v cos + u sin, y' = ...
    xs, ys = X.diff(t), Y.diff(t)
    for _ in range(order):
        expression = expression.diff(x) * xs + expression.diff(y) * ys + expression.diff(t)
    return sp.expand(expression.subs(t, 0))


EQ11 = (F("xxx") * v**3 - 3 * F("xxy") * v**2 * u + 3 * F("xyy") * v * u**2 - F("yyy") * u**3
        + 3 * (F("xx") - F("yy")) * u * v + 3 * F("xy") * (v**2 - u**2))  # fmt: skip
LOWER = (6 * u * v**2 * F("xxx") + 6 * v * (v**2 - 2 * u**2) * F("xxy")
         + 6 * u * (u**2 - 2 * v**2) * F("xyy") + 6 * u**2 * v * F("yyy")
         + 3 * (u**2 - v**2) * (F("xx") - F("yy")) + 12 * u * v * F("xy"))  # fmt: skip
EQ12 = (F("xxxx") * v**4 - 4 * F("xxxy") * v**3 * u + 6 * F("xxyy") * v**2 * u**2
        - 4 * F("xyyy") * v * u**3 + F("yyyy") * u**4 + LOWER)  # fmt: skip
EQ9 = W**2 - 4 * tan**2 * (u**2 + v**2)
UT, VT = 2 * x * W - 4 * u * tan**2, 2 * y * W - 4 * v * tan**2  # Eq. 15, corrected


def eq14(ut, vt):
    return (F("xxx") * v**2 * ut + F("xxy") * v * (v * vt - 2 * u * ut)
            + F("xyy") * u * (u * ut - 2 * v * vt) + F("yyy") * u**2 * vt
            + (F("xx") - F("yy")) * (u * ut - v * vt)
            + 2 * F("xy") * (u * vt + v * ut))  # fmt: skip


def zero(expression):
    return sp.simplify(expression) == 0


def example(a, b):
    return b**2 / (a**2 + b**2)


def values(jet):
    """Return a jet's derivatives at its one point, for substitution into the symbols."""
    return {s: float(np.ravel(jet.derivative(*order))[0]) for order, s in NAMES.items()}


def at(expression, jet, **more):
    more = {sp.Symbol(name, real=True): value for name, value in more.items()}
    return float(expression.subs(values(jet)).subs(more))


def general_jet(surface, s, t):
    """Return x, y and f's jet in the model's own frame, at one point of a surface in space."""
    px, py, jet = model_jet(surface, np.array([s]), np.array([t]))
    return float(px[0]), float(py[0]), jet


def circle_centre(points):
    """Return the centre of the circle through the top views of three points."""
    points = np.asarray(points)[:, :2]
    square = (points**2).sum(axis=1)
    return np.linalg.solve(2 * (points[1:3] - points[0]), square[1:3] - square[0])


def circle_planes(centre, radius, rulings):
    """Return points of the planes through a centre's tangent sphere with given normals."""
    return plane_to_point(rulings, radius - rulings @ centre)


def intrinsic_radius(points):
    """Return the radius on the unit sphere of the circle over which planes' points lie."""
    n = np.stack(normal(points[:, 0], points[:, 1]), axis=-1)
    pole = np.cross(n[1] - n[0], n[2] - n[0])
    angle = np.arccos(np.clip(n @ pole / np.linalg.norm(pole), -1, 1))
    assert np.ptp(angle) < 1e-9
    return min(angle[0], np.pi - angle[0])


def cone_points(vertex, axis, half_angle, n=9):
    return plane_to_point(*cone_planes(vertex, axis, half_angle, 2 * np.pi * np.arange(n) / n))


# ---- section 1: what tools do -----------------------------------------------------------------


def test_point_contact_of_second_order():
    # A cone's graph has a Hessian of determinant 0, and contact of order 2 shares the Hessian.
    cone = tan * sp.sqrt(x**2 + y**2)
    assert zero(cone.diff(x, 2) * cone.diff(y, 2) - cone.diff(x, y) ** 2)
    # A cone of 45 degrees that leaves a surface of revolution by the third power of the height,
    # all along a circle: K is 0 on that circle, and not beside it.
    height = sp.Symbol("height")
    away = sp.expand((1 + height + height**3) ** 2 - (1 + height) ** 2)
    assert sp.Poly(away, height).terms()[-1] == ((3,), 2)

    def surface(s, t):
        return [(1 + t + t**3) * np.cos(s), (1 + t + t**3) * np.sin(s), t]

    around, heights = np.meshgrid(np.linspace(0, 6, 7), [-0.1, 0.0, 0.1])
    state = hyperosculating_cones(surface, around, heights, half_angle=ANGLE, model="space").state
    assert np.all((state == "flat") == (heights == 0)) and np.all(state[::2] == "regular")
    assert recognise(surface, around, heights, "developable", model="space").verdict == "is not"


def test_osculation_penetrates():
    # Surfaces: the first form by which graphs of exact order 2 differ takes both signs.
    assert zero(CUBIC.subs({u: -u, v: -v}, simultaneous=True) + CUBIC)
    # Cones of 30 degrees, as sets of planes: points of the surface of Example 31 over the cone's
    # circle are within the cone on one side of the contact, outside on the other.
    here = 0.5, 0.3
    jet = example(*jet_variables(*here))
    steps = np.array([2e-4, -2e-4, 4e-4])
    for turn in np.linspace(0.1, 6.1, 13):
        way = np.array([np.cos(turn), np.sin(turn)])
        centre = way * (1 + np.dot(here, here)) / (2 * np.tan(ANGLE) - 2 * np.dot(here, way))
        names = dict(zip("xyuv", (*here, *centre), strict=True))
        assert abs(at(EQ9.subs(tan, np.tan(ANGLE)), jet, **names)) < 1e-9
        assert abs(at(EQ11, jet, **names)) > 1e-3  # of no higher order
        contact = np.array([*here, jet.value])
        _, a, b = osculating_conic(centre, example(*jet_variables(*here)))
        n, _ = point_to_plane(conic(contact, centre, a, b, np.array([0.0, 2.0, 4.0])))
        axis = np.linalg.solve(n, np.full(3, np.sin(ANGLE)))
        px, py, _ = conic(contact, centre, a, b, steps / np.hypot(*centre)).T
        near = example(*jet_variables(px, py))
        r = contact_point(px, py, near.value, near.derivative(1, 0), near.derivative(0, 1))
        out = np.stack(r, axis=-1) - cone_vertex(contact, centre, a, b)
        deep = (out @ axis) ** 2 - np.cos(ANGLE) ** 2 * np.sum(out**2, axis=-1)
        assert deep[0] * deep[1] < 0 and abs(np.log2(deep[2] / deep[0]) - 3) < 0.1


def test_cylinders_mill_what_has_a_ruled_offset():
    # A surface whose offset is ruled touches the cylinders about the rulings.
    s, t = GRID
    for name, lines in RULED.items():
        r = np.stack(np.broadcast_arrays(*ruled(name, 0.1)(s, t)), axis=-1)
        found = adapted_frames(ruled(name, 0.1), s, t, "space")
        point, _, along, _ = (np.stack(np.broadcast_arrays(*c), axis=-1) for c in lines(s))
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        out = r - point
        out = out - np.sum(out * along, axis=-1, keepdims=True) * along
        np.testing.assert_allclose(np.linalg.norm(out, axis=-1), 0.1, rtol=1e-12)
        across = np.linalg.norm(np.cross(out, found.axes[:, 2]), axis=-1)
        assert np.max(across) < 1e-12

    # One tolerance: where a ruled surface errs by so much from the offset, so does the cylinder.
    def offset(a, b):
        return np.array([a, b, a * b + 0.01 * np.cos(3 * a) * np.cos(2 * b)])

    def away(place, start):
        best = minimize(lambda at: np.sum((offset(*at) - place) ** 2), start, tol=1e-14)
        return np.sqrt(best.fun)

    places = [(a, b) for a in np.linspace(-0.5, 0.5, 5) for b in np.linspace(-0.5, 0.5, 5)]
    axes, milled = (
        np.array([np.stack(ruled("saddle", radius)(*place)) for place in places])
        for radius in (0.0, 0.1)
    )
    starts = [axis[:2] for axis in axes]
    erring = np.array([away(*both) for both in zip(axes, starts, strict=True)])
    errors = np.array([abs(away(*both) - 0.1) for both in zip(milled, starts, strict=True)])
    assert 0.007 < np.max(erring) <= 0.01
    np.testing.assert_allclose(errors, erring, atol=2e-4)


def test_cones_mill_a_hyperboloid():
    a, c, z = sp.symbols("a c z", positive=True)
    focal = sp.sqrt(a**2 + c**2)
    outside = (x**2 + y**2) / a**2 - z**2 / c**2 - 1
    # Vertex (focal, 0, 0), axis along y, tan(theta) = c/a: its points have y^2 >= wall.
    wall = ((x - focal) ** 2 + z**2) * (a / c) ** 2
    left = sp.expand(outside.subs(y, sp.sqrt(wall)))
    assert zero(left - (focal * x - a**2) ** 2 / (a * c) ** 2)  # a square: touches, never enters
    assert outside.diff(y) == 2 * y / a**2  # and deeper in the cone it's farther outside
    # The conic of contact meets every parallel circle, so that turning covers the surface.
    assert zero((x**2 + wall).subs(x, a**2 / focal) - a**2 * (1 + z**2 / c**2))
    # Contact along the surface's own rulings is another matter: along a cone's ruling the
    # tangent plane stays, and so would the surface's.
    ruling = sp.Matrix([sp.cos(t), sp.sin(t), tan])
    n = (g * ruling).diff(g).cross((g * ruling).diff(t))
    assert all(zero(e) for e in n - g * ruling.cross(ruling.diff(t)))
    # A second way: the library finds these cones from the surface's derivatives alone, and none
    # of the surface's points lies within them.
    around, heights = np.meshgrid(np.linspace(-np.pi, np.pi, 361), np.linspace(-2, 2, 161))
    for radius, height in ((1, 1), (2, 1)):

        def surface(s, t, radius=radius, height=height):
            size = radius * np.sqrt(1 + t * t / height**2)
            return [size * np.cos(s), size * np.sin(s), t]

        assert recognise(surface, *GRID, "ruled", model="space").verdict == "is"
        assert recognise(surface, *GRID, "developable", model="space").verdict == "is not"
        angle = np.arctan(height / radius)
        cones = hyperosculating_cones(surface, *GRID, half_angle=angle, model="space")
        which = np.flatnonzero(cones.undecided)  # those with contact of order 4
        assert set(cones.index[which]) == set(range(GRID[0].size))
        vertex, axis = cones.vertex[which], cones.axis[which]
        circle = np.hypot(vertex[:, 0], vertex[:, 1])
        np.testing.assert_allclose(circle, np.hypot(radius, height), rtol=1e-9)
        assert np.max(np.abs(vertex[:, 2])) < 1e-9 and np.max(np.abs(axis[:, 2])) < 1e-9
        assert np.max(np.abs(np.sum(vertex * axis, axis=-1))) < 1e-9
        points = np.stack(surface(around, heights), axis=-1)
        for k in range(0, len(which), 9):
            distance = cone_distance(points, vertex[k], axis[k], angle, 0.0, 4.0)
            assert -1e-12 < distance.min() < 1e-3


# ---- section 2: developable surfaces ----------------------------------------------------------


def test_eq01_derivative_along_the_ruling():
    fxx, fxy, fyy = d(x, x), d(x, y), d(y, y)
    length = sp.sqrt(fyy**2 + fxy**2)
    assert zero(fxx * fyy / length + fxy * (-fxy / length) - (fxx * fyy - fxy**2) / length)


def test_eq02_derivative_along_the_curve():
    a, b = sp.Function("a")(t), sp.Function("b")(t)
    h = sp.Function("h")
    fxx, fxy = h(x, y).diff(x, x), h(x, y).diff(x, y)
    along = [e.diff(x) * a + e.diff(y) * b for e in (fxx, fxy)]
    left = along[0] * a + fxx * a.diff(t) + along[1] * b + fxy * b.diff(t)
    third = fxx.diff(x) * a**2 + 2 * fxx.diff(y) * a * b + fxy.diff(y) * b**2
    assert zero(left - third - fxx * a.diff(t) - fxy * b.diff(t))
    # The next display: the third-order part follows from the derivative of K by x.
    K = d(x, x) * d(y, y) - d(x, y) ** 2
    shown = d(x, x, x) * d(y, y) - 2 * d(x, x, y) * d(x, y) + d(x, y, y) * d(x, x)
    assert zero(K.diff(x) - shown)
    # With K = 0 it is the part of third order in (2), along (fyy, -fxy).
    along = {u: F("yy"), v: -F("xy")}
    part = (F("xxx") * u**2 + 2 * F("xxy") * u * v + F("xyy") * v**2).subs(along)
    rest = F("xyy") * (F("xx") * F("yy") - F("xy") ** 2)
    assert zero(plain(shown) * F("yy") - part - rest)


def test_theorem2_developable_surfaces():
    assert (len(DEVELOPABLE), len(GENERAL), len(RULED), len(MOTIONS), len(CURVES)) == (
        8,
        3,
        6,
        6,
        6,
    )
    for surface in DEVELOPABLE.values():
        assert recognise(surface, *GRID, "developable", model="space").residual < 1e-10
    for surface in GENERAL.values():
        assert recognise(surface, *GRID, "developable", model="space").residual > 1e-3
    # The tangent plane stays along a ruling.
    s, w = np.full(7, 0.4), np.linspace(0.1, 0.7, 7)
    normals = adapted_frames(DEVELOPABLE["tangents of the cubic"], s, w, "space").axes[:, 2]
    assert np.abs(normals - normals[0]).max() < 1e-12


def test_example1_boundary_of_positive_measure():
    """The fat Cantor set: stage k leaves 2^k intervals shorter than 2^-k, of total above 1/2."""
    stage, gaps = [(Fraction(0), Fraction(1))], []
    for k in range(9):
        assert sum(b - a for a, b in stage) == (1 + Fraction(1, 2**k)) / 2  # towards a half
        assert len(stage) == 2**k and all(b - a <= Fraction(1, 2**k) for a, b in stage)
        half = Fraction(1, 2 * 4 ** (k + 1))  # of the piece that is taken out of each middle
        middles = [((a + b) / 2 - half, (a + b) / 2 + half) for a, b in stage]
        gaps += middles
        stage = [
            part for (a, b), (c, e) in zip(stage, middles, strict=True) for part in ((a, c), (e, b))
        ]
    # So a gap, where a smooth g is above 0, is within 2^-k of any place that stays: all of the
    # set, where g vanishes, is boundary. Every derivative of such a g is 0 at a gap's ends.
    for a, _ in stage:
        assert min(abs(end - a) for gap in gaps for end in gap) < Fraction(1, 2**8)
    bump = sp.exp(-1 / x)
    assert all(sp.limit(bump.diff(x, order), x, 0, "+") == 0 for order in range(3))
    column = sp.Function("h")(x)  # f depends on x only
    assert zero(column.diff(x, x) * column.diff(y, y) - column.diff(x, y) ** 2)


def test_remark3_at_each_point_of_example1():
    # The graph of Example 1, at each of its points: the plane there touches along x = x0.
    x0 = sp.Symbol("x0")
    column = sp.Function("h")
    plane = column(x0) + column(x0).diff(x0) * (x - x0)
    assert zero((column(x) - plane).subs(x, x0))
    assert zero((column(x) - plane).diff(x).doit().subs(x, x0).doit()) and plane.diff(y) == 0
    # So it does on the developable surfaces at hand, wherever they are looked at.
    s, here = np.linspace(0.2, 0.9, 8), np.full(8, 0.3)
    for name, surface in DEVELOPABLE.items():
        one, other = (adapted_frames(surface, s, w, "space").axes[:, 2] for w in (here, 2 * here))
        assert np.abs(np.sum(one * other, axis=-1)).min() > 1 - 1e-12, name


# ---- section 3: ruled surfaces ----------------------------------------------------------------

QUADRATIC = F("xx") * u**2 + 2 * F("xy") * u * v + F("yy") * v**2
CUBIC = F("xxx") * u**3 + 3 * F("xxy") * u**2 * v + 3 * F("xyy") * u * v**2 + F("yyy") * v**3
_a, _b, _c = F("xx"), F("xy"), F("yy")
_k, _l, _m, _n = F("xxx"), F("xxy"), F("xyy"), F("yyy")
EQ4 = (_c**3 * _k**2 + 6 * _c * _k * _n * _b * _a - 6 * _c**2 * _k * _m * _a
       - 6 * _n * _m * _a**2 * _b + 9 * _c * _m**2 * _a**2 - 6 * _b * _c**2 * _l * _k
       + 12 * _b**2 * _l * _n * _a - 18 * _b * _c * _l * _m * _a + 12 * _c * _m * _b**2 * _k
       - 8 * _n * _b**3 * _k + 9 * _a * _c**2 * _l**2 - 6 * _c * _l * _n * _a**2
       + _n**2 * _a**3)  # fmt: skip
EQ4_PRINTED = (_c**3 * _k**2 + 6 * _c * _k * _n * _b * _a - 6 * _c**2 * _k * _b * _a
               - 6 * _n * _b * _a**2 * _b + 9 * _c * _b**2 * _a**2 - 6 * _b * _c**2 * _b * _k
               + 12 * _b**2 * _b * _n * _a - 18 * _b * _c * _b * _n * _a
               + 12 * _c * _b * _b**2 * _k - 8 * _n * _b**3 * _k + 9 * _a * _c**2 * _b**2
               - 6 * _c * _k * _n * _a**2 + _n**2 * _a**3)  # fmt: skip


def test_ruled_surfaces_as_limits():
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
            np.testing.assert_allclose(np.divide(gaps[:2], gaps[1:]), 10, rtol=0.02)
            # The plane is the ruled surface's, turned by the angle.
            n = np.cos(u) * second + np.sin(u) * third
            assert abs(n @ axis) < 1e-12 and abs(n @ move) < 1e-12


def test_eq03_line_contact():
    derivative = f
    for order in (1, 2, 3):
        derivative = sp.expand(derivative.diff(x) * u + derivative.diff(y) * v)
        form = {1: F("x") * u + F("y") * v, 2: QUADRATIC, 3: CUBIC}[order]
        assert zero(plain(derivative) - form)


def test_eq04_resultant():
    resultant = sp.resultant(QUADRATIC.subs(v, 1), CUBIC.subs(v, 1), u)
    assert sp.expand(resultant - EQ4) == 0
    assert sp.expand(resultant - EQ4_PRINTED) != 0
    assert len(EQ4.args) == 13 and len({*EQ4.args} - {*EQ4_PRINTED.args}) == 9  # nine terms
    # The printed terms aren't of one degree in third derivatives, and fail on a ruled surface.
    third = sp.Symbol("lambda")
    graded = sp.Poly(EQ4_PRINTED.subs({s: third * s for s in (_k, _l, _m, _n)}), third)
    assert len(graded.monoms()) > 1
    jet = (lambda a, b: (a + 2 * b) * (b - a) / (1 + a + 2 * b))(*jet_variables(0.3, 0.4))
    assert abs(at(EQ4, jet)) < 1e-10 < 1e-3 < abs(at(EQ4_PRINTED, jet))
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


def test_solutions_that_jump():
    for place, lines in ((2, {(1, 1)}), (-2, {(1, -1)}), (0, {(1, 1), (1, -1)})):
        second = x * u**3 - sp.Abs(x) * v**3
        system = [e.subs({x: place, u: 1}) for e in (u**2 - v**2, second)]  # u = 0 gives v = 0
        roots = [root for root in sp.roots(system[0], v) if system[1].subs(v, root) == 0]
        assert {(1, root) for root in roots} == lines


def test_discriminant_of_the_asymptotic_directions():
    discriminant = sp.discriminant(QUADRATIC.subs(v, 1), u)
    assert sp.expand(discriminant + 4 * (_a * _c - _b**2)) == 0


def test_theorem4_ruled_surfaces():
    for name in RULED:
        assert recognise(ruled(name), *GRID, "ruled", model="space").residual < 1e-10
        found = adapted_frames(ruled(name), *GRID, "space")
        graph = tangent_graph(found, found.smooth)
        for k in range(0, 20, 5):
            jet = Jet(graph.c[:, k : k + 1])
            scale = 1e-9 * (1 + max(abs(value) for value in values(jet).values())) ** 5
            assert abs(at(EQ4, jet)) < scale
    for surface in GENERAL.values():
        assert recognise(surface, *GRID, "ruled", model="space").residual > 1e-3
    # K <= 0 is needed: x^2 + y^2 divides both forms here, and no real line does.
    jet = (lambda a, b: (a * a + b * b) * (0.5 + a))(*jet_variables(0.0, 0.0))
    assert at(EQ4, jet) == 0 and at(_a * _c - _b**2, jet) > 0


def test_remark5_rulings_depend_analytically_on_the_point():
    # b^2 - ac > 0 keeps the two asymptotic directions apart, so that each is a formula in the
    # second derivatives without a branch; the one that is a ruling's stays straight.
    b2 = F("xy") ** 2 - F("xx") * F("yy")
    for sign in (1, -1):
        slope = (-F("xy") + sign * sp.sqrt(b2)) / F("yy")
        assert sp.simplify(QUADRATIC.subs({u: 1, v: slope})) == 0
    for graph, ruling in ((y / x, (x, y)), (sp.atan2(y, x), (x, y)), (y / x, (sp.S(0), sp.S(1)))):
        forms = {symbol: graph.diff(*pair) for symbol, pair in
                 ((F("xx"), (x, x)), (F("xy"), (x, y)), (F("yy"), (y, y)), (F("xxx"), (x, x, x)),
                  (F("xxy"), (x, x, y)), (F("xyy"), (x, y, y)), (F("yyy"), (y, y, y)))}  # fmt: skip
        assert sp.simplify(b2.subs(forms).subs({x: 2, y: 3})) > 0
        along = {u: ruling[0], v: ruling[1]}
        assert zero(QUADRATIC.subs(forms).subs(along)) and zero(CUBIC.subs(forms).subs(along))
        # Straight: its direction changes along itself by a multiple of itself.
        change = [ruling[0] * w.diff(x) + ruling[1] * w.diff(y) for w in ruling]
        assert zero(change[0] * ruling[1] - change[1] * ruling[0])


# ---- section 4: planes as points --------------------------------------------------------------


def test_eq05_envelope_of_moving_planes():
    """The library's moving cone is Eq. 5: its point lies on the cone and is touched there."""
    for name, motion in MOTIONS.items():
        surface = moving_cone(motion, ANGLE)
        found = adapted_frames(surface, *GRID, "space")
        vertex, _, axes, _ = motion(GRID[1])
        sine, cosine = np.sin(ANGLE), np.cos(ANGLE)
        a, b, c = (np.stack([w + 0 * GRID[0] for w in axis], -1) for axis in axes)
        n = sine * a + cosine * (np.cos(GRID[0])[:, None] * b + np.sin(GRID[0])[:, None] * c)
        m = np.stack([w + 0 * GRID[0] for w in vertex], -1)
        assert np.abs(((found.contact - m) * n).sum(-1)).max() < 1e-10, name
        assert np.abs(np.abs((found.axes[:, 2] * n).sum(-1)) - 1).max() < 1e-10, name
        # The three planes themselves: T and its derivatives hold the point.
        turn, time = jet_variables(*GRID)
        vertex, _, (a, b, c), _ = motion(time)
        plane = [sine * i + cosine * (np.cos(turn) * j + np.sin(turn) * k)
                 for i, j, k in zip(a, b, c, strict=True)]  # fmt: skip
        plane.append(-sum(i * j for i, j in zip(plane, vertex, strict=True)))
        for order in ((0, 0), (1, 0), (0, 1)):
            T = [part.derivative(*order) for part in plane]
            assert (
                np.abs(sum(i * j for i, j in zip(T[:3], found.contact.T, strict=True)) + T[3]).max()
                < 1e-10
            )


def test_eq06_planes_to_points():
    n, h = directions(np.random.default_rng(0), 20), np.linspace(-3, 3, 20)
    expected = np.column_stack([n[:, :2], h]) / (n[:, 2:] + 1)
    assert np.allclose(plane_to_point(n, h), expected, rtol=1e-12)
    back = point_to_plane(expected)  # no two planes have one point
    assert np.allclose(back[0], n) and np.allclose(back[1], h)
    with pytest.raises(ValueError, match=r"must not have the direction \(0, 0, -1\)"):
        plane_to_point((0, 0, -1), 1)


def test_eq07_spheres_to_paraboloids():
    n = directions(np.random.default_rng(1), 50)
    m, radius = np.array([0.3, -0.7, 0.5]), 0.8
    a, b, c = plane_to_point(n, radius - n @ m).T  # inward normals
    assert np.allclose(sphere_point(m, radius, a, b) / c, 1, rtol=1e-9)
    printed = (radius + m[2]) / 2 * (a**2 + b**2) - m[0] * a - m[1] * b + (radius - m[2]) / 2
    assert np.allclose(printed / c, 1, rtol=1e-9)


def test_top_view_is_the_stereographic_projection():
    n = directions(np.random.default_rng(2), 50)
    a, b, _ = plane_to_point(n, 0.0).T
    south = np.array([0, 0, -1.0])
    picture = south + (n - south) / (n[:, 2:] + 1)  # meets z = 0
    assert np.allclose(np.column_stack([a, b]), picture[:, :2], rtol=1e-10)


def test_prop6_cones_to_special_conics():
    rng = np.random.default_rng(3)
    for angle in (0.2, ANGLE, 1.2):
        points = cone_points(rng.normal(size=3), directions(rng, 1)[0], angle)
        assert abs(intrinsic_radius(points) - (np.pi / 2 - angle)) < 1e-9
        flat = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        assert flat[2] < 1e-10 * flat[0]  # a planar curve
        centre = circle_centre(points)
        assert np.ptp(np.linalg.norm(points[:, :2] - centre, axis=1)) < 1e-9 * flat[0]


def test_prop7_tangent_cones_are_conics_in_the_surface():
    surface = moving_cone(MOTIONS["screw"], ANGLE)
    s, w = np.linspace(0.2, 0.7, 9), np.full(9, 0.3)
    found = adapted_frames(surface, s, w, "space")
    n = found.axes[:, 2]
    points = plane_to_point(n, -(n * found.contact).sum(-1))
    flat = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    assert flat[2] < 1e-10 * flat[0]
    assert abs(intrinsic_radius(points) - (np.pi / 2 - ANGLE)) < 1e-9


def test_osculating_circles_between_vertices():
    # By a curve's support function p: the radius is p + p'', the centre moves by as much as the
    # radius grows and turns as it does so, so that circles between vertices are nested.
    support = sp.Function("support")(t)
    n = sp.Matrix([sp.cos(t), sp.sin(t)])
    radius = support + support.diff(t, 2)
    middle = support * n + support.diff(t) * n.diff(t) - radius * n
    assert all(zero(e) for e in middle.diff(t) + radius.diff(t) * n)
    rng = np.random.default_rng(6)
    for a, b, c, e in rng.uniform(-0.04, 0.04, (4, 4)):
        waves = a * sp.cos(2 * t) + b * sp.sin(2 * t) + c * sp.cos(3 * t) + e * sp.sin(3 * t)
        size, rate, centre = (
            sp.lambdify(t, thing.subs(support, 1 + waves).doit())
            for thing in (radius, radius.diff(t), middle)
        )
        turns = np.linspace(0, 2 * np.pi, 721)
        signs = np.sign(rate(turns))
        changes = np.flatnonzero(signs[1:] != signs[:-1])
        vertices = [brentq(rate, turns[i], turns[i + 1]) for i in changes]
        assert len(vertices) >= 4 and size(turns).min() > 0
        for first, last in pairwise(vertices):
            between = np.linspace(first, last, 12)
            places, sizes = np.array([centre(s).ravel() for s in between]), size(between)
            apart = np.linalg.norm(places[:, None] - places, axis=-1)
            assert np.all((apart < np.abs(sizes[:, None] - sizes)) | np.eye(12, dtype=bool))
        # Two circles of one size, on both sides of a vertex, cross.
        for before, vertex, after in zip(vertices[:-2], vertices[1:-1], vertices[2:], strict=True):
            sizes = [size(place) for place in (before, vertex, after)]
            least = max(sizes[::2]) if sizes[1] > sizes[0] else min(sizes[::2])
            level = (sizes[1] + least) / 2
            one, two = (
                brentq(lambda at, size=size, level=level: size(at) - level, *side)
                for side in ((before, vertex), (vertex, after))
            )
            assert 1e-9 < np.linalg.norm(centre(one) - centre(two)) < 2 * level


def test_definition8_contact_of_a_curve_and_a_graph():
    def graph(a, b):
        return a**2 - 3 * a * b + b**3 + 2 * a

    def orders(gap, s):
        """Return up to which power the gap vanishes, by the quotient and by its derivatives."""
        powers = [n for n in range(6) if sp.limit(gap / s**n, s, 0) == 0]
        still = [n for n in range(6) if all(gap.diff(s, k).subs(s, 0) == 0 for k in range(n + 1))]
        assert powers == still == list(range(len(powers)))
        return len(powers) - 1

    across, up = t + t**2, 1 - 2 * t + t**3
    for n in range(5):
        curve = sp.Matrix([across, up, graph(across, up) + 7 * t ** (n + 1)])
        assert orders(sp.expand(curve[2] - graph(curve[0], curve[1])), t) == n
        # Another parameter, with a rate of its own.
        other = curve.subs(t, 3 * g - g**2)
        assert orders(sp.expand(other[2] - graph(other[0], other[1])), g) == n
        # Curves in the graph that agree with it so far: its shadow, and as many more as one likes.
        for aside in (0, 1, -4):
            held = across + aside * t ** (n + 1)
            within = sp.Matrix([held, up, graph(held, up)])
            assert min(orders(sp.expand(e), t) for e in curve - within) == n
    # A tangent has order 1, a curve in the graph every one.
    slope = [graph(x, y).diff(e).subs({x: 0, y: 1}) for e in (x, y)]
    line = sp.Matrix([t, 1 - t, graph(0, 1) + (slope[0] - slope[1]) * t])
    assert orders(sp.expand(line[2] - graph(line[0], line[1])), t) == 1
    assert orders(sp.expand(graph(t, t) - graph(t, t)), t) == 5


def test_planes_through_a_tangent():
    # An elliptic point, 2 z = a x^2 + 2 b x y + c y^2 with a, c, a c - b^2 > 0; planes through x.
    a, c, rest = sp.symbols("a c rest", positive=True)
    b = sp.sqrt(a * c - rest)
    form = (a * x**2 + 2 * b * x * y + c * y**2) / 2
    # Inclined by its tangent m against the normal, y = m z, the curve is z = a x^2/2 + ...
    m = sp.Symbol("m", real=True)
    height = sp.Function("height")(x)
    cut = height - form.subs(y, m * height)
    at_rest = {height: 0, x: 0}
    first = sp.solve(cut.diff(x).subs(height.diff(x), g).subs(at_rest), g)
    assert first == [0] and cut.subs(at_rest) == 0
    second = cut.diff(x, 2).subs(height.diff(x, 2), t).subs(height.diff(x), 0).subs(at_rest)
    assert zero(sp.solve(second, t)[0] - a)  # of order 1 and no more
    # The tangent plane, z = 0: a sum of squares, zero in the point alone.
    assert zero(form - ((a * x + b * y) ** 2 + rest * y**2) / (2 * a))


def test_sphere_and_cone_touch_to_first_order_only():
    """All planes of a circumscribed cone touch the sphere; its rulings leave it at second order."""
    radius, vertex = 1.0, np.array([0, 0, -2.0])
    n, h = cone_planes(vertex, (0, 0, 1), np.arcsin(0.5), np.linspace(0, 6, 7))
    assert np.allclose(h, radius)  # the distance of the sphere's centre
    touch = -n
    away = touch + 1e-3 * (touch - vertex) / np.sqrt(3)
    assert np.allclose(np.linalg.norm(away, axis=1) - radius, 0.5e-6, rtol=1e-3)


def test_osculating_cones_touch_mannheims_sphere():
    """For one ruling the osculating cones of all angles have a common inscribed sphere."""
    found = adapted_frames(GENERAL["quartic graph"], np.array([0.3]), np.array([0.2]), "space")
    jet = isotropic_jet(found, slice(None))
    first, second, n = found.axes[0]
    a = 0.7
    e, w = (np.cos(a), np.sin(a)), np.cos(a) * second - np.sin(a) * first
    fee = e[0] ** 2 * jet.derivative(2, 0) + 2 * e[0] * e[1] * jet.derivative(1, 1)
    fee = (fee + e[1] ** 2 * jet.derivative(0, 2))[0]
    centre = found.contact[0] + fee / 2 * n
    for angle in (0.2, 0.5, 1.0):
        rho = 0.5 / np.tan(angle)
        point = cone_vertex((0, 0, 0), (-e[1] * rho, e[0] * rho), 0, fee * rho**2)
        vertex = found.contact[0] + point[0] * first + point[1] * second
        axis = np.cos(angle) * w + np.sin(angle) * n
        assert np.allclose(np.cross(centre - vertex, axis), 0, atol=1e-12)
        assert np.isclose(np.linalg.norm(centre - vertex) * np.sin(angle), abs(fee) / 2)


def test_appropriate_direction_is_not_conjugate_to_the_ruling():
    """The characteristic's tangent is conjugate to the cone's ruling."""
    surface = moving_cone(MOTIONS["wave"], ANGLE)
    r = surface(*jet_variables(*GRID))
    found = adapted_frames(surface, *GRID, "space")
    along = np.stack([c.derivative(1, 0) for c in r], axis=-1)
    vertex = np.stack([c + 0 * GRID[0] for c in MOTIONS["wave"](GRID[1])[0]], axis=-1)
    ruling = found.contact - vertex
    graph = tangent_graph(found, found.smooth)
    e, w = (np.einsum("nij,nj->ni", found.axes[:, :2], vector) for vector in (along, ruling))
    bend = (graph.derivative(2, 0) * e[:, 0] * w[:, 0] + graph.derivative(0, 2) * e[:, 1] * w[:, 1]
            + graph.derivative(1, 1) * (e[:, 0] * w[:, 1] + e[:, 1] * w[:, 0]))  # fmt: skip
    scale = np.linalg.norm(e, axis=1) * np.linalg.norm(w, axis=1)
    assert np.abs(bend / scale).max() < 1e-10


def test_third_order_contact_is_not_always_free():
    """Four of the six cones of Example 31 hold points of the surface next to the contact."""
    cones = hyperosculating_cones(example, 0.5, 0.3, half_angle=ANGLE)
    near = np.linspace(-0.04, 0.04, 121)
    a, b = np.meshgrid(0.5 + near, 0.3 + near)
    jet = example(*jet_variables(a, b))
    r = np.stack(contact_point(a, b, jet.value, jet.derivative(1, 0), jet.derivative(0, 1)), -1)
    depths = [
        cone_distance(r, cones.vertex[k], cones.axis[k], ANGLE, cones.distance[k] / 2,
                      2 * cones.distance[k]).min() for k in range(6)
    ]  # fmt: skip
    assert np.sum(np.less(depths, -1e-9)) == 4
    # And what decides: the sign of the fourth order against that of f_ee.
    assert np.array_equal(np.less(depths, -1e-9), cones.gouges)
    assert np.all(cones.gouges == (cones.side * cones.order4 < -1e-9))
    # A second way, in fractions: over the cone's own circle, however near the contact, the
    # surface lies within four cones by the fourth power of the step, and on both generators.
    a, b = place = sp.Rational(99, 65), sp.Rational(27, 65)
    square, half = a**2 + b**2, sp.Rational(1, 2)
    for generator in ((-3, -4, 5), (-12, 5, 13)):
        centre = tuple(sp.Rational(c, generator[2]) for c in generator[:2])
        assert _within_the_cone(EX31, place, centre) == (0, [0] * 6)
    for along, shift in (((2 * a * b, b**2 - a**2), b), ((a**2 - b**2, 2 * a * b), a)):
        for cot in (half, -half):
            size = (square + 1) / 2 / (cot - shift) / square
            residual, inside = _within_the_cone(EX31, place, [size * c for c in along])
            assert residual < 0 and min(inside[2:]) > 0
            assert all(abs(deep / inside[-1] - 1) < 0.02 for deep in inside[3:])
    # With K < 0 both signs occur, and that of f_ee keeps the surface out, whatever the direction.
    for fourth, sign in ((4, -1), (8, 1)):
        graph = 12 * x**2 - 12 * y**2 + fourth * x**4
        residual, inside = _within_the_cone(graph, (0, 0), (0, 1))
        assert sp.sign(residual) == sign and all(sp.sign(deep) == -sign for deep in inside[2:])
        found = hyperosculating_cones(sp.lambdify((x, y), graph), 0.0, 0.0,
                                      half_angle=np.arctan(0.5))  # fmt: skip
        k = np.argmax(np.abs(found.axis @ _axis_over((0, 0), (0, 1), float)))
        assert found.gouges[k] == (sign < 0)
        if sign > 0:
            around = [(i, j) for i in (-2, 0, 1) for j in (-1, 0, 2) if (i, j) != (0, 0)]
            _, inside = _within_the_cone(graph, (0, 0), (0, 1), around)
            assert max(inside) < 0


def _axis_over(place, centre, number=sp.Rational):
    """Return the axis of the cone over a circle through a place: its three normals' plane."""
    (a, b), (c, e) = place, centre
    n = sp.Matrix([2 * x, 2 * y, 1 - x**2 - y**2]) / p
    one, two, three = (n.subs({x: a + i, y: b + j}) for i, j in
                       ((0, 0), (2 * c, 2 * e), (c + e, e - c)))  # fmt: skip
    axis = (two - one).cross(three - one)
    return axis if number is sp.Rational else np.array(axis.T / axis.norm(), float)[0]


def _within_the_cone(graph, place, centre, around=None):
    """Return Eq. 12 on the cone's side, and how deep surface points lie within the cone.

    Exactly, for tan(theta) = 1/2: the points over the circle by steps t of 0.1 to 1e-9, depths in
    powers t^4; or those next to the place in given directions.
    """
    here = dict(zip((x, y, u, v), (*place, *centre), strict=True)) | {tan: sp.Rational(1, 2)}
    jet = {s: (graph.diff(*[x] * i, *[y] * j) if i + j else graph).subs(here)
           for (i, j), s in NAMES.items()}  # fmt: skip
    a, b, nine, eleven, twelve = (e.subs(jet).subs(here) for e in (*EQ10, EQ9, EQ11, EQ12))
    assert nine == eleven == 0
    contact = sp.Matrix(contact_point.unchecked(x, y, graph, graph.diff(x), graph.diff(y)))
    vertex = sp.Matrix(_vertex(jet[F("")], a, b)).subs(here)
    n = sp.Matrix([2 * x, 2 * y, 1 - x**2 - y**2])
    opposite = n.subs({x: x + 2 * u, y: y + 2 * v}, simultaneous=True).subs(here)
    side = sp.sign(opposite.dot(contact.subs(here) - vertex))  # Proposition 20
    axis = _axis_over(place, centre)
    depths = []
    for step in [sp.Rational(1, 10**k) for k in (1, 2, 3, 5, 7, 9)]:
        turn, rise = 2 * step / (1 + step**2), 2 * step**2 / (1 + step**2)  # sin, 1 - cos
        moves = [(v * turn + u * rise, v * rise - u * turn)] if around is None else [
            (step * i, step * j) for i, j in around]  # fmt: skip
        for move in moves:
            there = {x: x + move[0], y: y + move[1]}
            out = contact.subs(there, simultaneous=True).subs(here) - vertex
            deep = out.dot(axis) ** 2 / axis.dot(axis) - sp.Rational(4, 5) * out.dot(out)
            depths.append(deep / step**4)
    return twelve * side, depths


# ---- section 5: conics ------------------------------------------------------------------------


def test_eq08_eq09_prop9_special_conics():
    rng = np.random.default_rng(4)
    for angle in (0.2, ANGLE, 1.2):
        points = cone_points(rng.normal(size=3), directions(rng, 1)[0], angle)
        centre = circle_centre(points)
        for point in points:
            here = {x: point[0], y: point[1], u: centre[0] - point[0], v: centre[1] - point[1]}
            size = float((W**2).subs(here))
            assert abs(EQ9.subs({**here, tan: np.tan(angle)})) < 1e-8 * (size + 1)
            assert abs(EQ9.subs({**here, tan: np.tan(angle + 0.1)})) > 1e-3 * size
    # (8) itself: over such a circle it runs through planes of one point and one angle.
    vertex, axis = rng.normal(size=3), directions(rng, 1)[0]
    points = cone_points(vertex, axis, ANGLE)
    U, V = circle_centre(points) - points[0, :2]
    slope = np.linalg.solve(points[1:3, :2] - points[0, :2], points[1:3, 2] - points[0, 2])
    found = conic(points[0], (U, V), slope @ [V, -U], slope @ [U, V], np.linspace(0, 6, 25))
    n, h = point_to_plane(found)
    assert np.allclose(n @ vertex, -h, atol=1e-9) and np.allclose(n @ axis, np.sin(ANGLE))


def test_angle_of_proposition9():
    # O outside the circle about C, and inside: OA and OB from OC and the radius.
    far, radius = sp.symbols("far radius", positive=True)
    for sign, near in ((1, far - radius), (-1, radius - far)):
        quotient = (far + radius - sign * near) / (1 + sign * near * (far + radius))
        assert zero(quotient - 2 * radius / (1 + far**2 - radius**2))
        one, two = sp.symbols("one two", positive=True)  # the angles BSO and ASO
        difference = (sp.tan(one) - sign * sp.tan(two)) / (1 + sign * sp.tan(one) * sp.tan(two))
        assert zero(sp.expand_trig(sp.tan(one - sign * two)) - difference)
    below = 1 + (x + u) ** 2 + (y + v) ** 2 - u**2 - v**2
    assert zero(below - W)
    assert zero(4 * tan**2 * (u**2 + v**2) - below**2 + EQ9)  # cot = 2 sqrt/below, squared
    # ASB is the circle's radius on the sphere, or a straight angle less it.
    rng = np.random.default_rng(8)
    for centre, size in zip(rng.normal(size=(12, 2)), rng.uniform(0.1, 2, 12), strict=True):
        turns = 2 * np.pi * np.arange(9) / 9
        circle = centre + size * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        ends = centre + np.outer([size, -size], centre / np.linalg.norm(centre))
        one, two = np.column_stack([ends, [1, 1]])  # as seen from S
        angle = np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two)
        assert abs(min(angle, np.pi - angle) - intrinsic_radius(circle)) < 1e-9
        assert np.isclose(np.tan(angle), 2 * size / (1 + centre @ centre - size**2))


def test_example10_conics_in_a_graph():
    graph = y**2 / (x**2 + y**2)
    U, V = -x / 2, -y / 2
    a, b = x * y / (x**2 + y**2), (x**2 - y**2) / (2 * (x**2 + y**2))
    X = x + V * sp.sin(t) + U * (1 - sp.cos(t))
    Y = y - U * sp.sin(t) + V * (1 - sp.cos(t))
    Z = graph + a * sp.sin(t) + b * (1 - sp.cos(t))
    assert zero(Z - Y**2 / (X**2 + Y**2))
    circle = sp.expand(EQ9.subs({u: U, v: V}))
    assert zero(circle - (1 - tan**2 * (x**2 + y**2)))


EQ10 = (F("x") * v - F("y") * u, F("x") * u + F("y") * v
        + F("xx") * v**2 - 2 * F("xy") * u * v + F("yy") * u**2)  # fmt: skip


def test_eq10_second_order():
    a, b = EQ10
    assert zero(plain(on_circle(f, 1)) - a)
    assert zero(plain(on_circle(f, 2)) - b)
    z, found_a, found_b = osculating_conic((0.4, 0.2), example(*jet_variables(0.5, 0.3)))
    jet = example(*jet_variables(0.5, 0.3))
    assert np.isclose(found_a, at(a, jet, u=0.4, v=0.2)) and z == jet.value
    assert np.isclose(found_b, at(b, jet, u=0.4, v=0.2))


def test_eq11_third_order():
    # z'''(0) = -a = -f'; the sum f''' + f' must vanish.
    assert zero(plain(on_circle(f, 3)) + plain(on_circle(f, 1)) - EQ11)


def _mixed(a, first, b, second):
    """Return a times one series and b times another."""
    return [a * one + b * two for one, two in zip(first, second, strict=True)]


def _product(first, second):
    """Return the product of two series to order 4."""
    return [sum(first[k] * second[n - k] for k in range(n + 1)) for n in range(5)]


def test_eq12_fourth_order():
    # z''''(0) = -b = -f''.
    printed = (F("xxxx") * v**4 - 4 * F("xxx") * v**3 * u + 6 * F("xxy") * v**2 * u**2
               - 4 * F("xyy") * v * u**3 + F("yyy") * u**4 + LOWER)  # fmt: skip
    left = plain(on_circle(f, 4)) + plain(on_circle(f, 2))
    assert zero(left - EQ12) and not zero(left - printed)
    # A second way, fractions: the series of conic less graph has -(11)/6 for t^3 and -(12)/24
    # for t^4.
    for here in np.random.default_rng(12).integers(-9, 10, (10, 19)).tolist():
        (x0, y0, U, V), graph = here[:4], dict(zip(NAMES, here[4:], strict=True))
        sine, rise = [0, 1, 0, Fraction(-1, 6), 0], [0, 0, Fraction(1, 2), 0, Fraction(-1, 24)]
        step = [_mixed(V, sine, U, rise), _mixed(-U, sine, V, rise)]
        a, b = (e.subs({u: U, v: V}) for e in EQ10)
        a, b = (int(e.subs({s: graph[order] for order, s in NAMES.items()})) for e in (a, b))
        gap = _mixed(a, sine, b, rise)
        for (i, j), value in graph.items():
            term = [Fraction(value, factorial(i) * factorial(j)), 0, 0, 0, 0]
            for factor in [step[0]] * i + [step[1]] * j:
                term = _product(term, factor)
            gap = _mixed(1, gap, -1 if i + j else 0, term)
        at_here = {s: graph[order] for order, s in NAMES.items()} | {u: U, v: V, x: x0, y: y0}
        eleven, twelve, wrong = (int(e.subs(at_here)) for e in (EQ11, EQ12, printed))
        assert gap[:3] == [0, 0, 0] and 6 * gap[3] == -eleven and 24 * gap[4] == -twelve
        assert twelve != wrong


def test_prop11_contact_orders():
    """Gaps between conic and graph shrink as the order says, each order by the next equation."""
    cones = hyperosculating_cones(example, 0.5, 0.3, half_angle=ANGLE)
    for k in range(6):
        points = cone_points(cones.vertex[k], cones.side[k] * cones.axis[k], ANGLE)
        here = plane_to_point(cones.normal[k], -cones.normal[k] @ cones.contact[k])
        centre = circle_centre(points) - here[:2]
        jet = example(*jet_variables(0.5, 0.3))
        _, a, b = osculating_conic(centre, jet)
        gaps = []
        for step in np.array([2e-3, 4e-3]) / np.hypot(*centre):
            px, py, pz = conic(here, centre, a, b, step)
            gaps.append(abs(pz - example(px, py)))
        eleven, twelve = (at(e, jet, u=centre[0], v=centre[1]) for e in (EQ11, EQ12))
        assert abs(eleven) < 1e-8
        if abs(twelve) < 1e-8:
            assert max(gaps) < 1e-13
        else:
            assert 14 < gaps[1] / gaps[0] < 18
    _, a, b = osculating_conic((0.4, 0.1), jet)
    gaps = [
        abs(c[2] - example(c[0], c[1]))
        for c in (conic((0.5, 0.3, float(jet.value)), (0.4, 0.1), a, b, h) for h in (1e-2, 2e-2))
    ]
    assert 7 < gaps[1] / gaps[0] < 9


def test_corollary12_common_solution():
    for name in ("screw", "cubic"):
        surface = moving_cone(MOTIONS[name], ANGLE)
        px, py, jet = general_jet(surface, 0.4, 0.3)
        vertex, _, axes, _ = MOTIONS[name](0.3)
        found = adapted_frames(surface, np.array([0.4]), np.array([0.3]), "space")
        n = found.axes[0, 2]
        sign = np.sign(n @ np.array(axes[0], dtype=float))
        points = cone_points(np.array(vertex, dtype=float), sign * np.array(axes[0], float), ANGLE)
        centre = circle_centre(points) - (px, py)
        for equation in (EQ9, EQ11, EQ12):
            left = at(equation, jet, x=px, y=py, tan=np.tan(ANGLE), u=centre[0], v=centre[1])
            size = max(map(abs, values(jet).values())) * (1 + np.hypot(*centre)) ** 4
            assert abs(left) < 1e-9 * size


EQ13 = p * ((t**2 - 1) ** 3 * F("xxx") - 6 * (t**2 - 1) ** 2 * t * F("xxy")
            + 12 * (t**2 - 1) * t**2 * F("xyy") - 8 * t**3 * F("yyy"))  # fmt: skip
EQ13 += (6 * (2 * (t**3 - t) * (F("xx") - F("yy")) + (t**4 - 6 * t**2 + 1) * F("xy"))
         * (t**2 * tan - t**2 * y - 2 * t * x + y + tan))  # fmt: skip


def _eq13(px, py, jet, angle):
    """Return the coefficients of Eq. 13, by descending powers of t."""
    poly = EQ13.subs(values(jet)).subs({x: px, y: py, tan: np.tan(angle)})
    return [float(c) for c in sp.Poly(poly, t).all_coeffs()]


def test_eq13_loses_a_root_at_infinity():
    px, py = 0.5, 0.3
    jet = example(*jet_variables(px, py))
    coefficients = _eq13(px, py, jet, ANGLE)
    leading = (p * F("xxx") + 6 * F("xy") * (tan - y)).subs(values(jet))
    assert np.isclose(coefficients[0], float(leading.subs({x: px, y: py, tan: np.tan(ANGLE)})))
    roots = np.roots(coefficients)
    real = roots[np.abs(roots.imag) < 1e-9].real
    assert len(real) == 6  # one equation for both branches of (9)
    for root in real:
        below = root**2 * np.tan(ANGLE) - root**2 * py - 2 * root * px + py + np.tan(ANGLE)
        square = 1 + px**2 + py**2
        U, V = root * square / below, (root**2 - 1) * square / 2 / below
        for equation in (EQ9, EQ11):
            left = at(equation, jet, x=px, y=py, tan=np.tan(ANGLE), u=U, v=V)
            assert abs(left) < 1e-7 * (1 + abs(U) + abs(V)) ** 3

    # Where f_xy = f_xxx = 0 the degree falls, and a cone is lost.
    def graph(a, b):
        return a * a / 2 - b * b + a * b * b + 0.1 * b**3

    jet = graph(*jet_variables(0.5, 0.0))
    coefficients = _eq13(0.5, 0.0, jet, ANGLE)
    assert len(coefficients) < 7
    roots = np.roots(coefficients)
    count = hyperosculating_cones(graph, 0.5, 0.0, half_angle=ANGLE).count
    assert np.sum(np.abs(roots.imag) < 1e-9) < count


def test_theorem13_conics_of_fourth_order_stay_in_the_graph():
    cones = hyperosculating_cones(example, 0.5, 0.3, half_angle=ANGLE)
    here = plane_to_point(cones.normal[0], -cones.normal[0] @ cones.contact[0])
    gaps = []
    for k in np.flatnonzero(np.abs(cones.order4) < 1e-9):
        points = cone_points(cones.vertex[k], cones.side[k] * cones.axis[k], ANGLE, 40)
        centre = circle_centre(points)
        turn = np.angle(((points[:, :2] - centre) @ [1, 1j]) / ((here[:2] - centre) @ [1, 1j]))
        arc = points[(np.abs(turn) < 1.5) & (np.hypot(*points[:, :2].T) > 1e-3)]
        gaps.append(np.abs(arc[:, 2] - example(arc[:, 0], arc[:, 1])).max())
    assert len(gaps) == 2 and max(gaps) < 1e-9
    # The proof's last step: derivative of (11) less (12) is 3 g times (14), by (16).
    moved = _moved_eq11(-v - g * VT, u + g * UT)
    assert sp.expand(moved - EQ12 - 3 * g * eq14(UT, VT)) == 0


def _moved_eq11(du, dv):
    """Return the derivative of Eq. 11 along x' = v, y' = -u, with u' and v' given."""
    moved = sum(sp.diff(EQ11, s) * (NAMES[i + 1, j] * v - NAMES[i, j + 1] * u)
                for (i, j), s in NAMES.items() if i + j in (2, 3))  # fmt: skip
    return moved + EQ11.diff(u) * du + EQ11.diff(v) * dv


def test_derivative_of_eq11():
    du, dv = sp.symbols("du dv")
    fourth = (F("xxxx") * v**4 - 4 * F("xxxy") * v**3 * u + 6 * F("xxyy") * v**2 * u**2
              - 4 * F("xyyy") * v * u**3 + F("yyyy") * u**4)  # fmt: skip
    third = (u * v**2 * F("xxx") + v * (v**2 - 2 * u**2) * F("xxy")
             + u * (u**2 - 2 * v**2) * F("xyy") + u**2 * v * F("yyy"))  # fmt: skip
    turned = (3 * v**2 * dv * F("xxx") - 3 * v * (2 * u * dv + v * du) * F("xxy")
              + 3 * u * (2 * v * du + u * dv) * F("xyy") - 3 * u**2 * du * F("yyy")
              + 3 * (u * dv + v * du) * (F("xx") - F("yy"))
              + 6 * (v * dv - u * du) * F("xy"))  # fmt: skip
    assert sp.expand(_moved_eq11(du, dv) - fourth - 3 * third - turned) == 0
    # 3 g times (14) is half of g times the Jacobian.
    jacobian = sp.Matrix([EQ9, EQ11]).jacobian([u, v]).det()
    assert sp.expand(3 * g * eq14(UT, VT) - g * jacobian / 2) == 0
    # Printed with five indices in one place: wrong for x^3 y, whose fxxxy is 6.
    fifth = sp.Symbol("fxxxxy")
    printed = fourth.subs(F("xxxy"), fifth) + 3 * third + turned
    cubic = {s: (x**3 * y).diff(*[x] * i, *[y] * j) for (i, j), s in NAMES.items() if i + j}
    wrong = (_moved_eq11(du, dv) - printed).subs(fifth, 0).subs(cubic)
    assert sp.expand(wrong + 24 * u * v**3) == 0
    # A second way, fractions: along a straight move of (x, y, u, v) Eq. 11 of a polynomial of
    # degree 4 is of degree 4 itself, so that five values give the exact derivative.
    corrected = fourth + 3 * third + turned
    for move in np.random.default_rng(16).integers(-9, 10, (5, 19)).tolist():
        (U, V, DU, DV), graph = move[:4], dict(zip(NAMES, move[4:], strict=True))
        here = {s: graph[order] for order, s in NAMES.items()} | {u: U, v: V, du: DU, dv: DV}
        slope = _slope(_eleven(graph, U + step * DU, V + step * DV, V * step, -U * step)
                       for step in STEPS)  # fmt: skip
        assert slope == corrected.subs(here)
        if graph[3, 1] * V * U:
            assert slope != printed.subs(fifth, 0).subs(here)


def _eleven(graph, U, V, dx, dy):
    """Return Eq. 11 of a polynomial, by its derivatives at one place, dx and dy away from it."""
    jet = {
        s: sum(Fraction(value * dx ** (i - k) * dy ** (j - m), factorial(i - k) * factorial(j - m))
               for (i, j), value in graph.items() if i >= k and j >= m)
        for (k, m), s in NAMES.items()
    }  # fmt: skip
    return EQ11.subs({s: sp.Rational(value) for s, value in jet.items()}).subs({u: U, v: V})


STEPS = -2, -1, 1, 2


def _slope(values):
    """Return the derivative at 0 of a polynomial of degree 4, exactly, from those at STEPS."""
    back2, back, on, on2 = values
    return sp.Rational(8 * (on - back) - (on2 - back2)) / 12


def test_eq14_jacobian():
    jacobian = sp.Matrix([EQ9, EQ11]).jacobian([u, v]).det()
    assert sp.expand(jacobian - 6 * eq14(UT, VT)) == 0


def _eq9(a, b, U, V, cot):
    weight = a * a + b * b + 1 + 2 * a * U + 2 * b * V
    return weight**2 - Fraction(4, cot * cot) * (U * U + V * V)


def test_eq15_gradient():
    printed = x * W - 4 * u * tan**2, y * W - 4 * v * tan**2
    gradient = [EQ9.diff(u), EQ9.diff(v)]
    assert all(sp.expand(a - 2 * b) == 0 for a, b in zip(gradient, (UT, VT), strict=True))
    # Neither half of the gradient nor parallel to it.
    assert sp.expand(gradient[0] - 2 * printed[0]) != 0
    assert sp.expand(gradient[0] * printed[1] - gradient[1] * printed[0]) != 0
    # A second way, fractions: (9) is of degree 2 in u and in v, and central differences exact.
    for a, b, U, V, T in np.random.default_rng(15).integers(1, 9, (10, 5)).tolist():
        four = [_eq9(a, b, *move, T) for move in ((U + 1, V), (U - 1, V), (U, V + 1), (U, V - 1))]
        here = {x: a, y: b, u: U, v: V, tan: sp.Rational(1, T)}
        assert 4 * UT.subs(here) == four[0] - four[1] and 4 * VT.subs(here) == four[2] - four[3]
        assert 4 * printed[0].subs(here) != four[0] - four[1]


def test_derivative_of_eq09():
    du, dv = sp.symbols("du dv")
    moved = EQ9.diff(x) * v - EQ9.diff(y) * u + EQ9.diff(u) * du + EQ9.diff(v) * dv
    bracket = x * (v + du) + y * (dv - u)
    rest = 8 * tan**2 * (u * du + v * dv)
    assert sp.expand(moved - (4 * bracket * W - rest)) == 0
    assert sp.expand(moved - (2 * bracket * W - rest)) != 0
    assert sp.expand(moved / 2 - ((v + du) * UT - (u - dv) * VT)) == 0
    # A second way, fractions: along a straight move (9) is a polynomial of degree 4.
    wrong = 0
    for a, b, U, V, DU, DV, T in np.random.default_rng(17).integers(1, 9, (20, 7)).tolist():
        here = {x: a, y: b, u: U, v: V, du: DU, dv: DV, tan: sp.Rational(1, T)}
        slope = _slope(_eq9(a + s * V, b - s * U, U + s * DU, V + s * DV, T) for s in STEPS)
        assert slope == (4 * bracket * W - rest).subs(here)
        wrong += slope != (2 * bracket * W - rest).subs(here)
    assert wrong > 15


def test_eq16_motion_of_the_centre():
    du, dv = -v - g * VT, u + g * UT
    assert sp.expand((v + du) * UT - (u - dv) * VT) == 0


def test_problem15_multiple_conics():
    """Evidence: channels of constant slope have multiple conics, and are such envelopes."""
    surface, angle = pipe(CURVES["helix"], 0.3, 0.1), np.arcsin(0.1 / np.sqrt(1.16))
    cones = hyperosculating_cones(surface, *GRID, half_angle=angle, model="space")
    double = cones.multiplicity == 2
    assert np.array_equal(np.sort(cones.index[double]), np.arange(20))
    assert np.abs(cones.order4[double]).max() < 1e-10
    for name, motion in MOTIONS.items():
        cones = hyperosculating_cones(moving_cone(motion, 0.35), *GRID, half_angle=0.35,
                                      model="space")  # fmt: skip
        assert np.all(cones.multiplicity[np.abs(cones.order4) < 1e-10] == 1), name


# ---- section 6: envelopes of cones ------------------------------------------------------------


def test_theorem16_envelopes_of_cones():
    for motion in MOTIONS.values():
        surface = moving_cone(motion, SMALL)
        assert recognise(surface, *GRID, "cone", half_angle=SMALL, model="space").residual < 1e-10
        wrong = recognise(surface, *GRID, "cone", half_angle=SMALL + 0.1, model="space")
        assert wrong.residual > 1e-3
    for surface in GENERAL.values():
        assert recognise(surface, *GRID, "cone", model="space").residual > 1e-3


def test_prop17_positive_curvature():
    vertex, angle = np.array([0, 0, -2.0]), np.arcsin(0.5)
    sphere = directions(np.random.default_rng(5), 4000)
    distance = cone_distance(sphere, vertex, (0, 0, 1), angle, 0.1, 10.0)
    assert np.mean(distance < -1e-3) > 0.9
    cones = hyperosculating_cones(GENERAL["ellipsoid"], *GRID, half_angle=0.3, model="space")
    assert cones.gouges.all()


def test_eq17_to_eq20_prop18_surface_and_graph():
    a, b = 0.5, 0.3
    jet = example(*jet_variables(a, b))
    r = np.array(contact_point(a, b, jet.value, jet.derivative(1, 0), jet.derivative(0, 1)))
    fx, fy, value = jet.derivative(1, 0), jet.derivative(0, 1), jet.value
    square = a**2 + b**2 + 1
    printed = np.array([
        (a**2 - b**2 - 1) * fx + 2 * a * b * fy - 2 * a * value,
        (b**2 - a**2 - 1) * fy + 2 * a * b * fx - 2 * b * value,
        2 * a * fx + 2 * b * fy - 2 * value,
    ]) / square  # fmt: skip
    assert np.allclose(r, printed, atol=1e-13)
    back = isotropic_derivatives(r, normal(a, b))
    assert np.allclose(back, (a, b, value, fx, fy), atol=1e-13)
    n = np.array(normal(a, b))  # (17) to (19) as printed
    printed = -n @ r, n[0] * r[2] - r[0] * (n[2] + 1), n[1] * r[2] - r[1] * (n[2] + 1)
    assert np.allclose(np.divide(printed, n[2] + 1), (value, fx, fy), atol=1e-13)
    # The surface has these normals: derivatives of its points are across them.
    s, w = jet_variables(a, b)
    f4 = example(s, w)
    moving = contact_point(s, w, f4, differentiated(f4, 0), differentiated(f4, 1))
    for order in ((1, 0), (0, 1)):
        step = sum(c.derivative(*order) * n for c, n in zip(moving, normal(a, b), strict=True))
        assert abs(step) < 1e-12


def test_eq21_normal():
    n = np.stack(normal(0.4, -1.3), axis=-1)
    assert np.isclose(np.linalg.norm(n), 1) and np.allclose(n[:2] / (n[2] + 1), (0.4, -1.3))


def test_eq22_prop19_vertex():
    rng = np.random.default_rng(6)
    for _ in range(20):
        vertex, axis, angle = rng.normal(size=3), directions(rng, 1)[0], rng.uniform(0.2, 1.3)
        points = cone_points(vertex, axis, angle)
        U, V = circle_centre(points) - points[0, :2]
        slope = np.linalg.solve(points[1:3, :2] - points[0, :2], points[1:3, 2] - points[0, 2])
        found = cone_vertex(points[0], (U, V), slope @ [V, -U], slope @ [U, V])
        assert np.allclose(found, vertex, atol=1e-8 * (1 + np.abs(points).max()) ** 2)
        here = dict(zip((x, y, u, v), (*points[0, :2], U, V), strict=True))
        printed = sp.Matrix(_vertex(points[0, 2], slope @ [V, -U], slope @ [U, V])).subs(here)
        assert np.allclose(np.array(printed.T, float)[0], found, rtol=1e-9, atol=1e-9)


def test_prop20_side():
    x0, y0 = np.random.default_rng(7).uniform(0.3, 1.2, (2, 30))
    cones = hyperosculating_cones(example, x0, y0, half_angle=ANGLE)
    for k in range(len(cones.vertex)):
        i = cones.index[k]
        points = cone_points(cones.vertex[k], cones.side[k] * cones.axis[k], ANGLE)
        opposite = 2 * circle_centre(points) - (x0[i], y0[i])
        side = np.sign(np.array(normal(*opposite)) @ (cones.contact[k] - cones.vertex[k]))
        assert side == cones.side[k]


def test_remark21_distance():
    cones = hyperosculating_cones(example, *GRID, half_angle=ANGLE)
    measured = np.linalg.norm(cones.vertex - cones.contact, axis=1)
    assert np.allclose(measured, cones.distance, atol=1e-9)


# ---- sections 7 and 8: cylinders, channels, pipes ---------------------------------------------


def _offset_conic(radius=-0.1):
    """Return the model's point, f's jet and (u, v) of a cylinder on an offset ruled surface."""
    surface = ruled("saddle", 0.1)
    px, py, jet = general_jet(surface, 0.4, 0.3)
    n = adapted_frames(surface, np.array([0.4]), np.array([0.3]), "space").axes[0, 2]
    c, _, ruling, _ = (np.array(part, dtype=float) for part in RULED["saddle"](0.4))
    across = np.cross(ruling, n) / np.linalg.norm(ruling)
    turns = np.array([0.0, 0.5, 1.3])[:, None]
    normals = np.cos(turns) * n + np.sin(turns) * across
    points = circle_planes(c, radius, normals)
    return px, py, jet, circle_centre(points) - (px, py), points, radius


def test_prop22_cylinders_to_conics():
    px, py, jet, _, points, radius = _offset_conic()
    assert np.allclose(points[0], (px, py, jet.value[0]), atol=1e-12)
    assert abs(intrinsic_radius(points) - np.pi / 2) < 1e-9
    plane = np.linalg.det(points - [0, 0, radius])
    assert abs(plane) < 1e-12 < 1e-4 < abs(np.linalg.det(points - [0, 0, radius + 0.1]))


def test_remark23_outward_normals():
    """The same cylinder with the other normals: its plane passes through (0, 0, -R)."""
    rng = np.random.default_rng(8)
    c, ruling = rng.normal(size=3), directions(rng, 1)[0]
    n = np.cross(ruling, directions(rng, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    for radius in (0.7, -0.7):  # inwards, outwards
        points = circle_planes(c, radius, n)
        scale = np.abs(points).max() ** 3
        assert abs(np.linalg.det(points - [0, 0, radius])) < 1e-12 * scale
        assert abs(np.linalg.det(points - [0, 0, -radius])) > 1e-4


def _eq24(radius):
    return 2 * (u**2 + v**2) * (F("") - x * F("x") - y * F("y") - radius) + p * (
        F("xx") * v**2 - 2 * F("xy") * u * v + F("yy") * u**2
    )


def test_eq23_eq24_prop24_cylinder_conditions():
    px, py, jet, centre, _, radius = _offset_conic()
    here = {"x": px, "y": py, "u": centre[0], "v": centre[1]}
    assert abs(at(W, jet, **here)) < 1e-10
    assert abs(at(_eq24(radius), jet, **here)) < 1e-10
    assert abs(at(_eq24(-radius), jet, **here)) > 1e-3
    # The determinant of the proof, with (10) and (23) put in.
    a = F("x") * v - F("y") * u
    b = F("x") * u + F("y") * v + F("xx") * v**2 - 2 * F("xy") * u * v + F("yy") * u**2
    R = sp.Symbol("R")
    determinant = sp.Matrix([[x, y, F("") - R], [v, -u, a], [u, v, b]]).det()
    on = {u: (-p / 2 - y * v) / x}  # Eq. 23 solved for u
    assert sp.simplify((2 * determinant - _eq24(R)).subs(on)) == 0


def test_corollary25_ruled_offsets():
    px, py, jet, centre, *_ = _offset_conic()
    here = {"x": px, "y": py, "u": centre[0], "v": centre[1]}
    assert abs(at(EQ11, jet, **here)) < 1e-9
    for name in RULED:
        found = recognise(ruled(name, 0.1), *GRID, "cylinder", model="space")
        assert found.residual < 1e-10 and abs(abs(found.radius) - 0.1) < 1e-9
        assert recognise(ruled(name), *GRID, "cylinder", radius=0.0, model="space").residual < 1e-10


def _channel_conic(growth):
    """Return the model's point, f's jet and (u, v) of a characteristic circle of a channel."""
    surface = pipe(CURVES["cubic"], 0.3, growth)
    s = 0.4
    px, py, jet = general_jet(surface, s, 0.5)
    found = adapted_frames(surface, np.full(9, s), 0.5 + 0.3 * np.arange(9), "space")
    n = found.axes[:, 2]
    points = plane_to_point(n, -(n * found.contact).sum(-1))
    return px, py, jet, circle_centre(points) - (px, py), points, found


def test_prop26_channels_to_paraboloids():
    *_, points, found = _channel_conic(0.1)
    flat = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    assert flat[2] < 1e-10 * flat[0]
    # The paraboloid (7) of the sphere holds the conic.
    c = np.array(CURVES["cubic"](0.4)[0], dtype=float)
    radius = 0.34 * np.sign(((c - found.contact[0]) * found.axes[0, 2]).sum())
    assert np.allclose(sphere_point(c, radius, *points[:, :2].T), points[:, 2], atol=1e-10)


def test_eq25_prop27_tangent_planes_meet_over_the_centre():
    eq25 = (F("xx") - F("yy")) * u * v + F("xy") * (v**2 - u**2)
    for growth in (0.0, 0.1):
        px, py, jet, centre, points, found = _channel_conic(growth)
        assert abs(at(eq25, jet, u=centre[0], v=centre[1])) < 1e-9
        assert abs(at(eq25, jet, u=centre[0], v=-centre[1])) > 1e-3
        # The tangent planes of the graph along the conic do meet there, in one point.
        a, b, value, fx, fy = isotropic_derivatives(found.contact.T, found.axes[:, 2].T)
        assert np.allclose(np.stack([a, b, value], axis=-1), points, atol=1e-12)
        height = value + fx * (px + centre[0] - a) + fy * (py + centre[1] - b)
        assert np.ptp(height) < 1e-10 < 1e-2 < np.ptp(value)


def test_eq26_corollary28_channels():
    cubic = EQ11 - 3 * ((F("xx") - F("yy")) * u * v + F("xy") * (v**2 - u**2))
    jet, centre = _channel_conic(0.1)[2:4]
    assert abs(at(cubic, jet, u=centre[0], v=centre[1])) < 1e-8
    for curve in CURVES.values():
        surface = pipe(curve, 0.3, 0.1)
        assert recognise(surface, *GRID, "channel", model="space").residual < 1e-10
    for surface in GENERAL.values():
        assert recognise(surface, *GRID, "channel", model="space").residual > 1e-3


def test_corollary29_pipes():
    px, py, jet, centre, _, found = _channel_conic(0.0)
    c = np.array(CURVES["cubic"](0.4)[0], dtype=float)
    radius = 0.3 * np.sign((c - found.contact[0]) @ found.axes[0, 2])
    here = {"x": px, "y": py, "u": centre[0], "v": centre[1]}
    assert abs(at(_eq24(radius), jet, **here)) < 1e-9
    assert abs(at(_eq24(1.1 * radius), jet, **here)) > 1e-3
    for curve in CURVES.values():
        assert recognise(pipe(curve, 0.3), *GRID, "pipe", model="space").residual < 1e-10
        assert recognise(pipe(curve, 0.3, 0.1), *GRID, "pipe", model="space").residual > 1e-3


def test_pipes_are_no_offsets_but_envelopes_of_cylinders():
    """The offset of a pipe by its radius is a curve; cylinders about its tangents touch circles."""
    surface, radius = pipe(CURVES["cubic"], 0.3), 0.3
    s, w = np.full(9, 0.4), np.linspace(0, 6, 9)
    found = adapted_frames(surface, s, w, "space")
    centre, velocity, _ = (np.array(part, dtype=float) for part in CURVES["cubic"](0.4))
    n = found.axes[:, 2] * np.sign((centre - found.contact[0]) @ found.axes[0, 2])
    assert np.abs(found.contact + radius * n - centre).max() < 1e-14  # one point a circle
    assert np.abs(n @ velocity).max() < 1e-14  # normals of a cylinder about the tangent
    axis = velocity / np.linalg.norm(velocity)
    out = found.contact - centre
    assert np.allclose(np.linalg.norm(out - (out @ axis)[:, None] * axis, axis=1), radius)


def test_cylinder_along_tangents_envelops_offsets_and_a_pipe():
    """Frenet frame: velocity across the wall is distance from the curve times a cosine."""
    along, turn, curvature, torsion, radius = sp.symbols("along turn curvature torsion radius")
    # T' = k N, N' = -k T + m B, B' = -m N, by coordinates in (T, N, B).
    turned = sp.Matrix([[0, curvature, 0], [-curvature, 0, torsion], [0, -torsion, 0]])
    n = sp.Matrix([[0, sp.cos(turn), sp.sin(turn)]])
    point = sp.Matrix([[along, 0, 0]]) + radius * n
    velocity = sp.Matrix([[1, 0, 0]]) + point * turned
    assert zero(velocity.dot(n) - along * curvature * sp.cos(turn))
    # Zero on the pipe, along = 0, and at cos(turn) = 0: tangents moved along the binormal.
    assert point.subs(turn, sp.pi / 2) == sp.Matrix([[along, 0, radius]])


def test_contour_from_the_vertex_has_the_osculating_cones_circle():
    """Rulings from an osculating cone's vertex to the contour leave that cone at third order."""
    surface, angle, a = GENERAL["quartic graph"], 0.5, 0.7
    found = adapted_frames(surface, np.array([0.3]), np.array([0.2]), "space")
    first, second, n = found.axes[0]
    fee = order_four(isotropic_jet(found, slice(None)), np.array([[a]]), 1.0)[0][0, 0]
    w = np.cos(a) * second - np.sin(a) * first
    vertex = found.contact[0] - 0.5 / np.tan(angle) * fee * w
    axis = np.sign(fee) * (np.cos(angle) * w + np.sin(angle) * n)

    def plane(s, t):
        there = adapted_frames(surface, np.array([s]), np.array([t]), "space")
        return there.axes[0, 2] @ (there.contact[0] - vertex)

    gaps = []
    for step in (5e-3, 1e-2):
        t_here = brentq(lambda t, s=0.3 + step: plane(s, t), 0.1, 0.3, xtol=1e-15)
        ruling = np.array(surface(0.3 + step, t_here)) - vertex
        gaps.append(np.arccos(ruling @ axis / np.linalg.norm(ruling)) - angle)
    assert 7 < gaps[1] / gaps[0] < 9


def test_problem30_converses():
    """Evidence: what solves the equations at every point is an envelope, wherever we looked.

    With f_ee = 2 R and f_eee = 0 the offset by R has a direction of line contact of order 3 at
    each point (Theorem 4 makes it ruled); the two conditions are the same function of the jet.
    """
    for name in RULED:
        surface = adapted_frames(ruled(name, 0.1), *GRID, "space")
        found = recognise(ruled(name, 0.1), *GRID, "cylinder", model="space")
        contact, n = surface.contact, surface.axes[:, 2]
        back = contact + found.radius * n  # the offset: points of the rulings
        s, w = GRID
        expected = np.stack([c + 0 * s for c in ruled(name)(s, w)], axis=-1)
        assert np.abs(back - expected).max() < 1e-9
    # That step: on a general surface, wherever f_eee = 0, the offset by f_ee/2 has contact of
    # order 3 with a line across e; by another amount, or in another direction, it hasn't.
    graph = GENERAL["quartic graph"]

    def offset(R):
        def surface(s, t):
            slopes = (2 * s + 0.9 * s**2 * t, -2 * t + 0.3 * s**3 + 0.8 * t**3)
            length = (slopes[0] ** 2 + slopes[1] ** 2 + 1) ** 0.5
            n = [-slopes[0] / length, -slopes[1] / length, 1 / length]
            return [c + R * m for c, m in zip(graph(s, t), n, strict=True)]

        return surface

    s, t0 = np.array([0.3]), np.array([0.2])
    found = adapted_frames(graph, s, t0, "space")
    f_, (first, second, n) = isotropic_jet(found, slice(None)), found.axes[0]
    upwards = np.sign(n[2])

    def along(f_, order, e):
        return sum(comb(order, k) * f_.derivative(order - k, k)[0] * e[0] ** (order - k) * e[1] ** k
                   for k in range(order + 1))  # fmt: skip

    a = brentq(lambda a: along(f_, 3, (np.cos(a), np.sin(a))), 0, np.pi)
    for turn, share, holds in ((0.0, 1.0, True), (0.3, 1.0, False), (0.0, 0.9, False)):
        e = np.cos(a + turn), np.sin(a + turn)
        ruling = e[0] * second - e[1] * first
        there = adapted_frames(offset(upwards * share * along(f_, 2, e) / 2), s, t0, "space")
        w = there.axes[0, :2] @ ruling
        contact = [along(tangent_graph(there, there.smooth), order, w) for order in (2, 3)]
        assert bool(np.max(np.abs(contact)) < 1e-9) is holds


# ---- section 9: examples ----------------------------------------------------------------------


# Example 31 in polynomials: Eq. 11 is three linear forms over a power of x^2 + y^2.
EX31 = y**2 / (x**2 + y**2)
ON_EX31 = {s: EX31.diff(*[x] * i, *[y] * j) for (i, j), s in NAMES.items() if i + j} | {
    F(""): EX31}  # fmt: skip
PRINCIPAL = u * (x**2 - y**2) + 2 * v * x * y, v * (x**2 - y**2) - 2 * u * x * y
THROUGH = x**2 + y**2 + 2 * x * u + 2 * y * v  # the circle passes through the origin


def test_example31_two_generators():
    cones = hyperosculating_cones(example, 0.5, 0.3, half_angle=ANGLE)
    exact = np.abs(cones.order4) < 1e-9
    assert exact.sum() == 2 and not cones.gouges[exact].any()
    for k in np.flatnonzero(exact):
        points = cone_points(cones.vertex[k], cones.side[k] * cones.axis[k], ANGLE)
        centre = circle_centre(points)
        assert np.isclose(np.hypot(*centre), 0.5 / np.tan(ANGLE))  # through the origin
        radius = np.linalg.norm(points[:, :2] - centre, axis=1)
        assert np.allclose(radius, 0.5 / np.tan(ANGLE), rtol=1e-9)
    # Exactly: these circles solve (11) and (12), and (9) where u^2 + v^2 = cot^2/4.
    for equation in (EQ11, EQ12):
        left = sp.numer(sp.together(equation.subs(ON_EX31)))
        assert sp.rem(left, THROUGH, u) == 0
    assert sp.rem(sp.expand(EQ9 - (1 - 4 * tan**2 * (u**2 + v**2))), THROUGH, u) == 0
    # The line THROUGH is |(x, y)|/2 from the origin, so that it has two such points within cot.
    square = THROUGH.subs({u: 0, v: 0}) ** 2 / (THROUGH.diff(u) ** 2 + THROUGH.diff(v) ** 2)
    assert zero(square - (x**2 + y**2) / 4)


def test_example31_six_positions():
    """Six inside the circle |(x, y)| < cot(theta), four outside, of which four gouge."""
    rng = np.random.default_rng(9)
    turn = rng.uniform(0.1, 1.4, 400)
    for low, high, count in ((0.2, 0.999, 6), (1.001, 3, 4)):
        r = rng.uniform(low, high, 400) / np.tan(ANGLE)
        cones = hyperosculating_cones(example, r * np.cos(turn), r * np.sin(turn), half_angle=ANGLE)
        assert np.all(cones.count == count)
        assert np.all(np.bincount(cones.index[cones.gouges]) == 4)
    on = 1 / np.tan(ANGLE)
    cones = hyperosculating_cones(example, on * np.cos(turn), on * np.sin(turn), half_angle=ANGLE)
    assert np.all(cones.count == 5) and np.all(np.bincount(cones.index, cones.multiplicity) == 6)
    # And on four circles of half that radius through the origin, centred on the axes.
    for centre in on / 2 * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        circle = centre + on / 2 * np.stack([np.cos(4 * turn), np.sin(4 * turn)], axis=-1)
        circle = circle[np.min(np.abs(circle), axis=-1) > 0.1 * on]
        cones = hyperosculating_cones(example, *circle.T, half_angle=ANGLE)
        assert len(circle) > 100 and np.all(cones.count == 5)
        assert np.all(np.bincount(cones.index, cones.multiplicity) == 6)


def test_example31_four_principal_positions():
    """Exactly: two lines of principal directions with two cones each, all of which gouge."""
    square = x**2 + y**2
    eleven = sp.factor(EQ11.subs(ON_EX31))
    assert zero(eleven + 6 * PRINCIPAL[0] * PRINCIPAL[1] * THROUGH / square**4)
    f_, fx, fy = EX31, EX31.diff(x), EX31.diff(y)
    r = sp.Matrix(contact_point.unchecked(x, y, f_, fx, fy))
    gap = None
    for line, shift in zip(PRINCIPAL, (y, x), strict=True):
        along = {u: line.diff(v) / square, v: -line.diff(u) / square}  # a unit vector of the line
        assert zero(sum(c**2 for c in along.values()) - 1)
        size = p / 2 / (1 / t - shift)  # t = +-cot(theta)
        here = {s: sp.factor(size * c) for s, c in along.items()}
        assert zero((W - 2 * size / t).subs(here))  # a root of (9) for either sign of t
        a, b = (e.subs(ON_EX31).subs(here) for e in EQ10)
        m = sp.Matrix(_vertex(f_, a, b)).subs(here)
        opposite = [2 * (x + 2 * here[u]), 2 * (y + 2 * here[v]),
                    1 - (x + 2 * here[u]) ** 2 - (y + 2 * here[v]) ** 2]  # fmt: skip
        side = sp.factor(sp.Matrix(opposite).dot(r - m))  # Proposition 20
        gap = sp.factor(side * EQ12.subs(ON_EX31).subs(here))
        # Minus squares, but where square = |shift| cot: there it meets a generator.
        assert _is_minus_a_square(gap, (square + shift * t) ** 2)
    # Principal directions: along the rulings the normal changes in their own direction.
    cones = hyperosculating_cones(example, 0.9, 0.6, half_angle=ANGLE)
    X, Y = jet_variables(0.9, 0.6)
    f4 = example(X, Y)
    moving = contact_point(X, Y, f4, differentiated(f4, 0), differentiated(f4, 1))
    rates = [np.array([[c.derivative(1, 0), c.derivative(0, 1)] for c in part], float)
             for part in (moving, normal(X, Y))]  # fmt: skip
    for k in np.flatnonzero(cones.gouges):
        ruling = cones.contact[k] - cones.vertex[k]
        step, rest = np.linalg.lstsq(rates[0], ruling, rcond=None)[:2]
        assert np.all(rest < 1e-20)
        assert np.linalg.norm(np.cross(rates[1] @ step, ruling)) < 1e-10
    assert np.count_nonzero(cones.gouges) == 4


def _vertex(z, a, b):
    """Return Eq. 22 as printed."""
    square, more, less = u**2 + v**2, a * v + b * u, b * v - a * u
    vertex = [
        (x**2 - y**2 - 1) * more + 2 * x * y * less - 2 * square * (u * z + x * z + a * y),
        (y**2 - x**2 - 1) * less + 2 * x * y * more - 2 * square * (v * z + y * z - a * x),
        2 * x * more + 2 * y * less - 2 * square * z,
    ]
    return [part / square / W for part in vertex]


def _is_minus_a_square(expression, factor):
    """Return whether a quotient has a factor, and is never above 0."""
    rest = sp.factor(expression / factor)
    number, factors = sp.factor_list(sp.numer(rest) * sp.denom(rest))
    odd = [sp.Poly(base) for base, power in factors if power % 2]
    return number < 0 and all(
        min(base.coeffs()) > 0 and not any(n % 2 for powers in base.monoms() for n in powers)
        for base in odd
    )


def test_numbers_of_cones_by_sturms_rule():
    """Eq. 13 in fractions, cot(theta) = 2: six, five, four, and on other surfaces two."""
    places = {(1, sp.Rational(1, 2)): 6, (sp.Rational(-3, 4), sp.Rational(1, 3)): 6,
              (sp.Rational(6, 5), sp.Rational(8, 5)): 5,  # on the circle of radius cot
              (sp.Rational(4, 5), sp.Rational(2, 5)): 5,  # square = y cot
              (sp.Rational(2, 5), sp.Rational(-4, 5)): 5,
              (2, 1): 4, (-3, sp.Rational(1, 7)): 4}  # fmt: skip
    for (a, b), count in places.items():
        assert sp.Poly(_exact_eq13(EX31, a, b), t).count_roots() == count
        cones = hyperosculating_cones(example, float(a), float(b), half_angle=np.arctan(0.5))
        assert cones.count == count
    graphs = {x**3 + x * y + y**3: 2, x * y + y**3: 4, x**3 - 3 * x * y**2 + x * y: 6}
    for graph, count in graphs.items():
        coefficients = _exact_eq13(graph, sp.Rational(1, 3), sp.Rational(1, 7))
        assert sp.Poly(coefficients, t).count_roots() == count  # by Sturm's rule
        cones = hyperosculating_cones(sp.lambdify((x, y), graph), 1 / 3, 1 / 7,
                                      half_angle=np.arctan(0.5))  # fmt: skip
        assert cones.count == count
    # Never none: in the adapted frame the mean over the circle of directions vanishes.
    e, w = (sp.cos(t), sp.sin(t)), (-sp.sin(t), sp.cos(t))
    third = sum(sp.binomial(3, k) * NAMES[3 - k, k] * e[0] ** (3 - k) * e[1] ** k for k in range(4))
    mixed = F("xx") * e[0] * w[0] + F("yy") * e[1] * w[1]
    mixed += F("xy") * (e[0] * w[1] + e[1] * w[0])
    assert sp.integrate(sp.expand(g * third + 3 * mixed), (t, 0, 2 * sp.pi)) == 0


def _exact_eq13(graph, a, b):
    """Return Eq. 13 of a graph at (a, b), for cot(theta) = 2."""
    here = {s: graph.diff(*[x] * i, *[y] * j).subs({x: a, y: b})
            for (i, j), s in NAMES.items() if 2 <= i + j <= 3}  # fmt: skip
    return sp.Poly(EQ13.subs(here).subs({x: a, y: b, tan: sp.Rational(1, 2)}), t).all_coeffs()


def test_example31_cyclide():
    """An identity, and curvature lines that are circles: both principal directions solve (26)."""
    X, Y, Z = contact_point.unchecked(x, y, EX31, EX31.diff(x), EX31.diff(y))
    assert zero(Z * (X**2 + Y**2 + Z**2) + 2 * (X**2 + Z**2))
    quadratic = (F("xx") - F("yy")) * u * v + F("xy") * (v**2 - u**2)
    quadratic, cubic = (e.subs(ON_EX31) for e in (quadratic, EQ11 - 3 * quadratic))
    assert zero(cubic / quadratic - 6 * (x * u + y * v) / (x**2 + y**2))
    # Its normals are those of the model: the gradient is across the surface's tangents.
    n = sp.Matrix([2 * x, 2 * y, 1 - x**2 - y**2])
    A, B, C = sp.symbols("A B C")
    implicit = C * (A**2 + B**2 + C**2) + 2 * (A**2 + C**2)
    gradient = sp.Matrix([implicit.diff(s).subs({A: X, B: Y, C: Z}) for s in (A, B, C)])
    assert all(zero(part) for part in n.cross(gradient))


def _generators_from_noise(turn, seed, planes, degree, patch, place=(0.5, 0.3)):
    """Return how far the found cones' axes are from both generators', in degrees."""
    rng, place = np.random.default_rng(seed), np.array(place)
    exact = hyperosculating_cones(example, *place, half_angle=ANGLE)
    where, size = rng.uniform(0, 2 * np.pi, planes), patch * np.sqrt(rng.random(planes))
    px, py = place[:, None] + size * np.array([np.cos(where), np.sin(where)])
    n = tilted(np.stack(normal(px, py), axis=-1), turn, rng)
    top = mean_frame(n)
    contact = surface_points(example, px, py) - exact.contact[0]
    graph, _ = fit_planes(contact @ top.T, n @ top.T, scale=patch, degree=degree)
    here = plane_to_point(top @ exact.normal[0], 0.0)[:2]
    found = hyperosculating_cones(graph, *here, half_angle=ANGLE)
    return np.degrees(np.arccos(np.abs(exact.axis[exact.undecided] @ (found.axis @ top).T).max(1)))


def test_example32_noise():
    """Both generators return at one point from one fit, not from others, nor at another point."""
    many = [_generators_from_noise(0.1, seed, 10_000, 8, 0.45).max() for seed in range(3)]
    assert max(many) < 10
    for turn, back in ((0.0, True), (0.1, False)):
        other = [_generators_from_noise(turn, k, 10_000, 8, 0.45, (0.9, 0.6)).max() for k in (0, 1)]
        assert all((error < 10) == back for error in other)
    few = np.array([_generators_from_noise(0.1, seed, 1400, 6, 0.35) for seed in range(8)])
    assert np.median(few.min(axis=1)) < 2 and np.sum(few.max(axis=1) > 30) >= 3
    # Planes turned about exact contact points leave the graph by the square of the turn.
    r, n = surface_points(example, *GRID), np.stack(normal(*GRID), axis=-1)
    errors = []
    for turn in (1e-3, 1e-2):
        noisy = tilted(n, turn, np.random.default_rng(10))
        px, py, pz = plane_to_point(noisy, -(noisy * r).sum(-1)).T
        errors.append(np.abs(pz - example(px, py)).max())
    assert 80 < errors[1] / errors[0] < 125


def _ring():
    mm, deg = 1e-3, np.pi / 180
    return BladeRing(60 * mm, 30 * mm, 50 * mm, -40 * deg, 70 * deg, -6 * mm, -6 * mm, 6)


def test_example33_blades():
    """On a substitute: cones from below and above, of which collisions leave some."""
    s, w = (a.ravel() for a in np.meshgrid([0.2, 0.5, 0.8], [0.2, 0.5, 0.8]))
    ring, angle = _ring(), np.radians(10)
    cones = hyperosculating_cones(ring.coordinates, s, w, half_angle=angle, model="space")
    assert {-1, 1} <= set(cones.side[~cones.gouges])
    lengths = [cones.distance[cones.index == i] for i in range(9)]
    assert all(np.ptp(each) > 1e-3 for each in lengths)  # "the tool size varies"
    found = adapted_frames(ring.coordinates, s, w, "space")
    jet = isotropic_jet(found, slice(None))
    hessian = jet.derivative(2, 0) * jet.derivative(0, 2) - jet.derivative(1, 1) ** 2
    assert np.all(hessian < 0)  # hyperbolic
    assert 0 < np.sum(~cones.gouges) < len(cones.gouges)


# ---- figures ----------------------------------------------------------------------------------


def test_fig1_characteristic_of_degree_four():
    """On a cone the normal is linear in the point, so is velocity: their product cuts a quartic."""
    X = sp.Matrix(sp.symbols("X Y Z"))
    k = sp.Symbol("k", positive=True)
    gradient = sp.Matrix([X[0], X[1], -k * X[2]])
    c, w = sp.Matrix(sp.symbols("c1:4")), sp.Matrix(sp.symbols("w1:4"))
    speed = gradient.dot(c + w.cross(X))
    assert sp.Poly(speed, *X).total_degree() == 2  # with the cone: degree 2 times 2
    assert sp.Poly(gradient.dot(c), *X).homogeneous_order() == 1  # a plane through the vertex
    # Velocities have the same component along the axis all along it.
    a = sp.Matrix([0, 0, 1])
    assert (c + w.cross(t * a)).dot(a) == c.dot(a)


def test_fig2_tangent_planes_turn_along_a_skew_ruling():
    s, w = np.full(5, 0.4), np.linspace(0.1, 0.5, 5)
    turned = adapted_frames(ruled("saddle"), s, w, "space").axes[:, 2]
    fixed = adapted_frames(DEVELOPABLE["tangents of the helix"], s, w, "space").axes[:, 2]
    assert np.abs(turned - turned[0]).max() > 0.1 and np.abs(fixed - fixed[0]).max() < 1e-12


def test_fig3_gaussian_image_of_a_cone():
    n, _ = cone_planes((0, 0, 0), (0.3, 0.2, 1), ANGLE, np.linspace(0, 6, 9))
    axis = np.array([0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    assert np.allclose(np.arccos(n @ axis), np.pi / 2 - ANGLE)


def _along_helix(s):
    """Return isotropic points of the planes of the helix' tangent developable."""
    c, first, second = CURVES["helix"](s)
    n = np.cross(np.stack(first, -1), np.stack(second, -1))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return plane_to_point(n, -(n * np.stack([w + 0 * s for w in c], -1)).sum(-1))


def test_fig4_osculating_circle_in_the_top_view():
    """The osculating cone lies over the top view's osculating circle; its vertex on the edge."""
    s0 = 0.6
    near = _along_helix(s0 + np.array([-1e-3, 0, 1e-3]))
    centre = circle_centre(near)
    slope = np.linalg.solve(near[[0, 2], :2] - near[1, :2], near[[0, 2], 2] - near[1, 2])
    U, V = centre - near[1, :2]
    vertex = cone_vertex(near[1], (U, V), slope @ [V, -U], slope @ [U, V])
    assert np.allclose(vertex, CURVES["helix"](s0)[0], atol=1e-5)


def _slope_planes(s):
    """Return planes of one slope through the tangents of an ellipse."""
    normals = np.stack([np.cos(s), np.sin(s), 1 + 0 * s], axis=-1) / np.sqrt(2)
    return normals, -np.sqrt(4 * np.cos(s) ** 2 + np.sin(s) ** 2) / np.sqrt(2)


def test_fig5_hyperosculation_of_a_developable():
    """Planes of one slope on an ellipse, at its vertices; not the tangents of a regular edge."""
    # Their normals are on a circle; they leave the cone with the evolute's point for a vertex by
    # p''' + p', the rate of the radius of curvature, which is 0 at the ellipse's vertices alone.
    a, b = sp.symbols("a b", positive=True)
    support = sp.sqrt(a**2 * sp.cos(t) ** 2 + b**2 * sp.sin(t) ** 2)
    radius = a**2 * b**2 / support**3
    assert zero(support + support.diff(t, 2) - radius)
    rate = 3 * a**2 * b**2 * (a**2 - b**2) * sp.sin(t) * sp.cos(t) / support**5
    assert zero(radius.diff(t) - rate)
    for s0, power in ((0.0, 4), (np.pi / 2, 4), (0.7, 3)):
        p0, p1, rho = (float(e.subs({a: 2, b: 1, t: s0}))
                       for e in (support, support.diff(t), radius))  # fmt: skip
        turn = np.array([[np.cos(s0), np.sin(s0)], [-np.sin(s0), np.cos(s0)]])
        vertex = np.array([*((p0 - rho, p1) @ turn), rho])
        gaps = [n @ vertex + h for n, h in (_slope_planes(s0 + step) for step in (0.01, 0.02))]
        assert abs(np.log2(gaps[1] / gaps[0]) - power) < 0.05
    # A regular edge: its planes leave each of its points by curvature times torsion over 6.
    bend, twist = (sp.Function(name)(t) for name in ("bend", "twist"))
    q = [sp.Function(f"q{axis}")(t) for axis in "TNB"]  # from the moving frame to the point
    turned = bend * q[1] - 1, twist * q[2] - bend * q[0], -twist * q[1]
    rates = {c.diff(t): rate for c, rate in zip(q, turned, strict=True)}
    away = q[2]
    for order in (1, 2, 3):
        away = sp.expand(away.diff(t).subs(rates))
        left = away.subs(dict.fromkeys(q, 0))
        assert zero(left + (bend * twist if order == 3 else 0))

    # So a helix', though the normals of its planes are those of a cone.
    def helix(s):
        return CURVES["helix"](s)[0]

    vertex, axis, angle = osculating_cone(helix, 0.6)
    n, h = tangent_planes(helix, 0.6 + np.array([0.01, 0.02]))
    assert np.allclose(n @ axis, np.sin(angle), atol=1e-14)
    assert abs(np.log2((n @ vertex + h)[1] / (n @ vertex + h)[0]) - 3) < 0.01


def test_fig6_common_plane():
    """Surface and cone have the plane and the ruling; their neighbours part at third order."""

    def edge(s):
        return CURVES["knot"](s)[0]

    vertex, axis, angle = osculating_cone(edge, 0.6)
    n, h = tangent_planes(edge, 0.6)
    ruling = np.array(CURVES["knot"](0.6)[1], dtype=float)
    assert np.isclose(n @ axis, np.sin(angle)) and np.isclose(n @ vertex, -h)
    assert np.isclose(axis @ ruling, np.cos(angle) * np.linalg.norm(ruling))
    gaps = []
    for step in (0.01, 0.02):
        n, h = tangent_planes(edge, 0.6 + step)
        gaps.append((n @ vertex + h, n @ axis - np.sin(angle)))
    powers = np.log2(np.divide(*gaps[::-1]))
    assert np.all(np.abs(powers - 3) < 0.1), powers


def test_fig7_contact_curve_crosses_the_circles():
    """Along the motion the planes leave the cone's circle, where the envelope is regular."""
    surface = moving_cone(MOTIONS["screw"], ANGLE)
    n = adapted_frames(surface, *GRID, "space").n
    across = n[0].derivative(1, 0) * n[1].derivative(0, 1)
    across = across - n[0].derivative(0, 1) * n[1].derivative(1, 0)
    assert np.abs(across).min() > 1e-3


def test_fig8_circle_through_the_point():
    z, a, b = osculating_conic((0.4, 0.2), example(*jet_variables(0.5, 0.3)))
    points = conic((0.5, 0.3, z), (0.4, 0.2), a, b, np.linspace(0, 6, 7))
    assert np.allclose(points[0], (0.5, 0.3, z))
    assert np.allclose(np.linalg.norm(points[:, :2] - (0.9, 0.5), axis=1), np.hypot(0.4, 0.2))


def test_fig9_six_rulings_two_generators():
    cones = hyperosculating_cones(example, 0.9, 0.6, half_angle=ANGLE)
    assert cones.count == 6 and np.sum(np.abs(cones.order4) < 1e-9) == 2
