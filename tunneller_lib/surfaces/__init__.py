"""Shapes: the torus of the cutter's centre, the cone, the rod, the sewer section,
the machine."""

from .cone import Cone
from .egg import Egg
from .frustum import Frustum
from .machine import REFERENCE_MACHINE, Machine
from .rod import Rod, meet_rods
from .rod_box import meet_box
from .torus import Torus

__all__ = [
    "REFERENCE_MACHINE",
    "Cone",
    "Egg",
    "Frustum",
    "Machine",
    "Rod",
    "Torus",
    "meet_box",
    "meet_rods",
]
