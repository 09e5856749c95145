"""What becomes of a finished scene: a picture, a scene to turn, one kept for the web pages.

It gets scenes that are made already: so it needs neither pyvista nor a GL library itself.
"""

import functools
import html
import os
import secrets
from pathlib import Path
from unittest.mock import patch

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation

from .style import COLOURS, STYLE, TEXT_WIDTH

ASLANT = 1.0, -1.5, 0.8  # towards the camera
UP = 0.0, 0.0, 1.0
MARGIN = 1 / 80  # of a window's width: white that is left around a picture
ROUGH = 8  # times as small as a picture is the one that shows where it isn't white
BESIDE_OTHERS = 0.55  # of a window for pictures up to half as wide as the text
WIDGET = [800, 560]  # px, of a scene that is turned in a notebook
LETTER = STYLE["font.size"] / 72 * 2.54  # cm on paper, the size of the letters in drawings
BESIDE = 2.5  # letters' sizes; from what is farther away a line leads to its letter


def shoot(plotter, *, direction=ASLANT, up=UP, zoom=1.3, letters=None, width=TEXT_WIDTH):
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
    letters : dict of str to ((3,) float, (2,) float), optional
        What is written over the picture: each text, as matplotlib sets it, with the point in the
        scene that it names and its way from there, to the right and up in sizes of the letters.
    width : float
        Of the picture on paper, in cm, where letters have the size of those in drawings; up to
        half of the text's the window is smaller, since print shows fewer pixels of it.

    Returns
    -------
    pixels : (n, m, 3) uint8
        Red, green, blue.
    """
    if direction is not None:
        look(plotter, direction, up, zoom)
    if width <= TEXT_WIDTH / 2:
        plotter.window_size = [round(BESIDE_OTHERS * size) for size in plotter.window_size]
    pixels = _pixels(plotter)
    if letters:
        pixels = _lettered(plotter, pixels, letters, LETTER / width * crop(pixels).shape[1])
    if folder := os.environ.get("TUNNELLER_SCENES"):
        _keep(plotter, Path(folder))
    # Late, as it takes a fifth of a second: the command does without.
    from IPython import get_ipython
    from IPython.display import display

    if get_ipython() and os.environ.get("PYVISTA_JUPYTER_BACKEND") != "static":
        display(live(plotter, "A scene to turn; its picture is described where it is shown."))
    else:
        plotter.close()
    return crop(pixels)


def look(plotter, direction, up=UP, zoom=1.3):
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
    return pixels[_drawn(pixels, round(MARGIN * pixels.shape[1]))]


def live(plotter, title):
    """Return a widget in which a scene is turned.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene, its camera set; its window gets the widget's size.
    title : str
        What it shows, for those who can't see it.

    Returns
    -------
    widget : ipywidgets.HTML
        With pyvista's ``viewer``, whose ``update`` shows what has changed in the scene.
    """
    plotter.window_size = WIDGET
    plotter.enable_anti_aliasing("msaa")  # which takes half the time of a still picture's
    word = _password()
    widget = plotter.show(return_viewer=True)
    frame = f'<iframe title="{html.escape(title)}"'
    asked = f"{widget.src}&secret={word}"  # which the page takes off its address
    widget.value = widget.value.replace("<iframe", frame, 1).replace(widget.src, asked, 1)
    return widget


@functools.cache
def _password():
    """Return this process' own word for its scenes; their server refuses whoever doesn't say it.

    Left alone, it would take the same word everywhere, so that any web page that is open in a
    browser on this machine could ask for scenes and turn them.
    """
    import pyvista
    from trame.app import get_server

    word = f"s{secrets.token_hex(16)}"  # the page takes a number for one
    server = get_server(pyvista.global_theme.trame.jupyter_server_name)
    server.cli.set_defaults(authKey=word)
    if server.running:  # for somebody's own scenes
        server.protocol.updateSecret(word)
    return word


def refill(plotter, other):
    """Put another scene's actors in place of a scene's own; it keeps its camera and its lights.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene that is shown.
    other : pyvista.Plotter
        The one that gives its actors; it is closed.
    """
    plotter.clear_actors()
    for name, actor in other.actors.items():
        plotter.add_actor(actor, name=name, reset_camera=False, render=False)
    other.close()


def _drawn(pixels, margin):
    """Return the slices, for rows and columns, of what isn't white, and a margin; or of all."""
    drawn = pixels[..., 0] & pixels[..., 1] & pixels[..., 2] != 255
    if not drawn.any():
        return slice(None), slice(None)
    ends = [np.flatnonzero(drawn.any(axis=axis))[[0, -1]] for axis in (1, 0)]
    return tuple(slice(max(first - margin, 0), last + margin + 1) for first, last in ends)


def _pixels(plotter):
    """Return all pixels of a scene's window, of which those that stay white aren't rendered.

    They would take as long as the others. A rough picture shows where they are.
    """
    if plotter.scalar_bars:  # they lie where the window's size puts them
        return plotter.screenshot(return_img=True)
    width, height = plotter.window_size
    window, camera = plotter.render_window, plotter.camera
    window.SetSize(width // ROUGH, height // ROUGH)
    rough = plotter.screenshot(return_img=True)
    pixels = np.full((height, width, 3), 255, np.uint8)
    box = _drawn(rough.repeat(ROUGH, axis=0).repeat(ROUGH, axis=1), 2 * ROUGH)
    rows, columns = (range(n)[one] for n, one in zip((height, width), box, strict=True))
    whole = camera.copy()
    share = len(rows) / height
    camera.parallel_scale *= share
    camera.view_angle = np.degrees(2 * np.arctan(share * np.tan(np.radians(camera.view_angle) / 2)))
    right = (columns[0] + columns[-1] + 1 - width) / len(columns)
    camera.SetWindowCenter(right, (height - rows[0] - rows[-1] - 1) / len(rows))
    window.SetSize(len(columns), len(rows))
    plotter.render()
    pixels[box] = plotter.image
    window.SetSize(width, height)
    camera.DeepCopy(whole)
    return pixels


def _lettered(plotter, pixels, letters, size):
    """Return a scene's picture with letters of a size in pixels written over it."""
    height, width = pixels.shape[:2]
    # A point is a pixel.
    drawing = Figure(figsize=(width / 72, height / 72), dpi=72, frameon=False)
    halo = [withStroke(linewidth=size / 4, foreground="white")]
    style = dict(size=size, color=COLOURS["chord"], path_effects=halo, ha="center", va="center")
    line = {"arrowstyle": "-", "lw": size / 16, "shrinkA": 0, "shrinkB": 0, "path_effects": halo}
    canvas = FigureCanvasAgg(drawing)
    with rc_context(STYLE):
        for text, (point, away) in letters.items():
            named = _on_screen(plotter, point)
            beside = named + size * np.asarray(away)
            place = {"xy": named, "xycoords": "figure pixels", "xytext": beside}
            leads = line if np.hypot(*away) > BESIDE else None
            drawing.add_artist(Annotation(text, arrowprops=leads, **place, **style))
        # The picture is put below them as it is: matplotlib would resample it first.
        seen = np.asarray(canvas.get_renderer().buffer_rgba())
        seen[..., :3] = pixels
        seen[..., 3] = 255
        drawing.draw(canvas.get_renderer())
    return np.array(canvas.buffer_rgba())[..., :3]


def _on_screen(plotter, point):
    """Return where a point (3,) of a scene lies in its picture, in px from the lower left."""
    renderer = plotter.renderer
    renderer.SetWorldPoint(*point, 1.0)
    renderer.WorldToDisplay()
    return np.array(renderer.GetDisplayPoint()[:2])


def _keep(plotter, folder):
    """Write a scene for the web pages, named by the notebook's cell that is running."""
    for actor in plotter.actors.values():
        if hasattr(getattr(actor, "mapper", None), "dataset"):  # texts and bars have no mesh
            actor.mapper.dataset = _light(actor.mapper.dataset)
    from IPython import get_ipython

    cell = len(get_ipython().user_ns["In"]) - 1  # IPython's counter may be one ahead
    before = sum(1 for _ in folder.glob(f"{cell:02}-*"))
    folder.mkdir(parents=True, exist_ok=True)
    # The view writes the scene and is never shown, so it needn't prepare the six states that it
    # would send to a page.
    with patch("trame_pyvista.widgets.PyVistaLocalView.update"):
        plotter.trame.export_vtksz(folder / f"{cell:02}-{before}.vtksz")


def _light(mesh):
    """Return a mesh that packs well: single precision, without the bits that no screen shows."""
    if not mesh.length:
        return mesh
    packed = mesh.copy()
    step = 2.0 ** (np.ceil(np.log2(mesh.length)) - 13)
    packed.points = (np.round(mesh.points / step) * step).astype(np.float32)
    if "Normals" in mesh.point_data:
        normals = np.round(mesh.point_data["Normals"] * 64) / 64
        packed.point_data["Normals"] = normals.astype(np.float32)
    return packed
