"""The cone of the appendix and its development, on the Axes `ax` they are given."""

import numpy as np

from kit.style import COLOURS

from .plot import equal

HEIGHT = np.radians(22)  # above the horizon, from where a cone is seen


def draw_cone(ax, chord, u):
    """Draw a cone down to P as it is seen from afar, with the geodesic and the path on it.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    chord : ConeChord
        The test case, in m; the eye is at the azimuth midway between P and Q.
    u : (n,) float
        Fractions of the geodesic at which the path's points are drawn.
    """
    cone = chord.cone
    towards = chord.turn / 2
    right = [-np.sin(towards), np.cos(towards), 0.0]
    up = [-np.sin(HEIGHT) * np.cos(towards), -np.sin(HEIGHT) * np.sin(towards), np.cos(HEIGHT)]
    screen = np.transpose([right, up])
    # Where the normal is at right angles to the line of sight; a flat cone is seen all round.
    outline = np.arccos(max(-np.tan(cone.half_angle) * np.tan(HEIGHT), -1.0))
    for first, last, style in [(-outline, outline, "-"), (outline, 2 * np.pi - outline, "--")]:
        rim = cone.point(chord.ends[0], towards + np.linspace(first, last, 181)) @ screen
        ax.plot(*rim.T, ls=style, color=COLOURS["torus"], lw=0.8)
    for azimuth in (towards - outline, towards + outline):
        ruling = cone.point(np.array([0.0, chord.ends[0]]), azimuth) @ screen
        ax.plot(*ruling.T, color=COLOURS["torus"], lw=0.8)

    fine = np.linspace(0, 1, 201)
    distance = np.hypot(*chord.geodesic(fine).T)
    geodesic = cone.point(distance, chord.azimuth(fine)) @ screen
    path = cone.point(chord.tangent_sphere(chord.azimuth(fine)), chord.azimuth(fine)) @ screen
    points = cone.point(chord.tangent_sphere(chord.azimuth(u)), chord.azimuth(u)) @ screen
    _draw_both(ax, geodesic, path, points)
    _name_ends(ax, geodesic[0], geodesic[-1])
    ax.set_aspect("equal")
    ax.axis("off")


def draw_development(ax, chord, u):
    """Draw a cone unrolled (Fig. 9), with the geodesic and the projected chord.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    chord : ConeChord
        The test case, in m.
    u : (n,) float
        Fractions of the geodesic at which the path's points are drawn.
    """
    around = np.linspace(0, chord.turn, 181)
    for distance in chord.ends:
        ax.plot(*chord.cone.development(distance, around).T, color=COLOURS["torus"], lw=0.8)
    for azimuth in (0.0, chord.turn):
        ruling = chord.cone.development(np.array([0.0, chord.ends[0]]), azimuth)
        ax.plot(*ruling.T, color=COLOURS["torus"], lw=0.8)
    fine = np.linspace(0, 1, 201)
    geodesic = chord.geodesic(fine)
    _draw_both(ax, geodesic, chord.path(fine), chord.path(u))
    _name_ends(ax, geodesic[0], geodesic[-1])
    equal(ax, "development / m", "development / m")


def _draw_both(ax, geodesic, path, points):
    """Draw the lines of a geodesic, a path and points of the path, all (n, 2)."""
    blue = {"color": COLOURS["tangent sphere"]}
    ax.plot(*geodesic.T, color=COLOURS["geodesic"], label="geodesic")
    ax.plot(*path.T, lw=0.8, label="projected chord", **blue)
    ax.plot(*points.T, "o", mfc="white", **blue)


def _name_ends(ax, p, q):
    """Write the names of the apex and both ends beside them, away from their middle."""
    middle = (p + q) / 3
    for name, place in [("apex", np.zeros(2)), ("$P$", p), ("$Q$", q)]:
        away = (place - middle) / np.hypot(*(place - middle))
        look = {"ha": "center", "va": "center", "fontsize": 8}
        ax.annotate(name, place, 9 * away, textcoords="offset points", **look)
