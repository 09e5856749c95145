"""Examples for the room ream: a coarse plan, whose every lap is a hundred ticks."""

import numpy as np

from tunneller_lib.motion import Hydraulics, Integrator, Loop, reference_axes
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import Circuit, cutting_circuit
from tunneller_lib.ream import Cut, Fault, Limits, Moves, Plan, Pose, carve, knot_fault, plan
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
AXES = reference_axes(REFERENCE_MACHINE)
LIMITS = Limits(feed=0.5, acceleration=0.5, flow=1e-4, valve=0.5, axes=AXES)
COARSE = {"tolerance": 0.02, "step": 0.1, "tick": 0.05, "rest": 0.2}
PLAN = plan(CIRCUIT, LIMITS, laps=2, advance=0.05, **COARSE)
IDEAL = CIRCUIT.position(PLAN.places)
CUT = carve(PLAN, IDEAL, shape=(6, 12))
AXIS = {"plant": Integrator(0.5), "loop": Loop(5.0, 0.05)}
TASKS = {"tasks": [Task("line", 50_000, 400)], "cost": 60}
MOVES = {"lengths": [0.1, 0.2], "positions": np.zeros((3, 2)), "ground": [0.001, 0.002]}

INSTANCES = {
    Circuit: CIRCUIT,
    Cut: CUT,
    Fault: knot_fault(PLAN),
    Hydraulics: AXES[0],
    Integrator: AXIS["plant"],
    Limits: LIMITS,
    Moves: PLAN.entry,
    Loop: AXIS["loop"],
    Plan: PLAN,
    Pose: Pose(y=1e-3),
    Task: TASKS["tasks"][0],
}

CALLS = {
    "Limits": {"feed": 0.1, "acceleration": 0.5, "axes": AXES},
    "Limits.bounds": MOVES,
    "Limits.profile": MOVES,
    "Plan.centres": {"position": IDEAL},
    "budget": AXIS,
    "carve": {"position": IDEAL, "shape": (6, 12)},
    "encoder_fault": AXIS,
    "expected_seconds": AXIS | {"shape": (6, 12)},
    "following_fault": AXIS,
    "lap_volume": {"advance": 0.05},
    "overbreak": {"wall": CUT.wall},  # not the grid that the room removal cuts at
    "plan": COARSE,
    "scallop_height": {"radius": 0.2, "pitch": 0.1},
    "simulate": AXIS | {"shape": (6, 12)},
    "standing": {"wall": CUT.wall},
    "starved": TASKS,
    "trailing": AXIS,
}
