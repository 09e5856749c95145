"""Plane drawings of cones, planes and surfaces of lines, each on the Axes that it is given."""

import numpy as np
from matplotlib.axes import Axes

from ..arguments import Finite, checked
from ..envelopes import ConePose
from ..envelopes.adapted import frames_along
from ..envelopes.functions import Function
from ..envelopes.isotropic import plane_to_point
from .plot import equal
from .style import COLOURS

SIDES = COLOURS["tangent sphere"], COLOURS["error"]  # of the two planes that are seen edge-on


@checked
def draw_cone_and_conic(space: Axes, top: Axes, side: Axes, cone: ConePose):
    """Draw a cone from the side, the circle of its planes, and its conic from the side.

    Parameters
    ----------
    space, top, side : matplotlib.axes.Axes
    cone : ConePose
        In m, its vertex and its axis in the x-z plane.

    Raises
    ------
    ValueError
        If vertex or axis isn't in that plane, or a plane has the normal (0, 0, -1).
    """
    if cone.vertex[1] or cone.axis[1]:
        raise ValueError(f"cone: must have vertex and axis in the x-z plane; got {cone}.")
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


@checked
def draw_planes_along_line(
    above: Axes, ahead: Axes, turned: Axes, surface: Function(2), line: Finite
):
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
    x, y, _ = surface(*np.meshgrid(np.linspace(0, 2 * np.pi, 33), [0.1, 1.2]))
    above.plot(x, y, color=COLOURS["torus"], lw=0.8)
    four = np.linspace(0.1, 1.2, 4)
    x, y, _ = frames_along(surface, line, four).contact.T
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
