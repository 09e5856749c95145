"""The whole cut: plan it, run it through controller and axes, and look at the wall it leaves."""

from . import wall
from .clearance import part_clearances
from .cutting import carve, simulate, starved
from .error_budget import Case, budget, halving
from .feed import Limits
from .margins import gain_margins
from .planning import plan
from .pose import Pose
from .sensitivity import trailing

__all__ = [
    "Case",
    "Limits",
    "Pose",
    "budget",
    "carve",
    "gain_margins",
    "halving",
    "part_clearances",
    "plan",
    "simulate",
    "starved",
    "trailing",
    "wall",
]
