"""The exported motion generator, compiled: what its contract says, scan by scan."""

import subprocess
from functools import cache

import numpy as np
import pytest

from tests.audit.long import many
from tests.controllers import (
    COMPILER,
    DISABLED,
    ERROR_STOP,
    FULL,
    HOLDING,
    MOVING,
    SANITIZERS,
    STANDSTILL,
    WIRED,
    Driven,
    build,
    c99_program,
    closed_loop,
    job_with,
    moved,
    with_program,
)
from tunneller_lib.job.controller_texts import c99_header, c99_text
from tunneller_lib.motion import follow
from tunneller_lib.ream.moves import levers

READS = ["tests/references/reference_job.toml"]

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-pedantic", "-O1")
pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler on this machine")


@cache
def job(plant="T0", feed=0.1, feedforward=1.0, **options):
    return job_with(
        controller={"plant": plant, "feedforward": feedforward}, limits={"feed": feed}, plan=options
    )


FINE = {"count": 2 * np.pi / 2**24}
TWO_LAPS = {"laps": 2, "advance": 0.03}
MADE = {}  # a job's program, and where it is compiled


@pytest.fixture
def started(tmp_path_factory):
    """Return a function that starts a job's controller, to which no sanitizer may object."""
    running = []

    def start(wanted):
        if id(wanted) not in MADE:
            made, folder = with_program(wanted), tmp_path_factory.mktemp("c")
            MADE[id(wanted)] = made, c99_program(COMPILER, folder, made, *STRICT, *SANITIZERS)
        program, path = MADE[id(wanted)]
        running.append(Driven(path))
        return program, running[-1]

    yield start
    assert [one.close() for one in running] == [0] * len(running)


class Machine:
    """A controller on axes that are where the set-values of the last scan were."""

    def __init__(self, wanted, made, driven):
        self.wanted, self.made, self.driven, self.c = wanted, made, driven, driven.c
        first = wanted.planned.entry.setvalues[0] / wanted.planned.count
        self.at = self.start = np.rint(first).astype(int)
        self.scans = 0
        self.rows = []
        self.paused = False

    def scan(self, count=1, **inputs):
        """Run some scans with these inputs; each is a row of set-values, state, valves, scale."""
        c = self.c
        c.__dict__.update(inputs)
        for _ in range(count):
            if self.scans % self.made.slow == 0 and not self.paused:
                self.driven.slow()
            c.nActualTheta, c.nActualPhi = self.at.tolist()
            self.driven.fast()
            if c.nState not in (DISABLED, ERROR_STOP):
                self.at = np.array([c.nSetTheta, c.nSetPhi])
            self.scans += 1
            self.rows.append([c.nSetTheta, c.nSetPhi, c.nState, c.rValveTheta, c.rValvePhi,
                              c.nScale, c.bEnable, c.bBusy])  # fmt: skip
        return c

    def go(self, *, scans=1000):
        """Start, and run for some scans."""
        self.scan(bEnable=1)
        self.scan(bStart=1)
        return self.scan(scans, bStart=0)


@pytest.fixture
def machine(started):
    return lambda wanted=None: Machine(wanted or job(), *started(wanted or job()))


def kept(rows, wanted):
    """Assert what holds whatever is done, of rows of a `Machine`."""
    rows = np.array(rows)
    plan = wanted.planned
    body = plan.circuit.machine
    live = (rows[:, 2] > DISABLED) & (rows[:, 2] < ERROR_STOP)
    assert not rows[~live, 3:5].any() and not rows[rows[:, 6] == 0, 3:5].any()
    assert np.abs(rows[:, 3:5]).max() <= 1
    assert np.all((rows[:, 5] >= 0) & (rows[:, 5] <= FULL))
    position = plan.count * rows[:, :2]
    busy = rows[:, 7] == 1
    assert np.all(position[busy] >= [body.theta_min, body.phi_min])
    assert np.all(position[busy] <= [body.theta_max, body.phi_max])
    lever = levers(body.torus, position)
    rounding = plan.count * np.hypot(*lever.max(axis=0))  # each set-value is off by up to a count
    bounds = plan.limits.feed * plan.tick, plan.limits.acceleration * plan.tick**2
    for order, most in enumerate(bounds, start=1):
        change = lever[1 : len(lever) + 1 - order] * np.diff(position, order, axis=0)
        together = np.all([live[k : len(live) - order + k] for k in range(order + 1)], axis=0)
        found = np.linalg.norm(change, axis=-1)[together].max(initial=0)
        assert found <= most + 2 * order * rounding


# On time


@pytest.mark.parametrize(
    ("wanted", "scans"),
    [(job(), None), (job(path="corrected chord", feedforward=0.8), None), (job("T3"), 1500)],
    ids=["T0", "corrected", "T3"],
)
def test_run_on_time_is_the_librarys_to_a_tick(started, wanted, scans):
    plan = wanted.planned
    setvalues, slopes = moved(plan)
    made, controller = started(wanted)
    found = closed_loop(controller, wanted, made, scans or len(slopes) + 300)
    running = (found[:, 8] == 1) & (found[:, 9] == FULL) & (found[:, 7] == 0)
    begin = int(np.flatnonzero(running)[0])
    if not scans:
        end = int(np.flatnonzero(found[:, 7])[0])
        assert end - begin == len(slopes)
    run = slice(begin, scans or end)
    whole = np.rint(setvalues / plan.count)[: run.stop - begin]
    np.testing.assert_array_equal(found[run, :2], whole)
    # Its loops are the library's, from the first scan on.
    track = follow(*wanted.axes, plan.count * np.vstack([found[:, :2], found[-1, :2]]),
                   slopes=found[:, 10:])  # fmt: skip
    assert np.abs(found[:, 2:4] - track.position[:-1]).max() < 1e-12
    assert np.abs(found[:, 4:6] - track.command).max() < 1e-12


# The table of behaviour


def test_nothing_moves_at_power_on_or_while_disabled(machine):
    one = machine()
    c = one.scan(20, bStart=1)  # a start that is there from the first scan on is no edge
    assert c.nState == DISABLED and not c.bBusy
    one.at = one.at + np.array([300, -200])  # moved by hand
    c = one.scan(5)
    assert [c.nSetTheta, c.nSetPhi] == one.at.tolist() and c.rValveTheta == c.rValvePhi == 0
    c = one.scan(50, bEnable=1)
    assert c.nState == STANDSTILL and [c.nSetTheta, c.nSetPhi] == one.at.tolist()


def test_start_away_from_the_start_position_is_an_error_and_never_a_jump(machine):
    one = machine()
    one.at = one.at + 2000
    one.scan(3, bEnable=1)
    c = one.scan(5, bStart=1)
    assert (c.nState, c.bError, c.nErrorId) == (ERROR_STOP, 1, 3)
    assert [c.nSetTheta, c.nSetPhi] == one.at.tolist() and c.rValveTheta == c.rValvePhi == 0
    assert one.scan(2, bEnable=0, bStart=0).nState == ERROR_STOP
    c = one.scan(2, bReset=1)
    assert (c.nState, c.bError, c.nErrorId) == (DISABLED, 0, 0)
    assert one.scan(2, bEnable=1).nState == STANDSTILL


@pytest.mark.parametrize("how", [{"bHold": 1}, {"nOverride": 0}, {"nOverride": -400}])
@pytest.mark.parametrize("when", [3, 60, 700])
def test_hold_stops_in_every_state_and_goes_on_by_an_edge_of_start_alone(machine, how, when):
    one = machine(job(**FINE))
    one.go(scans=when)
    c = one.scan(400, **how)
    assert c.nState == HOLDING and c.nScale == 0 and c.bBusy
    stood = c.nSetTheta, c.nSetPhi
    assert one.scan(bStart=1).nState == HOLDING  # held still
    c = one.scan(100, bHold=0, nOverride=256, bStart=0)
    assert c.nState == HOLDING and (c.nSetTheta, c.nSetPhi) == stood
    c = one.scan(300, bStart=1)
    assert c.nState == MOVING and (c.nSetTheta, c.nSetPhi) != stood
    kept(one.rows, one.wanted)


def test_disabling_is_at_once_and_gives_the_run_up(machine):
    one = machine()
    one.go()
    c = one.scan(bEnable=0)
    assert (c.nState, c.rValveTheta, c.rValvePhi, c.bBusy) == (DISABLED, 0, 0, 0)
    c = one.scan(200, bEnable=1)
    assert c.nState == STANDSTILL and not c.bBusy
    c = one.scan(2, bStart=1)
    assert (c.nState, c.nErrorId) == (ERROR_STOP, 3)


@pytest.mark.parametrize("fault", ["frozen", "theta jumps", "phi jumps", "wrapped"])
def test_encoder_that_freezes_jumps_or_wraps_shuts_the_valves(machine, fault):
    one = machine()
    one.go()
    stays = one.at.copy()
    jumps = {"theta jumps": (5000, 0), "phi jumps": (0, 5000), "frozen": (0, 0),
             "wrapped": (2**31 - 1 - one.at[0], 0)}  # fmt: skip
    lever = one.wanted.planned.circuit.machine.R
    moved_by = 0.0
    for _ in range(400):
        one.at = (stays if fault == "frozen" else one.at) + jumps[fault]
        c = one.scan()
        if c.nState == ERROR_STOP:
            break
        moved_by = np.abs(one.at - stays).max() * one.wanted.planned.count * lever
    assert (c.nState, c.rValveTheta, c.rValvePhi) == (ERROR_STOP, 0, 0)
    assert c.nErrorId == (2 if fault == "phi jumps" else 1)
    assert moved_by < 1.3 * one.made.trip
    if fault != "frozen":
        assert one.rows[-2][2] == MOVING  # within a scan
    one.at = stays
    c = one.scan(3, bReset=1)
    assert c.nState == STANDSTILL and [c.nSetTheta, c.nSetPhi] == stays.tolist()


def test_laps_wait_for_the_step_and_a_run_may_begin_again(machine):
    one = machine(job(**FINE, **TWO_LAPS, tolerance=5e-3))
    one.go(scans=0)
    while not one.c.bStepRequest:
        one.scan(bStepDone=1)  # of an earlier step: no edge
    stood = one.c.nSetTheta, one.c.nSetPhi
    c = one.scan(300)
    assert c.bStepRequest and c.bBusy and (c.nSetTheta, c.nSetPhi) == stood
    # A hold amid the step neither takes the request back nor asks for another one.
    c = one.scan(3, bHold=1, bStepDone=0)
    assert c.bStepRequest and c.nState == HOLDING
    c = one.scan(300, bStepDone=1)
    assert not c.bStepRequest and (c.nState, c.nScale) == (HOLDING, 0)
    assert (c.nSetTheta, c.nSetPhi) == stood
    one.scan(bHold=0)
    c = one.scan(500, bStart=1)
    assert not c.bStepRequest and (c.nSetTheta, c.nSetPhi) != stood
    while not one.c.bDone:
        one.scan(bStepDone=0, bStart=0)
    assert (c.nState, c.bBusy, c.bError) == (STANDSTILL, 0, 0)
    # It withdrew; the machine's own program brings the axes back to the start position.
    one.scan(bEnable=0)
    one.at = one.start
    c = one.go(scans=1500)
    assert (c.nState, c.bBusy, c.bDone) == (MOVING, 1, 0)
    kept(one.rows, one.wanted)


@pytest.mark.parametrize("feed", [0.1, 0.005])
def test_start_within_the_trip_goes_straight_to_the_start_position(machine, feed):
    """However slow the feed."""
    wanted = job(feed=feed, step=2e-3, **FINE)
    one = machine(wanted)
    one.at = one.start + int(0.9 * one.made.trip / wanted.planned.count / 0.88)
    one.scan(3, bEnable=1)
    c = one.scan(2, bStart=1)
    while c.nTick < 0:
        c = one.scan()
    assert np.abs([c.nSetTheta, c.nSetPhi] - one.start).max() <= 1  # a half may go either way
    kept(one.rows, wanted)
    # A way twice as long is gone at half of the feed: a set-value may be off by a trip, too.
    way = wanted.planned.count * np.array(one.rows)[2:, :2]
    moves = levers(wanted.planned.circuit.machine.torus, way[1:]) * np.diff(way, axis=0)
    assert np.linalg.norm(moves, axis=-1).max() < 0.25 * feed * wanted.planned.tick


# A slow task that is late


@pytest.mark.parametrize(("when", "pause"), [(420, 1500), (700, 50), (700, 400), (2500, 1500)])
def test_starved_line_comes_to_rest_within_the_acceleration_and_goes_on(machine, when, pause):
    wanted = job(**FINE)
    one = machine(wanted)
    one.go(scans=when)
    one.paused = True
    one.scan(pause)
    if pause == 1500:
        assert one.rows[-300][:2] == one.rows[-1][:2] and one.c.nState == MOVING
    one.paused = False
    while not one.c.bDone:
        one.scan()
    kept(one.rows, wanted)
    # No place is left out: the set-values run along the plan's.
    every = np.rint(moved(wanted.planned)[0] / wanted.planned.count)
    run = np.array([row[:2] for row in one.rows if row[7]])
    steps = np.abs(np.diff(run, axis=0)).max(axis=0)
    assert np.all(steps <= np.abs(np.diff(every, axis=0)).max(axis=0) + 1)
    for axis in range(2):
        # Where time is scaled the furthest place may be between two scans.
        assert abs(run[:, axis].min() - every[:, axis].min()) < 10
        assert abs(run[:, axis].max() - every[:, axis].max()) < 10


@pytest.mark.parametrize("seed", range(many(2, 50)))
def test_whatever_is_pressed_every_scan_keeps_what_is_promised(machine, seed):
    """Random inputs, overrides from -1000 to 1000, encoders that fail, a slow task that pauses."""
    wanted = job(**FINE, **TWO_LAPS, tolerance=5e-3)
    one = machine(wanted)
    rng = np.random.default_rng(seed)
    left = 0  # scans of a pause
    states = set()
    for _ in range(1000):
        chance = rng.random(8)
        given = {
            "bEnable": int(chance[0] < 0.998), "bHold": int(chance[1] < 0.03),
            "bReset": int(chance[2] < 0.3), "bStart": int(chance[3] < 0.5),
            "bStepDone": int(chance[4] < 0.5),
        }  # fmt: skip
        if chance[5] < 0.3:
            given["nOverride"] = int(rng.choice([rng.integers(-1000, 1000), 256, 256]))
        if one.c.nState in (DISABLED, ERROR_STOP) or (one.c.nState == STANDSTILL and one.c.bDone):
            given["bEnable"] = int(one.c.nState != STANDSTILL)
            one.at = one.start + rng.integers(-3000, 3000, 2)  # jogged to about the start position
        elif chance[6] < 0.01:
            jumped = [rng.integers(-(2**20), 2**20), 2**31 - 1 - int(one.at[0])]
            one.at = one.at + np.array([int(rng.choice(jumped)), 0])
        left = int(rng.integers(1, 40)) if chance[7] < 0.01 else max(left - 1, 0)
        one.paused = left > 0
        one.scan(20, **given)
        states.add(one.c.nState)
    assert states >= {STANDSTILL, MOVING, HOLDING, ERROR_STOP}
    kept(one.rows, wanted)


INTERRUPTED = """
#include <signal.h>
#include <stdio.h>
#include <sys/time.h>
static T_Setpoint wanted[20000];
static volatile long points, wrong, inside, taken;
static volatile bool busy, comparing;
static int32_t ended;
static void scan(void)
{
    tunneller.bStart = !tunneller.bStart && !tunneller.bBusy;
    tunneller.bEnable = true;
    tunneller.bStepDone = tunneller.bStepRequest;
    if (tunneller.bDone) { tunneller.bEnable = false; }
    if (!tunneller.bBusy) {
        tunneller.nActualTheta = BEGIN_THETA;
        tunneller.nActualPhi = BEGIN_PHI;
    }
    fb_tunneller(&tunneller, &ring);
    tunneller.nActualTheta = tunneller.nSetTheta;
    tunneller.nActualPhi = tunneller.nSetPhi;
    if (tunneller.nTick < 0) { taken = 0; ended = 0; }
    if (tunneller.nTick >= 0 && tunneller.now.nEnd != ended) {
        ended = tunneller.now.nEnd;
        T_Setpoint *known = &wanted[taken++];
        if (!comparing) *known = tunneller.now;
        wrong += known->nTheta != tunneller.now.nTheta || known->nPhi != tunneller.now.nPhi;
        if (taken > points) points = taken;
    }
}
static void alarmed(int number)
{
    (void)number;
    if (busy) ++inside;
    /* Some scans an interruption, or the slow task would mostly wait. */
    for (int i = 0; i < 40; ++i) scan();
}
int main(void)
{
    while (!tunneller.bDone) { fb_setpoints(&setpoints, &ring); scan(); }
    scan();
    comparing = true;
    inside = 0;
    struct itimerval often = {{0, 150}, {0, 150}};
    signal(SIGALRM, alarmed);
    setitimer(ITIMER_REAL, &often, 0);
    while (inside < INTERRUPTIONS) {
        busy = true;
        fb_setpoints(&setpoints, &ring);
        busy = false;
    }
    signal(SIGALRM, SIG_IGN);
    printf("%ld %ld %ld %ld\\n", wrong, inside, points, (long)tunneller.nErrorId);
    return 0;
}
"""


@pytest.mark.parametrize("optimised", ["-O0", "-O2"])
def test_slow_task_may_be_interrupted_anywhere(tmp_path, optimised):
    """By a timer, at any instruction."""
    wanted = job(path="corrected chord", step=6e-4)  # a setpoint every scan or two
    made = with_program(wanted)
    (tmp_path / "controller.h").write_text(c99_header(made))
    first = np.rint(wanted.planned.entry.setvalues[0] / wanted.planned.count).astype(int)
    options = [f"-DBEGIN_THETA={first[0]}", f"-DBEGIN_PHI={first[1]}",
               f"-DINTERRUPTIONS={many(1_000, 50_000)}"]  # fmt: skip
    path = build(COMPILER, tmp_path, c99_text(made) + WIRED + INTERRUPTED, "-std=gnu99", optimised,
                 *options)  # fmt: skip
    done = subprocess.run([path], capture_output=True, text=True, timeout=600)
    wrong, inside, points, error = map(int, done.stdout.split())
    assert (wrong, error) == (0, 0) and inside >= many(1_000, 50_000) and points > 4000
