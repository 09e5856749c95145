"""Plants and loops of the two joints: one for both, or one for each."""

from typing import Annotated

from ..arguments import Rule, rule_of
from ..motion import Compressible, Integrator, Lag, Loop, Resonance, Rigid
from ..motion.servo import one_or_each


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
