"""Vectors of three numbers each, or of three rows, one for each coordinate of many vectors."""

from .elementwise import larger, power_above, scaled, square_root, where


def scalar_products(a, b):
    """Return scalar products of vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def vector_products(a, b):
    """Return the components of vector products."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def products_with_each(vectors, v):
    """Return the scalar products of three vectors with a fourth."""
    return (
        scalar_products(vectors[0], v),
        scalar_products(vectors[1], v),
        scalar_products(vectors[2], v),
    )


def lengths(v):
    """Return the lengths of vectors."""
    return square_root(scalar_products(v, v))


def sums(a, b):
    """Return the sums of vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def differences(a, b):
    """Return the differences of vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def multiples(factor, v):
    """Return vectors times factors."""
    return factor * v[0], factor * v[1], factor * v[2]


def shares(v, parts):
    """Return vectors divided by numbers, none of which is zero."""
    return v[0] / parts, v[1] / parts, v[2] / parts


def either(condition, yes, no):
    """Return the vectors `yes` where a condition holds, else `no`."""
    return (
        where(condition, yes[0], no[0]),
        where(condition, yes[1], no[1]),
        where(condition, yes[2], no[2]),
    )


def near_one(v):
    """Return vectors divided by powers of two, so that their sizes are near 1, and the exponents.

    No digit changes by that, and squares neither over- nor underflow.
    """
    x, y, z = v
    power = power_above(larger(larger(abs(x), abs(y)), abs(z)))
    # The greatest component decides, so that no other one can overflow.
    return (scaled(x, -power), scaled(y, -power), scaled(z, -power)), power


def unit_and_speed(direction):
    """Return the unit vectors along directions, none of which is zero, and their lengths."""
    along, power = near_one(direction)
    speed = lengths(along)
    return shares(along, speed), scaled(speed, power)
