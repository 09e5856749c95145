"""Drawings on the Axes `ax` of what a ball takes: its advance, a groove and its passes."""

import numpy as np
from matplotlib.patches import Circle, Wedge

from kit.style import COLOURS

from .plot import equal


def draw_two_balls(ax, radius, advance):
    """Draw a ball and its image after an advance, with the cylinder about both (Fig. 6).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, advance : float
        In m.
    """
    x = np.linspace(-radius, advance + radius, 801)
    first = np.sqrt(np.clip(radius**2 - x**2, 0, None))
    second = np.sqrt(np.clip(radius**2 - (x - advance) ** 2, 0, None))
    between = (x >= 0) & (x <= advance)
    bowl = {"color": COLOURS["tangent sphere"], "alpha": 0.45, "lw": 0}
    ring = {"color": COLOURS["error"], "where": between, "lw": 0}
    for side in (1, -1):
        outside = second > first
        ax.fill_between(x, side * first, side * second, where=outside, **bowl)
        top = side * np.maximum(first, second)
        ax.fill_between(x, top, side * radius, **ring)
        ax.plot([0, advance], [side * radius] * 2, color=COLOURS["cutter"], lw=0.8)
    turn = np.linspace(0, 2 * np.pi, 241)
    for centre, style in ((0, "--"), (advance, "-")):
        circle = centre + radius * np.cos(turn), radius * np.sin(turn)
        ax.plot(*circle, style, color=COLOURS["cutter"], lw=0.8)
        ax.plot(centre, 0, "+", color=COLOURS["cutter"])
    equal(ax, "along the path / m", "across / m")


def draw_sector_and_segment(ax, radius, depth):
    """Draw a groove along the path: the part behind the wall and the document's sector (Fig. 6).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, depth : float
        Of the ball; how far it cuts behind the wall, in m.
    """
    wall = radius - depth
    beta = np.arccos(wall / radius)
    around = np.linspace(0, 2 * np.pi, 241)
    top = np.linspace(-beta, beta, 81)
    ax.plot(radius * np.sin(around), radius * np.cos(around), color=COLOURS["cutter"], lw=0.8)
    arc = radius * np.sin(top), radius * np.cos(top)
    sector = {"color": COLOURS["printed"], "alpha": 0.35, "label": "sector, printed"}
    ax.fill([0, *arc[0]], [0, *arc[1]], **sector)
    ax.fill(*arc, color=COLOURS["correct"], alpha=0.6, label="segment")
    ax.axhline(wall, color=COLOURS["tunnel"], zorder=0)
    arrow = {"arrowstyle": "<->", "lw": 0.6}
    ax.annotate("", (1.15 * radius, wall), (1.15 * radius, radius), arrowprops=arrow)
    ax.text(1.22 * radius, radius - depth / 2, "$g$", va="center")
    equal(ax, "across / m", "into the wall / m")
    ax.set(xlim=(-1.4 * radius, 1.4 * radius), ylim=(-1.8 * radius, 1.2 * radius))


def draw_half_lens(ax, radius, advance, *, strip=None):
    """Draw the D that turns into half of the lens of two balls, or its upper half (Fig. 6).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, advance : float
        Of the ball; from one centre to the other, in m.
    strip : float, optional
        Height y of a strip of the integral, in m: then only the upper half is drawn, with it.
    """
    x = np.linspace(advance / 2, radius, 201)
    y = np.sqrt(np.clip(radius**2 - x**2, 0, None))
    around = np.linspace(0, 2 * np.pi, 241)
    low = -y if strip is None else 0 * y
    ax.fill_between(x, low, y, alpha=0.25, color=COLOURS["tangent sphere"])
    ax.plot(radius * np.cos(around), radius * np.sin(around), color=COLOURS["cutter"], lw=0.8)
    ax.plot([0, advance / 2], [0, 0], ".-", color=COLOURS["cutter"], lw=0.6)
    equal(ax, "along the path / m", "y / m")
    ax.set_xlim(-0.2 * radius, 1.15 * radius)
    if strip is None:
        ax.text(0.3 * advance + 0.44 * radius, 0, "D", ha="center", va="center")
    else:
        far = np.sqrt(max(radius**2 - strip**2, 0))
        ax.fill_between([advance / 2, far], strip, strip + 0.05 * radius, color=COLOURS["error"])
        ax.text(0.8 * radius, strip + 0.15 * radius, r"$\mathrm{d}y$")
        ax.text(advance / 4, -0.1 * radius, "$c/2$", ha="center", va="top")
        ax.set_ylim(-0.3 * radius, 1.1 * radius)


def draw_passes(ax, radius, depth, pitch):
    """Draw a plane wall, across the path, with a pass of a ball beside an earlier one.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, depth, pitch : float
        Of the ball; how far it cuts behind the wall; from pass to pass, all in m.

    Examples
    --------
    What is coloured as cut by this pass begins halfway to the earlier one, at its cusp:

    >>> from matplotlib.figure import Figure
    >>> ax = Figure().subplots()
    >>> draw_passes(ax, radius=0.2, depth=0.02, pitch=0.06)
    >>> float(ax.collections[-1].get_paths()[0].vertices[:, 0].min().round(2))
    -0.03
    """
    x = np.linspace(-pitch - 1.25 * radius, 1.25 * radius, 801)
    wall = depth - radius  # the centres are on this line
    earlier, this = (
        wall + np.sqrt(np.clip(radius**2 - (x - at) ** 2, 0, None)) for at in (-pitch, 0)
    )
    earlier = np.maximum(earlier, 0)
    ax.axhspan(0, radius, color=COLOURS["tunnel"], alpha=0.5, lw=0)
    ax.fill_between(x, 0, earlier, color="white", lw=0)
    ax.fill_between(x, earlier, this, where=this > earlier, color=COLOURS["correct"], lw=0)
    for at in (-pitch, 0):
        ax.add_patch(Circle((at, wall), radius, fill=False, ec=COLOURS["cutter"], lw=0.8))
    half = np.degrees(np.arccos(1 - depth / radius))
    edge = {"fill": False, "ec": COLOURS["printed"], "lw": 1.5}
    ax.add_patch(Wedge((0, wall), radius, 90 - half, 90 + half, **edge))
    equal(ax, "across / m", "into the wall / m")
