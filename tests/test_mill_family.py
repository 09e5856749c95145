"""Several mills on one patch, chains of cones that touch twice, and what strips make together."""

from dataclasses import replace

import numpy as np
import pytest

from tests.test_strips import BALL, MILL, MM, PLANE, SADDLE, covering, straight
from tunneller_lib.milling import (
    cover,
    find_positions,
    find_scallops,
    plan_tour,
    sweep_error,
    touch_twice,
)
from tunneller_lib.milling.five_axes import TiltingTable
from tunneller_lib.milling.positions import depths_of
from tunneller_lib.milling.tangency import touch_along
from tunneller_lib.milling.tour import STEP

LOOK = {"tolerance": 1e-7, "n": 31}
OTHER = replace(MILL, half_angle=0.3)
STARTS = SADDLE.parameters(2, margin=0.2)


@pytest.fixture(scope="module")
def found():
    return find_positions(SADDLE, MILL, *STARTS, **LOOK)


@pytest.fixture(scope="module")
def first(found):
    return cover(SADDLE, MILL, found, step=1 * MM, most=1, **LOOK)


def test_a_second_mill_goes_on_where_the_first_left_something(first):
    more = find_positions(SADDLE, OTHER, *STARTS, **LOOK)
    both = cover(SADDLE, OTHER, more, step=1 * MM, begun=first, **LOOK)
    assert both.chains[0] is first.chains[0] and both.mills[0] == MILL
    assert len(both.chains) > 1 and set(both.mills[1:]) == {OTHER}
    mesh = SADDLE.mesh(31)
    error = np.full(mesh.shape[:2], np.inf)
    shares = []
    for mill, chain in zip(both.mills, both.chains, strict=True):
        error = np.minimum(error, sweep_error(mesh, mill, chain.tip, chain.axis))
        shares.append(replace(both, error=error).share(1e-7))
    np.testing.assert_array_equal(error, both.error)
    assert np.diff(shares).min() >= 0.01


def test_what_is_begun_counts_among_the_most_and_leaves_what_fits_no_more(found, first):
    assert (
        cover(SADDLE, MILL, found, step=1 * MM, begun=first, most=1, **LOOK).chains == first.chains
    )
    none = replace(found, reason=np.full(len(found), "not asked"))
    assert cover(SADDLE, MILL, none, step=1 * MM, begun=first, **LOOK).chains == first.chains


def test_a_coverage_of_another_mesh_or_without_mills_is_refused(found, first):
    with pytest.raises(ValueError, match=r"^begun: must be of this patch's mesh \(21, 21\)"):
        cover(SADDLE, MILL, found, step=1 * MM, begun=first, **(LOOK | {"n": 21}))
    with pytest.raises(ValueError, match=r"got \(31, 31\) and 0 mills"):
        cover(SADDLE, MILL, found, step=1 * MM, begun=replace(first, mills=()), **LOOK)


def test_chains_that_touch_twice_are_taken_where_they_add_more(found, first):
    twice = cover(SADDLE, MILL, found, step=1 * MM, most=1, twice=True, **LOOK)
    assert twice.share(1e-7) > 1.1 * first.share(1e-7)
    [chain] = twice.chains
    own, holder, _ = depths_of(SADDLE, MILL, chain.tip, chain.axis, None, 61)
    assert own.max() <= LOOK["tolerance"] and holder.max() == 0
    off = sweep_error(chain.contact, MILL, chain.tip, chain.axis)
    # Amid its contacts a cone leaves nearly the tolerance, where one contact leaves nothing.
    assert 0.5e-7 < np.median(off) < 1e-7


def test_without_a_tolerance_no_cone_touches_twice(first):
    [chain] = first.chains
    assert touch_along(SADDLE, MILL, chain, 0.0, None, None, 31) is None  # it may leave nothing


def test_a_chain_touches_twice_at_the_distances_that_are_given(first):
    [chain] = first.chains
    apart = np.linspace(2 * MM, 3 * MM, len(chain))
    twin = touch_along(SADDLE, MILL, chain, 1e-7, None, None, 31, apart)
    rows = np.isin(chain.s, twin.s)
    whole = touch_twice(SADDLE, MILL, chain, apart=apart, n=31)
    assert len(twin) >= 6
    np.testing.assert_array_equal(twin.tip, whole.tip[rows])


@pytest.mark.parametrize("pitch", [0.5 * MM, 2 * MM])
def test_balls_side_by_side_meet_in_the_kink_of_two_circles(pitch):
    chains = [straight(k * pitch) for k in (-1, 0, 1)]
    kink = find_scallops(PLANE, BALL, covering(*chains), m=101).kink
    slope = pitch / 2 / np.hypot(pitch / 2, 5 * MM)
    np.testing.assert_allclose(kink, 2 * np.arctan(slope), rtol=0.03)


def test_scallops_are_those_of_the_mills_of_a_coverage():
    one, next_one = straight(0.0), straight(2 * MM)
    ours = replace(covering(one, next_one), mills=(BALL, BALL))
    np.testing.assert_array_equal(
        find_scallops(PLANE, None, ours).height, find_scallops(PLANE, BALL, ours).height
    )
    with pytest.raises(ValueError, match="covered: must have a mill a chain; got 0 of them"):
        find_scallops(PLANE, None, covering(one, next_one))


def test_a_tour_begins_above_its_first_chain(first):
    table = TiltingTable((0, 0, -0.1), (1, 0, 0), *[(-1, 1)] * 3, (-3.2, 3.2), (-9, 9), 0.5)
    tour = plan_tour(SADDLE, MILL, first.chains, table, clearance=0.01, **LOOK)
    highest = np.linalg.norm(SADDLE.mesh(31) - np.array(table.pivot), axis=-1).max()
    assert tour.kind[0] == "approach"
    assert tour.values[0, 2] == pytest.approx(highest + 0.01)
    assert 0 < tour.values[0, 2] - tour.values[1, 2] <= STEP[0] * (1 + 1e-9)
