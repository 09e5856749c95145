"""Curves, rulings and motions that envelopes are made of: each with the derivatives it claims."""

import numpy as np
import pytest

from tests.envelopes_zoo import CURVES, MOTIONS, RULED
from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.adapted import frames_along
from tunneller_lib.envelopes.families import (
    helicoid,
    helix,
    helix_lines,
    moving_cone,
    ruled,
    saddle,
    screwing,
    swept_ball,
    tangent_lines,
    turning,
)

V = np.array([-0.8, 0.1, 1.3])
STEP = 1e-5


def rate(function, v):
    """Return the central difference quotient of a function that gives a list of coordinates."""
    ahead, back = np.asarray(function(v + STEP)), np.asarray(function(v - STEP))
    return (ahead - back) / (2 * STEP)


@pytest.mark.parametrize("name", CURVES)
def test_curve_has_its_velocity_and_acceleration(name):
    curve = CURVES[name]
    _, velocity, acceleration = curve(V)
    np.testing.assert_allclose(rate(lambda v: curve(v)[0], V), velocity, atol=1e-8)
    np.testing.assert_allclose(rate(lambda v: curve(v)[1], V), acceleration, atol=1e-8)


@pytest.mark.parametrize("name", RULED)
def test_rulings_have_their_derivatives(name):
    lines = RULED[name]
    _, velocity, _, turn = lines(V)
    np.testing.assert_allclose(rate(lambda v: lines(v)[0], V), velocity, atol=1e-8)
    np.testing.assert_allclose(rate(lambda v: lines(v)[2], V), turn, atol=1e-8)


SCREW = screwing(1.5, -0.4, 0.6, start=2.0)
SLOW = turning(lambda v: [v, v * v, 0 * v], lambda v: [1 + 0 * v, 2 * v, 0 * v], 0.8, rate=-0.3)


@pytest.mark.parametrize(
    "motion", [*MOTIONS.values(), SLOW, SCREW], ids=[*MOTIONS, "slow", "screwing"]
)
def test_motion_turns_its_axes_as_it_says(motion):
    _, velocity, axes, omega = motion(V)
    np.testing.assert_allclose(rate(lambda v: motion(v)[0], V), velocity, atol=1e-8)
    gram = np.einsum("ikn,jkn->nij", axes, axes)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-15)
    for i, axis in enumerate(axes):
        turned = np.cross(omega, axis, axis=0)
        found = rate(lambda v, i=i: motion(v)[2][i], V)
        np.testing.assert_allclose(found, turned, atol=1e-8)


def test_turning_leans_from_z_and_starts_where_it_is_told():
    axes = np.array(SLOW(0.0)[2])
    assert axes[0] @ [0, 0, 1] == pytest.approx(np.cos(0.8))
    np.testing.assert_allclose(axes[0, :2], np.sin(0.8) * np.array([np.cos(1), np.sin(1)]))


def test_helicoid_moves_by_its_pitch():
    point, *_ = helicoid(np.array([0, 2 * np.pi]), pitch=0.4)
    np.testing.assert_allclose(point, [[0, 0.8 * np.pi], [0, 0], [0, 0]], atol=1e-15)


def test_helix_lines_run_from_tangents_to_a_helicoid():
    s, t = np.linspace(-2, 3, 7), np.linspace(0.1, 1.7, 7)
    np.testing.assert_array_equal(ruled(helix_lines)(s, t), ruled(tangent_lines(helix))(s, t))
    across = ruled(lambda s: helix_lines(s, np.pi / 2))
    x, y, z = across(s, 1 + 0 * s)  # every line meets the axis at t = 1, level with its start
    np.testing.assert_allclose([x, y, z - 0.4 * s], 0, atol=1e-15)


@pytest.mark.parametrize("twist", [0.0, 0.3, np.pi / 2])
def test_helix_lines_turn_as_their_directions_differ(twist):
    s, h = np.linspace(-2, 3, 7), 1e-5
    (*_, before, _), (*_, after, _) = (helix_lines(s + d, twist, pitch=0.7) for d in (-h, h))
    turn = helix_lines(s, twist, pitch=0.7)[3]
    np.testing.assert_allclose(np.subtract(after, before) / (2 * h), turn, atol=1e-9)


def test_a_motion_that_answers_one_number_is_refused():
    with pytest.raises(ValueError, match=r"^motion: must return .* angular velocity; got 3\.$"):
        moving_cone(lambda t: 3, 0.3)(0.0, 0.0)


def test_screwing_keeps_its_radius_and_rises_by_its_pitch():
    x, y, z = SCREW(V)[0]
    np.testing.assert_allclose(np.hypot(x, y), 1.5)
    np.testing.assert_allclose(z, -0.4 * V)
    assert np.array(SCREW(0.0)[2][0])[2] == pytest.approx(np.cos(0.6))


def test_swept_ball_lies_at_its_radius_across_the_path():
    s, t = np.meshgrid(V, np.linspace(0, 6, 9), indexing="ij")
    swept = swept_ball(lambda s: helix(s)[:2], 0.3)
    surface = np.array(swept(s, t))
    centre, velocity, _ = (np.array(part) for part in helix(s))
    np.testing.assert_allclose(np.linalg.norm(surface - centre, axis=0), 0.3, rtol=1e-14)
    np.testing.assert_allclose(np.sum((surface - centre) * velocity, axis=0), 0, atol=1e-15)
    found = recognise(swept, s, t, "pipe", model="space")
    assert found.verdict == "is" and abs(found.radius) == pytest.approx(0.3, abs=1e-9)


def test_frames_along_a_line_have_it_for_their_first_axis():
    t = np.linspace(-0.5, 1.0, 5)
    found = frames_along(ruled(saddle), 0.7, t)
    np.testing.assert_allclose(found.contact, np.stack([0.7 + 0 * t, t, 0.7 * t], axis=-1))
    way = np.array([0, 1, 0.7]) / np.hypot(1, 0.7)
    np.testing.assert_allclose(np.abs(found.axes[:, 0] @ way), 1)
