"""Symbols of the tunnelling robot's equations, and what several tests of them share.

Tests are tests/test_equations_*.py; the verdicts stand in report/ledger/tunneller.toml.
"""

import itertools

import numpy as np
import sympy as sp

r, R, theta, phi = sp.symbols("r R theta phi", positive=True)
t, u, k, H, h, f = sp.symbols("t u k H h f", positive=True)
x, y, z, w = sp.symbols("x y z w")
m = m1, m2, m3 = sp.symbols("m1:4")
n = n1, n2, n3 = sp.symbols("n1:4")
TORUS = (x**2 + y**2 + z**2 - (r**2 + R**2)) ** 2 - (2 * r) ** 2 * (R**2 - y**2)  # Eq. 2


def zero(expression):
    """Return whether an expression, or each entry of a matrix, vanishes identically."""
    return all(map(is_zero, sp.Matrix([expression])))


def is_zero(expression):
    """Return whether one vanishes: its numerator multiplied out, or else made simple."""
    return sp.expand(sp.fraction(sp.together(expression))[0]) == 0 or sp.simplify(expression) == 0


def at(expression, symbols, values):
    """Return an expression in floats, computed by sympy from the values given."""
    return sp.lambdify(symbols, expression, "numpy")(*values)


def close(found, expected, scale=1.0):
    return np.max(np.abs(np.asarray(found) - expected)) < 1e-11 * scale


def draw(seed, *shape):
    return np.random.default_rng(seed).uniform(-1, 1, shape)


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


def eq11(mended=False):
    """Return the parts of Eq. 11 by their names, as printed or with its slips mended."""
    s, second = m1**2 + m3**2, m2 if mended else m3
    last = r**2 - R**2 if mended else r**2 + R**2
    nu4 = (
        r**4 + (m3**2 - 2 * r**2) * m3**2
        + (2 * (m3**2 + r**2) + m2**2) * m2**2
        + (2 * (second**2 + m3**2 - r**2) + m1**2) * m1**2
    )  # fmt: skip
    nu2 = (
        (r**2 + R**2) * (r**4 + (m3**2 - 2 * r**2) * m3**2)
        + (r**2 * m2**2 + (2 * r**2 + R**2) * (r**2 + m3**2)) * m2**2
        + ((r**2 + R**2) * (2 * m3**2 + m1**2 - 2 * r**2) + (2 * r**2 + R**2) * m2**2) * m1**2
    )
    nu0 = (
        (r**2 - R**2) * last * (r**4 + (m3**2 - 2 * r**2) * m3**2) * (1 if mended else m3**2)
        + r**2 * (2 * (r**2 - R**2) * (r**2 + m3**2) + r**2 * m2**2) * m2**2
        + (r**2 - R**2) * (last * (-2 * r**2 + 2 * m3**2 + m1**2) + 2 * r**2 * m2**2) * m1**2
    )
    N4, N2 = m1**4 * s ** (2 if mended else 1) * nu4, -2 * m1**6 * s * nu2
    N1, N0 = 8 * r**2 * R**2 * s * m1**7 * m2**2, m1**8 * nu0
    return {"nu4": nu4, "nu2": nu2, "nu0": nu0,
            "N4": N4, "N3": sp.Integer(0), "N2": N2, "N1": N1, "N0": N0}  # fmt: skip


def eq10(mended=True):
    """Return Eq. 10 with Eq. 11 put in, without the factor m1^4."""
    parts = eq11(mended)
    return sp.expand(sum(parts[f"N{p}"] * n1**p for p in range(5)) / m1**4)


EQ13 = n1**2 + n2**2 - k * n3**2
EQ16 = (
    (k + 1) ** 2 * (m1**2 + m2**2) * n1**2
    - 2 * k * (k + 1) * m1 * (m1**2 + m2**2) * n1
    + k * m1**2 * (k * (m1**2 + m2**2) - m3**2)
)


def development():
    """Return S, sigma, Phi_f and the point N_d(u), from P_d(S, 0) and Q_d."""
    S = sp.sqrt(H**2 + R**2)
    sigma, Phi_f = h * S / H, f * 2 * sp.pi * R / S
    P = sp.Matrix([S, 0])
    Q = sigma * sp.Matrix([sp.cos(Phi_f), sp.sin(Phi_f)])
    return S, sigma, Phi_f, P + u * (Q - P)


CHORDS = ((1, 1, 0.5, 0.25), (3, 4, 1, 0.3), (2, 1, 0.5, 0.1), (4, 3, 1, 0.4))
EXAMPLE_CONE = (1, 1, 0.5, 0.25)
