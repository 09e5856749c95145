"""Derivatives in a turning direction, their size, and a Hessian's eigenvalues, against tensors."""

from itertools import product

import numpy as np
import pytest

from tests.forms_random import jet_of
from tunneller_lib.envelopes.forms import derivative_along, frobenius, principal

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


def test_principal_directions_are_the_hessians():
    f = jet_of(POINTS, 4)
    values, vectors = np.linalg.eigh(tensor(f, 2))
    low, high, turn = principal(f)
    np.testing.assert_allclose(np.stack([low, high], axis=-1), values, atol=1e-14)
    across = np.cos(turn) * vectors[:, 1, 0] - np.sin(turn) * vectors[:, 0, 0]
    np.testing.assert_allclose(across, 0, atol=1e-13)
    assert np.all((turn >= 0) & (turn <= np.pi))
