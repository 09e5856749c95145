"""The library's loops in JavaScript: what isn't translated is refused, and answers are Python's."""

import json
import math
import shutil
import subprocess

import numpy as np
import pytest

from report.live.javascript import Untranslated, script, take_back
from tunneller_lib.kernels.compiled import call_plain, cosine
from tunneller_lib.motion import Compressible, Integrator, Lag, Loop, Push, Resonance, Rigid
from tunneller_lib.motion.both_joints import PUSHED, least_parts, machine_of, parts_in
from tunneller_lib.motion.hydraulics import spool_at
from tunneller_lib.motion.plant import ValveResonance
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.motion.ticks import control_of, run_axis, run_joints
from tunneller_lib.removal import DexelGrid
from tunneller_lib.removal.sweep import LOOPS as OF_LINES
from tunneller_lib.removal.sweep import cut_moves, room_on
from tunneller_lib.surfaces import REFERENCE_MACHINE

NODE = shutil.which("node")
SIZES = usual_sizes(REFERENCE_MACHINE)
AXES = axes_of(REFERENCE_MACHINE, SIZES)
TICK = 5e-3
PLANTS = [
    Integrator(0.5),
    Lag(0.5, 0.02),
    Resonance(0.5, 100.0, 0.15),
    ValveResonance(0.5, 0.45, 100.0, 0.15, 0.004),
    Rigid(AXES[0]),
    Compressible(AXES[1]),
]
LOOPS = [
    Loop(10.0, TICK, feedforward=1.0, delay=1, count=2 * np.pi / 2**16),
    Loop(8.0, TICK, integral=5.0),
    Loop(30.0, TICK, delay=3, limit=0.05),
]
# Rows of floats are handed over in one piece, as a page's are.
RUN = """
const libm = Math;
const found = (() => {{ {script} }})();
const rows = (table) => (Array.isArray(table?.[0]) ? table.map((r) => Float64Array.from(r))
                                                   : Float64Array.from(table));
const whole = (fields) => Object.fromEntries(Object.entries(fields).map(([k, v]) => [k, taken(v)]));
const taken = ([kind, one]) => (kind === "rows" ? rows(one) : kind === "tuple" ? whole(one) : one);
const given = {given}.map(taken);
const answer = found(...given);
console.log(JSON.stringify([answer, ...{filled}.map((at) => given[at]).map((table) =>
  table[0]?.length ? table.map((r) => [...r]) : [...table])]));
"""


def as_json(one):
    if isinstance(one, tuple) and any(isinstance(part, np.ndarray) for part in one):
        names = one._fields
        return ["tuple", {name: as_json(part) for name, part in zip(names, one, strict=True)}]
    if isinstance(one, np.ndarray):
        return ["rows", one.tolist()]
    return ["value", with_names(one)]


def with_names(one):
    if hasattr(one, "_asdict"):
        return {name: with_names(value) for name, value in one._asdict().items()}
    return [with_names(value) for value in one] if isinstance(one, tuple) else one


def assert_same(function, given, filled, **parts):
    """Assert that Python and node fill the same rows of the arguments and answer alike."""
    text = RUN.format(
        script=script(function, **parts),
        given=json.dumps([as_json(one) for one in given]),
        filled=json.dumps(filled),
    )
    ran = subprocess.run([NODE], input=text, capture_output=True, text=True, check=True)
    answer, *rows = json.loads(ran.stdout)
    assert call_plain(function, *given, **parts) == answer
    for at, row in zip(filled, rows, strict=True):
        # Sine and tanh are node's own here: their last bits may differ.
        np.testing.assert_allclose(row, given[at], rtol=1e-9, atol=1e-12)


@pytest.mark.skipif(NODE is None, reason="node isn't installed")
@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("loop", LOOPS)
def test_axis_runs_in_javascript_as_in_python(plant, loop):
    setvalues = 0.1 + 0.05 * (1 - np.cos(np.linspace(0, 3, 101)))
    numbers = plant.numbers(TICK)
    start = tuple(map(float, plant.rest(0.1)))
    states = np.zeros((len(start), 101))
    states[:, 0] = start
    slopes = np.diff(setvalues) / TICK
    memory = np.zeros(1 + loop.delay)
    given = [numbers, control_of(loop), memory, start, setvalues, slopes, states, np.zeros(100)]
    assert_same(run_axis, given, [2, 6, 7], **plant.functions())
    assert np.ptp(given[6][0]) > 1e-3


@pytest.mark.skipif(NODE is None, reason="node isn't installed")
@pytest.mark.parametrize("shared", [False, True])
def test_both_joints_run_in_javascript_as_in_python(shared):
    arm = arm_of(REFERENCE_MACHINE, SIZES) if shared else None
    plants = [Compressible(axis) for axis in AXES]
    ramp = 1 - np.cos(np.linspace(0, 2, 41))
    setvalues = np.stack([0.1 + 0.02 * ramp, 0.2 - 0.01 * ramp], axis=-1)
    push = Push((200.0, 100.0), 2e4, (0.9, 0.8), (0.1, 0.2), (0.01, -0.02, 0.03))
    rows = np.array(np.broadcast_to(push.rows, (40, PUSHED)))
    weights = [None, None] if arm is None else arm.weight(setvalues[0]).tolist()
    starts = zip(plants, setvalues[0].tolist(), weights, strict=True)
    state = (*(tuple(map(float, plant.rest(*rest))) for plant, *rest in starts), (0.0,) * 5)
    states = np.zeros((41, 15))
    loops = LOOPS[:2]
    machine = machine_of(AXES, arm)
    parts = parts_in(machine, least_parts(AXES, TICK), rows, TICK)
    given = [
        machine, TICK, tuple(map(control_of, loops)), np.zeros((2, 2)), 0, state,
        setvalues, np.diff(setvalues, axis=0) / TICK, rows, parts,
        states, np.zeros((40, 2)),
    ]  # fmt: skip
    assert_same(run_joints, given, [3, 10, 11], commanding=spool_at)
    assert np.all(states[1:, 10] > 0)


@pytest.mark.skipif(NODE is None, reason="node isn't installed")
@pytest.mark.parametrize("rays", [False, True])
def test_moves_are_cut_in_javascript_as_in_python(rays):
    grid = (DexelGrid.radial(-0.4, 0.4, 0.3, 0.6, (12, 40)) if rays
            else DexelGrid.cartesian((-0.4, -0.4, 0), (0.4, 0.4, 0.6), (12, 14)))  # fmt: skip
    for _ in range(3):  # since lines are split
        grid.add_slot()
    way = np.cumsum(np.random.default_rng(2).uniform(-0.1, 0.1, (12, 3)), axis=0)
    given = [
        grid.rows,
        np.add(way, (0.0, 0.2, 0.3)),
        0.12,
        0,
        np.zeros(11),
        room_on(grid.rows, 400),
    ]
    assert_same(cut_moves, given, [4], **OF_LINES)
    assert given[4].sum() > 0


MARGIN = np.radians(2)
ENDLESS = math.inf
SWITCH = True


def with_constants(x):
    """Use numbers of a module: numpy's, none that ends, a truth."""
    return x + MARGIN if SWITCH and x < ENDLESS else -1.5


@pytest.mark.skipif(NODE is None, reason="node isn't installed")
def test_constants_of_a_module_are_kept():
    assert_same(with_constants, [0.25], [])


def test_rows_of_any_numbers_are_taken_back():
    for dtype in (float, int, np.uint8):
        rows = np.zeros((2, 3), dtype)
        kept = rows[:]
        take_back(rows, memoryview(np.arange(6.0)))
        assert kept.tolist() == [[0, 1, 2], [3, 4, 5]] and kept.dtype == dtype


def with_list(numbers):
    """Make a list, which numba takes."""
    return [2 * number for number in numbers]


def with_power(x):
    """Take a power, whose last bit depends on who computes it."""
    return x**3


def with_chain(x):
    """Compare what is called for in the middle of a chain."""
    return 0 < cosine(x) < 1


def with_three(x):
    """Take the largest of three."""
    return max(x, 1.0, math.inf)


REFUSED = [with_list, with_power, with_chain, with_three, lambda x: x]


@pytest.mark.parametrize("function", REFUSED)
def test_what_is_not_translated_is_refused(function):
    with pytest.raises(Untranslated):
        script(function)
