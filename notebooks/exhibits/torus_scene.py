"""The torus in space: its working patch with a grid, and the whole of it, cut open."""

import numpy as np

from kit import scene
from kit.kinds import Series
from kit.style import COLOURS
from tunneller_lib.arguments import checked, shown
from tunneller_lib.surfaces import Torus


@checked
def grid_picture(torus: Torus, theta: Series, phi: Series):
    """Return a picture of a patch of the torus, ruled by meridians and parallels (Fig. 2).

    Parameters
    ----------
    torus : Torus
        The surface, in m.
    theta, phi : (n,) float
        The grid's angles, in rad; the letters say its ends and where both are 0.

    Returns
    -------
    picture : (n, m, 3) uint8

    Raises
    ------
    ValueError
        If an angle's ends don't lie to either side of 0.
    """
    for name, angles in {"theta": theta, "phi": phi}.items():
        if not angles[0] < 0 < angles[-1]:
            raise ValueError(f"{name}: must run from below 0 to above it; got {shown(angles)}.")
    plotter = scene.empty()
    fine = (np.linspace(angles[0], angles[-1], 120) for angles in (theta, phi))
    patch = scene.surface(torus.point(*np.meshgrid(*fine, indexing="ij")))
    plotter.add_mesh(patch, color=COLOURS["torus"], smooth_shading=True)
    along = np.linspace(0, 1, 120)
    lines = [torus.point(t, phi[0] + (phi[-1] - phi[0]) * along) for t in theta]
    lines += [torus.point(theta[0] + (theta[-1] - theta[0]) * along, p) for p in phi]
    for points in lines:
        plotter.add_mesh(scene.curve(points, 0.0015), color=COLOURS["chord"])
    plotter.window_size = 1300, 975
    ends = np.degrees([theta[0], theta[-1], phi[0], phi[-1]])
    told = [f"{end:.0f}" for end in ends]
    letters = {
        rf"$\varphi = {told[2]}$°": (torus.point(0.0, phi[0]), (-2.4, 0)),
        rf"$\varphi = {told[3]}$°": (torus.point(0.0, phi[-1]), (2.0, 0)),
        rf"$\theta = {told[0]}$°": (torus.point(theta[0], 0.0), (0, 0.8)),
        rf"$\theta = {told[1]}$°": (torus.point(theta[-1], 0.0), (0, -0.8)),
        r"$\theta = \varphi = 0$": (torus.point(0.0, 0.0), (0, 0.8)),
    }
    plotter.add_mesh(scene.ball(torus.point(0.0, 0.0), 0.01), color=COLOURS["chord"])
    return scene.shoot(plotter, direction=(1.6, -0.5, 0.4), zoom=1.0, letters=letters, width=8)


@checked
def entire_torus_picture(torus: Torus):
    """Return pictures of a whole spindle torus: closed, and with a quarter cut away (Fig. 3).

    Parameters
    ----------
    torus : Torus
        The surface, in m, with R > r.

    Returns
    -------
    picture : (n, m, 3) uint8

    Raises
    ------
    ValueError
        If the torus is a ring, which has no inner sheet.
    """
    if torus.R <= torus.r:
        raise ValueError(f"torus: must have R > r; got R = {torus.R:g} m and r = {torus.r:g} m.")
    node = np.arccos(-torus.r / torus.R)
    round_it = np.linspace(0, 2 * np.pi, 200)
    apple = _sheet(torus, np.linspace(0, np.radians(270), 200), -node, node)
    lemon = _sheet(torus, round_it, node, 2 * np.pi - node)
    nodes = torus.point(np.zeros(2), np.array([-node, node]))
    axis = 1.2 * nodes  # through the nodes, and a little beyond
    aslant = {"node": (nodes[0], (1.6, 0.6)), "axis": (axis[0], (-1, -0.7))}
    whole = [(_sheet(torus, round_it, -node, node), "torus")]
    outside = _with_nodes(whole, nodes, (1.0, -1.4, 0.8), aslant)
    across = {
        "node": (nodes[0], (-1.7, 0.7)),
        "node ": (nodes[1], (1.7, 0.7)),
        "inner sheet": (torus.point(-0.6, 0.0), (0, 0)),
        "outer sheet": (torus.point(np.pi / 2, 0.0), (0, 0)),
    }
    opened = [(apple, "torus"), (lemon, "inner sheet")]
    inside = _with_nodes(opened, nodes, (1.0, 0.0, 0.8), across)
    return scene.side_by_side(outside, inside)


def _sheet(torus, theta, low, high):
    phi = np.linspace(low, high, 200)
    return torus.point(*np.meshgrid(theta, phi, indexing="ij"))


def _with_nodes(sheets, nodes, direction, letters):
    plotter = scene.empty()
    plotter.window_size = 1000, 800
    for sheet, colour in sheets:
        plotter.add_mesh(scene.surface(sheet), color=COLOURS[colour], smooth_shading=True)
    plotter.add_mesh(scene.curve(1.2 * nodes, 0.006), color=COLOURS["chord"])
    for one in nodes:
        plotter.add_mesh(scene.ball(one, 0.03), color=COLOURS["error"])
    return scene.shoot(plotter, direction=direction, zoom=1.0, letters=letters, width=6)
