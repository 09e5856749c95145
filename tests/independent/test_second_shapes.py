"""Machine, torus, tunnel and circuit: sampled, where the chapters have closed forms."""

import numpy as np

from tests.independent.section import HALF, HEIGHT, INSIDE, LARGE, SMALL, centre, egg, joints

READS = ["report/numbers/*.json"]

LIFTED, LOWERED, SWUNG = np.radians([60, 35, 40])


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=-1).sum()


def circuit(count=40_001):
    """Return the joints' angles (n, 2) and the cutter's places (n, 3) once round."""
    angles = joints(*egg(INSIDE, count).T)
    return np.stack(angles, axis=-1), centre(*angles)


def test_perimeter_of_the_tunnel(printed):
    assert length(egg()) == printed("03_tunnel", "perimeter")


def test_area_of_the_tunnel_by_triangles(printed):
    y, z = egg().T
    twice = np.sum(y[:-1] * z[1:] - y[1:] * z[:-1])
    assert twice / 2 == printed("03_tunnel", "area")


def test_perimeter_of_the_curve_of_the_cutters_centre(printed):
    assert length(egg(INSIDE)) == printed("03_tunnel", "perimeter of the offset")


def test_length_of_the_circuit(printed):
    assert length(circuit()[1]) == printed("05_circuit", "length of the circuit")


def test_joint_angles_of_the_circuit(printed):
    theta, phi = np.degrees(circuit()[0]).T
    assert theta.min() == printed("05_circuit", "theta lowest")
    assert theta.max() == printed("05_circuit", "theta highest")
    assert phi.max() == printed("05_circuit", "phi largest")


def test_circuit_bends_within_the_torus_on_the_roof(printed):
    """The part of the acceleration that is neither along the way nor along the normal."""
    places = circuit(4001)[1][:4001]
    step = np.pi * (HALF - INSIDE) / 4000
    velocity = (places[2:] - places[:-2]) / (2 * step)
    change = (places[2:] - 2 * places[1:-1] + places[:-2]) / step**2
    x, y, z = (places[1:-1] - [0, 0, HEIGHT]).T
    away = 1 - SMALL / np.hypot(x, z)  # from the ring, on which the arm's joint moves
    normal = np.stack([x * away, y, z * away], axis=-1) / LARGE
    aside = np.sum(np.cross(normal, velocity) * change, axis=-1)
    bend = np.abs(aside) / np.linalg.norm(velocity, axis=-1) ** 3
    assert bend.min() == printed("05_circuit", "geodesic curvature, least")
    assert bend.max() == printed("05_circuit", "geodesic curvature, largest")


def heights(arm):
    """Return between which heights a machine with this arm reaches all places of the curve."""
    y, z = egg(INSIDE, 4001).T
    reach = SMALL + arm * np.sqrt(np.maximum(1 - (y / arm) ** 2, 0))
    return (z - reach * np.sin(LIFTED)).max(), (z + reach * np.sin(LOWERED)).min()


def test_heights_at_which_the_machine_reaches_all_of_the_section(printed):
    low, high = heights(LARGE)
    assert low == printed("01_machine", "lowest height")
    assert high == printed("01_machine", "highest height")


def test_shortest_arm_that_does(printed):
    widest = egg(INSIDE)[:, 0].max()
    short, long = 0.3, 1.2
    for _ in range(40):
        arm = (short + long) / 2
        low, high = heights(arm)
        does = low <= high and widest <= arm * np.sin(SWUNG)
        short, long = (short, arm) if does else (arm, long)
    assert long == printed("01_machine", "shortest arm")


def test_width_of_a_cell_at_the_joints_limit(printed):
    """Two places a small turn of the crank apart, at the limit and on the equator."""
    for degrees in (40, 60):
        reach = SMALL + LARGE * np.cos(np.radians([degrees, 0]))
        limit, equator = 2 * reach * np.sin(5e-7)  # chords
        assert 100 * limit / equator == printed("02_torus", f"cell width at {degrees} deg")


def test_flattening_and_dimple_of_the_torus_of_eight_to_one(printed):
    """Of the curve that turns about the axis: its greatest distances, and where it meets it."""
    crank, arm = 0.1, 0.8
    phi = np.linspace(0, np.pi, 2_000_001)
    away, height = crank + arm * np.cos(phi), arm * np.sin(phi)
    size = away.max()
    node = height[np.argmin(np.abs(away))]
    assert 100 * (1 - height.max() / size) == printed("02_torus", "flattening")
    assert 100 * (height.max() - node) / size == printed("02_torus", "dimple")
    within = np.hypot(away, height)[phi <= SWUNG]
    assert 100 * (1 - within.min() / size) == printed("02_torus", "flattening within 40 deg")


def section_area(pieces):
    """Return the area that points (n, 2), once round, enclose."""
    y, z = np.concatenate(pieces).T
    return abs(np.sum(y * np.roll(z, -1) - z * np.roll(y, -1))) / 2


def test_areas_of_the_other_sections(printed):
    turn = np.linspace(0, np.pi, 20_001)
    around = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    quarter = turn[turn >= np.pi / 2] + np.pi / 2
    corner = 0.25 * np.stack([np.cos(quarter), np.sin(quarter)], axis=-1)
    left = np.array([-0.25, -0.4]) + corner
    horseshoe = [0.5 * around, left, left[::-1] * [-1, 1]]
    area = "area / m#super[2]"
    assert section_area(horseshoe) == printed("44_sections", "sections", "horseshoe", area)
    circle = [0.6 * around, -0.6 * around]
    assert section_area(circle) == printed("44_sections", "sections", "circle, 1.2 m wide", area)
