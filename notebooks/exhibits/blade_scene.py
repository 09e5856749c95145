"""Conical tools between the blades of a ring."""

import numpy as np

from kit import scene

LOOKS = {"fits": "cone", "hits a blade": "generator", "gouges": "error"}
FROM_OUTSIDE = 1, 0.4, 0.9  # towards the camera


def tools_scene(ring, cones, show, verdicts, towards, away):
    """Return a scene of three blades with tools that touch the first one.

    Parameters
    ----------
    ring : BladeRing
        The blades.
    cones : Cones
        In contact with the first blade.
    show : (k,) bool
        Which of them are drawn.
    verdicts : list of str
        Of each cone: "fits" is green, "hits a blade" ochre, "gouges" red.
    towards, away : float
        How far a tool reaches from the contact to the vertex and away from it, in m.

    Returns
    -------
    plotter : pyvista.Plotter
        The scene, its camera set.
    """
    plotter = scene.empty()
    angle, z = np.meshgrid(np.radians(np.linspace(-85, 85, 81)), np.array([-0.028, 0.028]))
    inner = 0.995 * ring.hub
    hub = np.stack([inner * np.cos(angle), inner * np.sin(angle), z], axis=-1)
    scene.put(plotter, scene.surface(hub), "torus")
    for blade in (0, 1, -1):  # the others are hidden, and the ring large
        colour = "tunnel" if blade else "design surface"
        scene.put(plotter, scene.surface(ring.mesh(41, blade)), colour)
    for k in np.flatnonzero(show):
        wall = scene.surface(cones[k].tool(towards, away).mesh(m=181))
        scene.put(plotter, wall, LOOKS[verdicts[k]], opacity=0.6)
        plotter.add_mesh(scene.ball(cones.contact[k], 0.0015), color="white")
    return scene.look(plotter, FROM_OUTSIDE)


def each_tool_picture(ring, cones, verdicts, towards, away):
    """Return a picture of each tool at one contact, with its letter and verdict.

    Parameters
    ----------
    ring, cones, verdicts, towards, away
        As for `tools_scene`.

    Returns
    -------
    picture : (n, m, 3) uint8
        In rows of three.
    """
    views = []
    amid = (0, 0, 0.6 * ring.chord)  # in the ring, where nothing is drawn
    for k, verdict in enumerate(verdicts):
        only = np.arange(len(cones)) == k
        plotter = tools_scene(ring, cones, only, verdicts, towards, away)
        plotter.window_size = [2000, 1750]
        letters = {f"{chr(97 + k)}  {verdict}": (amid, (0, 0))}
        view = {"direction": FROM_OUTSIDE, "zoom": 1.2}
        views.append(scene.shoot(plotter, **view, letters=letters, width=5))
    return scene.rows(views)


def tool_sequence_picture(ring, cones, show, places, towards, away):
    """Return a picture of tools that fit along a blade; where none is shown there is a red dot.

    Parameters
    ----------
    ring, cones, show
        As for `tools_scene`; those shown fit.
    places : (n, 3) float
        The points along the blade, by the index of `cones`, in m.
    towards, away
        As for `tools_scene`.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    plotter = tools_scene(ring, cones, show, ["fits"] * len(cones), towards, away)
    letters = {}
    for i in set(range(len(places))) - set(cones.index[show].tolist()):
        ahead = 0.1 * np.array(FROM_OUTSIDE)  # in front of all cones, at the same place seen
        scene.put(plotter, scene.ball(places[i] + ahead, 0.002), "error")
        letters |= {"none fits": (places[i], (-3.5, -1.5))}
    return scene.shoot(plotter, direction=FROM_OUTSIDE, letters=letters, width=5.5)
