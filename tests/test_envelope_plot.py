"""Drawings of envelopes in the plane: what they refuse."""

import numpy as np
import pytest

from exhibits.envelope_plot import draw_cone_and_conic, draw_cone_counts
from kit import figure
from tunneller_lib.envelopes import ConePose


@pytest.fixture
def ax():
    return figure(height=5)[1]


@pytest.mark.parametrize(("vertex", "axis"), [
    ((0, 0.1, 1), (0.2, 0, 1)), ((0, 0, 1), (0.2, 0.1, 1)), ((0, 0.1, 1), (0.2, 0.1, 1)),
])  # fmt: skip
def test_cone_that_leans_out_of_the_drawing_is_refused(ax, vertex, axis):
    with pytest.raises(ValueError, match=r"^cone: must have vertex and axis in the x-z plane; got"):
        draw_cone_and_conic(ax, ax, ax, ConePose(vertex, axis, 0.3, 0.0, 1.0))


def test_counts_and_places_of_two_shapes_are_refused(ax):
    x, y = np.meshgrid(np.arange(4.0), np.arange(3.0))
    with pytest.raises(ValueError, match=r"^x, y, count: must "):
        draw_cone_counts(ax, x, y, np.full((4, 3), 2.0))
