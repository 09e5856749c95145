"""Motion: set-values in whole counts, the hydraulic axes and their loops, tasks, exports."""

from . import export, identify, slow_task, stability, tasks
from .hydraulics import Hydraulics, reference_axes
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

__all__ = [
    "Compressible",
    "Hydraulics",
    "Integrator",
    "Lag",
    "Loop",
    "Resonance",
    "Rigid",
    "Track",
    "ValveResonance",
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
]
