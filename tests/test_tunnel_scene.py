"""The machine in the tunnel: the wall in stages, parts where the simulation has them, pictures."""

import numpy as np
import pytest

from exhibits.machine_scene import DARK
from exhibits.tunnel_scene import posed_machine, stages
from tests.scenes import small_scenes  # noqa: F401 - a fixture of all tests
from tunneller_lib.motion import Integrator, Loop
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, Pose, plan, simulate
from tunneller_lib.ream.wall import standing
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

EGG = Egg(0.5)
QUICK = Limits(feed=0.2, acceleration=0.5)
SHAPE = 60, 90


def simulated(pose=None, laps=1, **stance):
    circuit = cutting_circuit(REFERENCE_MACHINE, EGG, **stance)
    job = plan(circuit, QUICK, tolerance=1e-3, step=1e-2, rest=0.2, laps=laps, advance=0.04)
    return simulate(job, Integrator(1.0), Loop(10.0, job.tick, feedforward=1.0), pose=pose,
                    shape=SHAPE)  # fmt: skip


@pytest.fixture(scope="module")
def cut():
    return simulated(laps=2, pose=Pose(y=1e-3, yaw=1e-3))


def last(cut):
    return len(cut.centres) - 1


def test_stages_end_with_the_wall_and_begin_with_none_removed(cut):
    before, half, after = stages(cut, [0, last(cut) // 2, last(cut)])
    np.testing.assert_allclose(after.low, cut.wall.low, rtol=1e-14)
    np.testing.assert_allclose(after.high, cut.wall.high, rtol=1e-14)
    assert before.volume == pytest.approx(
        cut.wall.volume + cut.removed.sum() + cut.plunged, rel=1e-12
    )
    assert before.volume > half.volume > after.volume
    np.testing.assert_allclose(EGG.depth(*standing(before)[..., 1:].T), 0, atol=1e-12)


@pytest.mark.parametrize(
    "options",
    [{"laps": 2, "pose": Pose(y=3e-3, z=-2e-3, roll=0.01)},
     {"pitch": np.radians(2), "yaw": np.radians(1)}],
    ids=["stepped back and shifted", "tilted"],
)  # fmt: skip
def test_posed_machine_has_its_cutter_where_the_simulation_has_it(options):
    cut = simulated(**options)
    circuit = cut.plan.circuit
    for tick in (0, last(cut) // 3, last(cut)):
        dark = [np.reshape(mesh.bounds, (3, 2)) for mesh, look in posed_machine(cut, tick)
                if look is DARK]  # fmt: skip
        joint, cutter = dark[0].mean(axis=1), dark[-1]
        np.testing.assert_allclose(cutter.mean(axis=1), cut.centres[tick], atol=2e-4)
        assert np.ptp(cutter, axis=1).max() == pytest.approx(1.8 * 0.2, rel=2e-3)
        # The machine keeps its length: only the pose error moves it, and each lap steps back.
        back = cut.plan.advance * (tick > last(cut) // 2) * (cut.plan.laps - 1)
        off = joint - [-back, 0, circuit.machine.height]
        assert np.max(np.abs(off)) < (0.012 if "pose" in options else 5e-4)
