"""What notebooks use to show and to record: needs the study's environment, not only numpy."""

from .record import Record
from .style import COLOURS, ERROR_MAP, figure

__all__ = ["COLOURS", "ERROR_MAP", "Record", "figure"]
