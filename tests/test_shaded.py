"""Shaded sheets on a drawing: the near ones cover the far ones."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from exhibits.shaded import draw_shaded, on_paper
from kit import COLOURS, figure

SQUARE = np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [0.0], indexing="ij"), axis=-1)[:, :, 0]


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
