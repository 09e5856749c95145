"""Volumes of a cut against quadrature in other coordinates, and their limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from scipy.integrate import quad

from tests.draws import log_uniform
from tunneller_lib.removal import Ground
from tunneller_lib.removal.volume import (
    advance_for_volume,
    bowl,
    groove_area,
    half_lens,
    removed_volume,
    ring,
)


@given(log_uniform(1e-6, 1e6), st.floats(0, 2))
def test_bowl_and_ring_fill_the_cylinder(R, share):
    c = share * R
    whole = 4 / 3 * np.pi * R**3
    assert np.isclose(bowl(R, c), whole - 2 * half_lens(R, c), rtol=1e-12, atol=1e-12 * whole)
    assert np.isclose(bowl(R, c) + ring(R, c), np.pi * R**2 * c, rtol=1e-14)
    assert np.isclose(half_lens(R, c), np.pi * quad(lambda x: R**2 - x**2, c / 2, R)[0], rtol=1e-9)


def test_bowl_of_a_short_advance_keeps_its_digits():
    for c in (1e-3, 1e-9, 1e-15):
        with mp.workdps(40):
            R = mp.mpf("0.2")
            lens = 2 * mp.pi * (R**2 * (4 * R - 3 * mp.mpf(c)) / 12 + mp.mpf(c) ** 3 / 48)
            expected = float(4 * mp.pi * R**3 / 3 - 2 * lens)
        assert np.isclose(bowl(0.2, c), expected, rtol=1e-14)


@pytest.mark.parametrize("share", [1e-15, 1e-9, 1e-3, 0.1, 0.4, 1.0, 1.7])
def test_groove_area_keeps_its_digits(share):
    with mp.workdps(60):
        g = mp.mpf(share)
        expected = mp.acos(1 - g) - (1 - g) * mp.sqrt(2 * g - g**2)
        assert groove_area(1, share) == pytest.approx(float(expected), rel=2e-15, abs=0)


@given(st.floats(0.01, 1), st.floats(0.01, 3), st.floats(1.0001, 30))
def test_removed_volume_behind_a_concave_wall(share, pitch, wall):
    # Over the strip between two passes: how far the ball reaches beyond the wall's circle.
    R, g, c = 1.0, share, 0.3
    path = wall - R + g
    half = min(np.sqrt(2 * R * g - g * g), pitch / 2, R)

    def beyond(x):
        return ((path + np.sqrt(R * R - x * x)) ** 2 - wall**2) / 2

    expected = c / path * 2 * quad(beyond, 0, half, epsabs=1e-13)[0]
    found = removed_volume(R, c, g, wall=wall, pitch=pitch)
    assert np.isclose(found, expected, rtol=1e-7)
    assert removed_volume(R, c, g, wall=wall) >= found * (1 - 1e-12)


def test_removed_volume_limits():
    plane = removed_volume(0.2, 0.01, 0.02)
    assert np.isclose(removed_volume(0.2, 0.01, 0.02, wall=1e9), plane, rtol=1e-8)
    assert removed_volume(0.2, 0.01, 0.02, pitch=0.4) == plane  # wider than the groove
    assert np.isclose(removed_volume(0.2, 0.01, 0.02, pitch=1e-6), 0.01 * 1e-6 * 0.02, rtol=1e-9)
    assert np.isclose(removed_volume(0.2, 0.01, 0.4), bowl(0.2, 0.01) + ring(0.2, 0.01), rtol=1e-14)
    assert removed_volume(0.2, 0, 0.02) == removed_volume(0.2, 0.01, 0) == 0


@given(log_uniform(1e-9, 1e-2), st.floats(0.001, 0.2))
def test_advance_for_volume_is_the_inverse(volume, depth):
    for options in ({}, {"wall": 0.5}, {"wall": 0.25, "pitch": 0.03}):
        c = advance_for_volume(0.2, volume, depth, **options)
        assert np.isclose(removed_volume(0.2, c, depth, **options), volume, rtol=1e-14)


def test_force_of_picks_swells_about_its_mean():
    picks = Ground(20e6, 2.0, ripple=0.3, ripple_frequency=5.0)
    assert picks.pulse([0.0, 0.05, 0.15]) == pytest.approx([1.0, 1.3, 0.7], rel=1e-14)


def test_wrong_cuts_are_refused():
    for message, call in {
        "advance: must lie between 0 and 2 m; got 2.1": lambda: half_lens(1, 2.1),
        "wall: must be above the cutter's radius": lambda: removed_volume(1, 1, 0.1, wall=0.8),
        "depth: must be above 0": lambda: advance_for_volume(1, 1, 0),
        "volume: must be removed by an advance": lambda: advance_for_volume(1, 1, 1e-200),
    }.items():
        with pytest.raises(ValueError, match=f"^{message}"):
            call()
