"""Scenes that are turned in a live notebook."""

import html

WINDOW = [800, 560]  # px


def live(plotter, title):
    """Return a widget in which a scene is turned.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene, its camera set; its window gets the widget's size.
    title : str
        What it shows, for those who can't see it.

    Returns
    -------
    widget : ipywidgets.HTML
        With pyvista's ``viewer``, whose ``update`` shows what has changed in the scene.
    """
    plotter.window_size = WINDOW
    widget = plotter.show(return_viewer=True)
    frame = f'<iframe title="{html.escape(title)}"'
    widget.value = widget.value.replace("<iframe", frame, 1)
    return widget


def refill(plotter, other):
    """Put another scene's actors in place of a scene's own; it keeps its camera and its lights.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene that is shown.
    other : pyvista.Plotter
        The one that gives its actors; it is closed.
    """
    plotter.clear_actors()
    for name, actor in other.actors.items():
        plotter.add_actor(actor, name=name, reset_camera=False, render=False)
    other.close()
