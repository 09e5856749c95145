"""Flank milling with cones: from a surface to positions of a tool, to paths and to what they leave.

After Envelopes, section 6 and its outlook. Surfaces come as control points and knots, as measured
points, or as any function of two variables.
"""

from .chains import Chain, trace_chains
from .coverage import Coverage, cover
from .five_axes import TiltingTable
from .motion import moved
from .nurbs import Nurbs, fit_nurbs
from .patch import Patch
from .positions import Positions, find_positions
from .scallops import Scallops, find_scallops
from .sweep import Strip, ball_positions, cylinder_positions, strip_across, sweep_error
from .tangency import TwoContacts, touch_twice
from .tools import BallMill, ConicalMill, CylinderMill
from .tour import Tour, plan_tour

__all__ = [
    "BallMill",
    "Chain",
    "ConicalMill",
    "Coverage",
    "CylinderMill",
    "Nurbs",
    "Patch",
    "Positions",
    "Scallops",
    "Strip",
    "TiltingTable",
    "Tour",
    "TwoContacts",
    "ball_positions",
    "cover",
    "cylinder_positions",
    "find_positions",
    "find_scallops",
    "fit_nurbs",
    "moved",
    "plan_tour",
    "strip_across",
    "sweep_error",
    "touch_twice",
    "trace_chains",
]
