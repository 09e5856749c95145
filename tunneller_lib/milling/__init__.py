"""What conical mills in third-order contact leave of a surface: positions, strips, scallops.

After Envelopes, section 6 and its outlook. A surface is any function of two variables that
`envelopes` takes, such as the blades of a `BladeRing`.
"""

from .faces import BladeRing, Patch
from .positions import find_positions
from .strips import ball_chain, cover, coverage_of, cylinder_chain, find_scallops, strip_across
from .tools import BallMill, ConicalMill, CylinderMill

__all__ = [
    "BallMill",
    "BladeRing",
    "ConicalMill",
    "CylinderMill",
    "Patch",
    "ball_chain",
    "cover",
    "coverage_of",
    "cylinder_chain",
    "find_positions",
    "find_scallops",
    "strip_across",
]
