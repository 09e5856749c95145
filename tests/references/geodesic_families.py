"""The families of torus_geodesics.csv: how the start of each geodesic is drawn."""

import math

import numpy as np
from mpmath import mp, mpf

from tests.references.geodesic_rivals import waves
from tests.references.torus_geodesics import LIMIT, Start, from_azimuth

RIM = math.pi


def log(rng, low, high):
    """Return a number spread evenly in its logarithm."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def sheet(rng):
    """Return r, R of a machine: R/r from 4 to 100."""
    return 0.8 / log(rng, 4, 100), 0.8


def ring(rng):
    """Return r, R of a ring of any proportion: r/R - 1 from 1e-3 to 29."""
    R = log(rng, 1e-3, 1e3)
    return R * (1 + log(rng, 1e-3, 29)), R


def spindle(rng):
    """Return r, R of a spindle less narrow than a machine's: R/r from 1.01 to 4."""
    r = log(rng, 1e-2, 1e2)
    return r, r * (1 + log(rng, 0.01, 3))


def nearly_horn(rng):
    """Return r, R of a spindle with R/r - 1 from 1e-5 to 1e-2."""
    r = log(rng, 1e-2, 1e2)
    return r, r * (1 + log(rng, 1e-5, 1e-2))


def node(r, R):
    """Return the greatest phi: of the node, or of the inner equator."""
    return math.acos(-r / R) if r < R else RIM


def any_torus(rng):
    return rng.choice([sheet, ring, spindle])(rng)


def reach(r, R):
    """Return the greatest |phi| that a family away from nodes uses."""
    return LIMIT if R / r >= 4 else RIM if r > R else 0.9 * node(r, R)


def ends(rng, limit):
    """Return phi = a >= |b|."""
    x, y = (rng.uniform(-limit, limit) for _ in range(2))
    return (abs(x), y) if abs(x) > abs(y) else (abs(y), x)


def anywhere(rng, torus):
    r, R = torus(rng)
    return from_azimuth(r, R, *ends(rng, reach(r, R)), rng.uniform(0, math.pi))


def working_sheet(rng):
    """Draw within the machine's joint limits: a path turns by 95 degrees at most."""
    while True:
        start = anywhere(rng, sheet)
        if turned(start) <= math.radians(95):
            return start


def turned(start):
    """Return by how much a start turns, in floating point."""
    m = float(mp.hypot(start.a, start.unknown))
    c = np.array([start.r + start.R * math.cos(m)])
    first, last = (np.arccos(np.array([phi / m])) for phi in (start.a, start.b))
    at_a, at_b = (waves(start.R, c, np.array([m]), s)[0, 0] for s in (first, last))
    return at_b - (at_a if start.unknown > 0 else -at_a)


def short(rng):
    """Draw lengths from 1e-9 to 1e-2 R."""
    r, R = any_torus(rng)
    a, azimuth = rng.uniform(0.05, 1) * reach(r, R), rng.uniform(math.pi / 2, math.pi)
    b = a + log(rng, 1e-9, 1e-2) * math.cos(azimuth)
    return from_azimuth(r, R, a, b, azimuth)


def nearly_meridional(rng):
    """Draw azimuths from 1e-12 to 1e-3 off a meridian, over the inner equator too."""
    r, R = any_torus(rng)
    off = log(rng, 1e-12, 1e-3)
    a, b = ends(rng, reach(r, R))
    over = r > R and a - b > math.pi
    return from_azimuth(r, R, a, b, off if over else math.pi - off)


def meridional(rng):
    r, R = any_torus(rng)
    return Start(r, R, *ends(rng, reach(r, R)), "meridian", mpf(0))


def on_a_parallel(rng):
    """Draw two ends of equal phi: the geodesic has a vertex half way."""
    r, R = any_torus(rng)
    a = log(rng, 1e-3, 1) * reach(r, R)
    m = a + log(rng, 1e-6, 0.9) * (node(r, R) - a)
    return Start(r, R, a, a, "wave", -mp.sqrt((mpf(m) - a) * (mpf(m) + a)))


def vertex_to_vertex(rng):
    """Draw ends at +-phi, both nearly vertices: t from 1e-5 to 1e-2."""
    r, R = any_torus(rng)
    a = rng.uniform(0.02, 0.98) * (LIMIT if R / r >= 4 else node(r, R))
    return Start(r, R, a, -a, "wave", mpf(rng.choice([-1, 1]) * log(rng, 1e-5, 1e-2)))


def near_a_node(rng):
    """Draw the first end from 1e-6 to 0.1 off the node of a spindle."""
    r, R = rng.choice([sheet, spindle])(rng)
    a = node(r, R) - log(rng, 1e-6, 0.1)
    return from_azimuth(r, R, a, rng.uniform(-1, 1) * 0.9 * a, rng.uniform(0, math.pi))


def near_both_nodes(rng):
    """Draw ends from 1e-6 to 0.1 off opposite nodes of a spindle, which may be nearly a horn."""
    r, R = rng.choice([sheet, spindle, nearly_horn])(rng)
    gaps = sorted(log(rng, 1e-6, 0.1) for _ in range(2))
    a, b = (node(r, R) - gap for gap in gaps)
    return from_azimuth(r, R, a, -b, rng.uniform(0, math.pi))


def nearly_conjugate(rng):
    """Draw ends on opposite sides of a ring's outer equator, about a conjugate point apart."""
    r, R = ring(rng)
    a, b = ends(rng, log(rng, 1e-6, 0.1))
    return Start(r, R, a, -abs(b), "wave", mpf(rng.choice([-1, 1]) * log(rng, 1e-6, 0.3)))


def along_the_outer_equator(rng):
    """Draw ends on a ring's outer equator before the conjugate point."""
    r, R = ring(rng)
    share = rng.choice([log(rng, 1e-9, 1), 1 - log(rng, 1e-6, 1e-1)])
    return Start(r, R, 0.0, 0.0, "equator", mpf(share * math.pi * math.sqrt(R / (r + R))))


def past_the_conjugate_point(rng):
    """Draw ends on a ring's outer equator so far apart that the geodesic leaves it."""
    r, R = ring(rng)
    return Start(r, R, 0.0, 0.0, "wave", mpf(-log(rng, 1e-3, 1) * math.pi * 0.999999))


def over_the_inner_equator(rng):
    r, R = ring(rng)
    a = rng.uniform(math.pi / 2, math.pi)
    b = -rng.uniform(math.pi - a, a)
    return Start(r, R, a, b, "over", (mpf(r) - R) * (1 - mpf(log(rng, 1e-6, 1))))


def near_the_inner_equator(rng):
    """Draw both ends within 1e-9 to 0.3 of a ring's inner equator, on one or both sides of it."""
    r, R = ring(rng)
    gaps = sorted(log(rng, 1e-9, 0.3) for _ in range(2))
    a, b = (RIM - gap for gap in gaps)
    if rng.random() < 0.5:
        return Start(r, R, a, -b, "over", (mpf(r) - R) * (1 - mpf(log(rng, 1e-12, 1))))
    return from_azimuth(r, R, a, b, math.pi / 2 + rng.choice([-1, 1]) * log(rng, 1e-6, 1))


def horn(rng):
    r = log(rng, 1e-3, 1e3)
    return from_azimuth(r, r, *ends(rng, 0.9 * RIM), rng.uniform(0, math.pi))


FAMILIES = {
    "working sheet": (500, working_sheet),
    "short": (160, short),
    "nearly meridional": (120, nearly_meridional),
    "meridional": (80, meridional),
    "on a parallel": (120, on_a_parallel),
    "vertex to vertex": (100, vertex_to_vertex),
    "near a node": (120, near_a_node),
    "near both nodes": (40, near_both_nodes),
    "nearly conjugate": (100, nearly_conjugate),
    "along the outer equator": (60, along_the_outer_equator),
    "past the conjugate point": (100, past_the_conjugate_point),
    "over the inner equator": (120, over_the_inner_equator),
    "near the inner equator": (120, near_the_inner_equator),
    "ring": (200, lambda rng: anywhere(rng, ring)),
    "horn": (100, horn),
    "spindle": (100, lambda rng: anywhere(rng, spindle)),
}
