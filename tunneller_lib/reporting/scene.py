"""Pictures of surfaces in space, drawn without a screen."""

import os

# VTK chooses its window when it is imported.
if "DISPLAY" not in os.environ:
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import pyvista

from ..envelopes.isotropic import cone_rulings
from . import gl
from .camera import crop, look, shoot

__all__ = ["arrow", "ball", "beside", "cone", "crop", "curve", "look", "pieces", "rectangle",
           "rows", "scene", "shoot", "surface"]  # fmt: skip

# Lights as the camera sees them, x to the right and y up: one in front, two from above.
LIGHTS = [((0, 0, 1), 0.6), ((-1, 1, 1), 0.35), ((1, 0.6, 0.4), 0.2)]

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
        line["values"] = np.asarray(values, dtype=float)
    return line.tube(radius=radius, n_sides=12)


def rectangle(middle, a, b):
    """Return a mesh of a rectangle, its middle (3,) and half its sides as vectors (3,), in m."""
    return surface([[middle - a - b, middle - a + b], [middle + a - b, middle + a + b]])


def pieces(points, keep):
    """Return the parts of a closed curve's points (n, 3) where `keep` (n,) is True, as a list.

    Examples
    --------
    >>> import numpy as np
    >>> points = np.arange(8)[:, None] * np.ones(3)
    >>> [part[:, 0].tolist() for part in pieces(points, np.array([1, 1, 0, 0, 1, 1, 0, 1]) > 0)]
    [[4.0, 5.0], [7.0, 0.0, 1.0]]
    """
    start = np.argmin(keep)  # so that no part is cut in two
    points, keep = np.roll(points, -start, axis=0), np.roll(keep, -start)
    parts = np.split(points, np.flatnonzero(np.diff(keep)) + 1)
    return [part for part in parts[int(not keep[0]) :: 2] if len(part) > 1]


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
    rulings = cone_rulings(axis, half_angle, np.linspace(0, 2 * np.pi, 361))
    return surface(np.asarray(vertex) + np.linspace(near, far, 25)[:, None, None] * rulings)


def arrow(start, vector, radius):
    """Return a mesh of an arrow from `start` along `vector`, its shaft's `radius` in m."""
    length = float(np.linalg.norm(vector))
    return pyvista.Arrow(start=start, direction=vector, scale=length, shaft_radius=radius / length,
                         tip_radius=2.5 * radius / length, shaft_resolution=24, tip_resolution=24,
                         tip_length=min(0.4, 8 * radius / length))  # fmt: skip


def beside(*pictures):
    """Return pictures (n, m, 3) side by side on white, each in the middle of the height."""
    height = max(len(picture) for picture in pictures)
    return np.concatenate([_padded(p, height, p.shape[1]) for p in pictures], axis=1)


def rows(pictures, columns):
    """Return pictures (n, m, 3) in rows of so many on white, each in the middle of its place.

    Examples
    --------
    >>> import numpy as np
    >>> rows([np.zeros((4, 6, 3)), np.zeros((2, 3, 3)), np.ones((4, 6, 3)), np.ones((1, 1, 3))],
    ...      columns=2).shape
    (8, 12, 3)
    """
    height, width = np.max([picture.shape[:2] for picture in pictures], axis=0)
    padded = [_padded(picture, height, width) for picture in pictures]
    places = range(0, len(padded), columns)
    return np.concatenate([np.concatenate(padded[i : i + columns], axis=1) for i in places])


def _padded(picture, height, width):
    gaps = [(size - had) // 2 for size, had in zip((height, width), picture.shape[:2], strict=True)]
    rest = [
        size - had - gap
        for size, had, gap in zip((height, width), picture.shape[:2], gaps, strict=True)
    ]
    return np.pad(picture, (*zip(gaps, rest, strict=True), (0, 0)), constant_values=255)
