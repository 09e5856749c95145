"""Plants and loops of the two joints: one for both, or one for each."""

from typing import Annotated

from ..arguments import Rule, shown
from ..motion import Compressible, Integrator, Lag, Loop, Resonance, Rigid


def Pair(*kinds):
    """Return the annotation of a pair, theta's and phi's, of instances of some classes.

    One alone is taken twice.
    """
    says = ", ".join(kind.__name__ for kind in kinds)

    def check(name, value):
        pair = (value, value) if isinstance(value, kinds) else value
        if not isinstance(pair, (list, tuple)):
            raise ValueError(f"{name}: must be of class {says}, or a pair; got {shown(value)}.")
        if len(pair) != 2:
            raise ValueError(f"{name}: must be two, theta's and phi's; got {len(pair)}.")
        for one in pair:
            if not isinstance(one, kinds):
                raise ValueError(f"{name}: must be of class {says}; got {shown(one)}.")
        return tuple(pair)

    return Annotated[tuple, Rule(f"{says} or a pair", check)]


Plants = Pair(Integrator, Lag, Resonance, Rigid, Compressible)
Loops = Pair(Loop)


def check_ticks(plan, loops):
    """Raise ValueError if the tick of a loop isn't the plan's."""
    for loop in loops:
        if loop.tick != plan.tick:
            raise ValueError(
                f"loop: must have the plan's tick of {plan.tick:g} s; got {loop.tick:g} s."
            )


def check_linear(loops):
    """Raise ValueError if a loop has what the closed forms lack."""
    if any(loop.integral or loop.dead_band for loop in loops):
        raise ValueError(
            "loop: must be without integral and dead band, for which there is no closed form; "
            "got one with."
        )
