"""Motion: set-values in whole counts, the hydraulic axes and their loops, tasks, exports."""

from . import export, identify, slow_task, stability, tasks
from .arm import Arm
from .both_joints import Push
from .hydraulics import Hydraulics
from .interpolate import (
    line_ticks,
    polyline,
    polyline_slopes,
    rounding_spectrum,
    tick_counts,
    time_bresenham,
)
from .oil import Compressible, Rigid
from .plant import Integrator, Lag, Resonance, ValveResonance
from .ramp import rest_to_rest, rest_to_rest_ticks
from .servo import Loop, Track, follow
from .sizing import Sizes, arm_of, axes_of, reference_axes, usual_sizes

__all__ = [
    "Arm",
    "Compressible",
    "Hydraulics",
    "Integrator",
    "Lag",
    "Loop",
    "Push",
    "Resonance",
    "Rigid",
    "Sizes",
    "Track",
    "ValveResonance",
    "arm_of",
    "axes_of",
    "export",
    "follow",
    "identify",
    "line_ticks",
    "polyline",
    "polyline_slopes",
    "reference_axes",
    "rest_to_rest",
    "rest_to_rest_ticks",
    "rounding_spectrum",
    "slow_task",
    "stability",
    "tasks",
    "tick_counts",
    "time_bresenham",
    "usual_sizes",
]
