"""The whole job: plan a cut, run it through controller and axes, and look at the wall it leaves."""

from .clearance import PartClearance, part_clearances
from .cutting import Cut, carve, expected_seconds, simulate, starved
from .error_budget import budget, kind
from .faults import (
    Fault,
    corner_fault,
    count_fault,
    encoder_fault,
    following_fault,
    knot_fault,
    pose_fault,
    ripple_fault,
    setpoint_fault,
    tangent_sphere_fault,
)
from .feed import Limits
from .ground_faults import LoadedLaps, arm_fault, ground_fault, picks_fault
from .margins import Margin, capability, gain_margins
from .moves import Moves
from .planning import Plan, plan
from .pose import Pose
from .sensitivity import trailing
from .wall import lap_volume, overbreak, pass_distance, scallop_height, standing

__all__ = [
    "Cut",
    "Fault",
    "Limits",
    "LoadedLaps",
    "Margin",
    "Moves",
    "PartClearance",
    "Plan",
    "Pose",
    "arm_fault",
    "budget",
    "capability",
    "carve",
    "corner_fault",
    "count_fault",
    "encoder_fault",
    "expected_seconds",
    "following_fault",
    "gain_margins",
    "ground_fault",
    "kind",
    "knot_fault",
    "lap_volume",
    "overbreak",
    "part_clearances",
    "pass_distance",
    "picks_fault",
    "plan",
    "pose_fault",
    "ripple_fault",
    "scallop_height",
    "setpoint_fault",
    "simulate",
    "standing",
    "starved",
    "tangent_sphere_fault",
    "trailing",
]
