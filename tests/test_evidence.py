"""Zeros of polynomials that are only known to some error, and how sure they are."""

import numpy as np
import pytest

from tunneller_lib.envelopes.evidence import spread_in_two, zeros


def touching(height):
    """Return the polynomials height + 1 - cos(angle), which are least at angle = 0."""
    return lambda angle: height[:, None] + 1 - np.cos(angle)


def test_polynomial_may_vanish_where_twice_its_error_reaches_zero():
    off = np.full(4, 1e-6)
    height = off * [0.5, 1.9, 2.1, 3.0]
    angle, spread, several = zeros(touching(height), 1, off)
    at = np.abs(angle) < 0.1
    assert np.any(at, axis=1).tolist() == [True, True, False, False]
    assert several[at].all()
    # The zero of a double root known to e lies within sqrt(2 e) of it, and farther it isn't sought.
    assert np.all(spread[at] >= np.sqrt(2 * 1e-6)) and np.all(spread[at] < 0.02)


@pytest.mark.parametrize("off", [1e-12, 1e-8, 1e-4])
def test_simple_zeros_lie_within_their_spread(off):
    rng = np.random.default_rng(3)
    shift = rng.uniform(-0.9, 0.9, 50)
    errors = off * rng.choice([-1, 1], 50)
    angle, spread, several = zeros(lambda a: np.cos(a) - shift[:, None], 1, np.full(50, off))
    true = np.arccos(shift + errors)
    away = np.abs(np.cos(angle) - np.cos(true)[:, None]) / np.abs(np.sin(true))[:, None]
    known = ~np.isnan(angle)
    assert not several[known].any() and known.sum() == 100
    assert np.all(away[known] <= spread[known]) and np.all(spread[known] < 20 * off)


@pytest.mark.parametrize("size", [1e-6, 1.0])
def test_points_are_spread_unless_one_conic_or_one_orbit_holds_them(size):
    s, t = size * np.random.default_rng(4).uniform(-1, 1, (2, 20))
    angle = np.linspace(0, 5, 20)
    normals = np.stack([s / size, t / size, np.full(20, 2.0)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    circle = np.stack([np.cos(angle), np.sin(angle), np.ones(20)], axis=-1) / np.sqrt(2)
    assert spread_in_two(s, t, None) and spread_in_two(s, t, normals)
    assert not spread_in_two(s, t, circle)
    short = 5e-6 * angle  # an arc that is hardly turned
    arc = np.stack([np.cos(short), np.sin(short), np.ones(20)], axis=-1) / np.sqrt(2)
    assert not spread_in_two(s, t, arc)
    assert not spread_in_two(size * np.cos(angle), 2 * size * np.sin(angle), normals)
    assert not spread_in_two(s, s * s / size, None)


@pytest.mark.parametrize("apart", [1e-7, 1e-6, 1e-5, 1.9e-5])
def test_zeros_that_come_as_one_are_both_within_its_spread(apart):
    """Nearer than 2e-5 they come as a double one amid them, where the polynomial isn't zero."""
    angle, spread, several = zeros(
        lambda a: np.cos(a - 0.3) - np.cos(apart / 2), 1, np.array([1e-16])
    )
    near = np.abs(angle - 0.3) < 1e-4
    for zero in (0.3 - apart / 2, 0.3 + apart / 2):
        assert np.any(np.abs(angle - zero)[near] <= spread[near])
    assert several[near].all()
