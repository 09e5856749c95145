"""Surfaces with planes and cones that touch them, in space and in the model of planes."""

from dataclasses import replace

import numpy as np

from kit import scene
from tunneller_lib.envelopes import adapted_frames, hyperosculating_cones, jet_variables
from tunneller_lib.envelopes.adapted import frames_along
from tunneller_lib.envelopes.isotropic import (
    conic,
    osculating_conic,
    plane_to_point,
    surface_points,
)

ROUND = np.linspace(0, 2 * np.pi, 361)  # rad about an axis


def tangent_planes_picture(surface, line, places, direction):
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
    lines = np.linspace(-0.9, 1.1, 81)
    along = np.linspace(0.05, 1.3, 41)
    sheet = np.stack(surface(*np.meshgrid(lines, along, indexing="ij")), axis=-1)
    plotter = scene.on_sheet(sheet, 0.55)
    for points in sheet[::10]:
        scene.put(plotter, scene.curve(points, 0.004), "chord")
    chosen = np.stack(surface(np.full(20, line), np.linspace(0.05, 1.3, 20)), axis=-1)
    scene.put(plotter, scene.curve(chosen, 0.012), "tangent sphere")
    frames = frames_along(surface, line, places)
    for middle, (ahead, across, _) in zip(frames.contact, frames.axes, strict=True):
        scene.put(plotter, scene.rectangle(middle, 0.3 * across, 0.12 * ahead), "plane")
    return scene.shoot(plotter, direction=direction, width=8)


def ring_on_graph_picture(f, place, centre):
    """Return a picture of a graph with a conic that osculates it, and the conic's top view below.

    Parameters
    ----------
    f : callable
        Of x and y, in m; drawn for x from 0.05 to 1.25 and y from -0.6 to 0.75.
    place : (2,) float
        Where the conic touches.
    centre : (2,) float
        From there to the centre of the circle beneath it.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    z, a, b = osculating_conic(centre, f(*jet_variables(*place)))
    circle = conic((*place, z), centre, a, b, ROUND)
    x, y = np.meshgrid(np.linspace(0.05, 1.25, 61), np.linspace(-0.6, 0.75, 61), indexing="ij")
    touch = (*place, z)
    foot = (*place, -0.3)
    middle = (*np.add(place, centre), -0.3)
    plotter = scene.on_sheet(np.stack([x, y, f(x, y)], axis=-1), 0.6)
    scene.put(plotter, scene.curve(circle, 0.01), "cone")
    scene.put(plotter, scene.curve(circle * [1, 1, 0] - [0, 0, 0.3], 0.01), "top view")
    scene.put(plotter, scene.ball(touch, 0.022), "error")
    for point in (foot, middle):
        scene.put(plotter, scene.ball(point, 0.022), "chord")
    scene.put(plotter, scene.curve([touch, foot], 0.004), "chord")
    letters = {
        "$(x,y,z)$": (touch, (-3.2, 0.6)),
        "$C^i_o$": (circle[120], (1.2, 0.6)),
        "$(x,y)$": (foot, (-2.6, -1.0)),
        "$(x+u,y+v)$": (middle, (0.6, -1.9)),
    }
    view = {"direction": (0.9, -1.1, 0.8), "zoom": 0.72}
    return scene.shoot(plotter, **view, letters=letters, width=6)


def cones_along_curve_picture(f, contacts, half_angle):
    """Return pictures of generators along a curve of contacts, in space and in the model.

    Parameters
    ----------
    f : callable
        Of x and y, in m: the graph of an envelope's tangent planes.
    contacts : (141, 2) float
        Places of the model, within x from 0.15 to 0.75 and y from 0.1 to 1.
    half_angle : float
        Of the cones, in rad.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    tools = hyperosculating_cones(f, *contacts[[30, 70, 110]].T, half_angle=half_angle)
    exact = np.flatnonzero(tools.undecided)  # generators
    alike = np.abs(tools.axis[exact] @ tools.axis[exact[0]])  # one of the two families of them
    family = [exact[np.argmax(np.where(tools.index[exact] == i, alike, -2))] for i in range(3)]
    x, y = np.meshgrid(np.linspace(0.15, 0.75, 61), np.linspace(0.1, 1.0, 61), indexing="ij")
    places = contacts, x, y
    return scene.side_by_side(
        _family_in_space(f, places, tools, family), _family_in_model(f, places, tools, family)
    )


def _family_in_space(f, places, tools, family):
    contacts, x, y = places
    plotter = scene.on_sheet(surface_points(f, x, y), 0.8)
    curve = surface_points(f, *contacts.T)
    scene.put(plotter, scene.curve(curve, 0.02), "generator")
    for k in family:
        pose = replace(tools[k].pose, near=tools.distance[k] - 0.5, far=tools.distance[k] + 0.5)
        scene.put(plotter, scene.surface(pose.mesh(m=181)), "cone", opacity=0.3)
    steps = np.arange(20, 141, 25)  # of the contacts whose planes are drawn
    there = adapted_frames(f, *contacts[steps].T, "isotropic")
    ahead = np.gradient(curve, axis=0)[steps]
    ahead *= 0.2 / np.linalg.norm(ahead, axis=-1, keepdims=True)
    for middle, way, n in zip(there.contact, ahead, there.axes[:, 2], strict=True):
        scene.put(plotter, scene.rectangle(middle, 0.5 * way, np.cross(n, way)), "error")
    letters = {
        "$c(t)$": (curve[-1], (0.6, 0.8)),
        "$D(t)$": (there.contact[1], (0.4, -1.8)),
        r"$\Phi$": (surface_points(f, 0.2, 0.15), (-0.6, 0)),
    }
    k = family[1]
    aside = np.cross(tools.normal[k], tools.axis[k])
    above = tools.side[k] * tools.normal[k]
    view = {"direction": 0.7 * aside - above - 0.3 * tools.axis[k], "zoom": 1.0}
    return scene.shoot(plotter, **view, letters=letters, width=7)


def _family_in_model(f, places, tools, family):
    contacts, x, y = places
    plotter = scene.on_sheet(np.stack([x, y, f(x, y)], axis=-1), 0.6)
    line = np.column_stack([contacts, f(*contacts.T)])
    scene.put(plotter, scene.curve(line, 0.008), "generator")
    for k in family:
        circle = plane_to_point(*tools[k].planes(ROUND))
        near = np.abs(circle[:, :2] - [0.45, 0.55]).max(axis=1) < 0.5
        for arc in scene.kept_parts(circle[:-1], near[:-1]):
            scene.put(plotter, scene.curve(arc, 0.008), "cone")
    letters = {
        "$D^i(t)$": (line[-1], (0.3, 0.9)),
        r"$\Phi^i$": ((0.72, 0.95, f(0.72, 0.95)), (0.8, 0.2)),
        "$C^i$": (arc[0], (-0.4, 1.0)),
    }
    return scene.shoot(plotter, direction=(1, -1.2, 0.9), zoom=1.0, letters=letters, width=7)
