"""The cone unrolled, on the Axes `ax` it is given."""

import numpy as np
from matplotlib.axes import Axes

from ..arguments import checked
from ..paths import ConeChord
from .kinds import Series
from .plot import equal
from .style import COLOURS


@checked
def draw_development(ax: Axes, chord: ConeChord, u: Series):
    """Draw a cone unrolled (Fig. 9), with the geodesic and the tangent-sphere path.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    chord : ConeChord
        The test case, in m.
    u : (n,) float
        Fractions of the geodesic at which the path's points are drawn.

    Returns
    -------
    lines : list of matplotlib.lines.Line2D
        The geodesic, the path, the path's points.
    """
    around = np.linspace(0, chord.turn, 181)
    for distance in chord.ends:
        ax.plot(*chord.cone.development(distance, around).T, color=COLOURS["torus"], lw=0.8)
    for azimuth in (0.0, chord.turn):
        ruling = chord.cone.development(np.array([0.0, chord.ends[0]]), azimuth)
        ax.plot(*ruling.T, color=COLOURS["torus"], lw=0.8)
    fine = np.linspace(0, 1, 201)
    lines = ax.plot(*chord.geodesic(fine).T, color=COLOURS["geodesic"], label="geodesic")
    path = {"color": COLOURS["tangent sphere"]}
    lines += ax.plot(*chord.path(fine).T, lw=0.8, label="tangent-sphere path", **path)
    lines += ax.plot(*chord.path(u).T, "o", mfc="white", **path)
    equal(ax, "development / m", "development / m")
    return lines
