"""Surfaces with planes and cones that touch them, in space and in the model of planes."""

import numpy as np

from ..arguments import Finite, Point, checked
from ..envelopes.adapted import frames_along
from ..envelopes.functions import Function
from . import scene
from .kinds import Series
from .style import COLOURS


@checked
def tangent_planes_picture(surface: Function(2), line: Finite, places: Series, direction: Point):
    """Return a picture of a surface of lines with pieces of its tangent planes along one of them.

    Parameters
    ----------
    surface : callable
        Of the line s and the place t along it, three coordinates in m; drawn where s is from -0.9
        to 1.1 and t from 0.05 to 1.3.
    line : float
        Which line.
    places : (n,) float
        Where along it.
    direction : (3,) float
        Towards the camera.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    lines, along = np.linspace(-0.9, 1.1, 81), np.linspace(0.05, 1.3, 41)
    sheet = np.stack(surface(*np.meshgrid(lines, along, indexing="ij")), axis=-1)
    plotter = scene.empty()
    plotter.add_mesh(scene.surface(sheet), color=COLOURS["design surface"], opacity=0.55)
    for points in sheet[::10]:
        plotter.add_mesh(scene.curve(points, 0.004), color=COLOURS["chord"])
    chosen = np.stack(surface(np.full(20, line), np.linspace(0.05, 1.3, 20)), axis=-1)
    plotter.add_mesh(scene.curve(chosen, 0.012), color=COLOURS["tangent sphere"])
    frames = frames_along(surface, line, places)
    for middle, (ahead, across, _) in zip(frames.contact, frames.axes, strict=True):
        mesh = scene.rectangle(middle, 0.3 * across, 0.12 * ahead)
        plotter.add_mesh(mesh, color=COLOURS["plane"])
    return scene.shoot(plotter, direction=direction)
