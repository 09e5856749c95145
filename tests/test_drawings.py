"""Plane drawings: what is drawn lies where the shapes, paths and tasks have it."""

from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba

from exhibits import (
    cone_plot,
    geodesic_plot,
    groove_plot,
    machine_plot,
    motion_plot,
    path_plot,
    plot,
    response_plot,
    rod_plot,
)
from kit import COLOURS, figure
from tunneller_lib.motion import Integrator, Loop, Resonance, follow
from tunneller_lib.motion.tasks import HandOver, Task
from tunneller_lib.paths import ConeChord, competing_geodesics
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Rod, Torus

EGG = Egg(0.5)
TORUS = REFERENCE_MACHINE.torus
RING = Torus(3.0, 1.0)


@pytest.fixture
def ax():
    drawing, ax = figure(height=4)
    yield ax
    plt.close(drawing)


def length(line):
    return np.hypot(*np.diff(line.get_xydata(), axis=0).T).sum()


def area(patches):
    """Return the area of all polygons of a collection, by the shoelace formula."""
    x_and_y = [path.vertices.T for path in patches.get_paths()]
    return sum(abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2 for x, y in x_and_y)


# ---- the machine and the section ------------------------------------------------------------


def test_side_view_has_both_limbs_and_the_tunnel_levels(ax):
    theta = -0.4
    machine_plot.draw_side_view(ax, REFERENCE_MACHINE, EGG, theta)
    limbs = ax.lines[3:5]
    assert [length(limb) for limb in limbs] == pytest.approx(
        [REFERENCE_MACHINE.r, REFERENCE_MACHINE.R]
    )
    tip = TORUS.point(theta, 0.0)[[0, 2]] + [0, REFERENCE_MACHINE.height]
    np.testing.assert_allclose(limbs[1].get_xydata()[-1], tip, atol=1e-12)
    levels = {line.get_ydata()[0]: line for line in ax.lines if line.get_zorder() == 0}
    assert set(levels) == {EGG.a, 0.0, -2 * EGG.a}
    assert levels[0.0].get_linestyle() == "--"  # no wall is there, so it is drawn thin
    assert levels[0.0].get_linewidth() < levels[EGG.a].get_linewidth()


def test_plan_view_turns_the_arm_by_phi(ax):
    machine_plot.draw_plan_view(ax, REFERENCE_MACHINE, 0.3)
    leg, arm = ax.lines[1:3]
    assert length(leg) == pytest.approx(REFERENCE_MACHINE.r)
    x, y = np.diff(arm.get_xydata(), axis=0)[0]
    assert np.arctan2(y, x) == pytest.approx(0.3)
    assert np.hypot(x, y) == pytest.approx(REFERENCE_MACHINE.R)


def test_limits_are_the_machine_s(ax):
    [line] = machine_plot.draw_limits(ax, REFERENCE_MACHINE)
    low, high = np.radians([line.get_xydata().min(axis=0), line.get_xydata().max(axis=0)])
    assert low == pytest.approx([REFERENCE_MACHINE.theta_min, REFERENCE_MACHINE.phi_min])
    assert high == pytest.approx([REFERENCE_MACHINE.theta_max, REFERENCE_MACHINE.phi_max])


def test_section_and_its_construction_lie_on_the_curve(ax):
    plot.draw_section(ax, EGG)
    [line] = ax.lines
    np.testing.assert_allclose(EGG.depth(*line.get_data()), 0, atol=1e-12)
    assert length(line) == pytest.approx(EGG.perimeter, rel=1e-4) and ax.xaxis_inverted()
    plot.draw_construction(ax, EGG)
    rays = [line for line in ax.lines if len(line.get_xdata()) == 3]
    assert len(rays) == len(EGG.arcs)
    for ray, arc in zip(rays, EGG.arcs, strict=True):
        start, centre, stop = ray.get_xydata()
        ends = np.hypot(*(start - centre)), np.hypot(*(stop - centre))
        assert ends == pytest.approx([arc.radius] * 2)


def test_radii_stand_beside_their_rays_in_a_box_that_touches_the_section(ax):
    plot.draw_construction(ax, EGG)
    rays = [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 3]
    names = {"$a$": EGG.a, "$3a$": 3 * EGG.a, "$a/2$": EGG.a / 2}
    letters = [text for text in ax.texts if text.get_text() in names][:3]
    assert {text.get_text() for text in letters} == set(names)
    for text in letters:
        apart = [
            min(distance_from_segment(text.get_position(), one, ray[1]) for one in ray[::2])
            for ray in rays
        ]
        nearest = min(apart)
        assert 0.15 * EGG.a < nearest < 0.25 * EGG.a
        radii = [
            arc.radius for arc, off in zip(EGG.arcs, apart, strict=True) if off < 1.01 * nearest
        ]
        assert any(radius == pytest.approx(names[text.get_text()]) for radius in radii)
    [box] = ax.patches
    outline = EGG.point(np.linspace(0, EGG.perimeter, 20_001))
    np.testing.assert_allclose(box.get_xy(), outline.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(
        (box.get_width(), box.get_height()), np.ptp(outline, axis=0), atol=1e-6
    )


def distance_from_segment(place, start, stop):
    """Return how far a place (2,) is from the segment between two points (2,)."""
    along = np.subtract(stop, start)
    share = np.clip(np.subtract(place, start) @ along / (along @ along), 0, 1)
    return np.hypot(*(place - start - share * along))


def test_pictures_have_their_titles():
    drawing, axes = figure(1, 2, height=2)
    picture = np.zeros((4, 6, 3), dtype=np.uint8)
    plot.draw_pictures(axes, [picture] * 2, ["left", "right"])
    assert [ax.get_title() for ax in axes] == ["left", "right"]
    plt.close(drawing)


# ---- the torus and its paths ----------------------------------------------------------------


def test_tangent_spheres_touch_the_meridian_and_the_working_one_stands_out(ax):
    m = np.array([1.2, 0.3, 0.0])
    plot.draw_tangent_spheres(ax, TORUS, m)
    circles = ax.patches
    feet = TORUS.feet(m)
    for circle, foot in zip(circles, feet, strict=True):
        assert circle.radius == pytest.approx(np.linalg.norm(foot - m))
    for text in ax.texts[:4]:  # at one distance from each foot
        assert np.hypot(*text.xyann) == pytest.approx(14)
    working, *others = circles
    assert all(working.get_linewidth() > other.get_linewidth() for other in others)
    assert working.get_edgecolor() == to_rgba(COLOURS["tangent sphere"])
    assert all(working.get_edgecolor() != other.get_edgecolor() for other in others)


def test_ways_begin_and_end_together_and_the_legend_has_their_excess(ax):
    p, q = (0.0, 0.1), (0.4, -0.3)
    path_plot.draw_ways(ax, TORUS, p, q)
    for way in ax.lines:
        ends = np.radians(way.get_xydata()[[0, -1]])
        np.testing.assert_allclose(ends, [p, q], atol=1e-9)
    geodesic, spheres, joints = (way.get_label() for way in ax.lines)
    assert geodesic.startswith("geodesic, ") and "longer by" in spheres and "longer by" in joints
    assert float(spheres.split()[-2]) > 0 and float(joints.split()[-2]) > 0


def test_competing_geodesics_are_told_apart_from_the_shortest(ax):
    p, q = (0.0, 0.8), (3.1, -0.3)
    path_plot.draw_competing(ax, RING, p, q)
    shortest, *longer = [line for line in ax.lines if line.get_linestyle() == "-"]
    assert longer and all(line.get_linewidth() < shortest.get_linewidth() for line in longer)
    assert all(line.get_color() != shortest.get_color() for line in longer)
    for line in (shortest, *longer):
        ends = np.radians(line.get_xydata()[[0, -1]]) - [p, q]
        np.testing.assert_allclose(np.exp(1j * ends), 1, atol=1e-9)
    # Ways over the inner equator have their lengths farther on, clear of the others'.
    kinds = competing_geodesics(RING, p, q).kind
    assert set(kinds) == {"inner", "outer"}
    for text, line, kind in zip(ax.texts, (shortest, *longer), kinds, strict=False):
        at = np.argmin(np.hypot(*(line.get_xydata() - text.xy).T))
        assert at == (155 if kind == "inner" else 100)


def test_deviations_vanish_at_both_ends(ax):
    p, q = (0.0, 0.1), (0.4, -0.3)
    rules = ["projected chord", "joint space"]
    path_plot.draw_deviations(ax, TORUS, p, q, rules=rules)
    *lines, _level = ax.lines
    chord = np.linalg.norm(TORUS.point(*p) - TORUS.point(*q))
    for line in lines:
        x, y = line.get_data()
        np.testing.assert_allclose([x[0], x[-1]], [-chord / 2, chord / 2], rtol=1e-12)
        np.testing.assert_allclose(y[[0, -1]], 0, atol=1e-6)
        assert np.abs(y).max() > 1e-3
    assert [line.get_label() for line in lines] == rules


def test_gap_of_rounder_tori_is_nearer_to_the_law(ax):
    tori = [Torus(1 / ratio, 1.0) for ratio in (4, 10, 100)]
    path_plot.draw_gap(ax, tori, (0.0, 0.6), (1.5, -0.6))
    law, *dots = ax.lines
    angle, gap = law.get_data()
    gap = np.interp(dots[0].get_xdata(), angle, gap)
    off = [np.abs(one.get_ydata() - gap).max() for one in dots]
    assert off[0] > off[1] > off[2] and off[2] < 0.02 * np.abs(gap).max()
    assert [one.get_label() for one in dots] == ["R/r = 4", "R/r = 10", "R/r = 100"]


def test_ruling_is_dotted_where_it_meets_the_torus(ax):
    y, z = 0.2, 0.3
    path_plot.draw_ruling(ax, TORUS, y, z)
    every, last = ax.lines[-2:]
    x = every.get_xdata()
    assert len(x) in (2, 4) and last.get_xdata() == x.max()
    size = (TORUS.r + TORUS.R) ** 4
    points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    assert np.all(np.abs(TORUS.implicit(points)) < 1e-12 * size)


def test_cone_unrolls_with_a_straight_geodesic(ax):
    chord = ConeChord(1.0, 1.0, 0.5, 0.25)
    share = np.array([0.0, 0.5, 1.0])
    cone_plot.draw_development(ax, chord, share)
    geodesic, path, points = ax.lines[-3:]
    assert length(geodesic) == pytest.approx(chord.geodesic_length, rel=1e-12)
    start, stop = geodesic.get_xydata()[[0, -1]]
    assert np.hypot(*(stop - start)) == pytest.approx(chord.geodesic_length, rel=1e-12)
    assert length(path) == pytest.approx(chord.path_length, rel=1e-4)
    np.testing.assert_allclose(points.get_xydata(), path.get_xydata()[[0, 100, 200]], atol=1e-12)


def test_cone_seen_from_afar_has_the_lengths_of_its_projection(ax):
    chord = ConeChord(1.0, 1.0, 0.5, 0.25)
    share = np.linspace(0, 1, 5)
    cone_plot.draw_cone(ax, chord, share)
    geodesic, path, points = ax.lines[-3:]
    for line in (geodesic, path, points):
        ends = line.get_xydata()[[0, -1]]
        # From midway between P and Q: across, half a turn's sine; upwards, less for the far ones.
        sine, cosine = np.sin(chord.turn / 2), np.cos(chord.turn / 2)
        radius = np.array([1.0, 0.5])
        height = -radius * np.cos(cone_plot.HEIGHT) - radius * cosine * np.sin(cone_plot.HEIGHT)
        expected = np.transpose([[-1.0, 0.5] * np.array(sine), height])
        np.testing.assert_allclose(ends, expected, atol=1e-12)
    assert [text.get_text() for text in ax.texts] == ["apex", "$P$", "$Q$"]
    outline = [line.get_xydata() for line in ax.lines[2:4]]
    rim = np.concatenate([line.get_xydata() for line in ax.lines[:2]])
    for ruling in outline:  # all of the rim lies on one side of it
        side = np.cross(np.append(ruling[1], 0), np.pad(rim, ((0, 0), (0, 1))))[:, 2]
        assert side.min() > -1e-9 or side.max() < 1e-9


# ---- rods and balls -------------------------------------------------------------------------


def test_shadow_is_a_rectangle_between_two_ellipses(ax):
    rod_plot.draw_shadow(ax, 0.5, 2.0, 0.3)
    rectangle, lower, upper = ax.patches
    assert (rectangle.get_width(), rectangle.get_height()) == (2.0, 1.0)
    assert (lower.center, upper.center) == ((0, 0), (2.0, 0))
    assert {lower.height, upper.height} == {1.0} and {lower.width, upper.width} == {0.3}


def test_two_balls_leave_a_bowl_and_a_ring(ax):
    radius, advance = 0.5, 0.2
    groove_plot.draw_two_balls(ax, radius, advance)
    bowls, rings = ax.collections[:2]
    # The upper half of either: the second ball less the lens, the strip less both balls.
    half = advance / 2
    lens = radius**2 * np.arccos(half / radius) - half * np.sqrt(radius**2 - half**2)
    bowl = np.pi * radius**2 / 2 - lens
    assert area(bowls) == pytest.approx(bowl, rel=1e-3)
    assert bowls.get_paths()[0].vertices[:, 0].min() == pytest.approx(half, abs=2e-3)
    under = half * np.sqrt(radius**2 - half**2) + radius**2 * np.arcsin(half / radius)
    ring = advance * radius - under
    assert area(rings) == pytest.approx(ring, rel=1e-2)


@pytest.mark.parametrize("depth", [0.05, 0.5, 0.9])
def test_sector_and_segment_of_a_groove_differ_by_a_triangle(ax, depth):
    radius = 0.5
    groove_plot.draw_sector_and_segment(ax, radius, depth)
    sector, segment = (shoelace(patch.get_xy()) for patch in ax.patches)
    beta = np.arccos((radius - depth) / radius)
    assert sector == pytest.approx(radius**2 * beta, rel=1e-3)
    triangle = (radius - depth) * radius * np.sin(beta)
    assert sector - segment == pytest.approx(triangle, rel=1e-6, abs=1e-12)


def shoelace(corners):
    """Return the area inside a polygon, counted backwards where it runs clockwise."""
    x, y = corners.T
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def test_half_lens_is_a_cap_of_the_ball_or_its_upper_half(ax):
    radius, advance = 0.5, 0.2
    groove_plot.draw_half_lens(ax, radius, advance)
    groove_plot.draw_half_lens(ax, radius, advance, strip=0.2)
    whole, upper, _strip = ax.collections
    cap = radius**2 * np.arccos(advance / 2 / radius) - advance / 2 * np.sqrt(0.24)
    assert area(whole) == pytest.approx(cap, rel=1e-2)
    assert area(upper) == pytest.approx(cap / 2, rel=1e-2)


@pytest.mark.parametrize("pitch", [0.1, 3.0])
def test_a_pass_takes_what_the_earlier_one_left(ax, pitch):
    radius, depth = 0.5, 0.05
    groove_plot.draw_passes(ax, radius, depth, pitch)
    _earlier, taken = ax.collections
    sector = ax.patches[-1]
    to_chord = radius - depth

    def segment(height):
        """Return the area of a circle's part beyond a chord at this height."""
        return radius**2 * np.arccos(height / radius) - height * np.sqrt(radius**2 - height**2)

    x = np.linspace(-radius, radius, 200_001)
    now, before = (np.sqrt(np.clip(radius**2 - (x - at) ** 2, 0, None)) for at in (0, -pitch))
    expected = np.trapezoid(np.maximum(now - np.maximum(before, to_chord), 0), x)
    if pitch > 2 * radius:
        assert expected == pytest.approx(segment(to_chord), rel=1e-6)
    assert area(taken) == pytest.approx(expected, rel=1e-2)
    half = np.degrees(np.arccos(to_chord / radius))
    assert sector.theta2 - sector.theta1 == pytest.approx(2 * half)
    groove_plot.draw_passes(ax, radius, 2 * radius, pitch)


def test_rod_and_box_are_drawn_where_they_touch(ax):
    rod = Rod((0, 0, 0), (0.9, 0, 1.2), 0.25)
    rod_plot.draw_rod_and_box(ax, rod, 0.1, 0.3, 0.2)
    lines = ax.lines
    x, top = lines[3].get_data()
    corners = [(x, 0.2 + 0 * x), (x + 0.15, 0.1 + 0 * x), (x - 0.15, 0 * x)]
    for line, over in ((1, (x, 0.1 + 0 * x)), *((3, corner) for corner in corners)):
        there = rod.meet_line(np.stack([*over, 0 * x], axis=-1), (0, 0, 1))[1]
        met = np.isfinite(there)
        found = lines[line].get_ydata()[met]
        assert np.all(found >= there[met] - 1e-12)
        if line == 1:
            assert np.allclose(found, there[met])
    assert np.nanmax(top) == pytest.approx(1.2 + 0.25 * 0.6)


def test_shares_are_squares_of_their_grade(ax):
    shares = np.array([[0, 0.5, 5], [20, 80, 0]])
    key = plot.draw_shares(ax, shares, ["a", "b", "c"], ["of", "7", "9"])
    middles = [patch.get_path().vertices[:4].mean(axis=0).tolist() for patch in ax.patches]
    assert middles == [[1, 0], [2, 0], [0, 1], [1, 1]]
    assert [p.get_facecolor() for p in ax.patches] == [p.get_facecolor() for p in key[1:]]
    assert [text.get_text() for text in ax.texts] == ["of", "7", "9"]


def test_cut_row_draws_what_is_left_of_the_nearest_row(ax):
    grid = DexelGrid.cartesian((-1, -1, -1), (1, 1, 1), (10, 10))
    capsule = Rod((-0.2, 0.1, -0.1), (0.3, 0.1, 0.2), 0.4, ends="round")
    grid.cut(capsule)
    rod_plot.draw_cut_row(ax, grid, capsule)
    [bars] = ax.collections
    low, high = np.array(bars.get_segments())[..., 1].T
    x = np.unique(np.array(bars.get_segments())[..., 0])
    assert x.tolist() == grid.lines.x.tolist()
    there = np.stack([x, 0 * x + 0.1, 0 * x], axis=-1)
    enter, leave = capsule.meet_line(there, (0, 0, 1))
    assert np.sum(high - low) == pytest.approx(20 - np.sum(np.clip(leave - enter, 0, None)))
    [outline] = ax.patches
    x, z = outline.get_xy().T
    y = np.full_like(x, grid.lines.aside[np.argmin(np.abs(grid.lines.aside - 0.1))])
    along = np.stack([x, y, z], axis=-1) - capsule.a
    axis = np.subtract(capsule.b, capsule.a)
    foot = np.clip(along @ axis / (axis @ axis), 0, 1)
    np.testing.assert_allclose(np.linalg.norm(along - foot[:, None] * axis, axis=-1), 0.4)


# ---- set-values and tasks -------------------------------------------------------------------


@pytest.mark.parametrize(("box", "count"), [(None, 0), (0.0, 0), (1.0, 3)])
def test_setvalues_have_a_box_each_where_it_has_a_height(ax, box, count):
    t, values, ideal = [0.0, 0.5, 1.0], [0.0, 1.0, 1.0], [0.0, 0.6, 1.2]
    motion_plot.draw_setvalues(ax, t, values, ideal, box=box)
    line, circles = ax.lines
    np.testing.assert_array_equal(line.get_data(), [t, ideal])
    np.testing.assert_array_equal(circles.get_data(), [t, values])
    assert len(ax.patches) == count
    for patch, x, y in zip(ax.patches, t, values, strict=False):
        assert patch.get_center().tolist() == [x, y]


def test_responses_say_which_models_are_unstable(ax):
    loop = Loop(30.0, 0.01)
    models = {"T0": Integrator(1.0), "T1": Resonance(1.0, 50.0, 0.05)}
    setvalues = np.linspace(0, 1, 20)
    response_plot.draw_responses(ax, models, loop, setvalues)
    tracks = {name: follow(model, loop, setvalues) for name, model in models.items()}
    assert tracks["T0"].stable == (True,) and tracks["T1"].stable == (False,)
    assert ax.get_title() == "unstable: T1"
    drawn = {line.get_label(): np.radians(line.get_ydata()) for line in ax.lines}
    for name, track in tracks.items():
        np.testing.assert_allclose(drawn[name], track.position.ravel(), rtol=1e-12)
    response_plot.draw_responses(ax, {"T0": models["T0"]}, loop, np.zeros(5))
    assert ax.get_title() == "all stable"


def test_hand_over_draws_each_segment_and_only_the_waits(ax):
    run = HandOver(ready=(3, 9), needed=(2, 12), started=(3, 12), starved=(1, 0))
    tasks = [Task("interpolation", 5, 1)]
    motion_plot.draw_hand_over(ax, tasks, run, [1, 2], unit=0.5)
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert names == ["interpolation", "preparation", "segment", "starved"]
    bars = [c for c in ax.collections if isinstance(c, PolyCollection)]
    spans = {
        name: [(v[:, 0].min(), v[:, 0].max()) for v in (p.vertices for p in bar.get_paths())]
        for name, bar in zip(names, bars, strict=True)
    }
    assert spans["segment"] == [(1.5, 4.0), (6.0, 11.0)]  # halves of 3 to 8 and of 12 to 22
    assert spans["starved"] == [(1.0, 1.5)]
    assert spans["preparation"] == [(0.0, 1.5), (1.5, 4.5)]


def test_scheme_has_each_word_in_a_block_of_its_own(ax):
    motion_plot.draw_scheme(ax)
    boxes = [block.get_bbox() for block in ax.patches]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    inside = [
        next(text.get_text() for text in ax.texts if box.contains(*text.xy) and text.get_text())
        for box in boxes
    ]
    words = ["circuit", "slow", "buffer", "fast"]
    words += ["loop", "valve", "cylinder", "encoder"] * 2
    assert len(inside) == len(words)
    assert all(word in text for word, text in zip(words, inside, strict=True))
    middles = [(box.x0 + box.x1) / 2 for box in boxes]
    assert middles[4:8] == sorted(middles[4:8]) == middles[8:]
    heads = [
        text.xy for text in ax.texts if text.arrow_patch and text.arrowprops["arrowstyle"] != "-"
    ]
    assert len(heads) == 3 + 2 * 5
    for x, y in heads:  # an arrow ends on a block's frame
        assert any(
            box.x0 - 1e-9 <= x <= box.x1 + 1e-9 and box.y0 - 1e-9 <= y <= box.y1 + 1e-9
            for box in boxes
        )


# ---- tangent spheres -------------------------------------------------------------------------


@pytest.mark.parametrize(("height", "words"), [(0.0, "both equators"), (0.35, "four feet")])
def test_feet_along_the_axis_lie_on_a_line_through_it(ax, height, words):
    m = np.array([0.5, height, 0.25])
    plot.draw_feet_along_axis(ax, Torus(0.3, 0.8), m)
    [dots] = [line for line in ax.lines if line.get_marker() == "o"]
    x, z = dots.get_data()
    np.testing.assert_allclose(x * m[2], z * m[0], atol=1e-12)
    assert len(x) == 4 and words in ax.get_title()


# ---- lines and rods --------------------------------------------------------------------------


def test_crossings_lie_on_the_ellipses(ax):
    rod_plot.draw_crossings(ax, 25.0, 90.0, 0.8, 15.0)
    _axis, *pieces, dots = ax.lines
    np.testing.assert_allclose(dots.get_xdata(), [-16, 16, 74, 106], rtol=1e-12)
    ends = np.array([piece.get_xdata() for piece in pieces])
    np.testing.assert_allclose(ends, [[-16, 16], [16, 74], [74, 106]], rtol=1e-12)


def test_an_axis_seen_from_the_other_end_runs_backwards(ax):
    rod_plot.draw_crossings(ax, 25.0, -90.0, 0.8, 15.0)
    np.testing.assert_allclose(np.sort(ax.lines[-1].get_xdata()), [-106, -74, -16, 16], rtol=1e-12)


# ---- why a geodesic is the shortest way ------------------------------------------------------


def test_half_swings_fall_to_that_of_the_outer_equator(ax):
    geodesic_plot.draw_half_swings(ax, [TORUS, RING])
    lines = ax.lines[::2]
    for line, torus in zip(lines, (TORUS, RING), strict=True):
        turned = line.get_ydata()
        assert np.all(np.diff(turned) < 0)
        assert turned[-1] == pytest.approx(180 / np.sqrt(1 + torus.r / torus.R), rel=1e-9)


def test_arrivals_grow_with_the_direction(ax):
    first, second = geodesic_plot.draw_arrivals(ax, RING, (0.0, 0.8), -0.3)
    assert np.all(np.diff(first.get_xdata()) < 0) and np.all(np.diff(first.get_ydata()) > 0)
    later = np.interp(second.get_xdata()[::-1], first.get_xdata()[::-1], first.get_ydata()[::-1])
    assert np.all(second.get_ydata()[::-1] > later)


def test_mirrored_way_has_a_corner_opposite_its_beginning(ax):
    begin, end = (0.0, 0.8), (2.6, -0.3)
    geodesic_plot.draw_mirrored(ax, RING, begin, end)
    way, image = ax.lines[:2]
    np.testing.assert_allclose(way.get_xydata()[0], np.degrees(begin), atol=1e-6)
    np.testing.assert_allclose(way.get_xydata()[-1], np.degrees(end) - [360, 0], atol=1e-6)
    np.testing.assert_allclose(image.get_xydata()[-1], np.degrees(end), atol=1e-6)
    theta = image.get_xdata()
    corner = np.argmax(theta)
    assert 170 < theta[corner] <= 180 and np.all(np.diff(theta[:corner]) > 0)
    assert np.all(np.diff(theta[corner + 1 :]) < 0)
