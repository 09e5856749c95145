"""Motion: set-values in whole counts, hydraulic axes and their loops, tasks, exports."""

from . import sizing, stability, tasks
from .both_joints import Push
from .interpolate import polyline, polyline_slopes, rounding_spectrum, tick_counts, time_bresenham
from .oil import Compressible, Rigid
from .plant import Integrator, Lag, Resonance
from .servo import Loop, follow
from .sizing import reference_axes

__all__ = [
    "Compressible",
    "Integrator",
    "Lag",
    "Loop",
    "Push",
    "Resonance",
    "Rigid",
    "follow",
    "polyline",
    "polyline_slopes",
    "reference_axes",
    "rounding_spectrum",
    "sizing",
    "stability",
    "tasks",
    "tick_counts",
    "time_bresenham",
]
