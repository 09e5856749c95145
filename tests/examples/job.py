"""Examples for the room job."""

import tempfile
from functools import cache
from pathlib import Path

from tunneller_lib.job import read_job
from tunneller_lib.job.controller import Program, program
from tunneller_lib.job.reader import Job

_FOLDER = tempfile.TemporaryDirectory()
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
feed = 0.3
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
along = 20
around = 48
""",
    encoding="utf-8",
)


@cache
def _job():
    return read_job(_JOB)


INSTANCES = {Job: _job, Path: _JOB, Program: lambda: program(_job().planned, _job())}

CALLS = {"read_job": {"path": _JOB}}
