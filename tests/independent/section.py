"""The reference machine and its tunnel, for more than one of the second opinions."""

import numpy as np

SMALL, LARGE = 0.08, 0.80  # m, crank and arm
HEIGHT = -0.36  # m, of the crank's joint below the centre of the roof
BALL, DEPTH = 0.20, 0.02  # m, radius of the cutter, and how deep it cuts
HALF, INSIDE = 0.5, BALL - DEPTH  # m, half of the width; from the wall to the cutter's centre


def egg(inside=0.0, count=40_001):
    """Return points (n, 2) of the egg-shaped section, or of a curve inside it, once round.

    Roof, right wall, invert and left wall are arcs about (0, 0), (2, 0), (0, -3/2) and (-2, 0),
    with radii 1, 3, 1/2 and 3, all times half of the width.
    """
    bend = np.arctan2(1.5, 2)
    arcs = [
        (0, 0, 1, 0, np.pi),
        (2, 0, 3, np.pi, np.pi + bend),
        (0, -1.5, 0.5, np.pi + bend, 2 * np.pi - bend),
        (-2, 0, 3, 2 * np.pi - bend, 2 * np.pi),
    ]
    pieces = []
    for y, z, radius, first, last in arcs:
        turn = np.linspace(first, last, count)[:-1]
        out = (HALF * radius - inside) * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        pieces.append(HALF * np.array([y, z]) + out)
    return np.concatenate([*pieces, pieces[0][:1]])


def even(points, count):
    """Return as many points of a curve (n, 2) at equal ways, the first and the last included."""
    way = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=-1)))
    at = np.linspace(0, way[-1], count)
    return np.stack([np.interp(at, way, axis) for axis in points.T], axis=-1)


def joints(y, z):
    """Return theta and phi at which the cutter's centre is over a place of the section."""
    phi = np.arcsin(y / LARGE)
    return -np.arcsin((z - HEIGHT) / (SMALL + LARGE * np.cos(phi))), phi


def centre(theta, phi):
    """Return the cutter's centre (..., 3) in the tunnel."""
    reach = SMALL + LARGE * np.cos(phi)
    x, y, z = reach * np.cos(theta), LARGE * np.sin(phi), HEIGHT - reach * np.sin(theta)
    return np.stack([x, y, z], axis=-1)


def beyond(y, z, inside=0.0):
    """Return how far places are outside the section, or outside a curve inside it, in m."""
    below = np.abs(np.arctan2(y, -(z + 1.5 * HALF))) < np.arctan2(2, 1.5)
    roof = np.hypot(y, z) - HALF
    invert = np.hypot(y, z + 1.5 * HALF) - HALF / 2
    wall = np.hypot(np.abs(y) + 2 * HALF, z) - 3 * HALF
    return inside + np.where(z >= 0, roof, np.where(below & (z < -HALF), invert, wall))
