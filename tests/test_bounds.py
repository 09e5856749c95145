"""What may be asked of a path, to the last point and the last angle."""

import numpy as np
import pytest

from tunneller_lib.paths.bounds import check_on_sheet, check_points
from tunneller_lib.surfaces import Torus


def test_points_of_all_paths_together_have_a_bound():
    for n, shape in ((2, (2_500_000,)), (5, (1000, 1000)), (1_000_000, (5,)), (1_000_000, ())):
        check_points(n, shape)
    with pytest.raises(ValueError, match=r"^n: must ask for at most 5000000 .* 3 of each of 166"):
        check_points(3, (1_666_667,))  # one point too many


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_ends_of_paths_lie_on_the_working_sheet(size):
    edge = np.pi - np.arccos(0.5)  # where r + R cos(phi) is 0
    torus = Torus(size, 2 * size)
    inside = np.array([[0.3, edge - 1e-6], [-0.2, edge - 2e-6]])
    check_on_sheet(torus, inside, inside[0])
    outside = inside + np.array([0, 2e-6])
    for name, ends in (("p", (outside, inside)), ("q", (inside, outside))):
        with pytest.raises(ValueError, match=rf"^{name}: must lie on the working sheet, .* 2\.094"):
            check_on_sheet(torus, *ends)
