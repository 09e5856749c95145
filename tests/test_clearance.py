"""Clearance in closed form against samples of the arm, the section and a grid of intervals."""

import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.audit.long import many
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, Pose, part_clearances, plan
from tunneller_lib.removal.arm_clearance import circuit_clearance, rod_clearance, solid_clearance
from tunneller_lib.surfaces import (
    REFERENCE_MACHINE,
    Body,
    Box,
    Egg,
    Frustum,
    Line,
    Rod,
    closed_profile,
)

EGG = Egg(0.5)
BODY = Body(1.2, 0.3, -0.25, 0.15, holder_radius=0.12, holder_length=0.25)
WITH_BODY = replace(REFERENCE_MACHINE, body=BODY)
COUNT = 20_000  # of a circle's points
SAGITTA = 0.3 * (2 * np.pi / COUNT) ** 2  # more than points of a rim leave out, in m


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 1e3), st.floats(0, 0.7))
def test_rod_clearance_is_the_least_over_the_axis(seed, a, offset):
    section = Egg(a).offset(offset * a)
    ends = np.random.default_rng(seed).uniform(-2, 2, (2, 40, 3)) * a
    found = rod_clearance(section, *ends, 0.1 * a)
    share = np.linspace(0, 1, 101)[:, None, None]
    along = ends[0] + share * (ends[1] - ends[0])
    depth = section.depth(along[..., 1], along[..., 2]).min(axis=0) - 0.1 * a
    np.testing.assert_allclose(found, depth, atol=1e-12 * a)


@pytest.mark.parametrize("arm_radius", [0.0, 0.1, 0.25])
def test_circuit_clearance_is_the_least_over_the_circuit(arm_radius):
    circuit = cutting_circuit(REFERENCE_MACHINE, EGG)
    low, high = circuit.reach()
    found = circuit_clearance(REFERENCE_MACHINE, EGG, low[0], high[0], arm_radius)
    s = np.linspace(0, EGG.offset(REFERENCE_MACHINE.offset).perimeter, 5001)
    ends = circuit.arm(circuit.position(s))
    sampled = rod_clearance(EGG, *ends, arm_radius)
    np.testing.assert_allclose(found, sampled.min(), atol=1e-9)


def rim(centre, axis, radius):
    """Return points (n, 3) of a circle."""
    across = np.linalg.qr(np.stack([axis, *np.eye(3)], axis=-1))[0][:, 1:3]
    turn = np.linspace(0, 2 * np.pi, COUNT)
    return centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1) @ across.T


@pytest.mark.parametrize("seed", range(8))
def test_solid_clearance_is_the_least_depth_of_the_solid(seed):
    # Inside, across the wall and outside; the least depth of a convex solid is at a corner or rim.
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-0.4, 0.4, (2, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    first, last, corner = rng.uniform(0.02, 0.3, 3)
    capsule = Rod(a, b, first, ends="round")
    assert solid_clearance(EGG, capsule) == pytest.approx(
        float(rod_clearance(EGG, a, b, first)), abs=1e-14
    )
    rims = rim(a, b - a, first), rim(b, b - a, last)
    depths = [EGG.depth(points[:, 1], points[:, 2]).min() for points in rims]
    frustum = solid_clearance(EGG, Frustum(a, b, first, last))
    assert min(depths) - SAGITTA <= frustum <= min(depths) + 1e-14
    rod = solid_clearance(EGG, Rod(a, b, first))
    ends = [EGG.depth(*rim(end, b - a, first)[:, 1:].T).min() for end in (a, b)]
    assert rod == pytest.approx(min(ends), abs=SAGITTA)
    box = Box(a, *(turn * [[first], [last], [corner]]))
    points = box.corner + np.array(list(product((0, 1), repeat=3))) @ [box.x, box.y, box.z]
    lowest = EGG.depth(points[:, 1], points[:, 2]).min()
    # The last bit of hypot depends on an array's length.
    assert solid_clearance(EGG, box) == pytest.approx(lowest, abs=1e-14)


@pytest.mark.parametrize("sides", [8, 16])
def test_clearance_of_a_ball_from_many_flat_walls_is_that_from_the_nearest(sides):
    # Each wall makes a valley of the depth of its own, a few degrees from the next.
    turn = 2 * np.pi * np.arange(sides) / sides
    half = np.tan(np.pi / sides)
    walls = [
        Line(np.cos(k) + half * np.sin(k), np.sin(k) - half * np.cos(k), k + np.pi / 2, 2 * half)
        for k in turn
    ]
    section = closed_profile(walls)
    rng = np.random.default_rng(14)
    for _ in range(20):
        centre, radius = rng.uniform(-0.5, 0.5, 3), rng.uniform(0.3, 0.9)
        nearest = np.min(1 - centre[1] * np.cos(turn) - centre[2] * np.sin(turn)) - radius
        ball = Rod(centre, centre, radius, ends="round")
        assert solid_clearance(section, ball) == pytest.approx(nearest, abs=1e-14)


def in_tunnel(circuit, points, pose=None):
    """Return points of the machine's frame in the tunnel, moved by a pose about the joint."""
    placed = circuit.in_tunnel(points)
    return placed if pose is None else pose.moved(placed, circuit.in_tunnel(np.zeros(3)))


TURNED = Pose(y=2e-3, z=-1e-3, roll=0.1, pitch=0.2, yaw=-0.1)
STANCES = {}, {"pitch": 0.02, "yaw": 0.01}


@pytest.mark.parametrize(("stance", "pose"), [*product(STANCES, (None, TURNED))][:: many(3, 1)])
def test_clearance_of_the_machines_parts_is_the_least_of_their_points(stance, pose):
    circuit = cutting_circuit(WITH_BODY, EGG, **stance)
    parts = {part.name: part for part in part_clearances(circuit, 0.1, pose=pose)}
    assert list(parts) == ["arm", "holder", "box", "cutter"]
    # Corners of the box, seen by the joint.
    corners = [(x, y, z) for x in (-1.2, 0) for y in (-0.15, 0.15) for z in (-0.25, 0.15)]
    y, z = in_tunnel(circuit, np.array(corners), pose)[:, 1:].T
    assert parts["box"].least == pytest.approx(EGG.depth(y, z).min(), abs=1e-12)
    assert parts["box"].place is None
    # The holder's rims about the line from the cutter's centre to the tangential joint.
    s = np.linspace(0, circuit.profile.perimeter, 721)
    theta, phi = circuit.position(s).T
    torus = circuit.machine.torus
    ends = torus.ring_point(theta), torus.point(theta, phi)
    joint, centre = (in_tunnel(circuit, point, pose) for point in ends)
    k = int(np.argmin(np.abs(s - parts["holder"].place)))
    back = (joint[k] - centre[k]) / torus.R
    rims = np.concatenate([rim(centre[k] + end * back, back, 0.12) for end in (0.0, 0.25)])
    assert parts["holder"].least == pytest.approx(EGG.depth(*rims[:, 1:].T).min(), abs=SAGITTA)
    depth = {name: EGG.depth(p[:, 1], p[:, 2]).min() for name, p in (("a", joint), ("b", centre))}
    assert parts["cutter"].least == pytest.approx(depth["b"] - 0.2, abs=1e-12)
    assert parts["arm"].least == pytest.approx(min(depth.values()) - 0.1, abs=1e-12)


def test_machine_without_a_body_has_an_arm_and_a_cutter():
    circuit = cutting_circuit(REFERENCE_MACHINE, EGG)
    arm, cutter = part_clearances(circuit, 0.1)
    closed = circuit_clearance(REFERENCE_MACHINE, EGG, *(r[0] for r in circuit.reach()), 0.1)
    assert arm.least == pytest.approx(closed, abs=1e-12)
    assert cutter.least == pytest.approx(-REFERENCE_MACHINE.depth, abs=1e-12)
    assert not cutter.collides and arm.place == cutter.place == 0


def test_plan_keeps_the_body_clear():
    limits = Limits(feed=0.1, acceleration=0.5)

    def planned(**changes):
        circuit = cutting_circuit(replace(WITH_BODY, body=replace(BODY, **changes)), EGG)
        return plan(circuit, limits, tolerance=4e-3, arm_radius=0.1)

    arm, holder, box, cutter = planned().clearances
    assert min(arm.least, holder.least, box.least) > 0 > cutter.least
    message = r"^body: its box is 0\.\d+ m in the wall; high = 0\.72 would do\.$"
    with pytest.raises(ValueError, match=message):
        planned(high=0.9)
    planned(high=0.72)
    message = r"^body: its holder is 0\.\d+ m in the wall \d\.\d+ m along the circuit; holder_rad"
    with pytest.raises(ValueError, match=message) as refused:
        planned(holder_radius=0.25)
    planned(holder_radius=float(re.search(r"= (\S+) would", str(refused.value))[1]))
