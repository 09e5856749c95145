"""What all notebooks use to show their results; scenes are in `kit.scene`."""

from .chapters import ending
from .interactive import sliders
from .moving import moving_picture
from .number_format import in_words
from .record import Show, preview
from .style import COLOURS, ERROR_MAP, figure

__all__ = [
    "COLOURS",
    "ERROR_MAP",
    "Show",
    "ending",
    "figure",
    "in_words",
    "moving_picture",
    "preview",
    "sliders",
]
