"""Examples for the room milling: a saddle, small enough for few steps, and a mill that fits it."""

import numpy as np

from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    CylinderMill,
    Patch,
    TiltingTable,
    cover,
    find_positions,
    find_scallops,
    plan_tour,
    strip_across,
    touch_twice,
    trace_chains,
)
from tunneller_lib.milling.chains import Chain
from tunneller_lib.milling.coverage import Coverage
from tunneller_lib.milling.nurbs import Nurbs
from tunneller_lib.milling.positions import Positions
from tunneller_lib.milling.scallops import Scallops
from tunneller_lib.milling.sweep import Strip
from tunneller_lib.milling.tangency import TwoContacts
from tunneller_lib.milling.tour import Tour


def saddle(s, t):
    return [s, t, 30 * s * t]


LINE = np.linspace(0, 1, 4)
KNOTS = [0.0] * 4 + [1.0] * 4
SURFACE = {"control": np.stack(np.broadcast_arrays(LINE[:, None], LINE, 0.0), axis=-1),
           "knots_s": KNOTS, "knots_t": KNOTS}  # fmt: skip
GRID = np.stack(np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), [0.1]), axis=-1)[:, :, 0]
PATCH = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
SIZES = {"half_angle": 0.2, "tip_radius": 0.01, "length": 0.2, "holder_radius": 0.03,
         "holder_length": 0.05}  # fmt: skip
MILL = ConicalMill(**SIZES)
LOOK = {"tolerance": 1e-4, "n": 11}
STARTS = find_positions(PATCH, MILL, 0.003, 0.001, **LOOK)
CHAIN = trace_chains(PATCH, MILL, STARTS, step=1e-3, **LOOK)[0]
WAY = {"mill": MILL, "tip": CHAIN.tip, "axis": CHAIN.axis}
COVERED = cover(PATCH, MILL, STARTS, step=1e-3, most=1, **LOOK)
TABLE = {"pivot": (0, 0, -0.1), "up": (0, 0, 1), "x": (-1, 1), "y": (-1, 1), "z": (-1, 1),
         "tilt": (-2, 2), "turn": (-7, 7), "most_turn": 0.5}  # fmt: skip
MACHINE = TiltingTable(**TABLE)
TOUR = {"chains": COVERED.chains, "machine": MACHINE, "clearance": 0.01} | LOOK

INSTANCES = {
    BallMill: BallMill(0.005),
    Chain: CHAIN,
    ConicalMill: MILL,
    Coverage: COVERED,
    CylinderMill: CylinderMill(0.005, 0.02),
    Nurbs: Nurbs(**SURFACE),
    Patch: PATCH,
    Positions: STARTS,
    Scallops: find_scallops(PATCH, MILL, COVERED),
    Strip: strip_across(PATCH, MILL, CHAIN, CHAIN.tip, CHAIN.axis, reach=0.005, m=5),
    TiltingTable: MACHINE,
    TwoContacts: touch_twice(PATCH, MILL, CHAIN, apart=1e-3, n=11),
    Tour: plan_tour(PATCH, MILL, **TOUR),
}

CALLS = {
    "ConicalMill": SIZES,
    "Nurbs": SURFACE,
    "Patch": {"surface": saddle, "s": (-0.01, 0.01), "t": (-0.01, 0.01)},
    "cover": {"found": STARTS, "step": 1e-3, "most": 1} | LOOK,
    "TiltingTable": TABLE,
    "TiltingTable.beyond": {"values": [[0.0, 0.0, 0.0, 0.1, 0.2]]},
    "TiltingTable.positions": {"values": [[0.0, 0.0, 0.0, 0.1, 0.2]]},
    "TiltingTable.values": {"tip": CHAIN.tip, "axis": CHAIN.axis},
    "find_positions": {"s": 0.003, "t": 0.001} | LOOK,
    "find_scallops": {"mill": MILL, "covered": COVERED},
    "fit_nurbs": {"points": GRID, "s": np.arange(9.0), "t": np.arange(9.0), "count": 6},
    "moved": {"tip": CHAIN.tip, "axis": CHAIN.axis},
    "plan_tour": TOUR,
    "strip_across": WAY | {"reach": 0.005, "m": 5},
    "sweep_error": WAY | {"between": 2},
    "touch_twice": {"chain": CHAIN, "apart": 1e-3, "n": 11},
    "trace_chains": {"step": 1e-3, "most": 3} | LOOK,
}
