"""Sliders: none without a screen, one for each value with one."""

import asyncio
import threading
from types import SimpleNamespace

import ipywidgets
import numpy as np
import pytest
from IPython.display import Image

from tunneller_lib.reporting import figure, scene
from tunneller_lib.reporting.live_scene import refill
from tunneller_lib.reporting.sliders import sliders

SLIDERS = "tunneller_lib.reporting.sliders"


def draw(**values):
    """Return a drawing that knows what it was asked for."""
    drawing, _ = figure(height=2, width=3)
    drawing.values = values
    return drawing


@pytest.fixture
def shown(monkeypatch):
    """Return a list of what is displayed."""
    things = []
    monkeypatch.setattr(f"{SLIDERS}.display", things.append)
    return things


def test_sliders_without_a_screen_draw_once(monkeypatch, shown):
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    assert sliders(draw, gain=(1.0, 20.0, 10.0), delay=(0, 4, 1)).values == {
        "gain": 10.0,
        "delay": 1,
    }
    assert shown == []


def test_sliders_without_a_screen_show_what_has_a_text(monkeypatch, shown):
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    sliders(draw, alt="Nothing.", gain=(1.0, 20.0, 10.0))
    [image] = shown
    assert image.alt == "Nothing."


def test_sliders_with_a_screen_draw_again(monkeypatch, shown):
    monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    calls = []
    picture = sliders(
        lambda **v: calls.append(v) or draw(**v), gain=(1.0, 20.0, 10.0, "1/s"), delay=(0, 4, 1)
    )
    assert picture.values == {"gain": 10.0, "delay": 1}
    gain, delay, _ = shown[-1].children
    assert isinstance(gain, ipywidgets.FloatSlider) and isinstance(delay, ipywidgets.IntSlider)
    assert (gain.min, gain.max, gain.value, delay.max) == (1.0, 20.0, 10.0, 4)
    assert (gain.description, delay.description) == ("gain / 1/s", "delay")
    delay.value = 3
    assert calls[-1] == {"gain": 10.0, "delay": 3}
    assert shown[-1].alt.endswith("Drawn for gain 10, delay 3.")
    assert [type(thing) for thing in shown] == [Image, ipywidgets.VBox, Image]


def test_sliders_refuse_a_start_beyond_the_range():
    with pytest.raises(ValueError, match=r"^gain: must start from 1 to 5; got 9\.$"):
        sliders(draw, gain=(1, 5, 9))


def test_sliders_keep_the_places_of_axes(monkeypatch, shown):
    monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    drawings = []

    def labelled(lines):
        drawing, ax = figure(height=4, width=6)
        ax.set_ylabel("\n".join(["a line"] * lines))  # takes room from the axes
        drawings.append(drawing)
        return drawing

    sliders(labelled, lines=(1, 9, 1))
    shown[-1].children[0].value = 9
    first, last = drawings[0], drawings[-1]
    places = [drawing.axes[0].get_position().bounds for drawing in (first, last)]
    assert places[0] == places[1]
    anew = labelled(9)
    anew.draw_without_rendering()
    assert anew.axes[0].get_position().x0 > places[0][0] + 0.1


def balls(radius):
    plotter = scene.scene()
    plotter.add_mesh(scene.ball((0, 0, 0), 1))
    plotter.add_mesh(scene.ball((2, 0, 0), radius))
    return scene.look(plotter, (1, -2, 1))


def test_refilled_scene_looks_like_the_other_one():
    plotter, other = balls(1), balls(1)
    plotter.add_mesh(scene.ball((1, 0, 1), 0.5), reset_camera=False)
    before, wanted = (p.screenshot(return_img=True) for p in (plotter, other))
    refill(plotter, balls(1))
    plotter.render()
    assert np.array_equal(plotter.screenshot(return_img=True), wanted)
    assert not np.array_equal(before, wanted)


def test_sliders_without_a_screen_show_a_scene(monkeypatch, shown):
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    sliders(balls, alt="Two balls.", radius=(0.1, 1.0, 0.5))
    [image] = shown
    assert image.alt == "Two balls."


def test_sliders_with_a_screen_refill_the_scene_that_is_turned(monkeypatch, shown):
    monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    widget, updates = ipywidgets.HTML(), []
    widget.viewer = SimpleNamespace(update=lambda: updates.append(threading.get_ident()))
    monkeypatch.setattr(f"{SLIDERS}.live", lambda plotter, title: widget)

    async def moved():
        plotter = sliders(balls, alt="Two balls.", radius=(0.1, 1.0, 0.5))
        before = plotter.bounds, plotter.camera_position
        slider = shown[-1].children[0]
        await asyncio.to_thread(setattr, slider, "value", 1.0)  # as JupyterLab does
        await asyncio.sleep(0.01)
        return before, (plotter.bounds, plotter.camera_position)

    (bounds, camera), (bounds_after, camera_after) = asyncio.run(moved())
    assert updates == [threading.get_ident()] * 2  # at the start, too
    assert (bounds[1], bounds_after[1]) == pytest.approx((2.5, 3.0), rel=1e-3)
    assert camera == camera_after
