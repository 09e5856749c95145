"""Milling with what isn't told: how many chains, control points and places are looked at."""

from dataclasses import replace

import numpy as np
import pytest

from tunneller_lib.milling import (
    ConicalMill,
    Patch,
    cover,
    coverage,
    find_positions,
    fit_nurbs,
    strip_across,
    trace_chains,
)

MM = 1e-3
PATCH = Patch(lambda s, t: [s, t, 30 * s * t], (-10 * MM, 10 * MM), (-10 * MM, 10 * MM))
MILL = ConicalMill(0.2, 10 * MM, 200 * MM, 30 * MM, 50 * MM)
LOOSE = {"tolerance": 0.1 * MM}


@pytest.fixture(scope="module")
def found():
    s, t = PATCH.parameters(5, margin=0.2)
    return find_positions(PATCH, MILL, s.ravel(), t.ravel(), **LOOSE)


def test_normals_of_positions_are_unit_vectors_towards_the_mill(found):
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=-1), 1, rtol=1e-14)
    assert np.all(np.sum((found.tip - found.contact) * found.normal, axis=-1)[found.fits] > 0)


def test_a_patch_is_looked_at_on_121_by_121_places(found):
    untold, told, finer = (
        find_positions(PATCH, MILL, 0.001, 0.002, **LOOSE, **n)
        for n in ({}, {"n": 121}, {"n": 242})
    )
    assert np.array_equal(untold.enters, told.enters)
    assert not np.array_equal(untold.enters, finer.enters)
    none = replace(found, reason=np.full(len(found), "not asked"))
    assert cover(PATCH, MILL, none, step=1 * MM, **LOOSE).error.shape == (121, 121)


def test_a_fit_has_twenty_control_points_each_way():
    x = np.linspace(0, 1, 50)
    fit, _ = fit_nurbs(np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((50, 50))], -1), x, x)
    assert fit.control.shape == (20, 20, 3)


def first(chain, k):
    """Return the first k positions of a chain."""
    columns = {name: value[:k] for name, value in vars(chain).items() if name != "ends"}
    return replace(chain, **columns)


@pytest.fixture(scope="module")
def chain(found):
    start = replace(found, reason=np.where(np.arange(len(found)) == 0, found.reason, ""))
    [chain] = trace_chains(PATCH, MILL, start, step=1 * MM, **LOOSE, n=20)
    return chain


def test_a_strip_needs_six_positions(chain):
    six, five = first(chain, 6), first(chain, 5)
    assert len(strip_across(PATCH, MILL, six, six.tip, six.axis, reach=5 * MM).along) == 2
    with pytest.raises(ValueError, match=r"^chain: must have 6 positions or more; got 5\.$"):
        strip_across(PATCH, MILL, five, five.tip, five.axis, reach=5 * MM)


def test_twelve_chains_cover_a_patch_by_default(found, chain, monkeypatch):
    # However many there could be: from each start the same, which counts as a gain every time.
    def traced(patch, mill, starts, **options):
        return [chain] * np.count_nonzero(starts.fits)

    monkeypatch.setattr(coverage, "trace_chains", traced)
    monkeypatch.setattr(coverage, "_gain", lambda *given: np.inf)
    assert len(cover(PATCH, MILL, found, step=1 * MM, tolerance=0.0, n=20).chains) == 12


def test_a_chain_has_a_thousand_positions_to_either_side_at_most(found):
    with pytest.raises(ValueError, match=r"^most: must be .*from 2 to 1000"):
        trace_chains(PATCH, MILL, found, step=1 * MM, **LOOSE, most=1001)


def test_a_margin_of_half_the_width_leaves_nothing():
    with pytest.raises(ValueError, match=r"^margin: must be below 0\.5; got 0\.5\.$"):
        PATCH.parameters(3, margin=0.5)
