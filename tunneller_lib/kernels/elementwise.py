"""One formula for one number and for many: operations on floats and, element by element, on arrays.

Python adds two floats in a thirtieth of the time that it takes to call numpy. A formula made of
sums, products and these functions runs on either, with the same bits. Many callers divide by zero
in a branch that isn't chosen: with arrays they switch numpy's warnings off.
"""

import math

import numpy as np


def where(condition, yes, no):
    """Return `yes` where a condition holds, else `no`."""
    # A comparison of floats gives one of these two, one of arrays an array.
    if condition is True:
        return yes
    if condition is False:
        return no
    return np.where(condition, yes, no)


def smaller(a, b):
    """Return the smaller of two numbers, or NaN if either is."""
    # A comparison with NaN is false: a is asked for by itself, and b is then returned anyway.
    if type(a) is float and type(b) is float:
        return a if a <= b or a != a else b
    return np.minimum(a, b)


def larger(a, b):
    """Return the larger of two numbers, or NaN if either is."""
    if type(a) is float and type(b) is float:
        return a if a >= b or a != a else b
    return np.maximum(a, b)


def within(x, low, high):
    """Return x, or the limit that it is beyond."""
    return smaller(larger(x, low), high)


def square_root(x):
    """Return the square root, which is NaN below zero."""
    if type(x) is float:
        return math.sqrt(x) if x >= 0 else math.nan
    return np.sqrt(x)


def ratio(a, b):
    """Return a / b, which is infinite or NaN where b is zero."""
    if type(a) is float and type(b) is float:
        return a / b if b else a * math.copysign(math.inf, b)
    return np.divide(a, b)


def power_above(x):
    """Return the exponent of the power of two next above a size."""
    return math.frexp(x)[1] if type(x) is float else np.frexp(x)[1]


def scaled(x, power):
    """Return x times a power of two."""
    if type(x) is float and type(power) is int:
        return math.ldexp(x, power)
    return np.ldexp(x, power)


def two_to(shifted):
    """Return 2^n, n from -1022 to 1023, of the float n + 1.5 * 2^52."""
    return math.ldexp(1.0, int(shifted - 1.5 * 2.0**52))


# ---- the same for numbers alone, in loops that may be compiled -------------


def chosen(condition, yes, no):
    """Return `yes` if a condition holds, else `no`."""
    return yes if condition else no


def lesser(a, b):
    """Return the smaller of two numbers, or NaN if one is."""
    return a if a <= b or a != a else b


def greater(a, b):
    """Return the larger of two numbers, or NaN if one is."""
    return a if a >= b or a != a else b


def rooted(x):
    """Return the square root of a number that isn't below zero."""
    # With `math.sqrt` itself in its place, numba's loops would take nearly twice as long.
    return math.sqrt(x)


def quotient(a, b):
    """Return a / b, which is infinite or not a number where b is zero."""
    return a / b if b else a * math.copysign(math.inf, b)


def divided(a, b):
    """Return a / b in a `compiled.loop`, where quotients by zero are as those of arrays."""
    return a / b


def power_in_bits(x):
    """Return the exponent of the power of two next above a number of at least 1e-300."""
    return (np.float64(x).view(np.int64) >> 52) - 1022


def two_to_bits(shifted):
    """Return `two_to` by the bits: the last bits of `shifted` are n, and go into the exponent."""
    return np.int64((np.float64(shifted).view(np.int64) + 1023) << 52).view(np.float64)


# What `compiled.call_plain` puts in their place. The root of a negative number raises ValueError.
PLAIN = {
    "where": chosen,
    "smaller": lesser,
    "larger": greater,
    "square_root": math.sqrt,
    "ratio": quotient,
}
# Numpy's own numbers may be infinite or NaN, where `math.ldexp` and whole numbers end; a compiled
# loop is faster by the bits than by calls of the C library.
IEEE = {"power_above": power_in_bits, "two_to": two_to_bits}
NUMBERS = PLAIN | IEEE | {"square_root": rooted}  # for `compiled.call`
