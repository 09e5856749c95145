"""The size that all points of a surface share: of cones along their own circles, in any window."""

import numpy as np
import pytest

from tunneller_lib.envelopes import recognise
from tunneller_lib.envelopes.families import channel, helix, moving_cone, screwing

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


GRID = np.meshgrid(np.linspace(-0.5, 0.5, 6), np.linspace(-0.5, 0.5, 5))


@pytest.mark.parametrize(("motion", "half_angle", "middle", "window", "other"), [
    ((0.186, 0.0, 1.2), 0.7, (0.45, 0.35), 0.5, np.pi / 2 - 1.2),  # of revolution: both are right
    ((1.588, -0.691, 1.271), 0.782, (0.11, 1.59), 0.0075, 0.7778),  # too small to tell them apart
])  # fmt: skip
def test_sizes_that_pass_as_well_are_named_in_the_reason(motion, half_angle, middle, window, other):
    s, t = np.array(middle)[:, None, None] + window * np.array(GRID)
    found = recognise(moving_cone(screwing(*motion), half_angle), s, t, "cone", model="space")
    named = [found.half_angle, float(found.because.rpartition(" ")[2].rstrip("."))]
    assert found.verdict == "is" and "; so they do with " in found.because
    assert sorted(named) == pytest.approx(sorted([half_angle, other]), abs=1e-4)
