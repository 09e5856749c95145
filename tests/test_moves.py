"""How a run of ticks is divided into moves: by their greatest way, and by the limits' strain."""

import numpy as np
import pytest

from tunneller_lib.ream.moves import move_lengths

FREE = np.zeros(9)


@pytest.mark.parametrize(("more", "ticks"), [(0.0, [4, 4]), (1e-12, [4, 4]), (1e-7, [3, 3, 2])])
def test_a_move_goes_as_far_as_the_step_up_to_rounding(more, ticks):
    moved = np.arange(9) * (1 + more)
    assert move_lengths(moved, FREE, step=4.0).tolist() == ticks


@pytest.mark.parametrize(("share", "ticks"), [(0.5, 2), (0.5 * (1 + 1e-7), 2), (0.5001, 1), (1, 1)])
def test_a_move_of_n_ticks_has_a_strain_of_an_nth_at_most(share, ticks):
    found = move_lengths(np.arange(9.0), np.full(9, share), step=100.0)
    assert found.tolist() == [ticks] * (8 // ticks)


def test_where_the_strain_is_high_moves_are_short():
    strain = np.where(np.arange(25) == 12, 1.0, 0.1)
    found = move_lengths(np.arange(25.0), strain, step=100.0)
    ends = np.cumsum(found)
    assert found.sum() == 24 and found.max() == 10
    beside = found[(ends >= 12) & (ends - found <= 12)]
    assert beside.tolist() == [1, 1]
