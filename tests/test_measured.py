"""Surfaces through measured points and normals, their errors, and verdicts from such data."""

import csv

import numpy as np
import pytest

from tests.envelopes_random import KINDS
from tests.long import many
from tests.measured_many import ASKED, HEAD, TABLE, example_32, tried
from tunneller_lib.envelopes import fit_surface, recognise_measured
from tunneller_lib.envelopes.families import channel, cubic, cyclide
from tunneller_lib.envelopes.fit import tilted
from tunneller_lib.envelopes.isotropic import normal, surface_points
from tunneller_lib.envelopes.jet import jet_variables
from tunneller_lib.envelopes.measured import CHANCES, drawn, point_of
from tunneller_lib.envelopes.rough import RUNS

READS = ["tests/measured.csv"]
EXACT = {"contact_error": 0.0, "normal_error": 1e-6}


def patch(n=800, seed=0):
    """Return points of Example 31 with unit normals, from places about (0.45, 0.45)."""
    x, y = np.random.default_rng(seed).uniform(0.3, 0.6, (2, n))
    return surface_points(cyclide, x, y), np.stack(normal(x, y), axis=-1)


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
        for c in drawn(fit, rng, many(500, 2000)):
            r = point_of(fit, *jet_variables(x, y), c)
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
    own = [point_of(first, *places[0].T, c)[2] for c in every]
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
    found = recognise_measured(*data, "pipe", contact_error=1e-5, normal_error=1e-5)
    assert found.verdict == "cannot tell" and found.because.startswith("no polynomial of degree 16")
    assert found.probability is None


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


def test_a_verdict_has_its_chance_and_a_radius_is_found():
    s, t = np.random.default_rng(6).uniform(0.2, 0.6, (2, 800))
    surface = channel(cubic, 0.3)
    centre = np.stack([c + 0 * s for c in cubic(s)[0]], axis=-1)
    contact = np.stack(surface(s, t), axis=-1)
    n = (centre - contact) / 0.3
    found = recognise_measured(*noisy((contact, n), 0, 1e-4, 7), "pipe", contact_error=0,
                               normal_error=1e-4)  # fmt: skip
    assert found.verdict == "is" and 0.999 < found.probability < 1
    assert found.radius == pytest.approx(0.3, rel=1e-7)
    other = recognise_measured(*noisy((contact, n), 0, 1e-4, 7), "ruled", contact_error=0,
                               normal_error=1e-4)  # fmt: skip
    assert other.verdict == "is not" and other.probability >= found.probability


def test_chances_are_those_of_ten_times_the_greatest_of_eight():
    """How seldom a normal error passes k times what eight others allow, by their distribution."""
    x = np.random.default_rng(8).normal(size=(400_000, RUNS))
    most = np.abs(x - np.median(x, axis=1)[:, None]).max(axis=1)
    # The least of many has the law of a power 7: so few draws tell how often it is below m.
    below = np.mean(most < 0.5) / 0.5**7
    steps = np.linspace(0, 0.5, 4001)[1:]
    for times, chance in CHANCES.items():
        tail = np.exp(-((10 * times * steps) ** 2) / 2)  # above the chance of more than that
        bound = np.sum(7 * below * steps**6 * tail) * (steps[1] - steps[0])
        assert 1 < bound / chance < 6


@pytest.mark.parametrize("place", [(0.5, 0.3), (0.9, 0.6), (-0.4, 1.0), (0.2, -0.7)])
def test_example_32_by_contacts_has_all_six_cones(place):
    """With normals turned by 0.1 and exact contacts, in every draw."""
    for seed in range(many(2, 20)):
        exact, found = example_32(place, seed)
        assert len(exact) == len(found) == 6
        axes = np.abs(exact.axis @ found.axis.T).max(axis=1)
        assert np.degrees(np.arccos(np.minimum(axes, 1))).max() < 1e-3


def test_no_verdict_from_noisy_data_is_wrong():
    for turn, off, _ in ASKED[:2]:
        for seed in range(many(3, 500)):
            exact, _, found = tried(seed, turn, off)
            assert found.verdict != ("is not" if exact else "is")


def test_a_small_bump_beside_a_sharp_bend_is_no_cylinder():
    """An eighth of its points, where it bends sharply, was one to half a millionth."""
    assert tried(113, 1e-6, 0.0)[2].verdict != "is"


def told(turn, off):
    """Return how many members and near-misses of the table are, are not and cannot be told."""
    lines = [line for line in TABLE.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    part = [row for row in rows if (float(row["normals"]), float(row["contacts"])) == (turn, off)]
    return {row["surface"]: [int(row[verdict]) for verdict in HEAD[3:]] for row in part}


def test_table_of_verdicts_from_data_has_no_wrong_one_and_tells_most():
    """What the report shows; `python -m tests.measured_many` makes it."""
    for turn, off, draws in ASKED:
        counts = told(turn, off)
        assert sum(map(sum, counts.values())) == draws
        if off == 0:
            assert counts["member"][1] == counts["near-miss"][0] == 0
            assert 2 * counts["member"][0] > sum(counts["member"])
            assert 2 * counts["near-miss"][1] > sum(counts["near-miss"])
    assert len(KINDS) == 6


def test_with_normals_off_by_a_millionth_three_of_ten_are_not_told_at_most():
    counts = told(1e-6, 0.0).values()
    assert sum(row[2] for row in counts) <= 0.3 * sum(map(sum, counts))


@pytest.mark.parametrize(("change", "message"), [
    (dict(zip(("contact", "n"), patch(200), strict=True)), r"^contact: .* 250 points; got 200\.$"),
    ({"n": patch(300)[1]}, r"^contact, n: .* must broadcast; got \(800,\), \(300,\)\.$"),
    ({"n": 2 * patch()[1]}, r"^n: "),
    ({"contact_error": -1.0}, r"^contact_error: "),
    ({"normal_error": -1.0}, r"^normal_error: "),
    ({"half_angle": 0.3}, r"^half_angle: belongs to cone only; got it with 'pipe'\.$"),
])  # fmt: skip
def test_wrong_data_are_refused(change, message):
    contact, n = patch()
    asked = {"contact": contact, "n": n, "kind": "pipe"} | EXACT | change
    with pytest.raises(ValueError, match=message):
        recognise_measured(**asked)
