"""Errors of derivatives, found from runs that round at random."""

import operator

import numpy as np
import pytest

from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet
from tunneller_lib.envelopes.jet import Jet
from tunneller_lib.envelopes.rough import RUNS, RoughJet, errors, rough_frames, scatter

EPS = np.finfo(float).eps
S, T = np.random.default_rng(7).uniform(0.2, 0.8, (2, 30))


def torus(s, t):
    return [(2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)]


def test_a_jet_is_turned_by_a_rounding_at_most():
    jet = RoughJet(np.ones((15, 1000)), np.random.default_rng(1))
    turned = (jet + 0.0).c[0] - 1  # a sum of one term
    assert 0.5 * EPS <= np.abs(turned).max() <= 2 * EPS
    assert turned.min() < 0 < turned.max()


@pytest.mark.parametrize("operate", [operator.add, operator.sub, operator.mul, operator.truediv])
@pytest.mark.parametrize("other", [Jet(np.full((15, 1000), 0.7)), 0.7, np.full(1000, 0.7)])
def test_every_operator_turns_either_operand(operate, other):
    jet = Jet(np.ones((15, 1000)))
    rough = RoughJet(jet.c, np.random.default_rng(1))
    for found, exact in (
        (operate(rough, other), operate(jet, other)),
        (operate(other, rough), operate(other, jet)),
    ):
        assert isinstance(found, RoughJet)
        assert np.mean(found.c != exact.c) > 0.05  # some roundings hide a turn


@pytest.mark.parametrize("order", [4, 5])
def test_errors_of_a_torus_are_some_hundreds_of_roundings(order):
    exact = isotropic_jet(adapted_frames(torus, S, T, "space"), slice(None))
    rough = rough_frames(torus, S, T, "space", order)
    off = errors(isotropic_jet(rough, slice(None)))
    assert off.c.shape[1] == len(S) and rough.r[0].c.shape[1] == RUNS * len(S)
    size = np.abs(exact.c[3:]).max()
    bends = off.c[3:6].max(axis=0)  # of the curvatures
    assert np.all(bends > EPS * size / 10)
    assert np.median(bends) < 500 * EPS * size


def test_errors_are_ten_times_the_greatest_deviation_and_a_rounding():
    runs = np.arange(RUNS, dtype=float)[None, :, None] + np.zeros((15, 1, 4))
    middle = (RUNS - 1) / 2
    off = errors(RoughJet(runs.reshape(15, -1), None)).c
    np.testing.assert_allclose(off, 10 * middle + EPS * middle, rtol=1e-15)
    np.testing.assert_allclose(scatter(runs[0].repeat(2, axis=1).reshape(-1, 2)), 10 * middle)
