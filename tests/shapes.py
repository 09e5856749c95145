"""What the tests of the torus share: tori of hard proportions, pairs and ways on them."""

import math

import numpy as np
from hypothesis import strategies as st

from tests.draws import log_uniform
from tunneller_lib.paths import direct_problem, geodesic_root
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

TORI = (
    Torus(1, 0.2),  # thin ring
    Torus(2, 1.5),
    Torus(1, 1),  # horn: the nodes meet in the centre
    Torus(0.08, 0.8),  # the machine's
    Torus(1e-4, 1),  # nearly a sphere
    Torus(3e-3, 1e-3),
    Torus(2e5, 1e6),
)
PROOFS = Torus(1, 2), TORI[3], Torus(3, 24), TORI[1]  # where numbers stand for symbols


# theta and phi at the machine's joint limits.
LOW = REFERENCE_MACHINE.theta_min, REFERENCE_MACHINE.phi_min
HIGH = REFERENCE_MACHINE.theta_max, REFERENCE_MACHINE.phi_max


def joint_pairs(n, seed=0):
    """Return random pairs of positions (2, n, 2) within the machine's joint limits."""
    return np.random.default_rng(seed).uniform(LOW, HIGH, (2, n, 2))


tori = st.builds(
    lambda size, ratio: Torus(size, size * ratio), log_uniform(1e-3, 1e6), log_uniform(0.2, 1e4)
)


def ends_at_limits(torus):
    """Return ends p, q (n, 2): near the outer equator, near nodes or the inner equator, level."""
    rim = math.acos(max(-torus.r / torus.R, -1))
    a = np.array([0, 1e-300, 1e-30, 1e-9, 0.3, *(rim - np.array([0.5, 1e-2, 1e-4, 1e-9]))])
    conjugate = math.pi / math.sqrt(1 + torus.r / torus.R)
    beside = conjugate * (1 + np.array([-1e-9, 1e-9]))
    turn = np.array([0, 5e-324, 1e-17, 1e-9, 1, *beside, 2.8, math.pi - 1e-9, math.pi])
    a, b, turn = np.meshgrid(a, [*a, *-a[1:]], turn)
    p, q = np.stack([0 * a, a], axis=-1), np.stack([turn, b], axis=-1)
    return p.reshape(-1, 2), q.reshape(-1, 2)


def ways_of(family, torus, a, b, unknowns, nodes=200):
    """Return c, turned angle, its rate and length (4, n) of ways of a class from phi = a to b.

    They are by so many nodes, or as many as the library takes: `nodes` None.
    """
    rules, room = geodesic_root.quadratures(torus.r > torus.R, ready=False), np.empty((3, 100))
    if nodes:
        count = [nodes // 2, nodes // 2]
        rules = [geodesic_root.rule(nodes)] * len(rules[0]), [count] * len(rules[0])
    ends = geodesic_root.ends_at(torus, a, b)
    found = []
    for u in unknowns:
        way = geodesic_root.way_of(family, torus, ends, float(u))
        whole = geodesic_root.integrate_way(torus, way, family, False, rules, room)
        found.append([way.c, *whole])
    return np.array(found).T


def half_swing(torus, c):
    """Return by how much geodesics turn from one crossing of the outer equator to the next, in rad.

    Clairaut's constant c (n,), in m, is above r - R, and at most r + R.
    """
    rules, edges, series = direct_problem.rules(ready=False), np.empty((3, 99)), [None, None]
    r, turned = torus.r / torus.R, []
    for sine in np.atleast_1d(c) / (torus.r + torus.R):
        cosine = math.sqrt((1 - sine) * (1 + sine))
        orbit, start = direct_problem.orbit_of(r, 0.0, (0.0, 1.0, r + 1), float(sine), cosine)
        panels = direct_problem.prepare(orbit, rules, edges, None, series)
        turned.append(direct_problem.begun_at(orbit, start, panels, rules[0], edges, series)[-1])
    return np.array(turned)


def eq2(r, R, x, y, z):
    """Return the left side of Eq. 2 as printed, in the arithmetic of its arguments."""
    return (x**2 + y**2 + z**2 - (r**2 + R**2)) ** 2 - (2 * r) ** 2 * (R**2 - y**2)


def off_surface(torus, points):
    """Return how far points (..., 3) are from the nearer of their two meridian circles."""
    x, y, z = np.moveaxis(points, -1, 0)
    rho = np.hypot(x, z)
    circles = [np.abs(np.hypot(rho - c, y) - torus.R) for c in (torus.r, -torus.r)]
    return np.minimum(*circles)
