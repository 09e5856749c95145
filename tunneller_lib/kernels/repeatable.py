"""Elementary functions of a float whose bits are the same everywhere, in plain Python or compiled.

They are made of sums, products, quotients and roots in a fixed order. The functions of the C
library, of numpy and of compilers differ in their last bits, and also from processor to processor.
Each value here is right to two roundings.
"""

import math

import numpy as np

from .elementwise import power_above, square_root, two_to, within

WHOLE = 1.5 * 2.0**52  # adding and subtracting it rounds to a whole number
FAR = 2.0**21  # rad, up to which products of whole turns with _HALF_PI are exact

# Numbers in parts, from the greatest down. All but the last have so few bits that their products
# with small whole numbers are exact.
_HALF_PI = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
_LOG2 = 0.6931471803691238, 1.9082149292705877e-10
_PER_LOG2 = 1.4426950408889634  # 1 / log(2), as a number, for libraries' logarithms differ

_FRACTIONS = [1 / math.factorial(k) for k in range(19)]
_E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12, _E13 = _FRACTIONS[2:14]
_S3, _S5, _S7, _S9, _S11, _S13, _S15, _S17 = (
    (-1) ** k * _FRACTIONS[2 * k + 1] for k in range(1, 9)
)
_C4, _C6, _C8, _C10, _C12, _C14, _C16, _C18 = ((-1) ** k * _FRACTIONS[2 * k] for k in range(2, 10))
_A3, _A5, _A7, _A9, _A11, _A13, _A15, _A17, _A19, _A21 = (1 / k for k in range(3, 22, 2))


def growth(x):
    """Return exp(x) - 1 for x from 0 to 700, to its last digits however small x is."""
    # exp(x) = 2^power exp(r), with |r| at most half of log 2.
    power = (x * _PER_LOG2 + WHOLE) - WHOLE
    r = (x - power * _LOG2[0]) - power * _LOG2[1]
    high = ((((_E13 * r + _E12) * r + _E11) * r + _E10) * r + _E9) * r + _E8
    rest = ((((((high * r + _E7) * r + _E6) * r + _E5) * r + _E4) * r + _E3) * r + _E2) * (r * r)
    scale = two_to(power + WHOLE)
    # scale - 1 is exact, and zero where x is small: there the sum keeps all digits of r + rest.
    return scale * (r + rest) + (scale - 1)


def area_sine(x):
    """Return the inverse hyperbolic sine of x from 0 to 1e150."""
    # It is log(x + sqrt(1 + x^2)) = log(1 + above), without the 1 that would cost digits of a small
    # x. This is power log(2) + log(1 + left), 1 + above being 2^power (1 + left).
    above = x + x * x / (1 + square_root(1 + x * x))
    # By the factor 0.7, about sqrt(1/2), 1 + left is from 0.71 to 1.43, to both sides of 1.
    power = power_above(0.7 * (1 + above)) + 0.0
    # Where the power of two is 1 itself, `above` has the digits that 1 + above has lost.
    left = above if power == 0 else (1 + above) / two_to(power + WHOLE) - 1
    # log(1 + left) = 2 artanh(s) = 2 (s + s^3/3 + s^5/5 + ...), and |s| is below 0.18.
    s = left / (2 + left)
    z = s * s
    low = (((_A21 * z + _A19) * z + _A17) * z + _A15) * z + _A13
    rest = (((((low * z + _A11) * z + _A9) * z + _A7) * z + _A5) * z + _A3) * z
    return power * _LOG2[0] + (power * _LOG2[1] + (2 * s + 2 * s * rest))


def sine_cosine(x):
    """Return the sine and the cosine of x, from -3.9 to 3.9."""
    quarter = (x * (2 / math.pi) + WHOLE) - WHOLE
    # With pi/2 in three parts no digit of r is lost next to a multiple of it.
    r = ((x - quarter * _HALF_PI[0]) - quarter * _HALF_PI[1]) - quarter * _HALF_PI[2]
    z = r * r
    rest = ((((((_S17 * z + _S15) * z + _S13) * z + _S11) * z + _S9) * z + _S7) * z + _S5) * z
    sine = r + r * z * (rest + _S3)
    rest = ((((((_C18 * z + _C16) * z + _C14) * z + _C12) * z + _C10) * z + _C8) * z + _C6) * z
    cosine = 1 - (z / 2 - z * z * (rest + _C4))
    if abs(quarter) == 1:
        return quarter * cosine, -quarter * sine
    if abs(quarter) == 2:
        return -sine, -cosine
    return sine, cosine


def sine_of(x):
    """Return the sine of any x, in rad."""
    return sine_cosine(within_half_a_turn(x))[0]


def cosine_of(x):
    """Return the cosine of any x, in rad."""
    return sine_cosine(within_half_a_turn(x))[1]


def within_half_a_turn(x):
    """Return an angle x less whole turns, in rad."""
    turns = (x / (2 * math.pi) + WHOLE) - WHOLE
    return ((x - turns * 4 * _HALF_PI[0]) - turns * 4 * _HALF_PI[1]) - turns * 4 * _HALF_PI[2]


def tangent(x):
    """Return the hyperbolic tangent of x, right to three roundings."""
    if abs(x) > 20:  # which differs from 1 by less than a rounding
        return 1.0 if x > 0 else -1.0
    # Lambert's continued fraction, cut off where that is right to rounding, gives it for x / 32.
    a = x / 32
    z = a * a
    t = a * (135135 + z * (17325 + z * (378 + z))) / (135135 + z * (62370 + z * (3150 + z * 28)))
    for _ in range(5):
        t = 2 * t / (1 + t * t)
    return t


def reduced(angle):
    """Return angles (n,), in rad, reduced to -pi to pi by exact multiples of 2 pi.

    They are right to their own last digits, as the sine of a far angle is.
    """
    far = abs(angle) > math.pi
    if not far.any():
        return angle
    turns = (angle / (2 * math.pi) + WHOLE) - WHOLE
    high, middle, low = (4 * part for part in _HALF_PI)
    left = ((angle - turns * high) - turns * middle) - turns * low
    if not (abs(angle) < FAR).all():  # beyond, turns times a part of pi aren't exact
        left = np.where(abs(angle) < FAR, left, np.arctan2(np.sin(angle), np.cos(angle)))
    return np.where(far, within(left, -math.pi, math.pi), angle)


def arctangent(y, x):
    """Return the angle of the direction (x, y), from -pi to pi; zero where both are zero."""
    steep = abs(y) > abs(x)
    big, small = (abs(y), abs(x)) if steep else (abs(x), abs(y))
    # Between 0 and pi/4 now, the angle is turned back by pi/4 where that is nearer, and halved. So
    # it is small, at most about pi/16 to either side, where the series is short.
    nearer = small > 0.4 * big
    across, along = (small - big, small + big) if nearer else (small, big)
    tangent = across / along if big > 0 else across
    tangent = tangent / (1 + square_root(1 + tangent * tangent))
    z = -tangent * tangent
    low = (((_A21 * z + _A19) * z + _A17) * z + _A15) * z + _A13
    rest = (((((low * z + _A11) * z + _A9) * z + _A7) * z + _A5) * z + _A3) * z
    angle = 2 * (tangent + tangent * rest)
    # Back to the octant. Of pi/2 the smaller parts are added first, lest their digits be lost.
    low = _HALF_PI[1] + _HALF_PI[2]
    if nearer:
        angle = _HALF_PI[0] / 2 + (low / 2 + angle)
    if steep:
        angle = _HALF_PI[0] + (low - angle)
    if x < 0:
        angle = 2 * _HALF_PI[0] + (2 * low - angle)
    return -angle if y < 0 else angle
