"""Planes and cones: by differences of planes, and by roots of polynomials in a direction."""

import numpy as np

READS = ["report/numbers/*.json"]


def test_tangent_plane_of_a_helicoid_turns_along_a_ruling(printed):
    """Lines across the x axis, one radian a metre; from 0.1 m to 1.2 m along one."""

    def point(s, t):
        return np.array([s, t * np.cos(s), t * np.sin(s)])

    h = 1e-5
    normals = []
    for t in (0.1, 1.2):
        along = point(0.35, t + h) - point(0.35, t - h)
        across = point(0.35 + h, t) - point(0.35 - h, t)
        normal = np.cross(along, across)
        normals.append(normal / np.linalg.norm(normal))
    found = np.degrees(np.arccos(normals[0] @ normals[1]))
    assert found == printed("51_planes_as_points", "turn of the plane, skew")


STEPS = np.geomspace(0.01, 0.04, 6)


def power(gap):
    return np.polyfit(np.log(STEPS), np.log(np.abs(gap)), 1)[0]


def test_power_of_the_gap_to_an_osculating_cone(printed):
    """From a point of a cubic, its cone's tip, to the osculating planes beside it."""
    s = 0.7 + STEPS
    point = np.stack([s, 0.4 * s**2, s**3 / 6], axis=-1)
    velocity = np.stack([1 + 0 * s, 0.8 * s, s**2 / 2], axis=-1)
    change = np.stack([0 * s, 0.8 + 0 * s, s], axis=-1)
    n = np.cross(velocity, change)
    tip = np.array([0.7, 0.4 * 0.7**2, 0.7**3 / 6])
    gap = np.sum((tip - point) * n, axis=-1) / np.linalg.norm(n, axis=-1)
    assert power(gap) == printed("53_contact", "power of the gap, osculating")


def test_power_of_the_gap_to_a_hyperosculating_cone(printed):
    """A roof at 45 degrees through an ellipse; its cone's tip is over the centre of curvature."""
    long, short = 2.0, 1.0
    radius = short**2 / long
    edge = np.stack([long * np.cos(STEPS), short * np.sin(STEPS)], axis=-1)
    out = np.stack([np.cos(STEPS) / long, np.sin(STEPS) / short], axis=-1)
    out /= np.linalg.norm(out, axis=-1)[:, None]
    tip = np.array([long - radius, 0.0])
    # A plane rises by the distance from the edge inwards; the tip lies as deep as its circle's.
    gap = (np.sum((edge - tip) * out, axis=-1) - radius) / np.sqrt(2)
    assert power(gap) == printed("53_contact", "power of the gap, hyperosculating")


HALF_ANGLE = np.radians(30)


def wave(a, x, y, second, third):
    """Return what vanishes in directions a (rad) where a cone fits a graph to third order.

    Over the place p of the model planes of a cone lie on a circle, in the direction e, to its left
    w, of the radius rho = (1 + p^2) / (2 (tan - p.w)). A graph meets a conic over it to third
    order where rho f_eee + 3 f_ew = 0; second and third are its derivatives xx, xy, yy and so on.
    """
    c, s = np.cos(a), np.sin(a)
    along = third[0] * c**3 + 3 * third[1] * c * c * s + 3 * third[2] * c * s * s + third[3] * s**3
    twist = (second[2] - second[0]) * s * c + second[1] * (c * c - s * s)
    return (1 + x * x + y * y) / 2 * along + 3 * (np.tan(HALF_ANGLE) + x * s - y * c) * twist


def parts(x, y, second, third):
    """Return the shares (7, ...) of exp(3i a) to exp(-3i a) in the wave."""
    eight = np.pi / 4 * np.arange(8).reshape(8, *[1] * np.ndim(y))
    return np.fft.fft(wave(eight, x, y, second, third), axis=0)[[3, 2, 1, 0, -1, -2, -3]]


def cones(*place):
    """Return the number of different cones at a place: roots of the wave as a polynomial."""
    roots = np.roots(parts(*place))
    angles = np.sort(np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-5]))
    return int(np.sum(np.diff(angles, append=angles[0] + 2 * np.pi) > 1e-4))


def cyclide(x, y):
    """Return second and third derivatives of y^2 / (x^2 + y^2), by Cauchy's sums.

    The function is analytic; each derivative is a mean over circles about the place.
    """
    turn = np.exp(2j * np.pi * np.arange(32) / 32)
    h = 0.1 * np.hypot(x, y)
    u, v = np.meshgrid(x + h * turn, y + h * turn, indexing="ij")
    series = np.fft.fft2(v**2 / (u**2 + v**2)).real / 32**2

    def derivative(i, j):
        factorial = [1, 1, 2, 6]
        return series[i, j] * factorial[i] * factorial[j] / h ** (i + j)

    return [derivative(2 - k, k) for k in range(3)], [derivative(3 - k, k) for k in range(4)]


def test_cones_of_a_cyclide(printed):
    """Six within the disk of the radius cot, four beyond it, five on the small circles."""
    found = cones(0.5, 0.3, *cyclide(0.5, 0.3))
    assert found == printed("53_contact", "cones at the point")
    assert cones(2.0, 1.5, *cyclide(2.0, 1.5)) == printed("53_contact", "cones outside")
    border = 1 / np.tan(HALF_ANGLE)
    small = border / 2 * np.array([np.cos(0.7), 1 + np.sin(0.7)])
    assert cones(*small, *cyclide(*small)) == printed("53_contact", "cones on the small circles")


def test_shares_of_a_map_with_two_four_and_six_cones(printed):
    """By changes of sign over 720 directions at the middles of squares."""
    side = 6 * (np.arange(440) + 0.5) / 440 - 3
    around = np.exp(1j * np.radians(np.outer(np.arange(720) / 2, np.arange(3, -4, -1))))
    counts = np.zeros(8)
    for x in side:
        c, s = np.cos(2 * x), np.sin(2 * x)
        cy, sy = np.cos(side), np.sin(side)
        second = -4 * s * cy, 0.3 - 2 * c * sy, -s * cy
        third = -8 * c * cy, 4 * s * sy, -2 * c * cy, s * sy
        above = (around @ parts(x, side, second, third)).real > 0
        changes = np.sum(above != np.roll(above, 1, axis=0), axis=0)
        counts += np.bincount(changes, minlength=8)
    for n in (2, 4, 6):
        share = 100 * counts[n] / counts.sum()
        assert share == printed("53_contact", f"share with {n} cones")
