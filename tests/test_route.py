"""The way through knots: its lengths and the places along the section that belong to them."""

import numpy as np
import pytest

from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.ream.route import route_through
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = Circuit(REFERENCE_MACHINE, Egg(0.5))
KNOTS = CIRCUIT.knots(1e-2)
ROUTE = route_through(CIRCUIT, KNOTS)


def test_lengths_and_places_belong_together():
    np.testing.assert_allclose(ROUTE.place(ROUTE.ends), [*KNOTS, KNOTS[0] + ROUTE.places[-1]])
    lengths = np.linspace(0, ROUTE.ends[-1], 50)
    np.testing.assert_allclose(ROUTE.length_at(ROUTE.place(lengths)), lengths, atol=1e-12)


@pytest.mark.parametrize("given", [None, "x", np.nan])
def test_lengths_and_places_are_numbers(given):
    with pytest.raises(ValueError, match=r"^length: must "):
        ROUTE.place(given)
    with pytest.raises(ValueError, match=r"^place: must "):
        ROUTE.length_at(given)


@pytest.mark.parametrize(
    ("way", "message"),
    [
        (len, r"must be a function of 3 arguments; got .*"),
        (lambda p, q, n: None, r"must hold real numbers .*"),
        (lambda p, q, n: np.full((len(p), n, 2), np.nan), r"must hold finite numbers; got nan"),
        (lambda p, q, n: p, r"must return positions \(\d+, 17, 2\); got \(\d+, 2\)"),
    ],
    ids=["len", "nothing", "nan", "of the knots"],
)
def test_ways_that_are_none_are_refused_in_a_sentence(way, message):
    with pytest.raises(ValueError, match=rf"^way: {message}\.$"):
        route_through(CIRCUIT, KNOTS, way=way)
