"""What a machine has, and what its loops need, before anything is planned."""

import numpy as np
import pytest

from tunneller_lib.motion import Compressible, Lag, Loop, reference_axes
from tunneller_lib.motion.sizing import usual_sizes
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, plan
from tunneller_lib.ream.ground_faults import ground_fault
from tunneller_lib.ream.margins import capability, gain_margins
from tunneller_lib.removal import Ground
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
AXES = reference_axes(REFERENCE_MACHINE)
PLANT = tuple(Compressible(axis) for axis in AXES)


def test_margins_are_of_gain_and_resonance_of_each_joint():
    gain = 8.0
    found = {one.what: one for one in gain_margins(CIRCUIT, PLANT, (Loop(gain, 0.005),) * 2)}
    assert list(found) == ["gain of theta", "resonance of theta", "gain of phi",
                           "resonance of phi"]  # fmt: skip
    angles = CIRCUIT.position(np.linspace(0, CIRCUIT.profile.perimeter, 500))
    for joint, name in enumerate(("theta", "phi")):
        axis = AXES[joint]
        least = axis.natural_frequency(angles[:, joint]).min()
        resonance = found[f"resonance of {name}"]
        assert resonance.unit == "Hz"
        assert resonance.has == pytest.approx(least / (2 * np.pi), rel=1e-3)
        # A loop on an integrator with a resonance w and damping ratio zeta needs gain < 2 zeta w,
        # and 2 zeta w is the damping over the inertia.
        share = resonance.needs / resonance.has
        assert share == pytest.approx(gain / (axis.damping / axis.inertia), rel=1e-3)
        assert resonance.enough == (share < 1)
        limit = found[f"gain of {name}"]
        assert limit.needs == gain and 0 < limit.has < 1000 and limit.enough == (limit.has > gain)


def test_only_axes_with_cylinders_have_margins():
    planned = plan(CIRCUIT, Limits(feed=0.2, acceleration=1.0), tolerance=1e-2)
    loop = (Loop(8.0, planned.tick),) * 2
    lag = (Lag(0.5, 0.02),) * 2
    with pytest.raises(ValueError, match=r"^plant: must have cylinders; got Lag, without\.$"):
        capability(planned, lag, loop, usual_sizes(REFERENCE_MACHINE))
    with pytest.raises(ValueError, match=r"^plant: must have cylinders; got Lag, without\.$"):
        gain_margins(CIRCUIT, lag, loop)
    with pytest.raises(ValueError, match=r"^plant: must be of class Compressible, .* got Lag and"):
        ground_fault(planned, lag, loop, Ground(2e7, 2.0))


@pytest.mark.parametrize("number", [0.0, -1.0, [1.0, 2.0]])
def test_bounds_are_numbers_above_zero(number):
    with pytest.raises(ValueError, match=r"^joint_speed: must be one number above zero; got "):
        Limits(feed=0.1, acceleration=1.0, joint_speed=number)
