"""What the sizes, gains and times of axes and loops may be, said for annotations.

The ranges are far wider than any machine's; within them no product of a few overflows and no
power of a loop's matrix does.
"""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Each, Number, Rule, as_array, rule_of, shown

LEAST, MOST = 1e-9, 1e9  # of gains, frequencies, damping ratios and times


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


def Pair(kind):
    """Return the annotation of a pair, theta's and phi's, of instances of a class.

    One alone is taken twice.
    """
    one_or_each = rule_of(Each(kind, or_one=True))

    def check(name, value):
        found = one_or_each.check(name, value)
        pair = found if isinstance(found, tuple) else (found, found)
        if len(pair) != 2:
            raise ValueError(f"{name}: must be two, theta's and phi's; got {len(pair)}.")
        return pair

    return Annotated[tuple, Rule(f"{kind.__name__} or a pair", check)]


Quantity = Number(LEAST, MOST)
Quantity0 = Number(LEAST, MOST, or_zero=True)
Tick = Number(LEAST, MOST, "s")
Ticks = Array("(...) float", "s", low=LEAST, high=MOST)
Size = Number(1e-15, 1e15)  # of hydraulics, whose SI units are far apart: Pa, m^3, m^3/s/Pa^0.5
Size0 = Number(1e-30, 1e15, or_zero=True)
Torque = Number(-1e15, 1e15, "N m")
ComplexFrequencies = Annotated[ArrayLike, Rule("(...) complex", _complex_frequencies, "rad/s")]
moderate_array = rule_of(Array("(...) float", low=-1e15, high=1e15)).check


def Share(most):
    """Return the annotation of one number from 0 to `most`."""
    return Number(0.0, most)
