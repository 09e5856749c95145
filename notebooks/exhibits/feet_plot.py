"""The feet of a point and its tangent spheres, in the torus' meridian plane and along its axis."""

import numpy as np
from matplotlib.patches import Circle

from kit.style import COLOURS
from tunneller_lib.surfaces.torus import FEET

from .plot import equal


def draw_meridian(ax, torus):
    """Draw the two circles in which a meridian plane cuts the torus, rho against y.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, in m.
    """
    node = np.arccos(max(-torus.r / torus.R, -1))
    sheets = [("torus", -node, node), ("inner sheet", node, 2 * np.pi - node)]
    for sheet, low, high in sheets:
        phi = np.linspace(low, high, 361)
        rho, y, _ = torus.point(np.zeros_like(phi), phi).T
        for side in (1, -1):
            ax.plot(side * rho, y, color=COLOURS[sheet], lw=1.8, zorder=1)
    ax.plot([torus.r, -torus.r], [0, 0], "+", color=COLOURS["chord"], ms=6)
    equal(ax, "distance from the axis / m", "y / m")


def draw_tangent_spheres(ax, torus, m):
    """Draw the four tangent spheres of one point, in its meridian plane.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, in m.
    m : (3,) float
        The centre M, in m, with x > 0 and z = 0.
    """
    draw_meridian(ax, torus)
    for index, foot in enumerate(torus.feet(m)):
        name, width = ("cutter", 0.6) if index else ("tangent sphere", 1.4)
        colour, radius = COLOURS[name], np.hypot(*(foot - m)[:2])
        ax.add_patch(Circle(m[:2], radius, fill=False, color=colour, lw=width))
        ax.plot(*np.transpose([m[:2], foot[:2]]), color=colour, lw=width, marker=".")
        signs = "({:+d}, {:+d})".format(*FEET[index])
        away = 14 * (foot - m)[:2] / (radius or 1.0)  # M may be its own foot
        place = {"textcoords": "offset points", "ha": "center", "va": "center"}
        box = {"fc": "white", "ec": "none", "pad": 0.5, "alpha": 0.8}
        ax.annotate(signs, foot[:2], away, fontsize=7, color=colour, bbox=box, **place)
    ax.plot(*m[:2], "o", color=COLOURS["chord"])
    ax.annotate("$M$", m[:2], (7, -5), textcoords="offset points", fontsize=8)


def draw_feet_along_axis(ax, torus, m):
    """Draw the feet of one point as seen along the axis of revolution, x to the right and z up.

    Where the point lies in the plane of the equators, all of both equators solve the document's
    Eqs 8 and 9, and they are drawn so.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, in m.
    m : (3,) float
        The centre M of the spheres, in m.
    """
    whole = m[1] == 0
    around = np.linspace(0, 2 * np.pi, 200)
    colour, width = ("error", 2.0) if whole else ("cutter", 0.8)
    for radius in (torus.R + torus.r, torus.R - torus.r):
        ax.plot(radius * np.cos(around), radius * np.sin(around), color=COLOURS[colour], lw=width)
    ax.axline((0, 0), (m[0], m[2]), color=COLOURS["chord"], lw=0.6, ls="--")
    ax.plot(*torus.feet(m).T[[0, 2]], "o", color=COLOURS["tangent sphere"])
    ax.plot(m[0], m[2], "s", color=COLOURS["chord"])
    ax.annotate("M", (m[0], m[2]), (4, -11), textcoords="offset points")
    ax.annotate("axis", (0, 0), (3, -11), textcoords="offset points")
    ax.plot(0, 0, "+", color=COLOURS["chord"])
    ax.set(xlabel="x / m", aspect="equal", xlim=(-1.3, 1.3), ylim=(-1.3, 1.3))
    ax.set_title("$m_2 = 0$: both equators" if whole else "$m_2$ not zero: four feet")
