"""Tunnelling robot, section 3.3.1: the four feet of a sphere's centre, Eqs 10 and 11.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import itertools

import numpy as np
import sympy as sp

from tests import symbols_tunneller as shared
from tests.shapes import PROOFS, joint_pairs
from tests.symbols_tunneller import R, close, m1, m2, m3, n1, n2, n3, r, t, u, zero
from tunneller_lib.paths import project_chord
from tunneller_lib.surfaces import Torus

READS = ["report/ledger/*"]

DEGREES = sp.pi / 180


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


def test_eq10_no_cubic(judge):
    truth = feet_product()
    judge("eq10", truth.degree() == 4 and zero(truth.coeff_monomial(n1**3)))


def test_eq10_back_substitution(judge):
    # Not given for N: n3 = m3 n1 / m1 and, on one of the two circles, n2 = m2 (W - sigma r)/(...).
    rho, d = sp.symbols("rho d")
    for sigma, eps in shared.SIGNS:
        W = sigma * r + eps * R * (rho - sigma * r) / d
        assert zero(m2 * (W - sigma * r) / (rho - sigma * r) - eps * R * m2 / d)
    assert shared.vanishes_at_feet(shared.THIRD)
    torus, centre = Torus(1, 4), (2.0, 1.0, 3.0)
    quartic = shared.eq10()
    roots = sp.Poly(quartic.subs(shared.EXAMPLE), n1).nroots(n=15)
    solved = close(np.sort(torus.feet(centre)[:, 0]), np.array(sorted(map(float, roots))), 100)
    judge("eq10-back-substitution",
          cases={"n1": n1 in quartic.free_symbols and solved,
                 "n2 and n3": {n2, n3} <= quartic.free_symbols})  # fmt: skip


def coefficient(power, m1_power=4):
    return m1**m1_power * feet_product().coeff_monomial(n1**power)


def is_by_feet(form, power):
    """Tell whether a form is the coefficient of n1^4 or n1^0, over m1^4, by the library's feet.

    For M and the torus of EXAMPLE, in numbers: N1 as printed, which holds, is minus N4 times the
    sum of the triple products of the feet's n1, and N0 is N4 times the product of all.
    """
    feet = Torus(1, 4).feet((2, 1, 3))[:, 0]
    triples = sum(np.prod(three) for three in itertools.combinations(feet, 3))
    wanted = -float((shared.eq11()["N1"] / m1**4).subs(shared.EXAMPLE)) / triples
    wanted *= np.prod(feet) if power == 0 else 1
    return bool(abs(float(form.subs(shared.EXAMPLE)) / wanted - 1) < 1e-9)


def test_eq11_N4(judge):
    corrected = shared.eq11(mended=True)["N4"]
    printed = corrected / (m1**2 + m3**2)  # without the square
    truth = coefficient(4)
    judge("eq11-N4", zero(printed - truth), right=zero(corrected - truth))
    # A second way, in numbers.
    assert is_by_feet(corrected / m1**4, 4) and not is_by_feet(printed / m1**4, 4)


def test_eq11_nu4(judge):
    printed, corrected = (shared.eq11(mended)["nu4"] for mended in (False, True))
    s, truth = m1**2 + m3**2, coefficient(4, 0)
    judge("eq11-nu4", zero(s**2 * printed - truth), right=zero(s**2 * corrected - truth))
    assert zero(corrected - ((s + r**2 + m2**2) ** 2 - 4 * r**2 * s))
    # A second way, in numbers.
    assert is_by_feet(s**2 * corrected, 4) and not is_by_feet(s**2 * printed, 4)


def test_eq11_N1_N2_nu2(judge):
    printed = shared.eq11()
    s = m1**2 + m3**2
    judge("eq11-N1", zero(printed["N1"] - coefficient(1)))
    judge("eq11-N2", zero(printed["N2"] - coefficient(2)))
    judge("eq11-nu2", zero(-2 * m1**2 * s * printed["nu2"] - coefficient(2, 0)))
    short = (r**2 + R**2) * (s - r**2) ** 2 + (2 * r**2 + R**2) * (s + r**2) * m2**2 + r**2 * m2**4
    assert zero(printed["nu2"] - short)


def test_eq11_nu0(judge):
    printed, corrected = (shared.eq11(mended)["nu0"] for mended in (False, True))
    truth = coefficient(0, 0)
    judge("eq11-nu0", zero(m1**4 * printed - truth), right=zero(m1**4 * corrected - truth))
    judge("eq11-N0", zero(m1**8 * corrected - coefficient(0)))
    # A second way, in numbers.
    assert is_by_feet(m1**4 * corrected, 0) and not is_by_feet(m1**4 * printed, 0)


def test_eq11_quartic(judge):
    # Corrected, Eqs 10 and 11 have exactly the n1 of the four feet as roots; printed, they don't.
    printed, corrected, feet = shared.eq10(mended=False), shared.eq10(), feet_product()

    def has_feet(form):  # but for a factor free of n1
        quartic = sp.Poly(form, n1)
        return sp.expand(feet.LC() * quartic.as_expr() - quartic.LC() * feet.as_expr()) == 0

    judge("eq11", has_feet(printed), right=has_feet(corrected))
    # A second way, in numbers: the library's feet, by no polynomial.
    foot = Torus(1, 4).feet((2, 1, 3))[:, 0]
    example = [form.subs(shared.EXAMPLE) for form in (printed, corrected)]
    wrong, right = (sp.lambdify(n1, form / abs(form.subs(n1, 0))) for form in example)
    assert np.min(np.abs(wrong(foot))) > 0.1 and close(right(foot), 0, 100)


def test_four_coefficients(judge):
    # Corrected, grouped as printed: what is added, multiplied and raised to a power.
    mended = shared.eq11(mended=True)
    left = [mended[f"N{p}"] for p in range(5) if mended[f"N{p}"] != 0]
    operations = sum(map(sp.count_ops, left))
    judge("four-coefficients", len(left) == 4 and operations < 200)


def test_eq11_common_factor(judge):
    printed = shared.eq11()
    coefficients = [printed[name] for name in ("N4", "N2", "N1", "N0")]
    assert all(sp.rem(c, m1**4, m1) == 0 for c in coefficients)
    assert not all(sp.rem(sp.expand(c), m1**5, m1) == 0 for c in coefficients)

    def tell(place):  # the quartic isn't 0 = 0
        return any(c.subs(m1, place) != 0 for c in coefficients)

    judge("eq11-common-factor", cases={"m1 = 2": tell(2), "m1 = 0": tell(0)})
    # At m1 = 0 the feet exist all the same.
    feet = Torus(1, 4).feet((0, 1, 3))
    assert close(Torus(1, 4).implicit(feet), 0, 1e3) and close(feet[:, 0], 0)
    assert np.ptp(feet[:, 2]) > 1


def test_nearest_foot(judge):
    # |MN| = |R - d+|, R + d+, |R - d-|, R + d-, with d- >= d+: the distances of M from the
    # meridian circles' centres. The first is least where d+ + d- > 2R, and nowhere else.
    for torus in PROOFS[:3]:
        centres = 2 * torus.R * shared.draw(13, 500, 3)
        rho = np.hypot(centres[:, 0], centres[:, 2])
        plus, minus = (np.hypot(rho - s * torus.r, centres[:, 1]) for s in (1, -1))
        away = np.linalg.norm(torus.feet(centres) - centres[:, None], axis=-1)
        lengths = [abs(torus.R - plus), torus.R + plus, abs(torus.R - minus), torus.R + minus]
        assert close(away, np.transpose(lengths), 10 * torus.R)
        first = np.argmin(away, axis=-1) == 0
        assert np.array_equal(first, plus + minus > 2 * torus.R)
        assert 0 < np.sum(first) < len(first)
    # On the working sheet alone the nearest point is the working foot.
    nearest_of_sheet = []
    for torus in PROOFS[:3]:
        sheet = np.arccos(-torus.r / torus.R) * np.linspace(-1, 1, 4001)
        turns = np.pi * np.linspace(-1, 1, 101)[:, None]
        for centre in torus.point(*shared.draw(17, 8, 2).T) * 0.6:
            least = np.linalg.norm(torus.point(turns, sheet) - centre, axis=-1).min()
            away = np.linalg.norm(torus.foot(centre) - centre)
            assert least < 1.01 * away + 0.01 * torus.R
            nearest_of_sheet.append(away <= least)
    # A chord within the joint limits whose middle has another foot nearest: R/r = 10.
    ends = Torus(1, 10).point(np.arcsin([-0.8, 8 / 17]), 0.0)
    middle = np.mean(ends, axis=0)
    away = np.linalg.norm(Torus(1, 10).feet(middle) - middle, axis=-1)
    assert np.argmin(away) == 2 and away[0] - away[2] > 1.9
    working = np.linalg.norm(Torus(1, 10).foot(middle) - middle)
    assert close(working, away[0], 10)
    judge("nearest-foot",
          cases={"on the working sheet": len(nearest_of_sheet) == 24 and all(nearest_of_sheet),
                 "on both sheets": working <= np.min(away)})  # fmt: skip


def test_greatest_n1_foot(judge):
    # Between the joint limits the working foot has the greatest n1. W = n1 rho / m1, so that
    # W(+,+) - W(+,-) = 2R(rho - r)/d+ > 0 beyond the ring, and
    # W(+,+) - W(-,+) = 2r - R (g(rho + r) - g(rho - r)), g(s) = s/sqrt(s^2 + m2^2), whose slope
    # m2^2/(s^2 + m2^2)^(3/2) falls: it is enough that d+^3 > R m2^2.
    s, d = sp.symbols("s d", positive=True)
    slope = (s / sp.sqrt(s**2 + m2**2)).diff(s)
    assert zero(slope - m2**2 / (s**2 + m2**2) ** sp.Rational(3, 2))
    assert sp.simplify(slope.diff(s) / s / m2**2).subs({s: 1, m2: 1}) < 0
    margin = d**3 - R * (d**2 - s**2)  # d = d+, s = rho - r: least at d = 2R/3
    (lowest,) = sp.solve(margin.diff(d), d)
    assert lowest == 2 * R / 3
    assert zero(margin.subs(d, lowest) - R * (s**2 - 4 * R**2 / 27))  # so s > 2R/sqrt(27) will do
    # Within the limits s >= (r + R cos 40) cos(95/2) - r, enough for all R > 5r/2.
    reach = (r + R * sp.cos(40 * DEGREES)) * sp.cos(sp.Rational(95, 2) * DEGREES) - r
    excess = sp.expand(reach - 2 * R / sp.sqrt(27))
    assert excess.coeff(r) < 0 and sp.N(excess.subs({r: 2, R: 5})) > 0

    def is_working(choose, torus, centres):  # the root that is chosen, at each centre
        first = torus.feet(centres)[..., 0]
        assert np.all(np.isfinite(first))
        return np.all(choose(first, axis=-1) == 0)

    greatest, least = [], []
    for torus in (Torus(1, 2.5), Torus(1, 8), Torus(1, 10)):
        ends = torus.point(*joint_pairs(2000, 14).T).swapaxes(0, 1)
        share = np.random.default_rng(15).uniform(size=(2000, 1))
        centres = ends[0] + share * (ends[1] - ends[0])
        greatest.append(is_working(np.argmax, torus, centres))
        least.append(is_working(np.argmin, torus, centres))
    deep = 1.05, 0.5, 0  # m1 > 0 alone isn't enough
    greatest_there = is_working(np.argmax, Torus(1, 10), deep)
    judge("working-foot",
          cases={"the greatest, between the limits": len(greatest) == 3 and all(greatest),
                 "the least, between the limits": any(least),
                 "the greatest, deep inside": greatest_there})  # fmt: skip


def test_fairly_equal_separation(judge):
    # "Parameterizing in equal increments from P to Q": on a meridian, seen from the tube's centre,
    # tan(phi) = (2t - 1) tan(half), where half is half the angle between the end normals.
    half = sp.symbols("half", positive=True)
    printed = sp.atan((2 * t - 1) * sp.tan(half))
    middle, end = printed.diff(t).subs(t, sp.Rational(1, 2)), printed.diff(t).subs(t, 1)
    assert zero(middle / end - 1 / sp.cos(half) ** 2)
    even = (1 + sp.tan(half * (2 * u - 1)) / sp.tan(half)) / 2
    assert zero(((2 * t - 1) * sp.tan(half)).subs(t, even) - sp.tan(half * (2 * u - 1)))

    def fairly_equal(reach):  # steps that differ by less than a tenth
        ends = np.radians([(10, -reach), (10, reach)])
        steps = np.diff(project_chord(Torus(1, 10), *ends, 101)[:, 1])
        return steps.max() / steps.min() < 1.1

    judge("fairly-equal",
          cases={"ends 20 degrees apart": fairly_equal(10),
                 "ends 80 degrees apart": fairly_equal(40)})  # fmt: skip
