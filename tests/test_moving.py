"""Pictures that move: as many drawings as values, one size, one palette, and a text."""

import io

import numpy as np
import PIL.Image
from PIL import ImageSequence

from kit import figure, moving_picture
from kit.record import drawing_pixels


def dot(place, width=6):
    drawing, ax = figure(height=3, width=width)
    ax.plot(place, 0.5, "o", color="#C42A52")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    return drawing


def test_moving_picture_shows_every_drawing_and_the_first_one_first():
    places = [0.2, 0.5, 0.8]
    shown = moving_picture(dot, places, alt="A dot that moves.", milliseconds=50)
    assert shown.alt == "A dot that moves."
    with PIL.Image.open(io.BytesIO(shown.data)) as picture:
        assert (picture.n_frames, picture.width, picture.info["loop"]) == (3, 800, 0)
        for k, place in enumerate(places):
            picture.seek(k)
            assert picture.info["duration"] == 50
            seen = np.asarray(picture.convert("RGB")).astype(int)
            # The palette is the same for all, so that soft edges may differ a little.
            assert np.abs(seen - drawing_pixels(dot(place))).mean() < 0.5


def test_axes_stay_where_the_first_drawing_has_them():
    def labelled(lines):
        drawing = dot(0.5)
        drawing.axes[0].set_ylabel("\n".join(["a line"] * lines))  # takes room from the axes
        return drawing

    shown = moving_picture(labelled, [1, 3], alt="A label that grows.")
    with PIL.Image.open(io.BytesIO(shown.data)) as picture:
        before, after = (
            np.asarray(frame.convert("L")) for frame in ImageSequence.Iterator(picture)
        )
    right = slice(200, None)  # beside the label
    assert np.array_equal(before[:, right], after[:, right]) and not np.array_equal(before, after)
