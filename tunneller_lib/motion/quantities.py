"""What the sizes, gains and times of axes and loops may be, said for annotations.

The ranges are far wider than any machine's; within them no product of a few overflows and no
power of a loop's matrix does.
"""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import (
    Rule,
    as_array,
    bounded_array,
    none_beyond,
    not_negative,
    positive,
    real,
    rule_of,
    shown,
)

LEAST, MOST = 1e-9, 1e9  # of gains, frequencies, damping ratios and times


def Number(low, high, *, unit="", or_zero=False):
    """Return the annotation of one number from `low`, above zero, to `high`.

    `or_zero` lets zero pass; `unit` is what docstrings have to name.
    """
    also = "0 or " if or_zero else ""

    def check(name, value):
        if type(value) is float and low <= value <= high:  # as nearly always: the short way
            return value
        number = (not_negative if or_zero else positive)(name, value)
        if not (low <= number <= high or (or_zero and number == 0)):
            raise ValueError(f"{name}: must be {also}from {low:g} to {high:g}; got {shown(value)}.")
        return number

    return Annotated[float, Rule("float", check, unit)]


def _share(most):
    def check(name, value):
        number = not_negative(name, value)
        if number > most:
            raise ValueError(f"{name}: must be from 0 to {most:g}; got {shown(value)}.")
        return number

    return check


def Share(most):
    """Return the annotation of one number from 0 to `most`."""
    return Annotated[float, Rule("float", _share(most))]


def _ticks(name, value):
    array = bounded_array(name, value)
    wrong = ~((array >= LEAST) & (array <= MOST))
    if wrong.any():
        raise ValueError(
            f"{name}: must be from {LEAST:g} to {MOST:g} s, above zero; got {array[wrong][0]:g} s."
        )
    return array


def moderate_array(name, value):
    """Return `value` as a float array (...) of numbers not above 1e15 in size."""
    array = real(name, value)
    if not none_beyond(array, 1e15):
        bounded_array(name, array)
        raise ValueError(
            f"{name}: must hold numbers of at most 1e15 in size; got {np.abs(array).max():g}."
        )
    return array


def _torque(name, value):
    number = moderate_array(name, value)
    if number.ndim:
        raise ValueError(f"{name}: must be one number; got {shown(value)}.")
    return float(number)


def _complex_frequencies(name, value):
    array = as_array(value)
    if array.dtype.kind not in "iufc":
        raise ValueError(f"{name}: must hold numbers in a regular array; got {shown(value)}.")
    with np.errstate(over="ignore"):
        array = array.astype(complex)
        size = np.abs(array)
    wrong = ~((size >= 1e-50) & (size <= 1e50))
    if wrong.any():
        raise ValueError(
            f"{name}: must be from 1e-50 to 1e50 rad/s in size; got {array[wrong][0]:g}."
        )
    return array


def one_or_each(*kinds):
    """Return the annotation of one object of some classes, or of a sequence, one for each axis."""
    says = " or ".join(kind.__name__ for kind in kinds)

    def check(name, value):
        if isinstance(value, kinds):
            return value
        if not isinstance(value, (list, tuple)):
            raise ValueError(f"{name}: must be of class {says}, or a list; got {shown(value)}.")
        for i, one in enumerate(value):
            if not isinstance(one, kinds):
                raise ValueError(f"{name}[{i}]: must be of class {says}; got {shown(one)}.")
        return tuple(value)

    return Annotated[object, Rule(f"{says} or a list of them", check)]


def Pair(*kinds):
    """Return the annotation of a pair, theta's and phi's, of instances of some classes.

    One alone is taken twice.
    """
    one_or_two = rule_of(one_or_each(*kinds))

    def check(name, value):
        found = one_or_two.check(name, value)
        pair = found if isinstance(found, tuple) else (found, found)
        if len(pair) != 2:
            raise ValueError(f"{name}: must be two, theta's and phi's; got {len(pair)}.")
        return pair

    return Annotated[tuple, Rule(f"{', '.join(kind.__name__ for kind in kinds)} or a pair", check)]


Quantity = Number(LEAST, MOST)
Quantity0 = Number(LEAST, MOST, or_zero=True)
Tick = Number(LEAST, MOST, unit="s")
Ticks = Annotated[ArrayLike, Rule("(...) float", _ticks, "s")]
Size = Number(1e-15, 1e15)  # of hydraulics, whose SI units are far apart: Pa, m^3, m^3/s/Pa^0.5
Size0 = Number(1e-30, 1e15, or_zero=True)
Torque = Annotated[float, Rule("float", _torque, "N m")]
ComplexFrequencies = Annotated[ArrayLike, Rule("(...) complex", _complex_frequencies, "rad/s")]
