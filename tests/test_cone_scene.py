"""Cones, surfaces and blades in space: what is drawn is there, in its colour and place."""

import numpy as np
import pytest

from exhibits.blade_scene import tool_sequence_picture
from exhibits.six_cones_scene import contact_scene, double_cones_picture
from exhibits.surface_scene import (
    cones_along_curve_picture,
    ring_on_graph_picture,
    tangent_planes_picture,
)
from kit import scene
from tests.scenes import share, small_scenes  # noqa: F401 - a fixture of all tests
from tunneller_lib.envelopes import hyperosculating_cones
from tunneller_lib.envelopes.families import cyclide, helicoid, ruled
from tunneller_lib.envelopes.isotropic import surface_points
from tunneller_lib.milling.faces import BladeRing

ANGLE = np.radians(30)
PLACE = (0.5, 0.3)
CONES = hyperosculating_cones(cyclide, *PLACE, half_angle=ANGLE)
SHEET = surface_points(
    cyclide, *np.meshgrid(np.linspace(0.3, 1, 41), np.linspace(0.1, 0.8, 41), indexing="ij")
)
RING = BladeRing(0.06, 0.03, 0.05, -0.7, 1.2, -0.006, -0.006, 6)
ON_BLADE = hyperosculating_cones(RING.coordinates, 0.8, 0.3, half_angle=0.17, model="space")
SIZE = {"towards": 0.015, "away": 0.045}


def seen(plotter):
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    return picture


def test_tangent_planes_are_pink_pieces_as_many_as_places():
    few, many = (
        share(tangent_planes_picture(ruled(helicoid), 0.3, places, (0.3, -0.9, 0.5)), "plane")
        for places in ([0.2, 1.2], [0.2, 0.5, 0.8, 1.2])
    )
    assert 1.5 * few < many < 2.5 * few


@pytest.fixture
def curves(monkeypatch):
    """Return a list that gets the points of each curve that is drawn."""
    drawn = []
    curve = scene.curve
    monkeypatch.setattr(
        scene,
        "curve",
        lambda points, radius: drawn.append(np.array(points)) or curve(points, radius),
    )
    return drawn


def test_ring_on_a_graph_has_its_top_view_at_the_contacts_foot(curves):
    picture = ring_on_graph_picture(cyclide, PLACE, (0.12, 0.16))
    ring, top, down = curves
    np.testing.assert_array_equal(top[:, :2], ring[:, :2])
    np.testing.assert_allclose(top[:, 2], down[1][2])
    assert share(picture, "cone") > 1e-3 and share(picture, "top view") > 1e-3


def test_cones_along_a_curve_have_their_arcs_beside_it_in_the_model(curves):
    track = np.linspace(0.2, 0.9, 141)
    contacts = np.stack([0.25 + 0.4 * track, track], axis=-1)
    picture = cones_along_curve_picture(cyclide, contacts, ANGLE)
    arcs = curves[2:]  # after the curve, in space and in the model
    assert arcs and all(np.abs(arc[:, :2] - (0.45, 0.55)).max() < 0.5 for arc in arcs)
    assert share(picture, "cone") > 0.02 and share(picture, "generator") > 1e-3


def test_scene_of_a_contact_has_generators_within_the_circle_only():
    inside, outside = (seen(contact_scene(cyclide, place, ANGLE)) for place in (PLACE, (1.6, 1.2)))
    assert share(inside, "generator") > 0.05 and share(inside, "error") > 1e-3
    assert share(outside, "generator") == 0 and share(outside, "error") > 1e-3


def test_only_the_rulings_of_multiple_cones_are_drawn(curves):
    double = hyperosculating_cones(cyclide, 1.2, np.sqrt(3 - 1.44), half_angle=ANGLE)
    for cones in (double, CONES):
        double_cones_picture(SHEET, cones)
    assert len(curves) == np.count_nonzero(double.multiplicity > 1) == 1


def test_place_without_a_tool_is_red():
    places = np.stack(RING.coordinates(np.array([0.8, 0.8]), np.array([0.3, 0.6])), axis=-1)
    show = np.arange(len(ON_BLADE)) == 0
    found = [tool_sequence_picture(RING, ON_BLADE, show, p, **SIZE) for p in (places, places[:1])]
    assert share(found[0], "error") > share(found[1], "error") == 0
