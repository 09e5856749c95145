"""Tunnelling robot, section 3.3: its claims about geodesics, one proof a claim."""

import numpy as np
import sympy as sp

from tunneller_lib.paths import (
    CHORD_PATHS,
    NODES_OF_WORKING_SHEET,
    competing_geodesics,
    geodesic_direct,
    geodesic_inverse,
    geodesic_root,
    path_length,
)
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

MACHINE = REFERENCE_MACHINE
LOW, HIGH = (MACHINE.theta_min, MACHINE.phi_min), (MACHINE.theta_max, MACHINE.phi_max)


def pairs(n):
    return np.random.default_rng(33).uniform(LOW, HIGH, (2, n, 2))


def test_several_geodesics():
    # They do meet on a ring; on the machine's sheet one is proved to be enough.
    ring = competing_geodesics(Torus(3, 1), (0, 0.8), (3.1, -0.3))
    assert ring.converged.all() and len(set(ring.length.round(6))) == 6
    assert geodesic_inverse(MACHINE.torus, *pairs(2000)).certified.all()


def test_geodesic_is_one_root():
    # Clairaut's integral follows from the equations; with it one unknown is left.
    s, r, R = sp.symbols("s r R", positive=True)
    phi, alpha = sp.Function("phi")(s), sp.Function("alpha")(s)
    rho = r + R * sp.cos(phi)
    turning = {phi.diff(s): sp.cos(alpha) / R, alpha.diff(s): sp.sin(phi) * sp.sin(alpha) / rho}
    assert sp.simplify(sp.diff(rho * sp.sin(alpha), s).subs(turning)) == 0
    p, q = pairs(2000)
    found = geodesic_inverse(MACHINE.torus, p, q)
    end = geodesic_direct(MACHINE.torus, p, found.azimuth1, found.length).point[:, -1]
    assert np.max(np.linalg.norm(end - MACHINE.torus.point(*q.T), axis=-1)) < 1e-12


def test_geodesic_by_no_trial():
    # Always found: near and far, on tori that differ by a thousand times.
    for ratio in (4, 40, 4000):
        found = geodesic_inverse(Torus(1 / ratio, 1), *pairs(20_000))
        assert found.converged.all() and found.certified.all()
    # A second way, without Clairaut: geodesics in a fan of directions meet the end's parallel
    # farther and farther round, so that there is one direction to find, and no other.
    torus, p, q = MACHINE.torus, (-0.9, -0.5), (0.3, 0.6)
    fan = np.linspace(0.02, 1.45, 60)
    ways = geodesic_direct(torus, p, fan, 3.0, 3001)
    met = []
    for theta, phi in np.moveaxis(ways.position, -1, 1):
        i = np.argmax(phi > q[1])
        met.append(np.interp(q[1], phi[i - 1 : i + 1], theta[i - 1 : i + 1]) if i else np.inf)
    met = np.array(met)
    reach = np.isfinite(met)
    assert reach[:40].all() and np.all(np.diff(met[reach]) > 0)
    direction = np.interp(q[0], met[reach], fan[reach])
    assert abs(direction - geodesic_inverse(torus, p, q).azimuth1) < 1e-3


def test_geodesic_in_real_time(monkeypatch):
    # A handful of short sums, once for a whole path: no search of unknown length.
    rounds = []

    def counted(torus, integrand, count):
        rounds.append(count)
        return integrate(torus, integrand, count)

    integrate = geodesic_root.integrate
    monkeypatch.setattr(geodesic_root, "integrate", counted)
    number = []
    for p, q in zip(*pairs(300), strict=True):
        rounds.clear()
        assert geodesic_inverse(MACHINE.torus, p, q).converged
        number.append(len(rounds))
    assert set(rounds) == {NODES_OF_WORKING_SHEET} and max(number) <= 5 and np.mean(number) < 3.5


def test_geodesic_is_approximated():
    p, q = pairs(2000)
    corners = np.array([(LOW, HIGH), (LOW, (HIGH[0], LOW[1]))]).swapaxes(0, 1)
    p, q = np.concatenate([p, corners[0]]), np.concatenate([q, corners[1]])
    torus = MACHINE.torus
    geodesic = geodesic_inverse(torus, p, q)
    excess = path_length(torus, CHORD_PATHS["tangent spheres"], p, q) / geodesic.length - 1
    path = CHORD_PATHS["tangent spheres"](torus, p, q, np.linspace(0, 1, 17))
    aside = np.max(np.abs(geodesic.points(65).deviation(path)), axis=-1)
    assert np.max(excess) < 5e-4 and np.median(excess) < 1e-6
    assert np.max(aside) < 0.0125 and np.median(aside) < 2e-4
    joint = path_length(torus, CHORD_PATHS["joint space"], p, q) / geodesic.length - 1
    assert np.median(joint) > 500 * np.median(excess)
    # About one middle, chords of half the length deviate an eighth as much.
    middle, half = (p + q)[:200] / 2, (q - p)[:200] / 2
    worst = []
    for part in (1 / 8, 1 / 16):
        ends = middle - part * half, middle + part * half
        track = CHORD_PATHS["tangent spheres"](torus, *ends, np.linspace(0, 1, 17))
        short = geodesic_inverse(torus, *ends).points(65).deviation(track)
        worst.append(np.max(np.abs(short), axis=-1))
    assert abs(np.median(np.log2(worst[0] / worst[1])) - 3) < 0.1
