"""What notebooks use to show and to record: needs the study's environment, not only numpy."""

from .record import Record
from .style import COLOURS, figure

__all__ = ["COLOURS", "Record", "figure"]
