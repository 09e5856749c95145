"""What may be asked of a path, to the last point and the last angle."""

import pytest

from tunneller_lib.paths.bounds import check_points


def test_points_of_all_paths_together_have_a_bound():
    for n, shape in ((2, (2_500_000,)), (5, (1000, 1000)), (1_000_000, (5,)), (1_000_000, ())):
        check_points(n, shape)
    with pytest.raises(ValueError, match=r"^n: must ask for at most 5000000 .* 3 of each of 166"):
        check_points(3, (1_666_667,))  # one point too many
