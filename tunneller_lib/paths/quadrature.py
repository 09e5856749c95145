"""Gauss and Legendre's quadrature, whose nodes are computed once."""

from functools import cache

from numpy.polynomial import legendre


@cache
def gauss_rule(count):
    """Return so many nodes (count,), from -1 to 1, and their weights; neither may be written to.

    They come from an eigenvalue problem, which takes longer than most sums over them.
    """
    rule = legendre.leggauss(count)
    for row in rule:
        row.flags.writeable = False
    return rule
