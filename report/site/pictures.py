"""Pictures of pages: packed, and with their sizes, so that nothing moves when they come."""

import io
import re

import PIL.Image

HIGHEST = 576  # px on a screen
POINT = 4 / 3  # px
DRAWN = re.compile(rb'<svg[^>]*\swidth="([\d.]+)pt" height="([\d.]+)pt"')


def sizes(content):
    """Return a picture's attributes of its size on a screen; a PNG, a WebP or an SVG by points."""
    if found := DRAWN.search(content):
        width, height = (POINT * float(size) for size in found.groups())
    else:
        width, height = PIL.Image.open(io.BytesIO(content)).size
    share = min(1, HIGHEST / height)
    return f'width="{share * width:.0f}" height="{share * height:.0f}"'


def packed(content, width=None):
    """Return a picture as WebP: the same pixels, or fewer and about the same if a width is given.

    Parameters
    ----------
    content : bytes
        Any picture of pixels.
    width : int, optional
        The most px that it may be wide or high.
    """
    picture = PIL.Image.open(io.BytesIO(content)).convert("RGB")
    made = io.BytesIO()
    if width is None:
        picture.save(made, "WEBP", lossless=True)
    else:
        picture.thumbnail((width, width))
        picture.save(made, "WEBP", quality=70)
    return made.getvalue()
