"""Scenes: meshes where they are meant, and what happens where nothing can be drawn or turned."""

import numpy as np
import pytest

from exhibits import machine_scene
from kit import camera, gl, scene
from tests.scenes import small_scenes  # noqa: F401 - a fixture of all tests
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg


def test_wall_about_the_machine_is_left_open_on_its_right():
    egg, machine = Egg(0.5), REFERENCE_MACHINE
    (wall, _), *posed = machine_scene.machine_in_tunnel(machine, egg, 0.1, 0.2)
    _, y, z = wall.points.T.astype(float)
    np.testing.assert_allclose(egg.depth(y, z), 0, atol=1e-6)
    section = egg.point(np.linspace(0, egg.perimeter, 999))
    assert y.min() == pytest.approx(-0.2 * machine.R, abs=0.02)
    assert y.max() == pytest.approx(section[:, 0].max(), rel=1e-3)
    tip = machine.torus.point(0.1, 0.2) + np.array([0, 0, machine.height])
    nearest = min(np.linalg.norm(mesh.points - tip, axis=-1).min() for mesh, _ in posed)
    assert nearest < machine.cutter_radius


@pytest.mark.parametrize("parallel", [True, False])
def test_letters_are_written_where_the_scene_has_their_point(parallel):
    def shot(letters, width=2.0):
        plotter = scene.empty(parallel=parallel)
        plotter.window_size = 1200, 900
        for end in ((-1, -1, -1), (1, 1, 1)):
            plotter.add_mesh(scene.ball(end, 0.05), color="white", lighting=False)
        plotter.add_mesh(scene.ball(place, 0.1), color="red", lighting=False)
        return scene.shoot(plotter, direction=(0.3, -1, 0.4), letters=letters, width=width)

    place = np.array([0.4, 0.2, -0.5])
    plain, lettered = shot(None), shot({"M": (place, (0, 0))})
    assert plain.shape == lettered.shape
    changed = np.argwhere(np.any(plain != lettered, axis=-1))
    red = np.argwhere(plain[..., 0] > plain[..., 1].astype(int) + 100)
    assert len(changed) and np.abs(changed.mean(axis=0) - red.mean(axis=0)).max() < 2.2
    # A line leads to a letter that is far away, and to no other: seen with a letter that is blank.
    blank = [shot({" ": (place, (away, 0))}, width=1.0) for away in (-2, -3)]
    led = [picture.max(axis=-1).min() < 80 for picture in blank]
    assert led == [False, True]  # black is only in the line
    aside = shot({"M": (place, (4, 0))})
    assert aside.shape[1] > plain.shape[1]  # what stands beside the scene isn't cut off


def test_scene_without_a_library_says_how_to_get_one(monkeypatch):
    monkeypatch.setattr(gl, "problem", lambda: "No scene can be drawn here.")
    with pytest.raises(OSError, match=r"^No scene can be drawn here\.$"):
        scene.empty()


@pytest.mark.parametrize(
    ("kernel", "backend", "turned"),
    [(None, None, False), ("a notebook", "static", False), ("a notebook", None, True)],
)
def test_scenes_are_turned_only_where_somebody_can(monkeypatch, kernel, backend, turned):
    monkeypatch.setattr("IPython.get_ipython", lambda: kernel)
    monkeypatch.setattr("IPython.display.display", lambda widget: shown.append(widget))
    monkeypatch.setattr(camera, "live", lambda plotter, title: title)
    monkeypatch.delenv("TUNNELLER_SCENES", raising=False)
    if backend:
        monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", backend)
    else:
        monkeypatch.delenv("PYVISTA_JUPYTER_BACKEND", raising=False)
    shown = []
    plotter = scene.empty()
    plotter.add_mesh(scene.ball((0, 0, 0), 1.0))
    picture = camera.shoot(plotter)
    assert bool(shown) is turned
    assert picture.ndim == 3 and (picture != 255).any()
