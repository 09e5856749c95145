"""What strips leave: beside each other, over a patch, and between neighbours."""

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
    strip_across,
    strips,
)
from tunneller_lib.milling.chains import Chain, trace_chain
from tunneller_lib.milling.strips import sweep_error

MM = 1e-3
PLANE = Patch(lambda s, t: [s, t, 0 * s], (-0.02, 0.02), (-0.02, 0.02))
BALL = BallMill(5 * MM)


def straight(y, count=12):
    """Return a chain of a ball on the plane, along x at a place y."""
    x = np.linspace(-11 * MM, 11 * MM, count)
    contact = np.stack([x, np.full(count, y), np.zeros(count)], axis=-1)
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    across = np.tile([0.0, 1.0, 0.0], (count, 1))
    return Chain(x, contact[:, 1], contact, up, contact, up, across)


def first(chain, k):
    """Return the first k positions of a chain."""
    return Chain(*(part[:k] for part in vars(chain).values()))


@pytest.mark.parametrize("pitch", [0.5 * MM, 2 * MM, 4 * MM])
def test_balls_side_by_side_leave_the_scallops_of_pythagoras(pitch):
    chains = [straight(k * pitch) for k in (-1, 0, 1)]
    lines, height = find_scallops(PLANE, BALL, chains, m=101)
    np.testing.assert_allclose(height, np.hypot(pitch / 2, 5 * MM) - 5 * MM, rtol=1e-6)
    assert set(map(tuple, lines[:, [0, 2]].tolist())) == {(0, 1), (1, 2)}  # not the outer two
    assert len(lines) == 16  # eight inner contacts, each pair once
    np.testing.assert_array_equal(lines[:, 1], lines[:, 3])
    assert lines[:, 1].min() == 2 and lines[:, 1].max() == 9


def test_a_strip_between_counts():
    """The outer two chains begin lines to the middle one, whose sweep is what is left there."""
    outer = [straight(-2 * MM), straight(2 * MM)]
    alone = find_scallops(PLANE, BALL, outer, m=101)[1].max()
    both = find_scallops(PLANE, BALL, [*outer, straight(0.5 * MM)], m=101)[1].max()
    assert both == pytest.approx(np.hypot(1.25 * MM, 5 * MM) - 5 * MM, rel=1e-3)
    assert both < alone


@pytest.mark.parametrize("chains", [
    [straight(0.0)], [straight(0.0, count=4), straight(1 * MM, count=4)],
])  # fmt: skip
def test_one_chain_or_too_short_ones_have_no_scallops(chains):
    lines, height = find_scallops(PLANE, BALL, chains)
    assert lines.shape == (0, 4) and height.shape == (0,)


def test_a_line_between_strips_is_looked_at_at_sixty_points():
    chains = [straight(0.0), straight(2 * MM)]
    usual = find_scallops(PLANE, BALL, chains)[1]
    np.testing.assert_array_equal(usual, find_scallops(PLANE, BALL, chains, m=60)[1])
    assert np.all(usual < find_scallops(PLANE, BALL, chains, m=101)[1])  # has the middle


def test_chains_one_behind_the_other_have_no_scallops_between_them():
    one = straight(0.0)
    away = np.array([0.03, 0, 0])
    behind = replace(one, contact=one.contact + away, tip=one.tip + away)
    assert len(find_scallops(PLANE, BALL, [one, behind])[1]) == 0


SADDLE = Patch(lambda s, t: [s, t, 30 * s * t + 200 * s**3], (-0.01, 0.01), (-0.01, 0.01))
MILL = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)


LOOK = {"tolerance": 1e-7, "n": 31}


@pytest.fixture(scope="module")
def found():
    return find_positions(SADDLE, MILL, *SADDLE.parameters(2, margin=0.2), **LOOK)


@pytest.fixture(scope="module")
def chains(found):
    rows = np.flatnonzero(found.fits).tolist()
    return [trace_chain(SADDLE, MILL, found, row, step=1 * MM, **LOOK) for row in rows]


def test_normals_of_positions_are_unit_vectors_towards_the_mill(found):
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=-1), 1, rtol=1e-14)
    assert np.all(np.sum((found.tip - found.contact) * found.normal, axis=-1)[found.fits] > 0)


def test_a_patch_is_looked_at_on_121_by_121_places():
    untold, told, finer = (
        find_positions(SADDLE, MILL, 0.001, 0.002, tolerance=1e-4, **n)
        for n in ({}, {"n": 121}, {"n": 242})
    )
    assert np.array_equal(untold.enters, told.enters)
    assert not np.array_equal(untold.enters, finer.enters)


def test_a_strip_needs_six_positions(chains):
    six, five = (first(max(chains, key=len), k) for k in (6, 5))
    assert len(strip_across(SADDLE, MILL, six, reach=5 * MM).along) == 2
    with pytest.raises(ValueError, match=r"^chain: must have 6 positions or more; got 5\.$"):
        strip_across(SADDLE, MILL, five, reach=5 * MM)


def test_a_chain_has_a_thousand_positions_to_either_side_at_most(found):
    row = int(np.flatnonzero(found.fits)[0])
    whole, short = (
        trace_chain(SADDLE, MILL, found, row, step=1 * MM, **LOOK, **most)
        for most in ({}, {"most": 2})
    )
    assert len(short) <= 5 < len(whole)
    with pytest.raises(ValueError, match=r"^most: must be .*from 2 to 1000"):
        trace_chain(SADDLE, MILL, found, row, step=1 * MM, **LOOK, most=1001)


@pytest.mark.parametrize("side", [1, -1])
def test_a_chain_past_an_obstacle_keeps_its_start(found, chains, side):
    """The obstacle lies in the way of the mill, a step ahead of the start and not within it."""
    row = int(np.flatnonzero(found.fits)[0])
    free = chains[0]
    start = int(np.argmin(np.abs(free.contact - found.contact[row]).sum(axis=1)))
    ahead = start + side
    way = free.tip[ahead] - free.tip[start]
    radius = MILL.tip_radius + MILL.length / 2 * np.tan(MILL.half_angle)
    middle = free.tip[ahead] + MILL.length / 2 * free.axis[ahead]
    point = middle + 0.99 * radius * way / np.linalg.norm(way)
    blocked = trace_chain(SADDLE, MILL, found, row, step=1 * MM, others=[point], **LOOK)
    kept = slice(None, start + 1) if side > 0 else slice(start, None)
    assert len(blocked) <= len(free.tip[kept]) < len(free)
    assert np.abs(blocked.contact - found.contact[row]).sum(axis=1).min() < 1e-12


def test_a_margin_of_half_the_width_leaves_nothing():
    with pytest.raises(ValueError, match=r"^margin: must be below 0\.5; got 0\.5\.$"):
        SADDLE.parameters(3, margin=0.5)


def test_twelve_chains_cover_a_patch_by_default(chains, monkeypatch):
    # However many there could be: from each start the same, which counts as a gain every time.
    found = find_positions(SADDLE, MILL, *SADDLE.parameters(5, margin=0.2), **LOOK)
    long = max(chains, key=len)
    monkeypatch.setattr(strips, "trace_chain", lambda *given, **options: long)
    monkeypatch.setattr(strips, "_gain", lambda *given: np.inf)
    assert len(cover(SADDLE, MILL, found, step=1 * MM, tolerance=0.0, n=20).chains) == 12


def test_what_chains_leave_is_the_least_of_what_each_leaves():
    chains = [straight(-2 * MM), straight(3 * MM)]
    both = coverage_of(PLANE, BALL, chains, n=21)
    alone = [sweep_error(PLANE.mesh(21), BALL, one) for one in chains]
    np.testing.assert_array_equal(both.error, np.minimum(*alone))
    assert both.area.sum() == pytest.approx(0.04**2)
    for wrong, said in (
        ([], "be a list of one Chain or"),
        ([straight(0.0, 3)], "each be a Chain of f"),
    ):
        with pytest.raises(ValueError, match=rf"^chains: must {said}"):
            coverage_of(PLANE, BALL, wrong)


def test_a_coverage_takes_the_chain_that_adds_most_and_none_that_adds_little(found, chains):
    covered = cover(SADDLE, MILL, found, step=1 * MM, **LOOK)
    mesh = SADDLE.mesh(31)
    assert 1 < len(chains) <= 6  # all are tried in the first round
    alone = [sweep_error(mesh, MILL, chain) for chain in chains if len(chain) > 5]
    best = max(replace(covered, error=error).share(1e-7) for error in alone)
    error = np.full(mesh.shape[:2], np.inf)
    shares = [0.0]
    for chain in covered.chains:
        error = np.minimum(error, sweep_error(mesh, MILL, chain))
        shares.append(replace(covered, error=error).share(1e-7))
    assert shares[1] == pytest.approx(best)
    assert np.diff(shares).min() >= 0.01
    np.testing.assert_array_equal(error, covered.error)
