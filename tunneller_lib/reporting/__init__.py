"""What notebooks use to show and to record: needs the study's environment, not only numpy."""

from tunneller_lib.reporting.record import Record
from tunneller_lib.reporting.style import COLOURS, figure

__all__ = ["COLOURS", "Record", "figure"]
