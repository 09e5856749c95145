"""A job: a small file that asks for a cut, and the files that a cut leaves.

It needs numpy and scipy alone; pictures of a cut need matplotlib.
"""

from .reader import read_job
from .tables import WrongJob

__all__ = ["WrongJob", "read_job"]
