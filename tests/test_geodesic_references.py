"""The shortest geodesics against the tables of high-precision references."""

from collections import Counter

import numpy as np
import pytest
from mpmath import mp

from tests.audit.long import many
from tests.references import geodesic_sweep, tables, torus_geodesics
from tests.references.geodesic_rivals import shortest_rival
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import Torus

READS = ["tests/references/*"]


HEADER, ROWS = tables.read(torus_geodesics.TABLE)
COUNTS = Counter(row[0] for row in ROWS)
SWEEP_HEADER, SWEEP = tables.read(geodesic_sweep.TABLE)
# Where the reduced length is smaller than that share of the length, the ends are nearly conjugate.
DEGENERATE = geodesic_sweep.DEGENERATE

every_family = pytest.mark.parametrize("family", COUNTS)
some_families = pytest.mark.parametrize("family", [*COUNTS][:: many(4, 1)])


def numbers(family):
    """Return columns of a family as floats by name, and its kinds: of rows all over its table."""
    rows = [row for row in ROWS if row[0] == family]
    rows = rows[:: max(len(rows) // many(25, 10_000), 1)]
    columns = np.array([row[1:-1] for row in rows], dtype=float).T
    return dict(zip(HEADER[1:-1], columns, strict=True)), np.array([row[-1] for row in rows])


def inverse(known):
    """Return the library's answers, a torus a row."""
    found = [
        geodesic_inverse(Torus(r, R), (theta1, phi1), (theta2, phi2))
        for r, R, theta1, phi1, theta2, phi2 in np.stack(
            [known[name] for name in torus_geodesics.INPUTS[1:]], axis=-1
        )
    ]
    names = ("length", "azimuth1", "azimuth2", "clairaut", "kind", "converged")
    return {name: np.array([getattr(one, name) for one in found]) for name in names}


def azimuth_error(known, found):
    """Return by how much the azimuths are off, of the nearer answer where there are two.

    With phi1 = -phi2 the geodesic turned by half about the middle is as long, azimuths exchanged.
    """
    pair = [np.stack([one["azimuth1"], one["azimuth2"]]) for one in (known, found)]
    straight, exchanged = (
        np.max(geodesic_sweep.angle_between(other, pair[1]), axis=0)
        for other in (pair[0], pair[0][::-1])
    )
    two = known["phi1"] == -known["phi2"]
    return np.where(two, np.minimum(straight, exchanged), straight)


@every_family
def test_geodesic_inverse_against_references(family):
    known, kinds = numbers(family)
    found = inverse(known)
    assert np.all(found["converged"])
    np.testing.assert_array_equal(found["kind"], kinds)
    np.testing.assert_allclose(found["length"], known["length"], rtol=1e-13)
    # A reduced length that is small against the length magnifies what rounding does to a direction.
    share = np.minimum(known["reduced"] / known["length"], 1)
    off = azimuth_error(known, found)
    assert np.all(off[share >= DEGENERATE] <= 1e-10)
    assert np.all(off * share <= 1e-13)
    size = known["r"] + known["R"]
    assert np.all(np.abs(found["clairaut"] - known["clairaut"]) * share <= 1e-13 * size)


@some_families
def test_references_of_geodesics_are_what_their_script_writes(family):
    with mp.workdps(torus_geodesics.DIGITS):
        first = next(torus_geodesics.rows(family))
    assert first == next(row for row in ROWS if row[0] == family)


@pytest.mark.parametrize("turn, shorter", [(1.5, False), (1.6, True), (2.5, True)])
def test_rivals_of_the_outer_equator_appear_past_its_conjugate_point(turn, shorter):
    ring = Torus(3, 1)  # conjugate at pi/2
    rival = shortest_rival(3, 1, 0, 0, turn, 4 * turn, shorter=1e-9)
    assert (rival is not None) == shorter
    if shorter:
        assert rival == pytest.approx(geodesic_inverse(ring, (0, 0), (turn, 0)).length, rel=1e-6)


@pytest.mark.parametrize("row", SWEEP, ids=lambda row: row[0])
def test_geodesic_inverse_against_a_sweep_in_80_bits(row, count=100):
    told = dict(zip(SWEEP_HEADER, row, strict=True))
    assert SWEEP_HEADER == geodesic_sweep.COLUMNS
    assert told["failures"] == told["wrong branches"] == told["rivals"] == "0"
    bounds = [float(x) for name, x in told.items() if name.startswith("worst ")]
    assert bounds[0] <= 1e-13 and bounds[2] <= 1e-10 and max(bounds[-2:]) <= 1e-17
    inputs, known = geodesic_sweep.solved(row[0], count, seed=1)
    failures, wrong, *errors = geodesic_sweep.compared(
        inputs, known, geodesic_sweep.library(inputs)
    )
    del errors[2]  # how many are degenerate
    assert failures == wrong == 0
    assert all(error <= bound for error, bound in zip(errors, bounds[:-2], strict=True))
    with mp.workdps(geodesic_sweep.DIGITS):
        exact = geodesic_sweep.against_mpmath(inputs, known, range(0, count, many(50, 20)))
    assert max(exact) <= 1e-17
