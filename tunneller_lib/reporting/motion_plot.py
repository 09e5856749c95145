"""Drawings of set-values in time and of tasks, each on the Axes that it is given."""

import numpy as np
from matplotlib.patches import Rectangle

from ..motion import follow
from ..motion.tasks import schedule
from .style import COLOURS


def draw_setvalues(ax, t, values, ideal, *, box=None, colour="correct"):
    """Draw set-values as circles on their ideal line, as the document's listing plots them.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    t, values : (n,) float
        Times in s and set-values in counts.
    ideal : (n,) float
        The line that they should be on.
    box : float, optional
        Height of a rectangle about each set-value, a step wide; none where it isn't above zero.
    colour : str
        Name in `COLOURS`.

    Returns
    -------
    lines : list of matplotlib.lines.Line2D
        The ideal line and the circles.
    """
    lines = ax.plot(t, ideal, color=COLOURS["chord"], lw=0.8)
    lines += ax.plot(t, values, "o", color=COLOURS[colour], mfc="white", ms=4.5)
    width = t[1] - t[0]
    for x, y in zip(t, values, strict=True) if box and box > 0 else ():
        corner = (x - width / 2, y - box / 2)
        ax.add_patch(Rectangle(corner, width, box, fill=False, ec=COLOURS[colour], lw=0.6))
    return lines


def draw_tasks(ax, rows, *, unit=1.0):
    """Draw who has the processor when, a row a task, the most urgent on top.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    rows : dict
        For each task's name, a colour's name and a list of (start, stop).
    unit : float
        Drawn time of one unit of the tasks.

    Returns
    -------
    bars : list
        The collection of bars of each row.
    """
    bars = []
    for i, (colour, spans) in enumerate(rows.values()):
        lengths = [(unit * a, unit * (b - a)) for a, b in spans]
        bars.append(ax.broken_barh(lengths, (-i - 0.38, 0.76), fc=COLOURS[colour], lw=0))
    ax.set_yticks(-np.arange(len(rows)), list(rows))
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(0.6 - len(rows), 0.6)
    return bars


def draw_responses(ax, models, loop, setvalues):
    """Draw how models of an axis answer set-values; the title says which are unstable.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    models : dict
        Plants by their names in `COLOURS`.
    loop : Loop
        The position loop of each.
    setvalues : (ticks + 1,) float
        In rad.

    Returns
    -------
    tracks : dict
        A `Track` for each name.
    """
    tracks = {name: follow(model, loop, setvalues) for name, model in models.items()}
    for name, track in tracks.items():
        ax.plot(track.time, np.degrees(track.position), color=COLOURS[name], label=name)
    unstable = [name for name, track in tracks.items() if track.stable == (False,)]
    ax.set_title(f"unstable: {', '.join(unstable)}" if unstable else "all stable")
    ax.set(xlabel="$t$ / s", ylabel="position / deg")
    return tracks


def draw_hand_over(ax, tasks, run, ticks, *, unit=1.0):
    """Draw fast tasks, preparations, segments and waits of a run with a double buffer (Fig. 7).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    tasks : sequence of Task
        The fast tasks; their names are colours too, the first is the interpolation.
    run : HandOver
        What became of the segments.
    ticks : sequence of int
        How long each segment lasts.
    unit : float
        Drawn time of one unit of the tasks.
    """
    tick = tasks[0].period
    ends = [start + number * tick for start, number in zip(run.started, ticks, strict=True)]
    slices, _ = schedule(tasks, ends[-1])
    rows = {
        task.name: (task.name, [s[1:] for s in slices if s.name == task.name]) for task in tasks
    }
    free = [0, *(max(pair) for pair in zip(run.ready, run.started, strict=True))]
    rows["preparation"] = "preparation", list(zip(free[:-1], run.ready, strict=True))
    rows["segment"] = "tangent sphere", list(zip(run.started, ends, strict=True))
    rows["starved"] = (
        "error",
        [pair for pair in zip(run.needed, run.started, strict=True) if pair[1] > pair[0]],
    )
    bars = draw_tasks(ax, rows, unit=unit)
    bars[-2].set(ec="white", lw=1.0)  # segments follow each other without a gap
    for start in run.started:
        ax.axvline(unit * start, color=COLOURS["chord"], lw=0.4, ls=":")
