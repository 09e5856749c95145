"""The torus in space: its working patch with a grid, and the whole of it, cut open."""

import numpy as np

from kit import scene


def grid_picture(torus, theta, phi):
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
    """
    plotter = scene.empty()
    fine = (np.linspace(angles[0], angles[-1], 120) for angles in (theta, phi))
    patch = scene.surface(torus.point(*np.meshgrid(*fine, indexing="ij")))
    scene.put(plotter, patch, "torus", smooth_shading=True)
    along = np.linspace(0, 1, 120)
    lines = [torus.point(t, phi[0] + (phi[-1] - phi[0]) * along) for t in theta]
    lines += [torus.point(theta[0] + (theta[-1] - theta[0]) * along, p) for p in phi]
    for points in lines:
        scene.put(plotter, scene.curve(points, 0.0015), "chord")
    plotter.window_size = 2000, 1500
    ends = np.degrees([theta[0], theta[-1], phi[0], phi[-1]])
    letters = {
        rf"$\varphi = {ends[2]:.0f}$°": (torus.point(0.0, phi[0]), (-2.4, 0)),
        rf"$\varphi = {ends[3]:.0f}$°": (torus.point(0.0, phi[-1]), (2.0, 0)),
        rf"$\theta = {ends[0]:.0f}$°": (torus.point(theta[0], 0.0), (0, 0.8)),
        rf"$\theta = {ends[1]:.0f}$°": (torus.point(theta[-1], 0.0), (0, -0.8)),
        r"$\theta = \varphi = 0$": (torus.point(0.0, 0.0), (0, 0.8)),
    }
    scene.put(plotter, scene.ball(torus.point(0.0, 0.0), 0.01), "chord")
    return scene.shoot(plotter, direction=(1.6, -0.5, 0.4), zoom=1.0, letters=letters, width=8)


def entire_torus_picture(torus):
    """Return pictures of a whole spindle torus: closed, and with a quarter cut away (Fig. 3).

    Parameters
    ----------
    torus : Torus
        The surface, in m, with R > r.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    node = np.arccos(-torus.r / torus.R)
    round_it = np.linspace(0, 2 * np.pi, 200)
    nodes = torus.point(np.zeros(2), np.array([-node, node]))
    aslant = {"node": (nodes[0], (1.6, 0.6)), "axis": (1.2 * nodes[0], (-1, -0.7))}
    whole = {"torus": _sheet(torus, round_it, -node, node)}
    outside = _with_nodes(whole, nodes, (1.0, -1.4, 0.8), aslant)
    across = {
        "node": (nodes[0], (-1.7, 0.7)),
        "node ": (nodes[1], (1.7, 0.7)),
        "inner sheet": (torus.point(-0.6, 0.0), (0, 0)),
        "outer sheet": (torus.point(np.pi / 2, 0.0), (0, 0)),
    }
    opened = {
        "torus": _sheet(torus, np.linspace(0, np.radians(270), 200), -node, node),
        "inner sheet": _sheet(torus, round_it, node, 2 * np.pi - node),
    }
    inside = _with_nodes(opened, nodes, (1.0, 0.0, 0.8), across)
    return scene.side_by_side(outside, inside)


def _sheet(torus, theta, low, high):
    phi = np.linspace(low, high, 200)
    return torus.point(*np.meshgrid(theta, phi, indexing="ij"))


def _with_nodes(sheets, nodes, direction, letters):
    plotter = scene.empty()
    plotter.window_size = 2000, 1600
    for colour, sheet in sheets.items():
        scene.put(plotter, scene.surface(sheet), colour, smooth_shading=True)
    scene.put(plotter, scene.curve(1.2 * nodes, 0.006), "chord")
    for one in nodes:
        scene.put(plotter, scene.ball(one, 0.03), "error")
    return scene.shoot(plotter, direction=direction, zoom=1.0, letters=letters, width=6)
