"""Plane drawings of cones, planes and surfaces of lines, each on the Axes that it is given."""

import numpy as np

from kit.style import COLOURS
from tunneller_lib.envelopes import adapted_frames, hyperosculating_cones
from tunneller_lib.envelopes.adapted import frames_along
from tunneller_lib.envelopes.isotropic import plane_to_point

from .plot import equal

SHADES = {2: "#DCE6EF", 4: "#7FA6C9", 6: "#22527A"}  # of numbers of cones
ROUNDING = 1e-6  # of the limit of a map: from there on it's a gouge
SIDES = COLOURS["tangent sphere"], COLOURS["error"]  # of the two planes that are seen edge-on


def draw_cone_and_conic(space, top, side, cone):
    """Draw a cone from the side, the circle of its planes, and its conic from the side.

    Parameters
    ----------
    space, top, side : matplotlib.axes.Axes
    cone : ConePose
        In m, its vertex and its axis in the x-z plane.
    """
    round_it = np.linspace(0, 2 * np.pi, 361)
    curve = plane_to_point(*cone.planes(round_it))
    lean = np.arctan2(cone.axis[0], cone.axis[2])
    rulings = lean + np.array([-1, 1]) * cone.half_angle
    n = np.stack([np.cos(rulings), 0 * rulings, -np.sin(rulings)], axis=-1) * [[1], [-1]]
    edges = plane_to_point(n, -n @ np.array(cone.vertex))
    for way, colour in zip([lean, *rulings], [COLOURS["torus"], *SIDES], strict=True):
        line = [0, 2] * np.array([[np.sin(way)], [np.cos(way)]])
        space.plot(cone.vertex[0] + line[0], cone.vertex[2] + line[1], color=colour)
    space.set(title="the cone", xlim=(-2.5, 2.5), ylim=(-1.5, 3.5))
    equal(space, "x / m", "z / m")
    top.plot(*curve[:, :2].T, color=COLOURS["top view"])
    top.plot(np.cos(round_it), np.sin(round_it), "--", color=COLOURS["torus"], lw=0.8)
    top.scatter(*edges.T[:2], color=SIDES)
    top.set(title="its circle", xlim=(-2.2, 2.2), ylim=(-2.2, 2.2))
    equal(top, "x", "y")
    side.plot(*curve[:, ::2].T, color=COLOURS["cone"])
    side.axhline(0, color=COLOURS["torus"], lw=0.5)
    side.scatter(*edges.T[::2], color=SIDES)
    side.set(title="its conic", xlim=(-2.2, 2.2), ylim=(-2.2, 2.2), aspect="equal")
    side.set(xlabel="x", ylabel="z / m")


def draw_planes_along_line(above, ahead, turned, surface, line):
    """Draw a surface of lines from above, the tangent planes along one line, and their turn.

    Parameters
    ----------
    above, ahead, turned : matplotlib.axes.Axes
        From above; along the line, where the planes are seen edge-on; turn against place.
    surface : callable
        Of the line s, in rad, and the place t along it, three coordinates in m.
    line : float
        Which line, in rad; the four squares stand on it from t = 0.1 to t = 1.2.
    """
    four = np.linspace(0.1, 1.2, 4)
    frames = frames_along(surface, line, four)  # which looks at what the surface returns
    # One curve with gaps takes less time than 33 lines.
    edges = surface(*np.meshgrid(np.linspace(0, 2 * np.pi, 33), [0.1, 1.2]))
    x, y = (np.insert(one, 2, np.nan, axis=0).T.ravel() for one in edges[:2])
    above.plot(x, y, color=COLOURS["torus"], lw=0.8)
    x, y, _ = frames.contact.T
    above.plot(x, y, "s-", color=COLOURS["tangent sphere"], mfc=COLOURS["plane"], mec="none")
    above.set(title="from above", xlim=(-1.7, 1.7), ylim=(-1.7, 1.7))
    equal(above, "x / m", "y / m")
    _, turn = _turn(surface, line, four)
    ends = 0.4 * np.stack([np.cos(turn), np.sin(turn)])
    ahead.plot(*np.stack([-ends, ends], axis=1), color=COLOURS["plane"])
    ahead.plot(0, 0, "o", color=COLOURS["tangent sphere"])
    ahead.set(title="seen along the line", xlim=(-0.5, 0.5), ylim=(-0.5, 0.5))
    equal(ahead, "in the first plane / m", "across / m")
    place, turn = _turn(surface, line, np.linspace(0.1, 1.2, 30))
    turned.plot(place, np.degrees(turn), color=COLOURS["plane"])
    turned.set(title="turn of the plane", xlabel="along the line / m", ylabel="turn / deg")
    turned.set(ylim=(-10, 190), box_aspect=1)


def _turn(surface, line, t):
    """Return places along a line, in m, and how far the planes there have turned, in rad."""
    found = frames_along(surface, line, t)
    n = found.axes[:, 2]
    turn = np.arctan2(n @ found.axes[0, 1], n @ found.axes[0, 2])
    return np.linalg.norm(found.contact - found.contact[0], axis=-1), np.unwrap(turn)


def draw_cone_counts(ax, x, y, count):
    """Shade on `ax` a map of the model by the number of cones, all (n, m): 6 dark, 2 pale."""
    ax.contourf(x, y, count, levels=[1, 3, 5, 7], colors=list(SHADES.values()))
    ax.set(xlabel="x", aspect="equal")


def draw_cones_at_contact(where, rods, f, place, half_angle):
    """Draw a contact in a quarter of the model, and the rulings of all cones there from above.

    Parameters
    ----------
    where, rods : matplotlib.axes.Axes
        The model, with the circle of the radius cot(half_angle); the tangent plane, with dots on
        the side of the vertices, generators ochre, cones that gouge red.
    f : callable
        Of x and y, in m.
    place : (2,) float
        The contact, from 0 to 2.6.
    half_angle : float
        Of the cones, in rad.
    """
    quarter = np.linspace(0, np.pi / 2, 91)
    edge = np.array([np.sin(quarter), np.cos(quarter)]) / np.tan(half_angle)
    where.set(facecolor=SHADES[4], xlim=(0, 2.6), ylim=(0, 2.6), xlabel="x", ylabel="y")
    where.fill_between(*edge, color=SHADES[6], lw=0)
    where.plot(*place, "o", color=COLOURS["machine"])
    where.set(aspect="equal", title="the contact in the model")
    frame = adapted_frames(f, *np.array(place)[:, None], "isotropic").axes[0]
    cones = hyperosculating_cones(f, *place, half_angle=half_angle)
    ends = (cones.vertex - cones.contact) / cones.distance[:, None] @ frame[:2].T
    for end, colour in zip(ends, cone_colours(cones), strict=True):
        rods.plot(*np.transpose([end, -end]), "o-", color=colour, markevery=[0])
    rods.plot(0, 0, "o", color=COLOURS["chord"])
    rods.set(xlabel="in the tangent plane", ylabel="across", xticks=[], yticks=[])
    rods.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1), aspect="equal", title=f"{len(cones)} cones")


def cone_colours(cones):
    """Return the colours of cones: generators ochre, those that gouge red, others green."""
    names = np.where(cones.undecided, "generator", np.where(cones.gouges, "error", "cone"))
    return [COLOURS[name] for name in names]


def draw_gap_map(ax, e, w, gap, edge, limit):
    """Shade a map of the gap between a surface and a cone.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    e, w : (n, m) float
        Places in the tangent plane, in m.
    gap : (n, m) float
        Positive where there is air, in mm; negative parts are hatched within a dashed line.
    edge : float
        How far from the contact the map goes, in m.
    limit : float
        Where the shades end, in mm.

    Returns
    -------
    shades : matplotlib.contour.QuadContourSet
        For a colour bar.
    """
    steps = limit * np.linspace(-1, 1, 21)
    with np.errstate(over="ignore"):  # a gap may be any number of limits
        shades = ax.contourf(e, w, gap, steps, cmap="RdBu", extend="both")
        # Hatched, for in grey a red is as dark as a blue; rounding isn't a gouge.
        inside = gap.min() if gap.min() < -ROUNDING * limit else -limit
        gouge = [2 * inside, -ROUNDING * limit]
        ax.contourf(e, w, gap, gouge, colors="none", hatches=["/////"])
    shades.set_rasterized(True)  # flat shades: less than lines
    ax.contour(e, w, gap, [0.0], colors="k", linewidths=0.6, linestyles="--")
    ax.plot(0, 0, ".", color=COLOURS["chord"])
    ax.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge))
    return shades
