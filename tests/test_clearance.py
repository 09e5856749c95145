"""Clearance in closed form against samples of the arm, the section and a grid of intervals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tunneller_lib.paths import cutting_circuit
from tunneller_lib.removal import DexelGrid, circuit_clearance, rod_clearance, solid_clearance
from tunneller_lib.surfaces import REFERENCE_MACHINE, Box, Egg, Frustum, Rod, RoundedDisc

EGG = Egg(0.5)
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


def test_ends_of_the_arm_are_an_arm_apart():
    position = np.random.default_rng(0).uniform(-0.6, 0.6, (50, 2))
    joint, centre = cutting_circuit(REFERENCE_MACHINE, EGG).arm(position)
    np.testing.assert_allclose(np.linalg.norm(centre - joint, axis=-1), REFERENCE_MACHINE.R)
    np.testing.assert_allclose(joint[:, 1], 0)
    from_axis = np.hypot(joint[:, 0], joint[:, 2] - REFERENCE_MACHINE.height)
    np.testing.assert_allclose(from_axis, REFERENCE_MACHINE.r)


@pytest.mark.parametrize("arm_radius", [0.0, 0.1, 0.25])
def test_circuit_clearance_is_the_least_over_the_circuit(arm_radius):
    circuit = cutting_circuit(REFERENCE_MACHINE, EGG)
    low, high = circuit.reach()
    found = circuit_clearance(REFERENCE_MACHINE, EGG, low[0], high[0], arm_radius)
    s = np.linspace(0, EGG.offset(REFERENCE_MACHINE.offset).perimeter, 5001)
    ends = circuit.arm(circuit.position(s))
    sampled = rod_clearance(EGG, *ends, arm_radius)
    np.testing.assert_allclose(found.arm, sampled.min(), atol=1e-9)
    cutter = EGG.depth(ends[1][:, 1], ends[1][:, 2]) - REFERENCE_MACHINE.cutter_radius
    np.testing.assert_allclose(found.cutter, cutter, atol=1e-9)
    assert found.cutter == pytest.approx(-REFERENCE_MACHINE.depth)


@pytest.mark.parametrize(("lowest", "highest"), [(-0.3, 0.5), (-0.9, 0.2), (0.1, 0.4)])
def test_joint_near_the_roof_decides(lowest, highest):
    machine = replace(REFERENCE_MACHINE, height=0.35)
    found = circuit_clearance(machine, EGG, lowest, highest, 0.0).arm
    heights = machine.height - machine.r * np.sin(np.linspace(lowest, highest, 101))
    assert found == pytest.approx(EGG.depth(np.zeros(101), heights).min(), abs=1e-12)
    assert found < 0.9 * machine.offset


def test_circuit_clearance_takes_a_quarter_turn_each_way():
    quarter = np.pi / 2
    found = circuit_clearance(REFERENCE_MACHINE, EGG, -quarter, quarter, 0.0).arm
    straight = [EGG.depth(0, REFERENCE_MACHINE.height + side * REFERENCE_MACHINE.r)
                for side in (-1, 1)]  # fmt: skip
    assert found == pytest.approx(min(*straight, REFERENCE_MACHINE.offset), rel=1e-12)
    for ends in ((-np.nextafter(quarter, 2), 0), (0, np.nextafter(quarter, 2)), (0.1, 0)):
        with pytest.raises(ValueError, match=r"^lowest: must be at most highest, both from -pi/2"):
            circuit_clearance(REFERENCE_MACHINE, EGG, *ends, 0.0)


def posed(seed):
    """Return two places and a rotation at random, about the egg."""
    rng = np.random.default_rng(seed)
    return *rng.uniform(-0.4, 0.4, (2, 3)), np.linalg.qr(rng.normal(size=(3, 3)))[0], rng


def rim(centre, axis, radius):
    """Return points (n, 3) of a circle."""
    across = np.linalg.qr(np.stack([axis, *np.eye(3)], axis=-1))[0][:, 1:3]
    turn = np.linspace(0, 2 * np.pi, COUNT)
    return centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1) @ across.T


@pytest.mark.parametrize("seed", range(8))
def test_solid_clearance_is_the_least_depth_of_the_solid(seed):
    # Inside, across the wall and outside; the least depth of a convex solid is at a corner or rim.
    a, b, turn, rng = posed(seed)
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
    disc = solid_clearance(EGG, RoundedDisc(a, b - a, first, 0))
    assert disc == pytest.approx(depths[0], abs=SAGITTA) and rod <= disc + 1e-14
    rounded = solid_clearance(EGG, RoundedDisc(a, b - a, first, corner))
    assert rounded == pytest.approx(disc - corner, abs=1e-14)
    box = Box(a, *(turn * [[first], [last], [corner]]))
    points = box.faces.reshape(-1, 3)
    assert solid_clearance(EGG, box) == EGG.depth(points[:, 1], points[:, 2]).min()


@pytest.mark.parametrize("turn", [0.0, 1e-12, 1e-6, 0.3, np.pi / 2])
def test_solid_clearance_of_a_wheel_in_the_middle(turn):
    # About the tunnel's axis, leaning to one side: the reach to that side is the radius' cosine.
    wheel = Rod((0, 0, 0), (0.1 * np.cos(turn), 0.1 * np.sin(turn), 0), 0.3)
    found = solid_clearance(EGG, wheel)
    assert found <= 0.5 - 0.3 * np.cos(turn) + 1e-15
    points = np.concatenate([rim(end, np.subtract(wheel.b, wheel.a), 0.3)
                             for end in np.array([wheel.a, wheel.b])])  # fmt: skip
    assert found == pytest.approx(EGG.depth(points[:, 1], points[:, 2]).min(), abs=SAGITTA)


def test_solid_clearance_of_nothing_and_of_a_point():
    assert solid_clearance(EGG, Rod((0, 0, 0), (0, 0, 0), 1)) == np.inf
    assert solid_clearance(EGG, Rod((9, 0.2, 0), (9, 0.2, 0), 0, ends="round")) == 0.3


@pytest.mark.parametrize("kind", ["frustum", "box", "disc"])
def test_grid_sees_the_same_collision_of_any_solid(kind):
    # The same solids, cut into the wall by the kernel of lines and held against it by planes.
    angle = (np.arange(360) + 0.5) * np.pi / 180
    inner = EGG.ray(angle)
    tunnel = DexelGrid.radial(-0.5, 0.5, inner, inner + 0.3, (200, 360))

    def solid(more):
        if kind == "frustum":
            return Frustum((-0.1, 0, 0.1), (0.2, 0.1, 0), 0.2 + more, 0.1)
        if kind == "box":
            return Box((-0.2, -0.25, -0.2), (0.4, 0, 0), (0, 0.5 + more, 0), (0, 0, 0.3))
        return RoundedDisc((0, 0.1, 0.1), (1, 0.2, 0.3), 0.2, 0.05 + more)

    low, high = 0.0, 1.0
    for _ in range(12):
        middle = (low + high) / 2
        clear = solid_clearance(EGG, solid(middle)) > 0
        low, high = (middle, high) if clear else (low, middle)
    assert tunnel.overlap(solid(low - 1e-3)) == 0 < tunnel.overlap(solid(low + 1e-2))


def test_grid_sees_the_same_collision():
    circuit = cutting_circuit(REFERENCE_MACHINE, EGG)
    clearance = circuit_clearance(REFERENCE_MACHINE, EGG, *(r[0] for r in circuit.reach()), 0.0).arm
    s = circuit.knots(tolerance=1e-3)
    joint, centre = circuit.arm(circuit.position(s))
    angle = (np.arange(360) + 0.5) * np.pi / 180
    inner, outer = np.zeros(360), np.full(360, 1.2)
    for _ in range(40):  # the wall, halved in
        middle = (inner + outer) / 2
        inside = EGG.depth(middle * np.cos(angle), middle * np.sin(angle)) > 0
        inner, outer = np.where(inside, middle, inner), np.where(inside, outer, middle)
    tunnel = DexelGrid.radial(-0.3, 1.3, inner, inner + 0.2, (200, 360))
    for radius, collides in ((clearance - 1e-3, False), (clearance + 5e-3, True)):
        rods = [Rod(a, b, radius, ends="round") for a, b in zip(joint, centre, strict=True)]
        assert any(tunnel.overlap(rod) > 0 for rod in rods) is collides


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: solid_clearance(EGG, 1), "solid: must be of class Rod or Frustum"),
        (lambda: rod_clearance(1, (0, 0, 0), (1, 0, 0), 1), "section: must be of class Section"),
        (lambda: rod_clearance(EGG, (0, 0, np.nan), (1, 0, 0), 1), "a: must hold finite numbers"),
        (lambda: circuit_clearance(REFERENCE_MACHINE, EGG, 1, 0, 0), "lowest: must be at most"),
        (lambda: circuit_clearance(REFERENCE_MACHINE, EGG, np.nan, 0, 0), "lowest: must be one"),
        (lambda: circuit_clearance(REFERENCE_MACHINE, EGG, 0, 0, -1), "arm_radius: must be one"),
    ],
)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
