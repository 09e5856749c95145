"""Pictures of surfaces in space, drawn without a screen."""

import os

# VTK chooses its window when it is imported.
if "DISPLAY" not in os.environ:
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import pyvista

from . import gl
from .camera import crop as crop
from .camera import look as look
from .camera import shoot as shoot
from .style import COLOURS

# Lights as the camera sees them, x to the right and y up: one in front, two from above.
LIGHTS = [((0, 0, 1), 0.6), ((-1, 1, 1), 0.35), ((1, 0.6, 0.4), 0.2)]

THEME = pyvista.themes.DocumentTheme()
THEME.window_size = [2400, 1800]
THEME.smooth_shading = True
THEME.lighting_params.ambient = 0.25  # nothing is quite black
# By "msaa" versions of Mesa differ in where surfaces cross that touch, and put it pixels aside.
THEME.anti_aliasing = "ssaa"
THEME.depth_peeling.enabled = False  # with Mesa's EGL it makes translucent sheets vanish


def empty(*, parallel=True):
    """Return an empty scene: white, without a screen, its lights moving with the camera.

    Parameters
    ----------
    parallel : bool
        Whether lengths stay comparable all over the picture, or near things look larger.

    Returns
    -------
    plotter : pyvista.Plotter
        Add meshes to it, then give it to `shoot`, which in a live notebook shows it to turn.

    Raises
    ------
    OSError
        If there is no off-screen GL library, without which VTK would crash.
    """
    gl.require()
    plotter = pyvista.Plotter(off_screen=True, theme=THEME, lighting="none")
    for position, intensity in LIGHTS:
        light = pyvista.Light(position=position, light_type="camera light", intensity=intensity)
        plotter.add_light(light)
    plotter.parallel_projection = parallel
    return plotter


def on_sheet(points, opacity=1.0):
    """Return an empty scene but for a design surface, a grid of points (n, m, 3) in m."""
    plotter = empty()
    put(plotter, surface(points), "design surface", opacity=opacity)
    return plotter


def put(plotter, mesh, colour, **look):
    """Add a mesh to a scene in one of the study's colours; `look` is for ``Plotter.add_mesh``."""
    plotter.add_mesh(mesh, color=COLOURS[colour], **look)


def surface(points, values=None):
    """Return a smooth mesh through a grid of points.

    Parameters
    ----------
    points : (n, m, 3) float
        Points of a surface, in m; rows that end where they began are joined.
    values : dict of str to (n, m) float, optional
        What colours it: scalars of the mesh, by name.

    Returns
    -------
    mesh : pyvista.PolyData
        Its quadrilaterals, the grid's cells.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.mgrid[0:2:3j, 0:1:4j]
    >>> surface(np.stack([x, y, x * y], axis=-1)).n_cells
    6
    """
    grid = pyvista.StructuredGrid(*np.moveaxis(np.asarray(points, dtype=float), -1, 0))
    for name, scalars in (values or {}).items():
        grid[name] = np.ravel(scalars, order="F")
    return grid.extract_surface(algorithm="geometry", pass_pointid=False, pass_cellid=False).clean()


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
        line["values"] = values
    return line.tube(radius=radius, n_sides=12)


def rectangle(middle, a, b):
    """Return a mesh of a rectangle, its middle (3,) and half its sides a, b (3,), all in m."""
    middle, a, b = np.array([middle, a, b])
    return surface([[middle - a - b, middle - a + b], [middle + a - b, middle + a + b]])


def kept_parts(points, keep):
    """Return the parts of a closed curve's points (n, 3) where `keep` (n,) is True, as a list.

    Examples
    --------
    >>> import numpy as np
    >>> points = np.arange(8)[:, None] * np.ones(3)
    >>> keep = np.array([1, 1, 0, 0, 1, 1, 0, 1]) > 0
    >>> [part[:, 0].tolist() for part in kept_parts(points, keep)]
    [[4.0, 5.0], [7.0, 0.0, 1.0]]
    """
    start = np.argmin(keep)  # so that no part is cut in two
    points = np.roll(points, -start, axis=0)
    keep = np.roll(keep, -start)
    parts = np.split(points, np.flatnonzero(np.diff(keep)) + 1)
    kept = parts[::2] if keep[0] else parts[1::2]
    return [part for part in kept if len(part) > 1]


def ball(centre, radius):
    """Return a mesh of a sphere, its centre (3,) and radius in m."""
    return pyvista.Sphere(radius=radius, center=centre, theta_resolution=60, phi_resolution=60)


def arrow(start, vector, radius):
    """Return a mesh of an arrow from `start` along `vector`, its shaft's `radius` in m."""
    length = float(np.linalg.norm(vector))
    share = radius / length  # by the length all sizes are scaled
    tip = {"tip_radius": 2.5 * share, "tip_length": min(0.4, 8 * share), "tip_resolution": 24}
    shaft = {"shaft_radius": share, "shaft_resolution": 24}
    return pyvista.Arrow(start=start, direction=vector, scale=length, **shaft, **tip)


def side_by_side(*pictures):
    """Return pictures (n, m, 3) side by side on white, each in the middle of the height."""
    height = max(map(len, pictures))
    return np.concatenate([_padded(p, height, p.shape[1]) for p in pictures], axis=1)


def rows(pictures):
    """Return pictures (n, m, 3) in full rows of three on white, each in the middle of its place.

    Examples
    --------
    >>> import numpy as np
    >>> sizes = [(4, 6), (2, 3), (1, 1)]
    >>> rows([np.zeros((*size, 3), dtype=np.uint8) for size in sizes]).shape
    (4, 18, 3)
    """
    height, width = np.max([picture.shape[:2] for picture in pictures], axis=0)
    padded = [_padded(picture, height, width) for picture in pictures]
    places = range(0, len(padded), 3)
    return np.concatenate([np.concatenate(padded[i : i + 3], axis=1) for i in places])


def _padded(picture, height, width):
    missing = height - picture.shape[0], width - picture.shape[1]
    gaps = [(one // 2, one - one // 2) for one in missing]
    return np.pad(picture, (*gaps, (0, 0)), constant_values=255)
