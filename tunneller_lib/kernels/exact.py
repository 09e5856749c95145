"""Arithmetic that keeps its digits where numbers cancel.

The error-free transformations are Dekker's (1971) and Knuth's (1969); the difference of products is
Kahan's.
"""

import numpy as np

_SPLITTER = 2.0**27 + 1.0


def dot(a, b):
    """Return the scalar products of vectors along the last axis."""
    return np.einsum("...i,...i->...", a, b)


def norm(a):
    """Return the lengths of vectors along the last axis."""
    return np.sqrt(dot(a, a))


def two_product(a, b):
    """Return a * b, rounded, and exactly what rounding took off it."""
    product = a * b
    # Each factor is split into halves of 26 bits, whose products are exact (Dekker).
    a_scaled, b_scaled = _SPLITTER * a, _SPLITTER * b
    a_high, b_high = a_scaled - (a_scaled - a), b_scaled - (b_scaled - b)
    a_low, b_low = a - a_high, b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def two_sum(a, b):
    """Return a + b, rounded, and exactly what rounding took off it."""
    total = a + b
    shadow = total - a  # the part of b that is in the sum (Knuth)
    return total, (a - (total - shadow)) + (b - shadow)


def difference_of_products(a, b, c, d):
    """Return a * b - c * d to the last digits, however much of it cancels."""
    first, first_error = two_product(a, b)
    second, second_error = two_product(c, d)
    # Where both products are nearly the same, what their roundings took off is most of the answer.
    difference, error = two_sum(first, -second)
    return difference + (error + (first_error - second_error))


def cross(a, b):
    """Return the vector products along the last axis, each component right to its last digits."""
    return np.stack(accurate_products(np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)), axis=-1)


def accurate_products(a, b):
    """Return vector products of three numbers each, every one right to its last digits."""
    ax, ay, az = a
    bx, by, bz = b
    return (
        difference_of_products(ay, bz, az, by),
        difference_of_products(az, bx, ax, bz),
        difference_of_products(ax, by, ay, bx),
    )


def radius_and_excess(x, z, r):
    """Return rho = hypot(x, z) and rho - r, the latter to 1e-23 of r.

    Each number is split at the same bit, 25 below r's first. The squares of the leading parts are
    then whole multiples of one unit, and their sum is exact where rho is near r, the only place
    where digits could be lost. No square may over- or underflow.
    """
    grid = 1.5 * 2.0 ** (np.frexp(r)[1] + 27)  # adding and subtracting it rounds to 2^-25 of r
    x_lead, z_lead, r_lead = (x + grid) - grid, (z + grid) - grid, (r + grid) - grid
    lead = x_lead * x_lead + z_lead * z_lead - r_lead * r_lead
    rest = (x - x_lead) * (x + x_lead) + (z - z_lead) * (z + z_lead)
    rest -= (r - r_lead) * (r + r_lead)
    # rho - r is (rho^2 - r^2) / (rho + r), with the difference of squares in two parts.
    rho = np.sqrt(x * x + z * z)
    return rho, (lead + rest) / (rho + r)


def in_blocks(function, rows, width, block=8192):
    """Return `function` of an array (..., n), called on blocks of rows that fit the cache.

    `function` maps (k, n) to (k, width). Without blocks numpy's intermediate arrays go to memory
    and back, which costs more than the arithmetic.
    """
    flat = rows.reshape(-1, rows.shape[-1])
    out = np.empty((len(flat), width))
    for start in range(0, len(flat), block):
        out[start : start + block] = function(flat[start : start + block])
    return out.reshape(*rows.shape[:-1], width)
