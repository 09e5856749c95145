"""Plane drawings of the study's shapes, each on the Axes `ax` that it is given."""

import numpy as np
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path

from kit.style import COLOURS

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
