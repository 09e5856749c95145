"""A job: a small file that asks for a cut, and the files that come of it.

Needs numpy and scipy alone. Pictures and scenes of a cut are `reporting`'s.
"""

from . import atomic_write, csv_tables, drawing, mesh
from .logged import identified_text, identify_log
from .progress import say
from .reader import Job, WrongJob, read_job
from .results import summarise, summary_text, write_all

__all__ = [
    "FlankJob",
    "FlankResult",
    "Job",
    "WrongJob",
    "atomic_write",
    "csv_tables",
    "drawing",
    "flank_text",
    "identified_text",
    "identify_log",
    "mesh",
    "read_flank",
    "read_job",
    "say",
    "summarise",
    "summarise_flank",
    "summary_text",
    "write_all",
    "write_flank",
]


def __getattr__(name):
    """Return a name of flank milling: the rooms that it needs, and a cut does not, come then."""
    if name in __all__:
        from . import flank, flank_files

        return getattr(flank if hasattr(flank, name) else flank_files, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
