"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures and scenes of a cut are `reporting`'s.
"""

from . import atomic_write, csv_tables, drawing, mesh, results
from .progress import say
from .reader import read_job
from .tables import WrongJob

__all__ = [
    "WrongJob",
    "atomic_write",
    "csv_tables",
    "drawing",
    "mesh",
    "read_job",
    "results",
    "say",
]
