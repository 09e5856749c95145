"""What neighbouring strips leave between them, and strips of cones that touch twice."""

from dataclasses import replace

import numpy as np
import pytest

from tunneller_lib.milling import (
    BallMill,
    ConicalMill,
    Patch,
    cover,
    coverage_of,
    find_positions,
    find_scallops,
    random_envelope,
    scallops,
    strip_across,
    sweep_error,
    tangency,
    touch_seam,
    touch_twice,
    trace_chains,
)
from tunneller_lib.milling.chains import Chain
from tunneller_lib.milling.coverage import Coverage
from tunneller_lib.milling.tools import seen_from

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


@pytest.mark.parametrize("chains", [(), (straight(0.0, count=4), straight(1 * MM, count=3))])
def test_no_chains_or_too_short_ones_have_no_scallops(chains):
    found = find_scallops(PLANE, BALL, covering(*chains))
    assert len(found) == 0 and found.height.shape == (0,)


def test_contacts_are_compared_block_by_block(monkeypatch):
    chains = covering(*(straight(k * MM) for k in range(-3, 4)))
    whole = find_scallops(PLANE, BALL, chains)
    assert len(whole) == 6 * 8
    for pairs in (1, 100, 56 * 56):
        monkeypatch.setattr(scallops, "PAIRS", pairs)
        parts = find_scallops(PLANE, BALL, chains)
        for field in ("chain", "position", "neighbour", "opposite", "height"):
            np.testing.assert_array_equal(getattr(whole, field), getattr(parts, field))


def test_no_more_than_a_million_pairs_of_contacts_are_in_memory(monkeypatch):
    sizes = []
    norm = scallops.norm
    monkeypatch.setattr(
        scallops, "norm", lambda away: sizes.append(away[..., 0].size) or norm(away)
    )
    x = np.linspace(-1, 1, 700)
    inner = [
        (np.stack([x, 0 * x + y, 0 * x], axis=-1), np.tile([0.0, 1.0, 0.0], (700, 1)))
        for y in (0.0, 1e-3)
    ]
    assert len(scallops._pairs(inner)) == 700
    assert sum(sizes) == 1400**2 and max(sizes) <= 2**20


def test_a_line_between_strips_is_looked_at_at_sixty_points():
    chains = covering(straight(0.0), straight(2 * MM))
    usual = find_scallops(PLANE, BALL, chains).height
    np.testing.assert_array_equal(usual, find_scallops(PLANE, BALL, chains, m=60).height)
    assert np.all(usual < find_scallops(PLANE, BALL, chains, m=101).height)  # has the middle


def test_chains_one_behind_the_other_have_no_scallops_between_them():
    one = straight(0.0)
    away = np.array([0.03, 0, 0])
    behind = replace(one, contact=one.contact + away, tip=one.tip + away)
    assert len(find_scallops(PLANE, BALL, covering(one, behind))) == 0


SADDLE = Patch(lambda s, t: [s, t, 30 * s * t + 200 * s**3], (-0.01, 0.01), (-0.01, 0.01))
MILL = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)


@pytest.fixture(scope="module")
def chain():
    look = {"tolerance": 1e-7, "n": 41}
    starts = find_positions(SADDLE, MILL, 0.001, 0.0, **look)
    chains = trace_chains(SADDLE, MILL, starts, step=5e-4, most=6, **look)
    return max(chains, key=len)


def test_a_cone_touches_where_it_says_and_lies_in_both_tangent_planes(chain):
    twice = touch_twice(SADDLE, MILL, chain, apart=4 * MM)
    assert twice.found.all()
    distance = MILL.cutting(*seen_from(twice.contact, twice.tip, twice.axis))
    assert np.abs(distance).max() < 1e-15
    step = 1e-6  # the distances of points beside a contact fall with the square of the step
    for ds, dt in ((step, 0), (-step, 0), (0, step), (0, -step)):
        beside = SADDLE.points(twice.s + ds, twice.t + dt)
        off = MILL.cutting(*seen_from(beside, twice.tip, twice.axis))
        assert np.abs(off).max() < 100 * step**2
    np.testing.assert_allclose(
        np.linalg.norm(twice.contact[:, 0] - twice.contact[:, 1], axis=-1), 4 * MM, rtol=5e-3
    )


def test_cones_that_touch_twice_are_looked_at_on_121_by_121_places(chain, monkeypatch):
    asked = []
    monkeypatch.setattr(tangency, "depths_of", lambda *given: asked.append(given[-1]) or [0] * 3)
    touch_twice(SADDLE, MILL, chain, apart=4 * MM)
    assert asked == [121]


def test_as_contacts_fall_together_the_cone_is_that_in_third_order_contact(chain):
    turns = []
    for apart in (4 * MM, 2 * MM, 1 * MM):
        twice = touch_twice(SADDLE, MILL, chain, apart=apart)
        turns.append(np.linalg.norm(twice.axis - chain.axis, axis=-1).max())
    assert 3.5 < turns[0] / turns[1] < 4.5 and 3.5 < turns[1] / turns[2] < 4.5


def test_twice_touching_strips_are_wider_by_the_root_of_two_at_best(chain):
    """The tolerance is what the cone leaves amid its contacts, found by trying distances apart."""
    tolerance = 0.05e-6
    single = strip_across(SADDLE, MILL, chain, chain.tip, chain.axis, reach=6 * MM, m=400)
    before = np.median(single.widths(tolerance))
    ratios = []
    for apart in np.linspace(0.3, 1.3, 21) * before:
        twice = touch_twice(SADDLE, MILL, chain, apart=apart)
        assert twice.found.all() and twice.enters.max() < 1e-9
        strip = strip_across(SADDLE, MILL, chain, twice.tip, twice.axis, reach=6 * MM, m=400)
        ratios.append(np.median(strip.widths(tolerance)) / before)
    assert max(ratios) == pytest.approx(np.sqrt(2), abs=0.06)
    # To fourth order the best distance apart is the width of the single strip, 2 (tolerance/c)^1/4.
    assert np.linspace(0.3, 1.3, 21)[np.argmax(ratios)] == pytest.approx(1, abs=0.11)


def test_strips_that_touch_along_one_curve_join_without_a_kink(chain):
    """With its own distance at each position the contacts follow a curve, which the sweep touches.

    So do strips from either side of that curve: both leave nothing there, and rise with a square.
    """
    apart = np.linspace(3 * MM, 5 * MM, len(chain))
    twice = touch_twice(SADDLE, MILL, chain, apart=apart)
    assert twice.found.all()
    away = np.linalg.norm(twice.contact[:, 0] - twice.contact[:, 1], axis=-1)
    np.testing.assert_allclose(away, apart, rtol=5e-3)
    step = 0.02 * MM
    # Nearer to its ends a chain cuts with less than its envelope.
    for side in (0, 1):
        s, t = twice.s[3:-3, side], twice.t[3:-3, side]
        way = np.sign(s - chain.s[3:-3])
        seam, *beside = (
            sweep_error(SADDLE.points(s + k * way * step, t), MILL, twice.tip, twice.axis)
            for k in (0, 1, -1)
        )
        assert np.abs(seam).max() < 1e-10
        slope = np.abs(beside[0] - beside[1]) / (2 * step)
        single = sweep_error(SADDLE.points(s, t), MILL, chain.tip, chain.axis)
        # With one contact what is left rises as 4 h / a at a distance a from it.
        assert slope.max() < 0.02 * (4 * single / (apart[3:-3] / 2)).min()


def test_a_chain_touches_along_the_seam_that_it_is_given(chain):
    """On the seam, which comes nearer to the chain along it, the swept mill leaves nothing."""

    along = np.polynomial.Polynomial.fit(chain.t, chain.s, 1)

    def place(t):
        return along(t) + 2 * MM + 0.1 * t

    joined = touch_seam(
        SADDLE, MILL, chain, lambda s, t: 100 * (s - place(t)), tolerance=1e-6, n=41
    )
    assert len(joined) == len(chain)
    t = joined.t[4:-4]
    left, before = (
        sweep_error(SADDLE.points(place(t), t), MILL, one.tip, one.axis) for one in (joined, chain)
    )
    assert np.abs(left).max() < 0.05 * before.min()


@pytest.mark.parametrize("apart", [0.0, -1 * MM, [1 * MM, 0.0], [[1 * MM]]])
def test_contacts_that_arent_apart_are_refused(chain, apart):
    with pytest.raises(
        ValueError, match=r"^apart: must be above zero, one length or one a pos.*\.$"
    ):
        touch_twice(SADDLE, MILL, chain, apart=apart)


def test_distances_of_contacts_are_as_many_as_positions(chain):
    with pytest.raises(ValueError, match=rf"^apart: must be one length or {len(chain)}; got 2\.$"):
        touch_twice(SADDLE, MILL, chain, apart=[1 * MM, 2 * MM])


def test_where_a_contact_would_be_beyond_the_patch_the_row_is_the_chains(chain):
    twice = touch_twice(SADDLE, MILL, chain, apart=50 * MM)
    assert not twice.found.any()
    np.testing.assert_array_equal(twice.tip, chain.tip)
    np.testing.assert_array_equal(twice.axis, chain.axis)


def test_what_chains_leave_is_the_least_of_what_each_leaves():
    chains = [straight(-2 * MM), straight(3 * MM)]
    both = coverage_of(PLANE, BALL, chains, n=21)
    alone = [sweep_error(PLANE.mesh(21), BALL, one.tip, one.axis) for one in chains]
    np.testing.assert_array_equal(both.error, np.minimum(*alone))
    assert both.area.sum() == pytest.approx(0.04**2)
    assert both.mills == (BALL, BALL)
    with pytest.raises(ValueError, match=r"^chains: must be a list of one Chain or more; got"):
        coverage_of(PLANE, BALL, [])


@pytest.mark.parametrize("opening", [0.0, 0.03])
def test_random_envelopes_are_saddles_that_their_mill_fits_as_far_as_the_cone_stays(opening):
    rng = np.random.default_rng(7)
    for _ in range(3):
        patch, mill = random_envelope(rng, opening=opening)
        s, t = patch.parameters(5, margin=0.1)
        assert patch.saddle(s, t).all()
        found = find_positions(patch, mill, s, t, tolerance=1e-7, n=41)
        assert len(set(found.index[found.fits])) == (
            25 if opening == 0 else pytest.approx(12, abs=13)
        )


def test_a_cone_that_opens_too_far_gives_no_envelope():
    with pytest.raises(ValueError, match=r"^opening: must leave saddles on one side of a cone; go"):
        random_envelope(np.random.default_rng(0), opening=50.0)


def test_a_coverage_takes_the_chain_that_adds_most_and_none_that_adds_little():
    look = {"tolerance": 1e-7, "n": 31}
    starts = find_positions(SADDLE, MILL, *SADDLE.parameters(2, margin=0.2), **look)
    covered = cover(SADDLE, MILL, starts, step=1 * MM, **look)
    mesh = SADDLE.mesh(31)
    chains = trace_chains(SADDLE, MILL, starts, step=1 * MM, **look)
    assert 1 < len(chains) <= 6  # all are tried in the first round
    alone = [sweep_error(mesh, MILL, chain.tip, chain.axis) for chain in chains if len(chain) > 5]
    best = max(replace(covered, error=error).share(1e-7) for error in alone)
    error = np.full(mesh.shape[:2], np.inf)
    shares = [0.0]
    for chain in covered.chains:
        error = np.minimum(error, sweep_error(mesh, MILL, chain.tip, chain.axis))
        shares.append(replace(covered, error=error).share(1e-7))
    assert shares[1] == pytest.approx(best)
    assert np.diff(shares).min() >= 0.01
    np.testing.assert_array_equal(error, covered.error)
