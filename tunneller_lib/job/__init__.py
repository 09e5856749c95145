"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures and scenes of a cut are `reporting`'s.
"""

from . import atomic_write, mesh, results
from .progress import say
from .reader import read_job
from .tables import WrongJob

# `flank` is imported where it is asked for: a cut needs none of the rooms beneath it.
__all__ = ["WrongJob", "atomic_write", "flank", "flank_files", "mesh", "read_job", "results", "say"]
