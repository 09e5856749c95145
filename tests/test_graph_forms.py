"""Forms of a surface as a graph: what rounding leaves of second derivatives is none."""

import pytest

from tunneller_lib.envelopes.graph_forms import space_forms


@pytest.mark.parametrize(("size", "curvature"), [(1e-13, 0.0), (1e-11, 0.5), (1.0, 0.5)])
def test_second_derivatives_of_rounding_size_have_no_curvature(size, curvature):
    rest = [0.0] * 9
    x = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, *rest]  # s + s^2, t + t^2: of the order of 1
    y = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, *rest]
    z = [0.0, 0.0, 0.0, size, 0.0, size, *rest]
    assert space_forms(x, y, z)[2] == pytest.approx(curvature, rel=1e-9)
