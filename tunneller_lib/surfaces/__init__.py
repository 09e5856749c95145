"""Shapes: the cutter's torus, cone, rod, frustum, box, sewer section, machine, its cylinders."""

from .box import Box, meet_boxes
from .cone import Cone
from .cutter import Cutter
from .egg import Egg
from .facet import meet_facets
from .frustum import Frustum, meet_frusta
from .linkage import Linkage, linkages
from .machine import REFERENCE_MACHINE, Body, Machine
from .pieces import Arc, Line
from .rod import Rod, meet_rods
from .rod_box import meet_box
from .rounded_disc import RoundedDisc, meet_rounded_discs
from .section import Section, closed_profile
from .torus import Torus

__all__ = [
    "REFERENCE_MACHINE",
    "Arc",
    "Body",
    "Box",
    "Cone",
    "Cutter",
    "Egg",
    "Frustum",
    "Line",
    "Linkage",
    "Machine",
    "Rod",
    "RoundedDisc",
    "Section",
    "Torus",
    "closed_profile",
    "linkages",
    "meet_box",
    "meet_boxes",
    "meet_facets",
    "meet_frusta",
    "meet_rods",
    "meet_rounded_discs",
]
