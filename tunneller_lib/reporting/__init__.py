"""What notebooks use to show and to record: needs the study's environment, not only numpy."""

from importlib import import_module

# What is below is imported where it is asked for: matplotlib and VTK take a second.
_FROM = {
    "COLOURS": "style",
    "ERROR_MAP": "style",
    "Record": "record",
    "ending": "chapters",
    "figure": "style",
    "in_words": "number_format",
    "moving_picture": "moving",
    "preview": "record",
    "sliders": "interactive",
}
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
    "flank_scene",
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
    "rod_plot",
    "scene",
    "six_cones_scene",
    "sliders",
    "surface_scene",
    "torus_scene",
    "tunnel_scene",
]


def __getattr__(name):
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_FROM[name]}", __name__), name)
