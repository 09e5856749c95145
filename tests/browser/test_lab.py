"""The notebooks in JupyterLab: run to the end, moved by hand, quick to answer."""

import os
import time

import nbformat
import pytest
from chromium import wait

from report.sources import INDEX, notebooks

# Their first sliders move what is in a scene.
SCENES = "01_machine 07_chord 44_sections 53_contact 56_blades".split()


def test_first_figure_is_moved_within_a_minute(lab):
    lab.open("notebooks/02_torus.ipynb")
    lab.start()
    lab.move()
    taken = time.monotonic() - lab.began
    print(f"\nfrom the start of JupyterLab to the first moved figure: {taken:.0f} s")
    assert taken < 60
    lab.close()


@pytest.mark.parametrize("name", [n.stem for n in notebooks()])
def test_notebook_runs_to_its_end_and_is_moved_at_once(lab, name):
    lab.open(f"notebooks/{name}.ipynb")
    lab.start()
    assert lab.finish() == []
    if name in SCENES:
        taken = lab.move_scene(2)
        print(f"\n{name}: {min(taken):.1f} s, looking at the scene included")
    elif name != INDEX:
        taken = sorted(lab.move(12))
        cores, load = os.cpu_count(), os.getloadavg()[0]
        print(f"\n{name}: {1000 * taken[0]:.0f} ms at best, {1000 * taken[6]:.0f} ms in the "
              f"median, on {cores} cores with a load of {load:.1f}")  # fmt: skip
        assert taken[6] < 0.2
    assert lab.errors() == []
    hosts = {request.split("/")[2].split(":")[0] for request in lab.browser.requests
             if request.startswith(("http", "ws"))}  # fmt: skip
    assert hosts <= {"localhost", "127.0.0.1"}
    lab.close()


def test_scene_is_turned_in_a_live_notebook(lab):
    lab.open("notebooks/01_machine.ipynb")
    lab.start()
    lab.finish()
    browser = lab.browser
    frame = "document.querySelector('.jp-NotebookPanel:not(.lm-mod-hidden) iframe.pyvista')"
    browser.until(f"!!{frame}")
    # The scene inside comes from another address: it can only be looked at.
    wait(lambda: browser.picture(frame).std() > 3, said="a picture of the scene")
    time.sleep(2)
    before = browser.picture(frame)
    browser.drag(frame, 150, 60)
    wait(lambda: (browser.picture(frame) != before).mean() > 0.01, said="another one")
    asked = {request.split("/")[2] for request in browser.requests if request.startswith("http")}
    assert asked == {lab.host}, "scenes come through the one port"
    lab.close()


def test_stored_pictures_have_texts():
    for notebook in notebooks():
        for cell in nbformat.read(notebook, as_version=4).cells:
            for output in cell.get("outputs", []):
                if "image/png" in output.get("data", {}):
                    assert output.metadata.get("image/png", {}).get("alt"), notebook.stem
