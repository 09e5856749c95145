"""Lines one after the other: each has its own point and direction, and numbers may be none."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tunneller_lib.kernels import compiled, elementwise
from tunneller_lib.kernels.line_loops import FOR_LINES, meet_lines

NUMBERS = [0.0, 1.5, -2.0, math.inf, -math.inf, math.nan]


@pytest.mark.parametrize("name", ["smaller", "larger", "ratio"])
def test_two_numbers_are_as_one_of_an_array(name):
    for a in NUMBERS:
        for b in NUMBERS:
            if name == "ratio" and a == b == 0:
                continue  # either way no number, but for a warning
            with np.errstate(all="ignore"):
                known = getattr(elementwise, name)(np.array([a]), np.array([b]))[0]
            np.testing.assert_equal(FOR_LINES[name](a, b), known)


def test_one_number_is_as_one_of_an_array():
    for x in NUMBERS:
        with np.errstate(all="ignore"):
            known = elementwise.square_root(np.array([x]))[0]
        np.testing.assert_equal(FOR_LINES["square_root"](x), known)
    for x in (5e-324, 0.3, 1.0, 1e300):
        assert FOR_LINES["power_above"](x) == elementwise.power_above(x)
        assert FOR_LINES["scaled"](x, -3) == elementwise.scaled(x, -3)
    assert FOR_LINES["some"](True) and not FOR_LINES["some"](False)
    assert [FOR_LINES["where"](condition, 1, 2) for condition in (True, False)] == [1, 2]


def of_a_line(_, q, u):
    """Stand in for both ways: tell point and direction, sure where the point's x is above 1."""
    return q[0] + 10 * q[1] + 100 * q[2], u[0] + 10 * u[1] + 100 * u[2]


def quickly(shape, q, u):
    return (*of_a_line(shape, q, u), q[0] > 1)


def carefully(shape, p, u):
    first, last = of_a_line(shape, p, u)
    return -first, -last


@pytest.mark.parametrize("points, directions", [(4, 4), (1, 4), (4, 1)])
@pytest.mark.parametrize("plain", [True, False])
def test_each_line_has_its_point_and_direction_and_the_way_that_is_sure(points, directions, plain):
    start = (1.0, 2.0, 3.0)
    p = np.arange(12.0).reshape(4, 3)[-points:]
    u = np.arange(20.0, 32.0).reshape(4, 3)[-directions:]
    enter, leave = np.zeros((2, 4))
    shape = SimpleNamespace(start=start)
    ways = dict(quick=quickly, careful=carefully)
    compiled.call_plain(meet_lines, shape, plain, p, u, enter, leave, **ways)
    places = [1, 10, 100]
    for i in range(4):
        point, direction = p[i % points], u[i % directions]
        sure = plain and point[0] - start[0] > 1
        known = (point - start) @ places if sure else -(point @ places)
        assert enter[i] == known
        assert leave[i] == (direction @ places if sure else -(direction @ places))
