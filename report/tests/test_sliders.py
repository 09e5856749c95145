"""Sliders: none without a screen, one for each value with one."""

import asyncio
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import ipywidgets
import pytest
from IPython.display import Image
from matplotlib.layout_engine import PlaceHolderLayoutEngine

from kit import figure, scene, sliders
from kit.camera import live

ROOT = Path(__file__).resolve().parents[2]
SLIDERS = "kit.interactive"


def draw(**values):
    """Return a drawing that knows what it was asked for."""
    drawing, _ = figure(height=2, width=3)
    drawing.values = values
    return drawing


@pytest.fixture
def shown(monkeypatch):
    """Return a list of what is displayed."""
    things = []
    monkeypatch.setattr("IPython.display.display", things.append)
    return things


def test_sliders_without_a_screen_draw_once(monkeypatch, shown):
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    assert sliders(draw, gain=(1.0, 20.0, 10.0), delay=(0, 4, 1)).values == {
        "gain": 10.0,
        "delay": 1,
    }
    assert shown == []


def test_sliders_with_a_screen_draw_again(monkeypatch, shown):
    monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    made = []
    picture = sliders(
        lambda **v: made.append(draw(**v)) or made[-1],
        loop_gain=(1.0, 20.0, 10.0, "1/s"),
        delay=(0, 4, 1),
    )
    assert picture.values == {"loop_gain": 10.0, "delay": 1}
    gain, delay, _ = shown[-1].children
    assert isinstance(gain, ipywidgets.FloatSlider) and isinstance(delay, ipywidgets.IntSlider)
    assert (gain.min, gain.max, gain.value, delay.max) == (1.0, 20.0, 10.0, 4)
    assert (gain.description, delay.description) == ("loop gain / 1/s", "delay")
    delay.value = 3
    assert made[-1].values == {"loop_gain": 10.0, "delay": 3}
    # A drawing that is moved keeps the places of the first one's axes.
    assert isinstance(made[-1].get_layout_engine(), PlaceHolderLayoutEngine)
    assert shown[-1].alt.endswith("Drawn for loop gain 10, delay 3.")
    assert [type(thing) for thing in shown] == [Image, ipywidgets.VBox, Image]


def test_scene_to_turn_has_a_title_and_is_smoothed_the_fast_way():
    frame = ipywidgets.HTML("<iframe src='scene?ui=1'></iframe>")
    frame.src = "scene?ui=1"
    smoothed = []
    plotter = SimpleNamespace(
        show=lambda return_viewer: frame, enable_anti_aliasing=smoothed.append
    )
    begin = '<iframe title="a &quot;ball&quot;" src=\'scene?ui=1&secret=s'
    assert live(plotter, 'a "ball"').value.startswith(begin)
    assert smoothed == ["msaa"]


SERVED = """
import asyncio, json, os, re
import aiohttp, msgpack, pyvista
from wslink.chunking import UnChunker, generate_chunks
from kit import scene
from kit.camera import live

async def welcome(address, word):  # what the server answers to a page that says a word
    hello = {"wslink": "1.0", "id": "system:c0:0", "method": "wslink.hello",
             "args": [{} if word is None else {"secret": word}]}
    async with aiohttp.ClientSession() as session, session.ws_connect(address) as page:
        for chunk in generate_chunks(msgpack.packb(hello), 100_000):
            await page.send_bytes(chunk)
        whole, answer = UnChunker(), None
        while answer is None:
            answer = whole.process_chunk((await page.receive(10)).data)
        return answer

async def main(early):
    if early:  # somebody showed a scene of their own, which started the server
        own = pyvista.Plotter(off_screen=True, notebook=True)
        own.show(return_viewer=True)
    found = []
    for _ in range(2):
        plotter = scene.empty()
        plotter.notebook = True
        plotter.add_mesh(scene.ball((0, 0, 0), 1.0))
        value = live(plotter, "a ball").value
        port, word = re.search(':([0-9]+)/index.html[^"]*&secret=([^"]+)"', value).groups()
        address = f"ws://127.0.0.1:{port}/ws"
        said = [await welcome(address, one) for one in (word, "wslink-secret", "", None)]
        found.append([word, *("clientID" in str(one.get("result")) for one in said)])
    print(json.dumps(found))

early = os.fork() == 0  # with what is imported
asyncio.run(main(early))
assert early or os.wait()[1] == 0
"""


@pytest.fixture(scope="module")
def served():
    """What two processes' servers of scenes say to pages that know their word, or another."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYVISTA_")}
    environment["PYVISTA_JUPYTER_BACKEND"] = "trame"
    done = subprocess.run([sys.executable, "-c", SERVED], cwd=ROOT, env=environment,
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return list(map(json.loads, done.stdout.splitlines()))


def test_scenes_are_served_to_those_alone_who_say_the_word_of_the_process(served):
    for every in served:
        assert [welcome for _, *welcome in every] == 2 * [[True, False, False, False]]
        assert every[0][0] == every[1][0]  # the server is one for all scenes


def test_word_for_scenes_is_random_and_differs_from_process_to_process(served):
    words = {every[0][0] for every in served}
    assert len(words) == 2
    for word in words:
        assert re.fullmatch("s[0-9a-f]{32}", word)  # 128 bits, and nothing that a page changes


def balls(radius):
    plotter = scene.empty()
    plotter.add_mesh(scene.ball((0, 0, 0), 1))
    plotter.add_mesh(scene.ball((2, 0, 0), radius))
    return scene.look(plotter, (1, -2, 1))


@pytest.mark.parametrize("thing", [draw, balls])
def test_sliders_without_a_screen_show_what_has_a_text(monkeypatch, shown, thing):
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    sliders(thing, alt="What is seen.", radius=(0.1, 1.0, 0.5))
    [image] = shown
    assert image.alt == "What is seen."


@pytest.fixture
def turned(monkeypatch):
    """Return what a live scene's widget is asked: by which threads it is updated."""
    monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    widget, updates = ipywidgets.HTML(), []
    widget.viewer = SimpleNamespace(update=lambda: updates.append(threading.get_ident()))
    monkeypatch.setattr(f"{SLIDERS}.live", lambda plotter, title: widget)
    return updates


def push(slider, *values):
    """Move a slider in another thread, as JupyterLab does."""
    for value in values:
        slider.value = value


def test_sliders_with_a_screen_refill_the_scene_that_is_turned(shown, turned):
    async def moved():
        plotter = sliders(balls, alt="Two balls.", radius=(0.1, 1.0, 0.5))
        before = plotter.bounds, plotter.camera_position
        await asyncio.sleep(0.01)  # what is drawn at the start
        await asyncio.to_thread(push, shown[-1].children[0], 1.0)
        await asyncio.sleep(0.01)
        return before, (plotter.bounds, plotter.camera_position)

    (bounds, camera), (bounds_after, camera_after) = asyncio.run(moved())
    assert turned == [threading.get_ident()] * 2  # at the start, too
    assert (bounds[1], bounds_after[1]) == pytest.approx((2.5, 3.0), rel=1e-3)
    assert camera == camera_after


def test_sliders_say_why_a_scene_cannot_be_drawn(shown, turned):
    def some(radius):
        if radius > 0.9:
            raise ValueError("radius: must leave room.")
        return balls(radius)

    async def moved():
        sliders(some, alt="Two balls.", radius=(0.1, 1.0, 0.5))
        slider, _, told = shown[-1].children
        said = []
        for value in (1.0, 0.6):
            await asyncio.to_thread(push, slider, value)
            await asyncio.sleep(0.01)
            said.append([output["text"] for output in told.outputs])
        return said

    assert asyncio.run(moved()) == [["ValueError: radius: must leave room.\n"], []]
