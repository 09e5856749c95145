"""Polynomials through the points of measured planes."""

import numpy as np
import pytest

from tests.shapes import directions
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.fit import fit_planes, mean_frame, noisy_planes, tilted
from tunneller_lib.envelopes.isotropic import normal, plane_to_point, surface_points
from tunneller_lib.envelopes.jet import jet_variables

RNG = np.random.default_rng(32)


def graph(x, y):
    return 0.3 + x - 2 * y + x * y + 0.5 * x**3 - y**4


def patch(f, n=200):
    x, y = RNG.uniform(-0.3, 0.3, (2, n))
    return surface_points(f, x, y), np.stack(normal(x, y), axis=-1)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_fit_planes_returns_a_polynomial(scale):
    contact, n = patch(graph)
    for array in (contact, n):
        array.flags.writeable = False
    f, planes = fit_planes(scale * contact, n, scale=0.3, degree=4)
    x, y = RNG.uniform(-0.3, 0.3, (2, 20))
    np.testing.assert_allclose(f(x, y) / scale, graph(x, y), atol=1e-12)
    np.testing.assert_allclose(planes[:, 2] / scale, graph(*planes[:, :2].T), atol=1e-12)
    found, expected = (g(*jet_variables(0.1, 0.2)) for g in (f, graph))
    np.testing.assert_allclose(found.c / scale, expected.c, atol=1e-9)


def test_fit_planes_hardly_minds_a_few_wrong_planes():
    contact, n = patch(graph)
    contact[::20] += 5.0
    f, _ = fit_planes(contact, n, scale=0.3, degree=4)
    assert abs(f(0.1, 0.1) - graph(0.1, 0.1)) < 1e-3


def test_fit_planes_wants_enough_planes():
    contact, n = patch(graph, 27)
    with pytest.raises(ValueError, match=r"^n: must hold at least 28 planes; got 27\.$"):
        fit_planes(contact, n, scale=0.3)


@pytest.mark.parametrize("degree", [0, 2.5, -1])
def test_fit_planes_wants_a_degree(degree):
    with pytest.raises(ValueError, match=r"^degree: must be one whole number from 1 to 20; got .*"):
        fit_planes(*patch(graph, 30), scale=0.3, degree=degree)


def test_tilted_turns_by_the_angle_in_all_directions():
    n = directions(RNG, 4000)
    turned = tilted(n, 0.1, RNG)
    angle = np.arccos(np.sum(n * turned, axis=-1))
    np.testing.assert_allclose(np.tan(angle), 0.1, rtol=1e-6)
    up = tilted(np.tile([0, 0, 1.0], (4000, 1)), 0.1, RNG)
    counts, _ = np.histogram(np.arctan2(up[:, 1], up[:, 0]), bins=8, range=(-np.pi, np.pi))
    assert np.abs(counts - 500).max() < 100  # 4.8 standard deviations
    assert abs(np.linalg.norm(turned, axis=-1) - 1).max() < 1e-15


def test_mean_frame_is_a_rotation_that_takes_the_mean_to_the_top():
    _, n = patch(cyclide)
    turn = mean_frame(n)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(turn) > 0
    top = (n @ turn.T).mean(axis=0)
    assert np.hypot(top[0], top[1]) < 1e-15 < top[2]


def test_noisy_planes_touch_within_the_disk_and_turn_by_the_angle():
    place = np.array([0.5, 0.3])
    options = {"count": 500, "reach": 0.2}
    contact, n = noisy_planes(cyclide, place, np.random.default_rng(1), turn=0.0, **options)
    x, y, z = plane_to_point(n, -np.sum(n * contact, axis=-1)).T
    away = np.hypot(x - place[0], y - place[1])
    assert 0.19 < away.max() <= 0.2 and np.median(away) == pytest.approx(0.2 / np.sqrt(2), rel=0.1)
    np.testing.assert_allclose(z, cyclide(x, y), atol=1e-14)
    again, turned = noisy_planes(cyclide, place, np.random.default_rng(1), turn=0.1, **options)
    np.testing.assert_array_equal(again, contact)
    np.testing.assert_allclose(np.sum(n * turned, axis=-1), np.cos(np.arctan(0.1)))
