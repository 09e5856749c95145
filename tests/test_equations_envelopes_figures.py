"""Envelopes of moving cones: what its figures show.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

import numpy as np
import sympy as sp

from tests.envelopes_zoo import CURVES, DEVELOPABLE, GRID, MOTIONS, ruled
from tests.symbols_envelopes import ANGLE, circle_centre, example, t, zero
from tunneller_lib.envelopes import isotropic
from tunneller_lib.envelopes.adapted import adapted_frames
from tunneller_lib.envelopes.developable import osculating_cone, tangent_planes
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.jet import jet_variables

READS = ["report/ledger/*"]


def test_fig1_characteristic_of_degree_four(judge):
    """On a cone the normal is linear in the point, so is velocity: their product cuts a quartic."""
    X = sp.Matrix(sp.symbols("X Y Z"))
    k = sp.Symbol("k", positive=True)
    gradient = sp.Matrix([X[0], X[1], -k * X[2]])
    c, w = sp.Matrix(sp.symbols("c1:4")), sp.Matrix(sp.symbols("w1:4"))
    speed = gradient.dot(c + w.cross(X))
    quartic = sp.Poly(speed, *X).total_degree() == 2  # with the cone: degree 2 times 2
    lines = sp.Poly(gradient.dot(c), *X).homogeneous_order() == 1  # a plane through the vertex
    # Velocities have the same component along the axis all along it.
    a = sp.Matrix([0, 0, 1])
    one = sp.expand((c + w.cross(t * a)).dot(a)) == c.dot(a)
    judge("cones-fig1", quartic and lines and one)


def test_fig2_tangent_planes_turn_along_a_skew_ruling(judge):
    s, w = np.full(5, 0.4), np.linspace(0.1, 0.5, 5)
    turned = adapted_frames(ruled("saddle"), s, w, "space").axes[:, 2]
    fixed = adapted_frames(DEVELOPABLE["tangents of the helix"], s, w, "space").axes[:, 2]
    turn, stay = (np.abs(n - n[0]).max() for n in (turned, fixed))
    judge("cones-fig2", turn > 0.1 and stay < 1e-12)


def test_fig4_osculating_circle_in_the_top_view(judge):
    """The osculating cone lies over the top view's osculating circle; its vertex on the edge."""
    s0 = 0.6
    planes = tangent_planes(lambda s: CURVES["helix"](s)[0], s0 + np.array([-1e-3, 0, 1e-3]))
    near = isotropic.plane_to_point(*planes)
    centre = circle_centre(near)
    slope = np.linalg.solve(near[[0, 2], :2] - near[1, :2], near[[0, 2], 2] - near[1, 2])
    U, V = centre - near[1, :2]
    vertex = isotropic.cone_vertex(near[1], (U, V), slope @ [V, -U], slope @ [U, V])
    judge("cones-fig4", np.allclose(vertex, CURVES["helix"](s0)[0], atol=1e-5))


def _slope_planes(s):
    """Return planes of one slope through the tangents of an ellipse."""
    normals = np.stack([np.cos(s), np.sin(s), 1 + 0 * s], axis=-1) / np.sqrt(2)
    return normals, -np.sqrt(4 * np.cos(s) ** 2 + np.sin(s) ** 2) / np.sqrt(2)


def test_fig5_hyperosculation_of_a_developable(judge):
    """Planes of one slope on an ellipse, at its vertices; not the tangents of a regular edge."""
    # Their normals are on a circle; they leave the cone with the evolute's point for a vertex by
    # p''' + p', the rate of the radius of curvature, which is 0 at the ellipse's vertices alone.
    a, b = sp.symbols("a b", positive=True)
    support = sp.sqrt(a**2 * sp.cos(t) ** 2 + b**2 * sp.sin(t) ** 2)
    radius = a**2 * b**2 / support**3
    assert zero(support + support.diff(t, 2) - radius)
    rate = 3 * a**2 * b**2 * (a**2 - b**2) * sp.sin(t) * sp.cos(t) / support**5
    assert zero(radius.diff(t) - rate)
    powers = {}
    for s0 in (0.0, np.pi / 2, 0.7):
        p0, p1, rho = (float(e.subs({a: 2, b: 1, t: s0}))
                       for e in (support, support.diff(t), radius))  # fmt: skip
        turn = np.array([[np.cos(s0), np.sin(s0)], [-np.sin(s0), np.cos(s0)]])
        vertex = np.array([*((p0 - rho, p1) @ turn), rho])
        gaps = [n @ vertex + h for n, h in (_slope_planes(s0 + step) for step in (0.01, 0.02))]
        powers[s0] = np.log2(gaps[1] / gaps[0])
    assert abs(powers[0.7] - 3) < 0.05
    judge("cones-fig5", all(abs(powers[s0] - 4) < 0.05 for s0 in (0.0, np.pi / 2)))
    # A regular edge: its planes leave each of its points by curvature times torsion over 6.
    bend, twist = (sp.Function(name)(t) for name in ("bend", "twist"))
    q = [sp.Function(f"q{axis}")(t) for axis in "TNB"]  # from the moving frame to the point
    turned = bend * q[1] - 1, twist * q[2] - bend * q[0], -twist * q[1]
    rates = {c.diff(t): rate for c, rate in zip(q, turned, strict=True)}
    away = q[2]
    for order in (1, 2, 3):
        away = sp.expand(away.diff(t).subs(rates))
        left = away.subs(dict.fromkeys(q, 0))
        assert zero(left + (bend * twist if order == 3 else 0))


def test_fig6_common_plane(judge):
    """Surface and cone have the plane and the ruling; their neighbours part at third order."""

    def edge(s):
        return CURVES["knot"](s)[0]

    vertex, axis, angle = osculating_cone(edge, 0.6)
    n, h = tangent_planes(edge, 0.6)
    shared = np.isclose(n @ axis, np.sin(angle)) and np.isclose(n @ vertex, -h)
    gaps = []
    for step in (0.01, 0.02):
        n, h = tangent_planes(edge, 0.6 + step)
        gaps.append((n @ vertex + h, n @ axis - np.sin(angle)))
    powers = np.log2(np.divide(*gaps[::-1]))
    judge("cones-fig6", shared and powers.shape == (2,) and np.all(np.abs(powers - 3) < 0.1))


def test_fig7_contact_curve_crosses_the_circles(judge):
    """Along the motion the planes leave the cone's circle, where the envelope is regular."""
    surface = moving_cone(MOTIONS["screw"], ANGLE)
    n = adapted_frames(surface, *GRID, "space").n
    across = n[0].derivative(1, 0) * n[1].derivative(0, 1)
    across = across - n[0].derivative(0, 1) * n[1].derivative(1, 0)
    judge("cones-fig7", np.abs(across).min() > 1e-3)


def test_fig8_circle_through_the_point(judge):
    z, a, b = isotropic.osculating_conic((0.4, 0.2), example(*jet_variables(0.5, 0.3)))
    points = isotropic.conic((0.5, 0.3, z), (0.4, 0.2), a, b, np.linspace(0, 6, 7))
    through = np.allclose(points[0], (0.5, 0.3, z))
    radii = np.linalg.norm(points[:, :2] - (0.9, 0.5), axis=1)
    judge("cones-fig8", through and np.allclose(radii, np.hypot(0.4, 0.2)))
