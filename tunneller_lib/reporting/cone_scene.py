"""Cones in space: on the way, in the model of planes, against a surface of lines."""

import numpy as np

from ..arguments import Point, checked
from ..envelopes import ConePose
from ..envelopes.isotropic import cone_rulings, plane_to_point
from . import scene
from .kinds import Curve, Grid
from .style import COLOURS

ROUND = np.linspace(0, 2 * np.pi, 1441)  # rad about an axis
FROM_THE_SIDE = 1, -1.3, 0.5  # towards the camera
FROM_ABOVE = 1, -1.6, 0.5


@checked
def moving_cone_picture(cone: ConePose, turn: Point, shift: Point):
    """Return a picture of a moving cone with its characteristic and two velocities of its axis.

    Parameters
    ----------
    cone : ConePose
        In m; it turns about its vertex.
    turn : (3,) float
        Angular velocity, in rad/s; zero for a translation, whose characteristic are rulings.
    shift : (3,) float
        Velocity of the vertex, in m/s.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    plotter = scene.empty()
    wall = scene.surface(cone.mesh(m=361))
    plotter.add_mesh(wall, color=COLOURS["cone"], opacity=0.45)
    for line in _characteristic(cone, turn, shift):
        plotter.add_mesh(scene.curve(line, 0.02), color=COLOURS["chord"])
    axis = np.array(cone.axis) / np.linalg.norm(cone.axis)
    for along in (cone.near, cone.far):
        end = along * np.cos(cone.half_angle) * axis
        speed = 0.6 * (np.array(shift) + np.cross(turn, end))
        foot = np.array(cone.vertex) + end
        plotter.add_mesh(scene.arrow(foot, speed, 0.025), color=COLOURS["correct"])
        plotter.add_mesh(scene.arrow(foot, speed @ axis * axis, 0.04), color=COLOURS["error"])
    return scene.shoot(plotter, direction=FROM_THE_SIDE)


def _characteristic(cone, turn, shift):
    """Return the parts of the characteristic that are on a cone, each a curve (n, 3)."""
    n, _ = cone.planes(ROUND)
    rulings = cone_rulings(cone.axis, cone.half_angle, ROUND)
    at_vertex = n @ np.array(shift)
    # Along a ruling the velocity's share in the normal grows linearly.
    growth = np.sum(n * np.cross(turn, rulings), axis=-1)
    if not np.any(turn):
        reach = np.linspace(cone.near, cone.far, 20)[:, None]
        found = [reach * rulings[k] for k in np.flatnonzero(np.diff(np.sign(at_vertex)))]
    else:
        along = -at_vertex / growth
        on_tool = (along > cone.near) & (along < cone.far)
        found = scene.kept_parts((along[:, None] * rulings)[:-1], on_tool[:-1])
    return [np.array(cone.vertex) + line for line in found]


@checked
def cone_on_sheet_picture(sheet: Grid, cone: ConePose, touched: Curve, direction: Point):
    """Return a picture of a cone that touches a `sheet` (n, m, 3) along a curve, all in m.

    The curve `touched` is (n, 3); `direction` (3,) points towards the camera.
    """
    plotter = scene.empty()
    plotter.add_mesh(scene.surface(sheet), color=COLOURS["design surface"], opacity=0.9)
    wall = scene.surface(cone.mesh(m=361))
    plotter.add_mesh(wall, color=COLOURS["cone"], opacity=0.45)
    plotter.add_mesh(scene.curve(touched, 0.03), color=COLOURS["chord"])
    return scene.shoot(plotter, direction=direction, zoom=1.5)


@checked
def cone_in_the_model_picture(cone: ConePose):
    """Return pictures of a cone with its normals, of these on the sphere, and of its conic.

    Parameters
    ----------
    cone : ConePose
        In m, of about a metre, none of its planes with the normal (0, 0, -1).

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    n, h = cone.planes(ROUND)
    points = plane_to_point(n, h)
    top = points * [1, 1, 0]
    views = [_with_normals(cone, n), _on_the_sphere(n, top), _over_its_circle(points, top)]
    return scene.side_by_side(*views)


def _with_normals(cone, n):
    plotter = scene.empty()
    wall = scene.surface(cone.mesh(m=361))
    plotter.add_mesh(wall, color=COLOURS["cone"], opacity=0.6)
    feet = np.array(cone.vertex) + 1.2 * cone_rulings(cone.axis, cone.half_angle, ROUND)
    for foot, direction in zip(feet[::60], 0.5 * n[::60], strict=True):
        arrow = scene.arrow(foot - direction, direction, 0.014)
        plotter.add_mesh(arrow, color=COLOURS["error"])
    return scene.shoot(plotter, direction=FROM_ABOVE)


def _on_the_sphere(n, top):
    plotter = scene.empty()
    ball = scene.ball((0, 0, 0), 1)
    plotter.add_mesh(ball, color=COLOURS["design surface"], opacity=0.35)
    plotter.add_mesh(scene.curve(n, 0.025), color=COLOURS["error"])
    plotter.add_mesh(scene.ball((0, 0, -1), 0.05), color=COLOURS["chord"])
    plotter.add_mesh(scene.curve(top, 0.025), color=COLOURS["top view"])
    for one in n[::180]:
        plotter.add_mesh(scene.curve([(0, 0, -1), one], 0.008), color=COLOURS["chord"])
    return scene.shoot(plotter, direction=(1, -1.6, 0.35))


def _over_its_circle(points, top):
    plotter = scene.empty()
    plotter.add_mesh(scene.curve(points, 0.025), color=COLOURS["cone"])
    plotter.add_mesh(scene.curve(top, 0.025), color=COLOURS["top view"])
    for foot, point in zip(top[::60], points[::60] + 1e-9, strict=True):
        plotter.add_mesh(scene.curve([foot, point], 0.006), color=COLOURS["chord"])
    return scene.shoot(plotter, direction=FROM_ABOVE)
