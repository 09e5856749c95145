"""Vectors as lists of three coordinates, each a number, an array or a jet."""

import numpy as np


def cross_product(a, b):
    """Return the vector product of two vectors."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def dot_product(a, b):
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(first, *others):
    """Return the sum of vectors, the first and the others."""
    for other in others:
        first = [a + b for a, b in zip(first, other, strict=True)]
    return first


def times(c, a):
    """Return the multiple c of a vector a."""
    return [c * part for part in a]


def unit_vector(a):
    """Return a vector a, scaled to length 1."""
    return times(1 / np.sqrt(dot_product(a, a)), a)
