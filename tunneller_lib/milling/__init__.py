"""Flank milling with cones: from a surface to positions of a tool, to paths and to what they leave.

After Envelopes, section 6 and its outlook. Surfaces come as control points and knots, as measured
points, or as any function of two variables.
"""

from .chains import Chain, trace_chains
from .coverage import Coverage, cover
from .motion import moved
from .nurbs import Nurbs, fit_nurbs
from .patch import Patch
from .positions import Positions, find_positions
from .sweep import Strip, ball_positions, cylinder_positions, strip_across, sweep_error
from .tools import BallMill, ConicalMill, CylinderMill

__all__ = [
    "BallMill",
    "Chain",
    "ConicalMill",
    "Coverage",
    "CylinderMill",
    "Nurbs",
    "Patch",
    "Positions",
    "Strip",
    "ball_positions",
    "cover",
    "cylinder_positions",
    "find_positions",
    "fit_nurbs",
    "moved",
    "strip_across",
    "sweep_error",
    "trace_chains",
]
