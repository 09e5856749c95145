"""Sliders under a drawing, where there is somebody to move them."""

import os

import ipywidgets
from IPython.display import display
from matplotlib.figure import Figure

from .record import preview


def sliders(draw, *, alt="", **ranges):
    """Draw once, and again whenever a slider is moved.

    Parameters
    ----------
    draw : function
        Takes the values by the names of the ranges and returns a drawing or pixels.
    alt : str
        What the drawing shows at the start, for those who can't see it; where there are sliders
        their values are added. With it a run without a screen shows the drawing too; without,
        that's left to the one who records it.
    **ranges
        (low, high, start) of each value, perhaps with its unit; whole numbers make a slider of
        whole numbers.

    Returns
    -------
    picture : matplotlib.figure.Figure or (n, m, 3) uint8
        What was drawn with the start values. A run without a screen is told by
        ``PYVISTA_JUPYTER_BACKEND=static``.

    Raises
    ------
    ValueError
        If a start isn't in its range.
    """
    for name, (low, high, start, *_) in ranges.items():
        if not low <= start <= high:
            raise ValueError(f"{name}: must start from {low} to {high}; got {start}.")
    picture = draw(**{name: start for name, (_, _, start, *_) in ranges.items()})
    if os.environ.get("PYVISTA_JUPYTER_BACKEND") != "static":
        controls = {name: _slider(name, *limits) for name, limits in ranges.items()}
        if isinstance(picture, Figure):
            picture.draw_without_rendering()  # its axes get their places

        def show(**values):
            here = ", ".join(f"{name} {value:g}" for name, value in values.items())
            display(preview(_placed(draw(**values), picture), f"{alt} Drawn for {here}."))

        shown = ipywidgets.interactive_output(show, controls)
        display(ipywidgets.VBox([*controls.values(), shown]))
    elif alt:
        display(preview(picture, alt))
    return picture


def _placed(picture, first):
    """Put a drawing's axes where the first one's are: to lay it out anew takes as long as it."""
    if isinstance(picture, Figure) and len(picture.axes) == len(first.axes):
        picture.set_layout_engine("none")
        for ax, before in zip(picture.axes, first.axes):
            ax.set_position(before.get_position(original=True))
    return picture


def _slider(name, low, high, start, unit=""):
    limits = {"min": low, "max": high, "value": start}
    limits |= {"description": f"{name} / {unit}" if unit else name}
    limits |= {"style": {"description_width": "initial"}}
    if all(isinstance(number, int) for number in (low, high, start)):
        return ipywidgets.IntSlider(**limits, continuous_update=False)
    return ipywidgets.FloatSlider(**limits, step=(high - low) / 100, continuous_update=False)
