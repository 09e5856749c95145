"""The machine in the tunnel that it cuts, posed from a simulated run; the wall by its error.

Everything is in the frame of the tunnel: x ahead, y to the left, z up, in m.
"""

import numpy as np

from kit import scene
from kit.style import COLOURS, ERROR_MAP
from tunneller_lib.arguments import Finite, Length, Whole, Wholes, checked, shown
from tunneller_lib.job.mesh import SCALAR
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.ream.cutting import Cut
from tunneller_lib.ream.wall import overbreak, standing
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import Section

from .machine_scene import machine_model

BACK, FRONT = 1.25, 0.25  # m of tunnel that are drawn behind the joint and before the cut ground
OPENED = np.radians([100, 285])  # angles from y over z that are left out, to look inside
VIEW = (0.55, -1.5, 0.5)  # towards the camera
ZOOM = 1.4
WINDOW = 1600, 1000  # px
BAR = {
    "title": SCALAR.replace(" / ", "\n/ "),
    "vertical": True,
    "fmt": "%.1f",
    "n_labels": 5,
    "below_label": "to cut",
    "width": 0.03,
    "height": 0.6,
    "position_x": 0.925,
    "position_y": 0.2,
}
KEPT = {
    "reset_camera": False,
    "render": False,
}  # neither the view nor the picture, while meshes change
MOST_TICKS = 10**9


@checked
def stages(cut: Cut, ticks: Wholes("(n,) int", 0, MOST_TICKS)):
    """Return the walls that stand after each of several ticks, one after the other.

    Parameters
    ----------
    cut : Cut
        A simulated or carved cut.
    ticks : (n,) int
        Ascending, none beyond the last tick.

    Returns
    -------
    walls : iterator of DexelGrid
        Each cut by the first ticks of the run, at tick 0 before the cutter enters; after the last
        tick, and when the cutter has left, as `Cut.wall`.

    Raises
    ------
    ValueError
        If the ticks don't ascend or are beyond the run.
    """
    last = len(cut.centres) - 1
    if ticks.ndim != 1 or np.any(ticks > last):
        raise ValueError(f"ticks: must be whole numbers (n,) from 0 to {last}; got {shown(ticks)}.")
    if np.any(np.diff(ticks) < 0):
        raise ValueError(f"ticks: must ascend; got {shown(ticks.tolist())}.")
    return _stages(cut, ticks)


def _stages(cut, ticks):
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


@checked
def wall_mesh(wall: DexelGrid, circuit: Circuit, *, opened: bool = False):
    """Return the standing wall, coloured by how far it is from the wanted one.

    Parameters
    ----------
    wall : DexelGrid
        The ground round a tunnel, on rays.
    circuit : Circuit
        Its section and its machine's depth of cut give the wanted wall.
    opened : bool
        Whether a part of the circumference is left out, to look inside.

    Returns
    -------
    mesh : pyvista.PolyData
        One point a ray, with the scalars `SCALAR`; minus the depth of cut where nothing is cut.
    """
    angle = np.arctan2(wall.lines.sin, wall.lines.cos)
    around = np.append(np.arange(len(angle)), 0)
    if opened:
        turned = np.mod(angle - OPENED[1], 2 * np.pi)
        around = np.argsort(turned)[: np.count_nonzero(turned < 2 * np.pi - np.ptp(OPENED))]
    over = 1e3 * overbreak(wall, circuit)
    return scene.surface(standing(wall)[:, around], {SCALAR: over[:, around]})


@checked
def tunnel_mesh(section: Section, start: Finite, stop: Finite, *, opened: bool = False):
    """Return the wall of a tunnel that isn't cut.

    Parameters
    ----------
    section : Section
        The tunnel's.
    start, stop : float
        Its ends along x, in m.
    opened : bool
        As for `wall_mesh`.

    Returns
    -------
    mesh : pyvista.PolyData
        The wall.
    """
    first, last = (OPENED[1] - 2 * np.pi, OPENED[0]) if opened else (0.0, 2 * np.pi)
    angle = np.linspace(first, last, 361)
    ray = section.ray(angle)
    points = np.broadcast_arrays([[start], [stop]], ray * np.cos(angle), ray * np.sin(angle))
    return scene.surface(np.stack(points, axis=-1))


@checked
def posed_machine(cut: Cut, tick: Whole(0, MOST_TICKS)):
    """Return the machine's parts at a tick of a cut, its cutter where the simulation has it.

    Parameters
    ----------
    cut : Cut
        A simulated or carved cut.
    tick : int
        Of the whole run.

    Returns
    -------
    parts : list of (mesh, dict)
        As from `machine_model`, in the tunnel's frame. A machine that stands elsewhere than it
        should is shifted as a whole to its cutter's centre.
    """
    centre = cut.centres[_within_run(cut, tick)]
    plan = cut.plan
    circuit = plan.circuit
    # The machine steps back by an advance each lap; the circuit is that of the first.
    unstepped = centre + np.array([float(plan.stepped(tick)), 0.0, -circuit.machine.height])
    torus = circuit.machine.torus
    theta, phi = map(float, torus.angles(unstepped @ circuit.axes))
    place = np.eye(4)
    place[:3, :3] = circuit.axes
    place[:3, 3] = centre - circuit.axes @ torus.point(theta, phi)
    parts = machine_model(circuit.machine, theta, phi)
    return [(mesh.transform(place, inplace=False), look) for mesh, look in parts]


@checked
def cut_scene(
    cut: Cut,
    tick: Whole(0, MOST_TICKS) | None = None,
    *,
    wall: DexelGrid | None = None,
    limit: Length = 1.5e-3,
    opened: bool = True,
    bar: bool = True,
):
    """Return the scene of a cut at a tick: tunnel, wall by error, machine, the cutter's path.

    Parameters
    ----------
    cut : Cut
        A simulated or carved cut.
    tick : int, optional
        Of the whole run; the last by default.
    wall : DexelGrid, optional
        What stands at this tick, where it is known already: one of `stages`.
    limit : float
        Over- and under-break at the ends of the colour scale, in m; ground that stands farther
        in is still to be cut, and has the tunnel's colour.
    opened : bool
        Whether a part of the wall is left out, to look inside.
    bar : bool
        Whether the colours are explained.

    Returns
    -------
    plotter : pyvista.Plotter
        To be shown, or for `scene.shoot` with no direction: its camera is set, and the same at
        all ticks of a cut.

    Raises
    ------
    ValueError
        If the tick is beyond the run.
    """
    last = len(cut.centres) - 1
    tick = last if tick is None else _within_run(cut, tick)
    if wall is None:
        wall = cut.wall if tick == last else next(stages(cut, [tick]))
    plotter = _uncut_tunnel(cut, opened)
    _place(plotter, cut, tick, wall, limit, opened, bar)
    return plotter


def _uncut_tunnel(cut, opened):
    """Return the scene of what no tick changes: the tunnel before and behind, and the camera."""
    plan = cut.plan
    start, stop = cut.wall.lines.x[[0, -1]]
    behind = min(start, 0.0) - plan.advance * (plan.laps - 1) - BACK
    plotter = scene.empty(parallel=False)
    plotter.window_size = WINDOW
    for ends in ((behind, start), (stop, stop + FRONT)):
        mesh = tunnel_mesh(plan.circuit.section, *ends, opened=opened)
        plotter.add_mesh(mesh, color=COLOURS["tunnel"])
    plotter.view_vector(VIEW, viewup=(0, 0, 1))
    plotter.camera.zoom(ZOOM)
    return plotter


def _place(plotter, cut, tick, wall, limit, opened, bar):
    """Put the wall, the machine and its path at a tick in the place of those before."""
    seconds = tick * cut.plan.tick
    plotter.title = f"The machine in the tunnel after {seconds:.1f} s; colours: {SCALAR}"
    millimetres = 1e3 * limit
    plotter.add_mesh(
        wall_mesh(wall, cut.plan.circuit, opened=opened),
        name="wall",
        scalars=SCALAR,
        cmap=ERROR_MAP,
        clim=(-millimetres, millimetres),
        below_color=COLOURS["tunnel"],
        show_scalar_bar=bar,
        **KEPT,
        scalar_bar_args=dict(BAR),
    )
    for number, (mesh, look) in enumerate(posed_machine(cut, tick)):
        plotter.add_mesh(mesh, name=f"part {number}", **KEPT, **look)
    if tick:
        path = scene.curve(cut.centres[: tick + 1 : max(1, tick // 500)], 0.004)
        plotter.add_mesh(path, name="path", color=COLOURS["chord"], **KEPT)


def _within_run(cut, tick):
    last = len(cut.centres) - 1
    if tick > last:
        raise ValueError(f"tick: must be one whole number from 0 to {last}; got {tick}.")
    return tick


def cut_picture(cut, tick=None, **options):
    """Return the picture (n, m, 3) uint8 of a cut at a tick; options are those of `cut_scene`.

    Nothing is cut off, so that pictures of a cut lie on each other.
    """
    plotter = cut_scene(cut, tick, **options)
    pixels = plotter.screenshot(return_img=True)
    plotter.close()
    return pixels
