"""Cones in space: on the way, in the model of planes, against a surface of lines."""

import numpy as np

from kit import scene
from tunneller_lib.envelopes.developable import curve_derivatives, tangent_planes
from tunneller_lib.envelopes.isotropic import cone_rulings, plane_to_point

ROUND = np.linspace(0, 2 * np.pi, 1441)  # rad about an axis
FROM_THE_SIDE = 1, -1.3, 0.5  # towards the camera
FROM_ABOVE = 1, -1.6, 0.5
ALONG_THE_EDGE = 0.3, -1, 0.9


def moving_cone_picture(cone, turn, shift):
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
    scene.put(plotter, scene.surface(cone.mesh(m=361)), "cone", opacity=0.45)
    for line in _characteristic(cone, turn, shift):
        scene.put(plotter, scene.curve(line, 0.02), "chord")
    axis = np.array(cone.axis) / np.linalg.norm(cone.axis)
    for along in (cone.near, cone.far):
        end = along * np.cos(cone.half_angle) * axis
        speed = 0.6 * (np.array(shift) + np.cross(turn, end))
        foot = np.array(cone.vertex) + end
        scene.put(plotter, scene.arrow(foot, speed, 0.025), "correct")
        scene.put(plotter, scene.arrow(foot, speed @ axis * axis, 0.04), "error")
    return scene.shoot(plotter, direction=FROM_THE_SIDE, width=5)


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


def cone_on_sheet_picture(sheet, cone, touched, direction):
    """Return a picture of a cone that touches a `sheet` (n, m, 3) along a curve, all in m.

    The curve `touched` is (n, 3); `direction` (3,) points towards the camera.
    """
    plotter = scene.on_sheet(sheet, 0.9)
    scene.put(plotter, scene.surface(cone.mesh(m=361)), "cone", opacity=0.45)
    scene.put(plotter, scene.curve(touched, 0.03), "chord")
    return scene.shoot(plotter, direction=direction, zoom=1.5, width=5)


def cone_in_the_model_picture(cone):
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
    plotter = scene.empty()
    scene.put(plotter, scene.surface(cone.mesh(m=361)), "cone", opacity=0.6)
    feet = np.array(cone.vertex) + 1.2 * cone_rulings(cone.axis, cone.half_angle, ROUND)
    for foot, direction in zip(feet[::60], 0.5 * n[::60], strict=True):
        scene.put(plotter, scene.arrow(foot - direction, direction, 0.014), "error")
    normals = scene.shoot(plotter, direction=FROM_ABOVE, width=5)

    plotter = scene.empty()
    scene.put(plotter, scene.ball((0, 0, 0), 1), "design surface", opacity=0.35)
    scene.put(plotter, scene.curve(n, 0.025), "error")
    scene.put(plotter, scene.ball((0, 0, -1), 0.05), "chord")
    scene.put(plotter, scene.curve(top, 0.025), "top view")
    for one in n[::180]:
        scene.put(plotter, scene.curve([(0, 0, -1), one], 0.008), "chord")
    sphere = scene.shoot(plotter, direction=(1, -1.6, 0.35), width=5)

    plotter = scene.empty()
    scene.put(plotter, scene.curve(points, 0.025), "cone")
    scene.put(plotter, scene.curve(top, 0.025), "top view")
    for foot, point in zip(top[::60], points[::60] + 1e-9, strict=True):
        scene.put(plotter, scene.curve([foot, point], 0.006), "chord")
    model = scene.shoot(plotter, direction=FROM_ABOVE, width=5)
    return scene.side_by_side(normals, sphere, model)


def osculating_cone_picture(sheet, cone, ruling, corner):
    """Return a picture of a surface and a cone through it that touch along a ruling, with letters.

    Parameters
    ----------
    sheet : (n, m, 3) float
        Of the surface, in m.
    cone : ConePose
        In m.
    ruling : (3,) float
        Along the ruling, from the vertex.
    corner : (3,) float
        Of the sheet, where its letter stands, in m.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    plotter = scene.on_sheet(sheet)
    scene.put(plotter, scene.surface(cone.mesh(m=1000)), "cone", opacity=0.5)
    vertex = np.array(cone.vertex)
    way = np.array(ruling) / np.linalg.norm(ruling)
    line = vertex + np.linspace(cone.near, cone.far, 9)[:, None] * way
    scene.put(plotter, scene.curve(line, 0.02), "tangent sphere")
    around = vertex + (cone.far - 0.1) * cone_rulings(cone.axis, cone.half_angle, ROUND[::4])
    opposite = around[np.argmax(np.linalg.norm(around - line[-1], axis=1))]
    letters = {
        "$C$": (corner, (-1.0, 0.2)),
        "$C_o$": (opposite, (-0.5, 1.2)),
        "v": (vertex, (-0.9, -0.7)),
    }
    return scene.shoot(plotter, direction=ALONG_THE_EDGE, letters=letters, width=6.6)


def osculating_ring_picture(cone, curve, touch):
    """Return a picture of a cone's conic and the curve of a developable surface in the model.

    Parameters
    ----------
    cone : ConePose
        In m.
    curve : (n, 3) float
        Points of the model: the tangent planes of the surface.
    touch : (3,) float
        The plane that both have in common.

    Returns
    -------
    picture : (n, m, 3) uint8
        With both top views below.
    """
    circle = plane_to_point(*cone.planes(ROUND[::4]))
    below = np.array([0, 0, circle[:, 2].min() - 0.15])
    thick = 0.008 * np.ptp(circle, axis=0).max()
    plotter = scene.empty()
    # The curve's tubes are thicker, where the circle's would hide them.
    for line, colour, top, size in [
        (circle, "cone", "top view", thick),
        (curve, "chord", "tunnel", 1.4 * thick),
    ]:
        scene.put(plotter, scene.curve(line, size), colour)
        scene.put(plotter, scene.curve(line * [1, 1, 0] + below, size), top)
    scene.put(plotter, scene.ball(touch, 2.5 * thick), "tangent sphere")
    opposite = circle[np.argmax(np.linalg.norm(circle - np.array(touch), axis=1))]
    letters = {
        "$C^i$": (curve[0], (1.2, 0.2)),
        "$C^i_o$": (opposite, (-1.5, 0.3)),
        "top view": (circle.mean(axis=0) * [1, 1, 0] + below, (0, 0)),
    }
    view = {"direction": (0.5, -1, 0.7), "zoom": 1.0}
    return scene.shoot(plotter, **view, letters=letters, width=4.6)


def plane_fans_picture(curve, place, cone):
    """Return pictures of neighbouring planes: of a curve's tangents, and of their osculating cone.

    Parameters
    ----------
    curve : callable
        Of its parameter: three coordinates in m.
    place : float
        The parameter where the `cone` osculates; the plane there is red.
    cone : ConePose
        In m.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    vertex = np.array(cone.vertex)
    normals, _ = cone.planes(ROUND[::4])
    steps = place + 0.12 * np.array([-3, -2, -1, 1, 2, 3, 0])
    own, _ = tangent_planes(curve, steps)
    starts, ways, *_ = curve_derivatives(curve, steps)
    # For each of the surface's planes the cone's with the nearest normal.
    near = normals[np.argmax(own @ normals.T, axis=1)]
    near[-1] = own[-1]
    rulings = np.array(cone.axis) - np.sin(cone.half_angle) * near
    surface = _fan(starts, ways, own, "design surface", "$C$")
    tool = _fan(0 * starts + vertex, rulings, near, "cone", "$C_o$", "v")
    return scene.side_by_side(surface, tool)


def _fan(starts, ways, normals, colour, name, start=None):
    """Return a picture of rectangles along rulings, black, the last one red, named at its ends."""
    plotter = scene.empty()
    ahead = 0.9 * ways / np.linalg.norm(ways, axis=-1, keepdims=True)
    across = 0.5 * np.cross(normals, ahead)
    looks = [(colour, 0.15)] * (len(starts) - 1) + [("error", 0.6)]
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    for middle, *sides, (shown, opacity) in zip(starts + ahead, ahead, across, looks, strict=True):
        scene.put(plotter, scene.rectangle(middle, *sides), shown, opacity=opacity)
        scene.put(plotter, scene.curve(middle + corners @ sides, 0.006), shown)
        ruling = np.array([middle - sides[0], middle + sides[0]])
        scene.put(plotter, scene.curve(ruling, 0.012), "chord")
    letters = {name: (starts[-1] + 2 * ahead[-1], (1.4, 0.4))}
    if start:
        letters[start] = starts[-1], (-0.9, -0.7)
    return scene.shoot(plotter, direction=ALONG_THE_EDGE, letters=letters, width=4.4)
