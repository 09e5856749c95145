"""Examples for the room milling: a saddle, small enough for few steps, and a mill that fits it."""

from functools import cache

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
TABLE = {"pivot": (0, 0, -0.1), "up": (0, 0, 1), "x": (-1, 1), "y": (-1, 1), "z": (-1, 1),
         "tilt": (-2, 2), "turn": (-7, 7), "most_turn": 0.5}  # fmt: skip
MACHINE = TiltingTable(**TABLE)


@cache
def starts():
    return find_positions(PATCH, MILL, 0.003, 0.001, **LOOK)


@cache
def chain():
    return trace_chains(PATCH, MILL, starts(), step=1e-3, **LOOK)[0]


@cache
def covered():
    return cover(PATCH, MILL, starts(), step=1e-3, most=1, **LOOK)


def way():
    return {"mill": MILL} | course()


def course():
    return {"tip": chain().tip, "axis": chain().axis}


def tour():
    return {"chains": covered().chains, "machine": MACHINE, "clearance": 0.01} | LOOK


INSTANCES = {
    BallMill: BallMill(0.005),
    Chain: chain,
    ConicalMill: MILL,
    Coverage: covered,
    CylinderMill: CylinderMill(0.005, 0.02),
    Nurbs: Nurbs(**SURFACE),
    Patch: PATCH,
    Positions: starts,
    Scallops: lambda: find_scallops(PATCH, MILL, covered()),
    Strip: lambda: strip_across(PATCH, chain=chain(), reach=0.005, m=5, **way()),
    TiltingTable: MACHINE,
    TwoContacts: lambda: touch_twice(PATCH, MILL, chain(), apart=1e-3, n=11),
    Tour: lambda: plan_tour(PATCH, MILL, **tour()),
}

CALLS = {
    "ConicalMill": SIZES,
    "Nurbs": SURFACE,
    "Patch": {"surface": saddle, "s": (-0.01, 0.01), "t": (-0.01, 0.01)},
    "coverage_of": lambda: {"mill": MILL, "chains": covered().chains, "n": 11},
    "cover": lambda: {"found": starts(), "step": 1e-3, "most": 1} | LOOK,
    "TiltingTable": TABLE,
    "TiltingTable.beyond": {"values": [[0.0, 0.0, 0.0, 0.1, 0.2]]},
    "TiltingTable.positions": {"values": [[0.0, 0.0, 0.0, 0.1, 0.2]]},
    "TiltingTable.values": course,
    "find_positions": {"s": 0.003, "t": 0.001} | LOOK,
    "find_scallops": lambda: {"mill": MILL, "covered": covered()},
    "fit_nurbs": {"points": GRID, "s": np.arange(9.0), "t": np.arange(9.0), "count": 6},
    "moved": course,
    "plan_tour": tour,
    "strip_across": lambda: way() | {"reach": 0.005, "m": 5},
    "sweep_error": lambda: way() | {"between": 2},
    "touch_seam": lambda: {"chain": chain(), "seam": lambda s, t: s - 0.005} | LOOK,
    "touch_twice": lambda: {"chain": chain(), "apart": 1e-3, "n": 11},
    "trace_chains": {"step": 1e-3, "most": 3} | LOOK,
}
