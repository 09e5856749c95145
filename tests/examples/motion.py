"""Examples for the room motion."""

import numpy as np

from tunneller_lib.motion import (
    Compressible,
    Integrator,
    Lag,
    Loop,
    Resonance,
    Rigid,
    follow,
    reference_axes,
)
from tunneller_lib.motion.arm import Arm
from tunneller_lib.motion.hydraulics import Hydraulics
from tunneller_lib.motion.plant import LinearPlant, Plant, ValveResonance
from tunneller_lib.motion.servo import Track
from tunneller_lib.motion.sizing import Sizes, usual_sizes
from tunneller_lib.motion.tasks import Task
from tunneller_lib.surfaces import REFERENCE_MACHINE

THETA, PHI = reference_axes(REFERENCE_MACHINE)
TASKS = [Task("line", 5000, 400), Task("servo", 5000, 600), Task("watch", 20_000, 1500)]
RAMP = np.linspace(0.0, 0.1, 30)

INSTANCES = {
    Arm: Arm(0.08, 0.80, head=30.0, beam=60.0),
    Compressible: Compressible(PHI),
    Hydraulics: THETA,
    Lag: Lag(0.5, 0.02),
    LinearPlant: Lag(0.5, 0.02),
    Plant: Lag(0.5, 0.02),
    Loop: Loop(10.0, 0.005),
    Resonance: Resonance(0.5, 100.0, 0.15),
    Rigid: Rigid(THETA),
    Sizes: usual_sizes(REFERENCE_MACHINE),
    Task: TASKS[0],
    Track: follow(Integrator(0.5), Loop(10.0, 0.005), RAMP),
    ValveResonance: ValveResonance(0.5, 0.5, 100.0, 0.15, 0.004),
}

OILY = {"plant": INSTANCES[Compressible]}
SEGMENTS = {"tasks": TASKS, "costs": [10_000, 20_000, 5000], "ticks": [9, 10, 5]}

CALLS = {
    "Hydraulics.loaded": {"angle": 0.1, "rate": 0.2, "torque": 100.0, "opened": 0.8},
    "Track.between": {"first": 1, "last": 3},
    "follow": {"plant": INSTANCES[Rigid], "loop": INSTANCES[Loop], "setvalues": RAMP},
    "polyline": {"knots": [[0, 0], [3, -2], [3, 5]], "ticks": [2, 3]},
    "polyline_slopes": {"knots": [[0, 0], [3, -2], [3, 5]], "ticks": [2, 3]},
    "stability.gain_limit": OILY,
    "stability.stable_gains": OILY,
    "stability.is_stable": OILY | {"angles": (0.0, 0.1)},
    "tasks.background_response": {"tasks": TASKS, "cost": 10_000},
    "tasks.buffer_depth": SEGMENTS,
    "tasks.hand_over": SEGMENTS,
    "tasks.response_times": {"tasks": TASKS},
    "tasks.schedule": {"tasks": TASKS, "horizon": 100_000},
    "tasks.utilisation": {"tasks": TASKS},
    "tick_counts": {"times": [0.0, 0.5, 1.1]},
}
