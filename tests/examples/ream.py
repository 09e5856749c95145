"""Examples for the room ream: a coarse plan, whose every lap is a hundred ticks."""

import numpy as np

from tunneller_lib.motion import Compressible, Integrator, Loop, reference_axes
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Case, Limits, Pose, carve, plan, simulate
from tunneller_lib.ream.cutting import Cut
from tunneller_lib.ream.error_budget import Fault
from tunneller_lib.ream.planning import Plan
from tunneller_lib.ream.route import Route, route_through
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
AXES = reference_axes(REFERENCE_MACHINE)
LIMITS = Limits(feed=0.5, acceleration=0.5, flow=1e-4, valve=0.5, axes=AXES)
COARSE = {"tolerance": 0.02, "step": 0.1, "tick": 0.05, "rest": 0.2}
PLAN = plan(CIRCUIT, LIMITS, laps=2, advance=0.05, **COARSE)
IDEAL = CIRCUIT.position(PLAN.places)
CUT = carve(PLAN, IDEAL, shape=(6, 12))
AXIS = {"plant": Integrator(0.5), "loop": Loop(5.0, 0.05)}
OILY = {"plant": [Compressible(axis) for axis in AXES], "loop": Loop(5.0, 0.05)}
TASKS = {"tasks": [Task("line", 50_000, 400)], "cost": 60}
MOVES = {"lengths": [0.1, 0.2], "positions": np.zeros((3, 2)), "ground": [0.001, 0.002]}

INSTANCES = {
    Case: Case(PLAN, **OILY),
    Cut: CUT,
    Fault: Case(PLAN).fault("knots"),
    Limits: LIMITS,
    Plan: PLAN,
    Pose: Pose(y=1e-3),
    Route: route_through(CIRCUIT, PLAN.knots),
}

CALLS = {
    "Case.fault": {"source": "knots"},
    "Limits.bounds": MOVES,
    "Limits.profile": MOVES,
    "Plan.centres": {"position": IDEAL},
    "budget": AXIS,
    "capability": OILY,
    "carve": {"position": IDEAL, "shape": (6, 12)},
    "halving": {"again": lambda what, factor: None},
    "route_through": {"knots": [0.0, 0.5, 1.2, 2.0]},
    "wall.intact_wall": {"start": -0.3, "shape": (6, 12)},
    "wall.lap_volume": {"advance": 0.05},
    # Not the grid that the room removal cuts at:
    "wall.overbreak": {"wall": CUT.wall},
    "wall.standing": {"wall": CUT.wall},
    "plan": COARSE,
    "simulate": AXIS | {"shape": (6, 12)},
    "gain_margins": OILY,
    "starved": TASKS,
    "trailing": AXIS,
    "used": {"plant": AXIS["plant"], "cut": simulate(PLAN, **AXIS, shape=(6, 12))},
}
