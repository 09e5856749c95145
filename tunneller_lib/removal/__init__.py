"""What the cutter removes: volumes in closed form, grids of intervals, clearance of solids."""

from . import arm_clearance, volume
from .dexel import DexelGrid
from .ground import Ground

__all__ = ["DexelGrid", "Ground", "arm_clearance", "volume"]
