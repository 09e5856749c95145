"""How fast a grid of intervals is cut: a circuit of ticks, and one cut against a mesh library.

manifold3d subtracts balls from a block as meshes; both sides are brought to the same error of the
volume, which is known, before their times are compared.
"""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Rod

TICKS = 10_000


def test_circuit_of_ticks_on_rays(benchmark, say):
    egg = Egg(0.5)
    angle = (np.arange(720) + 0.5) * np.pi / 360
    low, high = np.zeros(720), np.full(720, 1.5)
    for _ in range(60):
        middle = (low + high) / 2
        inside = egg.depth(middle * np.cos(angle), middle * np.sin(angle)) > 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    s = np.linspace(0, egg.offset(REFERENCE_MACHINE.offset).perimeter, TICKS + 1)
    circuit = cutting_circuit(REFERENCE_MACHINE, egg)
    _, centres = circuit.arm(circuit.position(s))

    def cut():
        tunnel = DexelGrid.radial(0.3, 1.2, low, low + 0.1, (400, 720))
        return tunnel.cut_path(centres, REFERENCE_MACHINE.cutter_radius)

    assert benchmark.pedantic(cut, rounds=1) > 0
    say("10 000 capsules on 400 x 720 rays, s", best_times(cut, rounds=3)[0])


@pytest.mark.parametrize("package", ["manifold3d"])
def test_cut_against_manifold(installed, benchmark, say, package):
    manifold = installed.Manifold
    radius, n = 0.7, 120
    exact = 4 / 3 * np.pi * radius**3
    places = np.random.default_rng(0).uniform(-0.01, 0.01, (8, 3))

    def grid(place):
        return DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (n, n)).cut(
            Rod(place, place, radius, ends="round")
        )

    error = np.sqrt(np.mean([(grid(p) / exact - 1) ** 2 for p in places]))
    block = manifold.cube((2, 2, 2), True)
    for sides in range(16, 4096, 16):
        ball = manifold.sphere(radius, sides)
        if abs((8 - (block - ball).volume()) / exact - 1) <= error:
            break
    benchmark.pedantic(grid, (places[0],), rounds=5)

    def mesh():
        return (manifold.cube((2, 2, 2), True) - manifold.sphere(radius, sides)).volume()

    ours, theirs = best_times(lambda: grid(places[0]), mesh, rounds=7)
    say("relative error of both, in millionths", 1e6 * error)
    say(f"time of manifold3d with {sides} sides over that of the grid", theirs / ours, package)
    assert theirs >= 10 * ours
    many = np.random.default_rng(1).uniform(-0.7, 0.7, (60, 3))

    def cut_many():
        whole = DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (n, n))
        for place in many:
            whole.cut(Rod(place, place, 0.25, ends="round"))
        return whole.volume

    def cut_many_meshes():
        whole = manifold.cube((2, 2, 2), True)
        for place in many:
            whole -= manifold.sphere(0.25, sides).translate(place)
        return whole.volume()

    ours, theirs = best_times(cut_many, cut_many_meshes, rounds=3)
    say("the same for sixty cuts one after the other", theirs / ours, package)
