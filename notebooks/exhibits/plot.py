"""Plane drawings of the study's shapes, each on the Axes `ax` that it is given."""

import numpy as np
from matplotlib.patches import Circle, Patch, PathPatch, Rectangle
from matplotlib.path import Path

from kit.style import COLOURS
from tunneller_lib.surfaces.torus import FEET

GRADES = [1e-9, 1, 10, 50]  # %, where a chart's next shade begins
SHADES = ["white", "#f6d5a8", "#e69f00", "#b35806", "#5a2000"]


def equal(ax, xlabel, ylabel):
    """Give both axes of a drawing one scale, and their labels `xlabel` and `ylabel`."""
    ax.set_aspect("equal")
    ax.set(xlabel=xlabel, ylabel=ylabel)


def draw_pictures(axes, pictures, titles):
    """Put pictures (n, m, 3), such as those of scenes, on as many axes, each with its title."""
    for ax, picture, title in zip(axes.flat, pictures, titles, strict=True):
        ax.imshow(picture, interpolation="none")
        ax.set_title(title)
        ax.axis("off")


def draw_shares(ax, shares, columns, counts):
    """Draw a chart of squares, the darker the greater a share: white is none.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    shares : (n, m) float
        In %.
    columns : list of str
        Names of the m columns, set below.
    counts : list of str
        What each of the n rows counts, set on the right, after a head for all of them.

    Returns
    -------
    key : list of matplotlib.patches.Patch
        For a legend of the grades.
    """
    grade = np.digitize(shares, GRADES)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    for level in range(1, len(SHADES)):
        corners = np.argwhere(grade == level)[:, ::-1] - 0.5
        path = Path.make_compound_path(*map(Path, corners[:, None] + square))
        ax.add_patch(PathPatch(path, facecolor=SHADES[level], lw=0))
    ax.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(shares) - 0.5, -0.5))
    ax.set_xticks(np.arange(len(columns)), columns, rotation=90)
    for i, text in enumerate(counts, start=-1):
        ax.text(len(columns) - 0.3, i, text, va="center_baseline", fontsize="small")
    labels = ["none", "up to 1 %", "to 10 %", "to 50 %", "more"]
    return [
        Patch(facecolor=shade, edgecolor="#888888", label=label)
        for shade, label in zip(SHADES, labels, strict=True)
    ]


def draw_section(ax, section, **line):
    """Draw a section as seen by the machine, with y growing to the left.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    section : Section
        The closed curve, in m.
    **line
        Passed on to ``Axes.plot``; the tunnel's colour by default.
    """
    y, z = section.point(np.linspace(0, section.perimeter, 721)).T
    ax.plot(y, z, **{"color": COLOURS["tunnel"], **line})
    equal(ax, "y / m (left)", "z / m (up)")
    if not ax.xaxis_inverted():
        ax.invert_xaxis()


def draw_construction(ax, egg):
    """Draw how the section is made (Fig. 4): arcs' centres and radii, rays to the blends, the box.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    egg : Egg
        The section, in m.
    """
    ends = egg.point(egg.blends)
    for arc, start, stop in zip(egg.arcs, ends[:-1], ends[1:], strict=True):
        centre = np.array([arc.y, arc.z])
        ax.plot(*np.transpose([start, centre, stop]), color=COLOURS["chord"], lw=0.5)
        ax.plot(*centre, "o", color=COLOURS["chord"], ms=3)
    for radius, y, z in (("$a$", 0.5, 0.2), ("$3a$", 1.35, -0.75), ("$a/2$", 0, -1.78)):
        ax.annotate(radius, (y * egg.a, z * egg.a), ha="center", va="center")
    ax.plot(*ends.T, "s", color=COLOURS["correct"], ms=4)
    low, high = -2 * egg.a, egg.a
    box = {"fill": False, "edgecolor": COLOURS["cutter"], "ls": "--", "lw": 0.7}
    ax.add_patch(Rectangle((-egg.a, low), 2 * egg.a, high - low, **box))
    beside, above = -1.55 * egg.a, 1.18 * egg.a
    arrow = {"arrowstyle": "<->", "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (beside, low), (beside, high), arrowprops=arrow)
    ax.annotate("", (-egg.a, above), (egg.a, above), arrowprops=arrow)
    clear = {"ha": "center", "va": "center", "bbox": {"fc": "white", "ec": "none", "pad": 1}}
    ax.annotate("$3a$", (beside, low / 2 + high / 2 - 0.7 * egg.a), **clear)
    ax.annotate("$2a$", (0, above), **clear)


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
        colour = COLOURS["tangent sphere"] if index == 0 else COLOURS["cutter"]
        radius = np.hypot(*(foot - m)[:2])
        width = 1.4 if index == 0 else 0.6
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
        circle = radius * np.array([np.cos(around), np.sin(around)])
        ax.plot(*circle, color=COLOURS[colour], lw=width)
    feet = torus.feet(m)
    ax.axline((0, 0), (m[0], m[2]), color=COLOURS["chord"], lw=0.6, ls="--")
    ax.plot(feet[:, 0], feet[:, 2], "o", color=COLOURS["tangent sphere"])
    ax.plot(m[0], m[2], "s", color=COLOURS["chord"])
    ax.annotate("M", (m[0], m[2]), (4, -11), textcoords="offset points")
    ax.annotate("axis", (0, 0), (3, -11), textcoords="offset points")
    ax.plot(0, 0, "+", color=COLOURS["chord"])
    ax.set(xlabel="x / m", aspect="equal", xlim=(-1.3, 1.3), ylim=(-1.3, 1.3))
    ax.set_title("$m_2 = 0$: both equators" if whole else "$m_2$ not zero: four feet")
