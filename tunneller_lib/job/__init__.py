"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures and scenes of a cut are `reporting`'s.
"""

from .reader import Job, WrongJob, read_job
from .results import summarise, told, write_all

__all__ = ["Job", "WrongJob", "read_job", "summarise", "told", "write_all"]
