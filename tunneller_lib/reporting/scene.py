"""Pictures of surfaces in space, drawn without a screen."""

import os
from pathlib import Path

# VTK chooses its window when it is imported.
if "DISPLAY" not in os.environ:
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import pyvista
from IPython import get_ipython

from ..envelopes.isotropic import cone_rulings

# Lights as the camera sees them, x to the right and y up: one in front, two from above.
LIGHTS = [((0, 0, 1), 0.6), ((-1, 1, 1), 0.35), ((1, 0.6, 0.4), 0.2)]
MARGIN = 20  # px of white left around a picture
WINDOW = [800, 560]  # px of a scene to turn in a notebook

THEME = pyvista.themes.DocumentTheme()
THEME.window_size = [1600, 1200]
THEME.smooth_shading = True
THEME.lighting_params.ambient = 0.25  # nothing is quite black
THEME.anti_aliasing = "msaa"
THEME.depth_peeling.enabled = False  # with Mesa's EGL it makes translucent sheets vanish


def scene(*, parallel=True):
    """Return an empty scene: white, without a screen, its lights moving with the camera.

    Parameters
    ----------
    parallel : bool
        Whether lengths stay comparable all over the picture, or near things look larger.

    Returns
    -------
    plotter : pyvista.Plotter
        Add meshes to it, then give it to `shoot`, or call its ``show`` for a scene to turn.
    """
    plotter = pyvista.Plotter(off_screen=True, theme=THEME, lighting="none")
    for position, intensity in LIGHTS:
        light = pyvista.Light(position=position, light_type="camera light", intensity=intensity)
        plotter.add_light(light)
    plotter.parallel_projection = parallel
    return plotter


def surface(points):
    """Return a smooth mesh through a grid of points.

    Parameters
    ----------
    points : (n, m, 3) float
        Points of a surface, in m; rows that end where they began are joined.

    Returns
    -------
    mesh : pyvista.PolyData
        Its quadrilaterals, the grid's cells.

    Raises
    ------
    ValueError
        If the points are no such grid.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.mgrid[0:2:3j, 0:1:4j]
    >>> surface(np.stack([x, y, x * y], axis=-1)).n_cells
    6
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 3 or points.shape[-1] != 3:
        raise ValueError(f"points: must be a grid (n, m, 3); got {points.shape}.")
    grid = pyvista.StructuredGrid(*np.moveaxis(points, -1, 0))
    return grid.extract_surface(algorithm="geometry").clean()


def curve(points, radius, values=None):
    """Return a tube along a curve, which unlike a line keeps its width at any resolution.

    Parameters
    ----------
    points : (n, 3) float
        Points of the curve, in m; it is closed where the last one is the first.
    radius : float
        Of the tube, in m.
    values : (n,) float, optional
        What colours it: scalars of the mesh, named ``values``.

    Returns
    -------
    mesh : pyvista.PolyData
        The tube.
    """
    line = pyvista.lines_from_points(np.asarray(points, dtype=float))
    if values is not None:
        line["values"] = np.asarray(values, dtype=float)
    return line.tube(radius=radius, n_sides=12)


def ball(centre, radius):
    """Return a mesh of a sphere, its centre (3,) and radius in m."""
    return pyvista.Sphere(radius=radius, center=centre, theta_resolution=60, phi_resolution=60)


def cone(vertex, axis, half_angle, near, far):
    """Return a mesh of a truncated cone's wall.

    Parameters
    ----------
    vertex, axis : (3,) float
        Vertex in m, and a vector along the axis into the cone.
    half_angle : float
        Between axis and rulings, in rad.
    near, far : float
        Where the rulings begin and end, as distances from the vertex, in m.

    Returns
    -------
    mesh : pyvista.PolyData
        The wall, without its ends.
    """
    rulings = cone_rulings(axis, half_angle, np.linspace(0, 2 * np.pi, 121))
    return surface(np.asarray(vertex) + np.linspace(near, far, 25)[:, None, None] * rulings)


def arrow(start, vector, radius):
    """Return a mesh of an arrow from `start` along `vector`, its shaft's `radius` in m."""
    length = float(np.linalg.norm(vector))
    return pyvista.Arrow(
        start=start, direction=vector, scale=length, shaft_radius=radius / length,
        tip_radius=2.5 * radius / length, tip_length=min(0.4, 8 * radius / length),
        shaft_resolution=24, tip_resolution=24,
    )  # fmt: skip


def beside(*pictures):
    """Return pictures (n, m, 3) side by side on white, each in the middle of the height."""
    height = max(len(picture) for picture in pictures)
    padded = []
    for picture in pictures:
        above = (height - len(picture)) // 2
        below = height - len(picture) - above
        padded.append(np.pad(picture, ((above, below), (0, 0), (0, 0)), constant_values=255))
    return np.concatenate(padded, axis=1)


def shoot(plotter, *, direction=(1.0, -1.5, 0.8), up=(0.0, 0.0, 1.0), zoom=1.3, turn=True):
    """Return a picture of a scene, its white border cut off; in a live notebook show it to turn.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene; it is closed afterwards, unless somebody is there to turn it.
    direction : (3,) float
        From the middle of the scene towards the camera.
    up : (3,) float
        What points up in the picture.
    zoom : float
        Above 1 for a closer look.
    turn : bool
        Whether to show it to turn, which a picture that a slider renews is not.

    Returns
    -------
    pixels : (n, m, 3) uint8
        Red, green, blue.
    """
    plotter.view_vector(direction, viewup=up)
    plotter.camera.zoom(zoom)
    pixels = plotter.screenshot(return_img=True)
    keep(plotter)
    if turn and get_ipython() and os.environ.get("PYVISTA_JUPYTER_BACKEND") != "static":
        plotter.window_size = WINDOW
        plotter.show()
    else:
        plotter.close()
    return crop(pixels)


def keep(plotter):
    """Keep a scene for the web pages, where ``TUNNELLER_SCENES`` names a folder.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene; it is named by the notebook's cell that is running.
    """
    if folder := os.environ.get("TUNNELLER_SCENES"):
        for actor in plotter.actors.values():
            if isinstance(actor, pyvista.Actor):
                actor.mapper.dataset = light(actor.mapper.dataset)
        cell = get_ipython().execution_count
        before = sum(1 for _ in Path(folder).glob(f"{cell:02}-*"))
        Path(folder).mkdir(parents=True, exist_ok=True)
        plotter.trame.export_vtksz(Path(folder, f"{cell:02}-{before}.vtksz"))


def light(mesh):
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
