"""Flank milling with cones: from a surface to positions of a tool, to paths and to what they leave.

After Envelopes, section 6 and its outlook. Surfaces come as control points and knots, as measured
points, or as any function of two variables.
"""

from .chains import trace_chains
from .coverage import cover, coverage_of
from .five_axes import TiltingTable
from .motion import moved
from .nurbs import fit_nurbs
from .patch import Patch
from .positions import find_positions
from .random_envelopes import random_envelope
from .scallops import find_scallops
from .sweep import ball_positions, cylinder_positions, strip_across, sweep_error
from .tangency import touch_seam, touch_twice
from .tools import BallMill, ConicalMill, CylinderMill
from .tour import plan_tour

__all__ = [
    "BallMill",
    "ConicalMill",
    "CylinderMill",
    "Patch",
    "TiltingTable",
    "ball_positions",
    "cover",
    "coverage_of",
    "cylinder_positions",
    "find_positions",
    "find_scallops",
    "fit_nurbs",
    "moved",
    "plan_tour",
    "random_envelope",
    "strip_across",
    "sweep_error",
    "touch_seam",
    "touch_twice",
    "trace_chains",
]
