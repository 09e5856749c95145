"""All cones at one contact, in space and in the model of planes."""

from dataclasses import replace

import numpy as np

from kit import scene
from tunneller_lib.envelopes import adapted_frames, hyperosculating_cones
from tunneller_lib.envelopes.isotropic import (
    cone_planes,
    cone_rulings,
    plane_azimuth,
    plane_to_point,
    surface_points,
)
from tunneller_lib.envelopes.measured import mean_frame

from .envelope_plot import cone_colours

ROUND = np.linspace(0, 2 * np.pi, 361)  # rad about an axis


def contact_scene(f, place, half_angle):
    """Return a scene of the surface about a contact with its generators and rods to all vertices.

    Parameters
    ----------
    f : callable
        Of x and y, in m.
    place : (2,) float
        The contact in the model.
    half_angle : float
        Of the cones, in rad.

    Returns
    -------
    plotter : pyvista.Plotter
        The scene, its camera set.
    """
    far = np.linspace(-0.35, 0.35, 41) * np.hypot(*place)
    sheet = surface_points(f, *np.meshgrid(place[0] + far, place[1] + far, indexing="ij"))
    cones = hyperosculating_cones(f, *place, half_angle=half_angle)
    size = np.ptp(sheet, axis=(0, 1)).max() / 2
    plotter = scene.on_sheet(sheet)
    for k, colour in enumerate(cone_colours(cones)):
        rod = size / cones.distance[k] * (cones.vertex[k] - cones.contact[k]) + cones.contact[k]
        plotter.add_mesh(scene.curve([cones.contact[k], rod], size / 60), color=colour)
    for k in np.flatnonzero(cones.undecided):
        scene.put(plotter, _leaf(cones, k, size), "generator", opacity=0.6)
    frame = adapted_frames(f, *np.array(place)[:, None], "isotropic").axes[0]
    return scene.look(plotter, [1, 1, 3] @ frame, frame[2])


def _leaf(cones, k, size):
    """Return the part of a cone near its contact."""
    distance = cones.distance[k]
    far = min(np.pi, size / 2 / distance / np.sin(cones.half_angle)) * np.linspace(-1, 1, 81)
    return _piece(cones, k, np.linspace(max(distance - size, 0), distance + size, 25), far)


def _piece(cones, k, along, spread):
    """Return a part of a cone: places along its rulings, turns about its axis from the contact."""
    lean = cones.axis[k], cones.half_angle
    touched = plane_azimuth(*lean, cones.side[k] * cones.normal[k])
    rulings = cone_rulings(*lean, touched + spread)
    return scene.surface(cones.vertex[k] + along[:, None, None] * rulings)


def cones_at_contact_picture(sheet, cones):
    """Return a picture of each cone on a surface, three a row, from the side of its tool.

    Parameters
    ----------
    sheet : (n, m, 3) float
        Of the surface about the contact, in m.
    cones : Cones
        At one contact.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    size = np.ptp(sheet, axis=(0, 1)).max()
    spread = np.linspace(-0.9, 0.9, 181)  # rad round the axis, from the contact
    aslant = (0.9 * (sheet[-1, 0] - sheet[0, 0]) - 0.5 * (sheet[0, -1] - sheet[0, 0])) / size
    pictures = []
    for k, side in enumerate(cones.side):
        along = cones.distance[k] + 3 / 8 * size * np.linspace(-1, 1, 3)
        plotter = scene.on_sheet(sheet)
        scene.put(plotter, _piece(cones, k, along, spread), "cone", opacity=0.6)
        scene.put(plotter, scene.ball(cones.contact[k], size / 45), "error")
        up = side * cones.normal[k]
        view = {"direction": aslant + up, "up": up, "zoom": 1.0}
        pictures.append(scene.shoot(plotter, **view, width=5))
    return scene.rows(pictures)


def six_rulings_picture(sheet, f, place, half_angle):
    """Return pictures of all rulings at a contact, and of one of the generators there.

    Parameters
    ----------
    sheet : (n, m, 3) float
        Of the surface about the contact, in m.
    f : callable
        Its graph in the model, of x and y, in m.
    place : (2,) float
        The contact in the model, where there are generators.
    half_angle : float
        Of the cones, in rad.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    cones = hyperosculating_cones(f, *place, half_angle=half_angle)
    best = np.flatnonzero(cones.undecided)[0]
    contact, normal = cones.contact[0], cones.normal[0]
    above = cones.side[best] * normal
    plotter = scene.on_sheet(sheet, 0.5)
    ends = _rods(plotter, cones, np.ones(len(cones)))
    scene.put(plotter, scene.ball(contact + 0.03 * above, 0.06), "error")
    right = np.cross([0.0, 0.0, 1.0], above)  # in the picture
    right = right / np.linalg.norm(right)
    aside = 1.2 * (ends - contact) @ np.transpose([right, np.cross(above, right)])
    letters = {str(k + 1): (end, tuple(aside[k])) for k, end in enumerate(ends)}
    counted = scene.shoot(plotter, direction=above, zoom=1.0, letters=letters, width=5)

    [planes] = _arcs(cones, best, place, 0.2)
    touched = scene.curve(surface_points(f, *planes[:, :2].T), 0.025)
    plotter = _on_sheet(sheet, touched, cones, best, (0, 1.5, 1.0))
    _rods(plotter, cones, np.minimum(cones.distance, 3))
    across = np.cross(normal, cones.axis[best])
    letters = {"r": (contact, (-0.9, 0.7)), "v": (cones.vertex[best], (0.2, -1.0))}
    whole = scene.shoot(plotter, direction=0.8 * across + above, letters=letters, width=5)
    plotter = _on_sheet(sheet, touched, cones, best, (0.6, 1.4, 0.6))
    ahead = cones.axis[best] + 0.4 * normal
    del letters["v"]
    close = scene.shoot(plotter, direction=ahead, letters=letters, width=5)
    return scene.side_by_side(counted, whole, close)


def _rods(plotter, cones, lengths):
    """Add a rod towards each vertex, those of generators black, and return their ends (k, 3)."""
    ways = (cones.vertex - cones.contact) / cones.distance[:, None]
    ends = cones.contact + lengths[:, None] * ways
    for start, end, exact in zip(cones.contact, ends, cones.undecided, strict=True):
        scene.put(plotter, scene.curve([start, end], 0.025), "chord" if exact else "cone")
    return ends


def _arcs(cones, k, middle, limit):
    """Return the parts of a cone's conic in the model that are near a place."""
    p = plane_to_point(*cones[k].planes(ROUND[:-1]))
    return scene.kept_parts(p, np.hypot(p[:, 0] - middle[0], p[:, 1] - middle[1]) < limit)


def _wall(cone, near, far):
    """Return a part of a cone, by shares of the distance from its vertex to the contact."""
    reach = cone.pose.far / 2
    return scene.surface(replace(cone.pose, near=near * reach, far=far * reach).mesh())


def _on_sheet(sheet, touched, cones, k, part):
    near, far, opacity = part
    plotter = scene.on_sheet(sheet, opacity)
    scene.put(plotter, _wall(cones[k], near, far), "generator", opacity=0.5)
    scene.put(plotter, touched, "tangent sphere")
    scene.put(plotter, scene.ball(cones.contact[k], 0.05), "error")
    return plotter


def noisy_cones_picture(sheet, contact, n, cones, noisy):
    """Return pictures of noisy planes and of the cones at one place, found and exact.

    Parameters
    ----------
    sheet : (n, m, 3) float
        Of the surface about the place, in m.
    contact, n : (k, 3) float
        Noisy planes: points, in m, and unit normals.
    cones, noisy : Cones
        At the place: exact, and found from the planes.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    top = mean_frame(n)
    here = cones.contact[0]
    points = plane_to_point(n @ top.T, -np.sum(n * (contact - here), axis=-1))
    plotter = scene.empty()
    near = points[np.hypot(*points[:, :2].T) < 0.5]
    look = {"render_points_as_spheres": True, "point_size": 6}
    scene.put(plotter, near, "design surface", **look)
    for arc in _arcs_seen(cones, top, here):
        scene.put(plotter, scene.curve(arc, 0.004), "cone")
    for arc in _arcs_seen(noisy, top, here):
        for i in range(0, len(arc) - 5, 10):
            part = scene.curve(arc[i : i + 5], 0.006)
            scene.put(plotter, part, "tangent sphere")
    model = scene.shoot(plotter, direction=(0.5, -1, 1.2), zoom=1.0, width=8)

    plotter = scene.on_sheet(sheet, 0.5)
    _rods(plotter, cones, np.ones(len(cones)))
    for way in (noisy.vertex - here) / noisy.distance[:, None]:
        for start in np.arange(0.1, 1, 0.2):
            part = scene.curve(here + np.outer([start, start + 0.08], way), 0.035)
            scene.put(plotter, part, "tangent sphere")
    best = np.flatnonzero(cones.undecided)[0]
    same = int(np.argmax(np.abs(noisy.axis @ cones.axis[best])))
    scene.put(plotter, _wall(cones[best], 0, 1.4), "generator", opacity=0.4)
    scene.put(plotter, _wall(noisy[same], 0, 1.4), "tangent sphere", opacity=0.2)
    across = np.cross(cones.normal[0], cones.axis[best])
    above = cones.side[best] * cones.normal[0]
    space = scene.shoot(plotter, direction=0.4 * across + above, zoom=1.0, width=8)
    return scene.side_by_side(model, space)


def _arcs_seen(cones, top, here):
    """Return parts of the cones' conics near the middle of a model in another frame."""
    found = []
    for cone in cones:
        axis = cone.side * (top @ cone.pose.axis)
        vertex = top @ (np.array(cone.pose.vertex) - here)
        p = plane_to_point(*cone_planes(vertex, axis, cones.half_angle, ROUND[:-1]))
        found += scene.kept_parts(p, np.hypot(*p[:, :2].T) < 0.4)
    return found


def double_cones_picture(sheet, cones):
    """Return a picture of a `sheet` (n, m, 3) and of those cones at a contact that are multiple."""
    size = np.ptp(sheet, axis=(0, 1)).max()
    plotter = scene.on_sheet(sheet)
    for k in np.flatnonzero(cones.multiplicity > 1):
        scene.put(plotter, _leaf(cones, k, 0.35 * size), "cone", opacity=0.5)
        reach = 0.35 * size / cones.distance[k]
        ruling = np.outer([-reach, reach], cones.vertex[k] - cones.contact[k])
        scene.put(plotter, scene.curve(cones.contact[k] + ruling, size / 150), "chord")
    scene.put(plotter, scene.ball(cones.contact[0], size / 50), "error")
    return scene.shoot(plotter, direction=(1.0, -0.35, 0.9), zoom=1.0, width=8)
