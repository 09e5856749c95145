"""The whole job: plan a cut, run it through controller and axes, and look at the wall it leaves."""

from .budget import Fault, budget
from .feed import Limits
from .plan import Plan, Pose, plan
from .simulate import Cut, carve, simulate, starved
from .wall import overbreak, scallop_height, standing

__all__ = [
    "Cut",
    "Fault",
    "Limits",
    "Plan",
    "Pose",
    "budget",
    "carve",
    "overbreak",
    "plan",
    "scallop_height",
    "simulate",
    "standing",
    "starved",
]
