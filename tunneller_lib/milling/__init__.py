"""What conical mills in third-order contact leave of a surface: positions, strips, scallops.

After Envelopes, section 6 and its outlook. A surface is any function of two variables that
`envelopes` takes: the blades of a `BladeRing`, or a `Nurbs` face by control points and knots.
"""

from .faces import BladeRing, Nurbs, Patch
from .positions import find_positions
from .strips import ball_chain, cover, coverage_of, cylinder_chain, find_scallops, strip_across
from .tools import BallMill, ConicalMill, CylinderMill

__all__ = [
    "BallMill",
    "BladeRing",
    "ConicalMill",
    "CylinderMill",
    "Nurbs",
    "Patch",
    "ball_chain",
    "cover",
    "coverage_of",
    "cylinder_chain",
    "find_positions",
    "find_scallops",
    "strip_across",
]
