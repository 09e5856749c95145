"""Sections made of arcs and lines: circle, horseshoe, egg, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.audit.long import many
from tunneller_lib.surfaces import REFERENCE_MACHINE, Arc, Egg, Line, closed_profile

QUARTER = np.pi / 2
CIRCLE = [Arc(0.0, 0.0, 0.6, 0.0, 2 * np.pi)]


def horseshoe(radius=0.5, wall=0.4, bend=0.25):
    """Return the pieces of a roof's half circle, straight walls, rounded bends, a flat floor."""
    floor = 2 * (radius - bend)
    return [
        Arc(0.0, 0.0, radius, 0.0, np.pi),
        Line(-radius, 0.0, -QUARTER, wall),
        Arc(bend - radius, -wall, bend, np.pi, QUARTER),
        Line(bend - radius, -wall - bend, 0.0, floor),
        Arc(radius - bend, -wall, bend, -QUARTER, QUARTER),
        Line(radius, -wall, QUARTER, wall),
    ]


CORNERS = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
SQUARE = [Line(y, z, k * QUARTER, 1.0) for k, (y, z) in enumerate(CORNERS)]
WEDGE = [
    Arc(-0.2, -0.3, 1.0, 0.0, QUARTER),
    Line(-0.2, 0.7, -QUARTER, 1.0),
    Line(-0.2, -0.3, 0.0, 1.0),
]
SHAPES = pytest.mark.parametrize(
    "pieces, area, perimeter",
    [
        (WEDGE, np.pi / 4, np.pi / 2 + 2),
        (CIRCLE, np.pi * 0.36, np.pi * 1.2),
        (horseshoe(), np.pi * 0.125 + 0.4 + 0.25 * 0.5 + np.pi * 0.03125,
         np.pi * 0.5 + 0.8 + 0.5 + np.pi * 0.25),
        (SQUARE, 1.0, 4.0),
        (list(Egg(0.5).arcs), Egg(0.5).area, Egg(0.5).perimeter),
    ],
    ids=["wedge", "circle", "horseshoe", "square", "egg"],
)  # fmt: skip


@SHAPES
def test_closed_profile_has_its_area_and_perimeter(pieces, area, perimeter):
    section = closed_profile(pieces)
    assert section.area == pytest.approx(area, rel=1e-14)
    assert section.perimeter == pytest.approx(perimeter, rel=1e-14)
    y, z = section.point(np.linspace(0, perimeter, 40_001)).T
    assert np.sum(y * np.roll(z, -1) - z * np.roll(y, -1)) / 2 == pytest.approx(area, rel=1e-4)
    np.testing.assert_allclose(section.box, [(y.min(), z.min()), (y.max(), z.max())], atol=1e-6)


def test_depth_over_a_gap_that_is_accepted():
    floor = Line(-0.5, -0.5, 0.0, 0.5 - 3e-12), Line(0.0, -0.5, 0.0, 0.5)
    section = closed_profile([*floor, *SQUARE[1:]])
    assert section.depth(-1.5e-12, -0.2) == pytest.approx(0.3, abs=1e-11)
    assert section.ray(-QUARTER) == pytest.approx(0.5, abs=1e-11)


@SHAPES
def test_depth_against_the_nearest_of_many_points(pieces, area, perimeter):
    section = closed_profile(pieces)
    curve = section.point(np.linspace(0, perimeter, 20_001))
    points = np.random.default_rng(6).uniform(-1.2, 1.2, (300, 2))
    far = cKDTree(curve).query(points)[0]
    depth = section.depth(*points.T)
    np.testing.assert_allclose(np.abs(depth), far, atol=2e-4)
    corner, other = curve[:-1], curve[1:] - curve[:-1]
    side = other[:, 0] * (points[:, None, 1] - corner[:, 1]) - other[:, 1] * (
        points[:, None, 0] - corner[:, 0]
    )
    assert np.array_equal(np.all(side > -1e-9, axis=1)[far > 1e-3], (depth > 0)[far > 1e-3])


@SHAPES
def test_ray_ends_on_the_curve(pieces, area, perimeter):
    section = closed_profile(pieces)
    angle = np.linspace(0, 7, 200)
    distance = section.ray(angle)
    on = section.depth(distance * np.cos(angle), distance * np.sin(angle))
    np.testing.assert_allclose(on, 0, atol=1e-13)


def test_normal_is_across_the_tangent_on_arcs_and_lines():
    section = closed_profile(horseshoe())
    s = np.linspace(0, section.perimeter, 997)
    tangent = (section.point(s + 1e-6) - section.point(s - 1e-6)) / 2e-6
    np.testing.assert_allclose(np.sum(tangent * section.normal(s), axis=-1), 0, atol=1e-4)
    outside = section.point(s) + 0.01 * section.normal(s)
    np.testing.assert_allclose(section.depth(*outside.T), -0.01, atol=1e-12)


def test_offset_of_a_section_with_a_corner_is_refused():
    for d in (0.01, 0.0, -0.3):
        with pytest.raises(ValueError, match="d: a section with a corner has no offset"):
            closed_profile(SQUARE).offset(d)


def test_depth_about_every_blend_of_a_profile_that_snaps_is_steady():
    """No point falls into a gap, on the section or on its offsets."""
    down = np.arctan2(0.875, 0.3)  # of a mouth profile: where bend and floor meet
    mouth = [(0, 0, 0.5, 0, np.pi), (-0.3, 0, 0.2, np.pi, down),
             (0, 0.875, 1.125, np.pi + down, np.pi - 2 * down),
             (0.3, 0, 0.2, -down, down)]  # fmt: skip
    section = closed_profile([Arc(*arc) for arc in np.round(mouth, 7).tolist()])
    assert 1e-8 < section.slack < 1e-6
    for profile in (section, section.offset(0.1), section.offset(-1.0)):
        steps = np.linspace(-3e-6, 3e-6, 1001)
        for s in profile.blends[:-1]:
            point, normal = profile.point(s), profile.normal(s)
            tangent = np.array([-normal[1], normal[0]])
            for inside in (1e-3, 0.0, -1e-3):
                y, z = (point - inside * normal + steps[:, None] * tangent).T
                np.testing.assert_allclose(profile.depth(y, z), inside, atol=1e-6)


def test_gap_may_be_what_snap_says_and_no_more():
    for snap in (0.0, 1e-9, 1e-4):
        wide = changed(1, length=0.4 + 1.01 * snap + 1e-11)
        with pytest.raises(ValueError, match="3 of 6 doesn't begin where the last one ended"):
            closed_profile(wide, snap=snap)
        close = changed(1, length=0.4 + 0.99 * snap)
        section = closed_profile(close, snap=snap)
        assert section.slack == pytest.approx(0.99 * snap, abs=1e-12)
        assert section.least_radius == 0.25


def test_turn_may_be_what_snap_says_of_the_perimeter_and_no_more():
    snap, perimeter = 1e-4, closed_profile(horseshoe()).perimeter
    for share in (0.99, 1.01):
        turn = share * snap / perimeter
        bent = changed(0, sweep=np.pi + turn)
        if share > 1:
            with pytest.raises(ValueError, match="never turn to the right; 2 of 6"):
                closed_profile(bent, snap=snap)
        else:  # the turn leaves a gap, too
            slack = closed_profile(bent, snap=snap).slack
            assert slack == pytest.approx(turn * (0.5 + perimeter), rel=1e-4)


def changed(index, **fields):
    pieces = horseshoe()
    pieces[index] = replace(pieces[index], **fields)
    return pieces


@pytest.mark.parametrize(
    "pieces, message",
    [
        (horseshoe()[:-1], "1 of 5 isn't met: it isn't closed; the gap is 0.4 m"),
        (changed(1, length=0.4 + 1.1e-6), "3 of 6 doesn't begin where .* the gap is 1.1e-06 m"),
        (changed(0, sweep=np.pi + 2e-6), "never turn to the right; 2 of 6 begins with 0.000115"),
        (changed(2, radius=-0.25), "above 0, counter-clockwise; 3 hasn't, of length -0.39"),
        (2 * CIRCLE, "they turn by 720 deg"),
    ],
)  # fmt: skip
def test_closed_profile_refuses_with_a_reason(pieces, message):
    with pytest.raises(ValueError, match=message):
        closed_profile(pieces)


def test_ray_needs_the_origin_inside():
    with pytest.raises(ValueError, match="must have the origin of its plane inside"):
        closed_profile([Arc(2.0, 0.0, 0.6, 0.0, 2 * np.pi)]).ray(0.0)


def test_requirements_of_a_section_with_a_corner_fail_at_its_bend():
    need = REFERENCE_MACHINE.requirements(closed_profile(SQUARE))[0]
    assert not need.met and need.right == 0


# ---- the egg ----------------------------------------------------------------------------------

SCALES = pytest.mark.parametrize("a", [1e-3, 0.5, 1e6])
OFFSETS = pytest.mark.parametrize("share", [-2, 0, 0.36, 0.4999, 0.5, 0.75, 0.999])


@SCALES
def test_point_at_the_blends_and_extremes(a):
    egg, sides = Egg(a), np.arctan2(3, 4)
    roof, wall = np.pi * a, 3 * a * sides
    invert = egg.perimeter - roof - 2 * wall
    np.testing.assert_allclose(np.diff(egg.blends), [roof, wall, invert, wall], rtol=1e-14)
    corners = [(1, 0), (-1, 0), (-0.4, -1.8), (0.4, -1.8), (1, 0)]
    np.testing.assert_allclose(egg.point(egg.blends), np.multiply(a, corners), atol=1e-15 * a)
    crown_and_invert = egg.point([roof / 2, roof / 2 + egg.perimeter / 2])
    np.testing.assert_allclose(crown_and_invert, [(0, a), (0, -2 * a)], atol=2e-15 * a)


@SCALES
@OFFSETS
def test_offset_is_at_its_distance_inside(a, share):
    egg = Egg(a)
    section = egg.offset(share * a)
    points = section.point(np.linspace(0, section.perimeter, many(100, 400)))
    np.testing.assert_allclose(egg.depth(*points.T), share * a, atol=1e-12 * a)


@pytest.mark.parametrize("share", [0.5, 0.6, 0.75, 0.99])
def test_offset_beyond_degeneration_has_its_corner(share):
    a, d = 0.7, 0.7 * share
    section = Egg(a).offset(d)
    assert len(section.arcs) == 3
    corner = (0, -np.sqrt((3 * a - d) ** 2 - 4 * a**2))
    np.testing.assert_allclose(section.point(section.blends[2]), corner, atol=1e-15)
