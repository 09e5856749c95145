"""Directions of the cones in contact of order 3 with a graph, of numbers or arrays.

They are the zeros on the circle of the sum of two forms, of degree 3 and 2. In the tangent of half
the angle that sum is a polynomial of degree 6. Between neighbouring zeros of its derivative it has
one zero at most, and so have all derivatives down to the linear one: from there upwards bisection
can't miss a zero, and Newton's steps find it soon.
"""

import math

from ..kernels.elementwise import ratio, some, where
from .binary_forms import product11, replaced2, replaced3

SAME = 2e-5  # rad, zeros nearer than this are one multiple zero
# A trigonometric polynomial of degree 3 is at most 2.21 times the greatest of seven samples,
# from where it falls to 0 over 1/6.63 rad or more: no zero of the polynomial lies beyond 13.3.
FAR = 14.0
_STEPS = 100  # bisection alone needs half of them
_NEAR = 1e-9  # a Newton step as short as this was the last but one
_COSINES = tuple(math.cos(2 * math.pi * j / 7) for j in range(7))
_SINES = tuple(math.sin(2 * math.pi * j / 7) for j in range(7))


def circle_zeros(cubic, square):
    """Return the directions (c, s) of the circle where two forms have the sum 0.

    Parameters
    ----------
    cubic, square : forms of degree 3 and 2
        In c and s.

    Returns
    -------
    directions : tuple of six pairs of (...) float
        Unit vectors.
    multiplicity : tuple of six (...) float
        How many zeros fell together in each, 0 where there is none. Two fall together where the
        Taylor polynomial there says that they are nearer than about `SAME`, be they real or not.
    greatest : (...) float
        The greatest size of the sum at seven places: 0 where it vanishes everywhere.
    """
    # The greatest sample becomes the leading coefficient, so that no zero is lost at infinity.
    greatest = -1.0
    at_c = at_s = 0.0
    for j in range(7):
        size = abs(_sum_at(cubic, square, _COSINES[j], _SINES[j]))
        larger = size > greatest
        greatest = where(larger, size, greatest)
        at_c = where(larger, -_COSINES[j], at_c)
        at_s = where(larger, -_SINES[j], at_s)
    p = _on_a_line(cubic, square, at_c, at_s)
    end = (FAR + 0.0 * greatest, greatest < 0)  # no zero
    ends = (end, end, end, end, end, end)
    first = _derivative(p)
    second = _derivative(first)
    third = _derivative(second)
    fourth = _derivative(third)
    fifth = _derivative(fourth)
    every = (p, first, second, third, fourth, fifth, _derivative(fifth))
    for k in range(5, -1, -1):
        ends = _parted(every[k], every[k + 1], ends)
    directions, multiplicity = _found(every, ends, at_c, at_s)
    return directions, multiplicity, greatest


def _sum_at(cubic, square, c, s):
    three = ((cubic[0] * c + cubic[1] * s) * c + cubic[2] * s * s) * c + cubic[3] * s * s * s
    return three + ((square[0] * c + square[1] * s) * c + square[2] * s * s)


def _on_a_line(cubic, square, c, s):
    """Return the polynomial in the tangent of half the angle from the direction (c, s)."""
    h, k = (c, -s), (s, c)
    squares = (product11(h, h), product11(h, k), product11(k, k))
    a, b, c, d = replaced3(cubic, h, k, squares)
    e, f, g = replaced2(square, squares)
    # Times (1 + x^2)^3, where the cosine is (1 - x^2)/(1 + x^2) and the sine 2 x/(1 + x^2).
    return (
        e + a,
        2 * (f + b),
        4 * (g + c) - (e + 3 * a),
        8 * d - 4 * b,
        4 * (g - c) - (e - 3 * a),
        2 * (b - f),
        e - a,
    )


def _derivative(p):
    return (p[1], 2 * p[2], 3 * p[3], 4 * p[4], 5 * p[5], 6 * p[6], 0.0 * p[6])


def _value(p, x):
    return (((((p[6] * x + p[5]) * x + p[4]) * x + p[3]) * x + p[2]) * x + p[1]) * x + p[0]


def _parted(p, slope, ends):
    """Return `_zero` of p in six intervals between the ascending zeros `ends` of its derivative."""
    return (
        _zero(p, slope, -FAR, ends[0][0]),
        _zero(p, slope, ends[0][0], ends[1][0]),
        _zero(p, slope, ends[1][0], ends[2][0]),
        _zero(p, slope, ends[2][0], ends[3][0]),
        _zero(p, slope, ends[3][0], ends[4][0]),
        _zero(p, slope, ends[4][0], FAR),
    )


def _zero(p, slope, low, high):
    """Return the zero between two places of a polynomial that is monotone there, and True.

    Where it has the same sign at both, return the place where it is smaller in size, and False.
    """
    at_low = _value(p, low)
    at_high = _value(p, high)
    begins_below = at_low < 0
    crosses = begins_below != (at_high < 0)
    end = where(abs(at_high) < abs(at_low), high, low)
    x = 0.5 * (low + high)
    moving = crosses
    for _ in range(_STEPS):
        if not some(moving):
            break
        y = _value(p, x)
        before = begins_below == (y < 0)  # the zero lies after x
        low = where(before, x, low)
        high = where(before, high, x)
        # Newton's step, or bisection where that would leave the interval.
        newton = x - ratio(y, _value(slope, x))
        within = (low <= newton) & (newton <= high)
        after = where(within, newton, 0.5 * (low + high))
        far = abs(after - x) > _NEAR * (1 + abs(x))
        x = where(moving, after, x)
        moving = moving & far
    return where(crosses, x, end), crosses


def _found(every, places, at_c, at_s):
    """Return the directions of zeros near six places, and their multiplicities."""
    a, m, last = _multiple(every, places[0], -2 * FAR)
    b, n, last = _multiple(every, places[1], last)
    c, o, last = _multiple(every, places[2], last)
    d, p, last = _multiple(every, places[3], last)
    e, q, last = _multiple(every, places[4], last)
    f, r, last = _multiple(every, places[5], last)
    return (
        (
            _direction(a, at_c, at_s),
            _direction(b, at_c, at_s),
            _direction(c, at_c, at_s),
            _direction(d, at_c, at_s),
            _direction(e, at_c, at_s),
            _direction(f, at_c, at_s),
        ),
        (m, n, o, p, q, r),
    )


def _multiple(every, place, last):
    """Return a zero near a `place`, how many zeros it is, and the last zero so far.

    `every` holds a polynomial and its derivatives. The greatest term of its Taylor polynomial at
    the distance `SAME` tells how many complex zeros lie about as near (Pellet's theorem): m of
    them if that is the term of order m. Their middle is a simple zero of the derivative of order
    m - 1. A zero that is the same as the last one isn't counted again.
    """
    x, crosses = place
    reach = 0.5 * SAME * (1 + x * x)
    before = _value(every[0], x)
    greatest = abs(before)
    m = 0.0 * greatest
    step = 0.0 * greatest
    factor = 1.0
    for k in range(1, 7):
        factor = factor * reach / k
        value = _value(every[k], x)
        size = abs(value) * factor
        larger = size > greatest
        greatest = where(larger, size, greatest)
        m = where(larger, 1.0 * k, m)
        step = where(larger, ratio(before, value), step)
        before = value
    x = x - step
    is_zero = crosses & (m > 0) | (m > 1)
    return x, where(is_zero & (x - last > reach), m, 0.0), where(is_zero, x, last)


def _direction(x, at_c, at_s):
    """Return the direction with half the angle's tangent x from another."""
    inverse = 1 / (1 + x * x)
    c = (1 - x * x) * inverse
    s = 2 * x * inverse
    return (at_c * c - at_s * s, at_s * c + at_c * s)
