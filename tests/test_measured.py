"""Surfaces through measured points and normals, and their errors."""

from dataclasses import replace

import numpy as np
import pytest

from tests.audit.long import many
from tunneller_lib.envelopes import fit_surface
from tunneller_lib.envelopes.families import cubic, cyclide
from tunneller_lib.envelopes.fit import tilted
from tunneller_lib.envelopes.isotropic import normal, surface_points
from tunneller_lib.envelopes.jet import jet_variables

EXACT = {"contact_error": 0.0, "normal_error": 1e-6}


def patch(n=800, seed=0):
    """Return points of Example 31 with unit normals, from places about (0.45, 0.45)."""
    x, y = np.random.default_rng(seed).uniform(0.3, 0.6, (2, n))
    return surface_points(cyclide, x, y), np.stack(normal(x, y), axis=-1)


def drawn(fit, rng, times):
    """Yield fits with other coefficients, at random as the covariance has them."""
    for noise in rng.normal(size=(times, len(fit.c))):
        yield replace(fit, c=fit.c + np.linalg.solve(fit.root, noise))


def noisy(data, contact_error, normal_error, seed):
    contact, n = data
    rng = np.random.default_rng(seed)
    moved = contact + contact_error * rng.normal(size=(len(n), 1)) * n
    return moved, tilted(n, np.sqrt(2) * normal_error, rng)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_a_fit_passes_exact_points_and_has_their_normals(scale):
    contact, n = patch()
    for array in (contact, n):
        array.flags.writeable = False
    fit = fit_surface(scale * contact, n, **EXACT)
    assert fit.fits and fit.misfit < 1.2
    x, y = np.random.default_rng(1).uniform(0.4, 0.5, (2, 30))
    inner, normals = surface_points(cyclide, x, y), np.stack(normal(x, y), axis=-1)
    place = (scale * inner - fit.origin) @ fit.axes[:2].T
    there = np.stack(fit.surface(*place.T), axis=-1)
    np.testing.assert_allclose(there / scale, inner, atol=1e-12)
    step = 1e-5 * scale
    slope = [np.stack(fit.surface(*(place + d).T), -1) - there for d in ([step, 0], [0, step])]
    assert max(np.abs(np.sum(s * normals, axis=-1)).max() for s in slope) < 1e-4 * step


def test_errors_of_jets_are_those_of_coefficients_drawn_at_random():
    """Spread of 500 draws in place of the covariance's square root; in metres and millimetres."""
    for scale in (1.0, 1e-3):
        contact, n = patch(400)
        errors = {"contact_error": 1e-4 * scale, "normal_error": 1e-3}
        fit = fit_surface(scale * contact, n, **errors)
        x, y = fit.reach * np.array([[0.0, 0.3, -0.5], [0.1, -0.4, 0.6]])
        said = fit.jet_errors(x, y)
        rng = np.random.default_rng(3)
        seen = []
        for other in drawn(fit, rng, many(500, 2000)):
            r = other.surface(*jet_variables(x, y))
            seen.append(sum(part.c * axis for part, axis in zip(r, fit.axes[2], strict=True)))
        np.testing.assert_allclose(np.std(seen, axis=0), said, rtol=0.1)


def test_covariance_says_how_far_fits_of_other_noise_are_apart():
    """Heights from 60 draws scatter as one fit's own covariance says."""
    data = patch(400)
    errors = {"contact_error": 1e-3, "normal_error": 1e-2}
    fits = [fit_surface(*noisy(data, *errors.values(), seed), **errors) for seed in range(60)]
    first = fits[0]
    assert all(fit.fits for fit in fits)
    inner = data[0][:20]
    places = [(inner - fit.origin) @ fit.axes[:2].T for fit in fits]
    heights = [
        (np.stack(fit.surface(*place.T), axis=-1) - inner) @ first.axes[2]
        for fit, place in zip(fits, places, strict=True)
    ]
    every = drawn(first, np.random.default_rng(2), 400)
    own = [fit.surface(*places[0].T)[2] for fit in every]
    expected = np.std(own, axis=0) * (first.axes[2, 2] ** -1)
    assert 0.6 < np.median(np.std(heights, axis=0) / expected) < 1.6


def test_far_from_the_patch_a_fit_says_nothing():
    fit = fit_surface(*patch(), **EXACT)
    fit.surface(2 * fit.reach, 0.0)
    for name, place in (("x", (2.01 * fit.reach, 0.0)), ("y", (0.0, -2.01 * fit.reach))):
        with pytest.raises(ValueError) as refused:
            fit.surface(*place)
        assert str(refused.value) == (
            f"{name}: must be at most {2 * fit.reach:g} m in size, 2 times the patch's; "
            f"got {2.01 * fit.reach:g}."
        )


def test_the_degree_rises_as_noise_falls():
    data = patch()
    loud, quiet = (
        fit_surface(*noisy(data, error, error, 3), contact_error=error, normal_error=error)
        for error in (1e-3, 1e-7)
    )
    assert loud.fits and quiet.fits and loud.degree < quiet.degree


@pytest.mark.parametrize("seed", range(3))
def test_what_is_left_of_few_data_is_their_noise(seed):
    # 250 points give 750 equations for 153 coefficients, which take a fifth of the noise with them.
    errors = {"contact_error": 1e-3, "normal_error": 1e-3}
    fit = fit_surface(*noisy(patch(250, seed), 1e-3, 1e-3, seed), **errors)
    assert fit.fits and 0.9 < fit.misfit < 1.1
    loud = fit_surface(*noisy(patch(250, seed), 1.4e-3, 1.4e-3, seed), **errors)
    assert not loud.fits and 1.25 < loud.misfit < 1.55


@pytest.mark.parametrize(("degrees", "kept"), [(60, True), (72, False)])
def test_normals_that_lean_by_more_than_66_degrees_are_left_out(degrees, kept):
    # A cap of a ball with errors so great that a polynomial would pass all its points.
    turn, share = np.random.default_rng(13).uniform([[0], [0]], [[2 * np.pi], [1]], (2, 1500))
    share[:60] = 1
    rho = np.sin(np.radians(degrees)) * np.sqrt(share)
    n = np.stack([rho * np.cos(turn), rho * np.sin(turn), np.sqrt(1 - rho**2)], axis=-1)
    fit = fit_surface(n, n, contact_error=1e-2, normal_error=0.1)
    assert fit.fits and (len(fit.place) == len(n)) == kept
    there = fit.place @ fit.axes[:2] + fit.origin  # but for heights along the third axis
    aside = there - (there @ fit.axes[2])[:, None] * fit.axes[2]
    assert np.linalg.norm(aside, axis=-1).max() < np.sin(np.arccos(0.4)) + 0.02


def test_noise_said_too_small_fits_nothing():
    data = noisy(patch(), 1e-3, 1e-3, 4)
    fit = fit_surface(*data, contact_error=1e-5, normal_error=1e-5)
    assert not fit.fits and fit.misfit > 30


def test_where_the_middle_half_has_the_edge_another_is_kept():
    """A ridge off the middle, sharper than degree 16 follows: the points on one side of it do."""
    x, y = np.random.default_rng(9).uniform(-1, 1, (2, 2000))
    root = np.sqrt(1e-4 + (x - 0.1) ** 2)
    contact = np.stack([x, y, 0.2 * root + 0.1 * y**2], axis=-1)
    n = np.stack([-0.2 * (x - 0.1) / root, -0.2 * y, 1 + 0 * x], axis=-1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    fit = fit_surface(*noisy((contact, n), 0, 1e-4, 10), contact_error=0, normal_error=1e-4)
    kept = (fit.place @ fit.axes[:2] + fit.origin)[:, 0]
    assert fit.fits and 500 <= len(fit.place) <= 1000
    assert kept.max() < 0.1 or kept.min() > 0.1


def test_an_edge_of_regression_is_left_out():
    s, t = np.random.default_rng(5).uniform(0, 1, (2, 2000))
    centre, tangent, _ = cubic(s)
    tangent = np.stack([c + 0 * s for c in tangent], axis=-1)
    curve = np.stack([c + 0 * s for c in centre], axis=-1)
    bend = np.stack([0 * s, 2 + 0 * s, 6 * s], axis=-1)
    n = np.cross(tangent, bend)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    fit = fit_surface(curve + (0.02 + t)[:, None] * tangent, n, **EXACT)
    assert len(fit.place) < 2000


@pytest.mark.parametrize(("change", "message"), [
    (dict(zip(("contact", "n"), patch(200), strict=True)), r"^contact: .* 250 points; got 200\.$"),
    ({"n": patch(300)[1]}, r"^contact, n: .* must broadcast; got \(800,\), \(300,\)\.$"),
    ({"n": 2 * patch()[1]}, r"^n: "),
    ({"contact_error": -1.0}, r"^contact_error: "),
    ({"normal_error": -1.0}, r"^normal_error: "),
])  # fmt: skip
def test_wrong_data_are_refused(change, message):
    contact, n = patch()
    asked = {"contact": contact, "n": n} | EXACT | change
    with pytest.raises(ValueError, match=message):
        fit_surface(**asked)
