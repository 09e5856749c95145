"""Annotations for the sizes, gains and times of axes and loops.

The ranges are far wider than any machine needs. Within them neither a product of a few quantities
nor a power of a loop's matrix overflows.
"""

from typing import Annotated

from ..arguments import Array, Each, Number, Rule, rule_of

LEAST, MOST = 1e-9, 1e9  # of gains, frequencies, damping ratios and times


def Pair(kind):
    """Return the annotation of a pair of instances of a class, for theta and phi.

    A single instance stands for both.

    Examples
    --------
    >>> pair = rule_of(Pair(float))
    >>> pair.check("lag", 0.1)
    (0.1, 0.1)
    >>> pair.check("lag", [0.1, 0.2, 0.3])
    Traceback (most recent call last):
    ValueError: lag: must be two, theta's and phi's; got 3.
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
Frequencies = Array("(...) float", "rad/s", low=1e-50, high=1e50)
