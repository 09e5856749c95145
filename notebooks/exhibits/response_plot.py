"""A drawing of how axes answer set-values, on the Axes `ax` that it is given."""

import numpy as np

from kit.style import COLOURS
from tunneller_lib.motion import follow


def draw_responses(ax, models, loop, setvalues):
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
    """
    tracks = {name: follow(model, loop, setvalues) for name, model in models.items()}
    for name, track in tracks.items():
        ax.plot(track.time, np.degrees(track.position), color=COLOURS[name], label=name)
    unstable = [name for name, track in tracks.items() if track.stable == (False,)]
    ax.set_title(f"unstable: {', '.join(unstable)}" if unstable else "all stable")
    ax.set(xlabel="$t$ / s", ylabel="position / deg")
