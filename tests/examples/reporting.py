"""Examples for the room reporting: all but what draws in space or reads the notebooks."""

import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tunneller_lib.envelopes import ConePose, hyperosculating_cones
from tunneller_lib.envelopes.families import cyclide, ruled, saddle
from tunneller_lib.envelopes.hyperosculate import Cones
from tunneller_lib.motion import Integrator, Loop
from tunneller_lib.motion.tasks import HandOver, Task
from tunneller_lib.paths import ConeChord
from tunneller_lib.ream.cutting import Cut
from tunneller_lib.removal import DexelGrid
from tunneller_lib.reporting import Record, figure
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Machine, Rod, Section, Torus

from . import ream

DRAW_IN_SPACE = {"blade_scene", "cone_scene", "machine_scene", "path_scene", "scene",
                 "six_cones_scene", "surface_scene", "torus_scene", "tunnel_scene"}  # fmt: skip
READ_NOTEBOOKS = {"chapters", "ending"}
LEFT_OUT = DRAW_IN_SPACE | READ_NOTEBOOKS

RING = Torus(3.0, 1.0)
DRAWING, _ = figure(height=2, width=3)
_, AXES = figure(height=2, width=3)  # never shown: it fills up
PIXELS = np.zeros((4, 5, 3), dtype=np.uint8)
RECORD = Record("01_machine")
RECORD.root = Path(tempfile.mkdtemp())
SERIES = [0.0, 0.5, 1.0]
MAP = np.outer([-1.0, 0.0, 1.0], [1.0, 1.0, 1.0])
UPRIGHT = ConePose((0, 0, 0), (0, 0, 1), 0.4, near=0.0, far=2.0)
SEGMENTS = HandOver(ready=(3, 9), needed=(2, 12), started=(3, 12), starved=(1, 0))

INSTANCES = {
    Axes: AXES,
    Cones: hyperosculating_cones(cyclide, 0.5, 0.3, half_angle=0.5),
    ConeChord: ConeChord(1.0, 1.0, 0.5, 0.25),
    Cut: ream.CUT,
    Egg: Egg(0.5),
    Figure: DRAWING,
    HandOver: SEGMENTS,
    Loop: Loop(5.0, 0.01),
    Machine: REFERENCE_MACHINE,
    Record: RECORD,
    Section: Egg(0.5),
    Torus: REFERENCE_MACHINE.torus,
}

CALLS = {
    "Record": {"notebook": "01_machine"},
    "Record.__call__": {"name": "length", "value": 1.5, "unit": "m", "digits": 3},
    "Record.order": {"name": "arm against leg", "first": 1.5, "second": 2.0},
    "Record.figure": {"picture": PIXELS, "name": "stripes", "alt": "Stripes."},
    "Record.table": {"name": "t", "columns": ["x / m"], "rows": [[0.5]], "decimals": 2},
    "envelope_plot.draw_cone_and_conic": {"cone": UPRIGHT},
    "envelope_plot.draw_cone_counts": {"x": MAP, "y": MAP.T, "count": MAP},
    "envelope_plot.draw_cones_at_contact": {"f": cyclide, "place": (0.5, 0.3)},
    "envelope_plot.draw_gap_map": {"e": MAP, "w": MAP.T, "gap": MAP},
    "envelope_plot.draw_planes_along_line": {"surface": ruled(saddle)},
    "envelope_plot.draw_ring_gap": {"f": cyclide, "place": (0.5, 0.3), "centre": (0.1, 0.2)},
    "machine_plot.draw_plan_view": {"phi": 0.3},
    "motion_plot.draw_hand_over": {"tasks": [Task("interpolation", 5, 1)], "ticks": [1, 2]},
    "response_plot.draw_responses": {"models": {"T1": Integrator(1.0)}, "setvalues": SERIES},
    "geodesic_plot.draw_half_swings": {"tori": [Torus(0.1, 0.8)]},
    "geodesic_plot.draw_arrivals": {"torus": RING, "begin": (0.0, 0.8), "level": -0.3},
    "geodesic_plot.draw_mirrored": {"torus": RING, "begin": (0.0, 0.8), "end": (2.6, -0.3)},
    "rod_plot.draw_cut_row": {"grid": DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (4, 4)),
                              "capsule": Rod((0, 0, 0), (0.3, 0, 0.2), 0.4, ends="round")},
    "moving_picture": {"draw": lambda value: DRAWING, "values": [0, 1], "alt": "Nothing."},
    "motion_plot.draw_setvalues": {"t": SERIES, "values": SERIES, "ideal": SERIES, "box": 0.5},
    "path_plot.draw_competing": {"torus": RING, "p": (0.0, 0.8), "q": (3.1, -0.3)},
    "path_plot.draw_deviations": {"p": (0, 0), "q": (0.3, 0.2), "rules": ["tangent spheres"]},
    "path_plot.draw_gap": {"tori": [Torus(0.1, 0.8)], "p": (0, 0), "q": (0.3, 0.2)},
    "cone_plot.draw_cone": {"u": SERIES},
    "cone_plot.draw_development": {"u": SERIES},
    "path_plot.draw_ways": {"p": (0, 0), "q": (0.3, 0.2)},
    "path_plot.path_style": {"name": "joint space"},
    "plot.draw_pictures": {"axes": figure(1, 2, height=2)[1], "pictures": [PIXELS] * 2,
                           "titles": ["a", "b"]},
    "plot.draw_feet_along_axis": {"m": (0.5, 0.3, 0.2)},
    "plot.draw_tangent_spheres": {"m": (0.5, 0.3, 0.0)},
    "plot.draw_shares": {"shares": [[0.0, 20.0]], "columns": ["a", "b"], "counts": ["of", "7"]},
    "plot.equal": {"xlabel": "x / m", "ylabel": "y / m"},
    "preview": {"picture": PIXELS},
    "sliders": {"draw": lambda: DRAWING},
}  # fmt: skip
