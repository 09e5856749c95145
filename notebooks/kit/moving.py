"""Pictures that move by themselves, small enough to be stored in a notebook."""

import io

import numpy as np
import PIL.Image

from .record import PREVIEW, drawing_pixels

COLOURS_OF_ALL = 62  # of one palette for all drawings, beside white: drawings need few


def moving_picture(draw, values, *, alt, milliseconds=80):
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
    """
    from IPython.display import Image  # drawings need no IPython: the extra [picture] has none

    first = draw(values[0])
    pictures = [drawing_pixels(first)]
    places = [ax.get_position(original=True) for ax in first.axes]
    for value in values[1:]:
        drawing = draw(value)
        drawing.set_layout_engine("none")  # to lay them out anew takes as long as to draw
        for ax, place in zip(drawing.axes, places, strict=True):
            ax.set_position(place)
        pictures.append(drawing_pixels(drawing))
    content = _animated_png(pictures, milliseconds)
    return Image(content, format="png", width=PREVIEW, alt=alt)


def _animated_png(pictures, milliseconds):
    # One palette, for a PNG has one: white, and what a few of the pictures have.
    few = PIL.Image.fromarray(np.concatenate(pictures[:: max(1, len(pictures) // 4)]))
    others = np.reshape(few.quantize(COLOURS_OF_ALL).getpalette(), (-1, 3))
    others = others[others.min(axis=1) < 248]  # nothing that white paper would be mistaken for
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *others.ravel().tolist()])
    plain = {"palette": palette, "dither": PIL.Image.Dither.NONE}
    first, *others = (PIL.Image.fromarray(pixels).quantize(**plain) for pixels in pictures)
    moved = {"save_all": True, "append_images": others, "duration": milliseconds, "loop": 0}
    content = io.BytesIO()
    first.save(content, format="png", optimize=True, **moved)
    return content.getvalue()
