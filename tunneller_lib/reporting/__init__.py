"""What notebooks use to show and to record: needs the study's environment, not only numpy."""

from .chapters import ending
from .interactive import sliders
from .moving import moving_picture
from .number_format import in_words
from .record import Record, preview
from .style import COLOURS, ERROR_MAP, figure

# The modules are imported where they are asked for: those of scenes take VTK a second.
__all__ = [
    "COLOURS",
    "ERROR_MAP",
    "Record",
    "blade_scene",
    "chapters",
    "cone_plot",
    "cone_scene",
    "ending",
    "envelope_plot",
    "figure",
    "geodesic_plot",
    "groove_plot",
    "in_words",
    "machine_plot",
    "machine_scene",
    "motion_plot",
    "moving_picture",
    "path_plot",
    "path_scene",
    "plot",
    "preview",
    "response_plot",
    "rod_plot",
    "scene",
    "six_cones_scene",
    "sliders",
    "surface_scene",
    "torus_scene",
    "tunnel_scene",
    "wall_plot",
]
