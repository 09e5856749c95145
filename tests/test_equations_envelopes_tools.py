"""Envelopes of moving cones, section 1: what tools do.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it and the corrected form is proved. The verdicts stand in report/ledger/cone-envelopes.toml.
"""

from dataclasses import replace

import numpy as np
import sympy as sp
from scipy.optimize import minimize

from tests.envelopes_zoo import CURVES, GRID, RULED, ruled, tangents
from tests.symbols_envelopes import ANGLE, CUBIC, example, g, t, tan, u, v, x, y, zero
from tunneller_lib.envelopes import ConePose, hyperosculating_cones, isotropic, recognise
from tunneller_lib.envelopes.adapted import adapted_frames
from tunneller_lib.envelopes.developable import osculating_cone
from tunneller_lib.envelopes.jet import jet_variables

READS = ["report/ledger/*"]


def test_point_contact_of_second_order(judge):
    # A cone's graph has a Hessian of determinant 0, and contact of order 2 shares the Hessian.
    cone = tan * sp.sqrt(x**2 + y**2)
    assert zero(cone.diff(x, 2) * cone.diff(y, 2) - cone.diff(x, y) ** 2)
    # A cone of 45 degrees that leaves a surface of revolution by the third power of the height,
    # all along a circle: K is 0 on that circle, and not beside it.
    height = sp.Symbol("height")
    away = sp.expand((1 + height + height**3) ** 2 - (1 + height) ** 2)
    assert sp.Poly(away, height).terms()[-1] == ((3,), 2)

    def on_a_circle(s, t):
        return [(1 + t + t**3) * np.cos(s), (1 + t + t**3) * np.sin(s), t]

    around, heights = np.meshgrid(np.linspace(0, 6, 7), [-0.1, 0.0, 0.1])
    found = hyperosculating_cones(on_a_circle, around, heights, half_angle=ANGLE, model="space")
    state = found.state
    assert np.all((state == "flat") == (heights == 0)) and np.all(state[::2] == "regular")
    # A cone for each point: tangents of a curve leave their osculating cones by the third power.
    everywhere = tangents(CURVES["cubic"])
    for s0, t0 in zip(*GRID, strict=True):
        vertex, axis, angle = osculating_cone(lambda s: CURVES["cubic"](s)[0], s0)
        out = np.stack(everywhere(s0 + np.array([1e-3, 2e-3]), t0), axis=-1) - vertex
        away = np.arccos(out @ axis / np.linalg.norm(out, axis=-1)) - angle
        assert abs(np.log2(away[1] / away[0]) - 3) < 0.05
    places = {"along a circle": (on_a_circle, around, heights),
              "everywhere": (everywhere, *GRID)}  # fmt: skip
    found = {name: recognise(*place, "developable", model="space").verdict
             for name, place in places.items()}  # fmt: skip
    judge("cones-point-contact", cases={name: word == "is" for name, word in found.items()})
    assert found["along a circle"] == "is not"


def test_osculation_penetrates(judge):
    """Of Example 31 at one point, in twelve directions: contact of order 2 is crossed as a cube.

    Cones that are smaller by that depth stay out.

    Over the cone's own circle the surface is within it on one side of the contact and without on
    the other: the first form by which graphs of exact order 2 differ takes both signs.
    """
    both_signs = zero(CUBIC.subs({u: -u, v: -v}, simultaneous=True) + CUBIC)
    place = np.array([0.5, 0.3])

    def near(size):
        steps = size * np.linspace(-1, 1, 121)
        places = np.meshgrid(*(place[:, None] + steps))
        return isotropic.surface_points(example, *places)

    jet, contact = example(*jet_variables(*place)), near(1e-3)[60, 60]
    enters, cubes, free, crossed = [], [], [], []
    for turn in np.linspace(0.1, 0.1 + 2 * np.pi, 12, endpoint=False):
        w = np.array([np.cos(turn), np.sin(turn)])
        c, e = centre = w * (1 + place @ place) / 2 / (np.tan(ANGLE) - place @ w)  # on Eq. 9
        z, a, b = isotropic.osculating_conic(centre, jet)
        vertex = isotropic.cone_vertex((*place, z), centre, a, b)
        one, two, three = (np.stack(isotropic.normal(*(place + step)), axis=-1)
                           for step in ((0, 0), (2 * c, 2 * e), (c + e, e - c)))  # fmt: skip
        axis = np.cross(two - one, three - one)
        axis *= np.sign(axis @ (contact - vertex)) / np.linalg.norm(axis)
        far = np.linalg.norm(contact - vertex)
        cone = ConePose(vertex, axis, ANGLE, near=far / 2, far=2 * far)
        half, whole = (-cone.clearance(near(size)).min() for size in (1e-3, 2e-3))
        enters.append(half > 1e-11)
        steps = 2e-4 * np.array([1, -1]) / np.hypot(*centre)
        along = isotropic.conic((*place, z), centre, a, b, steps)
        over = cone.clearance(isotropic.surface_points(example, *along[:, :2].T))
        crossed.append(over[0] * over[1] < 0)
        cubes.append(np.log2(whole / half))
        smaller = replace(cone, vertex=vertex + 1.01 * whole / np.sin(ANGLE) * axis)
        free.append(smaller.clearance(near(2e-3)).min() > 0)
    judge("cones-osculation", both_signs and len(crossed) == 12 and all(crossed))
    judge("cones-undercut", np.all(enters) and np.all(free))
    assert np.allclose(cubes, 3, atol=0.4)


def test_cylinders_mill_what_has_a_ruled_offset(judge):
    # A surface whose offset is ruled touches the cylinders about the rulings.
    s, t = GRID
    touched = []
    for name, lines in RULED.items():
        r = np.stack(np.broadcast_arrays(*ruled(name, 0.1)(s, t)), axis=-1)
        found = adapted_frames(ruled(name, 0.1), s, t, "space")
        point, _, along, _ = (np.stack(np.broadcast_arrays(*c), axis=-1) for c in lines(s))
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        out = r - point
        out = out - np.sum(out * along, axis=-1, keepdims=True) * along
        across = np.linalg.norm(np.cross(out, found.axes[:, 2]), axis=-1)
        touched.append(np.allclose(np.linalg.norm(out, axis=-1), 0.1, rtol=1e-12, atol=0))
        touched.append(np.max(across) < 1e-12)

    # One tolerance: where a ruled surface errs by so much from the offset, so does the cylinder.
    def offset(a, b):
        return np.array([a, b, a * b + 0.01 * np.cos(3 * a) * np.cos(2 * b)])

    def away(place, start):
        best = minimize(lambda at: np.sum((offset(*at) - place) ** 2), start, tol=1e-14)
        return np.sqrt(best.fun)

    places = [(a, b) for a in np.linspace(-0.5, 0.5, 5) for b in np.linspace(-0.5, 0.5, 5)]
    axes, milled = (np.array([np.stack(ruled("saddle", radius)(*place)) for place in places])
                    for radius in (0.0, 0.1))  # fmt: skip
    starts = [axis[:2] for axis in axes]
    erring = np.array([away(*both) for both in zip(axes, starts, strict=True)])
    errors = np.array([abs(away(*both) - 0.1) for both in zip(milled, starts, strict=True)])
    assert 0.007 < np.max(erring) <= 0.01
    as_well = np.allclose(errors, erring, rtol=1e-7, atol=2e-4)
    judge("cones-cylinder-offset", as_well and len(touched) == 12 and all(touched))


def test_cones_mill_a_hyperboloid(judge):
    a, c, z = sp.symbols("a c z", positive=True)
    focal = sp.sqrt(a**2 + c**2)
    outside = (x**2 + y**2) / a**2 - z**2 / c**2 - 1
    # Vertex (focal, 0, 0), axis along y, tan(theta) = c/a: its points have y^2 >= wall.
    wall = ((x - focal) ** 2 + z**2) * (a / c) ** 2
    left = sp.expand(outside.subs(y, sp.sqrt(wall)))
    # A square: the cone touches and never enters. Deeper in it a point is farther outside.
    milled = zero(left - (focal * x - a**2) ** 2 / (a * c) ** 2)
    assert outside.diff(y) == 2 * y / a**2
    # The conic of contact meets every parallel circle, so that turning covers the surface.
    assert zero((x**2 + wall).subs(x, a**2 / focal) - a**2 * (1 + z**2 / c**2))
    # Lines lie in it, and its normal turns along them.
    line = {x: a * sp.cos(t) - g * a * sp.sin(t), y: a * sp.sin(t) + g * a * sp.cos(t), z: g * c}
    normals = sp.Matrix([outside.diff(s) for s in (x, y, z)]).subs(line, simultaneous=True)
    is_ruled = zero(outside.subs(line, simultaneous=True))
    developable = all(zero(e) for e in normals.cross(normals.diff(g)))
    judge("cones-ruled-tools", developable or not (milled and is_ruled))
    # A second way: the library finds these cones from the surface's derivatives alone, and none
    # of the surface's points lies within them.
    around, heights = np.meshgrid(np.linspace(-np.pi, np.pi, 361), np.linspace(-2, 2, 161))
    for radius, height in ((1, 1), (2, 1)):

        def surface(s, t, radius=radius, height=height):
            size = radius * np.sqrt(1 + t * t / height**2)
            return [size * np.cos(s), size * np.sin(s), t]

        assert recognise(surface, *GRID, "ruled", model="space").verdict == "is"
        assert recognise(surface, *GRID, "developable", model="space").verdict == "is not"
        angle = np.arctan(height / radius)
        cones = hyperosculating_cones(surface, *GRID, half_angle=angle, model="space")
        which = np.flatnonzero(cones.undecided)  # those with contact of order 4
        assert set(cones.index[which]) == set(range(GRID[0].size))
        circle = np.hypot(*cones.vertex[which, :2].T)  # the focal one
        assert np.allclose(circle, np.hypot(radius, height), rtol=1e-9, atol=0)
        points = np.stack(surface(around, heights), axis=-1)
        for k in which[::9]:
            tool = ConePose(cones.vertex[k], cones.axis[k], angle, 0.0, 4.0)
            assert -1e-12 < tool.clearance(points).min() < 1e-3


def test_ruled_strips_approximate(judge):
    # Between curves x = k/n a strip's straight lines leave a graph by at most max |fxx|/(8 n^2).
    grid = np.linspace(0, 1, 41)
    well = []
    for form in (x**2 + y**2, x**2 - y**2, sp.sin(3 * x) * sp.cos(2 * y) + x * y**2):
        height = sp.lambdify((x, y), form, "numpy")
        curvature = sp.lambdify((x, y), form.diff(x, 2) + 0 * x, "numpy")
        bound = np.max(np.abs(curvature(*np.meshgrid(grid, grid))))
        errors = []
        for n in (8, 16, 32):
            low = np.arange(n)[:, None, None] / n
            share = np.linspace(0, 1, 17)[:, None]
            ruled_height = (1 - share) * height(low, grid) + share * height(low + 1 / n, grid)
            errors.append(np.max(np.abs(ruled_height - height(low + share / n, grid))))
            assert errors[-1] <= 1.02 * bound / (8 * n**2)
        well.append(3.5 < errors[0] / errors[1] < 4.5 and 3.5 < errors[1] / errors[2] < 4.5)
    judge("cones-ruled-approximation", len(well) == 3 and all(well))
