"""Shapes: the torus of the cutter's centre, cone, sewer section, machine and its cylinders."""

from .cone import Cone
from .egg import Egg
from .linkage import Linkage, linkages
from .machine import REFERENCE_MACHINE, Machine
from .torus import Torus

__all__ = ["REFERENCE_MACHINE", "Cone", "Egg", "Linkage", "Machine", "Torus", "linkages"]
