"""Examples for the room removal."""

import numpy as np

from tunneller_lib.removal import DexelGrid, Ground
from tunneller_lib.removal.grid import Lines
from tunneller_lib.surfaces import Rod

WALL = DexelGrid.radial(0, 1, 0.5, 0.8, (6, 12))

INSTANCES = {DexelGrid: WALL, Ground: Ground(20e6, 2.0, 0.5, 0.3, 12.0), Lines: WALL.lines}

CALLS = {
    "DexelGrid.cartesian": {"low": (0, 0, 0), "high": (1.0, 2.0, 3.0), "shape": (4, 6)},
    "DexelGrid.cut_moves": {"centres": [(0.5, 0.5, 0), (0.5, 0.5, 0.1)], "radius": 0.2},
    "DexelGrid.cut_path": {"centres": [(0.5, 0.5, 0), (0.5, 0.5, 0.1)], "radius": 0.2},
    "DexelGrid.radial": {"start": 0, "stop": 1, "inner": 0.5, "outer": 0.8, "shape": (4, 6)},
    "arm_clearance.circuit_clearance": {"lowest": -0.3, "highest": 0.4, "arm_radius": 0.1},
    "arm_clearance.solid_clearance": {
        "solid": Rod((0.5, 0, 0.1), (0.6, 0, 0), 0.1),
        "turn": np.eye(3),
    },
}
