"""Facets that move until they touch a solid: judged exactly, in any pose, and by hand."""

import numpy as np
import pytest

from tests.audit.long import many
from tests.exact_facets import judged_facets
from tests.exact_shapes import EPS, full_size
from tests.hard_lines import KINDS, Whole, _floats
from tests.test_exact_kernel import shape_of
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
def test_facets_keep_the_promise(family, kind):
    n = many(15, 200) if kind != "rounded" else many(3, 20)
    shapes, facets, u = family(kind, np.random.default_rng(1), n)
    found = met(kind, shapes, facets, u)
    if family is touching:
        assert np.all(found[0] <= found[1])  # a touch is never missed
    assert not np.any(judged_facets(found, kind, shapes, facets, u))


@every_kind
@pytest.mark.parametrize("family", [touching, anywhere], ids=lambda f: f.__name__)
def test_facets_keep_the_promise_from_a_million_sizes_away(family, kind):
    n = many(15, 200) if kind != "rounded" else many(3, 20)
    shapes, facets, u = family(kind, np.random.default_rng(7), n)
    sizes = full_size(kind, shapes) + np.abs(facets - facets[:, :1]).max(axis=(1, 2))
    steps = np.floor(1e6 * sizes / np.linalg.norm(u, axis=-1))
    facets = facets - (u * steps[:, None])[:, None]
    found = met(kind, shapes, facets, u)
    if family is touching:
        assert np.all(found[0] <= found[1])
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


def test_meet_box_takes_every_solid():
    for solid in SOLIDS.values():
        bottom, top = meet_box(solid, (0, 0), (3, 4))
        middle = solid.meet_line((2.5, 1.5, 0), (0, 0, 1))
        assert bottom <= middle[0] <= middle[1] <= top


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


WRONG = [
    (lambda: meet_facets(1, [(0, 0, 0)], (0, 0, 1)), "solid: must be of class Rod or Frustum"),
    (lambda: meet_facets(SOLIDS["rod"], (0, 0, 0), (0, 0, 1)), "facets: must have the shape"),
    (lambda: meet_facets(SOLIDS["rod"], [(0, 0, 0)], (0, 0, 0)), "direction: must not be zero"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_input_is_told(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
