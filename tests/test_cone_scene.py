"""Cones, surfaces and blades in space: what is drawn is there, in its colour and place."""

import numpy as np

from exhibits.blade_scene import tools_scene
from exhibits.cone_scene import moving_cone_picture
from exhibits.six_cones_scene import contact_scene
from tests.scenes import share, small_scenes  # noqa: F401 - a fixture of all tests
from tunneller_lib.envelopes import ConePose, hyperosculating_cones
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.milling.faces import BladeRing

ANGLE = np.radians(30)
PLACE = (0.5, 0.3)
UPRIGHT = ConePose((0, 0, 0), (0, 0, 1), np.radians(20), near=1.0, far=3.2)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)
ON_BLADE = hyperosculating_cones(RING.coordinates, 0.8, 0.3, half_angle=0.17, model="space")
SIZE = {"towards": 0.015, "away": 0.045}
VERDICTS = [["fits", "hits a blade", "gouges"][k % 3] for k in range(len(ON_BLADE))]


def dark(picture):
    """Return which share of a picture is nearly black."""
    return np.mean(np.all(picture < 90, axis=-1))


def seen(plotter):
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    return picture


def test_moving_cone_shows_its_velocities_and_a_longer_curve_if_it_turns():
    turning = moving_cone_picture(UPRIGHT, (0.02, 1.0, 0.01), (-2.0, 0.3, 0.5))
    sliding = moving_cone_picture(UPRIGHT, (0, 0, 0), (0.9, -0.3, 0.3))
    for picture in (turning, sliding):
        assert share(picture, "cone") > 0.1 and share(picture, "error") > 1e-3
    assert dark(turning) > dark(sliding) > 0.01


def test_scene_of_a_contact_has_generators_within_the_circle_only():
    inside, outside = (seen(contact_scene(cyclide, place, ANGLE)) for place in (PLACE, (1.6, 1.2)))
    assert share(inside, "generator") > 0.05 and share(inside, "error") > 1e-3
    assert share(outside, "generator") == 0 and share(outside, "error") > 1e-3


def test_tools_have_the_colours_of_their_verdicts():
    show = np.ones(len(ON_BLADE), dtype=bool)
    picture = seen(tools_scene(RING, ON_BLADE, show, VERDICTS, **SIZE))
    for colour in ("cone", "generator", "error"):
        assert share(picture, colour) > 0.003
