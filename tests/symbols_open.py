"""Symbols for the open problems: forms in a turning direction, at a general point of the model.

`D` differentiates with the direction held fixed, as the proofs do; the direction itself is `a`.
"""

from itertools import product

import numpy as np
import sympy as sp

from tests.symbols_envelopes import EVERY as F
from tests.symbols_envelopes import p, x, y

a, tau = sp.symbols("a tau", real=True)
e = sp.cos(a), sp.sin(a)
w = -sp.sin(a), sp.cos(a)
xe = x * e[0] + y * e[1]
xw = x * w[0] + y * w[1]


def form(*ways):
    """Return the derivative of f along directions."""
    total = 0
    for choice in product((0, 1), repeat=len(ways)):
        term = F[choice.count(0), choice.count(1)]
        for way, i in zip(ways, choice, strict=True):
            term *= way[i]
        total += term
    return total


def vanishes(expression):
    above = sp.expand(sp.fraction(sp.together(expression))[0])
    return sp.rem(above, e[0] ** 2 + e[1] ** 2 - 1, e[1]) == 0 or sp.simplify(expression) == 0


def vanishes_at_fractions(expression):
    """Tell whether an expression is exactly 0 at three random places, for what is long to expand.

    By the lemma of Schwartz and Zippel no such polynomial but 0 itself is likely to vanish there.
    """
    rng = np.random.default_rng(15)
    symbols = sorted(expression.free_symbols - {a}, key=str)
    for _ in range(3):
        m, n, *values = map(sp.Integer, rng.integers(1, 10**6, 2 + len(symbols)).tolist())
        here = dict(zip(symbols, values, strict=True))
        here[sp.cos(a)] = (m * m - n * n) / (m * m + n * n)
        here[sp.sin(a)] = 2 * m * n / (m * m + n * n)
        if sp.expand(expression.xreplace(here)) != 0:
            return False
    return True


SLOPE = F[1, 0], F[0, 1]
HEIGHT = F[0, 0] - x * F[1, 0] - y * F[0, 1]
q = p * form(e, e, e) + 6 * (tau - xw) * form(e, w)  # (11) is rho^3 q/p
qa = q.diff(a)
qaa = qa.diff(a)
kappa = 2 * (tau - xw) / p  # 1/rho, by (9)
rho = 1 / kappa
M = p * form(e, e) + 2 * HEIGHT  # (24) with R = 0, up to rho^2
