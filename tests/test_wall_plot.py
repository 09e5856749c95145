"""The unrolled wall: each ray where the section's points have it, each colour its overbreak."""

import numpy as np
import pytest

from kit import figure
from tests.examples.ream import CUT
from tunneller_lib.job import wall_plot
from tunneller_lib.ream import carve

LIMIT = 2e-3


@pytest.fixture(scope="module")
def cut():
    return carve(CUT.plan, CUT.plan.setvalues, shape=(40, 92))


@pytest.fixture(scope="module")
def drawn(cut):
    _, ax = figure(height=8)
    return wall_plot.draw_unrolled(ax, cut, limit=LIMIT)


@pytest.fixture(scope="module")
def rightwards(cut):
    """Return the order of rays from the invert over left springing, roof and right springing."""
    lines = cut.wall.lines
    return np.lexsort([np.where(lines.cos > 0, lines.sin, -lines.sin), lines.cos < 0])


def test_columns_of_the_wall_meet_between_their_rays(cut, drawn, rightwards):
    section, lines = cut.plan.circuit.section, cut.wall.lines
    edges = np.asarray(drawn.get_coordinates()[0, :, 0])
    roof = section.a * np.pi / 2  # of the arc that begins at the left springing
    point = section.point(roof + edges)
    np.testing.assert_allclose(section.point(roof), [0, section.a], atol=1e-15)
    across = np.transpose([-lines.sin, lines.cos])[rightwards]
    passed = np.einsum("ij,ij->i", point[1:-1], across[:-1])
    ahead = -np.einsum("ij,ij->i", point[1:-1], across[1:])
    assert np.all(passed > 0) and np.all(ahead > 0)
    np.testing.assert_allclose(passed, ahead, rtol=0.15)
    half = section.perimeter / 2
    np.testing.assert_allclose(edges[[0, -1]], [-half, half], rtol=1e-3)
    rows = drawn.get_coordinates()[:, 0, 1]
    np.testing.assert_allclose((rows[1:] + rows[:-1]) / 2, lines.x, rtol=1e-12)


def test_colours_of_the_wall_are_its_over_break_where_it_is_touched(cut, drawn, rightwards):
    lines = cut.wall.lines
    was = cut.plan.circuit.section.ray(np.arctan2(lines.sin, lines.cos))
    cut_away = (cut.wall.low[0] - was)[:, rightwards]
    shown = drawn.get_array()
    assert np.all(shown.mask[cut_away < 1e-12]) and not np.any(shown.mask[cut_away > 1e-4])
    assert 0.1 < shown.mask.mean() < 0.9
    over = 1e3 * cut.overbreak[:, rightwards]
    np.testing.assert_array_equal(shown.filled(0), np.where(shown.mask, 0, over))
    assert drawn.get_clim() == (-1e3 * LIMIT, 1e3 * LIMIT)
    assert drawn.colorbar.ax.get_ylabel() == "overbreak / mm"
