"""Shapes: the torus of the cutter's centre, the cone, the rod, the sewer section,
the machine."""

from .cone import Cone
from .egg import Egg
from .machine import REFERENCE_MACHINE, Machine
from .rod import Rod, meet_rods
from .torus import Torus

__all__ = ["REFERENCE_MACHINE", "Cone", "Egg", "Machine", "Rod", "Torus", "meet_rods"]
