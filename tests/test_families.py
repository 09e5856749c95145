"""Curves, rulings and motions that envelopes are made of, and what callers give for them."""

from functools import partial

import numpy as np
import pytest

from tests.envelopes_zoo import CURVES, MOTIONS, RULED
from tunneller_lib.envelopes import (
    adapted_frames,
    hyperosculating_cones,
    jet_variables,
    model_jet,
    recognise,
)
from tunneller_lib.envelopes.developable import curve_derivatives, osculating_cone, tangent_planes
from tunneller_lib.envelopes.families import (
    helix,
    helix_lines,
    moving_cone,
    ruled,
    screwing,
    swept_ball,
    tangent_lines,
    turning,
)
from tunneller_lib.envelopes.isotropic import surface_points
from tunneller_lib.envelopes.jet import Jet

V = np.array([-0.8, 0.1, 1.3])
STEP = 1e-5
SCREW = screwing(1.5, -0.4, 0.6, start=2.0)
SLOW = turning(lambda v: [v, v * v, 0 * v], lambda v: [1 + 0 * v, 2 * v, 0 * v], 0.8, rate=-0.3)
TWISTED = partial(helix_lines, twist=0.3, pitch=0.7)


def rate(function, v):
    """Return the central difference quotient of a function that gives a list of coordinates."""
    ahead, back = np.asarray(function(v + STEP)), np.asarray(function(v - STEP))
    return (ahead - back) / (2 * STEP)


# Which part of what a function returns is the derivative of which.
RATES = [(curve, k, k + 1) for curve in CURVES.values() for k in (0, 1)]
RATES += [(lines, k, k + 1) for lines in [*RULED.values(), TWISTED] for k in (0, 2)]
RATES += [(motion, 0, 1) for motion in (*MOTIONS.values(), SLOW, SCREW)]


def test_curves_rulings_and_vertices_have_their_derivatives():
    for function, part, derivative in RATES:
        found = rate(lambda v, function=function, part=part: function(v)[part], V)
        np.testing.assert_allclose(found, function(V)[derivative], atol=1e-8)


@pytest.mark.parametrize("motion", [*MOTIONS.values(), SLOW, SCREW])
def test_motion_turns_its_axes_as_it_says(motion):
    _, _, axes, omega = motion(V)
    gram = np.einsum("ikn,jkn->nij", axes, axes)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-15)
    for i, axis in enumerate(axes):
        found = rate(lambda v, i=i: motion(v)[2][i], V)
        np.testing.assert_allclose(found, np.cross(omega, axis, axis=0), atol=1e-8)


def test_motions_lean_start_rise_and_turn_as_they_are_told():
    axis = np.array(SLOW(0.0)[2][0])
    expected = [np.sin(0.8) * np.cos(1), np.sin(0.8) * np.sin(1), np.cos(0.8)]
    np.testing.assert_allclose(axis, expected)
    x, y, z = SCREW(V)[0]
    np.testing.assert_allclose(np.hypot(x, y), 1.5)
    np.testing.assert_allclose(z, -0.4 * V)
    axis = np.array(SCREW(0.0)[2][0])
    assert (axis[2], np.arctan2(axis[1], axis[0])) == pytest.approx((np.cos(0.6), 2.0))


def test_a_cone_that_opens_touches_its_envelope():
    u, v = np.meshgrid(np.linspace(3.7, 4.4, 5), np.linspace(-0.3, 0.3, 4))
    found = adapted_frames(moving_cone(MOTIONS["screw"], 0.35, rate=0.25), u, v, "space")
    vertex, _, axes, _ = MOTIONS["screw"](v.ravel())
    vertex, axis, *across = (np.stack(np.broadcast_arrays(*c), axis=-1) for c in (vertex, *axes))
    angle = (0.35 + 0.25 * v).reshape(-1, 1)
    turn = u.reshape(-1, 1)
    out = np.cos(turn) * across[0] + np.sin(turn) * across[1]
    n = np.sin(angle) * axis + np.cos(angle) * out
    np.testing.assert_allclose(np.abs(np.sum(found.axes[:, 2] * n, axis=-1)), 1, rtol=1e-12)
    np.testing.assert_allclose(np.sum((found.contact - vertex) * n, axis=-1), 0, atol=1e-12)


def test_helix_lines_run_from_tangents_to_a_helicoid():
    s, t = np.linspace(-2, 3, 7), np.linspace(0.1, 1.7, 7)
    np.testing.assert_array_equal(ruled(helix_lines)(s, t), ruled(tangent_lines(helix))(s, t))
    x, y, z = ruled(partial(helix_lines, twist=np.pi / 2))(s, 1 + 0 * s)
    np.testing.assert_allclose([x, y, z - 0.4 * s], 0, atol=1e-15)  # they meet the axis, level


def test_swept_ball_lies_at_its_radius_across_the_path():
    s, t = np.meshgrid(V, np.linspace(0, 6, 9), indexing="ij")
    swept = swept_ball(lambda s: helix(s)[:2], 0.3)
    surface = np.array(swept(s, t))
    centre, velocity, _ = (np.array(part) for part in helix(s))
    np.testing.assert_allclose(np.linalg.norm(surface - centre, axis=0), 0.3, rtol=1e-14)
    np.testing.assert_allclose(np.sum((surface - centre) * velocity, axis=0), 0, atol=1e-15)
    np.testing.assert_allclose(np.add(swept(s, t + np.pi), surface), 2 * centre, atol=1e-14)


# ---- functions that callers give ------------------------------------------------------------

S, T = np.random.default_rng(0).uniform(0.2, 0.8, (2, 14))
NONSENSE = {
    "nothing": None,
    "a masked array": [np.ma.masked_array([1.0], [1]), 1.0, 1.0],
    "jets of other points": [*jet_variables(np.ones(3), 1.0), 1.0],
    "a complex jet": [Jet(np.ones((15, 14), dtype=complex)), 1.0, 1.0],
    "the class itself": Jet,
}
DOORS = {
    "surface, space": lambda f: hyperosculating_cones(f, S, T, half_angle=0.5, model="space"),
    "surface": lambda f: hyperosculating_cones(f, S, T, half_angle=0.5),
    "f": lambda f: surface_points(f, S, T),
    "curve": lambda f: curve_derivatives(f, S),
    "motion": lambda f: moving_cone(f, 0.3)(*jet_variables(S, T)),
    "lines": lambda f: ruled(f)(S, T),
    "vertex": lambda f: turning(f, f, 0.3)(S),
}


@pytest.mark.parametrize("door", DOORS)
def test_nonsense_that_a_function_answers_is_refused_in_a_sentence(door):
    name = door.partition(",")[0]
    for answer in NONSENSE.values():
        with pytest.raises(ValueError, match=rf"^{name}: must return [^\n]*; got [^\n]*\.$"):
            DOORS[door](lambda *given, answer=answer: answer)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_constant_that_is_no_surface_is_told_from_a_wrong_call(value):
    cones = hyperosculating_cones(lambda s, t: value + 0 * s, S, T, half_angle=0.5)
    assert set(cones.state) <= {"outside", "singular"} and not len(cones)
    with pytest.raises(ValueError, match=r"^surface: must be smooth"):
        model_jet(lambda s, t: [value, s, t], S, T)
    for asked in (curve_derivatives, tangent_planes, osculating_cone):
        with pytest.raises(ValueError, match=r"^curve: must be defined and smooth"):
            asked(lambda s: [value, s, s], S)


def test_ufuncs_and_partial_functions_are_functions():
    assert (hyperosculating_cones(np.hypot, S, T, half_angle=0.5).state != "outside").all()
    assert recognise(ruled(TWISTED), S, T, "ruled", model="space").verdict == "is"
