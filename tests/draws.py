"""What the tests share: draws of numbers and directions, exact arithmetic."""

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

EPS = np.finfo(float).eps


def log_uniform(low, high):
    """Return a strategy of floats whose logarithm is spread evenly."""
    return st.floats(np.log(low), np.log(high)).map(lambda x: float(np.exp(x)))


def directions(rng, n):
    """Return n random unit vectors (n, 3)."""
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def fractions(*values):
    """Return floats as exact fractions."""
    return [Fraction(float(value)) for value in values]
