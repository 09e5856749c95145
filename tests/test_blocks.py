"""The quick way of lines through round solids: known ends, at a size far from 1 and near it."""

import numpy as np
import pytest

from tunneller_lib.surfaces import Frustum, Rod


@pytest.mark.parametrize("size", [1e-90, 1e-3, 1.0, 1e3, 1e90])
@pytest.mark.parametrize(
    "solid", [lambda a, b, r: Rod(a, b, r), lambda a, b, r: Frustum(a, b, r, r)]
)
def test_lines_across_a_wall_have_the_chord_that_is_known(solid, size):
    shape = solid((0, 0, 0), (0, 0, 4 * size), 0.5 * size)
    off = np.linspace(0, 0.4, 9)
    point = size * np.stack([-2 + 0 * off, off, 0 * off + 1.0], axis=-1)
    enter, leave = shape.meet_line(point, (3.0, 0.0, 0.0))  # three a unit of the parameter
    half = np.sqrt(0.25 - off**2)
    np.testing.assert_allclose(enter, size * (2 - half) / 3, rtol=1e-13)
    np.testing.assert_allclose(leave, size * (2 + half) / 3, rtol=1e-13)


@pytest.mark.parametrize(
    "solid", [lambda a, b, r: Rod(a, b, r), lambda a, b, r: Frustum(a, b, r, r)]
)
def test_lines_that_lean_leave_by_the_end_that_is_known(solid):
    shape = solid((0, 0, 0), (0, 0, 4), 0.5)
    off = np.linspace(0, 0.4, 9)
    point = np.stack([-2 + 0 * off, off, 0 * off + 1.0], axis=-1)
    half = np.sqrt(0.25 - off**2)
    enter, leave = shape.meet_line(point, np.tile([3.0, 0.0, 4.0], (9, 1)))
    np.testing.assert_allclose(enter, (2 - half) / 3, rtol=1e-13)
    np.testing.assert_allclose(leave, 0.75, rtol=1e-13)
    enter, leave = shape.meet_line(point, np.tile([3.0, 0.0, 2.0], (9, 1)))
    np.testing.assert_allclose(leave, (2 + half) / 3, rtol=1e-13)
