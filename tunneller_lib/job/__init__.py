"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures and scenes of a cut are `reporting`'s.
"""

from . import atomic_write, csv_tables, drawing, mesh
from .logged import identified_text, identify_log
from .progress import say
from .reader import Job, WrongJob, read_job
from .results import summarise, summary_text, write_all

__all__ = [
    "Job",
    "WrongJob",
    "atomic_write",
    "csv_tables",
    "drawing",
    "identified_text",
    "identify_log",
    "mesh",
    "read_job",
    "say",
    "summarise",
    "summary_text",
    "write_all",
]
