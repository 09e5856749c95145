"""Pictures that move by themselves, small enough to be stored in a notebook."""

import io
from collections.abc import Callable
from itertools import pairwise
from typing import Annotated

import numpy as np
import PIL.Image
from matplotlib.figure import Figure

from tunneller_lib.arguments import Rule, Whole, checked, shown

from .record import PREVIEW, drawing_pixels

COLOURS_OF_ALL = 62  # of one palette for all drawings, beside white: drawings need few
LONGEST = 500  # pictures


def _values(name, value):
    in_a_row = isinstance(value, (list, tuple)) or (
        isinstance(value, np.ndarray) and value.ndim == 1
    )
    if not in_a_row or not 2 <= len(value) <= LONGEST:
        raise ValueError(f"{name}: must be 2 to {LONGEST} values in a row; got {shown(value)}.")
    return list(value)


Values = Annotated[list, Rule("(n,)", _values)]


@checked
def moving_picture(
    draw: Callable, values: Values, *, alt: str, milliseconds: Whole(10, 10_000) = 80
):
    """Return a picture that moves: a drawing for each of some values, over and over.

    Parameters
    ----------
    draw : callable
        Takes a value and returns a drawing; all are of one size, with the axes of the first.
    values : (n,)
        What it is drawn for. A reader who sees no motion sees the first.
    alt : str
        What is seen, for those who can't see it.
    milliseconds : int
        How long each drawing stands.

    Returns
    -------
    picture : IPython.display.Image
        An animated PNG, 800 pixels wide.

    Raises
    ------
    ValueError
        If there is no text, `draw` returns no drawing, or they differ in size or number of axes.
    """
    from IPython.display import Image  # drawings need no IPython: the extra [picture] has none

    if not alt.strip():
        raise ValueError(f"alt: must say what is seen; got {alt!r}.")
    first = _drawing(draw, values[0])
    pictures = [drawing_pixels(first)]
    places = [ax.get_position(original=True) for ax in first.axes]
    for value in values[1:]:
        drawing = _drawing(draw, value)
        if len(drawing.axes) != len(places):
            raise ValueError("draw: must return drawings with as many axes each.")
        drawing.set_layout_engine("none")  # to lay them out anew takes as long as to draw
        for ax, place in zip(drawing.axes, places, strict=True):
            ax.set_position(place)
        pictures.append(drawing_pixels(drawing))
    if any(a.shape != b.shape for a, b in pairwise(pictures)):
        raise ValueError("draw: must return drawings of one size.")
    content = _animated_png(pictures, milliseconds)
    return Image(content, format="png", width=PREVIEW, alt=alt)


def _drawing(draw, value):
    drawing = draw(value)
    if not isinstance(drawing, Figure):
        raise ValueError(f"draw: must return a drawing; got {shown(drawing)}.")
    return drawing


def _animated_png(pictures, milliseconds):
    # One palette, for a PNG has one: white, and what a few of the pictures have.
    few = PIL.Image.fromarray(np.concatenate(pictures[:: max(1, len(pictures) // 4)]))
    others = np.reshape(few.quantize(COLOURS_OF_ALL).getpalette(), (-1, 3))
    others = others[others.min(axis=1) < 248]  # nothing that white paper would be mistaken for
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *others.ravel().tolist()])
    frames = [
        PIL.Image.fromarray(pixels).quantize(palette=palette, dither=PIL.Image.Dither.NONE)
        for pixels in pictures
    ]
    content = io.BytesIO()
    frames[0].save(
        content,
        format="png",
        save_all=True,
        append_images=frames[1:],
        duration=milliseconds,
        loop=0,
        optimize=True,
    )
    return content.getvalue()
