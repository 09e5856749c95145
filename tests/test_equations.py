"""Tunnelling robot, Eqs 1 to 19, figures, table and listing: one proof a claim.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import itertools

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

from tests.basic_listing import PRINTED, REPAIRS, run
from tunneller_lib.paths import ConeChord, project_chord
from tunneller_lib.replica import quartics
from tunneller_lib.replica.quartics import foot_quartic, line_quartic, real_roots
from tunneller_lib.surfaces import REFERENCE_MACHINE, Cone, Egg, Torus

r, R, theta, phi = sp.symbols("r R theta phi", positive=True)
t, u, k, H, h, f = sp.symbols("t u k H h f", positive=True)
x, y, z, w = sp.symbols("x y z w")
a = a1, a2, a3 = sp.symbols("a1:4")
b = b1, b2, b3 = sp.symbols("b1:4")
m = m1, m2, m3 = sp.symbols("m1:4")
n = n1, n2, n3 = sp.symbols("n1:4")

TORUS = (x**2 + y**2 + z**2 - (r**2 + R**2)) ** 2 - (2 * r) ** 2 * (R**2 - y**2)  # Eq. 2
TORI = (Torus(1, 2), Torus(0.08, 0.8), Torus(3, 24), Torus(2, 1.5))
DEGREES = sp.pi / 180


def zero(expression):
    """Return whether an expression, or each entry of a matrix, vanishes identically."""
    return all(sp.simplify(e) == 0 for e in sp.Matrix([expression]))


def at(expression, symbols, values):
    """Return an expression in floats, computed by sympy from the values given."""
    return sp.lambdify(symbols, expression, "numpy")(*values)


def close(found, expected, scale=1.0):
    return np.max(np.abs(np.asarray(found) - expected)) < 1e-11 * scale


def draw(seed, *shape):
    return np.random.default_rng(seed).uniform(-1, 1, shape)


def positions(seed, count):
    """Return joint positions within the machine's limits."""
    low = REFERENCE_MACHINE.theta_min, REFERENCE_MACHINE.phi_min
    high = REFERENCE_MACHINE.theta_max, REFERENCE_MACHINE.phi_max
    return np.random.default_rng(seed).uniform(low, high, (count, 2))


# ---- section 1: the machine -----------------------------------------------------------------


def test_ring_radius_words():
    point = sp.Matrix([(r + R * sp.cos(phi)) * sp.cos(theta), R * sp.sin(phi),
                       -(r + R * sp.cos(phi)) * sp.sin(theta)])  # fmt: skip
    centre = r * sp.Matrix([sp.cos(theta), 0, -sp.sin(theta)])
    printed = R  # "the greater, ring centre circle radius R"
    assert zero(centre.dot(centre) - r**2)
    assert not zero(centre.dot(centre) - printed**2)
    assert zero((point - centre).dot(point - centre) - R**2)
    # With r the lesser, the torus meets itself in two nodes on the joint's axis.
    node = {x: 0, y: sp.sqrt(R**2 - r**2), z: 0}
    assert zero([TORUS.subs(node), *[TORUS.diff(v).subs(node) for v in (x, y, z)]])
    assert close(Torus(1, 2).point(0.7, np.arccos(-1 / 2)), [0, 3**0.5, 0])
    # A second way, measured on the library's tori: distances from a circle of either radius.
    for torus in TORI:
        x_, y_, z_ = torus.point(*3 * draw(30, 2, 50)).T
        ring, printed = (np.hypot(np.hypot(x_, z_) - size, y_) for size in (torus.r, torus.R))
        inner = np.hypot(np.hypot(x_, z_) + torus.r, y_)  # of the sheet beyond the axis
        assert close(np.minimum(abs(ring - torus.R), abs(inner - torus.R)), 0, torus.R)
        assert np.ptp(printed) > 0.1 * torus.r


def test_joint_ranges():
    limits = REFERENCE_MACHINE
    for low, high in ((-40, 40), (-60, 35), (-60, 60)):
        ahead, backwards = 0, low - 90
        printed = [low >= angle <= high for angle in (ahead, backwards)]
        corrected = [low <= angle <= high for angle in (ahead, backwards)]
        assert printed == [False, True] and corrected == [True, False]
    degrees = [limits.theta_min, limits.theta_max, limits.phi_min, limits.phi_max]
    assert close(np.degrees(degrees), [-60, 35, -40, 40], 10)
    assert limits.within_limits([0.0, 0.0]) and not limits.within_limits(np.radians([0, -130]))
    # A second way, poses: the printed relation admits some with the cutter behind the joints, the
    # corrected none.
    behind = limits.torus.point(0, np.radians(np.arange(-260, 41)))[:, 0] < limits.r
    assert np.any(behind[:221]) and not np.any(behind[220:])  # up to -40, and from there on


def test_ratio_eight_somewhat_less():
    ratio = sp.symbols("ratio", positive=True)
    # Half the spread of the distances from the centre, in radii R: it falls with R/r.
    spread = (1 + 1 / ratio - sp.sqrt(1 - 1 / ratio**2)) / 2
    slope = sp.simplify(spread.diff(ratio) * ratio**2)
    assert all(slope.subs(ratio, q) < 0 for q in (2, 8, 10, 100))
    # Read literally, 8 is less than the machine's ratio: the machine is still nearer a sphere.
    machine = sp.Rational(str(REFERENCE_MACHINE.R)) / sp.Rational(str(REFERENCE_MACHINE.r))
    assert machine > 8 and spread.subs(ratio, machine) < spread.subs(ratio, 8)


def test_fig2_distances_diminish():
    along_theta = sp.sqrt(sum(c.diff(theta) ** 2 for c in parametrised()))
    along_phi = sp.sqrt(sum(c.diff(phi) ** 2 for c in parametrised()))
    assert zero(along_theta**2 - (r + R * sp.cos(phi)) ** 2)  # falls as |phi| grows
    assert zero((r + R * sp.cos(phi)).diff(phi) + R * sp.sin(phi))
    assert zero(along_phi**2 - R**2)  # doesn't
    torus, step, phis = Torus(1, 8), np.radians(10), np.radians(np.arange(0, 61, 10))
    across = np.linalg.norm(torus.point(step, phis) - torus.point(0, phis), axis=-1)
    up = np.linalg.norm(np.diff(torus.point(0, phis), axis=0), axis=-1)
    assert np.all(np.diff(across) < 0) and close(up, 2 * 8 * np.sin(step / 2))


def test_fig3_nearly_spherical():
    distance2 = sum(c**2 for c in parametrised())
    assert zero(distance2.diff(phi) + 2 * r * R * sp.sin(phi))  # falls from equator to node
    equator, node = sp.simplify(distance2.subs(phi, 0)), distance2.subs(sp.cos(phi), -r / R)
    node = sp.simplify(node.subs(sp.sin(phi) ** 2, 1 - r**2 / R**2))
    assert zero([equator - (R + r) ** 2, node - (R**2 - r**2)])
    eight = {r: 1, R: 8}
    assert (sp.sqrt(equator.subs(eight)), sp.sqrt(node.subs(eight))) == (9, 3 * sp.sqrt(7))
    off = (9 - 3 * sp.sqrt(7)) / (9 + 3 * sp.sqrt(7))  # from the sphere half-way between
    assert sp.Rational(6, 100) < off < sp.Rational(7, 100)
    tip = np.arccos(-1 / 8)
    sheet = np.linalg.norm(Torus(1, 8).point(0.3, np.linspace(-tip, tip, 999)), axis=-1)
    assert close([sheet.max(), sheet.min()], [9, 3 * 7**0.5])


# ---- section 2: the tunnel ------------------------------------------------------------------


def test_fig4_section():
    size = sp.symbols("a", positive=True)
    roof, wall, floor = size, 3 * size, size / 2
    # C1: the centres of two blended arcs lie on one line with their common point.
    offset, drop = sp.symbols("offset drop", positive=True)
    centres = sp.solve(
        [offset - (wall - roof), offset**2 + drop**2 - (wall - floor) ** 2], [offset, drop]
    )
    assert centres == [(2 * size, 3 * size / 2)]  # with 5a/2: a triangle 3-4-5
    blend = sp.Matrix([2 * size, 0]) + wall * sp.Matrix([-4, -3]) / 5
    assert blend == sp.Matrix([-2 * size / 5, -9 * size / 5])
    assert (blend - sp.Matrix([0, -3 * size / 2])).norm() == floor
    assert (2 * roof, roof + 3 * size / 2 + floor) == (2 * size, 3 * size)  # the box as printed

    egg = Egg(0.5)
    assert [arc.radius for arc in egg.arcs] == [0.5, 1.5, 0.25, 1.5]
    before, after = egg.normal(egg.blends - 1e-9), egg.normal(egg.blends + 1e-9)
    assert np.max(np.abs(before - after)) < 1e-8  # no corner anywhere
    assert close(egg.point(egg.blends[2]), [-0.2, -0.9])
    outline = egg.point(np.linspace(0, egg.perimeter, 20001))
    assert np.max(np.abs(np.ptp(outline, axis=0) - [1, 1.5])) < 1e-7


# ---- section 3.1: torus ---------------------------------------------------------------------


def parametrised():
    """Return the right sides of Eq. 1 as printed."""
    return ((r + R * sp.cos(phi)) * sp.cos(theta), R * sp.sin(phi),
            -(r + R * sp.cos(phi)) * sp.sin(theta))  # fmt: skip


def horizontal_joint():
    """Return the turn by theta about y."""
    cos, sin = sp.cos(theta), sp.sin(theta)
    return sp.Matrix([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def test_eq01_point():
    printed = sp.Matrix(parametrised())
    swing = sp.Matrix([R * sp.cos(phi), R * sp.sin(phi), 0])  # tangential joint
    assert zero(horizontal_joint() * (sp.Matrix([r, 0, 0]) + swing) - printed)
    angles = draw(1, 2, 50)
    for torus in TORI:
        expected = np.transpose(at(printed.T, (r, R, theta, phi), (torus.r, torus.R, *angles)))
        assert close(torus.point(*angles), expected.reshape(-1, 3), torus.R)


def test_frame():
    forward, up = sp.Matrix([1, 0, 0]), sp.Matrix([0, 0, 1])
    left = up.cross(forward)
    assert left == sp.Matrix([0, 1, 0])  # +y is left, and x, y, z is right-handed
    turn = horizontal_joint()
    assert zero(turn.diff(theta).subs(theta, 0) * forward - left.cross(forward))
    assert zero(turn * sp.Matrix([r + R, 0, 0]) - sp.Matrix(parametrised()).subs(phi, 0))
    assert Torus(1, 8).point(np.radians(-60), 0)[2] > 0  # "-60 represents elevation"


def test_eq01_cited_as_eq02():
    # "Squaring Eqs. 2 and adding these": only the three lines of Eq. 1 can be squared and added.
    squared_eq1 = sum(c**2 for c in parametrised())
    assert zero(squared_eq1 - (r**2 + 2 * r * R * sp.cos(phi) + R**2))
    printed = TORUS  # Eq. 2, whose left side is zero already
    on_surface = printed.subs(dict(zip((x, y, z), parametrised(), strict=True)))
    assert zero(on_surface) and not zero(on_surface**2 - squared_eq1)
    # A second way, in numbers: the sum is that of Eq. 1, while Eq. 2 says 0.
    point = Torus(1, 2).point(0.7, 0.4)
    assert close(np.sum(point**2), 1 + 4 * np.cos(0.4) + 4) and close(
        Torus(1, 2).implicit(point), 0
    )


def test_eq02_implicit():
    printed = TORUS
    assert zero(printed.subs(dict(zip((x, y, z), parametrised(), strict=True))))
    # Nothing else: in rho^2 = x^2 + z^2 it is the product over both meridian circles.
    rho = sp.symbols("rho")
    circles = sp.prod((rho - s * r) ** 2 + y**2 - R**2 for s in (1, -1))
    assert zero(printed.subs({x: rho, z: 0}) - circles)
    points = draw(2, 50, 3)
    for torus in TORI:
        expected = at(printed, (r, R, x, y, z), (torus.r, torus.R, *points.T))
        assert close(torus.implicit(points), expected, (torus.r + torus.R) ** 4)


def test_eq02_derivation():
    # x^2 + y^2 + z^2 = r^2 + 2 r R cos(phi) + R^2, cos(phi) from y = R sqrt(1 - cos^2(phi)).
    cosine, total = sp.symbols("cosine total")
    first = total - (r**2 + 2 * r * R * cosine + R**2)
    second = y**2 - R**2 * (1 - cosine**2)
    eliminated = sp.resultant(first, second, cosine) / R**2
    assert zero(eliminated.subs(total, x**2 + y**2 + z**2) - TORUS)


def test_eq02_expansion():
    c2, s2 = sp.cos(theta) ** 2, sp.sin(theta) ** 2
    printed = (r + R * sp.cos(phi)) ** 2 * (c2 + s2) + R**2 * sp.sin(theta) ** 2
    corrected = (r + R * sp.cos(phi)) ** 2 * (c2 + s2) + R**2 * sp.sin(phi) ** 2
    truth = sum(c**2 for c in parametrised())
    assert zero(corrected - truth)
    pole = {theta: 0, phi: sp.pi / 2}
    assert (printed - truth).subs(pole) == -(R**2)
    # The document's next line follows from the corrected one only.
    assert zero(corrected - (r**2 + 2 * r * R * sp.cos(phi) + R**2))
    # A second way, in numbers: the library's points, near and far.
    for torus in TORI:
        angles = draw(31, 2, 50)
        truth = np.sum(torus.point(*angles) ** 2, axis=-1) / torus.R**2
        values = (torus.r, torus.R, *angles)
        assert close(at(corrected, (r, R, theta, phi), values) / torus.R**2, truth)
        assert np.max(np.abs(at(printed, (r, R, theta, phi), values) / torus.R**2 - truth)) > 0.1
    assert close(np.sum(Torus(1, 2).point(0, np.pi / 2) ** 2), 5)


def test_eq03_homogeneous():
    rho = sp.symbols("rho")
    sphere = -(rho**2) * w**2 + x**2 + y**2 + z**2
    powers = [p for p in itertools.product(range(4), repeat=4) if sum(p) == 3]
    coefficients = [sp.Symbol("k_{}{}{}{}".format(*p)) for p in powers]
    cubic = sum(
        c * sp.prod(map(sp.Pow, (w, x, y, z), p)) for c, p in zip(coefficients, powers, strict=True)
    )
    printed, corrected = sphere**2 + cubic, sphere**2 + w * cubic
    assert not sp.Poly(printed, w, x, y, z).is_homogeneous
    assert sp.Poly(corrected, w, x, y, z).is_homogeneous
    assert zero((printed - corrected).subs(w, 1))
    # The torus: rho^2 = r^2 + R^2 and a remainder that w divides.
    torus = sphere.subs(rho**2, r**2 + R**2) ** 2 - 4 * r**2 * w * (R**2 * w**3 - y**2 * w)
    assert zero(torus.subs(w, 1) - TORUS) and sp.Poly(torus, w, x, y, z).is_homogeneous
    assert close(Torus(1, 2).implicit((0.3, 0.4, 0.5)),
                 float(torus.subs({w: 1, r: 1, R: 2, x: 0.3, y: 0.4, z: 0.5})))  # fmt: skip


def test_eq03_cyclide():
    # A cyclide has the circle at infinity, w = 0 and x^2 + y^2 + z^2 = 0, as a double curve.
    sphere = x**2 + y**2 + z**2
    constants = sp.symbols("c0:20")
    quadric = sp.Matrix([w, x, y, z]).dot(sp.Matrix(4, 4, lambda i, j: constants[4 + 4 * i + j])
                                          * sp.Matrix([w, x, y, z]))  # fmt: skip
    linear = sum(c * v for c, v in zip(constants[:4], (w, x, y, z), strict=True))

    def gradient_at_infinity(surface):
        ideal = [surface.diff(v).subs(w, 0) for v in (w, x, y, z)]
        return [sp.rem(sp.expand(g), sphere, x) for g in ideal]

    printed = sphere**2 + w * x**3  # the choice k_0300 = 1 among Eq. 3's
    corrected = sphere**2 + w * sphere * linear + w**2 * quadric
    assert any(not zero(g) for g in gradient_at_infinity(printed))
    assert all(zero(g) for g in gradient_at_infinity(corrected))
    # The torus itself has no cubic part, so it is among Eq. 3's.
    assert all(sum(powers) != 3 for powers, _ in sp.Poly(TORUS, x, y, z).terms())


# ---- section 3.2: line and torus ------------------------------------------------------------


def line_polynomial():
    """Return Eq. 4 with q put in, as a polynomial in t."""
    q = [ai + (bi - ai) * t for ai, bi in zip(a, b, strict=True)]
    return sp.Poly(TORUS.subs(dict(zip((x, y, z), q, strict=True))), t)


def test_eq04_line():
    q = sp.symbols("q1:4")
    printed = (q[0] ** 2 + q[1] ** 2 + q[2] ** 2 - r**2 - R**2) ** 2 - 4 * r**2 * (R**2 - q[1] ** 2)
    assert zero(printed.subs(dict(zip(q, (x, y, z), strict=True))) - TORUS)
    assert line_polynomial().degree() == 4
    ends = draw(4, 2, 40, 3)
    for torus in TORI:
        start, stop = ends[:, :, :] * torus.R
        ts = torus.meet_line(start, stop)
        points = start[:, None] + ts[..., None] * (stop - start)[:, None]
        residual = torus.implicit(points)[~np.isnan(ts)] / (torus.r + torus.R) ** 4
        assert residual.size > 40 and np.max(np.abs(residual)) < 1e-11


def test_four_points():
    # "A line intersects a torus on four points": counted with complex ones.
    torus, shape = Torus(1, 2), {r: 1, R: 2}
    lines = {4: ((-10, 0, 0), (-9, 0, 0)), 2: ((-9, 0, 2), (-8, 0, 2)), 0: ((9, 5, 0), (8, 5, 0))}
    for count, (start, stop) in lines.items():
        values = shape | dict(zip(a + b, start + stop, strict=True))
        quartic = sp.Poly(line_polynomial().as_expr().subs(values), t)
        assert quartic.degree() == 4 and quartic.count_roots() == count
        assert np.sum(~np.isnan(torus.meet_line(start, stop))) == count


def test_no_straight_lines():
    leading = line_polynomial().coeff_monomial(t**4)
    assert zero(
        leading - sum((bi - ai) ** 2 for ai, bi in zip(a, b, strict=True)) ** 2
    )  # never 0 for a != b
    start, stop = draw(5, 2, 20, 3)
    assert np.all(line_quartic(Torus(1, 2), start, stop)[:, 0] > 0)


def printed_eq05():
    d1, d2, d3 = b1 - a1, b2 - a2, b3 - a3
    t4 = d1**2 + d2**2 + d3**2
    t3 = a1 * d1 + a2 * d2 + a3 * d3
    t2 = a1**2 + a2**2 + a3**2 - r**2 - R**2
    printed = {
        4: t4**2,
        3: 4 * t3 * t4,
        2: 4 * r**2 * d2**2 + 2 * t2 * t4 + 2 * t3**2,
        1: 8 * r**2 * a2 * d2 + 4 * t2 * t3,
        0: t2 - 4 * r**2 * (R**2 - a2**2),
    }
    return printed, t2, t3


def test_eq05_T4_T3_T1():
    printed, _, _ = printed_eq05()
    for power in (4, 3, 1):
        assert zero(line_polynomial().coeff_monomial(t**power) - printed[power])


def test_eq05_T2():
    printed, _, t3 = printed_eq05()
    corrected = printed[2] + 2 * t3**2  # 4 t3^2 for 2 t3^2
    truth = line_polynomial().coeff_monomial(t**2)
    assert zero(corrected - truth) and not zero(printed[2] - truth)
    # A second way, from roots that are known.
    pairs = itertools.combinations([7, 9, 11, 13], 2)
    assert by_known_roots(corrected, printed[4]) == sum(p * q for p, q in pairs) == 590
    assert by_known_roots(printed[2], printed[4]) == 390


def by_known_roots(coefficient, leading):
    """Return a coefficient over the leading one, where the x axis meets the torus (1, 2).

    From x = -10 in steps of 1 it does so at t = 7, 9, 11, 13: at x = -3, -1, 1, 3.
    """
    line = {r: 1, R: 2, **dict(zip(a + b, (-10, 0, 0, -9, 0, 0), strict=True))}
    return coefficient.subs(line) / leading.subs(line)


def test_eq05_T0():
    printed, t2, _ = printed_eq05()
    corrected = t2**2 - 4 * r**2 * (R**2 - a2**2)  # t2^2 for t2
    truth = line_polynomial().coeff_monomial(1)
    assert zero(corrected - truth) and not zero(printed[0] - truth)
    # A second way, from roots that are known.
    assert by_known_roots(corrected, printed[4]) == 7 * 9 * 11 * 13
    assert by_known_roots(printed[0], printed[4]) == 79
    assert close(Torus(1, 2).meet_line((-10, 0, 0), (-9, 0, 0)), [7, 9, 11, 13], 10)


def test_eq05_quartic():
    printed, t2, t3 = printed_eq05()
    corrected = printed | {2: printed[2] + 2 * t3**2, 0: printed[0] - t2 + t2**2}
    # The x axis meets the torus r = 1, R = 2 in -3, -1, 1, 3.
    line = {r: 1, R: 2, **dict(zip(a + b, (-10, 0, 0, -9, 0, 0), strict=True))}
    for form, found in ((printed, False), (corrected, True)):
        quartic = sp.Poly(sum(c * t**p for p, c in form.items()).subs(line), t)
        assert (quartic.real_roots() == [7, 9, 11, 13]) is found
    # A second way, in numbers: the library's coefficients, and its roots by no polynomial.
    ends = draw(6, 6, 40)
    for torus in TORI:
        values = (torus.r, torus.R, *ends)
        expected = [at(corrected[p], (r, R, *a, *b), values) for p in (4, 3, 2, 1, 0)]
        coefficients = line_quartic(torus, ends[:3].T, ends[3:].T)
        assert close(coefficients, np.transpose(expected), (torus.r + torus.R) ** 4)
        exact = torus.meet_line(ends[:3].T, ends[3:].T)
        quartic = quartics.meet_line(torus, ends[:3].T, ends[3:].T)
        assert np.nanmax(np.abs(exact - quartic) / (1 + np.abs(exact))) < 1e-5


def test_greatest_x_root():
    # At each height y the working sheet's circle lies outside the other's: bodies one in another,
    # so that a line's first and last points are on the working sheet.
    half = sp.symbols("half", positive=True)  # sqrt(R^2 - y^2)
    outer, inner = r + half, half - r
    assert zero(outer**2 - inner**2 - 4 * r * half)
    for torus in TORI[:3]:
        ends = draw(7, 2, 400, 3) * torus.R
        ts = torus.meet_line(*ends)
        hit = ~np.isnan(ts[:, 1])
        ts, start, along = ts[hit], ends[0][hit], (ends[1] - ends[0])[hit]
        points = start[:, None] + ts[..., None] * along[:, None]
        greatest = np.nanargmax(points[..., 0], axis=1)
        chosen = points[np.arange(len(points)), greatest]
        back = torus.point(*torus.angles(chosen))
        assert np.max(np.abs(back - chosen)) < 1e-9 * torus.R
        lemon = points[~np.isnan(ts[:, 3])][:, 1]  # of four the second, but for polar hollows
        back = torus.point(*torus.angles(lemon))
        apart = np.linalg.norm(back - lemon, axis=-1)
        assert len(lemon) > 5 and np.sum(apart > 1e-3 * torus.R) > 5


# ---- section 3.3.1: tangent spheres ---------------------------------------------------------

SQUARE = n1**2 + n2**2 + n3**2
PLUS, MINUS = SQUARE + r**2 - R**2, SQUARE - r**2 - R**2
EQ6 = MINUS**2 - 4 * r**2 * (R**2 - n2**2)
EQ8 = PLUS * (n3 - m3) * n2 - MINUS * (n2 - m2) * n3
EQ9 = PLUS * (n1 - m1) * n2 - MINUS * (n2 - m2) * n1
THIRD = m1 * n3 - m3 * n1
SIGNS = tuple(itertools.product((1, -1), repeat=2))
EXAMPLE = {r: 1, R: 4, m1: 2, m2: 1, m3: 3}


def vanishes_at_feet(equation):
    """Return whether a polynomial in n is zero at the four feet, whatever r, R and M are.

    With rho^2 = m1^2 + m3^2, d^2 = (rho - sigma r)^2 + m2^2: N = (W m1/rho, eps R m2/d, W m3/rho),
    W = sigma r + eps R (rho - sigma r)/d.
    """
    rho, d, c, s = sp.symbols("rho d c s")
    for sigma, eps in SIGNS:
        W = sigma * r + eps * R * (rho - sigma * r) / d
        foot = {n1: W * c, n2: eps * R * m2 / d, n3: W * s, m1: rho * c, m3: rho * s}
        top = sp.numer(sp.together(equation.subs(foot, simultaneous=True)))
        top = sp.rem(sp.expand(top), s**2 + c**2 - 1, s)
        if sp.rem(top, d**2 - (rho - sigma * r) ** 2 - m2**2, d) != 0:
            return False
    return True


def test_eq06_on_torus():
    printed = EQ6
    assert zero(printed.subs(dict(zip(n, (x, y, z), strict=True))) - TORUS)
    assert vanishes_at_feet(printed)
    points = 3 * draw(8, 50, 3)
    for torus in TORI:
        scale = np.linalg.norm(points, axis=-1)[:, None] + torus.r + torus.R
        assert np.max(np.abs(torus.implicit(torus.feet(points))) / scale**4) < 1e-12


def test_eq07_gradient():
    printed = sp.Matrix([MINUS * n1, PLUS * n2, MINUS * n3])
    gradient = sp.Matrix([EQ6.diff(v) for v in n])
    assert not zero(gradient - printed)
    assert zero(gradient - 4 * printed)  # so the direction numbers are right
    for torus in TORI:
        angles = draw(9, 2, 30)
        values = (torus.r, torus.R, *torus.point(*angles).T)
        direction = np.reshape(at(printed, (r, R, *n), values), (3, -1)).T
        outward = direction / np.linalg.norm(direction, axis=1)[:, None]
        assert close(np.abs(np.sum(outward * torus.normal(*angles), axis=-1)), 1)


def test_eq08_eq09_normal():
    normal = sp.Matrix([MINUS * n1, PLUS * n2, MINUS * n3])
    cross = normal.cross(sp.Matrix(n) - sp.Matrix(m))
    assert zero([cross[0] - EQ8, cross[2] + EQ9, cross[1] + MINUS * THIRD])
    assert vanishes_at_feet(EQ8) and vanishes_at_feet(EQ9) and vanishes_at_feet(THIRD)
    for torus in TORI:
        points = 2 * torus.R * draw(10, 40, 3)
        feet = np.moveaxis(torus.feet(points), -1, 0)
        for equation in (EQ8, EQ9):
            values = (torus.r, torus.R, *points.T[..., None], *feet)
            assert close(at(equation, (r, R, *m, *n), values), 0, 1e3 * torus.R**4)


def test_eq08_eq09_common_zeros():
    # Off the plane m2 = 0: four feet and the two nodes, which have no normal.
    ideal = [e.subs(EXAMPLE) for e in (EQ6, EQ8, EQ9)]
    basis = sp.groebner(ideal, n3, n2, n1, order="lex")
    assert basis.contains(THIRD.subs(EXAMPLE))
    shape = sp.Poly(basis.exprs[-1], n1).factor_list()[1]
    assert [(p.degree(), e) for p, e in shape] == [(1, 2), (4, 1)]
    # Each of the four n1 has one n2, from a member of the ideal that is linear in it.
    linear = [sp.quo(e, n1**2, n1) for e in basis.exprs if sp.rem(e, n1**2, n1) == 0]
    assert any(sp.degree(e, n2) == 1 and not e.has(n3) for e in linear)
    at_nodes = sp.groebner([*ideal, n1], n3, n2, n1, order="lex")
    assert at_nodes.contains(n1) and at_nodes.contains(n3)
    nodes = sp.Poly(at_nodes.exprs[1], n2)
    assert set(nodes.real_roots()) == {sp.sqrt(15), -sp.sqrt(15)}  # +-sqrt(R^2 - r^2)
    # In the plane m2 = 0 the printed two hold on whole circles; the third component is needed.
    circle = {m2: 0, n2: 0}
    assert zero([EQ8.subs(circle), EQ9.subs(circle)])
    stray = {**EXAMPLE, m2: 0, n1: 5, n2: 0, n3: 0}
    assert zero([e.subs(stray) for e in (EQ6, EQ8, EQ9)])
    assert THIRD.subs(stray) != 0 and not np.any(np.all(
        np.isclose(Torus(1, 4).feet((2, 0, 3)), (5, 0, 0)), axis=-1))  # fmt: skip


def eliminate(first, numbers, twice=EQ9):
    """Return the factors {polynomial in n1: multiplicity} left by eliminating n2 and n3.

    The one named `first` goes from the two pairs that one equation makes with the other two.
    """
    second = {n2: n3, n3: n2}[first]
    others = [e for e in (EQ6, EQ8, EQ9) if e is not twice]
    *others, twice = (sp.Poly(e.subs(numbers), first, second, n1) for e in (*others, twice))
    pair = [p.resultant(twice).factor_list()[1] for p in others]
    factors = {}
    for (p, i), (q, j) in itertools.product(*pair):
        p, q = (sp.Poly(e.as_expr(), second, n1) for e in (p, q))
        for factor, power in p.resultant(q).factor_list()[1]:
            factors[factor] = factors.get(factor, 0) + i * j * power
    return factors


def test_degree_64():
    # 64 = 4 * 4 * 4 counts (8) and (9) as quartics; their leading terms cancel: 4 * 3 * 3 = 36.
    degrees = [sp.Poly(e, *n).total_degree() for e in (EQ6, EQ8, EQ9)]
    assert degrees == [4, 3, 3] and sp.prod(degrees) == 36
    another = {r: sp.Rational(2, 3), R: 5, m1: sp.Rational(7, 2), m2: -2, m3: sp.Rational(1, 5)}
    for numbers in (EXAMPLE, another):
        found = []  # every order of resultants
        for first, twice in itertools.product((n2, n3), (EQ6, EQ8, EQ9)):
            factors = eliminate(first, numbers, twice)
            found.append(sum(p.degree() * power for p, power in factors.items()))
        assert found == [44, 40, 40, 40, 40, 40]
        # What the three equations really imply for n1 has degree 6: n1^2 times the quartic.
        ideal = [e.subs(numbers) for e in (EQ6, EQ8, EQ9)]
        implied = sp.groebner(ideal, n3, n2, n1, order="lex").exprs[-1]
        valid = n1**2 * eq11_corrected(0).subs(numbers)
        assert sp.Poly(implied, n1).monic() == sp.Poly(valid, n1).monic()
    roots = real_roots(foot_quartic(Torus(1, 4), (2, 1, 3)))
    assert close(np.sort(Torus(1, 4).feet((2, 1, 3))[:, 0]), roots, 100)


def test_triple_product():
    numbers = [{**EXAMPLE, r: sp.Rational(3, 2), m3: third} for third in (3, 5)]
    here, there = (eliminate(n2, values) for values in numbers)
    for factors in (here, there):
        shape = sorted((p.degree(), power) for p, power in factors.items())
        assert shape == [(1, 12), (4, 2), (4, 2), (4, 3)]  # n1^12 q^3 a^2 b^2
    shared = set(here) & set(there)  # free of m3: n1, a and b
    assert sorted(p.degree() for p in shared) == [1, 4, 4]
    for factors, values in ((here, numbers[0]), (there, numbers[1])):
        (q,) = (p for p, power in factors.items() if power == 3)
        assert q not in shared
        valid = sp.Poly(eq11_corrected(0).subs(values), n1)
        assert zero(q.monic().as_expr() - valid.monic().as_expr())
    # In the other order the strangers are no quartics: n1^20 (n1 - m1)^12 q^2.
    other = eliminate(n3, numbers[0])
    assert sorted((p.degree(), power) for p, power in other.items()) == [(1, 12), (1, 20), (4, 2)]


def eq11_printed():
    nu4 = (
        r**4 + (m3**2 - 2 * r**2) * m3**2
        + (2 * (m3**2 + r**2) + m2**2) * m2**2
        + (2 * (m3**2 + m3**2 - r**2) + m1**2) * m1**2
    )  # fmt: skip
    nu2 = (
        (r**2 + R**2) * (r**4 + (m3**2 - 2 * r**2) * m3**2)
        + (r**2 * m2**2 + (2 * r**2 + R**2) * (r**2 + m3**2)) * m2**2
        + ((r**2 + R**2) * (2 * m3**2 + m1**2 - 2 * r**2) + (2 * r**2 + R**2) * m2**2) * m1**2
    )
    nu0 = (
        (r**2 - R**2) * (r**2 + R**2) * (r**4 + (m3**2 - 2 * r**2) * m3**2) * m3**2
        + r**2 * (2 * (r**2 - R**2) * (r**2 + m3**2) + r**2 * m2**2) * m2**2
        + (r**2 - R**2)
        * ((r**2 + R**2) * (-2 * r**2 + 2 * m3**2 + m1**2) + 2 * r**2 * m2**2) * m1**2
    )  # fmt: skip
    N4 = m1**4 * (m1**2 + m3**2) * nu4
    N2 = -2 * m1**6 * (m1**2 + m3**2) * nu2
    N1 = 8 * r**2 * R**2 * (m1**2 + m3**2) * m1**7 * m2**2
    N0 = m1**8 * nu0
    return {"nu4": nu4, "nu2": nu2, "nu0": nu0, "N4": N4, "N3": sp.Integer(0), "N2": N2,
            "N1": N1, "N0": N0}  # fmt: skip


def eq11_corrected(m1_power=4):
    """Return Eq. 10 with all corrections to Eq. 11, over the given power of the factor m1."""
    printed = eq11_printed()
    nu4, nu0 = eq11_corrected_nu()
    s = m1**2 + m3**2
    quartic = s**2 * nu4 * n1**4 + (printed["N2"] * n1**2 + printed["N1"] * n1) / m1**4
    return sp.expand(m1**m1_power * (quartic + m1**4 * nu0))


def eq11_corrected_nu():
    nu4 = (
        r**4 + (m3**2 - 2 * r**2) * m3**2
        + (2 * (m3**2 + r**2) + m2**2) * m2**2
        + (2 * (m2**2 + m3**2 - r**2) + m1**2) * m1**2
    )  # fmt: skip
    nu0 = (
        (r**2 - R**2) ** 2 * (r**4 + (m3**2 - 2 * r**2) * m3**2)
        + r**2 * (2 * (r**2 - R**2) * (r**2 + m3**2) + r**2 * m2**2) * m2**2
        + (r**2 - R**2)
        * ((r**2 - R**2) * (-2 * r**2 + 2 * m3**2 + m1**2) + 2 * r**2 * m2**2) * m1**2
    )  # fmt: skip
    return nu4, nu0


def feet_product():
    """Return the polynomial in n1 whose roots are the four feet's, by circles of both signs.

    (rho n1 - sigma r m1)^2 d^2 = R^2 m1^2 (rho - sigma r)^2 holds for both eps; the product
    over sigma is even in rho, and m1^2 + m3^2 replaces rho^2.
    """
    rho = sp.symbols("rho")
    product = sp.prod(
        (rho * n1 - s * r * m1) ** 2 * ((rho - s * r) ** 2 + m2**2) - (R * m1 * (rho - s * r)) ** 2
        for s in (1, -1)
    )
    even = sp.Poly(product, rho)
    assert all(power % 2 == 0 for (power,), _ in even.terms())
    return sp.Poly(sum(c * (m1**2 + m3**2) ** (p // 2) for (p,), c in even.terms()), n1)


def test_eq10_no_cubic():
    truth = feet_product()
    assert truth.degree() == 4 and zero(truth.coeff_monomial(n1**3))
    # The roots (m1/rho)(sigma r +- ...) sum to zero: r + r - r - r.
    rho, p, q = sp.symbols("rho p q")
    roots = [m1 / rho * (sigma * r + eps * (p if sigma > 0 else q)) for sigma, eps in SIGNS]
    assert zero(sum(roots))
    for torus in TORI:
        points = torus.R * draw(11, 40, 3)
        first = torus.feet(points)[..., 0]
        assert close(np.sum(first, axis=-1), 0, torus.R)
        coefficients = foot_quartic(torus, points)
        assert np.all(coefficients[:, 1] == 0)
        for i in range(3):  # a few, exactly: the feet's n1 are the roots
            values = dict(
                zip((r, R, *m), map(sp.Rational, (torus.r, torus.R, *points[i])), strict=True)
            )
            exact = sp.Poly(truth.as_expr().subs(values), n1).nroots(n=15)
            assert close(np.sort(first[i]), np.array(sorted(map(float, exact))), 1e2 * torus.R)


def test_eq10_back_substitution():
    # Not given for N: n3 = m3 n1 / m1 and, on one of the two circles, n2 = m2 (W - sigma r)/(...).
    rho, d = sp.symbols("rho d")
    for sigma, eps in SIGNS:
        W = sigma * r + eps * R * (rho - sigma * r) / d
        assert zero(m2 * (W - sigma * r) / (rho - sigma * r) - eps * R * m2 / d)
    assert vanishes_at_feet(THIRD)
    torus, centre = Torus(1, 4), (2.0, 1.0, 3.0)
    reach = np.hypot(centre[0], centre[2])
    for foot in torus.feet(centre):
        W, third = foot[0] * reach / centre[0], centre[2] * foot[0] / centre[0]
        both = [(foot[0], centre[1] * (W - s) / (reach - s), third) for s in (1, -1)]
        on_torus = np.abs(torus.implicit(both)) < 1e-9
        assert on_torus.sum() == 1 and close(np.array(both)[on_torus][0], foot, 10)


def coefficient(power, m1_power=4):
    return m1**m1_power * feet_product().coeff_monomial(n1**power)


def test_eq11_N4():
    s, (nu4, _) = m1**2 + m3**2, eq11_corrected_nu()
    printed, corrected = m1**4 * s * nu4, m1**4 * s**2 * nu4
    assert zero(corrected - coefficient(4)) and not zero(printed - coefficient(4))
    # A second way, by degrees: every coefficient's must fall by one as n1's rises.
    whole = {p: eq11_corrected(4).coeff(n1, p) for p in (2, 1, 0)} | {4: corrected}
    lengths = (r, R, *m)
    assert {sp.Poly(c, *lengths).total_degree() + p for p, c in whole.items()} == {16}
    assert sp.Poly(printed, *lengths).total_degree() + 4 == 14


def test_eq11_nu4():
    printed, (corrected, _) = eq11_printed()["nu4"], eq11_corrected_nu()
    s = m1**2 + m3**2
    assert zero(s**2 * corrected - coefficient(4, 0))
    assert not zero(s**2 * printed - coefficient(4, 0))
    assert zero(corrected - ((s + r**2 + m2**2) ** 2 - 4 * r**2 * s))
    assert (printed - corrected).subs(EXAMPLE) == 64  # 2 (m3^2 - m2^2) m1^2
    # A second way, in numbers: N1, which holds, is minus N4 times the sum of the feet's triple
    # products.
    feet, values = Torus(1, 4).feet((2, 1, 3))[:, 0], {**EXAMPLE}
    triples = sum(np.prod(three) for three in itertools.combinations(feet, 3))
    wanted = -float(coefficient(1, 0).subs(values)) / triples
    for form, right in ((corrected, True), (printed, False)):
        assert bool(abs(float((s**2 * form).subs(values)) / wanted - 1) < 1e-9) is right


def test_eq11_nu2_N2():
    printed = eq11_printed()
    assert zero(printed["N2"] - coefficient(2))
    s = m1**2 + m3**2
    short = (r**2 + R**2) * (s - r**2) ** 2 + (2 * r**2 + R**2) * (s + r**2) * m2**2 + r**2 * m2**4
    assert zero(printed["nu2"] - short)


def test_eq11_N1():
    assert zero(eq11_printed()["N1"] - coefficient(1))


def test_eq11_nu0():
    printed, (_, corrected) = eq11_printed()["nu0"], eq11_corrected_nu()
    assert zero(m1**4 * corrected - coefficient(0, 0))
    s, e = m1**2 + m3**2, r**2 - R**2
    short = e**2 * (s - r**2) ** 2 + 2 * r**2 * e * (s + r**2) * m2**2 + r**4 * m2**4
    assert zero(corrected - short)
    # Each of the two faults alone spoils it: the head, and the bracket of m1^2.
    head = e * (r**2 + R**2) * (r**4 + (m3**2 - 2 * r**2) * m3**2) * m3**2
    mended_head = printed - head + e**2 * (r**4 + (m3**2 - 2 * r**2) * m3**2)
    mended_bracket = printed - 2 * e * R**2 * (-2 * r**2 + 2 * m3**2 + m1**2) * m1**2
    for wrong in (printed, mended_head, mended_bracket):
        assert not zero(wrong - corrected)
    assert zero(mended_head + mended_bracket - printed - corrected)
    assert sp.Poly(head, r, R, *m).total_degree() == 10  # among terms of degree 8
    # A second way, in numbers: N0 is N4 times the product of the feet's n1.
    wanted = float(coefficient(4, 0).subs(EXAMPLE)) * np.prod(Torus(1, 4).feet((2, 1, 3))[:, 0])
    for form, right in ((corrected, True), (printed, False)):
        assert bool(abs(float((m1**4 * form).subs(EXAMPLE)) / wanted - 1) < 1e-9) is right


def test_eq11_quartic():
    # Corrected, Eqs 10 and 11 have exactly the n1 of the four feet as roots; printed, they don't.
    assert zero(eq11_corrected(0) - feet_product().as_expr())
    printed = eq11_printed()
    quartic = sum(printed[f"N{p}"] * n1**p for p in range(5))
    # A second way, in numbers: the library's feet, by no polynomial.
    foot = Torus(1, 4).feet((2, 1, 3))[:, 0]
    wrong, right = (
        sp.lambdify(n1, e.subs(EXAMPLE) / abs(e.subs(EXAMPLE).subs(n1, 0)))
        for e in (quartic, eq11_corrected())
    )
    assert np.min(np.abs(wrong(foot))) > 0.1 and close(right(foot), 0, 100)
    for torus in TORI:
        points = draw(12, 3, 40)
        expected = [
            at(eq11_corrected(0).coeff(n1, p), (r, R, *m), (torus.r, torus.R, *points))
            * np.ones(40)
            for p in (4, 3, 2, 1, 0)
        ]
        scale = (1 + torus.r + torus.R) ** 8
        assert close(foot_quartic(torus, points.T), np.transpose(expected), scale)


def test_eq11_common_factor():
    printed = eq11_printed()
    coefficients = [printed[name] for name in ("N4", "N2", "N1", "N0")]
    assert all(sp.rem(c, m1**4, m1) == 0 for c in coefficients)
    assert not all(sp.rem(sp.expand(c), m1**5, m1) == 0 for c in coefficients)
    # At m1 = 0 all vanish and the printed quartic says nothing; the feet exist all the same.
    assert all(c.subs(m1, 0) == 0 for c in coefficients)
    feet = Torus(1, 4).feet((0, 1, 3))
    assert close(Torus(1, 4).implicit(feet), 0, 1e3) and close(feet[:, 0], 0)
    assert np.ptp(feet[:, 2]) > 1


def test_nearest_foot():
    # |MN| = |R - d+|, R + d+, |R - d-|, R + d-, with d- >= d+: the distances of M from the
    # meridian circles' centres. The first is least where d+ + d- > 2R, and nowhere else.
    near, far = sp.symbols("near far", positive=True)
    assert zero((R - near) ** 2 - (R - far) ** 2 - (far - near) * (2 * R - near - far))
    assert zero((R + near) ** 2 - (R - near) ** 2 - 4 * R * near)
    # A second way, measured on the library's feet.
    for torus in TORI[:3]:
        centres = 2 * torus.R * draw(13, 500, 3)
        rho = np.hypot(centres[:, 0], centres[:, 2])
        plus, minus = (np.hypot(rho - s * torus.r, centres[:, 1]) for s in (1, -1))
        away = np.linalg.norm(torus.feet(centres) - centres[:, None], axis=-1)
        lengths = [abs(torus.R - plus), torus.R + plus, abs(torus.R - minus), torus.R + minus]
        assert close(away, np.transpose(lengths), 10 * torus.R)
        first = np.argmin(away, axis=-1) == 0
        assert np.array_equal(first, plus + minus > 2 * torus.R)
        assert 0 < np.sum(first) < len(first)
    # On the working sheet alone the nearest point is the working foot.
    for torus in TORI[:3]:
        sheet = np.arccos(-torus.r / torus.R) * np.linspace(-1, 1, 4001)
        turns = np.pi * np.linspace(-1, 1, 101)[:, None]
        for centre in torus.point(*draw(17, 8, 2).T) * 0.6:
            least = np.linalg.norm(torus.point(turns, sheet) - centre, axis=-1).min()
            away = np.linalg.norm(torus.foot(centre) - centre)
            assert away <= least < 1.01 * away + 0.01 * torus.R
    # A chord within the joint limits whose middle has another foot nearest: R/r = 10.
    ends = Torus(1, 10).point(np.arcsin([-0.8, 8 / 17]), 0.0)
    middle = np.mean(ends, axis=0)
    away = np.linalg.norm(Torus(1, 10).feet(middle) - middle, axis=-1)
    assert np.argmin(away) == 2 and away[0] - away[2] > 1.9
    assert close(np.linalg.norm(Torus(1, 10).foot(middle) - middle), away[0], 10)


def test_greatest_n1_foot():
    # Between the joint limits the working foot has the greatest n1. W = n1 rho / m1, so that
    # W(+,+) - W(+,-) = 2R(rho - r)/d+ > 0 beyond the ring, and
    # W(+,+) - W(-,+) = 2r - R (g(rho + r) - g(rho - r)), g(s) = s/sqrt(s^2 + m2^2), whose slope
    # m2^2/(s^2 + m2^2)^(3/2) falls: it is enough that d+^3 > R m2^2.
    s, d = sp.symbols("s d", positive=True)
    slope = (s / sp.sqrt(s**2 + m2**2)).diff(s)
    assert zero(slope - m2**2 / (s**2 + m2**2) ** sp.Rational(3, 2))
    assert sp.simplify(slope.diff(s) / s / m2**2).subs({s: 1, m2: 1}) < 0
    margin = d**3 - R * (d**2 - s**2)  # d = d+, s = rho - r: least at d = 2R/3
    (least,) = sp.solve(margin.diff(d), d)
    assert least == 2 * R / 3
    assert zero(margin.subs(d, least) - R * (s**2 - 4 * R**2 / 27))  # so s > 2R/sqrt(27) will do
    # Within the limits s >= (r + R cos 40) cos(95/2) - r, enough for all R > 5r/2.
    reach = (r + R * sp.cos(40 * DEGREES)) * sp.cos(sp.Rational(95, 2) * DEGREES) - r
    excess = sp.expand(reach - 2 * R / sp.sqrt(27))
    assert excess.coeff(r) < 0 and sp.N(excess.subs({r: 2, R: 5})) > 0
    for torus in (Torus(1, 2.5), Torus(1, 8), Torus(1, 10)):
        ends = torus.point(*positions(14, 4000).T).reshape(2, 2000, 3)
        share = np.random.default_rng(15).uniform(size=(2000, 1))
        centres = ends[0] + share * (ends[1] - ends[0])
        assert np.all(np.argmax(torus.feet(centres)[..., 0], axis=-1) == 0)
    # Deep inside, m1 > 0 alone isn't enough.
    assert np.argmax(Torus(1, 10).feet((1.05, 0.5, 0))[:, 0]) == 2


def test_fairly_equal_separation():
    # "Parameterizing in equal increments from P to Q": on a meridian, seen from the tube's centre,
    # tan(phi) = (2t - 1) tan(half), where half is half the angle between the end normals.
    half = sp.symbols("half", positive=True)
    printed = sp.atan((2 * t - 1) * sp.tan(half))
    middle, end = printed.diff(t).subs(t, sp.Rational(1, 2)), printed.diff(t).subs(t, 1)
    assert zero(middle / end - 1 / sp.cos(half) ** 2)
    even = (1 + sp.tan(half * (2 * u - 1)) / sp.tan(half)) / 2
    assert zero(((2 * t - 1) * sp.tan(half)).subs(t, even) - sp.tan(half * (2 * u - 1)))
    limits = np.radians([(10, -40), (10, 40)])
    for spacing in ("chord", "tangent", "arc"):
        path = project_chord(Torus(1, 10), *limits, 101, spacing=spacing)[:, 1]
        steps = np.diff(path)
        if spacing == "chord":
            expected = np.arctan(np.linspace(-1, 1, 101) * np.tan(limits[1, 1]))
            assert close(path, expected) and abs(steps.max() / steps.min() - 1.7) < 0.02
        else:
            assert np.ptp(steps) < 1e-9


# ---- section 3.3.2: the volume of a cut -----------------------------------------------------

c, g = sp.symbols("c g", positive=True)
V_D = 2 * sp.pi * (R**2 * (4 * R - 3 * c) / 12 + c**3 / 48)  # Eq. 12, printed
V_S, V_L = 4 * sp.pi * R**3 / 3, sp.pi * R**2 * c
V_C, V_R = V_S - 2 * V_D, V_L + 2 * V_D - V_S


def test_eq12_half_lens():
    primitive = -((R**2 - y**2) ** sp.Rational(3, 2)) / 3 - c * y**2 / 4
    assert zero(sp.diff(primitive, y) - y * (sp.sqrt(R**2 - y**2) - c / 2))
    at_rim = primitive.subs(R**2 - y**2, c**2 / 4).subs(y**2, R**2 - c**2 / 4)
    assert zero(2 * sp.pi * (at_rim - primitive.subs(y, 0)) - V_D)
    height = R - c / 2  # a second way: the half lens is a cap of the sphere
    assert zero(sp.pi * height**2 * (3 * R - height) / 3 - V_D)


def test_eq12_bowl_and_ring():
    assert zero(V_C + V_R - V_L)
    # The ring lies between the cylinder and the spheres, a washer R^2 - (R^2 - x^2) at each x.
    washers = 2 * sp.integrate(sp.pi * (R**2 - (R**2 - x**2)), (x, 0, c / 2))
    assert zero(V_R - washers) and zero(V_R - sp.pi * c**3 / 12)


def test_groove_volume():
    printed = 2 * sp.acos((R - g) / R) * (V_C + V_R)
    assert zero(printed.subs(g, 2 * R) - 2 * sp.pi * V_L)  # the whole cylinder, 2 pi times
    sector = printed / (2 * sp.pi)
    segment = R**2 * sp.acos((R - g) / R) - (R - g) * sp.sqrt(2 * R * g - g**2)
    # A second way, by quadrature; a third is measured in test_groove_along_a_wall.
    for depth in (sp.Rational(1, 10), sp.Rational(1, 2), sp.Rational(3, 2)):
        area = 2 * mp.quad(lambda v: mp.sqrt(1 - v * v), [1 - float(depth), 1])
        assert close(float(segment.subs({R: 1, g: depth})), float(area))
        assert abs(float(sector.subs({R: 1, c: 1, g: depth})) - area) > 0.2
    assert zero((sector - c * segment).subs(g, R))  # a half cylinder is sector and segment


# ---- appendix: the cone ---------------------------------------------------------------------

EQ13 = n1**2 + n2**2 - k * n3**2
EQ14 = n2 * (n1 - m1) - n1 * (n2 - m2)
EQ15 = k * n3 * (n1 - m1) + n1 * (n3 - m3)
EQ16 = (
    (k + 1) ** 2 * (m1**2 + m2**2) * n1**2
    - 2 * k * (k + 1) * m1 * (m1**2 + m2**2) * n1
    + k * m1**2 * (k * (m1**2 + m2**2) - m3**2)
)
ANGLES = (0.1, np.arctan(0.5), np.pi / 4, 1.4)


def test_eq13_cone():
    alpha, s = sp.symbols("alpha s", positive=True)
    ruling = {n1: s * sp.sin(alpha) * sp.cos(theta), n2: s * sp.sin(alpha) * sp.sin(theta),
              n3: -s * sp.cos(alpha)}  # fmt: skip
    assert zero(EQ13.subs(ruling).subs(k, sp.tan(alpha) ** 2))
    for angle in ANGLES:
        points = draw(16, 30, 3)
        expected = at(EQ13, (k, *n), (np.tan(angle) ** 2, *points.T))
        assert close(Cone(angle).implicit(points), expected, 1e2)
        distance, azimuth = 5 * draw(17, 2, 30)
        assert close(Cone(angle).implicit(Cone(angle).point(distance, azimuth)), 0, 1e3)


def test_eq13_k():
    # tan(alpha) = R/H = 3/4, alpha "the cone apex half angle": the circle R = 3, H = 4 is on it.
    alpha = sp.atan(sp.Rational(3, 4))
    half = sp.sin(alpha) / (1 + sp.cos(alpha))  # tan(alpha/2)
    printed, corrected = half**2, sp.tan(alpha) ** 2
    rim = {n1: 3, n2: 0, n3: -4}
    assert corrected == sp.Rational(9, 16) and zero(EQ13.subs(rim).subs(k, corrected))
    assert printed == sp.Rational(1, 9) and EQ13.subs(rim).subs(k, printed) == sp.Rational(65, 9)
    # A second way: the listing, and the library's cone, on which that circle is, near and far.
    for size in (1e-6, 1.0, 1e6):
        circle = size * np.array([3.0, 0, -4])
        assert abs(Cone(np.arctan(0.75)).implicit(circle)) < 1e-14 * size**2
        assert abs(Cone(np.arctan(0.75) / 2).implicit(circle)) > 7 * size**2  # alpha/2
    assert "K=(R/HH)^2" in PRINTED[120]  # the listing has it right
    assert close(Cone(np.arctan(0.75)).k, 9 / 16)


def test_eq14_eq15_normal():
    gradient = sp.Matrix([EQ13.diff(v) for v in n]) / 2
    cross = gradient.cross(sp.Matrix(n) - sp.Matrix(m))
    assert zero([cross[2] + EQ14, cross[1] + EQ15])
    for angle in ANGLES:
        points = draw(18, 30, 3)
        feet = np.moveaxis(Cone(angle).feet(points), -1, 0)
        for equation in (EQ13, EQ14, EQ15):
            values = (np.tan(angle) ** 2, *points.T[..., None], *feet)
            assert close(at(equation, (k, *m, *n), values), 0, 1e2)


def test_eq16_quadratic():
    printed = EQ16
    for first in (sp.resultant(EQ13, EQ15, n3), sp.resultant(EQ13, EQ14, n2)):
        second = (EQ14, n2) if first.has(n2) else (EQ15, n3)
        eliminated = sp.resultant(first, *second)
        assert zero(eliminated - n1**2 * printed)  # "after a common factor n1^2 has been removed"
    for angle in ANGLES:
        points = draw(19, 30, 3)
        values = np.tan(angle) ** 2, *points.T[..., None], Cone(angle).feet(points)[..., 0]
        assert close(at(printed, (k, *m, n1), values), 0, np.tan(angle) ** 4 * 10)


def test_eq16_back_substitution():
    printed = m2 * n1 / m1, m3 * n1 / (k * (n1 - m1) + n1)
    assert sp.solve(EQ14, n2) == [printed[0]] and zero(sp.solve(EQ15, n3)[0] - printed[1])
    for angle in ANGLES:
        points = draw(20, 30, 3)
        feet = Cone(angle).feet(points)
        values = np.tan(angle) ** 2, *points.T[..., None], feet[..., 0]
        for form, axis in zip(printed, (1, 2), strict=True):
            found = at(form, (k, *m, n1), values)
            assert close(found / (1 + np.abs(found)), feet[..., axis] / (1 + np.abs(found)), 1e3)


def test_eq16_m1_zero():
    # The plane m1 = 0, in which Q lies at f = 1/4: Eq. 16 leaves n1 = 0 and 0/0 for n2 and n3.
    assert zero(EQ16.subs(m1, 0) - (k + 1) ** 2 * m2**2 * n1**2)
    n3_printed = m3 * n1 / (k * (n1 - m1) + n1)
    assert zero(n3_printed.subs(m1, 0) - m3 / (k + 1))  # a limit that isn't the foot's n3
    foot = Cone(np.pi / 4).feet((0, 1, -2))[0]
    assert close(foot, [0, 1.5, -1.5]) and abs(foot[2] - -2 / (1 + 1)) > 0.4


def test_numeric_example():
    root2, root5 = sp.sqrt(2), sp.sqrt(5)
    centre = sp.Matrix([-root2, -3 * root2, -12])
    values = {k: sp.Rational(1, 4), **dict(zip(m, centre, strict=True))}
    feet = []
    for root in sp.solve(EQ16.subs(values), n1):
        other = [(m2 * n1 / m1).subs(values).subs(n1, root),
                 (m3 * n1 / (k * (n1 - m1) + n1)).subs(values).subs(n1, root)]  # fmt: skip
        feet.append(sp.Matrix([root, *other]).applyfunc(sp.radsimp))
    feet.sort(key=lambda foot: foot[0])
    radii = [sp.sqrt(sp.simplify((foot - centre).dot(foot - centre))) for foot in feet]
    assert zero([radii[0] - (12 / root5 - 4), radii[1] - (12 / root5 + 4)])
    digits = [(-1.800735989, -5.402207965, -11.38885438), (1.23505056, 3.705151691, -7.811145618)]
    for foot, shown in zip(feet, digits, strict=True):
        assert np.max(np.abs(np.array(foot.T, float)[0] - shown)) < 6e-9
    printed = [1.366563, 8.39997]
    assert abs(radii[0] - printed[0]) < 6e-7 and abs(radii[1] - printed[1]) > 0.9
    # Where 8.39997 comes from: n1 and n2 of this foot with n3 of the other.
    mixed = sp.Matrix([feet[1][0], feet[1][1], feet[0][2]]) - centre
    assert abs(mixed.norm() - printed[1]) < 6e-6
    # A second way, in floats: the library's feet and their distances.
    middle = np.array(centre.T, float)[0]
    found = Cone(np.arctan(0.5)).feet(middle)
    assert close(found, np.array([foot.T for foot in feet], float).reshape(2, 3), 10)
    away = np.linalg.norm(found - middle, axis=-1)
    assert close(away, [12 / 5**0.5 - 4, 12 / 5**0.5 + 4], 10) and abs(away[1] - printed[1]) > 0.9


def test_fig9_development():
    alpha, sigma = sp.symbols("alpha sigma", positive=True)
    S = sp.sqrt(H**2 + R**2)
    assert zero(sp.tan(sp.asin(R / S)) - R / H)  # tan(alpha) = R/H goes with S
    assert zero(sigma.subs(sigma, h * S / H) ** 2 - (h**2 + (h * R / H) ** 2))  # sigma = hS/H
    # Unrolled, theta sin(alpha) is the angle: lengths on the cone are kept.
    cone = sp.Matrix([sigma * sp.sin(alpha) * sp.cos(theta), sigma * sp.sin(alpha) * sp.sin(theta),
                      -sigma * sp.cos(alpha)])  # fmt: skip
    turn = theta * sp.sin(alpha)
    plane = sp.Matrix([sigma * sp.cos(turn), sigma * sp.sin(turn)])
    rates = [surface.jacobian([sigma, theta]) for surface in (cone, plane)]
    assert zero(rates[0].T * rates[0] - rates[1].T * rates[1])
    printed = 2 * sp.pi * R / S  # Phi, the whole development
    assert zero(turn.subs({theta: 2 * sp.pi, alpha: sp.asin(R / S)}) - printed)
    chord = ConeChord(3, 4, 1, 0.25)
    assert close(chord.ends, [5, 1.25])
    assert close(chord.cone.development(1, 1.5), [np.cos(1.5 * 0.6), np.sin(1.5 * 0.6)])


def development():
    """Return S, sigma, Phi_f and the point N_d(u), from P_d(S, 0) and Q_d."""
    S = sp.sqrt(H**2 + R**2)
    sigma, Phi_f = h * S / H, f * 2 * sp.pi * R / S
    P = sp.Matrix([S, 0])
    Q = sigma * sp.Matrix([sp.cos(Phi_f), sp.sin(Phi_f)])
    return S, sigma, Phi_f, P + u * (Q - P)


CHORDS = ((1, 1, 0.5, 0.25), (3, 4, 1, 0.3), (2, 1, 0.5, 0.1), (4, 3, 1, 0.4))


def test_eq17_geodesic():
    S, sigma, Phi_f, point = development()
    printed = sp.Matrix([S, 0]) + u * sp.Matrix([sigma * sp.cos(Phi_f) - S, sigma * sp.sin(Phi_f)])
    assert zero(printed - point)
    us = np.linspace(0, 1, 11)
    for values in CHORDS:
        expected = [at(c, (R, H, h, f, u), (*values, us)) for c in printed]
        assert close(ConeChord(*values).geodesic(us), np.transpose(expected), 10)


def test_eq17_labels():
    # Its left side begins with d_d1; the lines below use n_d1 for the same: tan(phi) = n_d2/n_d1.
    *_, point = development()
    chord = {R: 1, H: 1, h: sp.Rational(1, 2), f: sp.Rational(1, 4), u: sp.Rational(1, 2)}
    length = sp.sqrt(point.dot(point))
    polar = sp.Matrix([sp.cos(phi), sp.sin(phi)]) * length
    printed = 2 * sp.pi * R / sp.sqrt(H**2 + R**2)  # Phi, by its definition beside Fig. 9
    corrected = sp.atan2(point[1], point[0])  # phi
    off = [(polar.subs(phi, angle) - point).subs(chord).norm() for angle in (printed, corrected)]
    assert sp.N(off[0]) > 1 and abs(sp.N(off[1])) < 1e-12
    # A second way, in numbers: the library's point of the development has that angle.
    for values in CHORDS:
        chord = ConeChord(*values)
        for share in (0.1, 0.5, 0.9):
            here = chord.geodesic(share)
            angle, whole = chord.table(share)[1], 2 * np.pi * np.sin(chord.cone.half_angle)
            polar = np.hypot(*here) * np.array([np.cos(angle), np.sin(angle)])
            assert close(polar, here, 10) and abs(angle - whole) > 1


def test_tan_phi():
    S, sigma, Phi_f, point = development()
    printed = (sigma * sp.sin(Phi_f)) * u / (S + (sigma * sp.cos(Phi_f) - S) * u)
    assert zero(printed - point[1] / point[0])
    us = np.linspace(0, 1, 11)
    for values in CHORDS:
        expected = at(printed, (R, H, h, f, u), (*values, us))
        assert close(np.tan(ConeChord(*values).table(us)[:, 1]), expected, 1e2)


def test_eq18_theta():
    S, _, Phi_f, point = development()
    printed = S / R * sp.atan(point[1] / point[0])
    # u = 0 and 1 give 0 and Theta_f = 2 pi f, while Phi_f stays below a right angle.
    assert printed.subs(u, 0) == 0
    assert zero(S / R * Phi_f - 2 * sp.pi * f)
    assert zero(sp.tan(R / S * printed).subs(u, 1) - sp.tan(Phi_f))
    us = np.linspace(0, 1, 11)
    for values in CHORDS[:3]:
        expected = at(printed, (R, H, h, f, u), (*values, us))
        assert close(ConeChord(*values).azimuth(us), expected, 10)


def test_eq18_chain():
    # "theta = (Theta_f/Phi_f) phi = 2 pi/(2 pi R/S) = S/R": the last two lack phi.
    S, _, Phi_f, _ = development()
    ratio = 2 * sp.pi * f / Phi_f
    assert zero([ratio - S / R, 2 * sp.pi / (2 * sp.pi * R / S) - S / R])
    printed, corrected = S / R, S / R * phi
    assert zero(corrected - ratio * phi) and not zero(printed - ratio * phi)
    # A second way, in numbers: the azimuth and the development's point, which share no formula.
    for values in CHORDS:
        chord, share = ConeChord(*values), np.linspace(0, 1, 11)
        ratio = np.hypot(*values[:2]) / values[0]
        angle = np.arctan2(*chord.geodesic(share).T[::-1])
        assert close(chord.azimuth(share), ratio * angle)
        assert np.ptp(chord.azimuth(share)) > 0.6  # no constant
        assert close(chord.azimuth(1.0), 2 * np.pi * values[3])  # Theta_f


def test_eq18_branch():
    # R = 4, H = 3, f = 2/5: Phi_f = 115.2 degrees, past which tan^-1 changes its branch.
    S, _, Phi_f, point = development()
    wide = {R: 4, H: 3, h: 1, f: sp.Rational(2, 5), u: 1}
    printed = S / R * sp.atan(point[1] / point[0])
    corrected = S / R * sp.atan2(point[1], point[0])
    assert sp.N(Phi_f.subs(wide)) > sp.pi.evalf() / 2
    assert sp.N(printed.subs(wide)) < 0 and abs(sp.N(corrected.subs(wide) - 4 * sp.pi / 5)) < 1e-12
    assert close(ConeChord(4, 3, 1, 0.4).azimuth(1.0), 0.8 * np.pi)


def plane_meets_line(p, q, plane, sign):
    """Return the point of Eq. 19, with the sign of m23 M2 in its last row."""
    m01, m02, m03, m23, m31, m12 = (
        p[0] * q[1] - p[1] * q[0], p[0] * q[2] - p[2] * q[0], p[0] * q[3] - p[3] * q[0],
        p[2] * q[3] - p[3] * q[2], p[3] * q[1] - p[1] * q[3], p[1] * q[2] - p[2] * q[1],
    )  # fmt: skip
    M0, M1, M2, M3 = plane
    return sp.Matrix([
        m01 * M1 + m02 * M2 + m03 * M3,
        -m01 * M0 + m12 * M2 - m31 * M3,
        -m02 * M0 - m12 * M1 + m23 * M3,
        -m03 * M0 + m31 * M1 + sign * m23 * M2,
    ])  # fmt: skip


def test_eq19_row_m3():
    p, q, plane = (sp.Matrix(sp.symbols(f"{letter}0:4")) for letter in "pqM")
    printed = plane_meets_line(p, q, plane, +1)
    corrected = plane_meets_line(p, q, plane, -1)
    assert zero(corrected - (p * q.dot(plane) - q * p.dot(plane)))  # on the line
    assert zero(corrected.dot(plane))  # and in the plane
    assert zero((printed - corrected)[:3, 0]) and not zero(printed.dot(plane))
    # A second way: with the document's own P, Q and plane only the corrected row gives its M.
    appendix = [(1, R, 0, -H), (1, 0, h * R / H, -h), (0, -sp.sin(theta), sp.cos(theta), 0)]
    shown = -h * H * (sp.tan(theta) + 1) / (H * sp.tan(theta) + h)
    for sign, right in ((+1, False), (-1, True)):
        point = plane_meets_line(*map(sp.Matrix, appendix), sign)
        assert zero(point[3] / point[0] - shown) is right
    chord = ConeChord(1, 1, 0.5, 0.25)
    depth = at(shown, (R, H, h, theta), (1, 1, 0.5, 0.3))
    assert close(chord.chord_point(0.3)[2], depth)


def test_eq19_rows_m0_to_m2():
    p, q, plane = (sp.Matrix(sp.symbols(f"{letter}0:4")) for letter in "pqM")
    printed = plane_meets_line(p, q, plane, +1)[:3, 0]
    assert zero(printed - (p * q.dot(plane) - q * p.dot(plane))[:3, 0])


def test_M_formula():
    tan = sp.tan(theta)
    divisor = H * tan + h
    printed = sp.Matrix([h * R / divisor, h * R * tan / divisor, -h * H * (tan + 1) / divisor])
    # For any fraction f: t = H sin(theta)/(H sin(theta) + h sin(Theta_f - theta)) from P to Q.
    end = sp.symbols("Theta_f", positive=True)
    P = sp.Matrix([R, 0, -H])
    Q = sp.Matrix([h * R / H * sp.cos(end), h * R / H * sp.sin(end), -h])
    share = H * sp.sin(theta) / (H * sp.sin(theta) + h * sp.sin(end - theta))
    corrected = P + share * (Q - P)
    assert zero(corrected[0] * sp.sin(theta) - corrected[1] * sp.cos(theta))  # in the plane
    quarter, third = {end: sp.pi / 2}, {end: 2 * sp.pi / 3, theta: sp.pi / 3, R: 1, H: 1, h: 1}
    assert zero(corrected.subs(quarter) - printed)
    assert not zero(corrected.subs(third) - printed.subs(third))
    for values in CHORDS:
        azimuth = np.linspace(0, 2 * np.pi * values[3], 9)
        numbers = (*values[:3], 2 * np.pi * values[3], azimuth)
        expected = [at(c, (R, H, h, end, theta), numbers) for c in corrected]
        assert close(ConeChord(*values).chord_point(azimuth), np.transpose(expected), 10)


def test_planes_normal_to_surface():
    # A plane on the axis holds the cone's normals along its ruling, and isn't normal to PQ.
    plane = sp.Matrix([-sp.sin(theta), sp.cos(theta), 0])
    ruling = dict(zip(n, (sp.cos(theta), sp.sin(theta), -1 / sp.sqrt(k)), strict=True))
    gradient = sp.Matrix([EQ13.diff(v) for v in n]).subs(ruling)
    assert zero(gradient.dot(plane))
    chord = sp.Matrix([0, h * R / H, -h]) - sp.Matrix([R, 0, -H])
    assert zero(chord.cross(plane)[0] + (H - h) * sp.cos(theta))  # 0 at h = H only
    ends = ConeChord(1, 1, 0.5, 0.25).chord_point([0.0, np.pi / 2])
    assert abs(np.diff(ends[:, 2])[0]) > 0.4


def test_LN_closed_form():
    # The foot's distance from the apex from Eqs 16 and back-substitution: no root is needed.
    S, reach = sp.sqrt(H**2 + R**2), sp.symbols("rho", positive=True)
    LN = (reach * R + h * H) / S  # M at (reach, azimuth theta, -h)
    centre = {m1: reach * sp.cos(theta), m2: reach * sp.sin(theta), m3: -h, k: R**2 / H**2}
    first = LN * R / S * sp.cos(theta)
    assert zero(EQ16.subs(centre).subs(n1, first))
    back = (m3 * n1 / (k * (n1 - m1) + n1)).subs(centre).subs(n1, first)
    assert zero(back + LN * H / S)
    for values in CHORDS:
        chord = ConeChord(*values)
        azimuth = np.linspace(0, chord.turn, 9)
        point = chord.chord_point(azimuth)
        foot = chord.cone.feet(point)[:, 0]
        found = at(LN, (reach, R, H, h), (np.hypot(*point.T[:2]), *values[:2], -point[:, 2]))
        assert close(np.linalg.norm(foot, axis=-1), found, 10)
        assert close(chord.tangent_sphere(azimuth), found, 10)


# ---- appendix: listing and table ------------------------------------------------------------

TABLE = np.array([
    [0.0, 0.0, 1.4142, 1.4142, 0.0],
    [0.1, 2.7813, 1.2875, 1.3057, 0.0183],
    [0.2, 6.0572, 1.1748, 1.2009, 0.0261],
    [0.3, 9.9442, 1.0747, 1.1007, 0.0259],
    [0.4, 14.5832, 0.9863, 1.0065, 0.0204],
    [0.5, 20.1338, 0.9090, 0.9203, 0.0113],
    [0.6, 26.7542, 0.8427, 0.8445, 0.0018],
    [0.7, 34.5525, 0.7878, 0.7820, -0.0057],
    [0.8, 43.5058, 0.7454, 0.7363, -0.0091],
    [0.9, 53.3672, 0.7174, 0.7106, -0.0069],
    [1.0, 63.6396, 0.7071, 0.7071, 0.0],
])  # fmt: skip
MISPRINTS = {(4, 4): 0.0202, (6, 1): 26.7541, (7, 4): -0.0058}
EXAMPLE_CONE = (1, 1, 0.5, 0.25)
ALL = tuple(REPAIRS)


def exact_table():
    """Return the table at 30 digits from Eqs 16 to 19: u, phi in degrees, LN, NN, NN - LN."""
    S, _, _, point = development()
    angle = sp.atan2(point[1], point[0])
    turn = S / R * angle
    divisor = H * sp.sin(turn) + h * sp.cos(turn)  # f = 1/4, without the tangent's pole
    centre = [h * R * sp.cos(turn) / divisor, h * R * sp.sin(turn) / divisor,
              -h * H * (sp.sin(turn) + sp.cos(turn)) / divisor]  # fmt: skip
    LN = (sp.sqrt(centre[0] ** 2 + centre[1] ** 2) * R - centre[2] * H) / S
    NN = sp.sqrt(point.dot(point))
    form = sp.lambdify((u, R, H, h, f), [u, angle * 180 / sp.pi, LN, NN, NN - LN], "mpmath")
    with mp.workdps(30):
        half, quarter = mp.mpf(1) / 2, mp.mpf(1) / 4
        rows = [form(mp.mpf(i) / 10, mp.mpf(1), mp.mpf(1), half, quarter) for i in range(11)]
    return np.array(rows, dtype=float)


def differing(rows):
    """Return the cells whose four digits aren't the printed ones."""
    return {tuple(cell) for cell in np.argwhere(np.abs(np.round(rows, 4) - TABLE) > 1e-9).tolist()}


def test_table():
    truth = exact_table()
    assert TABLE.size == 55 and differing(truth) == set(MISPRINTS)
    for cell, digits in MISPRINTS.items():
        assert round(truth[cell], 4) == digits
    # A second way, in floats: the library's table, by feet and development.
    table = ConeChord(*EXAMPLE_CONE).table(np.arange(11) / 10)
    table[:, 1] = np.degrees(table[:, 1])
    assert close(table, truth, 100)


@pytest.mark.parametrize("row", [4, 7])
def test_table_difference_misprint(row):
    _, _, LN, NN, printed = TABLE[row]
    corrected = MISPRINTS[row, 4]
    assert round(NN - LN, 4) == corrected != printed  # against the printed row's own columns
    # A second way: to thirty digits.
    assert round(exact_table()[row, 4], 4) == corrected


def test_table_angle_misprint():
    *_, point = development()
    chord = {R: 1, H: 1, h: sp.Rational(1, 2), f: sp.Rational(1, 4), u: sp.Rational(3, 5)}
    angle = sp.N(sp.atan2(point[1], point[0]).subs(chord) * 180 / sp.pi, 30)
    printed, corrected = sp.Rational(267542, 10000), sp.Rational(267541, 10000)
    unit = sp.Rational(1, 10000)
    assert abs(angle - corrected) < unit / 2 < abs(angle - printed)
    # A second way, in floats: the library's table.
    table = ConeChord(*EXAMPLE_CONE).table(0.6)
    assert round(np.degrees(table[1]), 4) == float(corrected)


def test_table_columns():
    # "The radii ... to the geodesic line and to the approximating data points, respectively."
    truth = exact_table()
    geodesic, approximation = truth[:, 3], truth[:, 2]
    assert np.max(np.abs(TABLE[:, 2] - geodesic)) > 0.02  # as the text orders them
    assert np.max(np.abs(TABLE[:, [2, 3]].T - [approximation, geodesic])) < 6e-5
    # A second way: the order in which the listing prints them; its NN is the development's.
    assert PRINTED[240].endswith("LN, NN, NN-LN")
    assert "NN=SQR(ND1^2+ND2^2)" in PRINTED[160]
    run_rows = np.array(run(*EXAMPLE_CONE, 10, repaired=ALL))
    radii = np.linalg.norm(ConeChord(*EXAMPLE_CONE).geodesic(np.arange(11) / 10), axis=-1)
    assert close(run_rows[:, 3], radii, 1e4) and np.max(np.abs(run_rows[:, 2] - radii)) > 0.02


def listing_error(values, repaired):
    """Return how far the listing, run with some lines repaired, is off the library's table."""
    rows = np.array(run(*values, repaired=repaired))
    table = ConeChord(*values[:4]).table(np.arange(len(rows)) / values[4])
    table[:, 1] = np.degrees(table[:, 1])
    return np.max(np.abs(rows - table))


def test_listing_as_printed():
    with pytest.raises(ZeroDivisionError):  # at u = 0, in line 200
        run(*EXAMPLE_CONE, 10)
    rows = np.array(run(*EXAMPLE_CONE, 10, repaired=ALL))
    assert differing(rows) == set(MISPRINTS)
    # A second way, on other cones: the library's table.
    for values in ((2, 1, 0.5, 0.3, 10), (4, 3, 1, 0.4, 5), (1, 2, 0.5, 0.1, 20)):
        assert listing_error(values, ALL) < 1e-8


def test_listing_180():
    # The roots of A n^2 + B n + C are divided by 2A, not by A A.
    printed, corrected = "A2=A*A", "A2=2*A"
    assert printed in PRINTED[180] and corrected in REPAIRS[180]
    assert differing(np.array(run(*EXAMPLE_CONE, 10, repaired=[180]))) == set(MISPRINTS)
    # A second way, on another cone: P lies at S from the apex.
    others = [line for line in ALL if line != 180]
    start = run(1, 2, 0.5, 0.25, 10, repaired=others)[0]
    assert abs(start[2] - 5**0.5) > 0.05  # S = sqrt(5)
    assert abs(run(1, 2, 0.5, 0.25, 10, repaired=ALL)[0][2] - 5**0.5) < 1e-9


def test_listing_120():
    # PH is 2 pi R/S; without R it is right on the table's cone alone.
    others = [line for line in ALL if line != 120]
    assert listing_error((*EXAMPLE_CONE, 10), others) < 1e-8
    assert listing_error((2, 1, 0.5, 0.25, 10), others) > 1
    assert listing_error((2, 1, 0.5, 0.25, 10), ALL) < 1e-8
    # A second way: the whole development, f = 1, has the base circle 2 pi R for its arc.
    for repaired, whole in ((others, False), (ALL, True)):
        *_, (_, degrees, *_) = run(0.5, 3, 1, 0.25, 10, repaired=repaired)
        arc = 4 * np.radians(degrees) * np.hypot(0.5, 3)
        assert bool(abs(arc - 2 * np.pi * 0.5) < 1e-8) is whole


def test_listing_100():
    with pytest.raises(NameError):
        run(*EXAMPLE_CONE, 10, repaired=[180], fold_case=False)
    folded = run(*EXAMPLE_CONE, 10, repaired=[180])
    assert run(*EXAMPLE_CONE, 10, repaired=[100, 180], fold_case=False) == folded


def test_listing_130():
    others = [line for line in ALL if line != 130]
    assert len(run(*EXAMPLE_CONE, 5, repaired=others)) == 11  # runs past u = 1, to u = 2
    assert run(*EXAMPLE_CONE, 5, repaired=others)[-1][0] == 2
    assert [row[0] for row in run(*EXAMPLE_CONE, 5, repaired=ALL)] == [0, 0.2, 0.4, 0.6, 0.8, 1]


def test_listing_150_160():
    # TTH = TAN(TH) puts Q a quarter turn from P; ATN has the wrong branch past 90 degrees.
    others = [line for line in ALL if line not in (150, 160)]
    for values, off in (((*EXAMPLE_CONE, 10), False), ((1, 1, 0.5, 0.3, 10), True),
                        ((4, 3, 1, 0.4, 10), True)):  # fmt: skip
        assert bool(listing_error(values, others) > 0.01) is off
        assert listing_error(values, ALL) < 1e-8


def test_listing_230():
    # On the cone the nearer of the two feet is always the one on M's side of the axis.
    reach, alpha = sp.symbols("reach alpha", positive=True)
    side = [(s * reach * sp.cos(alpha) - h * sp.sin(alpha)) ** 2 for s in (1, -1)]
    assert zero(side[1] - side[0] - 4 * reach * h * sp.sin(alpha) * sp.cos(alpha))
    for values in CHORDS:
        chord = ConeChord(*values)
        centres = chord.chord_point(np.linspace(0, chord.turn, 50))
        away = np.linalg.norm(chord.cone.feet(centres) - centres[:, None], axis=-1)
        assert np.all(away[:, 0] < away[:, 1])


def test_good_approximation():
    # Length along the cone of both paths, each by the definition.
    P, Q = sp.Matrix([1, 0, -1]), sp.Matrix([0, sp.Rational(1, 2), -sp.Rational(1, 2)])
    centre = P + t * (Q - P)
    distance = (sp.sqrt(centre[0] ** 2 + centre[1] ** 2) - centre[2]) / sp.sqrt(2)
    unrolled = sp.atan2(centre[1], centre[0]) / sp.sqrt(2)
    speed = sp.sqrt(distance.diff(t) ** 2 + (distance * unrolled.diff(t)) ** 2)
    geodesic = sp.sqrt(sp.Rational(5, 2) - 2 * sp.cos(sp.pi / (2 * sp.sqrt(2))))
    with mp.workdps(20):
        path = mp.quad(sp.lambdify(t, speed, "mpmath"), [0, 0.25, 0.5, 0.75, 1])
        assert abs(geodesic.evalf(20) - mp.mpf("1.26963314")) < 5e-9
        assert abs(path - mp.mpf("1.27092977")) < 5e-9
        assert 0.00102 < path / geodesic.evalf(20) - 1 < 0.00103
    chord = ConeChord(*EXAMPLE_CONE)
    assert close([chord.geodesic_length, chord.path_length], [float(geodesic), float(path)])
    # The table's last column, at equal azimuth, is more than the distance across.
    us = np.linspace(0, 1, 201)
    across, last = chord.deviation(us), chord.table(us)[:, 4]
    assert np.max(np.abs(across)) < 0.9 * np.max(np.abs(last))


def test_equal_steps_along_chord():
    # "Obviously will not produce equally spaced points N": nor does the path's own rule exactly.
    chord, step = ConeChord(*EXAMPLE_CONE), np.linspace(0, 1, 11)
    P, Q = chord.chord_point([0.0, chord.turn])
    feet = chord.cone.feet(P + step[:, None] * (Q - P))[:, 0]
    plane = chord.cone.development(
        np.linalg.norm(feet, axis=-1), np.arctan2(feet[:, 1], feet[:, 0])
    )
    plain = np.linalg.norm(np.diff(plane, axis=0), axis=-1)
    by_azimuth = np.linalg.norm(np.diff(chord.path(step), axis=0), axis=-1)
    spread = plain.max() / plain.min(), by_azimuth.max() / by_azimuth.min()
    assert spread[0] > 1.2 and spread[1] < spread[0]
