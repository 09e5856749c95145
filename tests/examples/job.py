"""Examples for the room job."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tunneller_lib.job import mesh, read_job
from tunneller_lib.job.controller import Program, program
from tunneller_lib.job.flank import FlankJob, FlankResult, read_flank
from tunneller_lib.job.flank_files import summarise_flank
from tunneller_lib.job.logged import identify_log
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

_FLANK = Path(_FOLDER.name, "flank.toml")
_text = Path(__file__).parents[2].joinpath("notebooks", "flank.toml").read_text(encoding="utf-8")
for old, new in {
    "points = 9": "points = 3",
    "strips = 12": "strips = 1",
    "mesh = 121": "mesh = 20",
}.items():
    _text = _text.replace(old, new)
_FLANK.write_text(_text, encoding="utf-8")


@cache
def _job():
    return read_job(_JOB)


@cache
def _cut():
    return _job().simulated()


@cache
def _flanked():
    job = read_flank(_FLANK)
    return {"job": job, "result": job.solved(lambda text: None)}


def _solved():
    return _flanked()["result"]


_MESH = mesh.Mesh(np.eye(3), np.array([[0, 1, 2]]), {"left": np.arange(3.0)})

INSTANCES = {
    Circuit: lambda: _job().planned.circuit,
    Cut: _cut,
    DexelGrid: lambda: _cut().wall,
    FlankJob: lambda: _flanked()["job"],
    FlankResult: _solved,
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


_log = "time_s,valve,speed_rad_s\n" + "".join(
    f"{0.005 * n:g},{0.3 * (n // 20 % 2)},{0.15 * (n // 21 % 2)}\n" for n in range(120)
)

CALLS = {
    "flank.FlankJob.solved": {"say": lambda text: None},
    "identified_text": lambda: {"numbers": identify_log(_log)},
    "identify_log": {"text": _log},
    "read_csv": {"text": "# tick_s = 0.005\ntick,theta\n0,1\n1,2\n"},
    "dxf": {"curves": {"WALL": Egg(0.5)}},
    "flank_files.flank_text": lambda: {"numbers": summarise_flank(**_flanked())},
    "mesh.ply": {"mesh": _MESH, "name": "left"},
    "mesh.read_stl": {"content": mesh.stl(_MESH)},
    "mesh.stl_blocks": {"mesh": _MESH, "stamp": "tunneller_lib"},
    "mesh.vtp_blocks": {"mesh": _MESH, "stamp": "tunneller_lib"},
    "mesh.wall_solid": lambda: {"wall": _cut().wall},
    "mesh.wall_surface": lambda: {"wall": _cut().wall, "circuit": _job().planned.circuit},
    "atomic_write.list_files": {"folder": _LISTED, "stamp": "tunneller_lib"},
    "atomic_write.write": {"content": "text"},
    "flank.read_flank": {"path": _FLANK},
    "read_job": {"path": _JOB},
    "say": {"text": "done"},
    "flank_files.summarise_flank": _flanked,
    "results.summarise": lambda: {"job": _job(), "cut": _cut()},
    "results.summary_text": lambda: {"numbers": _results()["numbers"]},
    "results.write_all": _results,
    "flank_files.write_flank": lambda: (
        _flanked() | {"folder": Path(_FOLDER.name, "flank"), "say": lambda text: None}
    ),
}
