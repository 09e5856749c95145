"""Tunnelling robot, appendix: the cone and its normals, Eqs 13 to 16, and the numeric example.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import numpy as np
import sympy as sp

from tests import symbols_tunneller as shared
from tests.basic_listing import PRINTED
from tests.symbols_tunneller import EQ13, at, close, k, m, m1, m2, m3, n, n1, n2, n3, zero
from tunneller_lib.surfaces import Cone

READS = ["report/ledger/*", "report/listings.toml"]

EQ14 = n2 * (n1 - m1) - n1 * (n2 - m2)
EQ15 = k * n3 * (n1 - m1) + n1 * (n3 - m3)
ANGLES = (0.1, np.arctan(0.5), np.pi / 4, 1.4)


def test_eq13_cone(judge):
    alpha, s = sp.symbols("alpha s", positive=True)
    theta, out = shared.theta, s * sp.sin(alpha)
    ruling = {n1: out * sp.cos(theta), n2: out * sp.sin(theta), n3: -s * sp.cos(alpha)}
    on_it = zero(EQ13.subs(ruling).subs(k, sp.tan(alpha) ** 2))
    # Elsewhere it isn't zero: at a distance rho from the axis it is only at the cone's height.
    rho, height, tan = sp.symbols("rho height tan", positive=True)
    anywhere = {n1: rho * sp.cos(theta), n2: rho * sp.sin(theta), n3: -height, k: tan**2}
    nowhere_else = zero(EQ13.subs(anywhere) - (rho - height * tan) * (rho + height * tan))
    judge("eq13", on_it and nowhere_else)


def test_eq13_k(judge):
    # tan(alpha) = R/H = 3/4, alpha "the cone apex half angle": the circle R = 3, H = 4 is on it.
    alpha = sp.atan(sp.Rational(3, 4))
    half = sp.sin(alpha) / (1 + sp.cos(alpha))  # tan(alpha/2)
    printed, corrected = half**2, sp.tan(alpha) ** 2
    rim = EQ13.subs({n1: 3, n2: 0, n3: -4})
    judge("eq13-k", zero(rim.subs(k, printed)), right=zero(rim.subs(k, corrected)))
    assert corrected == sp.Rational(9, 16)
    # A second way: the listing, and the library's cone, on which that circle is, near and far.
    for size in (1e-6, 1.0, 1e6):
        circle = size * np.array([3.0, 0, -4])
        assert abs(Cone(np.arctan(0.75)).implicit(circle)) < 1e-14 * size**2
        assert abs(Cone(np.arctan(0.75) / 2).implicit(circle)) > 7 * size**2  # alpha/2
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
    judge("eq16", len(orders) == 2 and all(orders) and bool(sp.degree(printed, n1) == 2))


def test_eq16_back_substitution(judge):
    printed = m2 * n1 / m1, m3 * n1 / (k * (n1 - m1) + n1)
    [second], [third] = sp.solve(EQ14, n2), sp.solve(EQ15, n3)
    judge("eq16-back-substitution", zero([second - printed[0], third - printed[1]]))


def test_eq16_m1_zero(judge):
    # The plane m1 = 0, in which Q lies at f = 1/4: Eq. 16 leaves n1 = 0 and 0/0 for n2 and n3.
    back = m2 * n1 / m1, m3 * n1 / (k * (n1 - m1) + n1)

    def serves(*middle):
        """Tell whether Eq. 16 and what follows it lead to both feet of M; k = 1."""
        quadratic = sp.Poly(shared.EQ16.subs({k: 1, **dict(zip(m, middle, strict=True))}), n1)
        first = np.roots(np.array(quadratic.all_coeffs(), float))
        with np.errstate(invalid="ignore"):
            found = [first, *(at(form, (k, *m, n1), (1, *middle, first)) for form in back)]
        feet = Cone(np.pi / 4).feet(middle)
        return close(np.sort(found), np.sort(feet.T), 10)  # coordinate by coordinate

    judge("eq16-m1-zero", cases={"M beside the plane m1 = 0": serves(1, 2, -3),
                                 "M in the plane m1 = 0": serves(0, 1, -2)})  # fmt: skip
    assert zero(shared.EQ16.subs(m1, 0) - (k + 1) ** 2 * m2**2 * n1**2)
    assert zero(back[1].subs(m1, 0) - m3 / (k + 1))  # a limit that isn't the foot's n3


def right_to(decimals, shown, truth):
    """Tell which numbers are right to so many decimals: to half a unit of the last."""
    return np.abs(np.subtract(shown, truth)) < 0.5 * 10.0 ** -np.asarray(decimals)


def test_numeric_example(judge):
    root2, root5 = sp.sqrt(2), sp.sqrt(5)
    centre = sp.Matrix([-root2, -3 * root2, -12])
    values = {k: sp.Rational(1, 4), **dict(zip(m, centre, strict=True))}
    feet = []
    for root in sp.solve(shared.EQ16.subs(values), n1):
        other = [(m2 * n1 / m1).subs(values).subs(n1, root),
                 (m3 * n1 / (k * (n1 - m1) + n1)).subs(values).subs(n1, root)]  # fmt: skip
        feet.append(sp.Matrix([root, *other]).applyfunc(sp.radsimp))
    feet.sort(key=lambda foot: foot[0])
    # Four numbers have nine decimals, n3 of the first foot and n1 of the second have eight.
    digits = [(-1.800735989, -5.402207965, -11.38885438), (1.23505056, 3.705151691, -7.811145618)]
    decimals = [(9, 9, 8), (8, 9, 9)]
    truth = np.array([foot.T for foot in feet], float).reshape(2, 3)
    as_printed = right_to(decimals, digits, truth)
    judge("example-N", cases={"to eight decimals": np.all(right_to(8, digits, truth)),
                              "to the digits printed": np.all(as_printed)})  # fmt: skip
    assert as_printed.tolist() == [[True, False, True]] * 2  # n2 of either foot is off
    radii = [sp.sqrt(sp.simplify((foot - centre).dot(foot - centre))) for foot in feet]
    printed = [1.366563, 8.39997]
    corrected = [12 / root5 - 4, 12 / root5 + 4]
    assert zero([radii[0] - corrected[0], radii[1] - corrected[1]])
    judge("example-radius-1", right_to(6, printed[0], float(radii[0])))
    judge("example-radius-2", right_to(5, printed[1], float(radii[1])),
          right=right_to(5, float(corrected[1]), float(radii[1])))  # fmt: skip
    # Where 8.39997 comes from: n1 and n2 of this foot with n3 of the other.
    mixed = sp.Matrix([feet[1][0], feet[1][1], feet[0][2]]) - centre
    assert abs(mixed.norm() - printed[1]) < 6e-6
    # A second way, in floats: the library's feet and their distances.
    middle = np.array(centre.T, float)[0]
    found = Cone(np.arctan(0.5)).feet(middle)
    assert close(found, truth, 10)
    away = np.linalg.norm(found - middle, axis=-1)
    assert close(away, [12 / 5**0.5 - 4, 12 / 5**0.5 + 4], 10) and abs(away[1] - printed[1]) > 0.9
