"""What neighbouring strips leave between them."""

from dataclasses import replace

import numpy as np
import pytest

from tunneller_lib.milling import BallMill, Coverage, Patch, find_scallops
from tunneller_lib.milling.chains import Chain

MM = 1e-3
PLANE = Patch(lambda s, t: [s, t, 0 * s], (-0.02, 0.02), (-0.02, 0.02))
BALL = BallMill(5 * MM)


def straight(y, count=12):
    """Return a chain of a ball on the plane, along x at a place y."""
    x = np.linspace(-11 * MM, 11 * MM, count)
    contact = np.stack([x, np.full(count, y), np.zeros(count)], axis=-1)
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    across = np.tile([0.0, 1.0, 0.0], (count, 1))
    return Chain(x, contact[:, 1], contact, up, contact, up, across, ("", ""))


def covering(*chains):
    return Coverage(list(chains), np.zeros((2, 2)), np.ones((2, 2)))


@pytest.mark.parametrize("pitch", [0.5 * MM, 2 * MM, 4 * MM])
def test_balls_side_by_side_leave_the_scallops_of_pythagoras(pitch):
    chains = [straight(k * pitch) for k in (-1, 0, 1)]
    found = find_scallops(PLANE, BALL, covering(*chains), m=101)
    np.testing.assert_allclose(found.apart, pitch)
    np.testing.assert_allclose(found.height, np.hypot(pitch / 2, 5 * MM) - 5 * MM, rtol=1e-6)
    pairs = set(zip(found.chain.tolist(), found.neighbour.tolist(), strict=True))
    assert pairs == {(0, 1), (1, 2)}  # not the outer two
    assert len(found) == 16  # eight inner contacts, each pair once
    np.testing.assert_array_equal(found.position, found.opposite)


def test_a_strip_between_counts():
    """The outer two chains begin lines to the middle one, whose sweep is what is left there."""
    outer = covering(straight(-2 * MM), straight(2 * MM))
    alone = find_scallops(PLANE, BALL, outer, m=101).height.max()
    middle = covering(straight(-2 * MM), straight(0.5 * MM), straight(2 * MM))
    both = find_scallops(PLANE, BALL, middle, m=101).height.max()
    assert both == pytest.approx(np.hypot(1.25 * MM, 5 * MM) - 5 * MM, rel=1e-3)
    assert both < alone


def test_one_chain_has_no_scallops():
    found = find_scallops(PLANE, BALL, covering(straight(0.0)))
    assert len(found) == 0 and found.height.shape == (0,)


def test_chains_one_behind_the_other_have_no_scallops_between_them():
    one = straight(0.0)
    away = np.array([0.03, 0, 0])
    behind = replace(one, contact=one.contact + away, tip=one.tip + away)
    assert len(find_scallops(PLANE, BALL, covering(one, behind))) == 0
