"""Drawings of set-values in time and of tasks, each on the Axes `ax` that it is given."""

from itertools import pairwise

import numpy as np
from matplotlib.patches import Rectangle

from kit.style import COLOURS
from tunneller_lib.motion.tasks import schedule


def draw_setvalues(ax, t, values, ideal, *, box=None, colour="correct"):
    """Draw set-values as circles on their ideal line, as the document's listing plots them.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    t, values : (n,) float
        Times in s and set-values in counts.
    ideal : (n,) float
        The line that they should be on.
    box : float, optional
        Height of a rectangle about each set-value, a step wide; none where it isn't above zero.
    colour : str
        Name in `COLOURS`.
    """
    ax.plot(t, ideal, color=COLOURS["chord"], lw=0.8)
    ax.plot(t, values, "o", color=COLOURS[colour], mfc="white", ms=4.5)
    if not box or box < 0:
        return
    width = t[1] - t[0]
    for x, y in zip(t, values, strict=True):
        corner = (x - width / 2, y - box / 2)
        ax.add_patch(Rectangle(corner, width, box, fill=False, ec=COLOURS[colour], lw=0.6))


def draw_hand_over(ax, tasks, run, ticks, *, unit=1.0):
    """Draw fast tasks, preparations, segments and waits of a run with a double buffer (Fig. 7).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    tasks : list of Task
        The fast tasks; their names are colours too, the first is the interpolation.
    run : HandOver
        What became of the segments.
    ticks : (n,) int
        How long each segment lasts, 1 to 1000.
    unit : float
        Drawn time of one unit of the tasks.
    """
    # A row a task, the most urgent on top; beneath them how the segments fared.
    tick = tasks[0].period
    ends = [start + number * tick for start, number in zip(run.started, ticks, strict=True)]
    slices, _ = schedule(tasks, ends[-1])
    rows = {}
    for task in tasks:
        rows[task.name] = task.name, [s[1:] for s in slices if s.name == task.name]
    free = [0, *(max(pair) for pair in zip(run.ready, run.started, strict=True))]
    rows["preparation"] = "preparation", list(zip(free[:-1], run.ready, strict=True))
    rows["segment"] = "tangent sphere", list(zip(run.started, ends, strict=True))
    waits = zip(run.needed, run.started, strict=True)
    rows["starved"] = "error", [(needed, started) for needed, started in waits if started > needed]
    bars = []
    for i, (colour, spans) in enumerate(rows.values()):
        lengths = [(unit * a, unit * (b - a)) for a, b in spans]
        bars.append(ax.broken_barh(lengths, (-i - 0.38, 0.76), fc=COLOURS[colour], lw=0))
    ax.set_yticks(-np.arange(len(rows)), list(rows))
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(0.6 - len(rows), 0.6)
    bars[-2].set(ec="white", lw=1.0)  # segments follow each other without a gap
    for start in run.started:
        ax.axvline(unit * start, color=COLOURS["chord"], lw=0.4, ls=":")


def draw_scheme(ax):
    """Draw the blocks of the document's scheme (Fig. 7): two tasks, and a loop for each joint.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Sixteen units wide and seven high, once it is drawn on.
    """
    ax.set(xlim=(0, 16), ylim=(0, 7), aspect="equal")
    ax.axis("off")
    prepared = COLOURS["preparation"]
    words = [
        (6.4, "points on the circuit", COLOURS["chord"]),
        (4.7, "slow task:\nfeet on the torus,\nnext segment", prepared),
        (2.9, "buffer:\none segment ahead", prepared),
        (1.1, "fast task, each tick:\ninteger line", COLOURS["interpolation"]),
    ]
    tasks = [_block(ax, 2.1, y, text, colour, width=3.4) for y, text, colour in words]
    for upper, lower in pairwise(tasks):
        _arrow(ax, (2.1, upper.get_y()), (2.1, lower.get_y() + lower.get_height()))
    for y, joint, cylinder in [(5.4, r"$\theta$", "cylinder"), (2.4, r"$\varphi$", "cylinders")]:
        row = [
            _block(ax, 7.8, y, f"loop of {joint}", COLOURS["servo"]),
            _block(ax, 10.1, y, "servo\nvalve", COLOURS["cutter"]),
            _block(ax, 12.4, y, cylinder, COLOURS["cutter"]),
            _block(ax, 14.8, y, f"joint {joint},\nencoder", COLOURS["cutter"]),
        ]
        first, *_, last = row
        out = tasks[-1].get_x() + tasks[-1].get_width()
        _arrow(ax, (out, 1.1), (4.7, 1.1), (4.7, y), (first.get_x(), y))
        for one, other in pairwise(row):
            _arrow(ax, (one.get_x() + one.get_width(), y), (other.get_x(), y))
        back = y - 1.3
        _arrow(ax, (14.8, last.get_y()), (14.8, back), (7.8, back), (7.8, first.get_y()))
        ax.annotate(f"set-value of {joint}", (4.8, y + 0.12), fontsize=7)
        ax.annotate(f"counts of {joint}", (10.6, back + 0.12), fontsize=7)


def _block(ax, x, y, text, colour, width=1.7):
    """Return a framed text about its middle, high enough for its lines."""
    height = 0.3 + 0.4 * (1 + text.count("\n"))
    frame = Rectangle((x - width / 2, y - height / 2), width, height, fc="white", ec=colour, lw=1.2)
    ax.annotate(text, (x, y), ha="center", va="center", fontsize=8)
    return ax.add_patch(frame)


def _arrow(ax, *corners):
    """Draw an arrow through its corners."""
    for start, stop in pairwise(corners):
        head = "-|>" if stop == corners[-1] else "-"
        style = {"arrowstyle": head, "lw": 0.8, "shrinkA": 0, "shrinkB": 0, "fc": "k"}
        ax.annotate("", stop, start, arrowprops=style)
