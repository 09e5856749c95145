"""Sliders: none without a screen, one for each value with one."""

import ipywidgets
import pytest
from IPython.display import Image

from tunneller_lib.reporting import figure
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
