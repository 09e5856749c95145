"""Adapted frames: unit axes in the tangent plane, and a graph that lies flat in them."""

import numpy as np
import pytest

from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet, model_jet
from tunneller_lib.envelopes.jet import EXPONENTS

S, T = np.random.default_rng(3).uniform(0.2, 0.8, (2, 40))
SURFACES = {
    "space": lambda s, t: [(2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)],
    "isotropic": lambda x, y: y**2 / (x**2 + y**2) + x * y / 7,
}


@pytest.mark.parametrize("model", SURFACES)
def test_axes_are_a_right_handed_frame_on_the_tangent_plane(model):
    frames = adapted_frames(SURFACES[model], S, T, model)
    assert frames.smooth.all()
    for axes in frames.axes:
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(axes) == pytest.approx(1)
    # Along both parameters the surface leaves its point within the plane.
    height = frames.r[2].c[:3]
    np.testing.assert_allclose(height, 0, atol=1e-13)


@pytest.mark.parametrize("model", SURFACES)
def test_graph_in_its_own_frame_has_neither_height_nor_slope(model):
    frames = adapted_frames(SURFACES[model], S, T, model)
    f = isotropic_jet(frames, slice(None))
    np.testing.assert_array_equal(f.c[:3], 0)
    assert np.all(np.abs(f.c[3:6]).max(axis=0) > 1e-2)  # but it bends


def test_surfaces_without_a_graph_are_refused():
    def flat(s, t):
        return [s, t, s + 2 * t]

    def kinked(s, t):
        return [s, t, np.sqrt((s - 0.5) ** 2) + s * t]

    for surface, places in ((flat, S), (kinked, np.full(40, 0.5))):
        with pytest.raises(
            ValueError, match=r"^surface: must be smooth at every point, of a Gaussi"
        ):
            model_jet(surface, places, T)


def test_model_jet_is_the_series_of_the_tangent_planes():
    """At a point nearby the series has the height over the plane there, to its fifth order."""
    surface = SURFACES["space"]
    x, y, f = model_jet(surface, S, T)
    step = 1e-3
    there, beside, g = model_jet(surface, S + step, T - 2 * step)
    powers = zip(f.c, EXPONENTS, strict=True)
    series = sum(c * (there - x) ** i * (beside - y) ** j for c, (i, j) in powers)
    np.testing.assert_allclose(series, g.c[0], atol=1e-11)
    # The value is what Eq. 6 makes of the plane: its distance from the origin over n_3 + 1.
    n = np.stack([np.cos(T) * np.cos(S), np.cos(T) * np.sin(S), np.sin(T)], axis=-1)
    turned = np.sign(x * n[:, 0])  # the normals' side is the surface's own
    n = turned[:, None] * n
    point = np.stack(surface(S, T), axis=-1)
    np.testing.assert_allclose(f.c[0], -np.sum(point * n, axis=-1) / (n[:, 2] + 1), rtol=1e-13)
