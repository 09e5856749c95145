"""The machine in the tunnel that it cuts, posed from a simulated run; the wall by its error.

Everything is in the frame of the tunnel: x ahead, y to the left, z up, in m.
"""

import numpy as np
import pyvista

from kit import scene
from kit.style import COLOURS, ERROR_MAP
from tunneller_lib.job.mesh import SCALAR
from tunneller_lib.ream.wall import overbreak, standing
from tunneller_lib.removal import DexelGrid

from .machine_scene import machine_model

BACK, FRONT = 1.25, 0.25  # m of tunnel that are drawn behind the joint and before the cut ground
OPENED = np.radians([100, 285])  # angles from y over z that are left out, to look inside
VIEW = (0.55, -1.5, 0.5)  # towards the camera
WINDOW = 2400, 1500  # px
BAR = {
    "title": SCALAR.replace(" / ", "\n/ "), "vertical": True, "fmt": "%.1f", "n_labels": 5,
    "below_label": "to cut", "width": 0.03, "height": 0.6, "position_x": 0.925, "position_y": 0.2,
}  # fmt: skip
LIMIT = 1.5  # mm, over- and underbreak at the ends of the colour scale


def stages(cut, ticks):
    """Yield the walls (DexelGrid) that stand after each of several ascending ticks of a cut.

    At tick 0 that is before the cutter enters; after the last tick, when the cutter has left, as
    `Cut.wall`.
    """
    circuit = cut.plan.circuit
    lines = cut.wall.lines
    inner = circuit.section.ray(np.arctan2(lines.sin, lines.cos))
    wall = DexelGrid(lines, inner, cut.wall.high.max(axis=0))
    radius = circuit.machine.cutter_radius
    for before, tick in zip([0, *ticks[:-1]], ticks, strict=True):
        if before == 0 < tick and len(cut.before):
            wall.cut_path(cut.before, radius)
        if tick > before:
            wall.cut_path(cut.centres[before : tick + 1], radius)
        if len(cut.after) and before < tick == len(cut.centres) - 1:
            wall.cut_path(cut.after, radius)
        yield wall.copy()


def wall_mesh(wall, circuit):
    """Return the standing wall, coloured by how far it is from the wanted one, a part left out.

    One point a ray, with the scalars `SCALAR` in mm; minus the depth of cut where nothing is cut.
    """
    angle = np.arctan2(wall.lines.sin, wall.lines.cos)
    turned = np.mod(angle - OPENED[1], 2 * np.pi)
    around = np.argsort(turned)[: np.count_nonzero(turned < 2 * np.pi - np.ptp(OPENED))]
    over = 1e3 * overbreak(wall, circuit)
    return scene.surface(standing(wall)[:, around], {SCALAR: over[:, around]})


def tunnel_mesh(section, start, stop):
    """Return the wall of a tunnel that isn't cut, from `start` to `stop` along x, a part left out.

    Both are in m.
    """
    angle = np.linspace(OPENED[1] - 2 * np.pi, OPENED[0], 361)
    ray = section.ray(angle)
    points = np.broadcast_arrays([[start], [stop]], ray * np.cos(angle), ray * np.sin(angle))
    return scene.surface(np.stack(points, axis=-1))


def posed_machine(cut, tick):
    """Return the machine's parts at a tick of a cut, its cutter where the simulation has it.

    They are those of `machine_model`, in the tunnel's frame. A machine that stands elsewhere than
    it should is shifted as a whole to its cutter's centre.
    """
    centre = cut.centres[tick]
    circuit = cut.plan.circuit
    # The machine steps back by an advance each lap; the circuit is that of the first.
    unstepped = centre + np.array([float(cut.plan.stepped(tick)), 0.0, -circuit.machine.height])
    theta, phi = map(float, circuit.machine.torus.angles(unstepped @ circuit.axes))
    away = centre - circuit.axes @ circuit.machine.torus.point(theta, phi)
    place = pyvista.Transform().rotate(circuit.axes).translate(away)
    return [(place.apply(mesh), look) for mesh, look in machine_model(circuit.machine, theta, phi)]


def cut_scene(cut, tick=None, *, wall, bar=True):
    """Return the scene of a cut at a tick: tunnel, wall by error, machine, the cutter's path.

    Parameters
    ----------
    cut : Cut
        A simulated or carved cut.
    tick : int, optional
        Of the whole run; the last by default.
    wall : DexelGrid
        What stands at this tick: one of `stages`.
    bar : bool
        Whether the colours are explained; ground that is still to be cut has the tunnel's.

    Returns
    -------
    plotter : pyvista.Plotter
        Its camera is set, and the same at all ticks of a cut.
    """
    plan = cut.plan
    tick = len(cut.centres) - 1 if tick is None else tick
    start, stop = cut.wall.lines.x[[0, -1]]
    behind = min(start, 0.0) - plan.advance * (plan.laps - 1) - BACK
    plotter = scene.empty(parallel=False)
    plotter.window_size = WINDOW
    for ends in ((behind, start), (stop, stop + FRONT)):
        scene.put(plotter, tunnel_mesh(plan.circuit.section, *ends), "tunnel")
    scene.look(plotter, VIEW, zoom=1.4)
    # What changes from tick to tick leaves the camera where it is.
    shades = {"cmap": ERROR_MAP, "clim": (-LIMIT, LIMIT), "below_color": COLOURS["tunnel"]}
    shades |= {"show_scalar_bar": bar, "scalar_bar_args": dict(BAR)}
    mesh = wall_mesh(wall, plan.circuit)
    plotter.add_mesh(mesh, scalars=SCALAR, reset_camera=False, **shades)
    for mesh, look in posed_machine(cut, tick):
        plotter.add_mesh(mesh, reset_camera=False, **look)
    if tick:
        path = scene.curve(cut.centres[: tick + 1 : max(1, tick // 500)], 0.004)
        scene.put(plotter, path, "chord", reset_camera=False)
    return plotter


def cut_picture(cut, tick=None, **options):
    """Return the picture (n, m, 3) uint8 of a cut at a tick, half as wide as the text.

    Options are those of `cut_scene`.
    """
    plotter = cut_scene(cut, tick, **options)
    plotter.window_size = [size // 2 for size in WINDOW]
    pixels = plotter.screenshot(return_img=True)
    plotter.close()
    return scene.crop(pixels)
