"""Ways on the torus as they lie in space."""

import numpy as np

from ..arguments import Positive, checked
from ..paths import geodesic_inverse, project_chord
from ..surfaces import Torus
from . import scene
from .path_plot import JointPosition
from .style import COLOURS

GAUGE = 0.007  # m, radius of what is drawn of a curve


@checked
def three_ways_in_space(
    torus: Torus, p: JointPosition, q: JointPosition, *, exaggeration: Positive
):
    """Return a picture of the chord, the geodesic and the projected chord between two corners.

    Parameters
    ----------
    torus : Torus
        The surface, in m; the patch between the corners is drawn.
    p, q : (2,) float
        The corners: theta and phi in rad.
    exaggeration : float
        How many times too far beside the geodesic the projected chord is drawn.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    curve = geodesic_inverse(torus, p, q).points(201)
    beside = curve.deviation(project_chord(torus, p, q, 201))
    normal = torus.normal(*np.moveaxis(curve.position, -1, 0))
    across = np.cross(normal, curve.tangent)
    wide = torus.foot(curve.point + exaggeration * beside[:, None] * across)
    chord = torus.point(*np.transpose([p, q]))
    plotter = scene.empty()
    plotter.window_size = 1300, 975
    angles = [np.linspace(a, b, n) for a, b, n in zip(p, q, (80, 60), strict=True)]
    patch = scene.surface(torus.point(*np.meshgrid(*angles, indexing="ij")))
    plotter.add_mesh(patch, color=COLOURS["torus"], opacity=0.5)
    ways = {"geodesic": curve.point, "tangent sphere": wide, "chord": chord}
    for colour, points in ways.items():
        plotter.add_mesh(scene.curve(points, GAUGE), color=COLOURS[colour])
    letters = {
        "$P$": (chord[0], (-0.7, 0.3)),
        "$Q$": (chord[-1], (0.5, -0.7)),
        "chord": (chord.mean(axis=0), (-1.8, -0.5)),
        "geodesic": (curve.point[60], (1.0, 0.9)),
        f"projected, aside × {exaggeration:g}": (wide[80], (-2.5, -2.0)),
    }
    direction = (1.4, -1.0, -0.5)
    return scene.shoot(plotter, direction=direction, zoom=1.0, letters=letters, width=7.4)
