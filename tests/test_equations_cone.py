"""Tunnelling robot, appendix: the cone, its normals and development, Eqs 13 to 19, Fig. 9.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import numpy as np
import sympy as sp

from tests import symbols_tunneller as shared
from tests.basic_listing import PRINTED
from tests.symbols_tunneller import EQ13, H, R, at, close, f, h, k, m, n, theta, u, zero
from tunneller_lib.paths import ConeChord
from tunneller_lib.surfaces import Cone

READS = ["report/ledger/*", "report/listings.toml"]

m1, m2, m3 = m
n1, n2, n3 = n

EQ14 = n2 * (n1 - m1) - n1 * (n2 - m2)
EQ15 = k * n3 * (n1 - m1) + n1 * (n3 - m3)
BACK = m2 * n1 / m1, m3 * n1 / (k * (n1 - m1) + n1)  # n2 and n3, as printed after Eq. 16


def test_eq13_cone(judge):
    # At a distance rho from the axis it is zero at the cone's height, and only there.
    rho, height, tan = sp.symbols("rho height tan", positive=True)
    anywhere = {n1: rho * sp.cos(theta), n2: rho * sp.sin(theta), n3: -height, k: tan**2}
    judge("eq13", zero(EQ13.subs(anywhere) - (rho - height * tan) * (rho + height * tan)))


def test_eq13_k(judge):
    # tan(alpha) = R/H = 3/4, alpha "the cone apex half angle": the circle R = 3, H = 4 is on it.
    alpha = sp.atan(sp.Rational(3, 4))
    half = sp.sin(alpha) / (1 + sp.cos(alpha))  # tan(alpha/2)
    printed, corrected = half**2, sp.tan(alpha) ** 2
    rim = EQ13.subs({n1: 3, n2: 0, n3: -4})
    judge("eq13-k", zero(rim.subs(k, printed)), right=zero(rim.subs(k, corrected)))
    # A second way: the listing, and the library's cone, on which that circle is.
    assert abs(Cone(np.arctan(0.75)).implicit((3, 0, -4))) < 1e-14
    assert abs(Cone(np.arctan(0.75) / 2).implicit((3, 0, -4))) > 7  # alpha/2
    assert "K=(R/HH)^2" in PRINTED[120]  # the listing has it right


def test_eq14_eq15_normal(judge):
    gradient = sp.Matrix([EQ13.diff(v) for v in n]) / 2
    cross = gradient.cross(sp.Matrix(n) - sp.Matrix(m))
    judge("eq14", zero(cross[2] + EQ14))
    judge("eq15", zero(cross[1] + EQ15))


def test_eq16_quadratic(judge):
    printed = shared.EQ16
    orders = []
    for first in (sp.resultant(EQ13, EQ15, n3), sp.resultant(EQ13, EQ14, n2)):
        second = (EQ14, n2) if first.has(n2) else (EQ15, n3)
        eliminated = sp.resultant(first, *second)
        # "after a common factor n1^2 has been removed"
        orders.append(zero(eliminated - n1**2 * printed))
    judge("eq16", all(orders) and bool(sp.degree(printed, n1) == 2))


def test_eq16_back_substitution(judge):
    [second], [third] = sp.solve(EQ14, n2), sp.solve(EQ15, n3)
    judge("eq16-back-substitution", zero([second - BACK[0], third - BACK[1]]))


def test_eq16_m1_zero(judge):
    # The plane m1 = 0, in which Q lies at f = 1/4: Eq. 16 leaves n1 = 0 and 0/0 for n2 and n3.
    def serves(*middle):
        """Tell whether Eq. 16 and what follows it lead to both feet of M; k = 1."""
        quadratic = sp.Poly(shared.EQ16.subs({k: 1, **dict(zip(m, middle, strict=True))}), n1)
        first = np.roots(np.array(quadratic.all_coeffs(), float))
        with np.errstate(invalid="ignore"):
            found = [first, *(at(form, (k, *m, n1), (1, *middle, first)) for form in BACK)]
        feet = Cone(np.pi / 4).feet(middle)
        return close(np.sort(found), np.sort(feet.T), 10)  # coordinate by coordinate

    judge("eq16-m1-zero", cases={"M beside the plane m1 = 0": serves(1, 2, -3),
                                 "M in the plane m1 = 0": serves(0, 1, -2)})  # fmt: skip
    assert zero(shared.EQ16.subs(m1, 0) - (k + 1) ** 2 * m2**2 * n1**2)
    assert zero(BACK[1].subs(m1, 0) - m3 / (k + 1))  # a limit that isn't the foot's n3


def right_to(decimals, shown, truth):
    """Tell which numbers are right to so many decimals: to half a unit of the last."""
    return np.abs(np.subtract(shown, truth)) < 0.5 * 10.0 ** -np.asarray(decimals)


def test_numeric_example(judge):
    centre = np.array([-(2**0.5), -3 * 2**0.5, -12])
    truth = Cone(np.arctan(0.5)).feet(centre)
    # Four numbers have nine decimals, n3 of the first foot and n1 of the second have eight.
    digits = [(-1.800735989, -5.402207965, -11.38885438), (1.23505056, 3.705151691, -7.811145618)]
    as_printed = right_to([(9, 9, 8), (8, 9, 9)], digits, truth)
    judge("example-N", cases={"to eight decimals": np.all(right_to(8, digits, truth)),
                              "to the digits printed": np.all(as_printed)})  # fmt: skip
    assert as_printed.tolist() == [[True, False, True]] * 2  # n2 of either foot is off
    printed, corrected = [1.366563, 8.39997], [12 / 5**0.5 - 4, 12 / 5**0.5 + 4]
    away = np.linalg.norm(truth - centre, axis=-1)
    assert close(away, corrected, 10)
    judge("example-radius-1", bool(right_to(6, printed[0], away[0])))
    judge("example-radius-2", bool(right_to(5, printed[1], away[1])),
          right=bool(right_to(5, corrected[1], away[1])))  # fmt: skip
    # Where 8.39997 comes from: n1 and n2 of this foot with n3 of the other.
    mixed = [*truth[1, :2], truth[0, 2]] - centre
    assert abs(np.linalg.norm(mixed) - printed[1]) < 6e-6
    # A second way: the roots of Eq. 16, exactly, and what follows it.
    values = {k: sp.Rational(1, 4), m1: -sp.sqrt(2), m2: -3 * sp.sqrt(2), m3: -12}
    first = np.array(sorted(map(float, sp.solve(shared.EQ16.subs(values), n1))))
    third = -12 * first / (0.25 * (first - centre[0]) + first)
    feet = np.transpose([first, 3 * first, third])
    assert close(feet, truth, 10) and abs(np.linalg.norm(feet[1] - centre) - printed[1]) > 0.9


def test_fig9_development(judge):
    alpha, sigma = sp.symbols("alpha sigma", positive=True)
    S = sp.sqrt(H**2 + R**2)
    P = sp.Matrix([R, 0, -H])
    Q = sp.Matrix([h * R / H, 0, -h])  # at P's azimuth, for the drawing
    half_angle = sp.acos(P.dot(sp.Matrix([0, 0, -1])) / P.norm())
    three = zero([sp.tan(half_angle) - R / H, P.norm() - S, Q.norm() - h * S / H])
    # Unrolled, theta sin(alpha) is the angle: lengths on the cone are kept.
    cone = sp.Matrix([sigma * sp.sin(alpha) * sp.cos(theta), sigma * sp.sin(alpha) * sp.sin(theta),
                      -sigma * sp.cos(alpha)])  # fmt: skip
    turn = theta * sp.sin(alpha)
    plane = sp.Matrix([sigma * sp.cos(turn), sigma * sp.sin(turn)])
    rates = [surface.jacobian([sigma, theta]) for surface in (cone, plane)]
    assert zero(rates[0].T * rates[0] - rates[1].T * rates[1])
    printed = 2 * sp.pi * R / S  # Phi, the whole development
    judge("fig9", three and zero(turn.subs({theta: 2 * sp.pi, alpha: half_angle}) - printed))


def test_eq17_geodesic(judge):
    S, sigma, Phi_f, point = shared.development()
    printed = sp.Matrix([S, 0]) + u * sp.Matrix([sigma * sp.cos(Phi_f) - S, sigma * sp.sin(Phi_f)])
    assert zero(printed - point)
    start, stop = printed.subs(u, 0), printed.subs(u, 1)
    in_polar = zero([start.norm() - S, start[1], stop.norm() - sigma,
                     stop[1] * sp.cos(Phi_f) - stop[0] * sp.sin(Phi_f)])  # fmt: skip
    judge("eq17-vector", in_polar and zero(printed.diff(u, 2)))


def test_eq17_labels(judge):
    # Its left side begins with d_d1; the lines below use n_d1 for the same: tan(phi) = n_d2/n_d1.
    *_, point = shared.development()
    chord = {R: 1, H: 1, h: sp.Rational(1, 2), f: sp.Rational(1, 4), u: sp.Rational(1, 2)}
    length = sp.sqrt(point.dot(point))

    def off(angle):
        polar = sp.Matrix([sp.cos(angle), sp.sin(angle)]) * length
        return float(sp.N((polar - point).subs(chord).norm()))

    printed = 2 * sp.pi * R / sp.sqrt(H**2 + R**2)  # Phi, by its definition beside Fig. 9
    corrected = sp.atan2(point[1], point[0])  # phi
    judge("eq17", off(printed) < 1e-12, right=off(corrected) < 1e-12)
    assert off(printed) > 1
    # A second way, in numbers: the library's point of the development has that angle.
    for chord in (ConeChord(*values) for values in shared.CHORDS):
        here, angle = chord.geodesic(0.5), chord.table(0.5)[1]
        polar = np.hypot(*here) * np.array([np.cos(angle), np.sin(angle)])
        assert close(polar, here, 10)
        assert abs(angle - 2 * np.pi * np.sin(chord.cone.half_angle)) > 1


def test_tan_phi(judge):
    S, sigma, Phi_f, point = shared.development()
    printed = (sigma * sp.sin(Phi_f)) * u / (S + (sigma * sp.cos(Phi_f) - S) * u)
    judge("tan-phi", zero(printed - point[1] / point[0]))


def test_eq18_theta(judge):
    S, _, Phi_f, point = shared.development()
    printed = S / R * sp.atan(point[1] / point[0])
    # u = 0 and 1 give 0 and Theta_f = 2 pi f, while Phi_f stays below a right angle.
    ends = zero([printed.subs(u, 0), S / R * Phi_f - 2 * sp.pi * f])
    assert zero(sp.tan(R / S * printed).subs(u, 1) - sp.tan(Phi_f))
    # Between them the azimuth, rolled out by theta sin(alpha), points at N_d.
    rolled_out = sp.tan(printed * sp.sin(sp.atan(R / H)))
    judge("eq18", ends and zero(rolled_out - point[1] / point[0]))


def test_eq18_chain(judge):
    # "theta = (Theta_f/Phi_f) phi = 2 pi/(2 pi R/S) = S/R": the last two lack phi.
    S, _, Phi_f, _ = shared.development()
    phi = shared.phi
    first = 2 * sp.pi * f / Phi_f * phi
    ratio = 2 * sp.pi / (2 * sp.pi * R / S)

    judge("eq18-chain", zero([first - ratio, first - S / R]),
          right=zero([first - ratio * phi, first - S / R * phi]))  # fmt: skip
    # A second way, without the development: a tape laid about the cone along the circle of its
    # rim, from one azimuth to another, is S phi long by the definition of phi.
    along = np.linspace(0, 2.5, 200_001)
    for radius, height, *_ in shared.CHORDS:
        slant = np.hypot(radius, height)
        tape = radius * np.array([np.cos(along), np.sin(along)])
        rolled = np.sum(np.hypot(*np.diff(tape))) / slant  # phi
        assert abs(slant / radius * rolled - 2.5) < 1e-9 and abs(slant / radius - 2.5) > 0.1


def test_eq18_branch(judge):
    # R = 4, H = 3, f = 2/5: Phi_f = 115.2 degrees, past which tan^-1 changes its branch.
    S, _, Phi_f, point = shared.development()
    wide = {R: 4, H: 3, h: 1, f: sp.Rational(2, 5), u: 1}
    narrow = {R: 1, H: 1, h: sp.Rational(1, 2), f: sp.Rational(1, 4), u: 1}
    printed = S / R * sp.atan(point[1] / point[0])

    def ends_at_q(form, cone):
        return bool(abs(sp.N(form.subs(cone) - 2 * sp.pi * cone[f])) < 1e-12)

    judge("eq18-branch", cases={"Phi_f below a right angle": ends_at_q(printed, narrow),
                                "Phi_f past a right angle": ends_at_q(printed, wide)})  # fmt: skip
    assert sp.N(Phi_f.subs(narrow)) < sp.pi.evalf() / 2 < sp.N(Phi_f.subs(wide))


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


# Two points and a plane, homogeneous, and the point of the line pq in that plane.
p, q, plane = (sp.Matrix(sp.symbols(f"{letter}0:4")) for letter in "pqM")
ON_BOTH = p * q.dot(plane) - q * p.dot(plane)


def test_eq19_row_m3(judge):
    printed = plane_meets_line(p, q, plane, +1)
    corrected = plane_meets_line(p, q, plane, -1)

    judge("eq19", zero(printed.dot(plane)), right=zero(corrected.dot(plane)))
    assert zero(corrected - ON_BOTH)  # on the line, too
    assert zero((printed - corrected)[:3, 0])
    # A second way: with the document's own P, Q and plane only the corrected row gives its M.
    appendix = [(1, R, 0, -H), (1, 0, h * R / H, -h), (0, -sp.sin(theta), sp.cos(theta), 0)]
    own = dict(zip((*p, *q, *plane), sum(appendix, ()), strict=True))
    tan = sp.sin(theta) / sp.cos(theta)
    shown = -h * H * (tan + 1) / (H * tan + h)
    for form, right in ((printed, False), (corrected, True)):
        assert zero((form[3] / form[0]).subs(own) - shown) is right


def test_eq19_rows_m0_to_m2(judge):
    judge("eq19-rows", zero((plane_meets_line(p, q, plane, +1) - ON_BOTH)[:3, 0]))


def test_M_formula(judge):
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
    quarter = {end: sp.pi / 2}
    third = {end: 2 * sp.pi / 3, theta: sp.pi / 3, R: 1, H: 1, h: 1}
    judge("M-formula", cases={"f = 1/4": zero((corrected - printed).subs(quarter)),
                              "f = 1/3": zero((corrected - printed).subs(third))})  # fmt: skip


def test_planes_normal_to_surface(judge):
    # A plane on the axis holds the cone's normals along its ruling, and isn't normal to PQ.
    plane = sp.Matrix([-sp.sin(theta), sp.cos(theta), 0])
    ruling = dict(zip(n, (sp.cos(theta), sp.sin(theta), -1 / sp.sqrt(k)), strict=True))
    gradient = sp.Matrix([EQ13.diff(v) for v in n]).subs(ruling)
    chord = sp.Matrix([0, h * R / H, -h]) - sp.Matrix([R, 0, -H])
    normal_to_surface = zero(gradient.dot(plane))
    normal_to_chord = zero(chord.cross(plane))
    judge("planes-normal", normal_to_surface and not normal_to_chord)


def test_LN_closed_form(judge):
    # The foot's distance from the apex from Eqs 16 and back-substitution: no root is needed.
    S, reach = sp.sqrt(H**2 + R**2), sp.symbols("rho", positive=True)
    LN = (reach * R + h * H) / S  # M at (reach, azimuth theta, -h)
    centre = {m1: reach * sp.cos(theta), m2: reach * sp.sin(theta), m3: -h, k: R**2 / H**2}
    first = LN * R / S * sp.cos(theta)
    second, third = (form.subs(centre).subs(n1, first) for form in BACK)
    foot = sp.Matrix([first, second, third])
    judge("foot-distance", zero([shared.EQ16.subs(centre).subs(n1, first), foot.dot(foot) - LN**2]))
    assert zero(third + LN * H / S)


def test_good_approximation(judge):
    # Lengths along the cone of both paths; tests/test_cone_chord.py has them by the definition.
    chord = ConeChord(*shared.EXAMPLE_CONE)
    longer = chord.path_length / chord.geodesic_length - 1
    # The table's last column, at equal azimuth, is more than the distance across.
    us = np.linspace(0, 1, 201)
    across = np.max(np.abs(chord.deviation(us)))
    assert across < 0.9 * np.max(np.abs(chord.table(us)[:, 4]))
    # "Quite good", let it be a hundredth: it depends on what is measured.
    length = chord.path_length
    judge("approximation", cases={"by their lengths": bool(longer < 0.01),
                                  "by what is between them": across < 0.01 * length})  # fmt: skip


def unevenness(chord):
    """Return the longest over the shortest of ten steps of equal u, and of equal t along PQ."""
    share = np.linspace(0, 1, 11)
    P, Q = chord.chord_point([0.0, chord.turn])
    feet = chord.cone.feet(P + share[:, None] * (Q - P))[:, 0]
    turned = np.unwrap(np.arctan2(feet[:, 1], feet[:, 0]))
    plain = chord.cone.development(np.linalg.norm(feet, axis=-1), turned)
    paths = chord.path(share), plain
    steps = [np.linalg.norm(np.diff(path, axis=0), axis=-1) for path in paths]
    return [lengths.max() / lengths.min() for lengths in steps]


def test_equal_steps_along_chord(judge):
    # "Obviously will not produce equally spaced points N": nor does the path's own rule exactly.
    by_azimuth, plain = unevenness(ConeChord(*shared.EXAMPLE_CONE))
    judge("equal-steps", plain > 1.2)
    assert by_azimuth < plain


def test_steps_of_equal_u(judge):
    # "Close to equal", let it be a quarter more or less: the example's ten steps are, a wide
    # turn's aren't; and only from f = 1/4 on, of these, is it worth more than equal t.
    found = {f: unevenness(ConeChord(1, 1, 0.5, f)) for f in (0.1, 0.25, 0.4)}
    judge("close-to-equal", cases={"a quarter turn": found[0.25][0] < 1.25,
                                   "four tenths of a turn": found[0.4][0] < 1.25})  # fmt: skip
    assert np.round(found[0.25], 3).tolist() == [1.189, 1.280]
    assert np.round(found[0.4], 2).tolist() == [1.98, 3.14]
    assert np.round(found[0.1], 3).tolist() == [1.035, 1.013]


def test_perfect_approximation(judge):
    # Each plane on the axis meets the chord's path once, and the geodesic once: along both the
    # azimuth grows. So they have one point in it where they are one, and else two.
    one = []
    for values in ((1, 1, 0.5, 0.25), (3, 4, 1, 0.3), (1, 2, 1.5, 0.1)):
        chord, share = ConeChord(*values), np.linspace(0, 1, 2001)
        azimuth = chord.azimuth(share)
        x, y, _ = chord.chord_point(azimuth).T
        _, _, LN, NN, _ = chord.table(share).T
        apart = NN - LN  # in each plane
        grows = np.diff([azimuth, np.unwrap(np.arctan2(y, x))]) > 0
        one.append(grows.all() and np.max(np.abs(apart[[0, -1]])) < 1e-12)
        assert np.sum(np.diff(np.sign(apart[5:-5])) != 0) <= 1  # crossings
        assert np.max(np.abs(apart)) > 1e-4
    judge("cone-perfect", all(one))
