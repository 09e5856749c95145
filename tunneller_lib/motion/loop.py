"""A position loop: gains, period, delay, encoder and valve."""

from dataclasses import dataclass

from ..arguments import Number, Whole, checked
from .quantities import Quantity, Quantity0, Tick

MOST_DELAY = 100  # ticks; each is a row of the loop's matrix


@dataclass(frozen=True)
@checked
class Loop:
    """A sampled position loop with encoder and valve: wanted rate = Kv e + Ki (integral of e).

    Parameters
    ----------
    gain : float
        Kv in 1/s: wanted rate over following error. The document's controller gain is Kv / K.
    tick : float
        Sampling period, in s.
    integral : float
        Ki in 1/s^2; 0 for a P loop. The sum waits while the valve is fully open.
    feedforward : float
        Share of the exact slope of the set-values that is added to the wanted rate, 0 to 2.
    delay : int
        Whole ticks between the measurement and the command that answers it, up to 100.
    count : float
        Angle of an encoder count, in rad; 0 for an ideal encoder.
    limit : float
        Largest command; 1 is the fully open valve.
    dead_band : float
        Share of full command in which the valve stays shut, below 1.
    compensated : bool
        Whether the command jumps over the dead band.

    Raises
    ------
    ValueError
        If a number is beyond its range.
    """

    gain: Quantity
    tick: Tick
    integral: Quantity0 = 0.0
    feedforward: Number(0.0, 2.0) = 0.0
    delay: Whole(0, MOST_DELAY) = 0
    count: Number(1e-15, 1e9, or_zero=True) = 0.0
    limit: Quantity = 1.0
    dead_band: Number(0.0, 0.99) = 0.0
    compensated: bool = False
