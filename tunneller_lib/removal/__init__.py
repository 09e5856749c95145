"""What the cutter removes: volumes in closed form, grids of intervals, clearance of solids."""

from . import volume
from .arm_clearance import circuit_clearance, rod_clearance, solid_clearance
from .dexel import DexelGrid
from .ground import Ground
from .volume import removed_volume

__all__ = [
    "DexelGrid",
    "Ground",
    "circuit_clearance",
    "removed_volume",
    "rod_clearance",
    "solid_clearance",
    "volume",
]
