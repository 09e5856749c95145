"""Facets, boxes and cutters that move until they touch a solid: judged exactly, and by hand."""

import numpy as np
import pytest

from exhibits.exact_shapes import EPS, full_size
from tests.audit.long import many
from tests.exact_facets import judged_facets, meets
from tests.hard_lines import KINDS, Whole, _floats, shape_of
from tunneller_lib.surfaces import Box, Frustum, Rod, RoundedDisc, drop_cutter, meet_box
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


# ---- cutters --------------------------------------------------------------------------------


def mill(height):
    """Return a cone of the radius 3 m and its shank, which ends 20 m high."""
    return [Frustum((0, 0, 0), (0, 0, height), 0, 3), Rod((0, 0, height), (0, 0, 20), 3)]


STEEP = 3 / np.tan(np.radians(59))  # m, how high the drill's cone is
CUTTERS = {
    "ball": [Rod((0, 0, 3), (0, 0, 17), 3, ends="round")],
    "bull": [RoundedDisc((0, 0, 1), (0, 0, 1), 2, 1), Rod((0, 0, 1), (0, 0, 20), 3)],
    "flat": [Rod((0, 0, 0), (0, 0, 20), 3)],
    "drill": mill(STEEP),
    "blade": [Box((-3, -0.5, 0), (6, 0, 0), (0, 1, 0), (0, 0, 20))],
    "leaning pick": [Frustum((0, 0, 0.5), (4, 0, 6), 0.2, 2), Rod((4, 0, 6), (8, 0, 12), 2)],
}
every_cutter = pytest.mark.parametrize("cutter", CUTTERS.values(), ids=CUTTERS)


@every_cutter
def test_cutter_comes_to_rest_on_a_point(cutter):
    # Where it rests no point is inside, and a little lower one is.
    rng = np.random.default_rng(1)
    points = rng.uniform([-10, -10, -2], [10, 10, 2], (400, 3))
    places = rng.uniform(-6, 6, (40, 2))
    heights = drop_cutter(cutter, points, places)
    assert np.isfinite(heights).all()
    for lift, inside in ((1e-9, False), (-1e-9, True)):
        for place, height in zip(places, heights, strict=True):
            tip = np.array([*place, height + lift])
            ends = [part.meet_line(points - tip, (0, 0, 1)) for part in cutter]
            assert any(np.any((enter <= 0) & (leave >= 0)) for enter, leave in ends) == inside


def test_profiles_by_hand():
    away = np.array([0.0, 1, 2, 2.9, 3])
    places = np.stack([-away, 0 * away], axis=-1)
    profiles = {
        "ball": np.sqrt(9 - away**2) - 3,
        "bull": np.sqrt(1 - np.maximum(away - 2, 0) ** 2) - 1,
        "flat": 0 * away,
        "drill": -away * STEEP / 3,
    }
    for name, heights in profiles.items():
        found = drop_cutter(CUTTERS[name], [(0, 0, 0)], places)
        np.testing.assert_allclose(found, heights, atol=32 * EPS)
    beyond = drop_cutter(CUTTERS["drill"], [(0, 0, 0)], [(3.0001, 0), (0, -4)])
    assert np.all(beyond == -np.inf)
    assert drop_cutter(CUTTERS["drill"], np.empty((0, 3)), (0, 0)) == -np.inf


def mesh(seed, n=7):
    """Return corners and triangles of a rough ground."""
    rng = np.random.default_rng(seed)
    along = np.linspace(-9, 9, n)
    x, y = np.meshgrid(along, along, indexing="ij")
    points = np.stack([x, y, rng.uniform(-1, 1, (n, n))], axis=-1).reshape(-1, 3)
    points[:, :2] += rng.uniform(-0.5, 0.5, (n * n, 2))
    number = np.arange(n * n).reshape(n, n)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(three, axis=-1).reshape(-1, 3)
                            for three in ((a, b, c), (a, c, d))])  # fmt: skip
    return points, faces


def rows_of(cutter):
    """Return the parts of a cutter as the judge's kinds and rows."""
    rows = {
        Box: lambda p: ("box", [*p.corner, *p.x, *p.y, *p.z]),
        RoundedDisc: lambda p: ("rounded", [*p.centre, *p.axis, p.radius, p.corner]),
        Frustum: lambda p: ("frustum", [*p.a, *p.b, p.radius_a, p.radius_b]),
        Rod: lambda p: ({"flat": "rod"}.get(p.ends, "capsule"), [*p.a, *p.b, p.radius, p.radius]),
    }
    for part in cutter:
        kind, numbers = rows[type(part)](part)
        yield kind, [float(number) for number in (*numbers, *[0] * (12 - len(numbers)))]


@every_cutter
def test_drop_on_triangles_is_exact(cutter):
    # A little lower it's in a triangle, a little higher in none: 64 roundings of cutter and mesh.
    points, faces = mesh(5)
    places = np.random.default_rng(6).uniform(-5, 5, (many(2, 20), 2))
    heights = drop_cutter(cutter, points, places, faces=faces)
    size = 60.0  # m, of the greatest part, a triangle and the distance between them
    slack = 16 * EPS * size
    for place, height in zip(places, heights, strict=True):
        triangles = points[faces] - [*place, 0]
        low, high = triangles.min(axis=1), triangles.max(axis=1)
        near = np.all(np.abs(low[:, :2]) < 12, axis=-1) & (high[:, 2] > height - 1)
        for t, grow, expected in (
            (-height + slack, 64 * EPS * size, True),
            (-height - slack, -64 * EPS * size, False),
        ):
            met = any(
                meets(kind, row, triangle, [0.0, 0.0, 1.0], t, grow)
                for kind, row in rows_of(cutter)
                for triangle in triangles[near]
            )
            assert met == expected


def test_drop_of_parts_and_blocks_is_the_highest(monkeypatch):
    points, faces = mesh(3)
    places = np.random.default_rng(4).uniform(-6, 6, (30, 2))
    for cutter in CUTTERS.values():
        whole = drop_cutter(cutter, points, places, faces=faces)
        each = [drop_cutter([part], points, places, faces=faces) for part in cutter]
        np.testing.assert_array_equal(np.max(each, axis=0), whole)
        with monkeypatch.context() as patch:
            patch.setattr("tunneller_lib.surfaces.facet.PAIRS", 100)
            parts = drop_cutter(cutter, points, places.reshape(5, 6, 2), faces=faces)
        np.testing.assert_array_equal(parts.ravel(), whole)


def test_drop_on_triangles_by_hand():
    # A roof of 45 degrees: on its face, over its lower edge, and beyond.
    roof, faces = [(-90, 0, 0), (90, 0, 0), (0, 400, 400)], [(0, 1, 2)]
    half = np.sqrt(0.5)
    above = {"ball": 3 / half - 3, "flat": 3.0, "bull": 2 + 1 / half - 1, "drill": 3 - STEEP}
    for name, height in above.items():
        found = drop_cutter(CUTTERS[name], roof, [(0, 10), (0, -3.5)], faces=faces)
        np.testing.assert_allclose(found, [10 + height, -np.inf], rtol=64 * EPS)
    # A level edge that the axis is 2 beside; and over an upright triangle, which is edges alone.
    for edge in ([(-90, 2, 0), (90, 2, 0), (0, 2, -9)], [(-90, 2, 0), (90, 2, 0), (0, 200, -9000)]):
        found = {
            name: float(drop_cutter(CUTTERS[name], edge, (0, 0), faces=faces)) for name in above
        }
        assert found["flat"] == 0
        assert found["bull"] == pytest.approx(0, abs=64 * EPS)
        assert found["ball"] == pytest.approx(np.sqrt(5) - 3, rel=64 * EPS)
        assert found["drill"] == pytest.approx(-2 * STEEP / 3, rel=64 * EPS)


def test_cone_on_a_slanting_edge():
    # Over the edge the height is 1 + x/4 - sqrt(x^2 + 1); opencamlib 2023.1.11 has 0.0076.
    edge = [(-4, 1, 0), (4, 1, 2), (0, 9, -9)]
    found = drop_cutter(mill(3), edge, (0, 0), faces=[(0, 1, 2)])
    assert found == pytest.approx(1 - np.sqrt(15) / 4, rel=64 * EPS)
    with pytest.raises(ValueError, match=r"^faces: must name one of 3 points; got 3"):
        drop_cutter(mill(3), edge, (0, 0), faces=[(0, 1, 3)])
