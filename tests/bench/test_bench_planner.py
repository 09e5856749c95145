"""The planner against toppra (paths, no jerk) and ruckig (moves from rest to rest, with jerk)."""

import time

import numpy as np
import pytest
import ruckig
import toppra
import toppra.algorithm
import toppra.constraint

from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, plan
from tunneller_lib.ream.timing import move_shares, move_ticks
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TICK = 1e-3


class OnRoute(toppra.interpolator.AbstractGeometricPath):
    """A route as toppra wants a path."""

    def __init__(self, route):
        self.route = route

    dof = 2

    @property
    def path_interval(self):
        return np.array([0.0, self.route.length])

    @property
    def waypoints(self):
        return None

    def __call__(self, places, order=0):
        return self.route.at(np.asarray(places), order=order)


def of_toppra(route, speed, acceleration):
    toppra.setup_logging("ERROR")
    joint = np.array([[-1.0, 1.0]] * 2)
    bounds = [
        toppra.constraint.JointVelocityConstraint(speed * joint),
        toppra.constraint.JointAccelerationConstraint(acceleration * joint),
    ]
    places = np.unique(np.concatenate([np.linspace(0, route.length, 4001), route.ends]))
    solver = toppra.algorithm.TOPPRA(bounds, OnRoute(route), gridpoints=places)
    return solver.compute_trajectory(0, 0).duration


@pytest.mark.parametrize("speed, acceleration", [(0.2, 0.5), (0.3, 2.0), (1.0, 0.2)])
@pytest.mark.parametrize("blend", [1e-4, 5e-4])
def test_laps_last_as_long_as_topras(say, speed, acceleration, blend):
    limits = Limits(feed=1e3, acceleration=1e6, joint_speed=speed, joint_acceleration=acceleration)
    begun = time.process_time()
    job = plan(CIRCUIT, limits, tolerance=1e-3, blend=blend, tick=TICK, step=0.05, rest=0.0)
    ours = time.process_time() - begun
    lasts = job.lap_time - job.tick * int(job.ticks[-1])
    begun = time.process_time()
    theirs = of_toppra(job.route, speed, acceleration)
    spent = time.process_time() - begun
    assert max(job.shares.values()) <= 1
    say(f"{speed} rad/s, {acceleration} rad/s^2, corners of {1e3 * blend} mm: s", lasts)
    say("the same by toppra, s", theirs)
    say("planned in CPU s", ours)
    say("toppra in CPU s", spent)
    assert abs(lasts / theirs - 1) < 0.02


def of_ruckig(distance, speed, acceleration, jerk):
    asked = ruckig.InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [distance]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = [speed], [acceleration], [jerk]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(asked, found)
    return found.duration


def test_single_moves_last_as_long_as_ruckigs(say):
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(2000):
        distance, speed, acceleration, jerk = 10.0 ** rng.uniform([-3, -2, -1, 0], [0, 0, 1, 2])
        theirs = of_ruckig(distance, speed, acceleration, jerk)
        ticks = move_ticks(distance, speed, acceleration, jerk, TICK)
        run = distance * move_shares(ticks)
        for order, limit in ((1, speed), (2, acceleration), (3, jerk)):
            change = np.diff(np.pad(run, 3, mode="edge"), n=order) / TICK**order
            assert np.abs(change).max() <= limit * (1 + 1e-6)
        ratios.append((len(run) - 1) * TICK / theirs)
    say("longest over ruckig's", max(ratios))
    say("in the median", float(np.median(ratios)))
    long = np.array(ratios)
    assert long.max() < 1.05 and long.min() > 0.98
