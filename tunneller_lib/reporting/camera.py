"""Look at a scene, take its picture, keep it for the web pages, or show it to be turned.

For scenes that are made already: so it needs neither pyvista nor a GL library itself.
"""

import os

import numpy as np
from IPython import get_ipython
from IPython.display import display

from .kept_scene import keep
from .live_scene import live

MARGIN = 20  # px of white left around a picture


def shoot(plotter, *, direction=(1.0, -1.5, 0.8), up=(0.0, 0.0, 1.0), zoom=1.3):
    """Return a picture of a scene, its white border cut off; in a live notebook show it to turn.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene; it is closed afterwards, unless somebody is there to turn it.
    direction, up : (3,) float
        From the middle of the scene towards the camera, and what points up in the picture; a
        direction of None is for a camera that is set already.
    zoom : float
        Above 1 for a closer look.

    Returns
    -------
    pixels : (n, m, 3) uint8
        Red, green, blue.
    """
    if direction is not None:
        look(plotter, direction, up, zoom)
    pixels = plotter.screenshot(return_img=True)
    keep(plotter)
    if get_ipython() and os.environ.get("PYVISTA_JUPYTER_BACKEND") != "static":
        display(live(plotter, "A scene to turn; its picture is described where it is shown."))
    else:
        plotter.close()
    return crop(pixels)


def look(plotter, direction, up=(0.0, 0.0, 1.0), zoom=1.3):
    """Return a scene after its camera is set.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene, with all that is to be seen.
    direction, up, zoom
        As for `shoot`.

    Returns
    -------
    plotter : pyvista.Plotter
        The same scene.
    """
    plotter.view_vector(direction, viewup=up)
    plotter.camera.zoom(zoom)
    return plotter


def crop(pixels):
    """Return a picture without its white border, but for a small margin.

    Parameters
    ----------
    pixels : (n, m, 3) uint8
        Red, green, blue.

    Returns
    -------
    pixels : (n, m, 3) uint8
        The part that shows something, or all of an empty picture.
    """
    drawn = np.any(pixels != 255, axis=-1)
    if not drawn.any():
        return pixels
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    top, left = max(rows[0] - MARGIN, 0), max(columns[0] - MARGIN, 0)
    return pixels[top : rows[-1] + MARGIN + 1, left : columns[-1] + MARGIN + 1]
