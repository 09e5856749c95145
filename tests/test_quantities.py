"""The ranges of quantities that axes and their oil have."""

import pytest

from tunneller_lib.motion.quantities import Quantity, Quantity0, Size, Size0, Torque


@pytest.mark.parametrize(
    ("kind", "least", "most", "or_zero"),
    [
        (Quantity, 1e-9, 1e9, False),
        (Quantity0, 1e-9, 1e9, True),
        (Size, 1e-15, 1e15, False),
        (Size0, 1e-30, 1e15, True),
    ],
)
def test_sizes_are_taken_up_to_both_ends_of_their_range(kind, least, most, or_zero):
    [rule] = kind.__metadata__
    for size in (least, most):
        assert rule.check("it", size) == size
    for size in (0.99 * least, 1.01 * most, -least):
        with pytest.raises(ValueError, match=r"^it: must be"):
            rule.check("it", size)
    if or_zero:
        assert rule.check("it", 0.0) == 0
    else:
        with pytest.raises(ValueError, match=r"^it: must be"):
            rule.check("it", 0.0)


def test_torques_have_either_sign():
    [rule] = Torque.__metadata__
    assert rule.check("it", -3.0) == -3 and rule.check("it", 0.0) == 0
