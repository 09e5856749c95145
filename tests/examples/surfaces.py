"""Examples for the room surfaces."""

import numpy as np

from tunneller_lib.surfaces import (
    REFERENCE_MACHINE,
    Arc,
    Body,
    Box,
    Cone,
    Egg,
    Frustum,
    Line,
    Machine,
    Rod,
    Section,
    Torus,
)
from tunneller_lib.surfaces.linkage import Linkage, usual_linkages
from tunneller_lib.surfaces.solid import Solid

_ROD = Rod((0, 0, 0), (4, 0, 1), 1)

INSTANCES = {
    Arc: Arc(0.0, 0.0, 0.5, 0.0, 1.0),
    Body: Body(1.2, 0.3, -0.2, 0.1),
    Box: Box((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)),
    Cone: Cone(0.5),
    Frustum: Frustum((0, 0, 0), (0, 0, 2), 1, 0.5),
    Line: Line(0.0, 0.0, 0.3, 1.0),
    Linkage: usual_linkages(REFERENCE_MACHINE.R)[0],
    Machine: REFERENCE_MACHINE,
    Rod: _ROD,
    Section: Egg(0.5),
    Solid: _ROD,
    Torus: Torus(0.08, 0.8),
}

CALLS = {
    "Egg.offset": {"d": 0.2},
    "Linkage.check": {"low": -0.3, "high": 0.3},
    "Linkage.volumes": {"angle": 0.1, "low": -0.3, "high": 0.3},
    "Section.offset": {"d": 0.1},
    "Torus.meet_line": {"b": (1.0, 2.0, 3.0)},
    "closed_profile": {"pieces": [Arc(0.0, 0.0, 0.5, 0.0, 2 * np.pi)]},
    "meet_box": {"rod": _ROD, "low": (0.1, 0.1), "high": (0.3, 0.4)},
}  # fmt: skip
