"""Derivatives in a turning direction, their size, and a Hessian's eigenvalues, against tensors."""

from itertools import product

import numpy as np
import pytest

from tests.forms_random import jet_of
from tunneller_lib.envelopes.forms import derivative_along, frobenius, frobenius_along, principal
from tunneller_lib.envelopes.jet import EXPONENTS, Jet

POINTS = 30


def tensor(f, degree):
    """Return all derivatives of one degree (n, 2, .., 2)."""
    found = np.empty((POINTS, *[2] * degree))
    for axes in product((0, 1), repeat=degree):
        found[:, *axes] = f.derivative(degree - sum(axes), sum(axes))
    return found


@pytest.mark.parametrize(("e", "w"), [(1, 0), (0, 1), (2, 0), (1, 1), (3, 0), (2, 1), (1, 3)])
def test_derivatives_along_directions_are_the_tensors(e, w):
    f = jet_of(POINTS, 1)
    angle = np.random.default_rng(2).uniform(0, 2 * np.pi, (POINTS, 1))
    value = tensor(f, e + w)
    first = np.hstack([np.cos(angle), np.sin(angle)])
    second = np.hstack([-np.sin(angle), np.cos(angle)])
    for way in [first] * e + [second] * w:
        value = np.einsum("n...i,ni->n...", value, way)
    np.testing.assert_allclose(derivative_along(f, angle, e, w)[:, 0], value, atol=1e-13)


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_sizes_of_derivatives_are_the_tensors_norms(degree):
    f = jet_of(POINTS, 3)
    norms = np.sqrt((tensor(f, degree) ** 2).reshape(POINTS, -1).sum(axis=1))
    np.testing.assert_allclose(frobenius(f, degree), norms, rtol=1e-14)


@pytest.mark.parametrize("degree", [2, 3])
def test_sizes_over_a_width_are_the_norms_of_the_stretched_graph(degree):
    f = jet_of(POINTS, 3)
    first, second = f.c.copy(), f.c.copy()
    for row, (i, j) in enumerate(EXPONENTS):
        first[row] *= 0.1**j
        second[row] *= 0.1**i
    for turn, stretched in ((0.0, first), (np.pi / 2, second)):
        angle, width = np.full((POINTS, 1), turn), np.full((POINTS, 1), 0.1)
        found = frobenius_along(f, angle, width, degree)[:, 0]
        np.testing.assert_allclose(found, frobenius(Jet(stretched), degree), rtol=1e-14)


def test_principal_directions_are_the_hessians():
    f = jet_of(POINTS, 4)
    values, vectors = np.linalg.eigh(tensor(f, 2))
    low, high, turn = principal(f)
    np.testing.assert_allclose(np.stack([low, high], axis=-1), values, atol=1e-14)
    across = np.cos(turn) * vectors[:, 1, 0] - np.sin(turn) * vectors[:, 0, 0]
    np.testing.assert_allclose(across, 0, atol=1e-13)
    assert np.all((turn >= 0) & (turn <= np.pi))
