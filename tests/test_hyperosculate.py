"""Hyperosculating cones: contact by an independent series, all of them found, nothing else."""

from functools import partial
from math import comb, factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from tests.envelopes_zoo import GRID, MOTIONS
from tunneller_lib.envelopes import ConePose, hyperosculating_cones
from tunneller_lib.envelopes.circle_roots import real_zeros
from tunneller_lib.envelopes.families import cyclide, moving_cone
from tunneller_lib.envelopes.isotropic import surface_points, top_circle
from tunneller_lib.envelopes.jet import jet_variables

ANGLE = np.radians(30)
GRAPHS = {
    "example 31": lambda x, y, m=np: y**2 / (x**2 + y**2),
    "waves": lambda x, y, m=np: m.sin(2 * x) * m.cos(y) + 0.3 * x * y,
    "quintic": lambda x, y, m=np: x**3 - 2 * x * y**2 + 0.2 * y**5 + x * y,
}
every_graph = pytest.mark.parametrize("name", GRAPHS)


def series(cones, k, f):
    """Return Taylor coefficients of height over f along the planes of cone k, from its contact.

    In 40 digits, from vertex and axis alone: the cone's tangent planes as points, by Eq. 6.
    """
    with mp.workdps(40):
        axis = [mp.mpf(float(a)) for a in cones.axis[k]]
        ruling = cones.contact[k] - cones.vertex[k]
        start = cones.side[k] * cones.normal[k]
        across = np.cross(ruling / np.linalg.norm(ruling), start)
        sine, cosine = mp.sin(cones.half_angle), mp.cos(cones.half_angle)
        # Normals n(t) = side (sin axis + cos (p cos t + q sin t)), with n(0) the contact's.
        p = [(mp.mpf(float(n)) - sine * a) / cosine for n, a in zip(start, axis, strict=True)]

        def gap(t):
            n = [
                cones.side[k] * (sine * a + cosine * (u * mp.cos(t) + mp.mpf(float(v)) * mp.sin(t)))
                for a, u, v in zip(axis, p, across, strict=True)
            ]
            h = -sum(a * mp.mpf(float(m)) for a, m in zip(n, cones.vertex[k], strict=True))
            return h / (n[2] + 1) - f(n[0] / (n[2] + 1), n[1] / (n[2] + 1))

        return np.array([float(c) for c in mp.taylor(gap, 0, 4)])


@every_graph
@pytest.mark.parametrize("angle", [0.1, ANGLE, 1.3])
def test_contact_is_of_third_order_by_an_independent_series(name, angle):
    cones = hyperosculating_cones(GRAPHS[name], [0.5, 0.9], [0.3, -0.4], half_angle=angle)
    assert len(cones.vertex) >= 4
    for k in np.flatnonzero(cones.multiplicity == 1):
        c = series(cones, k, partial(GRAPHS[name], m=mp))
        # The vertex is known to 1e-13 of its distance.
        assert np.abs(c[:4]).max() < 1e-10 * (1 + np.abs(cones.vertex[k]).max())
        if abs(cones.order4[k]) < 1e-9:
            assert abs(c[4]) < 1e-9
        else:
            assert np.sign(c[4]) == -np.sign(cones.order4[k])


@every_graph
def test_no_cone_is_missed(name):
    """Against sign changes of Eq. 11 along the circle of Eq. 9, in the frame of the model."""
    rng = np.random.default_rng(4)
    x, y = rng.uniform(0.2, 1.5, (2, 300))
    cones = hyperosculating_cones(GRAPHS[name], x, y, half_angle=ANGLE)
    f = GRAPHS[name](*jet_variables(x, y))
    b = np.linspace(0, 2 * np.pi, 10_001)[:-1, None]
    u, v = np.cos(b), np.sin(b)
    cubic = (f.derivative(3, 0) * v**3 - 3 * f.derivative(2, 1) * v**2 * u
             + 3 * f.derivative(1, 2) * v * u**2 - f.derivative(0, 3) * u**3)  # fmt: skip
    square = (f.derivative(2, 0) - f.derivative(0, 2)) * u * v + f.derivative(1, 1) * (v**2 - u**2)
    value = (1 + x**2 + y**2) * cubic + 6 * square * (np.tan(ANGLE) - x * u - y * v)
    changes = np.sum(np.sign(value) != np.sign(np.roll(value, 1, axis=0)), axis=0)
    assert np.mean(cones.count == changes) > 0.995  # closer pairs than the samples' step
    assert np.all(cones.count >= changes)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_cones_move_with_the_surface(scale):
    turn = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    plain = moving_cone(MOTIONS["screw"], 0.35)

    def moved(s, t):
        r = plain(s, t)
        return [scale * (sum(turn[i, k] * r[k] for k in range(3)) + i) for i in range(3)]

    a = hyperosculating_cones(plain, *GRID, half_angle=0.35, model="space")
    b = hyperosculating_cones(moved, *GRID, half_angle=0.35, model="space")
    np.testing.assert_array_equal(a.count, b.count)
    np.testing.assert_array_equal(a.gouges, b.gouges)
    expected = scale * (a.vertex @ turn.T + np.arange(3))
    np.testing.assert_allclose(b.vertex, expected, atol=1e-9 * scale * np.abs(a.vertex).max())
    np.testing.assert_allclose(b.axis, a.axis @ turn.T, atol=1e-9)


@pytest.mark.parametrize(("order", "C", "gouges"), [
    (5, 200, True), (5, -200, True), (6, -200, True), (6, 200, False),
])  # fmt: skip
def test_gouging_is_undecided_where_order_four_vanishes(order, C, gouges):
    """The same jet of order 4, and the same cone: higher orders make it gouge or not."""
    f, x0, y0 = cyclide, 0.5, 0.3
    plain = hyperosculating_cones(f, x0, y0, half_angle=ANGLE)
    [k, _] = np.flatnonzero(plain.undecided)
    centre, _ = top_circle(plain.side[k] * plain.axis[k], ANGLE)
    u, v = centre - (x0, y0)
    e = np.array([v, -u]) / np.hypot(u, v)  # along the cone's circle

    def bent(x, y):
        return f(x, y) + C * ((x - x0) * e[0] + (y - y0) * e[1]) ** order

    cones = hyperosculating_cones(bent, x0, y0, half_angle=ANGLE)
    for name in ("vertex", "axis", "order4", "gouges", "undecided"):
        np.testing.assert_array_equal(getattr(cones, name), getattr(plain, name))
    near = np.linspace(-0.03, 0.03, 161)
    r = surface_points(bent, *np.meshgrid(x0 + near, y0 + near))
    length = cones.distance[k]
    d = ConePose(cones.vertex[k], cones.axis[k], ANGLE, length / 2, 2 * length).clearance(r)
    assert d.min() < -1e-8 if gouges else d.min() > -1e-12


# ---- what is no generic point -----------------------------------------------------------------


@pytest.mark.parametrize(("surface", "state"), [
    (lambda s, t: [s, t, 0 * s], "flat"),
    (lambda s, t: [s + t**3, t, 2 * s + 2 * t**3 - t], "flat"),
    (lambda s, t: [np.cos(s), np.sin(s), t], "flat"),
    (lambda s, t: [(1 + t) * np.cos(s), (1 + t) * np.sin(s), t], "flat"),
    (lambda s, t: [np.cos(s) * np.cos(t), np.sin(s) * np.cos(t), np.sin(t)], "spherical"),
    (lambda s, t: [s, t, np.sqrt(0.01 - s * s - t * t)], "outside"),
    (lambda s, t: [s * s, s * t + t * t, s + t - s], "regular"),
    (lambda s, t: [s + t, s + t, (s + t) ** 2], "outside"),
])  # fmt: skip
def test_state_of_points_in_space(surface, state):
    cones = hyperosculating_cones(surface, [0.3, 0.4], [0.5, 0.2], half_angle=0.4, model="space")
    assert set(cones.state) == {state}
    assert (len(cones.vertex) > 0) == (state == "regular")


@pytest.mark.parametrize(("surface", "x", "state"), [
    (lambda x, y: y**2 / (x**2 + y**2), 0.0, "outside"),
    (lambda x, y: 3.0, 0.2, "spherical"),
    (lambda x, y: 1 + x * x + y * y - 2 * x, 0.2, "spherical"),
    (lambda x, y: x + 2 * y, 0.2, "singular"),  # the planes through one point
    (lambda x, y: 1 - x * x - y * y, 0.2, "singular"),
    (lambda x, y: np.log(x - 1), 0.2, "outside"),
])  # fmt: skip
def test_state_of_points_in_the_model(surface, x, state):
    cones = hyperosculating_cones(surface, x, 0.0, half_angle=0.4)
    assert cones.state == state and cones.count == 0 and len(cones.vertex) == 0


@pytest.mark.parametrize(("d", "error"), [(1e-2, 1e-10), (1e-4, 1e-6), (1e-7, None)])
def test_digits_are_lost_towards_curvature_zero_and_refused_there(d, error):
    def sheet(s, t):
        height = s * s / 2 * (1 + s) - d * t * t / 2 + 0.3 * s**2 * t + 0.1 * s * t**2 + 0.2 * t**3
        return [s, t, height + 0.05 * s**4]

    plain, turned = (
        hyperosculating_cones(surface, 0.0, 0.0, half_angle=0.3, model="space")
        for surface in (sheet, lambda s, t: sheet(0.6 * s + 0.8 * t, -0.8 * s + 0.6 * t))
    )
    if error is None:
        assert plain.state == turned.state == "flat" and plain.count == 0
    else:
        gap = np.linalg.norm(plain.vertex[:, None] - turned.vertex, axis=-1).min(axis=1)
        assert plain.count == turned.count and np.all(gap < error * plain.distance)


def test_umbilics_have_the_cones_of_their_cubic_form():
    """At an umbilic that is no sphere's, f_ew = 0: only the cubic form chooses directions."""

    def monkey(s, t):
        return [s, t, s * s + t * t + s**3 - 3 * s * t**2]

    cones = hyperosculating_cones(monkey, 0.0, 0.0, half_angle=0.4, model="space")
    assert cones.count == 6 and cones.gouges.all()
    np.testing.assert_allclose(cones.distance, np.full(6, 0.5 / np.tan(0.4)), rtol=1e-12)


# ---- zeros on the circle, and what rounding leaves ---------------------------------------------


def with_zeros(zeros, size=1.0):
    """Return a trigonometric polynomial of degree 3 with six zeros, as a function of angles."""
    return lambda a: size * np.prod([np.sin((a - z) / 2) for z in zeros], axis=0).real


@given(st.lists(st.floats(1, 20), min_size=6, max_size=6), st.floats(1e-9, 1e9))
def test_all_zeros_on_the_circle_are_found(gaps, size):
    zeros = 6.2 * np.cumsum(gaps) / sum(gaps) - 3.1  # 0.06 rad apart or more
    function = with_zeros(zeros, size)
    angle, multiplicity = real_zeros(function, 3, unit=np.array([size]))
    np.testing.assert_allclose(angle[0], zeros, atol=1e-8)
    assert multiplicity.tolist() == [[1] * 6]


@pytest.mark.parametrize(("zeros", "expected"), [
    ([0.5, 0.5, 1, 2, -2, -1], [1, 1, 1, 1, 2]),
    ([0.5, 0.5 + 1e-6, 1, 2, -2, -1], [1, 1, 1, 1, 2]),
    ([0.5 + 1e-6j, 0.5 - 1e-6j, 1, 2, -2, -1], [1, 1, 1, 1, 2]),
    ([0.5, 0.5 + 1e-4, 1, 2, -2, -1], [1, 1, 1, 1, 1, 1]),
    ([0.5 + 1e-4j, 0.5 - 1e-4j, 1, 2, -2, -1], [1, 1, 1, 1]),
    ([np.pi, np.pi, 1, 2, -2, -1], [1, 1, 1, 1, 2]),
    ([0.5, 0.5, 0.5, 2, -2, -1], [1, 1, 1, 3]),
    ([0, np.pi, 1j, -1j, np.pi + 1j, np.pi - 1j], [1, 1]),  # odd, as are all its derivatives
])  # fmt: skip
def test_zeros_nearer_than_a_fifty_thousandth_count_as_one(zeros, expected):
    function = with_zeros(np.array(zeros))
    _, multiplicity = real_zeros(function, 3, unit=np.ones(1))
    assert sorted(multiplicity[multiplicity > 0]) == expected


def test_zeros_of_a_lower_degree_and_of_nothing():
    angle, _ = real_zeros(lambda a: np.sin(2 * a), 3, unit=np.ones(1))
    np.testing.assert_allclose(np.sort(np.abs(angle[0, :4])), [0, np.pi / 2, np.pi / 2, np.pi],
                               atol=1e-12)  # fmt: skip
    angle, multiplicity = real_zeros(lambda a: 0 * a, 3, unit=np.ones(1))
    assert np.isnan(angle).all() and not multiplicity.any()


RHO = 0.8


def cones_by(*forms):
    """Return the cones of a graph with these forms of degree 2, 3 and 4 at the origin."""

    def f(x, y):
        return sum(
            c * x ** (len(form) - 1 - k) * y**k for form in forms for k, c in enumerate(form) if c
        )

    return hyperosculating_cones(f, 0.0, 0.0, half_angle=np.arctan(0.5 / RHO))


def test_forms_that_vanish_within_rounding_have_no_cones():
    sphere = cones_by((2.0, 1e-13, 2.0), (0.0,) * 4, (1.0,) * 5)
    assert sphere.state == "spherical" and len(sphere) == 0
    assert len(cones_by((2.0, 1e-9, 2.0), (0.0,) * 4, (1.0,) * 5)) == 4


def norm_of(p):
    """Return the root of the squares of all derivatives, each as often as it is one."""
    d = len(p) - 1
    own = [p[i] * factorial(d - i) * factorial(i) for i in range(d + 1)]
    return np.sqrt(sum(comb(d, i) * own[i] ** 2 for i in range(d + 1)))


def test_terms_that_all_but_vanish_are_compared_with_a_thousandth_of_the_forms():
    small = 1e-10
    forms = (1.0, 0.0, 1.0), (0.0, 0.0, 0.0, 2.0), (small, 0.0, -0.2, 0.5, 3.0)
    floor = RHO**2 * norm_of(forms[2]) + 6 * RHO * norm_of(forms[1]) + 3 * norm_of(forms[0])
    cones = cones_by(*forms)
    expected = RHO**2 * 24 * small / (1e-3 * floor)
    flat = cones.order4[cones.multiplicity == 3]
    assert flat == pytest.approx(np.full(len(flat), expected), rel=1e-3) and len(flat) == 2
