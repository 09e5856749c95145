"""Noisy planes, and surfaces through measured points and normals."""

import numpy as np
import pytest

from exhibits.envelope_equations import noisy_planes, tilted
from tunneller_lib.envelopes import fit_surface
from tunneller_lib.envelopes.families import cyclide
from tunneller_lib.envelopes.measured import mean_frame

PLACE = (0.45, 0.45)
EXACT = {"contact_error": 0.0, "normal_error": 1e-6}


def planes(count=800, turn=0.0, seed=0, reach=0.15):
    rng = np.random.default_rng(seed)
    return noisy_planes(cyclide, PLACE, rng, turn=turn, count=count, reach=reach)


def noisy(data, error, seed):
    """Return points and normals that err by as much, in m and in rad."""
    contact, n = data
    rng = np.random.default_rng(seed)
    return contact + error * rng.normal(size=(len(n), 1)) * n, tilted(n, np.sqrt(2) * error, rng)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_a_fit_passes_exact_points_and_has_their_normals(scale):
    contact, n = planes()
    fit = fit_surface(scale * contact, n, **EXACT)
    assert fit.fits
    inner, normals = planes(30, seed=1, reach=0.1)
    place = (scale * inner - fit.origin) @ fit.axes[:2].T
    there = np.stack(fit.surface(*place.T), axis=-1)
    np.testing.assert_allclose(there / scale, inner, atol=1e-12)
    step = 1e-5 * scale
    slope = [np.stack(fit.surface(*(place + d).T), -1) - there for d in ([step, 0], [0, step])]
    assert max(np.abs(np.sum(s * normals, axis=-1)).max() for s in slope) < 1e-4 * step


def cap(degrees, count):
    """Return points of a ball's cap, its normals, which are the same, and some on its rim."""
    turn, share = np.random.default_rng(13).uniform([[0], [0]], [[2 * np.pi], [1]], (2, count))
    share[:60] = 1
    rho = np.sin(np.radians(degrees)) * np.sqrt(share)
    return np.stack([rho * np.cos(turn), rho * np.sin(turn), np.sqrt(1 - rho**2)], axis=-1)


@pytest.mark.parametrize(("share", "fits"), [(1.0, True), (1.2, False)])
def test_steep_slopes_err_more_uphill_than_across(share, fits):
    """Where normals lean by 52 degrees: by 2.6 times the turn and 1.6 times. Sums of squares tell
    such weights from others."""
    n, rng = cap(52, 499), np.random.default_rng(2)
    contact = n * (1 + share * 1e-5 * rng.normal(size=(499, 1)))
    turned = tilted(n, share * np.sqrt(2) * 1e-3, rng)
    assert fit_surface(contact, turned, contact_error=1e-5, normal_error=1e-3).fits == fits


def test_the_degree_rises_as_noise_falls():
    loud, quiet = (
        fit_surface(*noisy(planes(), error, 3), contact_error=error, normal_error=error)
        for error in (1e-3, 1e-7)
    )
    assert loud.fits and quiet.fits and loud.degree < quiet.degree


def test_the_degree_is_two_above_that_of_a_polynomial():
    """An even one at places symmetric about the origin, so that the mean normal is upright."""
    x, y = np.random.default_rng(6).uniform(-1, 1, (2, 300))
    x, y = np.append(x, -x), np.append(y, -y)
    contact = np.stack([x, y, 0.03 * x**6 - 0.05 * x**3 * y], axis=-1)
    n = np.stack([-0.18 * x**5 + 0.15 * x * x * y, 0.05 * x**3, 1 + 0 * x], axis=-1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    assert fit_surface(contact, n, contact_error=1e-6, normal_error=1e-6).degree == 8


def test_noise_that_is_said_too_small_fits_nothing():
    errors = {"contact_error": 1e-3, "normal_error": 1e-3}
    fits = [fit_surface(*noisy(planes(250), e, 5), **errors).fits for e in (1e-3, 1.4e-3)]
    assert fits == [True, False]


def test_the_outer_half_is_left_out_where_no_polynomial_follows():
    """A ridge on a rim, sharper than degree 16 follows: the points within are kept."""
    x, y = np.random.default_rng(9).uniform(-1, 1, (2, 3000))
    root = np.sqrt(1e-4 + (x - 0.8) ** 2)
    contact = np.stack([x, y, 0.2 * root + 0.1 * y**2], axis=-1)
    n = np.stack([-0.2 * (x - 0.8) / root, -0.2 * y, 1 + 0 * x], axis=-1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    fit = fit_surface(contact, tilted(n, 1e-4, np.random.default_rng(1)), contact_error=0.0,
                      normal_error=1e-4)  # fmt: skip
    assert fit.fits and fit.reach < 0.9


@pytest.mark.parametrize(("degrees", "kept"), [(60, True), (72, False)])
def test_points_whose_normals_lean_by_more_than_66_degrees_are_left_out(degrees, kept):
    n = cap(degrees, 1500)
    fit = fit_surface(n, n, contact_error=1e-2, normal_error=0.1)
    assert fit.fits and (fit.reach > 0.99 * np.sin(np.radians(degrees))) == kept


def test_far_from_the_patch_a_fit_says_nothing():
    fit = fit_surface(*planes(), **EXACT)
    fit.surface(2 * fit.reach, 0.0)
    for name, place in (("x", (2.01 * fit.reach, 0.0)), ("y", (0.0, -2.01 * fit.reach))):
        with pytest.raises(ValueError, match=rf"^{name}: must be at most .* 2 times the patch's;"):
            fit.surface(*place)


def test_points_too_few_and_normals_without_a_mean_are_refused():
    with pytest.raises(ValueError, match=r"^contact: must be at least 250 points; got 200\.$"):
        fit_surface(*planes(200), **EXACT)
    with pytest.raises(ValueError, match=r"^n: the normals' mean must not be zero"):
        mean_frame(np.array([[0.0, 0.6, 0.8], [0.0, -0.6, -0.8]]))
