"""The torus and ways on it in space: what is drawn is there, in its colour."""

import numpy as np
import pytest

from exhibits.path_scene import projected_chord, three_ways_in_space
from exhibits.torus_scene import entire_torus_picture
from kit import scene
from tests.scenes import share, small_scenes  # noqa: F401 - a fixture of all tests
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

TORUS = REFERENCE_MACHINE.torus
LOW, HIGH = np.radians([(-60, -40), (35, 40)])
P, Q = np.radians([(-45, -35), (30, 35)])


def test_projected_way_is_drawn_farther_aside_if_exaggerated():
    near, far = (three_ways_in_space(TORUS, LOW, HIGH, exaggeration=k) for k in (1, 12))
    # Not exaggerated the two lie in one place, where one hides the other.
    assert share(near, "tangent sphere") < 0.8 * share(far, "tangent sphere")


@pytest.mark.parametrize("geodesic", [False, True])
def test_scene_of_a_chord_has_a_dot_and_a_normal_for_each_point(geodesic):
    plotter = projected_chord(TORUS, P, Q, low=LOW, high=HIGH, steps=7, geodesic=geodesic)
    assert len(plotter.actors) >= 3 + 2 * 8 + geodesic
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    assert (share(picture, "geodesic") > 1e-4) == geodesic


def test_entire_torus_shows_its_inner_sheet_on_the_right_only_and_names_its_axis(monkeypatch):
    """The sheet lies within the tube, the axis' letter beyond the node's."""
    torus, letters, sheets, shoot, surface = Torus(0.1, 0.8), {}, [], scene.shoot, scene.surface
    shot = lambda plotter, **view: letters.update(view["letters"]) or shoot(plotter, **view)  # noqa: E731
    monkeypatch.setattr(scene, "shoot", shot)
    monkeypatch.setattr(scene, "surface", lambda points: sheets.append(points) or surface(points))
    picture = entire_torus_picture(torus)
    middle = picture.shape[1] // 2
    halves = [share(half, "inner sheet") for half in (picture[:, :middle], picture[:, middle:])]
    assert halves[0] < 1e-3 < 0.01 < halves[1]
    node, axis = letters["node"][0], letters["axis"][0]
    assert axis @ node > node @ node
    _whole, _outer, inner = sheets
    assert np.hypot(inner[..., 0], inner[..., 2]).max() <= (torus.R - torus.r) * (1 + 1e-12)
