"""What halves a fault of the budget: said only if a run of the fault alone confirms it."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ..arguments import checked, shown
from .faults import Fault

HALF = 0.4, 0.6  # of a fault, what is left where it is called halved
TRIES = 2  # of a factor, the second by the power that the first one showed
FARTHEST = 8  # either way, beyond which a factor is no advice
UNCHANGED = 0.97  # of a fault, from which on what was changed doesn't matter to it


class Remedy(NamedTuple):
    """What halves a fault, as simulated.

    Parameters
    ----------
    what : str
        Is changed: an option of the plan, of its limits or of the loops.
    factor : float
        By which it is multiplied.
    left : float
        Share of the fault that is left.
    """

    what: str
    factor: float
    left: float


@checked
def halving(fault: Fault, again: Callable[[str, float], object]):
    """Return the first of a fault's remedies that halves it, as a simulation confirms.

    Parameters
    ----------
    fault : Fault
        One source of error, alone.
    again : function
        (what, factor) -> `Fault`: the same source alone, with one of its ``remedies`` multiplied by
        a factor; None where that can't be had.

    Returns
    -------
    remedy : Remedy or None
        Its factor has two decimals. None where no remedy leaves from 0.4 to 0.6 of the fault.
    """
    for what, factor in fault.remedies if fault.measured else ():
        for _ in range(TRIES):
            factor = round(factor, 2)
            if not 1 / FARTHEST <= factor <= FARTHEST:
                break
            run = again(what, factor)
            if run is None:
                break
            if not isinstance(run, Fault):
                raise ValueError(f"again: must return a Fault or None; got {shown(run)}.")
            left = run.measured / fault.measured
            if HALF[0] <= left <= HALF[1]:
                return Remedy(what, factor, left)
            if not 0 < left < UNCHANGED:
                break
            factor **= math.log(1 / 2) / math.log(left)
    return None
