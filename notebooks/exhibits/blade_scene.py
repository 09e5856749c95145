"""Conical tools between the blades of a ring."""

import numpy as np

from kit import scene
from kit.kinds import Flags, Lines
from kit.style import COLOURS
from tunneller_lib.arguments import Length, Points, checked
from tunneller_lib.envelopes.blade import BladeRing
from tunneller_lib.envelopes.hyperosculate import Cones

LOOKS = {"fits": "cone", "hits a blade": "generator", "gouges": "error"}
FROM_OUTSIDE = 1, 0.4, 0.9  # towards the camera


@checked
def tools_scene(
    ring: BladeRing, cones: Cones, show: Flags, verdicts: Lines, towards: Length, away: Length
):
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
    plotter.add_mesh(scene.surface(hub), color=COLOURS["torus"])
    for blade in (0, 1, -1):  # the others are hidden, and the ring large
        colour = COLOURS["tunnel" if blade else "design surface"]
        plotter.add_mesh(scene.surface(ring.mesh(41, blade)), color=colour)
    for k in np.flatnonzero(show):
        wall = scene.surface(cones[k].tool(towards, away).mesh(m=181))
        plotter.add_mesh(wall, color=COLOURS[LOOKS[verdicts[k]]], opacity=0.6)
        plotter.add_mesh(scene.ball(cones.contact[k], 0.0015), color="white")
    return scene.look(plotter, FROM_OUTSIDE)


@checked
def each_tool_picture(
    ring: BladeRing, cones: Cones, verdicts: Lines, towards: Length, away: Length
):
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
        plotter = tools_scene.unchecked(ring, cones, only, verdicts, towards, away)
        plotter.window_size = [800, 700]
        letters = {f"{chr(97 + k)}  {verdict}": (amid, (0, 0))}
        view = {"direction": FROM_OUTSIDE, "zoom": 1.2}
        views.append(scene.shoot(plotter, **view, letters=letters, width=5))
    return scene.rows(views, columns=3)


@checked
def tool_sequence_picture(
    ring: BladeRing, cones: Cones, show: Flags, places: Points, towards: Length, away: Length
):
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
    plotter = tools_scene.unchecked(ring, cones, show, ["fits"] * len(cones), towards, away)
    letters = {}
    for i in set(range(len(places))) - set(cones.index[show].tolist()):
        ahead = 0.1 * np.array(FROM_OUTSIDE)  # in front of all cones, at the same place seen
        plotter.add_mesh(scene.ball(places[i] + ahead, 0.002), color=COLOURS["error"])
        letters |= {"none fits": (places[i], (-3.5, -1.5))}
    return scene.shoot(plotter, direction=FROM_OUTSIDE, letters=letters, width=5.5)
