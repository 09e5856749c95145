"""Examples for the room milling: a saddle, small enough for few steps, and a mill that fits it."""

from functools import cache

import numpy as np

from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    CylinderMill,
    Patch,
    cover,
    find_positions,
    strip_across,
)
from tunneller_lib.milling.chains import Chain, trace_chain
from tunneller_lib.milling.positions import Positions
from tunneller_lib.milling.strips import Coverage, Strip


def saddle(s, t):
    return [s, t, 30 * s * t]


PATCH = Patch(saddle, (-0.01, 0.01), (-0.01, 0.01))
MILL = ConicalMill(0.2, tip_radius=0.01, length=0.2, holder_radius=0.03, holder_length=0.05)
LOOK = {"tolerance": 1e-4, "n": 11}


@cache
def found():
    return find_positions(PATCH, MILL, 0.003, 0.001, **LOOK)


@cache
def chain():
    row = int(np.flatnonzero(found().fits)[0])
    return trace_chain(PATCH, MILL, found(), row, step=3e-3, **LOOK)


@cache
def covered():
    return cover(PATCH, MILL, found(), step=3e-3, most=1, **LOOK)


INSTANCES = {
    BallMill: BallMill(0.005),
    Chain: chain,
    ConicalMill: MILL,
    Coverage: covered,
    CylinderMill: CylinderMill(0.005, 0.02),
    Patch: PATCH,
    Positions: found,
    Strip: lambda: strip_across(PATCH, MILL, chain(), reach=0.005, m=5),
}

CALLS = {
    "coverage_of": lambda: {"mill": MILL, "chains": covered().chains, "n": 11},
    "cover": lambda: {"found": found(), "step": 3e-3, "most": 1} | LOOK,
    "find_positions": {"s": 0.003, "t": 0.001} | LOOK,
    "find_scallops": lambda: {"mill": MILL, "chains": covered().chains},
    "strip_across": lambda: {"mill": MILL, "chain": chain(), "reach": 0.005, "m": 5},
    "sweep_error": lambda: {"mill": MILL, "chain": chain()},
    "trace_chain": lambda: {"found": found(), "row": 0, "step": 3e-3, "most": 3} | LOOK,
}
