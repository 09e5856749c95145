"""The size that all points of a surface share: of cones along their own circles, in any window."""

import numpy as np
import pytest

from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.families import channel, helix

PITCH = 0.4


@pytest.mark.parametrize("growth", [0.3, 0.6])
@pytest.mark.parametrize(("window", "verdict"), [(0.6, "is"), (0.1, "is"), (1e-4, "cannot tell")])
def test_spheres_that_grow_evenly_have_one_cone_along_their_circles(growth, window, verdict):
    surface = channel(lambda s: helix(s, PITCH), 0.2, growth=growth)
    s, t = np.array([[0.4], [1.0]]) + window * np.random.default_rng(1).uniform(-1, 1, (2, 30))
    found = recognise(surface, s, t, "cone", model="space")
    assert found.verdict == verdict
    if verdict == "is":
        speed = np.hypot(1.0, PITCH)
        assert found.half_angle == pytest.approx(np.arcsin(growth / speed), rel=1e-12)
