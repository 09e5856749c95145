"""Sliders for a drawing or a scene, where there is somebody to move them."""

import asyncio
import gc
import itertools
import os
from contextlib import contextmanager

from matplotlib.figure import Figure

from .camera import live, refill, shoot
from .record import moved_preview, preview
from .style import TEXT_WIDTH

SWEEPS = itertools.count(1)
ROOM = 0.05, 0.03, 0.92, 0.94  # left, bottom, width and height of what drawings first fill


def sliders(draw, *, alt="", **ranges):
    """Draw once, and again whenever a slider is moved.

    Parameters
    ----------
    draw : callable
        Takes the values by the names of the ranges and returns a drawing, or a scene with its
        camera set. A drawing keeps the places of its axes, with some room for labels that grow, a
        scene the view it was turned to.
    alt : str
        What is shown at the start, for those who can't see it; where there are sliders a
        drawing's values are added. With it a run without a screen shows the drawing too; without,
        that's left to the one who shows it. A scene needs it.
    **ranges
        (low, high, start) of each value, perhaps with its unit; whole numbers make a slider of
        whole numbers. A name's words, joined by ``_``, stand beside the slider.

    Returns
    -------
    first : matplotlib.figure.Figure or pyvista.Plotter
        What was drawn with the start values, a scene closed where it isn't shown to be turned.
        ``PYVISTA_JUPYTER_BACKEND=static`` marks a run without a screen.
    """
    starts = {name: start for name, (_, _, start, *_) in ranges.items()}
    first = draw(**starts)
    moved = _moved_drawing if isinstance(first, Figure) else _moved_scene
    if os.environ.get("PYVISTA_JUPYTER_BACKEND") != "static":
        import ipywidgets

        controls = {name: _slider(name, *limits) for name, limits in ranges.items()}
        _show(ipywidgets.VBox([*controls.values(), *moved(draw, first, alt, controls)]))
    elif alt:
        half = {"direction": None, "width": TEXT_WIDTH / 2}
        _show(preview(first if isinstance(first, Figure) else shoot(first, **half), alt))
    return first


def _show(thing):
    from IPython.display import display  # drawings need no IPython: the extra [picture] has none

    display(thing)


@contextmanager
def _swept():
    """Have what a drawing leaves swept up at once, while it is young.

    Collected while it's drawn it would grow old; twenty of them swept with all that was ever
    imported take as long as two pictures. When Python sweeps by itself differs between its
    versions, so that it's asked to: each time for what is new, the tenth time for what outlived
    one sweep. It switches the collector on, whoever had it off.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.collect(int(next(SWEEPS) % 10 == 0))
        gc.enable()


def _moved_drawing(draw, first, alt, controls):
    from ipywidgets import interactive_output

    first.set_layout_engine("constrained", rect=ROOM)
    first.draw_without_rendering()
    places = [ax.get_position(original=True) for ax in first.axes]
    first.set_layout_engine("constrained")

    def picture(**values):
        drawing = draw(**values)
        if len(drawing.axes) == len(places):  # to lay them out anew takes as long as to draw
            drawing.set_layout_engine("none")
            for ax, place in zip(drawing.axes, places, strict=True):
                ax.set_position(place)
        here = ", ".join(f"{_words(name)} {value:g}" for name, value in values.items())
        return moved_preview(drawing, f"{alt} Drawn for {here}.")

    def show(**values):
        with _swept():
            _show(picture(**values))

    return [interactive_output(show, controls)]


def _moved_scene(draw, plotter, alt, controls):
    from ipywidgets import interactive_output

    loop = asyncio.get_running_loop()
    widget = live(plotter, alt)
    newest = None

    def move(values):
        if values is not newest:
            return  # the slider is farther already
        told.outputs = ()
        try:
            refill(plotter, draw(**values))
        except Exception as error:  # a loop's callback has nobody to tell
            text = f"{type(error).__name__}: {error}\n"
            told.outputs = ({"output_type": "stream", "name": "stderr", "text": text},)
        widget.viewer.update()

    def show(**values):
        nonlocal newest
        newest = values
        # A kernel hears of sliders in a thread of their own; rendering is left to its main one.
        loop.call_soon_threadsafe(move, values)

    told = interactive_output(show, controls)
    return [widget, told]


def _words(name):
    """Return the words that a name is made of: ``arm_angle`` is the arm angle."""
    return name.replace("_", " ")


def _slider(name, low, high, start, unit=""):
    from ipywidgets import FloatSlider, IntSlider

    about = {
        "min": low,
        "max": high,
        "value": start,
        "description": f"{_words(name)} / {unit}" if unit else _words(name),
        "style": {"description_width": "initial"},
        "continuous_update": False,
    }
    if all(isinstance(number, int) for number in (low, high, start)):
        return IntSlider(**about)
    return FloatSlider(**about, step=(high - low) / 100)
