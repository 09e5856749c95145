"""The plants and loops of both joints: one for both, or one for each."""

from ..motion import Loop
from ..motion.plant import Plant
from ..motion.quantities import Pair

Plants = Pair(Plant)
Loops = Pair(Loop)


def check_ticks(plan, loops):
    """Raise ValueError if the tick of a loop isn't the plan's."""
    for loop in loops:
        if loop.tick != plan.tick:
            raise ValueError(
                f"loop: must have the plan's tick of {plan.tick:g} s; got {loop.tick:g} s."
            )


def check_linear(loops):
    """Raise ValueError if a loop has an integral, for which there are no closed forms."""
    if any(loop.integral for loop in loops):
        raise ValueError("loop: must be without integral, which has no closed forms; got one.")
