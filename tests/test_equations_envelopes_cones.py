"""Envelopes of moving cones, section 6: envelopes of cones, Eqs 17 to 22.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

import numpy as np
import sympy as sp

from tests import symbols_envelopes as shared
from tests.draws import directions
from tests.envelopes_zoo import GENERAL, GRID, MOTIONS
from tests.symbols_envelopes import ANGLE, SMALL, cone_points, eq22, example, u, v, x, y
from tunneller_lib.envelopes import ConePose, hyperosculating_cones, recognise
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.isotropic import contact_point, normal, osculating_conic
from tunneller_lib.envelopes.jet import differentiated, jet_variables

READS = ["report/ledger/*"]


def test_theorem16_envelopes_of_cones(judge):
    solved, others = [], []
    for motion in MOTIONS.values():
        surface = moving_cone(motion, SMALL)
        right = recognise(surface, *GRID, "cone", half_angle=SMALL, model="space")
        wrong = recognise(surface, *GRID, "cone", half_angle=SMALL + 0.1, model="space")
        solved.append(right.residual < 1e-10)
        others.append(wrong.residual > 1e-3)
    for surface in GENERAL.values():
        others.append(recognise(surface, *GRID, "cone", model="space").residual > 1e-3)
    assert len(solved) == 6 and len(others) == 9
    judge("cones-thm16", all(solved) and all(others))


def test_prop17_positive_curvature(judge):
    ellipsoid, steps = GENERAL["ellipsoid"], np.array([-2, -1, 0, 1, 2]) * 1e-3
    cones = hyperosculating_cones(ellipsoid, *GRID, half_angle=0.3, model="space")
    enters = []
    for k, i in enumerate(cones.index):  # points of the surface next to the contact
        near = np.meshgrid(GRID[0][i] + steps, GRID[1][i] + steps)
        tool = cones.vertex[k], cones.axis[k], 0.3, 0.5 * cones.distance[k], 2 * cones.distance[k]
        enters.append(ConePose(*tool).clearance(np.stack(ellipsoid(*near), -1)).min() < -1e-9)
    judge("cones-prop17", len(enters) >= 40 and all(enters))


def test_eq17_to_eq20_prop18_surface_and_graph(judge):
    a, b = 0.5, 0.3
    jet = example(*jet_variables(a, b))
    r = np.array(contact_point(a, b, jet.value, jet.derivative(1, 0), jet.derivative(0, 1)))
    fx, fy, value = jet.derivative(1, 0), jet.derivative(0, 1), jet.value
    square = a**2 + b**2 + 1
    printed = np.array([
        (a**2 - b**2 - 1) * fx + 2 * a * b * fy - 2 * a * value,
        (b**2 - a**2 - 1) * fy + 2 * a * b * fx - 2 * b * value,
        2 * a * fx + 2 * b * fy - 2 * value,
    ]) / square  # fmt: skip
    same = np.allclose(r, printed, atol=1e-13)  # (20) as printed
    n = np.array(normal(a, b))  # (17) to (19) as printed
    printed = -n @ r, n[0] * r[2] - r[0] * (n[2] + 1), n[1] * r[2] - r[1] * (n[2] + 1)
    there = np.allclose(np.divide(printed, n[2] + 1), (value, fx, fy), atol=1e-13)
    # The surface has these normals: derivatives of its points are across them.
    s, w = jet_variables(a, b)
    f4 = example(s, w)
    moving = contact_point(s, w, f4, differentiated(f4, 0), differentiated(f4, 1))
    steps = [sum(c.derivative(*order) * n for c, n in zip(moving, normal(a, b), strict=True))
             for order in ((1, 0), (0, 1))]  # fmt: skip
    judge("cones-eq17", same and there and np.max(np.abs(steps)) < 1e-12)


def test_eq21_normal(judge):
    a, b = place = np.array([0.4, -1.3])
    printed = np.array([2 * a, 2 * b, 1 - a**2 - b**2]) / (a**2 + b**2 + 1)
    back = printed[:2] / (printed[2] + 1)
    judge("cones-eq21", np.isclose(np.linalg.norm(printed), 1) and np.allclose(back, place))


def test_eq22_prop19_vertex(judge):
    rng = np.random.default_rng(6)
    returns = []
    for _ in range(20):
        vertex, axis, angle = rng.normal(size=3), directions(rng, 1)[0], rng.uniform(0.2, 1.3)
        points = cone_points(vertex, axis, angle)
        U, V = shared.circle_centre(points) - points[0, :2]
        slope = np.linalg.solve(points[1:3, :2] - points[0, :2], points[1:3, 2] - points[0, 2])
        here = dict(zip((x, y, u, v), (*points[0, :2], U, V), strict=True))
        printed = sp.Matrix(eq22(points[0, 2], slope @ [V, -U], slope @ [U, V])).subs(here)
        printed = np.array(printed.T, float)[0]
        returns.append(np.allclose(printed, vertex, atol=1e-8 * (1 + np.abs(points).max()) ** 2))
    judge("cones-eq22", len(returns) == 20 and all(returns))


def test_prop20_side_by_the_opposite_and_by_any_place(judge):
    x0, y0 = np.random.default_rng(7).uniform(0.3, 1.2, (2, 30))
    cones = hyperosculating_cones(example, x0, y0, half_angle=ANGLE)
    turns = np.array([np.pi, *np.linspace(0.1, 6.1, 13), 1e-3, -1e-3])  # far and near
    c, s = np.cos(turns), np.sin(turns)
    as_said = []
    for k, i in enumerate(cones.index):
        _, centre = shared.conic_of(cones, k)
        start = np.array([x0[i], y0[i]]) - centre
        there = centre + np.stack([c * start[0] - s * start[1], s * start[0] + c * start[1]], -1)
        sides = np.stack(normal(*there.T), axis=-1) @ (cones.contact[k] - cones.vertex[k])
        lies = np.sign(cones.axis[k] @ cones.normal[k])  # the half space that holds the cone
        as_said.append(np.sign(sides) == lies)
    assert len(as_said) >= 60
    judge("cones-prop20", np.all(np.array(as_said)[:, 0]))
    judge("cones-prop20-any", np.all(as_said))
    assert {*cones.side.tolist()} == {-1.0, 1.0}  # both sides occur


def test_remark21_distance(judge):
    cones = hyperosculating_cones(example, *GRID, half_angle=ANGLE)
    # As printed, by (20) and (22): from the circle over which the cone's planes lie.
    z, a, b = sp.symbols("z a b")
    vertex = sp.lambdify((x, y, u, v, z, a, b), eq22(z, a, b))
    printed = []
    for k, i in enumerate(cones.index):
        here = np.array([GRID[0][i], GRID[1][i]])
        centre = shared.conic_of(cones, k)[1] - here
        jet = example(*jet_variables(*here))
        r = contact_point(*here, jet.value, jet.derivative(1, 0), jet.derivative(0, 1))
        m = vertex(*here, *centre, *osculating_conic(centre, jet))
        printed.append(np.linalg.norm(np.subtract(m, r)))
    judge("cones-remark21", len(printed) >= 40 and np.allclose(printed, cones.distance, atol=1e-9))
