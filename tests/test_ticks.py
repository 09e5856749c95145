"""Runs of axes tick by tick: where they begin, and what is kept of them."""

import numpy as np
import pytest

from tunneller_lib.motion import Compressible, Loop, follow
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.surfaces import REFERENCE_MACHINE

SIZES = usual_sizes(REFERENCE_MACHINE)
OILY = [Compressible(axis) for axis in axes_of(REFERENCE_MACHINE, SIZES)]


@pytest.mark.parametrize("arm", [None, arm_of(REFERENCE_MACHINE, SIZES)], ids=["apart", "one arm"])
def test_axes_begin_at_rest_at_their_first_setvalues(arm):
    still = np.tile([0.2, -0.3], (6, 1))
    track = follow(OILY, Loop(10.0, 0.005), still, slopes=np.zeros((5, 2)), arm=arm)
    np.testing.assert_array_equal(track.position[0], still[0])
    # The pressures bear the weight from the beginning: a free fall would be 1e-3 rad by now.
    np.testing.assert_allclose(track.position, still, atol=1e-5)
