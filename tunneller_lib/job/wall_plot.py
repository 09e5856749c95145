"""Pictures of a cut: the unrolled wall, and the overbreak of single laps."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..atomic_write import writing
from .mesh import SCALAR

ROOF = np.pi / 2  # rad, the angle of the roof, which is drawn in the middle
SAMPLES = 3601  # of the section, between which arc lengths are interpolated
DPI = 200  # the pictures are 6.3 inches wide
TUNNEL, FIRST, LAST, LIMITS = "#C9C2B8", "#C42A52", "#222222", "#4D4D4D"
WHOLE = 0.999  # share of the depth of cut: ground that stands farther in is untouched


def write_pictures(job, cut, wall, laps):
    """Write the unrolled wall of a job's cut and its laps to PNG files; return their paths."""
    figure = Figure(figsize=(6.3, 3.6), layout="constrained")
    tolerance = job.plan["tolerance"]
    draw_unrolled(figure.subplots(), cut, limit=1.5 * tolerance)
    write_drawing(wall, figure, job.stamp)
    figure = Figure(figsize=(6.3, 2.4), layout="constrained")
    draw_laps(figure.subplots(), cut, tolerance=tolerance)
    return [wall, write_drawing(laps, figure, job.stamp)]


def draw_unrolled(ax, cut, *, limit):
    """Draw the standing wall, unrolled and seen from within, with its overbreak in colour.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    cut : Cut
        A simulated or carved cut.
    limit : float
        Over- and underbreak at the ends of the colour scale, in m. Untouched ground has a colour
        of its own.

    Returns
    -------
    shades : matplotlib.collections.QuadMesh
        Overbreak in mm; x is the arc length from the roof, in m, positive to the right.
    """
    lines = cut.wall.lines
    along = _from_roof(cut.plan.circuit.section, np.arctan2(lines.sin, lines.cos))
    order = np.argsort(along)
    over = cut.overbreak[:, order]
    untouched = over < -WHOLE * cut.plan.circuit.machine.depth
    ax.set_facecolor(TUNNEL)
    ax.set(xlabel="along the section from the roof / m (right)", ylabel="along the tunnel / m")
    millimetres = np.ma.masked_where(untouched, 1e3 * over)
    span = {"vmin": -1e3 * limit, "vmax": 1e3 * limit}
    shades = ax.pcolormesh(
        along[order], lines.x, millimetres, cmap="RdBu_r", rasterized=True, **span
    )
    ax.figure.colorbar(shades, ax=ax, label=SCALAR, extend="both")
    return shades


def draw_laps(ax, cut, *, tolerance):
    """Draw the overbreak of a cut's first lap and, if there are several, of its last.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    cut : Cut
        A simulated or carved cut.
    tolerance : float
        Drawn on both sides of zero, in m.

    Returns
    -------
    lines : list of matplotlib.lines.Line2D
        Overbreak in mm over the arc length along the offset section in m: of the first lap, in
        whole ground, and of the last, which is cut beside another.

    Examples
    --------
    >>> from types import SimpleNamespace as Made
    >>> for laps in (1, 2):
    ...     cut = Made(plan=Made(places=[0.0, 1.0], laps=laps), lap_deviations=np.zeros((laps, 2)))
    ...     [line.get_label() for line in draw_laps(Figure().subplots(), cut, tolerance=1e-3)]
    ['lap 1']
    ['lap 1', 'lap 2, beside another']
    """
    plan = cut.plan
    places = plan.places
    deviations = 1e3 * cut.lap_deviations
    lines = ax.plot(places, deviations[0], color=FIRST, lw=0.8, label="lap 1")
    if plan.laps > 1:
        beside = f"lap {plan.laps}, beside another"
        lines += ax.plot(places, deviations[-1], color=LAST, lw=0.8, label=beside)
    for side in (-1e3, 1e3):
        ax.axhline(side * tolerance, color=LIMITS, lw=0.5, ls="--")
    ax.set(xlabel="place along the offset section / m", ylabel="overbreak / mm")
    ax.legend()
    return lines


def write_drawing(path, figure, stamp):
    """Write a matplotlib figure to a PNG file with a stamp as its comment; return the path."""
    figure.set_dpi(DPI)
    # Not by savefig, which would draw twice, once for the layout.
    with writing(path):
        FigureCanvasAgg(figure).print_png(path, metadata={"Comment": stamp})
    return path


def _from_roof(section, angle):
    """Return the arc lengths (n,) in m from a section's roof to the right, at angles in rad."""
    s = np.linspace(0, section.perimeter, SAMPLES)
    y, z = section.point(s).T
    turned = np.unwrap(np.arctan2(z, y))
    place = np.interp(np.mod(np.append(ROOF, angle) - turned[0], 2 * np.pi), turned - turned[0], s)
    half = section.perimeter / 2
    return np.mod(place[1:] - place[0] + half, 2 * half) - half
