"""The two conditions of each class on a direction, against their statements, and their errors."""

from itertools import product

import numpy as np
import pytest

from tests.forms_random import jet_of
from tunneller_lib.envelopes.conditions import two_conditions
from tunneller_lib.envelopes.forms import derivative_along, frobenius
from tunneller_lib.envelopes.jet import EXPONENTS, Jet

POINTS = 12
CLASSES = [("ruled", 0.0), ("cylinder", 0.3), ("channel", 0.0), ("pipe", 0.3), ("cone", 0.5)]
F = jet_of(POINTS, 5)
OFF = Jet(1e-9 * np.abs(jet_of(POINTS, 6).c))
ANGLES = np.random.default_rng(7).uniform(0, 2 * np.pi, (POINTS, 5))


def along(e, w=0):
    return derivative_along(F, ANGLES, e, w)


def statements(kind, size):
    """Return both conditions as the document has them, in a frame whose plane is tangent."""
    curvature = along(2) - 2 * size
    if kind in ("ruled", "cylinder"):
        return curvature, along(3)
    if kind == "channel":
        return along(1, 1), along(3)
    if kind == "pipe":
        return along(1, 1), curvature
    rho = 1 / (2 * np.tan(size))
    third = rho * along(3) + 3 * along(1, 1)
    fourth = rho**2 * along(4) + 6 * rho * along(2, 1) + 3 * (along(0, 2) - along(2))
    return third, fourth


@pytest.mark.parametrize(("kind", "size"), CLASSES)
def test_conditions_are_those_of_the_document(kind, size):
    forms = two_conditions(kind, F, OFF, size)
    first, second = statements(kind, size)
    np.testing.assert_allclose(forms.first(ANGLES), first, atol=1e-13)
    np.testing.assert_allclose(forms.second(ANGLES), second, atol=1e-13)


def of_degree(degree):
    """Return which coefficients of a jet are of one degree."""
    return np.array([sum(exponents) == degree for exponents in EXPONENTS])


def worst(kind, size, jets, sizes):
    """Return by how much both conditions change, at most, over all directions (2, POINTS)."""
    around = np.linspace(0, 2 * np.pi, 181)[None]
    still = two_conditions(kind, F, OFF, size)
    most = np.zeros((2, POINTS))
    for f, other in product(jets, sizes):
        moved = two_conditions(kind, f, OFF, other)
        for row, name in zip(most, ("first", "second"), strict=True):
            change = getattr(moved, name)(around) - getattr(still, name)(around)
            np.maximum(row, np.abs(change).max(axis=-1), out=row)
    return most


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize(("kind", "size"), CLASSES)
def test_errors_bound_what_wrong_coefficients_do(kind, size, degree):
    places = np.flatnonzero(of_degree(degree))
    off = np.zeros_like(F.c)
    off[places] = OFF.c[places]
    jets = []
    for signs in product((-1, 1), repeat=len(places)):
        moved = F.c.copy()
        moved[places] += np.array(signs)[:, None] * off[places]
        jets.append(Jet(moved))
    forms = two_conditions(kind, F, Jet(off), size)
    bounds = np.stack([forms.off_first, forms.off_second])
    found = worst(kind, size, jets, [size])
    assert np.all(found <= bounds * (1 + 1e-6) + 1e-15) and np.all(found >= bounds / 4)


@pytest.mark.parametrize(("kind", "size"), [("cylinder", 0.3), ("pipe", 0.3), ("cone", 0.5)])
def test_errors_bound_what_an_unsure_size_does(kind, size):
    unsure = 1e-6
    forms = two_conditions(kind, F, Jet(0 * F.c), size, unsure)
    bounds = np.stack([forms.off_first, forms.off_second])
    found = worst(kind, size, [F], [size - unsure, size + unsure])
    assert np.all(found <= bounds * (1 + 1e-4) + 1e-15) and np.all(found >= bounds / 4)


def test_order_4_is_compared_with_its_terms_or_a_share_of_the_jet():
    rho = 1 / (2 * np.tan(0.5))
    terms = [rho**2 * along(4), 6 * rho * along(2, 1), 3 * (along(0, 2) - along(2))]
    of_terms = sum(np.abs(term) for term in terms)
    whole = rho**2 * frobenius(F, 4) + 6 * rho * frobenius(F, 3) + 3 * frobenius(F, 2)
    for share in (1e-3, 1.0):
        size = two_conditions("cone", F, OFF, 0.5, floor=share).size(ANGLES)
        np.testing.assert_allclose(size, np.maximum(of_terms, share * whole[:, None]), rtol=1e-13)
