"""The torus: points, angles, implicit form, normals, curvatures, feet."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from tests.draws import EPS, fractions
from tests.references import tables, torus_feet
from tests.shapes import TORI, eq2, off_surface, tori
from tunneller_lib.surfaces import Torus

READS = ["tests/references/*"]

RING, SPINDLE, HORN = Torus(2, 1.5), Torus(3, 5), Torus(1, 1)
every_torus = pytest.mark.parametrize("torus", TORI, ids=str)


def sheet(torus, n):
    """Return n by n angles over the whole ring torus, or the working sheet of a spindle."""
    edge = np.pi if torus.r > torus.R else np.arccos(-torus.r / torus.R)
    return np.meshgrid(np.linspace(-np.pi, np.pi, n), np.linspace(-edge, edge, n) * (1 - 1e-9))


@every_torus
def test_angles_undo_point(torus):
    theta, phi = sheet(torus, 73)
    point = torus.point(theta, phi)
    again, swing = torus.angles(point)
    turned = np.angle(np.exp(1j * (again - theta)))
    rho = np.hypot(point[..., 0], point[..., 2])
    assert np.max(np.abs(turned) * rho) <= 4 * EPS * (torus.r + torus.R)
    assert np.max(np.abs(swing - phi)) * torus.R <= 8 * EPS * (torus.r + torus.R)


def test_point_of_negative_theta_lifts():
    assert RING.point(-0.1, 0)[2] > 0 and RING.point(0, 0.1)[1] > 0


@given(tori, st.tuples(*[st.floats(-10, 10).map(lambda c: round(c, 60))] * 3))
def test_angles_are_those_of_the_foot(torus, where):
    m = (torus.r + torus.R) * np.array(where)
    apart = torus.point(*torus.angles(m)) - torus.foot(m)
    assert np.linalg.norm(apart) <= 8 * EPS * (torus.r + torus.R)


@every_torus
@pytest.mark.parametrize("offset", [-0.1, 1e-3, -1e-6, 1e-9, 1e3])
def test_implicit_against_eq2_in_fractions(torus, offset):
    angles = np.random.default_rng(2).uniform(-3, 3, (2, 50))
    points = torus.point(*angles) + offset * torus.R * torus.normal(*angles)
    for point, found in zip(points, torus.implicit(points), strict=True):
        exact = eq2(*fractions(torus.r, torus.R, *point))
        loss = 1 + (torus.r + torus.R) / off_surface(torus, point)
        assert abs(found - float(exact)) <= 16 * EPS * loss * abs(float(exact))


@every_torus
def test_normal_points_outward(torus):
    theta, phi = (a[1:-1, 1:-1] for a in sheet(torus, 24))
    outside = torus.point(theta, phi) + 1e-9 * torus.R * torus.normal(theta, phi)
    assert np.all(torus.implicit(outside) > 0)


def test_curvatures_at_node_are_infinite_and_on_top_zero():
    assert Torus(1, 2).curvatures(0, np.pi / 2)[1] == pytest.approx(0, abs=EPS)
    assert HORN.curvatures(0, np.pi) == (1, -np.inf)


@given(tori, st.tuples(*[st.floats(-1e6, 1e6)] * 3))
def test_foot_is_the_first_of_the_feet(torus, m):
    np.testing.assert_array_equal(torus.foot(m), torus.feet(m)[..., 0, :])


@pytest.mark.parametrize(
    "m, feet",
    [
        # on the axis, at a node: theta = 0; 3-4-5 triangles
        ((0, 4, 0), [(0, 4, 0), (6, -4, 0), (0, 4, 0), (-6, -4, 0)]),
        # on the ring circle: phi = 0 and pi
        ((0, 0, 3), [(0, 0, 8), (0, 0, -2), (0, 0, 2), (0, 0, -8)]),
        ((3, 0, 0), [(8, 0, 0), (-2, 0, 0), (2, 0, 0), (-8, 0, 0)]),
        # the centre
        ((0, 0, 0), [(-2, 0, 0), (8, 0, 0), (2, 0, 0), (-8, 0, 0)]),
    ],
)
def test_feet_of_degenerate_points(m, feet):
    np.testing.assert_allclose(SPINDLE.feet(m), feet, atol=1e-15)


@pytest.mark.parametrize("torus", [RING, SPINDLE], ids=["ring", "spindle"])
def test_foot_is_on_the_sheet_that_its_docstring_says(torus):
    m = np.random.default_rng(8).uniform(-2, 2, (400, 3)) * (torus.r + torus.R)
    m[:100, ::2] *= 0.05  # near the axis
    m[:2] = (0, 0.3 * torus.R, 0), (0, 9 * torus.R, 0)
    m[2] = torus.r, 0, 0
    foot = torus.foot(m)
    rho = np.hypot(*m[:, ::2].T)
    apart = np.hypot(rho - torus.r, m[:, 1])
    working = torus.r + torus.R * (rho - torus.r) / np.where(apart, apart, np.inf) >= 0
    assert np.any(~working) == (torus.R > torus.r)
    out = np.where(working, 1, -1) * np.hypot(*foot[:, ::2].T)  # beyond the axis on the inner sheet
    np.testing.assert_allclose(np.hypot(out - torus.r, foot[:, 1]), torus.R, rtol=1e-12)
    off = rho > 0
    assert np.all((np.sum(m * foot, axis=-1) - m[:, 1] * foot[:, 1] > 0)[off] == working[off])
    np.testing.assert_allclose(foot[2], torus.point(0, 0), rtol=1e-12, atol=1e-15)
    assert np.all(foot[:2, 2] == 0)


@pytest.mark.parametrize("point, angles", [
    ((0, 1, 0), (0, np.arctan2(1, -3))),
    ((0, 0, 0), (0, np.pi)),
    ((-3, 0, 0), (np.pi, 0)),
    ((-3, 0, -0.0), (np.pi, 0)),
    ((0, 0, -3), (np.pi / 2, 0)),
    ((0, 0, 3), (-np.pi / 2, 0)),
])  # fmt: skip
def test_angles_of_degenerate_points(point, angles):
    assert SPINDLE.angles(point) == angles


# ---- the four feet against mpmath --------------------------------------------------------------

HEADER, ROWS = tables.read(torus_feet.TABLE)
FAMILIES = sorted({row[0] for row in ROWS})


def relative_error(found, expected):
    return np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)


@pytest.mark.parametrize("family", FAMILIES)
def test_feet_against_references(family):
    numbers = np.array([row[1:] for row in ROWS if row[0] == family], dtype=float)
    assert len(numbers) == 40
    found = np.array([Torus(r, R).feet(m) for r, R, *m in numbers[:, :5]])
    assert relative_error(found, numbers[:, 5:].reshape(-1, 4, 3)).max() <= 1e-13


def test_references_are_what_their_script_writes():
    assert HEADER == torus_feet.COLUMNS
    with mp.workdps(50):
        for _, r, R, *numbers in ROWS:
            m, printed = map(float, numbers[:3]), numbers[3:]
            again = torus_feet.feet(float(r), float(R), list(m))
            assert [mp.nstr(c, 20) for n in again for c in n] == printed


# ---- differential geometry ------------------------------------------------------------------


@pytest.fixture(params=[(0.08, 0.8), (3.0, 1.0)], ids=["spindle", "ring"])
def moving(request):
    """A torus, joint positions on its working sheet and rates."""
    torus, rng = Torus(*request.param), np.random.default_rng(7)
    return torus, rng.uniform(-0.9, 0.9, (200, 2)), rng.normal(size=(200, 2))


def test_tangents_and_normal_are_a_frame(moving):
    torus, q, _ = moving
    frame = np.stack([torus.normal(*q.T), *torus.tangents(*q.T)], axis=-2)
    np.testing.assert_allclose(
        frame @ np.swapaxes(frame, 1, 2), np.broadcast_to(np.eye(3), (200, 3, 3)), atol=1e-15
    )
    # They point where phi and theta grow.
    for k, tangent in ((1, frame[:, 1]), (0, frame[:, 2])):
        unit = np.broadcast_to(np.eye(2)[k], q.shape)
        assert np.all(np.sum(torus.velocity(q, unit) * tangent, axis=-1) > 0)


def test_velocity_and_acceleration_are_rates_of_the_point(moving):
    torus, q, rate = moving
    h = 1e-4
    ahead, here, behind = (torus.point(*(q + step * rate).T) for step in (h, 0, -h))
    np.testing.assert_allclose(torus.velocity(q, rate), (ahead - behind) / (2 * h), atol=1e-5)
    bend = (ahead - 2 * here + behind) / h**2
    np.testing.assert_allclose(torus.acceleration(q, rate), bend, atol=1e-4)


def test_normal_curvature_is_that_of_the_acceleration(moving):
    # Meusnier: whatever the curve, -n.a = curvature v^2.
    torus, q, rate = moving
    velocity = torus.velocity(q, rate)
    speed = np.linalg.norm(velocity, axis=-1)
    pull = -np.sum(torus.acceleration(q, rate) * torus.normal(*q.T), axis=-1)
    found = torus.normal_curvature(q, velocity / speed[:, None])
    np.testing.assert_allclose(found, pull / speed**2, rtol=1e-11)


def test_geodesic_torsion_is_how_the_normal_turns_about_the_way(moving):
    torus, q, rate = moving
    velocity, h = torus.velocity(q, rate), 1e-6
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    ahead, behind = torus.normal(*(q + h * rate).T), torus.normal(*(q - h * rate).T)
    turning = (ahead - behind) / (2 * h * speed)
    across = np.cross(torus.normal(*q.T), velocity / speed)
    torsion = torus.geodesic_torsion(q, velocity / speed)
    np.testing.assert_allclose(np.sum(turning * across, axis=-1), -torsion, atol=1e-8)
