"""Motion: set-values in whole counts, the hydraulic axes and their loops, tasks, exports."""

from .hydraulics import Hydraulics, reference_axes
from .interpolate import polyline, polyline_slopes, tick_counts, time_bresenham
from .oil import Compressible, Rigid
from .plant import Integrator, Lag, Resonance
from .ramp import rest_to_rest
from .servo import Loop, simulate

__all__ = [
    "Compressible",
    "Hydraulics",
    "Integrator",
    "Lag",
    "Loop",
    "Resonance",
    "Rigid",
    "polyline",
    "polyline_slopes",
    "reference_axes",
    "rest_to_rest",
    "simulate",
    "tick_counts",
    "time_bresenham",
]
