"""The planner against toppra, on the same way.

The criterion is the duration at equal limits, which both sides keep; then the processor time.
"""

import time

import numpy as np
import pytest

from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, plan
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TICK = 1e-3
# rad/s, rad/s^2, and by how much corners may be missed, in m.
LAPS = [(*limits, blend) for limits in ((0.2, 0.5), (0.3, 2.0), (1.0, 0.2))
        for blend in (1e-4, 5e-4)]  # fmt: skip


def toppra_run(toppra, route, speed, acceleration):
    """Return the duration that toppra gives a route under limits of both joints, in s."""
    from toppra import algorithm, constraint

    class OnRoute(toppra.interpolator.AbstractGeometricPath):
        dof = 2
        waypoints = None
        path_interval = np.array([0.0, route.length])

        def __call__(self, places, order=0):
            return route.at(np.asarray(places), order=order)

    toppra.setup_logging("ERROR")
    joint = np.array([[-1.0, 1.0]] * 2)
    bounds = [
        constraint.JointVelocityConstraint(speed * joint),
        constraint.JointAccelerationConstraint(acceleration * joint),
    ]
    places = np.unique(np.concatenate([np.linspace(0, route.length, 4001), route.ends]))
    solver = algorithm.TOPPRA(bounds, OnRoute(), gridpoints=places)
    return solver.compute_trajectory(0, 0).duration


def lap(speed, acceleration, blend):
    """Return our lap under limits of both joints, in rad/s and rad/s^2, corners rounded in m."""
    limits = Limits(feed=1e3, acceleration=1e6, joint_speed=speed, joint_acceleration=acceleration)
    return plan(CIRCUIT, limits, tolerance=1e-3, blend=blend, tick=TICK, step=0.05, rest=0.0)


def duration(job):
    """Return how long a lap takes without its rest, in s."""
    return job.lap_time - job.tick * int(job.ticks[-1])


@pytest.mark.parametrize("package", ["toppra"])
@pytest.mark.parametrize("speed, acceleration, blend", LAPS)
def test_laps_last_as_long_as_toppras(
    installed, benchmark, say, package, speed, acceleration, blend
):
    job = benchmark.pedantic(lap, args=(speed, acceleration, blend), rounds=3)
    lasts = duration(job)
    begun = time.process_time()
    theirs = toppra_run(installed, job.route, speed, acceleration)
    spent = time.process_time() - begun
    what = f"{speed} rad/s, {acceleration} rad/s^2, corners of {1e3 * blend} mm"
    say(f"duration over toppra's, {what}", lasts / theirs, package)
    say(f"toppra's CPU s, {what}", spent, package)
    assert max(job.shares.values()) <= 1 and abs(lasts / theirs - 1) < 0.02
