"""The whole job: plan a cut, run it through controller and axes, and look at the wall it leaves."""

from .feed import Limits
from .plan import Plan, Pose, plan
from .simulate import Cut, simulate
from .wall import overbreak, scallop_height, standing

__all__ = [
    "Cut",
    "Limits",
    "Plan",
    "Pose",
    "overbreak",
    "plan",
    "scallop_height",
    "simulate",
    "standing",
]
