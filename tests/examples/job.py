"""Examples for the room job."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tunneller_lib.job import mesh, read_job
from tunneller_lib.job.controller import Program, program
from tunneller_lib.job.reader import Job
from tunneller_lib.job.results import summarise
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.ream.cutting import Cut
from tunneller_lib.ream.planning import Plan
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import Egg, Section

_FOLDER = tempfile.TemporaryDirectory()
_NEW = Path(_FOLDER.name, "new.txt")
_JOB = Path(_FOLDER.name, "job.toml")
_JOB.write_text(  # coarse enough to be simulated in no time
    """
[machine]
r = 0.08
R = 0.80
theta_min_deg = -60
theta_max_deg = 35
phi_min_deg = -40
phi_max_deg = 40
cutter_radius = 0.20
depth = 0.02
height = -0.36

[section]
shape = "egg"
a = 0.5

[limits]
feed = 1.0
acceleration = 20

[plan]
tolerance = 1e-2
step = 0.2
tick = 0.02
count_deg = 0.0054931640625
rest = 0.02

[controller]
plant = "T0"
gain = 10
feedforward = 1
delay = 1
trip = 1

[wall]
along = 4
around = 12
""",
    encoding="utf-8",
)

_LISTED = Path(_FOLDER.name, "listed")
_LISTED.mkdir()


@cache
def _job():
    return read_job(_JOB)


@cache
def _cut():
    return _job().simulated()


_MESH = mesh.Mesh(np.eye(3), np.array([[0, 1, 2]]), {"left": np.arange(3.0)})

INSTANCES = {
    Circuit: lambda: _job().planned.circuit,
    Cut: _cut,
    DexelGrid: lambda: _cut().wall,
    Job: _job,
    mesh.Mesh: lambda: mesh.wall_solid(_cut().wall),
    Path: _NEW,
    Plan: lambda: _job().planned,
    Program: lambda: program(_job().planned, _job()),
    Section: Egg(0.5),
}


@cache
def _results():
    return {
        "job": _job(),
        "cut": _cut(),
        "folder": Path(_FOLDER.name, "cut"),
        "numbers": summarise(_job(), _cut()),
        "say": lambda text: None,
    }


CALLS = {
    "csv_tables.read_csv": {"text": "# tick_s = 0.005\ntick,theta\n0,1\n1,2\n"},
    "drawing.dxf": {"curves": {"WALL": Egg(0.5)}},
    "mesh.stl_blocks": {"mesh": _MESH, "stamp": "tunneller_lib"},
    "mesh.vtp_blocks": {"mesh": _MESH, "stamp": "tunneller_lib"},
    "mesh.wall_solid": lambda: {"wall": _cut().wall},
    "mesh.wall_surface": lambda: {"wall": _cut().wall, "circuit": _job().planned.circuit},
    "atomic_write.list_files": {"folder": _LISTED, "stamp": "tunneller_lib"},
    "read_job": {"path": _JOB},
    "say": {"text": "done"},
    "results.summarise": lambda: {"job": _job(), "cut": _cut()},
    "results.summary_text": lambda: {"numbers": _results()["numbers"]},
    "results.write_all": _results,
}
