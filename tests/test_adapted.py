"""Adapted frames, and a surface's graph in them and in the model."""

import numpy as np
import pytest

from tests.envelopes_zoo import GENERAL, GRID
from tunneller_lib.envelopes.adapted import (
    adapted_frames,
    frames_along,
    isotropic_jet,
    model_jet,
    tangent_graph,
)
from tunneller_lib.envelopes.families import cyclide, ruled, saddle
from tunneller_lib.envelopes.isotropic import contact_point
from tunneller_lib.envelopes.jet import exponents, frobenius

SURFACES = {"space": GENERAL["quartic graph"], "isotropic": cyclide}
every_model = pytest.mark.parametrize("model", SURFACES)
every_surface = pytest.mark.parametrize("name", GENERAL)


@every_model
def test_axes_are_a_right_handed_frame_on_the_tangent_plane(model):
    frames = adapted_frames(SURFACES[model], *GRID, model)
    assert frames.smooth.all()
    right = frames.axes @ np.swapaxes(frames.axes, 1, 2)
    np.testing.assert_allclose(right, np.broadcast_to(np.eye(3), right.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(frames.axes), 1)
    np.testing.assert_allclose(frames.r[2].c[:3], 0, atol=1e-13)  # no height, no slope


@every_surface
def test_graph_in_the_frame_has_twice_the_principal_radii(name):
    """f's Hessian is twice the inverse of the curvatures' matrix, that of the tangent graph."""
    found = adapted_frames(GENERAL[name], *GRID, "space")
    f, g = isotropic_jet(found, slice(None)), tangent_graph(found, slice(None))
    hessian, bend = ([[j.derivative(2, 0), j.derivative(1, 1)],
                      [j.derivative(1, 1), j.derivative(0, 2)]] for j in (f, g))  # fmt: skip
    product = np.moveaxis(hessian, -1, 0) @ np.moveaxis(bend, -1, 0)
    np.testing.assert_allclose(product, np.broadcast_to(2 * np.eye(2), product.shape), atol=1e-10)
    assert np.abs(f.c[:3]).max() == 0 and np.abs(g.c[:3]).max() < 1e-14


@pytest.mark.parametrize("shift", [0.0, 10.0])
def test_both_models_give_one_jet_but_for_frame_and_side(shift):
    def f(x, y):
        return cyclide(x, y) + shift * x

    def space(x, y):
        square = (x * x + y * y) ** 2
        return contact_point(x, y, f(x, y), shift - 2 * x * y * y / square, 2 * x * x * y / square)

    one, two = adapted_frames(f, *GRID, "isotropic"), adapted_frames(space, *GRID, "space")
    np.testing.assert_allclose(one.contact, two.contact, atol=1e-12)
    # r_s x r_t may point the other way: f changes its sign then, and the frame is another, but not
    # the size of the forms of each degree.
    jets = [isotropic_jet(found, slice(None)) for found in (one, two)]
    for degree in (2, 3, 4):
        np.testing.assert_allclose(*(frobenius(jet, degree) for jet in jets), rtol=1e-11)


@pytest.mark.parametrize(("size", "curvature"), [(1e-13, 0.0), (1e-11, 0.5), (1.0, 0.5)])
def test_second_derivatives_of_rounding_size_have_no_curvature(size, curvature):
    def bowl(s, t):
        return s + s * s, t + t * t, size * (s * s + t * t)

    found = adapted_frames(bowl, 0.0, 0.0, "space").curvature.item()
    assert found == pytest.approx(curvature, rel=1e-9)


@every_surface
def test_model_jet_is_the_surface_and_leads_to_its_neighbours(name):
    x, y, f = model_jet(GENERAL[name], *GRID)
    points = contact_point(x, y, f.value, f.derivative(1, 0), f.derivative(0, 1))
    for got, c in zip(points, np.broadcast_arrays(*GENERAL[name](*GRID)), strict=True):
        np.testing.assert_allclose(got, c, atol=1e-12)
    there, beside, g = model_jet(GENERAL[name], GRID[0] + 1e-3, GRID[1] - 2e-3)
    powers = zip(f.c, exponents(4), strict=True)
    series = sum(c * (there - x) ** i * (beside - y) ** j for c, (i, j) in powers)
    np.testing.assert_allclose(series, g.value, rtol=1e-8)


def test_surfaces_without_a_graph_are_refused():
    def flat(s, t):
        return [s, t, s + 2 * t]

    def kinked(s, t):
        return [s, t, np.sqrt((s - 0.15) ** 2) + s * t]

    for surface in (flat, kinked):
        with pytest.raises(ValueError, match=r"^surface: must be smooth at every point, of a Gau"):
            model_jet(surface, *GRID)


def test_frames_along_a_line_have_it_for_their_first_axis():
    t = np.linspace(-0.5, 1.0, 5)
    found = frames_along(ruled(saddle), 0.7, t)
    np.testing.assert_allclose(found.contact, np.stack([0.7 + 0 * t, t, 0.7 * t], axis=-1))
    np.testing.assert_allclose(np.abs(found.axes[:, 0] @ [0, 1, 0.7]), np.hypot(1, 0.7))
