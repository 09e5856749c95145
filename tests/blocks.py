"""Blocks of small sweeps, in a module of their own: each process that computes them imports it."""

from unittest import mock

import numpy as np

from exhibits import atlas


def small(block):
    """Return a small table of a block."""
    return np.sin(np.arange(6.0).reshape(2, 3) + 10 * block[0] + block[1])


EVERY_PAIR = atlas.pairs


def few_pairs(stripe):
    """Return every hundredth pair of a stripe."""
    return tuple(column[::100] for column in EVERY_PAIR(stripe))


def survey(block):
    """Return the atlas's table of a block for few pairs."""
    with mock.patch.object(atlas, "pairs", few_pairs):
        return atlas.survey(block)


def fails_late(block):
    if block[1] == 3:
        raise ArithmeticError("as after an interrupt")
    return small(block)
