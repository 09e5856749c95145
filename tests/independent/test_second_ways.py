"""Feet, chords and geodesics: by stepping the equation of geodesics, and by many small chords."""

from functools import cache

import numpy as np

READS = ["report/numbers/*.json"]

SMALL, LARGE = 0.08, 0.80  # m, crank and arm
LOW, HIGH = np.radians([[-60, -40], [35, 40]])  # theta, phi, the joints' limits


def shortest(start, stop, profile, metre, angle, length, steps=1000):
    """Return length and positions (steps + 1, 2) of a geodesic, from a guess of angle and length.

    On a surface of revolution with the distance rho(u) from the axis, whose places (azimuth, u)
    have lines of constant azimuth that take `metre` for each u:

        azimuth'' = -2 (rho' / rho) u' azimuth',  u'' = rho rho' azimuth'^2 / metre^2,

    stepped by Runge and Kutta; the angle from a line of constant azimuth and the length by Newton.
    """

    def rate(state):
        _, u, turning, climbing = state
        rho, slope = profile(u)
        bent = -2 * slope / rho * climbing * turning
        return np.array([turning, climbing, bent, rho * slope * (turning / metre) ** 2])

    def walk(angle, length):
        turning, climbing = np.sin(angle) / profile(start[1])[0], np.cos(angle) / metre
        state = np.array([start[0] + 0 * angle, start[1] + 0 * angle, turning, climbing])
        h = length / steps
        way = [state]
        for _ in range(steps):
            a = rate(state)
            b = rate(state + h / 2 * a)
            c = rate(state + h / 2 * b)
            state = state + h / 6 * (a + 2 * b + 2 * c + rate(state + h * c))
            way.append(state)
        return np.array(way)[:, :2]

    found = np.array([angle, length])
    for _ in range(5):
        tried = found[:, None] + 1e-6 * np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
        way = walk(*tried)
        end = way[-1]
        turns = np.stack([end[:, 1] - end[:, 2], end[:, 3] - end[:, 4]], axis=-1) / 2e-6
        found = found + np.linalg.solve(turns, stop - end[:, 0])
    return found[1], walk(*found[:, None])[..., 0]


def torus(crank, arm=LARGE):
    return lambda phi: (crank + arm * np.cos(phi), -arm * np.sin(phi))


def place(position, crank=SMALL, arm=LARGE):
    theta, phi = np.moveaxis(position, -1, 0)
    reach = crank + arm * np.cos(phi)
    return np.stack([reach * np.cos(theta), arm * np.sin(phi), -reach * np.sin(theta)], axis=-1)


def projected(p, q, crank=SMALL, arm=LARGE, count=20_001):
    """Return the nearest places (count, 3) of the working sheet to even points of a chord."""
    ends = place(np.array([p, q]), crank, arm)
    x, y, z = (ends[0] + np.linspace(0, 1, count)[:, None] * (ends[1] - ends[0])).T
    return place(
        np.stack([np.arctan2(-z, x), np.arctan2(y, np.hypot(x, z) - crank)], -1), crank, arm
    )


def length_of(points):
    """Return the length of a curve from an odd number of even points, by Richardson."""
    fine, coarse = (
        np.linalg.norm(np.diff(p, axis=0), axis=-1).sum() for p in (points, points[::2])
    )
    return fine + (fine - coarse) / 3


CORNERS = np.array([LOW, HIGH])


@cache
def longest(crank=SMALL, arm=LARGE):
    """Return the geodesic's length from corner to corner of the limits, and its positions."""
    return shortest(*CORNERS, torus(crank, arm), arm, 0.9, 1.8 * (crank + arm))


def excess(crank, arm=1.0):
    return length_of(projected(*CORNERS, crank, arm)) / longest(crank, arm)[0] - 1


def test_short_and_long_way_round(printed):
    p, q = np.radians([(-30, 20), (20, -10)])
    short = shortest(p, q, torus(SMALL), LARGE, 2.1, 0.9)[0]
    long = shortest(p, q - [2 * np.pi, 0], torus(SMALL), LARGE, -1.5, 4.6)[0]
    assert short == printed("09_geodesic", "the short way")
    assert long == printed("09_geodesic", "the long way round")


def test_turn_up_to_which_a_geodesic_is_alone(printed):
    """Where a way that leaves the equator by a thousandth of a degree comes back to it."""
    angle = np.pi / 2 - 1e-5
    way = shortest(np.zeros(2), np.array([np.radians(171), 1e-8]), torus(SMALL), LARGE, angle, 2.6)
    last, ahead = way[1][-2:]
    crossed = ahead[0] - ahead[1] * (ahead[0] - last[0]) / (ahead[1] - last[1])
    assert np.degrees(crossed) == printed("09_geodesic", "alone up to")


def test_geodesic_leaves_the_limits_of_the_joints(printed):
    p, q = np.array([LOW[0], HIGH[1]]), HIGH
    way = shortest(p, q, torus(SMALL), LARGE, 1.0, 1.2)[1]
    beyond = np.degrees(way[:, 1].max() - HIGH[1])
    assert beyond == printed("09_geodesic", "beyond the limit")


def test_way_through_both_nodes(printed):
    """The other arc of a meridian's circle, which meets the axis twice."""
    phi = np.linspace(HIGH[1], 2 * np.pi + LOW[1], 200_001)
    points = place(np.stack([0 * phi, phi], axis=-1))
    assert np.count_nonzero(np.diff(np.sign(points[:, 0]))) == 2
    assert length_of(points) == printed("09_geodesic", "through both nodes")


def test_projected_chord_is_longer_from_corner_to_corner(printed):
    assert 1e6 * excess(SMALL, LARGE) == printed("11_rivals", "worst excess")
    assert longest()[0] == printed("11_rivals", "length of the worst")


def test_projected_chord_lies_beside_the_geodesic(printed):
    geodesic = place(longest()[1])
    path = projected(*CORNERS, count=2001)
    nearest = np.linalg.norm(path[:, None] - geodesic, axis=-1).argmin(axis=1)
    gap, ahead = path - geodesic[nearest], np.gradient(geodesic, axis=0)[nearest]
    aside = np.linalg.norm(np.cross(gap, ahead), axis=-1) / np.linalg.norm(ahead, axis=-1)
    assert 1e3 * aside.max() == printed("09_geodesic", "aside, corner to corner")


def test_projected_chord_on_other_tori(printed):
    assert 100 * excess(1 / 4) == printed("11_rivals", "worst excess at 4")
    assert 1e6 * excess(1 / 100) == printed("11_rivals", "worst excess at 100")


def test_one_constant_bounds_the_excess_on_every_torus_up_to_the_horn(printed):
    """Its limit for a vanishing crank, by a polynomial through five."""
    cranks = np.linspace(0.01, 0.05, 5)
    multiples = [excess(crank) / crank**2 for crank in cranks]
    assert np.polyfit(cranks, multiples, 4)[-1] == printed("13_any_length", "sup F")


def test_line_in_the_joint_angles_is_longer(printed):
    p, q = np.array([LOW[0], HIGH[1]]), HIGH
    straight = (HIGH[0] - LOW[0]) * (SMALL + LARGE * np.cos(HIGH[1]))
    length = shortest(p, q, torus(SMALL), LARGE, 1.0, 1.2)[0]
    assert 100 * (straight / length - 1) == printed("11_rivals", "worst excess, joint space")


def test_nearest_foot_is_often_another_than_the_machines(printed):
    """Each of the four by the circles of the half-plane through the point and the axis."""
    rng = np.random.default_rng(6)
    p, q = (place(rng.uniform(LOW, HIGH, (20_000, 2))) for _ in range(2))
    m = p + rng.uniform(0, 1, (20_000, 1)) * (q - p)
    away, height = np.hypot(m[:, 0], m[:, 2]), m[:, 1]
    near, far = (np.hypot(away + side * SMALL, height) for side in (-1, 1))
    radii = np.abs([LARGE - near, LARGE - far, LARGE + near, LARGE + far])
    another = 100 * np.mean(radii.argmin(axis=0) != 0)
    assert another == printed("06_tangent_spheres", "points whose nearest foot is another")


def test_equal_steps_along_a_chord_are_unequal_on_the_torus(printed):
    worst = 1.0
    for p, q in (CORNERS, CORNERS * [1, -1], (LOW, [HIGH[0], LOW[1]]), (LOW, [LOW[0], HIGH[1]])):
        small = np.linalg.norm(np.diff(projected(p, q, count=10_001), axis=0), axis=-1)
        steps = small.reshape(10, -1).sum(axis=-1)
        worst = max(worst, steps.max() / steps.min())
    assert worst == printed("07_chord", "worst ratio, chord")


# The cone of the appendix: 1 m wide and deep, a quarter of a turn, from the rim half way up

SLANT = np.sqrt(2.0)  # m, of P; Q's is half of it
FINE = np.linspace(0, 1, 20_001)


def cone_path():
    """Return azimuths and distances from the apex (n,) of the chord's feet, along rulings."""
    p, q = np.array([1, 0, 1.0]), np.array([0, 0.5, 0.5])
    x, y, depth = (p + FINE[:, None] * (q - p)).T
    return np.arctan2(y, x), (np.hypot(x, y) + depth) / SLANT


def unrolled(azimuth, away):
    turned = azimuth / SLANT
    return away[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)


@cache
def cone_geodesic():
    half = np.array([np.pi / 2, SLANT / 2])
    return shortest(np.array([0, SLANT]), half, lambda u: (u / SLANT, 1 / SLANT), 1.0, 2.6, 1.27)


def test_lengths_on_the_cone(printed):
    geodesic = cone_geodesic()[0]
    path = length_of(unrolled(*cone_path()))
    assert geodesic == printed("08_cone", "geodesic")
    assert path == printed("08_cone", "tangent-sphere path")
    assert 100 * (path / geodesic - 1) == printed("08_cone", "excess")


def test_path_on_the_cone_beside_its_geodesic(printed):
    """Along the rulings, as the table has it, and at right angles to the geodesic."""
    azimuth, away = cone_path()
    turn, ruling = cone_geodesic()[1].T
    radial = np.abs(away - np.interp(azimuth, turn, ruling)).max()
    sheet = unrolled(azimuth, away)
    ahead = (sheet[-1] - sheet[0]) / np.linalg.norm(sheet[-1] - sheet[0])
    off = sheet - sheet[0]
    aside = np.abs(off[:, 0] * ahead[1] - off[:, 1] * ahead[0]).max()
    assert 1e3 * radial == printed("08_cone", "largest radial difference")
    assert 1e3 * aside == printed("08_cone", "largest deviation")


def test_radius_of_the_second_sphere_about_a_point_in_a_cone(printed):
    """The least distance from M to the wall that lies opposite, tried along its ruling."""
    m = np.array([-np.sqrt(2), -3 * np.sqrt(2), -12.0])
    outward = -m[:2] / np.hypot(*m[:2])
    low, high = 0.0, 30.0  # depths
    for _ in range(100):
        third = (high - low) / 3
        first, second = (
            np.linalg.norm([*(d / 2 * outward), -d] - m) for d in (low + third, high - third)
        )
        low, high = (low, high - third) if first < second else (low + third, high)
    assert first == printed("08_cone", "second radius")
