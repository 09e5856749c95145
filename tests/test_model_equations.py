"""The document's equations in the model's own frame, against series and known envelopes."""

import numpy as np
import pytest
from mpmath import mp

from exhibits import envelope_equations as eq
from tests.envelopes_zoo import GENERAL, GRID, MOTIONS
from tunneller_lib.envelopes.adapted import adapted_frames, model_jet
from tunneller_lib.envelopes.conics import top_circle
from tunneller_lib.envelopes.families import channel, cubic, moving_cone, ruled, saddle
from tunneller_lib.envelopes.isotropic import contact_point
from tunneller_lib.envelopes.jet import jet_variables

PLACES = [(0.3, -0.4, 0.7, 0.2), (-1.2, 0.5, -0.3, 2.0), (0.0, 0.0, 1e-3, -2e-3)]


def graph(x, y, m=np):
    return m.sin(2 * x) * m.cos(y) + 0.3 * x * y * y + m.exp(x - y)


@pytest.mark.parametrize(("x", "y", "u", "v"), PLACES)
def test_eq11_and_eq12_are_derivatives_along_the_circle(x, y, u, v):
    with mp.workdps(30):

        def along(t):
            rise = 1 - mp.cos(t)
            return graph(x + v * mp.sin(t) + u * rise, y - u * mp.sin(t) + v * rise, mp)

        c = mp.taylor(along, 0, 4)
        third, fourth = float(6 * c[3] + c[1]), float(24 * c[4] + 2 * c[2])
    f = graph(*jet_variables(x, y))
    assert eq.eq11(f, u, v) == pytest.approx(third, rel=1e-12)
    assert eq.eq12(f, u, v) == pytest.approx(fourth, rel=1e-12)


def test_eq04_as_mended_holds_on_a_graph_of_lines():
    x, y = jet_variables(0.4, 0.7)
    p = x + 0.5 * y
    f = (y - 0.3 * x) / (1 + p * p) + p**3  # straight where p is constant
    mended, printed = eq.eq04_terms(f), eq.eq04_terms(f, printed=True)
    assert abs(mended.sum()) < 1e-13 * np.abs(mended).max()
    assert abs(printed.sum()) > 1e-2 * np.abs(printed).max()


@pytest.mark.parametrize(("x", "y", "u", "v"), PLACES)
def test_eq14_is_a_sixth_of_the_jacobian(x, y, u, v):
    f, angle = graph(*jet_variables(x, y)), 0.4
    with mp.workdps(30):
        parts = [[mp.diff(g, (u, v), order) for order in ((1, 0), (0, 1))] for g in (
            lambda u, v: eq.eq09(x, y, u, v, angle),
            lambda u, v: eq.eq11(f, u, v))]  # fmt: skip
        jacobian = float(parts[0][0] * parts[1][1] - parts[0][1] * parts[1][0])
    assert eq.eq14(f, x, y, u, v, angle) == pytest.approx(jacobian / 6, rel=1e-11)


@pytest.mark.parametrize("name", GENERAL)
def test_model_jet_is_the_surface(name):
    x, y, f = model_jet(GENERAL[name], *GRID)
    point = contact_point(x, y, f.value, f.derivative(1, 0), f.derivative(0, 1))
    expected = np.broadcast_arrays(*GENERAL[name](*GRID))
    for got, c in zip(point, expected, strict=True):
        np.testing.assert_allclose(got, c, atol=1e-12)
    # Its Taylor polynomial leads to the neighbours.
    s, t = GRID[0] + 1e-3, GRID[1] - 2e-3
    x1, y1, f1 = model_jet(GENERAL[name], s, t)
    h, k = x1 - x, y1 - y
    near = sum(f.derivative(i, j) * h**i * k**j / mp.factorial(i) / mp.factorial(j)
               for i in range(5) for j in range(5 - i))  # fmt: skip
    np.testing.assert_allclose(near.astype(float), f1.value, rtol=1e-8)


@pytest.mark.parametrize("name", MOTIONS)
def test_cones_of_an_envelope_solve_eq09_eq11_and_eq12(name):
    surface = moving_cone(MOTIONS[name], 0.35)
    x, y, f = model_jet(surface, *GRID)
    n = adapted_frames(surface, *GRID, "space").axes[:, 2]
    axis = np.stack([c + 0 * x for c in MOTIONS[name](GRID[1])[2][0]], axis=-1)
    side = np.sign((n * axis).sum(axis=-1))
    u, v = (top_circle(side[:, None] * axis, 0.35)[0] - np.stack([x, y], -1)).T
    jet = max(np.abs(f.derivative(i, j)).max() for i in range(5) for j in range(5 - i))
    scale = jet * (1 + np.hypot(u, v)) ** 4
    assert np.all(np.abs(eq.eq09(x, y, u, v, 0.35)) < 1e-9 * scale)
    assert np.all(np.abs(eq.eq11(f, u, v)) < 1e-9 * scale)
    assert np.all(np.abs(eq.eq12(f, u, v)) < 1e-9 * scale)


def test_eq23_holds_for_cylinders():
    surface = ruled(saddle, offset=0.1)
    x, y, _ = model_jet(surface, *GRID)
    ruling = np.stack([c + 0 * x for c in saddle(GRID[0])[2]], axis=-1)
    u, v = (top_circle(ruling, 0.0)[0] - np.stack([x, y], -1)).T
    np.testing.assert_allclose(eq.eq23(x, y, u, v), 0, atol=1e-11)


def test_eq25_and_eq26_hold_for_channels():
    x, y, f = model_jet(channel(cubic, 0.3, growth=0.1), *GRID)
    tangent = np.stack([c + 0 * x for c in cubic(GRID[0])[1]], axis=-1)
    speed = np.linalg.norm(tangent, axis=-1)
    normal = adapted_frames(channel(cubic, 0.3, growth=0.1), *GRID, "space").axes[:, 2]
    # The characteristic's normals make a constant angle with the curve: a cone's planes.
    lean = np.arcsin((normal * tangent).sum(axis=-1) / speed)
    u, v = (top_circle(tangent, lean)[0] - np.stack([x, y], -1)).T
    np.testing.assert_allclose(eq.eq25(f, u, v), 0, atol=1e-9)
    np.testing.assert_allclose(eq.eq26(f, u, v), 0, atol=1e-8)


def test_terms_of_eq04_cancel_on_lines_where_they_are_mended():
    x, y = np.meshgrid(np.linspace(0.1, 0.8, 4), np.linspace(0.2, 0.9, 3))
    f = (lambda a, b: (a + 2 * b) * (b - a) / (1 + a + 2 * b))(*jet_variables(x, y))
    mended, printed = (eq.eq04_terms(f, printed=flag) for flag in (False, True))
    assert mended.shape == printed.shape == (13, *x.shape)
    assert np.abs(mended.sum(axis=0)).max() < 1e-12 < 1e-3 < np.abs(printed.sum(axis=0)).min()
    differ = np.abs(mended - printed).max(axis=(1, 2)) > 1e-6
    assert differ.sum() == 9
    other = np.sin(jet_variables(x, y)[0]) * np.exp(jet_variables(x, y)[1])
    assert np.abs(eq.eq04_terms(other).sum(axis=0)).min() > 1e-6
