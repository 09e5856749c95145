"""Plane drawings: what is drawn lies where the shapes, paths and tasks have it."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba

from exhibits import (
    cone_plot,
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
from tunneller_lib.paths import ConeChord
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Torus

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


def area(corners):
    """Return the area inside a polygon, by the shoelace formula."""
    x, y = np.transpose(corners)
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def area_of(collection):
    """Return the area of all polygons of a collection."""
    return sum(area(path.vertices) for path in collection.get_paths())


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
    assert area_of(bowls) == pytest.approx(bowl, rel=1e-3)
    assert bowls.get_paths()[0].vertices[:, 0].min() == pytest.approx(half, abs=2e-3)
    under = half * np.sqrt(radius**2 - half**2) + radius**2 * np.arcsin(half / radius)
    ring = advance * radius - under
    assert area_of(rings) == pytest.approx(ring, rel=1e-2)


@pytest.mark.parametrize("depth", [0.05, 0.5, 0.9])
def test_sector_and_segment_of_a_groove_differ_by_a_triangle(ax, depth):
    radius = 0.5
    groove_plot.draw_sector_and_segment(ax, radius, depth)
    sector, segment = (area(patch.get_xy()) for patch in ax.patches)
    beta = np.arccos((radius - depth) / radius)
    assert sector == pytest.approx(radius**2 * beta, rel=1e-3)
    triangle = (radius - depth) * radius * np.sin(beta)
    assert sector - segment == pytest.approx(triangle, rel=1e-6, abs=1e-12)


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
    assert area_of(taken) == pytest.approx(expected, rel=1e-2)
    half = np.degrees(np.arccos(to_chord / radius))
    assert sector.theta2 - sector.theta1 == pytest.approx(2 * half)
    groove_plot.draw_passes(ax, radius, 2 * radius, pitch)


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


# ---- lines and rods --------------------------------------------------------------------------


def test_crossings_lie_on_the_ellipses(ax):
    rod_plot.draw_crossings(ax, 25.0, 90.0, 0.8, 15.0)
    _axis, *pieces, dots = ax.lines
    np.testing.assert_allclose(dots.get_xdata(), [-16, 16, 74, 106], rtol=1e-12)
    ends = np.array([piece.get_xdata() for piece in pieces])
    np.testing.assert_allclose(ends, [[-16, 16], [16, 74], [74, 106]], rtol=1e-12)
