"""What the cutter removes: volumes in closed form, grids of intervals, clearance of solids."""

from .arm_clearance import circuit_clearance, rod_clearance, solid_clearance
from .dexel import DexelGrid
from .ground import Ground
from .volume import advance_for_volume, bowl, groove_area, half_lens, removed_volume, ring

__all__ = [
    "DexelGrid",
    "Ground",
    "advance_for_volume",
    "bowl",
    "circuit_clearance",
    "groove_area",
    "half_lens",
    "removed_volume",
    "ring",
    "rod_clearance",
    "solid_clearance",
]
