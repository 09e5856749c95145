"""Tunnelling robot, section 3.2: a line meets the torus, Eqs 4 and 5.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import itertools

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from tests.shapes import PROOFS
from tests.symbols_tunneller import TORUS, R, at, draw, r, t, x, y, z, zero
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

READS = ["report/ledger/*"]

a = a1, a2, a3 = sp.symbols("a1:4")
b = b1, b2, b3 = sp.symbols("b1:4")


def line_polynomial():
    """Return Eq. 4 with q put in, as a polynomial in t."""
    q = [ai + (bi - ai) * t for ai, bi in zip(a, b, strict=True)]
    return sp.Poly(TORUS.subs(dict(zip((x, y, z), q, strict=True))), t)


def test_eq04_line(judge):
    q = sp.symbols("q1:4")
    printed = (q[0] ** 2 + q[1] ** 2 + q[2] ** 2 - r**2 - R**2) ** 2 - 4 * r**2 * (R**2 - q[1] ** 2)
    point = dict(zip(q, (ai + (bi - ai) * t for ai, bi in zip(a, b, strict=True)), strict=True))
    judge("eq04", zero(printed.subs(point) - line_polynomial().as_expr()))
    assert zero(printed.subs(dict(zip(q, (x, y, z), strict=True))) - TORUS)
    assert line_polynomial().degree() == 4


def test_four_points(judge):
    # "A line intersects a torus on four points": counted with complex ones.
    shape = {r: 1, R: 2}
    lines = {4: ((-10, 0, 0), (-9, 0, 0)), 2: ((-9, 0, 2), (-8, 0, 2)), 0: ((9, 5, 0), (8, 5, 0))}
    real_points = {}
    for count, (start, stop) in lines.items():
        values = shape | dict(zip(a + b, start + stop, strict=True))
        quartic = sp.Poly(line_polynomial().as_expr().subs(values), t)
        real_points[count] = quartic.count_roots()
        assert quartic.degree() == 4 and real_points[count] == count
    judge("four-points", cases={"the x axis": bool(real_points[4] == 4),
                                "a line 2 above it": bool(real_points[2] == 4),
                                "a line beside the torus": bool(real_points[0] == 4)})  # fmt: skip


def test_no_straight_lines(judge):
    leading = line_polynomial().coeff_monomial(t**4)
    along = sp.symbols("along1:4", real=True)  # b - a
    ahead = dict(zip(b, (ai + d for ai, d in zip(a, along, strict=True)), strict=True))
    length2 = sum(d**2 for d in along)  # above zero for a != b
    judge("no-straight-lines", zero(leading.subs(ahead) - length2**2))


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


def test_eq05_T4_T3_T1(judge):
    printed, _, _ = printed_eq05()
    for name, power in {"eq05-T4": 4, "eq05-T3": 3, "eq05-T1": 1}.items():
        truth = line_polynomial().coeff_monomial(t**power)
        judge(name, zero(printed[power] - truth))


def test_eq05_T2(judge):
    printed, _, t3 = printed_eq05()
    corrected = printed[2] + 2 * t3**2  # 4 t3^2 for 2 t3^2
    truth = line_polynomial().coeff_monomial(t**2)
    judge("eq05-T2", zero(printed[2] - truth), right=zero(corrected - truth))
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


def test_eq05_T0(judge):
    printed, t2, _ = printed_eq05()
    corrected = t2**2 - 4 * r**2 * (R**2 - a2**2)  # t2^2 for t2
    truth = line_polynomial().coeff_monomial(1)
    judge("eq05-T0", zero(printed[0] - truth), right=zero(corrected - truth))
    # A second way, from roots that are known.
    assert by_known_roots(corrected, printed[4]) == 7 * 9 * 11 * 13
    assert by_known_roots(printed[0], printed[4]) == 79


def test_eq05_quartic(judge):
    printed, t2, t3 = printed_eq05()
    corrected = printed | {2: printed[2] + 2 * t3**2, 0: printed[0] - t2 + t2**2}
    # The x axis meets the torus r = 1, R = 2 in -3, -1, 1, 3.
    line = {r: 1, R: 2, **dict(zip(a + b, (-10, 0, 0, -9, 0, 0), strict=True))}

    def meets_the_torus(form):
        quartic = sp.Poly(sum(c * t**p for p, c in form.items()).subs(line), t)
        return quartic.real_roots() == [7, 9, 11, 13]

    judge("eq05", meets_the_torus(printed), right=meets_the_torus(corrected))
    # A second way, in numbers: the library's roots, by no polynomial.
    for torus in PROOFS:
        ends = torus.R * draw(6, 6, 40)
        met = torus.meet_line(ends[:3].T, ends[3:].T)
        values, size = (torus.r, torus.R, *ends), ((torus.r + torus.R) * (1 + np.abs(met))) ** 4
        for form, right in ((corrected, True), (printed, False)):
            left = sum(at(form[p], (r, R, *a, *b), values)[:, None] * met**p for p in range(5))
            worst = np.nanmax(np.abs(left) / size)
            assert worst < 1e-11 if right else worst > 0.1


def test_greatest_x_root(judge):
    # At each height y the working sheet's circle lies outside the other's: bodies one in another,
    # so that a line's first and last points are on the working sheet.
    half = sp.symbols("half", positive=True)  # sqrt(R^2 - y^2)
    outer, inner = r + half, half - r
    assert zero(outer**2 - inner**2 - 4 * r * half)
    on_working_sheet = []
    for torus in PROOFS[:3]:
        ends = draw(7, 2, 400, 3) * torus.R
        ts = torus.meet_line(*ends)
        hit = ~np.isnan(ts[:, 1])
        ts, start, along = ts[hit], ends[0][hit], (ends[1] - ends[0])[hit]
        points = start[:, None] + ts[..., None] * along[:, None]
        greatest = np.nanargmax(points[..., 0], axis=1)
        chosen = points[np.arange(len(points)), greatest]
        back = torus.point(*torus.angles(chosen))
        assert len(chosen) > 100
        on_working_sheet.append(np.max(np.abs(back - chosen)) < 1e-9 * torus.R)
    judge("greatest-x", len(on_working_sheet) == 3 and all(on_working_sheet))


def test_destination_on_a_ruling(judge):
    # The ball about Q reaches beyond the wall by its radius less Q's distance from the wall; that
    # should be the depth of cut, all round.
    machine, egg = REFERENCE_MACHINE, Egg(0.5)
    inset = machine.cutter_radius - machine.depth
    circuit = cutting_circuit(machine, egg)
    out = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    aim = np.stack([np.cos(out), np.sin(out)], axis=-1)

    def reach(inside):
        """Return how far beyond the wall the ball reaches about ends of rulings so far inside."""
        far = np.array([brentq(lambda s, d=d: egg.depth(*(s * d)) - inside, 0, 2) for d in aim])
        y, z = (far[:, None] * aim).T
        start = np.stack([0 * y, y, z - machine.height], axis=-1)
        along = np.array([1.0, 0.0, 0.0])
        ts = machine.torus.meet_line(start, start + along)
        Q = start + np.nanmax(ts, axis=-1)[:, None] * along
        assert np.isfinite(Q).all()
        _, y, z = circuit.in_tunnel(Q).T
        return machine.cutter_radius - egg.depth(y, z)

    printed, offset_reach = reach(0.0), reach(inset)
    judge("ruling-of-wall", np.allclose(printed, machine.depth, atol=1e-9),
          right=np.allclose(offset_reach, machine.depth, atol=1e-9))  # fmt: skip
    # A second way, by hand at crown and floor, whose arcs have their centres at the heights 0 and
    # -3a/2 and radii a and a/2; Q's x is the root of a square, and the ball's top is right above.
    a, B, g = sp.Rational(1, 2), sp.Rational(1, 5), sp.Rational(1, 50)
    ring, tube, z_c = sp.Rational(2, 25), sp.Rational(4, 5), sp.Rational(str(machine.height))
    for centre, radius, side in ((0, a, 1), (-3 * a / 2, a / 2, -1)):
        wall = centre + side * radius
        for height, beyond in ((wall, B), (wall - side * (B - g), g)):
            x2 = (ring + tube) ** 2 - (height - z_c) ** 2
            place = {x: sp.sqrt(x2), y: 0, z: height - z_c}
            assert x2 > 0 and zero(TORUS.subs({r: ring, R: tube, **place}))
            assert side * (height + side * B - wall) == beyond
