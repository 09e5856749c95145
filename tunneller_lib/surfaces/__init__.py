"""Shapes: the cutter's torus, cone, rod, frustum, box, sewer section, machine, its cylinders."""

from .box import Box
from .cone import Cone
from .egg import Egg
from .frustum import Frustum
from .machine import REFERENCE_MACHINE, Body, Machine
from .rod import Rod
from .rod_box import meet_box
from .section import Arc, Line, Section, closed_profile
from .torus import Torus

__all__ = [
    "REFERENCE_MACHINE",
    "Arc",
    "Body",
    "Box",
    "Cone",
    "Egg",
    "Frustum",
    "Line",
    "Machine",
    "Rod",
    "Section",
    "Torus",
    "closed_profile",
    "meet_box",
]
