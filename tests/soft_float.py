"""Floating point as a processor without a unit for it computes: in whole numbers, counted.

`Counted` is a whole number that counts the operations of its kind, `add` the sum of two numbers of
IEEE 754 single precision, by their bits: normal numbers and zero, rounded to nearest even.
"""

import numpy as np


class Counted(int):
    """A whole number; each operation and comparison adds one to `Counted.operations`."""

    operations = 0


def _counting(name):
    plain = getattr(int, name)

    def operation(self, other):
        Counted.operations += 1
        result = plain(self, other)
        return result if isinstance(result, bool) else Counted(result)

    return operation


for _name in ("add", "sub", "and", "or", "xor", "lshift", "rshift", "eq", "lt", "gt", "ge"):
    setattr(Counted, f"__{_name}__", _counting(f"__{_name}__"))


def bits(number):
    """Return a number's bits in single precision."""
    return Counted(np.float32(number).view(np.uint32))


def value(pattern):
    """Return the number that bits stand for."""
    return np.uint32(pattern).view(np.float32)


def greater(a, b):
    """Return whether a > b, by their bits."""
    if a >> 31:
        return bool(b >> 31) and b > a
    return bool(b >> 31) or a > b


def add(a, b):
    """Return the bits of a + b."""
    if (b & 0x7FFFFFFF) > (a & 0x7FFFFFFF):
        a, b = b, a
    if not b & 0x7FFFFFFF:
        return a
    exponent, gap = (a >> 23) & 255, ((a >> 23) & 255) - ((b >> 23) & 255)
    first = ((a & 0x7FFFFF) | 0x800000) << 3
    second = ((b & 0x7FFFFF) | 0x800000) << 3
    if gap:
        lost = gap > 26 or second & ((Counted(1) << gap) - 1)
        second = Counted(bool(lost)) if gap > 26 else (second >> gap) | bool(lost)
    total = first - second if (a ^ b) >> 31 else first + second
    if not total:
        return Counted(0)
    if total >= 1 << 27:
        total, exponent = (total >> 1) | (total & 1), exponent + 1
    while total < 1 << 26:
        total, exponent = total << 1, exponent - 1
    rest, total = total & 7, total >> 3
    if rest > 4 or (rest == 4 and total & 1):
        total = total + 1
        exponent = exponent + (total >> 24)
    return (a & 0x80000000) | (exponent << 23) | (total & 0x7FFFFF)
