"""Drawings on the Axes `ax` of rods: the shadow, crossings, a box above, a cut row of lines."""

import numpy as np
from matplotlib.patches import Ellipse, Rectangle

from kit.style import COLOURS
from tunneller_lib.surfaces import meet_box

from .plot import equal


def draw_shadow(ax, radius, run, tilt):
    """Draw the shadow of a rod as lines along z see it: two ellipses and a rectangle.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, run : float
        Of the rod, and of its axis as seen, in m.
    tilt : float
        Ratio of the ellipses' axes.
    """
    outline = {"fill": False, "edgecolor": COLOURS["torus"], "lw": 1.2}
    ax.add_patch(Rectangle((0, -radius), run, 2 * radius, **outline))
    for m in (0, run):
        ax.add_patch(Ellipse((m, 0), 2 * radius * tilt, 2 * radius, **outline))
    ax.plot([0, run], [0, 0], ".-", color=COLOURS["torus"], lw=0.6)
    equal(ax, "along the axis, $m$, in metres", "aside, $s$, in metres")
    ax.autoscale_view()


def draw_crossings(ax, radius, run, tilt, aside):
    """Draw the shadow of a rod, and where lines at a distance s cross its two ellipses.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    radius, run : float
        Of the rod, and of its axis as seen, in m.
    tilt : float
        Ratio of the ellipses' axes.
    aside : float
        The distance s, from -radius to radius, in m.
    """
    draw_shadow(ax, radius, run, tilt)
    k = tilt * np.sqrt((radius - aside) * (radius + aside))
    four = np.array([-k, k, run - k, run + k])
    for colour, ends, words in (
        ("tangent sphere", four[:2], "in by the lower disc"),
        ("correct", four[1:3], "in and out by the wall"),
        ("geodesic", four[2:], "out by the upper disc"),
    ):
        look = {"color": COLOURS[colour], "lw": 2.5, "solid_capstyle": "butt"}
        ax.plot(ends, [aside, aside], "-", label=words, **look)
    ax.plot(four, np.full(4, aside), "o", color=COLOURS["chord"], ms=4)
    clear = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
    for m, name in zip(four, ("$-k$", "$k$", "$d-k$", "$d+k$"), strict=True):
        ax.annotate(name, (m, aside), (0, 6), textcoords="offset points", ha="center", bbox=clear)


def draw_rod_and_box(ax, rod, aside, width, depth):
    """Draw between which heights upright lines, and a box about them, touch a rod.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    rod : Rod
    aside : float
        The y of the lines and of the box's middle, in m.
    width, depth : float
        Of the box, along x and y, in m.
    """
    room = rod.radius + width
    x = np.linspace(min(rod.a[0], rod.b[0]) - room, max(rod.a[0], rod.b[0]) + room, 401)
    place = np.stack([x, np.full_like(x, aside)], axis=-1)
    half = np.array([width, depth]) / 2
    thin = rod.meet_line(np.insert(place, 2, 0, axis=-1), (0, 0, 1))
    wide = meet_box(rod, place - half, place + half)
    both = ("line", thin, "cutter", "--"), ("box", wide, "correct", "-")
    for name, ends, colour, style in both:
        for heights, label in zip(ends, (None, name), strict=True):
            seen = np.where(np.isfinite(heights), heights, np.nan)
            ax.plot(x, seen, style, color=COLOURS[colour], label=label)
    equal(ax, "x / m", "z / m")


def draw_cut_row(ax, grid, capsule):
    """Draw a row of a grid's upright lines, as bars, with the outline of a capsule there.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    grid : DexelGrid
        With lines along z.
    capsule : Rod
        With round ends, its axis in a plane y = const; the row next to it is drawn.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from tunneller_lib.removal import DexelGrid
    >>> from tunneller_lib.surfaces import Rod
    >>> ax = Figure().subplots()
    >>> grid = DexelGrid.cartesian([0, 0, 0], [1, 1, 1], (8, 3))
    >>> draw_cut_row(ax, grid, Rod([0.3, 0.5, 0.5], [0.7, 0.5, 0.5], 0.1, ends="round"))
    >>> len(ax.collections[0].get_segments())  # a bar for each line of the row
    8
    >>> outline = ax.patches[0].get_xy()
    >>> outline.min(axis=0).round(3).tolist(), outline.max(axis=0).round(3).tolist()
    ([0.2, 0.4], [0.8, 0.6])
    """
    row = np.argmin(np.abs(grid.lines.aside - capsule.a[1]))
    low, high = grid.low[..., row], grid.high[..., row]
    left = low < high
    x = np.broadcast_to(grid.lines.x, low.shape)
    look = {"color": COLOURS["tunnel"], "lw": 150 / len(grid.lines.x)}
    ax.vlines(x[left], low[left], high[left], **look)
    # The row's plane cuts the capsule in a thinner one: half circles about both ends.
    off = grid.lines.aside[row] - capsule.a[1]
    thinner = np.sqrt(max(capsule.radius**2 - off**2, 0.0))
    turn = np.linspace(0, 2 * np.pi, 201)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    a, b = (np.asarray(end)[[0, 2]] for end in (capsule.a, capsule.b))
    outline = np.where((circle @ (b - a) < 0)[:, None], a, b) + thinner * circle
    ax.fill(*outline.T, fill=False, ec=COLOURS["cutter"], lw=1.2, zorder=3)
    equal(ax, "x / m", "z / m")
