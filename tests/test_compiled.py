"""Loops compiled by numba: the same bits as in plain Python, and only where the work is long."""

import os
import subprocess
import sys
from collections import Counter, defaultdict
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.audit.long import many
from tests.hard_lines import FAMILIES, KINDS, shape_of
from tests.shapes import ends_at_limits
from tunneller_lib.kernels import compiled
from tunneller_lib.motion import Compressible, Integrator, Lag, Loop, Push, Resonance, Rigid, follow
from tunneller_lib.motion.arm import weights
from tunneller_lib.motion.plant import ValveResonance
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.paths import (
    competing_geodesics,
    cutting_circuit,
    direct_problem,
    geodesic_direct,
    geodesic_inverse,
    inverse_problem,
)
from tunneller_lib.ream import Limits, plan
from tunneller_lib.ream.cutting import whole_run
from tunneller_lib.ream.face import Face
from tunneller_lib.removal import DexelGrid, Ground
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Rod, Torus, blocks

ROOT = Path(__file__).resolve().parents[1]
SIZES = usual_sizes(REFERENCE_MACHINE)
AXES = axes_of(REFERENCE_MACHINE, SIZES)
OILY = [Compressible(axis) for axis in AXES]
direct = geodesic_direct.unchecked  # which may get what has no answer, as from `Geodesic.points`
T = 5e-3
SHEET = REFERENCE_MACHINE.torus
RAMP = np.stack([0.1 * (1 - np.cos(np.linspace(0, 3, 300))), np.linspace(0.3, 0.1, 300)], axis=-1)
SLOPES = np.diff(RAMP, axis=0) / T
PLANTS = {
    "T0": Integrator(0.5),
    "T1": Lag(0.5, 0.02),
    "resonance": Resonance(0.5, 100.0, 0.15),
    "valve": ValveResonance(0.5, 0.45, 100.0, 0.15, 0.004),
    "T2": [Rigid(axis) for axis in AXES],
    "T3": OILY,
}
LOOPS = {
    "usual": Loop(10.0, T, feedforward=1.0, delay=1, count=2 * np.pi / 2**16),
    "integral": Loop(8.0, T, integral=5.0),
    "limited": Loop(30.0, T, delay=3, limit=0.05),
}


def go(way, monkeypatch):
    """Have loops compiled, or not, whatever work is expected meanwhile."""
    amount = np.inf if way else -np.inf
    monkeypatch.setattr(compiled._Work, "of_kind", defaultdict(lambda: amount))
    monkeypatch.setattr(compiled._Work, "compiled", way)
    assert compiled.ready("any") == way


@pytest.fixture
def both_ways(monkeypatch):
    """Return a function (call) -> its answers in plain Python and compiled."""
    pytest.importorskip("numba")

    def answers(call):
        found = []
        for way in (False, True):
            go(way, monkeypatch)
            found.append(call())
        return found

    return answers


def assert_same_bits(tracks):
    plain, fast = tracks
    for one, other in zip(plain.states, fast.states, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(plain.command, fast.command)
    np.testing.assert_array_equal(plain.energies, fast.energies)


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("plant", PLANTS)
def test_axes_have_the_same_bits_both_ways(plant, loop, both_ways):
    assert_same_bits(both_ways(lambda: follow(PLANTS[plant], LOOPS[loop], RAMP, slopes=SLOPES)))


def test_machine_in_ground_has_the_same_bits_both_ways(both_ways):
    rng = np.random.default_rng(1)
    push = Push(
        torque=(50.0, 0.0),
        damper=2e4 * rng.random(len(SLOPES)),
        lever=np.tile([0.88, 0.80], (len(SLOPES), 1)),
        across=rng.normal(0, 0.3, SLOPES.shape),
        drift=rng.normal(0, 0.02, (len(SLOPES), 3)),
    )
    given = dict(slopes=SLOPES, arm=arm_of(REFERENCE_MACHINE, SIZES), push=push)
    assert_same_bits(both_ways(lambda: follow(OILY, LOOPS["usual"], RAMP, **given)))


GRIDS = {
    "block": lambda: DexelGrid.cartesian((-1, -1, 0), (1, 1, 1), (40, 50)),
    "wall": lambda: DexelGrid.radial(-1, 1, 0.3, 1.0, (40, 60)),
    "fine wall": lambda: DexelGrid.radial(-1, 1, 0.3, 1.0, (400, 720)),  # more than one block
    "wall with gaps": lambda: DexelGrid.radial(-1, 1, 0.3, np.linspace(0.9, 0.3, 60), (40, 60)),
}
TURNING, STEPS = np.linspace(0, 7, 40), np.random.default_rng(3).uniform(-0.1, 0.1, (60, 3))
PATHS = {
    "ball": ([[0.1, 0.2, 0.5]], 0.2),
    "short moves": (np.add(np.cumsum(STEPS, axis=0), (0, 0.3, 0.4)), 0.2),
    "long moves": (np.random.default_rng(4).uniform(-1, 1, (many(12, 30), 3)), 0.05),
    "round and round": (
        np.stack([TURNING / 20, 0.7 * np.cos(TURNING), 0.7 * np.sin(TURNING)], axis=-1),
        0.1,
    ),
    # At rest, along lines of the block, about the axis of the wall, and outside of the material.
    "special moves": (
        [[0, 0, 0.2], [0, 0, 0.2], [0, 0, 0.7], [0.01, 0, 0.6], [-0.5, 0, 0], [0, 0, 0],
         [0.2, 0, 0.01], [0.5, 0, 0], [5, 0.7, 0.5], [5, 0.6, 0.9], [0, 0.6, 0.9]], 0.1,
    ),
    "clear": ([[9, 9, 9], [9, 9, 8]], 0.1),
}  # fmt: skip


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("grid", GRIDS)
def test_grid_is_cut_to_the_same_bits_both_ways(grid, path, both_ways):
    centres, radius = PATHS[path]

    def run():
        cut = GRIDS[grid]()
        removed = cut.cut_path(centres, radius)
        return cut, [removed, cut.cut_path(np.add(centres, (0.03, 0.02, -0.01)), radius)]

    (plain, removed), (fast, removed_fast) = both_ways(run)
    assert removed == removed_fast and (path == "clear") == (sum(removed) == 0)
    np.testing.assert_array_equal(plain.low, fast.low)
    np.testing.assert_array_equal(plain.high, fast.high)


@pytest.mark.parametrize("kind", KINDS)
def test_lines_have_the_same_bits_both_ways(kind, both_ways):
    rng = np.random.default_rng(12)
    drawn = [family(kind, rng, 12) for family in FAMILIES]
    shapes, points, directions = map(np.concatenate, zip(*drawn, strict=True))

    def run():
        solids = [shape_of(kind, row) for row in shapes]
        lines = list(zip(solids, points, directions, strict=True))
        # Each with its own line alone, with all lines, with one direction or one point for all.
        return [
            [solid.meet_line(p, u) for solid, p, u in lines],
            [solid.meet_line(points, directions) for solid in solids[::7]],
            [solid.meet_line(p[None], directions) for solid, p, _ in lines[::7]],
            [solid.meet_line(points[:, None], u[None, None]) for solid, _, u in lines[::7]],
        ]

    plain, fast = both_ways(run)
    for one, other in zip(plain, fast, strict=True):
        assert np.array(one).tobytes() == np.array(other).tobytes()
    assert np.isfinite(plain[0]).any() and np.isinf(plain[0]).any()


def test_ground_that_is_cut_has_the_same_bits_both_ways(both_ways):
    """With ripple, in a step sideways, and where ground is split and a run is resumed."""
    circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    concrete = Ground(20e6, 2.0, normal=0.5, ripple=0.3, ripple_frequency=12.0)
    limits = Limits(feed=0.1, acceleration=0.5, power=3000, ground=concrete)
    made = plan(circuit, limits, tolerance=1e-3, laps=2, advance=0.04)
    values, slopes = whole_run(made)
    first = int(made.entry.ticks.sum())
    step = first + int(made.ticks.sum()) - len(made.back) + 1
    loop = replace(LOOPS["usual"], delay=2, integral=3.0)  # which remember what went before
    slots = []

    def run(begin, full):
        part = slice(begin, begin + 40)
        run_values = values[begin : begin + 41]
        face = Face(made, concrete, run_values, first - begin, (60, 240), 0.1)
        face.wall.cut_path(made.centres(run_values[:1]), 0.2)
        if full:  # a thin layer within the tunnel, and the ground behind it
            face.wall.low[0] -= 0.03
            split = face.wall.low[0] + 0.005
            face.wall.add_slot()
            face.wall.low[1], face.wall.high[1] = split + 0.005, face.wall.high[0]
            face.wall.high[0] = split
        track = follow(OILY, loop, run_values, slopes=slopes[part], push=face,
                       arm=arm_of(REFERENCE_MACHINE, SIZES))  # fmt: skip
        slots.append(len(face.wall.low))
        return track, face

    for begin, full in ((first - 20, False), (step, False), (first + 400, True)):
        (plain, one), (fast, other) = both_ways(lambda begin=begin, full=full: run(begin, full))
        assert_same_bits((plain, fast))
        np.testing.assert_array_equal(one.force, other.force)
        np.testing.assert_array_equal(one.wall.low, other.wall.low)
        np.testing.assert_array_equal(one.wall.high, other.wall.high)
        assert one.removed.sum() > 0


TORI = {
    "machine": SHEET,
    "spindle": Torus(0.3, 1),
    "horn": Torus(1, 1),
    "ring": Torus(3, 1),
    "thin ring": Torus(3e4, 7),
    "nearly a sphere": Torus(1e-9, 1),
    "nearly a horn": Torus(0.99999, 1),
}


@pytest.mark.parametrize("name", TORI)
def test_geodesics_have_the_same_bits_both_ways(name, both_ways):
    torus, rng = TORI[name], np.random.default_rng(5)
    ends = np.stack(ends_at_limits(torus), axis=1)
    p, q = rng.choice(ends, many(24, 400), replace=False).swapaxes(0, 1)
    q[::11] = p[::11]
    p[5::41, 0] += 1e9
    plain, fast = both_ways(
        lambda: (geodesic_inverse(torus, p, q), competing_geodesics(torus, p[::8], q[::8]))
    )
    assert len(set(plain[0].kind_code)) >= 3
    for field in ("length", "azimuth1", "azimuth2", "clairaut", "kind_code", "certificate_code"):
        for known, found in zip(plain, fast, strict=True):
            np.testing.assert_array_equal(getattr(known, field), getattr(found, field))


@pytest.mark.parametrize("name", TORI)
@pytest.mark.parametrize("n", [2, 6])
def test_points_of_geodesics_have_the_same_bits_both_ways(name, n, both_ways):
    """From starts anywhere and on the equator, by all azimuths, along lengths of all sizes."""
    torus, rng, size = TORI[name], np.random.default_rng(6), many(180, 400)
    p = rng.uniform(-4, 4, (size, 2)) * rng.choice([(1, 1), (1, 0)], size)
    straight = rng.choice([0, np.pi, np.pi / 2, 1e-14], size)
    azimuth = np.where(rng.random(size) < 0.7, rng.uniform(-9, 9, size), straight)
    if torus.r > torus.R:  # c is next to r - R, round the tube and not
        close = np.arcsin((torus.r - torus.R) / (torus.r + torus.R))
        near = rng.choice([-1, 1], size // 9) * 10 ** rng.uniform(-16, -3, size // 9)
        p[8::9, 1] = 0
        azimuth[8::9] = close * (1 + near)
    sizes = rng.choice([1, 1, 1, 1, 0, 1e9, 1e-200, np.nan], size)
    length = torus.R * rng.uniform(-9, 9, size) * sizes
    plain, fast = both_ways(lambda: direct(torus, p, azimuth, length, n))
    assert 0.1 < np.isfinite(plain.azimuth[:, -1]).mean() < 1
    np.testing.assert_array_equal(plain.position, fast.position)
    np.testing.assert_array_equal(plain.azimuth, fast.azimuth)


def child(code, **variables):
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, text=True,
                          capture_output=True, env=os.environ | variables).stdout  # fmt: skip


SHORT = """
import sys
import numpy as np
from tunneller_lib.motion import Lag, Loop, follow
follow(Lag(0.5, 0.02), Loop(10.0, 5e-3), np.zeros(1000))
print("numba" in sys.modules)
"""


@pytest.mark.parametrize("cores", [1, 2, 7])
def test_blocks_have_the_same_bits_on_any_number_of_cores(cores, monkeypatch):
    numba = pytest.importorskip("numba")
    go(True, monkeypatch)
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", cores)
    monkeypatch.setattr(inverse_problem, "BLOCK", 100)
    monkeypatch.setattr(direct_problem, "BLOCK", 100)
    monkeypatch.setattr(blocks, "COMPILED", 100)
    rng = np.random.default_rng(5)
    p, q = rng.uniform(-1, 1, (2, 730, 2))
    point, direction = rng.normal(size=(2, 730, 3))
    rod = Rod((0, 0, 0), (0.5, 0.4, 0.3), 0.2)

    def answers(i):
        way = geodesic_inverse(SHEET, p[i], q[i])
        ends = geodesic_direct(SHEET, p[i], way.azimuth1, way.length, 3).position
        return way.length, way.azimuth1, ends, *rod.meet_line(point[i], direction[i])

    together = answers(slice(None))
    for i in (0, 99, 100, 729):
        for every, one in zip(together, answers(i), strict=True):
            np.testing.assert_array_equal(every[i], one)


def test_little_work_loads_no_compiler():
    assert child(SHORT).split() == ["False"]


def test_compiler_is_loaded_where_the_work_is_long(monkeypatch):
    monkeypatch.setattr(compiled._Work, "of_kind", Counter())
    monkeypatch.setattr(compiled._Work, "compiled", False)
    compiled.expect(0.9 * compiled.LONG, "axes")
    assert not compiled._Work.compiled
    monkeypatch.setitem(sys.modules, "numba", None)
    compiled.expect(compiled.LONG, "axes")
    assert not compiled._Work.compiled  # nothing to be had
    monkeypatch.setitem(sys.modules, "numba", ModuleType("numba"))
    compiled.expect(0.0, "axes")
    assert compiled._Work.compiled


BROKEN = """
import numpy as np
from tunneller_lib.kernels import compiled
from tunneller_lib.motion import Lag, Loop, follow
compiled.expect(2 * compiled.LONG, "axes")
print(follow(Lag(0.5, 0.02), Loop(10.0, 5e-3), np.zeros(10)).command.sum(), compiled.ready("axes"))
"""


@pytest.mark.parametrize("error", ["RuntimeError('no locator')", "OSError(28, 'No space')"])
def test_a_numba_that_does_not_work_is_as_none(error, tmp_path):
    (tmp_path / "numba.py").write_text(f"raise {error}\n")
    assert child(BROKEN, PYTHONPATH=str(tmp_path)).split() == ["0.0", "False"]


SPOILT = """
import os, pickle
from pathlib import Path
from tunneller_lib.kernels import compiled
from tunneller_lib.kernels.elementwise import lesser
compiled._Work.compiled = True

def files():
    return sorted(path for path in Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nb?"))

for content in (None, b"", b"no pickle at all", pickle.dumps(42)):
    for path in files() if content is not None else ():
        path.write_bytes(content)
    compiled._compiled.cache_clear()  # as the next command
    assert compiled.call(lesser, 3.0, 2.0) == compiled.call(lesser, 2.0, 5.0) == 2
assert files()
"""


def test_a_kept_form_that_is_cut_short_or_another_loses_no_answer(tmp_path):
    pytest.importorskip("numba")
    child(SPOILT, NUMBA_CACHE_DIR=str(tmp_path))


def test_other_compiler_runs_what_numba_does_not(monkeypatch):
    for name, value in (("compiled", False), ("other", None)):
        monkeypatch.setattr(compiled._Work, name, value)
    asked = []
    compiled.replace_plain(lambda *given, **parts: asked.append((given, parts)))
    compiled.call(weights, 1, 2, part=len)
    assert asked == [((weights, 1, 2), {"part": len})]


def test_a_number_of_another_module_makes_a_compiled_loop_anew(monkeypatch):
    pytest.importorskip("numba")
    names = []
    for value in (1.0, 2.0):
        monkeypatch.setitem(globals(), "AS_IF_IMPORTED", value)
        compiled._compiled.cache_clear()
        names.append(compiled._compiled(scaled).py_func.__qualname__)
    assert names[0] != names[1]


def scaled(x):
    return x * AS_IF_IMPORTED  # noqa: F821 - set by the test
