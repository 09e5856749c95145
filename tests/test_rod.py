"""Lines against rods: whole numbers as reference, hard lines by generator, properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exhibits.rod_cases import GENERATORS, rulings, whole_rotations
from exhibits.rod_exact import judge as judged_flat
from exhibits.rod_exact import rounding
from exhibits.rod_methods import METHODS
from tests.audit.long import many
from tests.exact_shapes import judged
from tests.shapes import EPS
from tunneller_lib.surfaces import Rod
from tunneller_lib.surfaces.rod import meet_rods
from tunneller_lib.surfaces.rod_interval import frame

MANY = many(40_000, 400_000)  # lines a generator and kind of ends; the report says so: test_words
CHECKED = many(1_000, 40_000)  # of these in whole numbers, which is slow
every_generator = pytest.mark.parametrize("lines_of", GENERATORS, ids=lambda g: g.__name__)
every_end = pytest.mark.parametrize("ends", ["flat", "round"])
TOUCHING = {"whole_rims", "far_rims", "tangents", "end_planes", "rim_tangents", "along_an_axis"}


def margin(a, b, radius, p, u):
    """Return by how much the docstring lets a rod's surface be off."""
    return 64 * EPS * (radius + frame(a.T, b.T, u.T).run)


def judge(found, lines, ends):
    """Return which answers are missed, thin and thick, by the judge of either kind of ends."""
    if ends == "flat":
        return judged_flat(found, lines, margin(*lines))
    a, b, radius, p, u = lines
    shapes = np.column_stack([a, b, radius, radius, np.zeros((len(radius), 4))])
    return judged(found, "capsule", shapes, p, u)


@every_end
@every_generator
def test_meet_rods_never_misses_thins_or_thickens(lines_of, ends):
    lines = lines_of(np.random.default_rng(1), CHECKED)
    found = meet_rods(*lines, ends=ends)
    missed, thin, thick = judge(found, lines, ends)
    assert not missed.any() and not thin.any() and not thick.any()


@every_end
@every_generator
def test_meet_rods_of_many_hard_lines(lines_of, ends):
    # Each of these lines meets its rod, as whole numbers say, and its two ends are on the surface.
    lines = lines_of(np.random.default_rng(2), MANY)
    a, b, radius, p, u = lines
    enter, leave = meet_rods(*lines, ends=ends)
    hit = enter <= leave
    assert hit.all() or lines_of.__name__ not in TOUCHING
    assert np.all((enter == np.inf) & (leave == -np.inf) | hit)
    slack = rounding((enter, leave), lines) * np.linalg.norm(u, axis=-1) + margin(*lines)
    for t in (enter, leave):
        off = distance_outside(a, b, radius, p + np.where(hit, t, 0)[:, None] * u, ends)
        # The point itself is rounded at the size of its coordinates.
        noise = 16 * EPS * (np.abs(p).max(axis=-1) + np.abs(np.where(hit, t, 0)) *
                            np.abs(u).max(axis=-1))  # fmt: skip
        assert np.all(np.abs(off[hit]) <= (slack + noise)[hit])


@every_end
@pytest.mark.parametrize("slight", ["tilt", "length"])
def test_meet_line_of_one_rod_with_a_slight_tilt_or_length(slight, ends):
    # Many lines of one direction: through rims, the wall, the inside.
    rng = np.random.default_rng(11)
    n = 60
    for i in range(60):
        u = np.array([(0, 0, 1), (0, -3, 0), (1, 2, -2), rng.normal(size=3)][i % 4], dtype=float)
        along, radius = u / np.linalg.norm(u), 10.0 ** rng.uniform(-3, 3)
        aside = np.cross(along, rng.normal(size=3))
        axis = radius * rng.normal(size=3) * 10.0 ** rng.uniform(-17, -8)
        if slight == "tilt":
            axis = radius * (along * 10.0 ** rng.uniform(-1, 4) +
                             aside * 10.0 ** rng.uniform(-16, -7))  # fmt: skip
        a = rng.normal(size=3) * radius * (i % 3 == 0 and slight == "tilt")
        rod = Rod(a, a + axis, radius, ends=ends)
        side = np.cross(rod.axis, rng.normal(size=(n, 3)))
        side *= radius / np.linalg.norm(side, axis=-1, keepdims=True)
        side *= rng.choice([1, 1, 1 - EPS, 1 + EPS, 0.3], (n, 1))
        p = rod.a + rng.choice([0, 0.5, 1], (n, 1)) * rod.axis + side
        p += rng.choice([0, 7, 1e6], (n, 1)) * radius * along
        lines = *np.broadcast_arrays(rod.a, rod.b, p)[:2], np.full(n, radius), p
        lines = *lines, np.broadcast_to(u, p.shape).copy()
        assert not np.any(judge(rod.meet_line(p, u), lines, ends))


@every_end
@pytest.mark.parametrize("together", [True, False])
def test_meet_rods_over_the_whole_range_of_sizes(together, ends):
    # Radius, length and direction from 1e-99 to 1e99, of one size or each of its own.
    rng, n = np.random.default_rng(12), many(1_000, 3_000)
    radius, length, speed = 10.0 ** rng.uniform(-99, 99, (3, n))
    if together:
        length = np.clip(radius * 10.0 ** rng.uniform(-3, 3, n), 1e-99, 1e99)
    unit, u = rng.normal(size=(2, n, 3))
    unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
    side = np.cross(unit, rng.normal(size=(n, 3)))
    side *= (radius / np.linalg.norm(side, axis=-1))[:, None] * rng.choice([1, 0.5], (n, 1))
    b = unit * length[:, None]
    p = side + b * rng.integers(0, 2, (n, 1))
    lines = 0 * b, b, radius, p, u * speed[:, None]
    found = meet_rods(*lines, ends=ends)
    assert not np.any(judge(found, lines, ends))
    for i in range(many(60, 200)):
        one = tuple(row[i : i + 1] for row in lines)
        alone = Rod(b[i] * 0, b[i], radius[i], ends=ends).meet_line(p[i : i + 1], one[4][0])
        assert not np.any(judge(alone, one, ends))


def distance_outside(a, b, radius, points, ends):
    """Return how far points are outside the surface of rods; a second way, by the point."""
    v, q = b - a, points - a
    length = np.linalg.norm(v, axis=-1)
    unit = v / np.where(length > 0, length, 1)[:, None]
    along = np.einsum("ni,ni->n", q, unit)
    off = np.linalg.norm(q - along[:, None] * unit, axis=-1)
    beyond = np.maximum(-along, along - length)
    if ends == "round":
        return np.hypot(np.maximum(beyond, 0), off) - radius
    return np.maximum(beyond, off - radius)


@every_generator
@pytest.mark.parametrize("power", [-40, 7, 90])
def test_meet_rods_scales_by_powers_of_two_bit_for_bit(lines_of, power):
    a, b, radius, p, u = lines_of(np.random.default_rng(3), 500)
    k = 2.0**power
    for ends in ("flat", "round"):
        found = meet_rods(a, b, radius, p, u, ends=ends)
        scaled = meet_rods(a * k, b * k, radius * k, p * k, u, ends=ends)
        faster = meet_rods(a, b, radius, p, u * k, ends=ends)
        np.testing.assert_array_equal(np.multiply(found, k), scaled)
        np.testing.assert_array_equal(found, np.multiply(faster, k))


@every_end
@every_generator
def test_meet_rods_does_not_mind_the_order_of_the_ends(lines_of, ends):
    a, b, radius, p, u = lines = lines_of(np.random.default_rng(4), 500)
    swapped = meet_rods(b, a, radius, p, u, ends=ends)
    missed, thin, thick = judge(swapped, lines, ends)
    assert not (missed | thin | thick).any()


@every_generator
def test_meet_rods_turns_with_the_line(lines_of):
    a, b, radius, p, u = lines_of(np.random.default_rng(5), 500)
    for ends in ("flat", "round"):
        enter, leave = meet_rods(a, b, radius, p, u, ends=ends)
        back = meet_rods(a, b, radius, p, -u, ends=ends)
        lines = a, b, radius, p, u
        for verdict in judge((-back[1], -back[0]), lines, ends):
            assert not verdict.any()
        assert np.all((enter <= leave) == (back[0] <= back[1]))


def draws(seed, n=2000):
    rng = np.random.default_rng(seed)
    a, b, p, aim = rng.normal(size=(4, n, 3))
    return a, b, rng.uniform(0.1, 2, n), p, aim - p


def test_meet_rods_of_halves_join():
    a, b, radius, p, u = draws(6)
    middle = (a + b) / 2
    enter, leave = meet_rods(a, b, radius, p, u)
    first, second = meet_rods(a, middle, radius, p, u), meet_rods(middle, b, radius, p, u)
    np.testing.assert_allclose(np.minimum(first[0], second[0]), enter, atol=1e-12)
    np.testing.assert_allclose(np.maximum(first[1], second[1]), leave, atol=1e-12)
    capsule = meet_rods(a, b, radius, p, u, ends="round")
    balls = [meet_rods(end, end, radius, p, u, ends="round") for end in (a, b)]
    lows, highs = (np.array(side) for side in zip((enter, leave), *balls, strict=True))
    np.testing.assert_allclose(lows.min(axis=0), capsule[0], atol=1e-7)  # a root near tangents
    np.testing.assert_allclose(highs.max(axis=0), capsule[1], atol=1e-7)


@every_end
def test_meet_rods_grows_with_the_radius(ends):
    a, b, radius, p, u = draws(7)
    last = np.full(len(p), np.inf), np.full(len(p), -np.inf)
    for share in np.linspace(0, 1, 30):
        found = meet_rods(a, b, radius * share, p, u, ends=ends)
        assert np.all(found[0] <= last[0] + 1e-12) and np.all(found[1] >= last[1] - 1e-12)
        last = found


@every_end
def test_meet_rods_turns_with_the_frame(ends):
    rng = np.random.default_rng(8)
    a, b, radius, p, u = draws(8)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found = meet_rods(a, b, radius, p, u, ends=ends)
    turned = meet_rods(a @ turn, b @ turn, radius, p @ turn, u @ turn, ends=ends)
    np.testing.assert_allclose(turned, found, rtol=1e-6, atol=1e-7)  # near tangents a root


@every_end
@given(st.integers(0, 2**32 - 1))
def test_contains_what_lines_run_through(ends, seed):
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.integers(-6, 7)
    rod = Rod(*(rng.normal(size=(2, 3)) * scale), rng.uniform(0.1, 2) * scale, ends=ends)
    p, u = rng.normal(size=(2, 50, 3)) * scale
    enter, leave = rod.meet_line(p, u)
    hit = enter <= leave
    p, u, enter, leave = p[hit], u[hit], enter[hit], leave[hit]
    inside = enter + np.linspace(0.001, 0.999, 5)[:, None] * (leave - enter)
    beyond = leave + np.array([0.001, 1])[:, None] * (1 + np.abs(leave))
    assert rod.contains(p + inside[..., None] * u).all()
    assert not rod.contains(p + beyond[..., None] * u).any()


def test_contains_surface_and_ends():
    rod = Rod((0, 0, 0), (90, 0, 120), 25)
    assert rod.contains([(16, 15, -12), (0, 25, 0), (90, 0, 120), (0, 0, 0)]).all()
    assert not rod.contains([(16, 15, -12.001), (0, 25.001, 0), (-3, 0, -4)]).any()
    assert Rod((0, 0, 0), (1, 0, 0), 1, ends="round").contains([(-1, 0, 0), (2, 0, 0)]).all()
    assert not Rod((1, 1, 1), (1, 1, 1), 1).contains((1, 1, 1))
    assert Rod((1, 1, 1), (1, 1, 1), 1, ends="round").contains((1, 1, 2))
    assert Rod((0, 0, 0), (2, 0, 0), 0).contains([(1, 0, 0), (1, 1e-9, 0)]).tolist() == [
        True,
        False,
    ]


@every_end
def test_lines_of_one_direction_have_the_bits_of_lines_with_a_direction_each(ends):
    rng = np.random.default_rng(9)
    for direction in ((0, 0, 1), (0, -3, 0), (1, 2, -2), (90, 0, 120), (1e-9, 0, 1)):
        rod = Rod((1, 2, 3), (91, 2, 123), 25, ends=ends)
        p = rng.uniform(-150, 150, (40_000, 3))
        p[:100] = np.array(rod.a) + np.linspace(-1, 2, 100)[:, None] * rod.axis
        fast = rod.meet_line(p.reshape(200, 200, 3), direction)
        slow = rod.meet_line(p, np.broadcast_to(np.array(direction, float), p.shape))
        for one, other in zip(fast, slow, strict=True):
            np.testing.assert_array_equal(one, other.reshape(200, 200))
        assert np.isfinite(fast[0]).any() and not np.isfinite(fast[0]).all()


@every_end
def test_parallel_lines_along_the_axes_leave_the_points_as_they_are(ends):
    rng = np.random.default_rng(10)
    p = rng.uniform(-1, 2, (500, 3))
    kept = p.copy()
    p.flags.writeable = False
    for end in ((2, 0, 2), (0, 2, 2), (2, 2, 0), (0, 0, 2), (1, 2, 2)):
        for direction in np.eye(3):
            Rod((0, 0, 0), end, 1, ends=ends).meet_line(p, direction)
    np.testing.assert_array_equal(p, kept)


@every_end
@pytest.mark.parametrize("far", [0, 2**20])
@pytest.mark.parametrize("direction", [(0, 0, 1), (-3, 0, 0), (1, -2, 2), (90, 0, 120), (4, 0, -3)])
def test_parallel_lines_through_rims(direction, far, ends):
    rod = Rod((1, 2, 3), (91, 2, 123), 25, ends=ends)
    turn = np.array([[7, 24], [24, 7], [15, 20], [20, 15], [25, 0], [0, 25]])
    turn = np.concatenate([turn * sign for sign in ([1, 1], [-1, 1], [1, -1], [-1, -1])])
    rim = turn[:, :1] * np.array([0.8, 0, -0.6]) + turn[:, 1:] * np.array([0, 1, 0])
    level = np.linspace(0, 1, 7)[:, None, None] * rod.axis
    p = (np.add(rod.a, level + rim) - far * np.array(direction)).reshape(-1, 3)
    lines = tuple(np.broadcast_to(x, (len(p), 3)) for x in (rod.a, rod.b))
    lines += np.full(len(p), 25.0), p, np.broadcast_to(np.array(direction, float), p.shape)
    verdicts = judge(rod.meet_line(p, direction), lines, ends)
    assert not np.any(verdicts)


def test_meet_line_edge_cases():
    rod = Rod((0, 0, 0), (0, 0, 2), 1)
    cases = {
        ((1, 0, -5), (0, 0, 1)): (5, 7),  # along the wall
        ((0.5, 0, -5), (0, 0, -1)): (-7, -5),  # inside, backwards
        ((1.0000001, 0, -5), (0, 0, 1)): (np.inf, -np.inf),
        ((-5, 0, 2), (1, 0, 0)): (4, 6),  # in an end's plane
        ((-5, 1, 2), (1, 0, 0)): (5, 5),  # touches a rim
        ((-5, 1, 1), (1, 0, 0)): (5, 5),  # touches the wall
        ((-5, 0, 2.0000001), (1, 0, 0)): (np.inf, -np.inf),
        ((0, 0, 1), (0, 0, 4)): (-0.25, 0.25),
    }
    for (p, u), expected in cases.items():
        assert rod.meet_line(p, u) == expected
    segment = Rod((0, 0, 0), (0, 0, 2), 0)
    assert segment.meet_line((-1, 0, 1), (1, 0, 0)) == (1, 1)
    assert segment.meet_line((0, 0, -1), (0, 0, 1)) == (1, 3)
    assert Rod((1, 1, 1), (1, 1, 1), 1).meet_line((0, 1, 1), (1, 0, 0)) == (np.inf, -np.inf)
    ball = Rod((1, 1, 1), (1, 1, 1), 1, ends="round")
    assert ball.meet_line((0, 1, 1), (1, 0, 0)) == (0, 2)
    assert ball.meet_line((0, 2, 1), (1, 0, 0)) == (1, 1)


@pytest.mark.parametrize("far", [0.0, 2.0**40, -(2.0**40)])
def test_meet_line_far_along_the_line(far):
    # Exactly through the axis' middle, from any distance: Torus.meet_line asks no less.
    rod = Rod((0, 0, -1), (0, 0, 1), 1)
    enter, leave = rod.meet_line((far * 3, far * 4, 0), (3, 4, 0))
    assert leave - enter == pytest.approx(0.4, abs=4 * EPS * abs(far) + 1e-15)
    tilted = Rod((0, 0, -1), (0, 0, 1), 1).meet_line((3 * far, 4 * far + 1, far), (3, 4, 1))
    near = Rod((0, 0, -1), (0, 0, 1), 1).meet_line((0, 1, 0), (3, 4, 1))
    np.testing.assert_allclose(np.add(tilted, far), near, atol=4 * EPS * abs(far) + 1e-14)


@pytest.mark.parametrize("method", ["three-surfaces", "epsilon", "slab"])
def test_other_methods_agree_away_from_edges(method):
    a, b, radius, p, u = draws(10)
    exact = meet_rods(a, b, radius, p, u)
    found = METHODS[method](a, b, radius, p, u)
    clear = np.isfinite(exact[0]) & (exact[1] - exact[0] > 1e-3)
    np.testing.assert_allclose(np.array(found)[:, clear], np.array(exact)[:, clear], atol=2e-3)


WRONG = [
    (lambda: Rod((0, 0), (1, 0, 0), 1), "a: the last axis must hold x, y, z"),
    (lambda: Rod((0, 0, 0), [(1, 0, 0)], 1), r"b: must have the shape \(3,\); got \(1, 3\)"),
    (lambda: Rod((0, 0, np.nan), (1, 0, 0), 1), "a: must hold finite numbers; got nan"),
    (lambda: Rod((0, 0, 0), (1, 0, np.inf), 1), "b: must hold finite numbers; got inf"),
    (lambda: Rod((0, 0, 0), (1, 0, 0), -1), "radius: must be one finite number, not below zero"),
    (lambda: Rod((0, 0, 0), (1, 0, 0), np.nan), "radius: must be one finite number"),
    (lambda: Rod((0, 0, 0), (1, 0, 0), 1, ends="hemi"), 'ends: must be "flat" or "round"'),
    (lambda: ROD.meet_line((0, 0, 0), (0, 0, 0)), r"direction: must not be zero; got \(0, 0, 0\)"),
    (lambda: ROD.meet_line((0, 0, np.nan), (0, 0, 1)), "point: must hold finite numbers; got nan"),
    (lambda: ROD.meet_line((0, 0, 0), (0, np.inf, 1)), "direction: must hold finite numbers"),
    (lambda: ROD.contains((0, 0, np.nan)), "points: must hold finite numbers"),
    (lambda: meet_rods(*ENDS, [1, -1], (0, 0, 0), (0, 0, 1)), "radius: must not be below zero"),
    (lambda: Rod(*ENDS, 1e-101), "radius: must be zero or from 1e-100 to 1e[+]100 in size, whose"),
    (lambda: Rod((0, 0, 0), (0, 1e-170, 0), 1), "b - a: must be zero or from 1e-100"),
    (lambda: Rod((0, 0, 0), (0, 2e100, 0), 1), "b: must hold numbers of at most 1e[+]100 in size"),
    (lambda: meet_rods(*ENDS, [1, 1e-200], (0, 0, 0), (0, 0, 1)), "radius: must be zero or from"),
    (lambda: meet_rods(*ENDS, 1, (0, 0, 0), (0, 0, 1e-170)), "direction: must be from"),
    (lambda: meet_rods(*ENDS, 1, (0, 1e150, 0), (0, 0, 1)), "point: must hold numbers of at most"),
    (lambda: ROD.meet_line((0, 1e150, 0), (0, 0, 1)), "point: must hold numbers of at most"),
    (lambda: ROD.meet_line((0, 1, 0), (0, 0, 1e101)), "direction: must be from 1e-100"),
    (lambda: ROD.contains((0, 1e150, 0)), "points: must hold numbers of at most"),
]  # fmt: skip
ENDS = (0, 0, 0), (1, 0, 0)
ROD = Rod(*ENDS, 1)


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()


def test_whole_rotations_are_of_small_numbers():
    matrix, N = whole_rotations(np.random.default_rng(1), 2_000)
    np.testing.assert_array_equal(matrix @ np.swapaxes(matrix, 1, 2), N[:, None, None] ** 2
                                  * np.eye(3, dtype=int))  # fmt: skip
    assert 0 < N.min() and N.max() <= 4 * 9**2


def test_lines_beside_a_ruling_are_off_by_last_bits():
    a, b, radius, p, _ = rulings(np.random.default_rng(1), 500)
    axis = (b - a) / np.linalg.norm(b - a, axis=-1, keepdims=True)
    distance = np.linalg.norm(np.cross(p - a, axis), axis=-1)
    assert 0 < np.max(np.abs(distance / radius - 1)) < 1e-14


def test_meet_line_touches_the_rim_of_a_nearly_vertical_rod_where_it_is():
    axis = (-3.8534266197128644e-14, 3.084093971681962e-14, 16.978424326584722)
    rod = Rod((0, 0, 0), axis, 0.08605578297597163)
    point = (-0.07904269999452951, 0.03402718561959727, 16.978424326584722)
    enter, leave = rod.meet_line(point, (0, 0, 1.0))
    assert enter <= leave <= 1e-14


def test_meet_line_of_a_rod_shorter_than_its_rounding_keeps_to_its_disc():
    # A disc tilted by half a right angle: its shadow is as wide as 0.7071.
    rod = Rod((0, 0, 0), (1e-15, 0, 1e-15), 1.0)
    enter, leave = rod.meet_line((0.9, 0, 0), (0, 0, 1.0))
    assert leave < enter
    enter, leave = rod.meet_line((0.7, 0, 0), (0, 0, 1.0))
    assert enter == pytest.approx(-0.7) and leave == pytest.approx(-0.7)


def test_slab_finds_nothing_in_a_rod_of_no_length():
    enter, leave = METHODS["slab"]((0, 0, 0), (0, 0, 0), 1.0, (0, 0, 0), (0, 0, 1.0))
    assert leave < enter
