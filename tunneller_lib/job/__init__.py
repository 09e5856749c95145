"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures of a cut need matplotlib.
"""

from .progress import say
from .reader import read_job
from .tables import WrongJob

__all__ = ["WrongJob", "read_job", "say"]
