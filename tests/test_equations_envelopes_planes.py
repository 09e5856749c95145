"""Envelopes of moving cones, section 4: planes as points, contact, Eqs 5 to 7.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

import numpy as np
import sympy as sp
from numpy.polynomial import Polynomial

from tests import symbols_envelopes as shared
from tests.draws import directions
from tests.envelopes_zoo import GENERAL, GRID, MOTIONS
from tests.symbols_envelopes import ANGLE, g, t, x, y, zero
from tunneller_lib.envelopes import hyperosculating_cones, isotropic
from tunneller_lib.envelopes.adapted import adapted_frames, isotropic_jet, tangent_graph
from tunneller_lib.envelopes.families import moving_cone
from tunneller_lib.envelopes.jet import jet_variables

READS = ["report/ledger/*"]


def test_eq05_envelope_of_moving_planes(judge):
    """The library's moving cone is Eq. 5: its point lies on the cone and is touched there."""
    common = []
    sine, cosine = np.sin(ANGLE), np.cos(ANGLE)
    for motion in MOTIONS.values():
        surface = moving_cone(motion, ANGLE)
        found = adapted_frames(surface, *GRID, "space")
        # The three planes themselves: T and its derivatives hold the point.
        turn, time = jet_variables(*GRID)
        vertex, _, (a, b, c), _ = motion(time)
        plane = [sine * i + cosine * (np.cos(turn) * j + np.sin(turn) * k)
                 for i, j, k in zip(a, b, c, strict=True)]  # fmt: skip
        plane.append(-sum(i * j for i, j in zip(plane, vertex, strict=True)))
        for order in ((0, 0), (1, 0), (0, 1)):
            T = [part.derivative(*order) for part in plane]
            left = sum(i * j for i, j in zip(T[:3], found.contact.T, strict=True)) + T[3]
            common.append(np.abs(left).max() < 1e-10)
    judge("cones-eq05", len(common) == 18 and all(common))


def test_eq06_planes_to_points(judge):
    n, h = directions(np.random.default_rng(0), 20), np.linspace(-3, 3, 20)
    expected = np.column_stack([n[:, :2], h]) / (n[:, 2:] + 1)
    assert np.allclose(isotropic.plane_to_point(n, h), expected, rtol=1e-12)
    back = isotropic.point_to_plane(expected)  # no two planes have one point
    judge("cones-eq06", np.allclose(back[0], n) and np.allclose(back[1], h))


def test_eq07_spheres_to_paraboloids(judge):
    n = directions(np.random.default_rng(1), 50)
    m, radius = np.array([0.3, -0.7, 0.5]), 0.8
    a, b, c = isotropic.plane_to_point(n, radius - n @ m).T  # inward normals
    printed = (radius + m[2]) / 2 * (a**2 + b**2) - m[0] * a - m[1] * b + (radius - m[2]) / 2
    judge("cones-eq07", np.allclose(printed / c, 1, rtol=1e-9))


def test_top_view_is_the_stereographic_projection(judge):
    n = directions(np.random.default_rng(2), 50)
    a, b, _ = isotropic.plane_to_point(n, 0.0).T
    south = np.array([0, 0, -1.0])
    picture = south + (n - south) / (n[:, 2:] + 1)  # meets z = 0
    assert np.allclose(picture[:, 2], 0, atol=1e-15)
    judge("cones-topview", np.allclose(np.column_stack([a, b]), picture[:, :2], rtol=1e-10))


def test_prop6_cones_to_special_conics(judge):
    rng = np.random.default_rng(3)
    so_it_is, radius_of_normals = [], []
    for angle in (0.2, ANGLE, 1.2):
        points = shared.cone_points(rng.normal(size=3), directions(rng, 1)[0], angle)
        flat = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        so_it_is.append(flat[2] < 1e-10 * flat[0])  # a planar curve
        centre = shared.circle_centre(points)
        radii = np.linalg.norm(points[:, :2] - centre, axis=1)
        so_it_is.append(np.ptp(radii) < 1e-9 * flat[0])  # over a circle
        radius_of_normals.append(abs(shared.intrinsic_radius(points) - (np.pi / 2 - angle)))
    judge("cones-fig3", np.max(radius_of_normals) < 1e-9)
    so_it_is.append(np.max(radius_of_normals) < 1e-9)
    judge("cones-prop6", len(so_it_is) == 7 and all(so_it_is))


def test_prop7_tangent_cones_are_conics_in_the_surface(judge):
    surface = moving_cone(MOTIONS["screw"], ANGLE)
    flat, special = {}, {}
    moves, stays = np.linspace(0.2, 0.7, 9), np.full(9, 0.3)
    along, across = (moves, stays), (stays, np.linspace(0, 1, 9))
    for name, line in (("along", along), ("across", across)):
        found = adapted_frames(surface, *line, "space")
        n = found.axes[:, 2]
        points = isotropic.plane_to_point(n, -(n * found.contact).sum(-1))
        thick = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        flat[name] = thick[2] / thick[0]
        special[name] = abs(shared.intrinsic_radius(points) - (np.pi / 2 - ANGLE)) < 1e-9
    judge("cones-prop7", flat["along"] < 1e-10 and special["along"])
    assert flat["across"] > 1e-6  # lines across the characteristic are no cone's


def nested(centres, radii):
    """Tell whether of any two circles one lies within the other."""
    apart = np.linalg.norm(centres[:, None] - centres, axis=-1)
    within = apart < np.abs(radii[:, None] - radii)
    return np.all(within | np.eye(len(radii), dtype=bool))


def test_osculating_circles_between_vertices(judge):
    # By a curve's support function p: the radius is p + p'', the centre moves by as much as the
    # radius grows and turns as it does so, so that circles between vertices are nested.
    support = sp.Function("support")(t)
    n = sp.Matrix([sp.cos(t), sp.sin(t)])
    radius = support + support.diff(t, 2)
    middle = support * n + support.diff(t) * n.diff(t) - radius * n
    assert all(zero(e) for e in middle.diff(t) + radius.diff(t) * n)
    # An oval with vertices at each sixth of a turn, where cos(3 t) has its extremes. Circles at
    # equal turns on both sides of one have one size, and cross.
    oval = [form.subs(support, 1 + sp.cos(3 * t) / 20).doit() for form in (radius, middle)]
    size, centre = (sp.lambdify(t, form) for form in oval)

    def are_nested(turns):
        return nested(np.array([centre(s).ravel() for s in turns]), size(turns))

    sixth, found = np.pi / 3, {"between two vertices": [], "across a vertex": []}
    for vertex in sixth * np.arange(6):
        found["between two vertices"].append(are_nested(vertex + np.linspace(0, sixth, 12)))
        found["across a vertex"].append(are_nested(vertex + np.array([-0.3, 0.3])))
    assert size(np.linspace(0, 2 * np.pi, 99)).min() > 0 and not any(found["across a vertex"])
    judge("cones-nested", cases={where: all(seen) for where, seen in found.items()})


def test_definition8_contact_of_a_curve_and_a_graph(judge):
    def graph(a, b):
        return a**2 - 3 * a * b + b**3 + 2 * a

    def orders(gap, s):
        """Return up to which power the gap vanishes, by the quotient and by its derivatives."""
        powers = [n for n in range(6) if sp.limit(gap / s**n, s, 0) == 0]
        still = [n for n in range(6) if all(gap.diff(s, k).subs(s, 0) == 0 for k in range(n + 1))]
        assert powers == still == list(range(len(powers)))
        return len(powers) - 1

    across, up = t + t**2, 1 - 2 * t + t**3
    as_said = []
    for n in range(5):
        curve = sp.Matrix([across, up, graph(across, up) + 7 * t ** (n + 1)])
        as_said.append(orders(sp.expand(curve[2] - graph(curve[0], curve[1])), t) == n)
        # Another parameter, with a rate of its own.
        other = curve.subs(t, 3 * g - g**2)
        as_said.append(orders(sp.expand(other[2] - graph(other[0], other[1])), g) == n)
        # Curves in the graph that agree with it so far: its shadow, and as many more as one likes.
        for aside in (0, 1, -4):
            held = across + aside * t ** (n + 1)
            within = sp.Matrix([held, up, graph(held, up)])
            as_said.append(min(orders(sp.expand(e), t) for e in curve - within) == n)
    judge("cones-def8", len(as_said) == 25 and all(as_said))


def test_planes_through_a_tangent(judge):
    # An elliptic point, 2 z = a x^2 + 2 b x y + c y^2 with a, c, a c - b^2 > 0; planes through x.
    a, c, rest = sp.symbols("a c rest", positive=True)
    b = sp.sqrt(a * c - rest)
    form = (a * x**2 + 2 * b * x * y + c * y**2) / 2
    # Inclined by its tangent m against the normal, y = m z, the curve is z = a x^2/2 + ...
    m = sp.Symbol("m", real=True)
    height = sp.Function("height")(x)
    cut = height - form.subs(y, m * height)
    at_rest = {height: 0, x: 0}
    first = sp.solve(cut.diff(x).subs(height.diff(x), g).subs(at_rest), g)
    assert first == [0] and cut.subs(at_rest) == 0
    second = cut.diff(x, 2).subs(height.diff(x, 2), t).subs(height.diff(x), 0).subs(at_rest)
    [bend] = sp.solve(second, t)
    # The tangent plane, z = 0: a sum of squares, zero in the point alone.
    assert zero(form - ((a * x + b * y) ** 2 + rest * y**2) / (2 * a))
    leaves = sp.discriminant(form.subs(x, 1), y)  # a curve needs directions where the form is 0
    judge("cones-pencil", cases={"an inclined plane": zero(bend - a),  # of order 1 and no more
                                 "the tangent plane": bool(leaves >= 0)})  # fmt: skip


def test_sphere_and_cone_touch_to_first_order_only(judge):
    """All planes of a circumscribed cone touch the sphere; its rulings leave it at second order."""
    radius, vertex = 1.0, np.array([0, 0, -2.0])
    n, h = isotropic.cone_planes(vertex, (0, 0, 1), np.arcsin(0.5), np.linspace(0, 6, 7))
    in_common = np.allclose(h, radius)  # the distance of the sphere's centre
    touch = -n
    away = touch + 1e-3 * (touch - vertex) / np.sqrt(3)
    outside = np.linalg.norm(away, axis=1) - radius
    judge("cones-sphere-cone", in_common and np.allclose(outside, 0.5e-6, rtol=1e-3, atol=0))


def test_osculating_cones_touch_mannheims_sphere(judge):
    """For one ruling the osculating cones of all angles have a common inscribed sphere."""
    found = adapted_frames(GENERAL["quartic graph"], np.array([0.3]), np.array([0.2]), "space")
    jet = isotropic_jet(found, slice(None))
    first, second, n = found.axes[0]
    a = 0.7
    e, w = (np.cos(a), np.sin(a)), np.cos(a) * second - np.sin(a) * first
    fee = e[0] ** 2 * jet.derivative(2, 0) + 2 * e[0] * e[1] * jet.derivative(1, 1)
    fee = (fee + e[1] ** 2 * jet.derivative(0, 2))[0]
    centre = found.contact[0] + fee / 2 * n
    touch = []
    for angle in (0.2, 0.5, 1.0):
        rho = 0.5 / np.tan(angle)
        point = isotropic.cone_vertex((0, 0, 0), (-e[1] * rho, e[0] * rho), 0, fee * rho**2)
        vertex = found.contact[0] + point[0] * first + point[1] * second
        axis = np.cos(angle) * w + np.sin(angle) * n
        touch.append(np.allclose(np.cross(centre - vertex, axis), 0, atol=1e-12))
        touch.append(np.isclose(np.linalg.norm(centre - vertex) * np.sin(angle), abs(fee) / 2))
    judge("cones-mannheim", len(touch) == 6 and all(touch))


def test_appropriate_direction_is_not_conjugate_to_the_ruling(judge):
    """The characteristic's tangent is conjugate to the cone's ruling."""
    surface = moving_cone(MOTIONS["wave"], ANGLE)
    r = surface(*jet_variables(*GRID))
    found = adapted_frames(surface, *GRID, "space")
    along = np.stack([c.derivative(1, 0) for c in r], axis=-1)
    vertex = np.stack([c + 0 * GRID[0] for c in MOTIONS["wave"](GRID[1])[0]], axis=-1)
    ruling = found.contact - vertex
    graph = tangent_graph(found, found.smooth)
    e, w = (np.einsum("nij,nj->ni", found.axes[:, :2], vector) for vector in (along, ruling))
    bend = (graph.derivative(2, 0) * e[:, 0] * w[:, 0] + graph.derivative(0, 2) * e[:, 1] * w[:, 1]
            + graph.derivative(1, 1) * (e[:, 0] * w[:, 1] + e[:, 1] * w[:, 0]))  # fmt: skip
    scale = np.linalg.norm(e, axis=1) * np.linalg.norm(w, axis=1)
    judge("cones-direction", np.abs(bend / scale).max() < 1e-10)


def test_third_order_contact_is_not_always_free(judge):
    """Four of the six cones of Example 31 hold points of the surface next to the contact."""
    cones = hyperosculating_cones(shared.example, 0.5, 0.3, half_angle=ANGLE)
    near = np.linspace(-0.04, 0.04, 121)
    r = isotropic.surface_points(shared.example, *np.meshgrid(0.5 + near, 0.3 + near))
    depths = [cone.pose.clearance(r).min() for cone in cones]
    enters = np.less(depths, -1e-9)
    judge("cones-free", not np.any(enters))

    # A second way: over each cone's own circle the surface lies within four of them by the fourth
    # power of the step, and on both generators.
    def within(cones, k, graph, place, steps):
        """Return how deep points of a surface, by steps over the circle of cone k, are in it."""
        centre = complex(*shared.conic_of(cones, k)[1])
        away = complex(*place) - centre
        over = centre + away * np.exp(1j * np.array(steps) / abs(away))
        return -cones[k].pose.clearance(isotropic.surface_points(graph, over.real, over.imag))

    for k in range(6):
        deep = within(cones, k, shared.example, (0.5, 0.3), (0.01, 0.02))
        if enters[k]:
            assert deep.min() > 0 and abs(np.log2(deep[1] / deep[0]) - 4) < 0.1
        else:
            assert np.abs(deep).max() < 1e-13
    # With K < 0 both signs occur; where the residual has that of f_ee = 24 it's free.
    for fourth, free in ((4, False), (8, True)):
        graph = sp.lambdify((x, y), 12 * x**2 - 12 * y**2 + fourth * x**4)
        cones = hyperosculating_cones(graph, 0.0, 0.0, half_angle=np.arctan(0.5))
        for k in (0, 2):  # along the x axis
            deep = within(cones, k, graph, (0.0, 0.0), (0.05, -0.1))
            assert np.all((deep < 0) == free) and (cones[k].verdict == "free") == free


def test_curves_in_contact_envelop_surfaces_in_contact_along_a_ruling(judge):
    """A point beside the common ruling is off the other surface by the power n + 1 of its place."""
    rng, orders = np.random.default_rng(31), {1: [], 2: [], 3: []}

    def planes(x, y, z):
        """Return the planes of a curve of the model, unnormalised, by its parameter."""
        return [2 * x, 2 * y, 1 - x * x - y * y, 2 * z]

    for n, found in orders.items():
        curve = [Polynomial(rng.uniform(-1, 1, 5)) for _ in range(3)]
        gap = Polynomial([0] * (n + 1) + [1])
        one, two = planes(*curve), planes(*(part + rng.uniform(0.5, 1) * gap for part in curve))
        across = rng.uniform(-1, 1, 3)

        def off(step, along, one=one, two=two, across=across):
            """Return how far a point of one surface is from the other, and from the ruling."""
            T, T_u = ([part(step) for part in each] for each in (two, [p.deriv() for p in two]))
            point = np.linalg.solve([T[:3], T_u[:3], across], [-T[3], -T_u[3], along])
            height = sum(part * place for part, place in zip(one, [*point, 1], strict=True))
            roots = height.deriv().roots()
            touched = roots[np.argmin(abs(roots - step))].real
            return abs(height(touched)), point

        for along in (-1.0, 0.3, 2.0):
            (near, _), (far, _) = off(0.001, along), off(0.002, along)
            found.append(np.log2(far / near))
            start, moved = off(0.0, along)[1], off(0.002, along)[1]
            assert off(0.0, along)[0] < 1e-14 and 1e-4 < np.linalg.norm(moved - start) < 1
    judge("cones-common-ruling", all(np.allclose(orders[n], n + 1, atol=0.1) for n in orders))


def test_tangent_plane_and_its_derivative_meet_in_a_ruling(judge):
    # A cone about the z axis: its tangent planes by the angle around, and their derivatives.
    angle, half, far = sp.symbols("angle half far", positive=True)
    vertex = sp.Matrix(sp.symbols("vertex1:4", real=True))
    normal_ = sp.Matrix([sp.cos(half) * sp.cos(angle), sp.cos(half) * sp.sin(angle), -sp.sin(half)])
    ruling = sp.Matrix([sp.sin(half) * sp.cos(angle), sp.sin(half) * sp.sin(angle), sp.cos(half)])
    place = vertex + far * ruling
    height = -normal_.dot(vertex)
    T = normal_.dot(place) + height
    T_u = normal_.diff(angle).dot(place) + height.diff(angle)
    both = sp.simplify(T) == 0 and sp.simplify(T_u) == 0
    # Not parallel: their normals are at right angles, and neither vanishes.
    apart = sp.simplify(normal_.dot(normal_.diff(angle))) == 0
    size = sp.simplify(normal_.diff(angle).dot(normal_.diff(angle)) - sp.cos(half) ** 2) == 0
    judge("cones-rulings", both and apart and size)
