"""A drawing of how axes answer set-values, on the Axes `ax` that it is given."""

import numpy as np
from matplotlib.axes import Axes

from kit.kinds import Series
from kit.style import COLOURS, check_colour_names
from tunneller_lib.arguments import checked
from tunneller_lib.motion import Loop, follow


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
    check_colour_names("models", models)
    tracks = {name: follow(model, loop, setvalues) for name, model in models.items()}
    for name, track in tracks.items():
        ax.plot(track.time, np.degrees(track.position), color=COLOURS[name], label=name)
    unstable = [name for name, track in tracks.items() if track.stable == (False,)]
    ax.set_title(f"unstable: {', '.join(unstable)}" if unstable else "all stable")
    ax.set(xlabel="$t$ / s", ylabel="position / deg")
    return tracks
