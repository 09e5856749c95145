"""Drawings of set-values in time and of tasks, each on the Axes `ax` that it is given."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from ..arguments import Each, Finite, Positive, Wholes, checked, shown
from ..motion import Loop, follow
from ..motion.tasks import HandOver, Task, schedule
from .kinds import Series
from .style import COLOURS, Colour

LONGEST = 1000  # ticks of a segment that is drawn


@checked
def draw_setvalues(
    ax: Axes,
    t: Series,
    values: Series,
    ideal: Series,
    *,
    box: Finite | None = None,
    colour: Colour = "correct",
):
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

    Returns
    -------
    lines : list of matplotlib.lines.Line2D
        The ideal line and the circles.
    """
    if not len(t) == len(values) == len(ideal):
        lengths = len(t), len(values), len(ideal)
        raise ValueError(f"t, values, ideal: must be of one length; got {lengths}.")
    lines = ax.plot(t, ideal, color=COLOURS["chord"], lw=0.8)
    lines += ax.plot(t, values, "o", color=COLOURS[colour], mfc="white", ms=4.5)
    if box is None or box <= 0:
        return lines
    width = t[1] - t[0]
    for x, y in zip(t, values, strict=True):
        corner = (x - width / 2, y - box / 2)
        ax.add_patch(Rectangle(corner, width, box, fill=False, ec=COLOURS[colour], lw=0.6))
    return lines


def _check_names(argument, names):
    for name in names:
        if name not in COLOURS:
            raise ValueError(f"{argument}: each name must be one in COLOURS; got {shown(name)}.")


def _draw_rows(ax, rows, unit):
    """Draw rows, by name a colour's name and a list of (start, stop); return each row's bars."""
    bars = []
    for i, (colour, spans) in enumerate(rows.values()):
        lengths = [(unit * a, unit * (b - a)) for a, b in spans]
        bars.append(ax.broken_barh(lengths, (-i - 0.38, 0.76), fc=COLOURS[colour], lw=0))
    ax.set_yticks(-np.arange(len(rows)), list(rows))
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(0.6 - len(rows), 0.6)
    return bars


@checked
def draw_responses(ax: Axes, models: dict, loop: Loop, setvalues: Series):
    """Draw how models of an axis answer set-values; the title says which are unstable.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    models : dict
        Plants by their names in `COLOURS`.
    loop : Loop
        The position loop of each.
    setvalues : (n,) float
        In rad.

    Returns
    -------
    tracks : dict
        A `Track` for each name.
    """
    _check_names("models", models)
    tracks = {name: follow(model, loop, setvalues) for name, model in models.items()}
    for name, track in tracks.items():
        ax.plot(track.time, np.degrees(track.position), color=COLOURS[name], label=name)
    unstable = [name for name, track in tracks.items() if track.stable == (False,)]
    ax.set_title(f"unstable: {', '.join(unstable)}" if unstable else "all stable")
    ax.set(xlabel="$t$ / s", ylabel="position / deg")
    return tracks


@checked
def draw_hand_over(
    ax: Axes,
    tasks: Each(Task),
    run: HandOver,
    ticks: Wholes("(n,) int", 1, LONGEST),
    *,
    unit: Positive = 1.0,
):
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

    Raises
    ------
    ValueError
        If a task's name is no colour's, or there aren't as many ticks as segments.
    """
    if not tasks:
        raise ValueError("tasks: must be at least one; got none.")
    _check_names("tasks", [task.name for task in tasks])
    if np.shape(ticks) != (len(run.started),):
        raise ValueError(f"ticks: must be {len(run.started)} numbers (n,); got {np.shape(ticks)}.")
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
    bars = _draw_rows(ax, rows, unit)
    bars[-2].set(ec="white", lw=1.0)  # segments follow each other without a gap
    for start in run.started:
        ax.axvline(unit * start, color=COLOURS["chord"], lw=0.4, ls=":")
