"""One look for all drawings: the report's width, its text size, a colour for each thing."""

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"  # of text in drawings, pinned with it
TEXT_WIDTH = 16.0  # cm, of the report

# Colours that stay apart for the colour-blind (Okabe and Ito, some darkened); what is compared
# in one drawing differs in lightness too, for a print in grey.
COLOURS = {
    "torus": "#8FA3B5",
    "inner sheet": "#E3B587",
    "tunnel": "#C9C2B8",
    "offset": "#CC79A7",
    "chord": "#222222",
    "tangent sphere": "#0072B2",
    "geodesic": "#D55E00",
    "printed": "#E69F00",
    "correct": "#005F47",
    "error": "#C42A52",
    "corrected": "#7A1FA2",
    "machine": "#F0C83C",
    "cutter": "#4D4D4D",
    "T0": "#B9B9B9",
    "T1": "#3F9BD6",
    "T2": "#007A59",
    "T3": "#6A3D9A",
    "interpolation": "#1B6CA8",
    "servo": "#7FB3D5",
    "preparation": "#BD7420",
    "design surface": "#9AA8B8",
    "cone": "#2A9D76",
    "generator": "#E69F00",
    "top view": "#D8B400",
    "plane": "#CC79A7",
}

ERROR_MAP = "RdBu_r"  # of errors on the wall: overbreak red, underbreak blue

STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titley": 1.0,  # to look for a better place takes a fifth of the time
    "axes.labelsize": 9,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    # Not "cm": its letters aren't at their places of Unicode, so a search for a φ finds none.
    "mathtext.fontset": "stix",
    "font.sans-serif": ["DejaVu Sans"],
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "grid.linewidth": 0.4,
    "grid.color": "#DDDDDD",
    "legend.frameon": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}


def figure(rows=1, cols=1, *, height, width=TEXT_WIDTH, divisions=None, **subplots):
    """Return a new drawing at its printed size.

    Parameters
    ----------
    rows, cols : int
        Axes below and beside each other.
    height, width : float
        Size on paper, in cm.
    divisions : int, optional
        Most of them that ticks make on an axis, where it stays linear and its ticks aren't set.
        Each tick takes half a millisecond to draw: under a slider two axes may well have few.
    **subplots
        Passed on to matplotlib's ``Figure.subplots``.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Not known to pyplot: it is shown where it is recorded, and nowhere else.
    axes : matplotlib.axes.Axes or array of them
        As matplotlib gives them.

    Examples
    --------
    >>> drawing, ax = figure(height=5)
    >>> line = ax.plot([0, 1], [0, 1], color=COLOURS["chord"])
    """
    matplotlib.rcParams.update(STYLE)
    drawing = Figure(figsize=(width / 2.54, height / 2.54), layout="constrained")
    axes = drawing.subplots(rows, cols, **subplots)
    if divisions is not None:
        for ax in drawing.axes:
            ax.locator_params(nbins=divisions)
    return drawing, axes
