"""Envelopes of moving cones, sections 4 and 5: what contact is worth, and what solutions need.

The verdicts stand in report/ledger/cone-envelopes.toml.
"""

import numpy as np
import sympy as sp
from mpmath import mp
from scipy.optimize import fsolve

from tests import symbols_envelopes as shared
from tests.symbols_envelopes import ANGLE, EQ13, EX31, example, t, tan, x, y
from tunneller_lib.envelopes import hyperosculating_cones, isotropic
from tunneller_lib.envelopes.adapted import adapted_frames, tangent_graph
from tunneller_lib.envelopes.jet import jet_variables

READS = ["report/ledger/*"]

WAYS = ((1, 0), (0, 1), (1, -1))


def quartic(a, b):
    return a**2 - b**2 + 0.3 * a**3 * b + 0.2 * b**4


def order(gap):
    """Return up to which order a function of a step vanishes with it, by steps of 1e-6 and 1e-7."""
    first, second = gap(mp.mpf(10) ** -6), gap(mp.mpf(10) ** -7)
    found = mp.log10(abs(first / second)) - 1
    assert abs(found - mp.nint(found)) < 0.01
    return int(mp.nint(found))


# ---- 4: contact of tools and of surfaces ----------------------------------------------------


ACROSS = y - sp.Rational(3, 10) - x / 5  # 0 on a line that crosses the circles of Example 31
OUTLINE = 3 - x**2 - y**2  # 0 on the circle that all of them touch


def on_circle(circle, step):
    """Return a place on a circle through (0, 0) over which a conic of Example 31 lies."""
    radius = mp.sqrt(3) / 2  # cot(30 degrees)/2
    return [radius * (of(circle) + of(step)) for of in (mp.cos, mp.sin)]


def cyclide_contacts(gap, circle, contact):
    """Return in which order planes of a cone, and points, leave Example 31 for f + gap."""
    f = EX31 + gap
    between, other = (
        sp.lambdify((x, y), form, "mpmath") for form in (gap, [f, f.diff(x), f.diff(y)])
    )
    a, b = on_circle(circle, contact)

    def points(step, way):
        p, q = a + step * way[0], b + step * way[1]
        f_, fx, fy = other(p, q)
        r3 = 2 * (p * fx + q * fy - f_) / (1 + p * p + q * q)  # Eq. 20
        r1, r2 = p * r3 - fx, q * r3 - fy
        return r3 * (r1 * r1 + r2 * r2 + r3 * r3) + 2 * (r1 * r1 + r3 * r3)

    assert abs(points(0, (0, 0))) < 1e-50
    planes = order(lambda step: between(*on_circle(circle, contact + step)))
    return planes, {order(lambda step, way=way: points(step, way)) for way in WAYS}


def test_contact_of_tools_is_contact_of_surfaces(judge):
    as_said, line = [], sp.lambdify((x, y), ACROSS, "mpmath")
    with mp.workdps(60):
        for n in (1, 2, 3, 4):
            # Tool positions with contact of order n in the space of planes, along a curve that
            # crosses them: so have, as points, the surface and the envelope.
            for circle in (mp.mpf("0.3"), mp.mpf(1), mp.mpf("-0.2")):
                contact = mp.findroot(lambda t, c=circle: line(*on_circle(c, t)), circle + 0.2)
                gap = ACROSS ** (n + 1) * (1 + x * y) / 5
                planes, points = cyclide_contacts(gap, circle, contact)
                assert planes == n
                as_said.append(points == {n})  # and no other order of planes leaves that of points
        # The tool must move across its circles: along the curve that all of them touch, planes
        # have order 3 or 5 and the surfaces only 1 or 2.
        for power, orders in ((2, (3, {1})), (3, (5, {2}))):
            gap = OUTLINE**power * (1 + x * y) / 5
            for circle in (mp.mpf("0.3"), mp.mpf(1)):
                assert cyclide_contacts(gap, circle, circle) == orders
    judge("cones-contact-transfer", len(as_said) == 12 and all(as_said))


def over(direction, place):
    """Return the centre, from the place, of a special circle through it (Eq. 9)."""
    way = np.array([np.cos(direction), np.sin(direction)])
    return way * (1 + np.dot(place, place)) / 2 / (np.tan(ANGLE) - np.dot(place, way))


def hyperosculating_directions(f, place):
    """Return the directions of the circles of the cones at a place, ascending."""
    cones = hyperosculating_cones(f, *place, half_angle=ANGLE)
    centres = [shared.conic_of(cones, k)[1] - place for k in range(len(cones))]
    return np.sort([np.arctan2(y, x) for x, y in centres])


def twice_tangent(f, place, start, apart):
    """Return the vertex of a cone that touches f's surface here and `apart` from here."""
    jet = f(*jet_variables(*place))
    slope = np.array([float(jet.derivative(1, 0)), float(jet.derivative(0, 1))])
    here = np.array([*place, float(jet.value)])
    turn = apart / np.hypot(*over(start, place))

    def conic_of(direction, b):
        U, V = over(direction, place)
        return (U, V), slope[0] * V - slope[1] * U, b

    def left(unknown):
        (U, V), a, b = conic_of(*unknown)
        s, _ = jet_variables(turn, 0.0)
        back = 1 - np.cos(s)
        gap = here[2] + a * np.sin(s) + b * back
        gap = gap - f(here[0] + V * np.sin(s) + U * back, here[1] - U * np.sin(s) + V * back)
        value, rate = float(gap.value), float(gap.derivative(1, 0))
        return [value / turn**2, (turn * rate - 2 * value) / turn**3]

    _, _, b = isotropic.osculating_conic(over(start, place), jet)
    found = fsolve(left, (start, b), xtol=1e-13, full_output=True)[0]  # as rounding lets it
    assert np.abs(left(found)).max() < 1e-7  # it touches there, too
    return isotropic.cone_vertex(here, *conic_of(*found))


def test_doubly_tangent_cones_are_near(judge):
    # A cone of the same angle that touches here and a little farther on: Newton's method from
    # the cone in third-order contact, whose root of Eq. 11 is simple.
    near = []
    for f, places in ((example, ((0.5, 0.3), (0.3, 0.2))),
                      (quartic, ((0.5, 0.3), (0.3, 0.2), (-0.4, 0.6)))):  # fmt: skip
        for place in places:
            starts = hyperosculating_directions(f, place)
            jet = f(*jet_variables(*place))
            for start in starts:
                centre = over(start, place)
                _, slope, bend = isotropic.osculating_conic(centre, jet)
                limit = isotropic.cone_vertex((*place, float(jet.value)), centre, slope, bend)
                away = []
                for apart in (0.02, 0.005):
                    vertex = twice_tangent(f, place, start, apart)
                    away.append(np.linalg.norm(vertex - limit))
                near.append(away[1] < 0.3 * away[0] or away[0] < 1e-8)
    judge("cones-doubly-tangent", len(near) == 22 and all(near))


def saddle(s, t):
    return [s, t, s**2 - t**2 + 0.3 * s**3 * t + 0.2 * t**4]


def milled_width(place, start, beta, tolerance=1e-5):
    """Return how wide a strip hyperosculating cones mill along a straight row of contacts.

    The row runs at the angle beta from the direction conjugate to the first cone's ruling, all
    cones are put there, and points across the row are measured from the nearest.
    """
    cone = hyperosculating_cones(saddle, *place, half_angle=ANGLE, model="space")
    frame = adapted_frames(saddle, *np.array(place)[:, None], "space")
    first, second, _ = frame.axes[0]
    graph = tangent_graph(frame, frame.smooth)
    bend = [[graph.derivative(2, 0)[0], graph.derivative(1, 1)[0]],
            [graph.derivative(1, 1)[0], graph.derivative(0, 2)[0]]]  # fmt: skip
    ruling = cone.contact[start] - cone.vertex[start]
    p, q = np.array(bend) @ [ruling @ first, ruling @ second]
    conjugate = np.arctan2(p, -q)
    r = saddle(*jet_variables(*place))
    slopes = np.array([[c.derivative(1, 0), c.derivative(0, 1)] for c in r], float)

    def parameters(direction):
        way = np.cos(direction) * first + np.sin(direction) * second
        return np.linalg.lstsq(slopes, way, rcond=None)[0]

    row = place + np.linspace(-0.25, 0.25, 251)[:, None] * parameters(conjugate + beta)
    side = np.linspace(-0.12, 0.12, 97)
    across = place + side[:, None] * parameters(conjugate + beta + np.pi / 2)
    points = np.stack(saddle(*across.T), axis=-1)
    cones = hyperosculating_cones(saddle, *row.T, half_angle=ANGLE, model="space")
    picked = {125: np.flatnonzero(cones.index == 125)[start]}
    for i in [*range(126, 251), *range(124, -1, -1)]:  # outwards, each next to the last one
        there = np.flatnonzero(cones.index == i)
        before = cones.vertex[picked[i - 1 if i > 125 else i + 1]]
        steps = np.linalg.norm(cones.vertex[there] - before, axis=-1)
        picked[i] = there[np.argmin(steps)]
        assert steps.min() < 0.02
    left = np.min([cones[k].tool(10, 10).clearance(points) for k in picked.values()], axis=0)
    assert left.min() > -1e-6 and left[[0, -1]].min() > tolerance
    # Where the rest passes the tolerance, outwards from the row, by its fourth root.
    fourth = np.maximum(left, 0) ** 0.25
    ends = [np.interp(tolerance**0.25, fourth[half], np.abs(side[half]))
            for half in (slice(48, None), slice(48, None, -1))]  # fmt: skip
    return sum(ends)


def test_widest_strips_across_the_conjugate_direction(judge):
    # Cones put along rows in five directions through a point, and what they leave beside it.
    betas = np.radians([45, 60, 90, 120, 135])
    widest = []
    for place, starts in (((0.3, 0.2), (3,)), ((0.1, 0.15), (1, 2, 3))):
        for start in starts:
            width = np.array([milled_width(place, start, beta) for beta in betas])
            widest.append(np.argmax(width) == 2)
            assert np.ptp(width / np.sin(betas)) < 0.05 * width[2]
    judge("cones-widest", len(widest) == 4 and all(widest))


# ---- 5: what solutions need -----------------------------------------------------------------


def test_choice_that_jumps(judge):
    # Example 31 has two nonmultiple conics of fourth order at a point: one taken at random, anew
    # at each point, jumps between them, and yet each lies in the graph.
    rng = np.random.default_rng(13)
    a, b = rng.uniform(-0.8, 0.8, (2, 300))
    cones = hyperosculating_cones(example, a, b, half_angle=ANGLE)
    contained = []
    for i in np.argsort(a):
        both = np.flatnonzero((cones.index == i) & (np.abs(cones.order4) < 1e-10)
                              & (cones.multiplicity == 1))  # fmt: skip
        if len(both) != 2:
            continue  # too near a place where two fall together
        k = rng.choice(both)
        planes, _ = shared.conic_of(cones, k)
        size = 1 + np.abs(planes).max() ** 2
        contained.append(np.max(np.abs(planes[:, 2] - example(*planes.T[:2]))) < 1e-7 * size)
    # What makes it inessential: nonmultiple solutions are branches that move with the point.
    for f, place in ((example, (0.5, 0.3)), (quartic, (0.3, 0.2)), (quartic, (-0.4, 0.6))):
        here = np.array(hyperosculating_directions(f, place))
        for step in ((1e-4, 0), (0, 1e-4), (-1e-4, 1e-4)):
            there = hyperosculating_directions(f, np.add(place, step))
            assert len(there) == len(here) and np.max(np.abs(there - here)) < 1e-2
    judge("cones-continuity", len(contained) > 200 and all(contained))


def test_multiple_roots_are_unstable(judge):
    # By how much the roots of Eq. 13 move when its coefficients err by a share of 1e-9 or 1e-5.
    equation = sp.Poly(EQ13.subs(shared.jet_of(EX31)).subs(tan, 1 / sp.sqrt(3)), t)
    sextic = sp.lambdify((x, y), equation.all_coeffs())
    rng = np.random.default_rng(16)
    powers, lost = {}, {}
    # On the circle both generators are one.
    circle = np.sqrt(3) * np.cos(0.7), np.sqrt(3) * np.sin(0.7)
    for kind, place in {"simple": (0.5, 0.3), "double": circle}.items():
        roots = np.roots(sextic(*place))
        apart = np.sort(np.abs(roots[:, None] - roots), axis=1)[:, 1]
        assert (apart.min() < 1e-6) == (kind == "double")
        root = roots[apart.argmin() if kind == "double" else apart.argmax()].real
        moved, gone = [], 0
        for way in rng.uniform(-1, 1, (20, 7)):
            near = [np.roots(sextic(*place) * (1 + error * way)) for error in (1e-9, 1e-5)]
            nearest = [each[np.abs(each - root).argmin()] for each in near]
            moved.append(np.abs(np.subtract(nearest, root)))
            gone += abs(nearest[1].imag) > abs(nearest[1].real - root)
        ratios = np.log10(np.divide(*np.transpose(moved)[::-1])) / 4
        powers[kind], lost[kind] = (ratios.min(), ratios.max()), gone
    keeps = 0.99 < powers["simple"][0] and powers["simple"][1] < 1.01 and lost["simple"] == 0
    assert 0.49 < powers["double"][0] and powers["double"][1] < 0.51
    judge("cones-stable-roots", keeps and lost["double"] > 0)
