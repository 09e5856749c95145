"""Plane drawings: what is drawn lies where the shapes, paths and tasks have it."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from exhibits import groove_plot, machine_plot, motion_plot, response_plot
from exhibits.shaded import draw_shaded, on_paper
from kit import COLOURS, figure
from tunneller_lib.motion import Integrator, Loop, Resonance, follow
from tunneller_lib.motion.tasks import HandOver, Task
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

SQUARE = np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [0.0], indexing="ij"), axis=-1)[:, :, 0]


@pytest.fixture
def ax():
    drawing, ax = figure(height=4)
    yield ax
    plt.close(drawing)


# ---- the machine, rods and balls ------------------------------------------------------------


def test_side_view_has_the_tunnels_levels_thin_where_no_wall_is(ax):
    egg = Egg(0.5)
    machine_plot.draw_side_view(ax, REFERENCE_MACHINE, egg, -0.4)
    levels = {line.get_ydata()[0]: line for line in ax.lines if line.get_zorder() == 0}
    assert set(levels) == {egg.a, 0.0, -2 * egg.a}
    assert levels[0.0].get_linestyle() == "--"
    assert levels[0.0].get_linewidth() < levels[egg.a].get_linewidth()


def test_bowl_lies_beyond_the_middle_of_two_balls_and_the_ring_between_them(ax):
    groove_plot.draw_two_balls(ax, 0.5, 0.2)
    for collection, ends in zip(ax.collections, ((0.1, 0.7), (0.0, 0.2)), strict=False):
        across = collection.get_paths()[0].vertices[:, 0]
        assert (across.min(), across.max()) == pytest.approx(ends, abs=5e-3)


# ---- set-values and tasks -------------------------------------------------------------------


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


# ---- shaded sheets --------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [(1, 0, 0), (0.3, -2, 5), (-1, 1, -0.1)])
def test_paper_is_seen_from_the_eye_and_up_is_up(direction):
    axes = on_paper(direction)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) > 0 and axes[1, 2] > 0
    np.testing.assert_allclose(axes[2] * np.linalg.norm(direction), direction, rtol=1e-15)


@pytest.mark.parametrize("names", [["cone", "tunnel"], ["tunnel", "cone"]])
def test_near_sheets_are_drawn_over_far_ones(names):
    _, ax = figure(height=5)
    near, far = (SQUARE + np.array([0, 0, height]) for height in (0.5, -0.5))
    draw_shaded(ax, (0, 0.1, 1), dict(zip(names, (near, far), strict=True)))
    [faces] = ax.collections
    under, over = faces.get_facecolors()[:, :3]
    for colour, name in ((over, names[0]), (under, names[1])):
        share = colour / to_rgb(COLOURS[name])
        assert np.ptp(share) < 1e-6 and 0.55 <= share[0] <= 1
