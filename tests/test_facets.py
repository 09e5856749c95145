"""Facets and boxes that move until they touch a solid: judged exactly, and by hand."""

import numpy as np
import pytest

from exhibits.exact_shapes import EPS, full_size
from tests.audit.long import many
from tests.exact_facets import judged_facets
from tests.hard_lines import KINDS, Whole, _floats, shape_of
from tunneller_lib.surfaces import Box, Frustum, Rod, meet_box
from tunneller_lib.surfaces.facet import meet_facets

every_kind = pytest.mark.parametrize("kind", KINDS)


def touching(kind, rng, n):
    """Triangles in the tangent plane of a whole point, which they hold inside, at an edge, ..."""
    whole = Whole(kind, rng, n)
    steps = rng.integers(-6, 7, (2, 2, n, 1))
    first, second = (whole.point + whole.side * step[0] + whole.ruling * step[1] for step in steps)
    which = rng.integers(0, 3, n)[:, None]
    choices = [whole.point, 2 * whole.point - first]
    third = np.select([which == 0, which == 1], choices, 3 * whole.point - first - second)
    facets = np.stack([first, second, third], axis=1).astype(float)
    u = rng.integers(-9, 10, (n, 3)).astype(float)
    u[np.all(u == 0, axis=-1)] = 1
    return whole.shapes.astype(float), facets, u


def anywhere(kind, rng, n):
    """Triangles near a shape, smaller and greater than it; a third move nearly along an edge."""
    shapes, p = _floats(kind, rng, n, rng.choice([0.5, 3]))
    spread = np.abs(shapes[:, 3:]).max(axis=-1) * 10.0 ** rng.uniform(-2, 1, n)
    facets = p[:, None] + rng.normal(size=(n, 3, 3)) * spread[:, None, None]
    u = rng.normal(size=(n, 3))
    edge = (facets[:, 1] - facets[:, 0])[::3]
    u[::3] = edge + rng.normal(size=edge.shape) * 1e-9
    return shapes, facets, u


def met(kind, shapes, facets, u):
    return np.array([
        meet_facets(shape_of(kind, shape), facet, way)
        for shape, facet, way in zip(shapes, facets, u, strict=True)
    ]).T  # fmt: skip


@every_kind
@pytest.mark.parametrize("family", [touching, anywhere], ids=lambda f: f.__name__)
@pytest.mark.parametrize("away", [0, 1e6], ids=["near", "a million sizes away"])
def test_facets_keep_the_promise(away, family, kind):
    n = many(15, 200) if kind != "rounded" else many(3, 20)
    shapes, facets, u = family(kind, np.random.default_rng(7), n)
    sizes = full_size(kind, shapes) + np.abs(facets - facets[:, :1]).max(axis=(1, 2))
    steps = np.floor(away * sizes / np.linalg.norm(u, axis=-1))
    facets = facets - (u * steps[:, None])[:, None]
    found = met(kind, shapes, facets, u)
    if family is touching:
        assert np.all(found[0] <= found[1])  # a touch is never missed
    assert not np.any(judged_facets(found, kind, shapes, facets, u))


@every_kind
def test_judge_of_facets_notices_faults(kind):
    shapes, facets, u = anywhere(kind, np.random.default_rng(2), 12 if kind != "rounded" else 5)
    enter, leave = met(kind, shapes, facets, u)
    hit = np.isfinite(enter)
    assert hit.any()
    step = np.where(hit, 1e-6 * (leave - enter) + 1e-9, 0)
    late, _ = judged_facets((enter + step, leave), kind, shapes, facets, u)
    _, early = judged_facets((enter - step, leave), kind, shapes, facets, u)
    np.testing.assert_array_equal(late, hit)
    np.testing.assert_array_equal(early, hit)


SOLIDS = {
    "rod": Rod((0, 1, 2), (3, 2, 4), 1),
    "capsule": Rod((0, 1, 2), (3, 2, 4), 1, ends="round"),
    "frustum": Frustum((0, 1, 2), (3, 2, 4), 1, 0.3),
    "box": Box((0, 1, 2), (1, 2, 2), (2, 1, -2), (2, -2, 1)),
}


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)
def test_no_line_through_a_facet_goes_further(solid):
    # Points all over a facet: none is met before it, and the nearest comes near.
    rng = np.random.default_rng(3)
    shares = rng.dirichlet([0.5] * 3, 20_000)
    for _ in range(4):
        facet, u = rng.normal(size=(3, 3)) * 2 + [1, 1, 3], rng.normal(size=3)
        enter, leave = meet_facets(solid, facet, u)
        first, last = solid.meet_line(shares @ facet, u)
        assert enter <= first.min() + 1e-14
        assert leave >= last.max() - 1e-14
        assert not np.isfinite(first.min()) or enter > first.min() - 0.05


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)
def test_boxes_in_any_pose_meet_solids(solid):
    # Two ways: the box moves towards a solid, or a solid that is a box towards the other's faces.
    rng = np.random.default_rng(4)
    edges = np.linalg.qr(rng.normal(size=(3, 3)))[0] * [[0.5], [1.0], [2.0]]
    box = Box(rng.normal(size=3) + 9, *edges)
    u = np.array([-1.0, -0.9, -0.8])
    enter, leave = meet_facets(solid, box.faces, u)
    first, last = enter.min(), leave.max()
    assert first < last
    inside = rng.beta(0.5, 0.5, size=(20_000, 3)) @ edges + box.corner
    enter, leave = solid.meet_line(inside, u)
    assert first <= enter.min() and leave.max() <= last
    assert enter.min() - first < 0.3 and last - leave.max() < 0.3
    if isinstance(solid, Box):
        back, forth = meet_facets(box, solid.faces, -u)
        np.testing.assert_allclose((back.min(), forth.max()), (first, last), rtol=1e-14)


def test_points_and_edges_are_facets():
    rod = SOLIDS["rod"]
    points = np.random.default_rng(5).normal([1, 1, 3], size=(50, 1, 3))
    u = (1.0, 2.0, 3.0)
    lines = rod.meet_line(points[:, 0], u)
    np.testing.assert_allclose(meet_facets(rod, points, u), lines, atol=16 * EPS)
    edge = [(-5, 0, 0), (5, 0, 0)]
    ball = Rod((0, 3, 0), (0, 3, 0), 2, ends="round")
    assert meet_facets(ball, edge, (0, 1, 0)) == (1, 5)
    assert meet_facets(ball, edge, (1, 0, 0)) == (np.inf, -np.inf)
    assert meet_facets(ball, np.add(edge, (20, 2, 0)), (-1, 0, 0)) == pytest.approx(
        (15 - np.sqrt(3), 25 + np.sqrt(3)), rel=1e-15
    )


def test_a_face_that_hardly_faces_its_way_touches_a_ball_in_its_middle():
    # It lies in x = 0 and comes nearer by a millionth of its way, up along z.
    face, ball = [(0, -9, -9), (0, 9, -9), (0, 0, 9)], (1 + 5e-6, 0, 5)
    enter, _ = meet_facets(Rod(ball, ball, 1, ends="round"), face, (1e-6, 0, 1))
    assert enter == pytest.approx(5, abs=1e-6)


@pytest.mark.parametrize("power", [-300, 300])
def test_facets_scale(power):
    k = 2.0**power
    for kind in KINDS:
        shapes, facets, u = anywhere(kind, np.random.default_rng(6), 3)
        for shape, facet, way in zip(shapes, facets, u, strict=True):
            found = meet_facets(shape_of(kind, shape), facet, way)
            scaled = meet_facets(shape_of(kind, shape * k), facet * k, way)
            # At the ends of the range the careful way takes all lines.
            np.testing.assert_allclose(np.divide(scaled, k), found, rtol=1e-9)


# ---- boxes ----------------------------------------------------------------------------------

POSES = ("any", "vertical", "level", "along x", "along y", "nearly vertical", "nearly level")


def rod_of(kind, rng, ends, scale=1.0):
    """Return a rod whose axis is of a kind."""
    v = rng.normal(size=3)
    v[:2] *= {"vertical": 0, "nearly vertical": 1e-9}.get(kind, 1)
    v[2] *= {"level": 0, "along x": 0, "along y": 0, "nearly level": 1e-9}.get(kind, 1)
    v *= {"along x": [1, 0, 1], "along y": [0, 1, 1]}.get(kind, 1)
    a = rng.normal(size=3)
    return Rod(a * scale, (a + v) * scale, rng.uniform(0.1, 1) * scale, ends=ends)


def searched(rod, low, high, side):
    """Return the highest (or lowest) point by zooming in on a concave height over the section."""
    best, where = -np.inf, None
    first, last = low.copy(), high.copy()
    for _ in range(60):
        x, y = (np.linspace(*ends, 13) for ends in zip(first, last, strict=True))
        grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((13, 13))], axis=-1)
        enter, leave = rod.meet_line(grid, (0, 0, 1))
        height = side * (leave if side > 0 else enter)
        height = np.where(np.isfinite(height), height, -np.inf)
        i, j = np.unravel_index(np.argmax(height), height.shape)
        if height[i, j] == -np.inf:
            return where, best
        best, where = max(best, height[i, j]), (x[i], y[j])
        span = (last - first) / 3
        first = np.maximum(low, np.array(where) - span)
        last = np.minimum(high, np.array(where) + span)
    return where, best


@pytest.mark.parametrize("ends", ["flat", "round"])
@pytest.mark.parametrize("kind", POSES)
def test_meet_box_is_what_a_search_finds(kind, ends):
    rng = np.random.default_rng(0)
    met = 0
    for _ in range(15):
        rod = rod_of(kind, rng, ends)
        low = np.array(rod.a)[:2] + rng.normal(size=2)
        high = low + rng.uniform(0.05, 2, 2)
        bottom, top = meet_box(rod, low, high)
        place, height = searched(rod, low, high, 1)
        if place is None:
            continue
        met += 1
        assert top >= height - 1e-9
        assert top <= height + 1e-4 or ends == "flat"  # a search halts at edges
        assert bottom <= -searched(rod, low, high, -1)[1] + 1e-9
        assert np.isfinite(top) and np.isfinite(bottom) and bottom <= top
    assert met >= 2


def test_meet_box_by_hand():
    post = Rod((0, 0, 1), (0, 0, 5), 2)
    assert meet_box(post, (-9, -9), (9, 9)) == (1, 5)
    assert meet_box(post, (-0.1, -0.1), (0.1, 0.1)) == (1, 5)
    assert meet_box(post, (2, -9), (9, 9)) == (1, 5)  # touches the wall
    assert meet_box(post, (2.1, -9), (9, 9)) == (np.inf, -np.inf)
    lying = Rod((0, 0, 0), (8, 0, 0), 2)
    assert meet_box(lying, (3, -1), (4, 9)) == (-2, 2)
    np.testing.assert_allclose(meet_box(lying, (3, 1), (4, 9)), (-np.sqrt(3), np.sqrt(3)))
    assert meet_box(Rod((0, 0, 0), (0, 0, 0), 1, ends="round"), (-1, -1), (1, 1)) == (-1, 1)
    assert meet_box(Rod((0, 0, 0), (0, 0, 0), 1), (-1, -1), (1, 1)) == (np.inf, -np.inf)
    with pytest.raises(ValueError, match=r"^low: must not be above high"):
        meet_box(post, (0, 2), (1, 1))


AXES = [(12, 3, 4), (8, 9, 12), (12, 4, 3), (8, 12, 9), (15, 12, 16), (3, 4, 0), (0, 3, 4)]


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_meet_box_touches_flat_rods_at_their_sides(axis, side):
    # In whole numbers: how far a disc reaches along x is its radius times a whole ratio.
    rng = np.random.default_rng(6)
    v = np.array(axis)
    wide, length = round(np.hypot(*v[1:])), round(np.linalg.norm(v))
    for _ in range(many(20, 50)):
        step = rng.integers(1, 40)
        a = rng.integers(-999, 1000, 3)
        b = a + v * rng.integers(1, 300)
        end = b if side > 0 else a
        tip = end + side * step * np.array([wide**2, -v[0] * v[1], -v[0] * v[2]])
        low = tip[:2] - (5 if side < 0 else 0, 5)
        bottom, top = meet_box(Rod(a, b, int(step * wide * length)), low, low + np.array([5, 10]))
        assert bottom <= top
        # A touch in a point of the rim, but for a lying axis: there it's a ruling or a disc.
        if v[0] and v[2]:
            size = step * wide * length + np.linalg.norm(b - a)
            # Within the guard beside the touch the rim has risen by the root of it.
            assert abs(top - tip[2]) <= 8 * np.sqrt(EPS) * size
