"""A position loop: gains, period, delay, encoder and valve."""

from dataclasses import dataclass

from ..arguments import Number, Whole, checked
from .quantities import Quantity, Quantity0, Tick

MOST_DELAY = 100  # ticks; each is a row of the loop's matrix


@dataclass(frozen=True)
@checked
class Loop:
    """A sampled position loop: the wanted rate is Kv e + Ki (integral of e), e the following error.

    Parameters
    ----------
    gain : float
        Kv in 1/s. The paper's controller gain is Kv / K, with the plant's gain K.
    tick : float
        Sampling period, in s.
    integral : float
        Ki in 1/s^2; 0 for a P loop. The integral waits while the valve is fully open.
    feedforward : float
        Share of the set-values' exact slope that is added to the wanted rate, from 0 to 2.
    delay : int
        Whole ticks from a measurement to the command that answers it, up to 100.
    count : float
        Angle of an encoder count, in rad; 0 for an ideal encoder.
    limit : float
        Largest command; at 1 the valve is fully open.

    Raises
    ------
    ValueError
        If a number is beyond its range.

    Examples
    --------
    >>> Loop(10, tick=0.01, delay=101)
    Traceback (most recent call last):
    ValueError: delay: must be one whole number from 0 to 100; got 101.
    """

    gain: Quantity
    tick: Tick
    integral: Quantity0 = 0.0
    feedforward: Number(0.0, 2.0) = 0.0
    delay: Whole(0, MOST_DELAY) = 0
    count: Number(1e-15, 1e9, or_zero=True) = 0.0
    limit: Quantity = 1.0
