"""Taylor coefficients to order 5 of the elementary functions of one variable, for `jet`.

The functions bear numpy's names, by which `jet` looks them up; they are called as
``elementary.exp`` only.
"""

from math import factorial

import numpy as np


def power(x, p):
    """Return the coefficients of x^p for a real p."""
    binomial = [1.0]
    for k in range(5):
        binomial.append(binomial[-1] * (p - k) / (k + 1))
    return [b * x ** (p - k) for k, b in enumerate(binomial)]


def reciprocal(x):
    """Return the coefficients of 1/x."""
    return [(-1) ** n / x ** (n + 1) for n in range(6)]


def log(x):
    """Return the coefficients of log(x)."""
    return [np.log(x), *((-1) ** (n - 1) / (n * x**n) for n in range(1, 6))]


def exp(x):
    """Return the coefficients of exp(x)."""
    return _repeated(np.exp(x))


def sin(x):
    """Return the coefficients of sin(x)."""
    return _repeated(np.sin(x), np.cos(x), -np.sin(x), -np.cos(x))


def cos(x):
    """Return the coefficients of cos(x)."""
    return _repeated(np.cos(x), -np.sin(x), -np.cos(x), np.sin(x))


def sinh(x):
    """Return the coefficients of sinh(x)."""
    return _repeated(np.sinh(x), np.cosh(x))


def cosh(x):
    """Return the coefficients of cosh(x)."""
    return _repeated(np.cosh(x), np.sinh(x))


def tan(x):
    """Return the coefficients of tan(x)."""
    t = np.tan(x)
    c = 1 + t * t
    last = c * (t**4 + t * t + 2 / 15)
    return [t, c, t * c, c * (t * t + 1 / 3), t * c * (t * t + 2 / 3), last]


def tanh(x):
    """Return the coefficients of tanh(x)."""
    t = np.tanh(x)
    c = 1 / np.cosh(x) ** 2  # 1 - t^2 would cancel
    last = c * (t**4 - t * t + 2 / 15)
    return [t, c, -t * c, c * (t * t - 1 / 3), t * c * (2 / 3 - t * t), last]


def arctan(x):
    """Return the coefficients of arctan(x)."""
    c = 1 / (1 + x * x)
    last = (x**4 - 2 * x * x + 1 / 5) * c**5
    return [np.arctan(x), c, -x * c**2, (x * x - 1 / 3) * c**3, (x - x**3) * c**4, last]


def _repeated(*derivatives):
    """Return the coefficients of a function whose derivatives come round again."""
    return [derivatives[n % len(derivatives)] / factorial(n) for n in range(6)]
