"""Symbols of the equations of cones' envelopes, and what several tests of them share.

Tests are tests/test_equations_envelopes_*.py.
"""

import numpy as np
import sympy as sp

from tests.symbols_tunneller import is_zero
from tunneller_lib.envelopes.adapted import model_jet
from tunneller_lib.envelopes.isotropic import cone_planes, normal, plane_to_point

x, y, u, v, t, g, tan = sp.symbols("x y u v t g tan", real=True)
p, W = 1 + x**2 + y**2, 1 + x**2 + y**2 + 2 * x * u + 2 * y * v
ANGLE, SMALL = np.radians(30), np.radians(20)
zero = is_zero


# The graph's derivatives: those of a jet, and with those of order 5.
ORDERS = [(i, j) for i in range(6) for j in range(6 - i)]
EVERY = {(i, j): sp.Symbol(f"f{'x' * i}{'y' * j}", real=True) for i, j in ORDERS}
NAMES = {order: symbol for order, symbol in EVERY.items() if sum(order) < 5}


def D(way, expression):
    """Return the derivative of an expression in x, y and derivatives of f along a fixed way."""
    moved = way[0] * expression.diff(x) + way[1] * expression.diff(y)
    for (i, j), symbol in EVERY.items():
        if symbol in expression.free_symbols:
            moved += expression.diff(symbol) * (way[0] * EVERY[i + 1, j] + way[1] * EVERY[i, j + 1])
    return moved


def jet_of(graph):
    """Return what stands for f and its derivatives where f is given by its formula."""
    return {s: graph.diff(*[x] * i, *[y] * j) if i + j else graph for (i, j), s in NAMES.items()}


def F(name):
    return NAMES[name.count("x"), name.count("y")]


EQ11 = (F("xxx") * v**3 - 3 * F("xxy") * v**2 * u + 3 * F("xyy") * v * u**2 - F("yyy") * u**3
        + 3 * (F("xx") - F("yy")) * u * v + 3 * F("xy") * (v**2 - u**2))  # fmt: skip
LOWER = (6 * u * v**2 * F("xxx") + 6 * v * (v**2 - 2 * u**2) * F("xxy")
         + 6 * u * (u**2 - 2 * v**2) * F("xyy") + 6 * u**2 * v * F("yyy")
         + 3 * (u**2 - v**2) * (F("xx") - F("yy")) + 12 * u * v * F("xy"))  # fmt: skip
EQ12 = (F("xxxx") * v**4 - 4 * F("xxxy") * v**3 * u + 6 * F("xxyy") * v**2 * u**2
        - 4 * F("xyyy") * v * u**3 + F("yyyy") * u**4 + LOWER)  # fmt: skip
EQ9 = W**2 - 4 * tan**2 * (u**2 + v**2)
EQ25 = (F("xx") - F("yy")) * u * v + F("xy") * (v**2 - u**2)
UT, VT = 2 * x * W - 4 * u * tan**2, 2 * y * W - 4 * v * tan**2  # Eq. 15, corrected


def eq14(ut, vt):
    """Return Eq. 14 with the derivatives (15) of (9) put in."""
    return (F("xxx") * v**2 * ut + F("xxy") * v * (v * vt - 2 * u * ut)
            + F("xyy") * u * (u * ut - 2 * v * vt) + F("yyy") * u**2 * vt
            + (F("xx") - F("yy")) * (u * ut - v * vt)
            + 2 * F("xy") * (u * vt + v * ut))  # fmt: skip


def example(a, b):
    return b**2 / (a**2 + b**2)


def values(jet):
    """Return a jet's derivatives at its one point, for substitution into the symbols."""
    return {s: float(np.ravel(jet.derivative(*order))[0]) for order, s in NAMES.items()}


def at(expression, jet, **more):
    """Return an expression's value, or values, by a jet and by numbers or arrays for x, y, ..."""
    given = {s: jet.derivative(*order) for order, s in NAMES.items()}
    given |= {sp.Symbol(name, real=True): value for name, value in more.items()}
    return np.squeeze(sp.lambdify(list(given), expression)(*given.values()))[()]


def general_jet(surface, s, t):
    """Return x, y and f's jet in the model's own frame, at one point of a surface in space."""
    px, py, jet = model_jet(surface, np.array([s]), np.array([t]))
    return float(px[0]), float(py[0]), jet


def circle_centre(points):
    """Return the centre of the circle through the top views of three points."""
    points = np.asarray(points)[:, :2]
    square = (points**2).sum(axis=1)
    return np.linalg.solve(2 * (points[1:3] - points[0]), square[1:3] - square[0])


def intrinsic_radius(points):
    """Return the radius on the unit sphere of the circle over which planes' points lie."""
    n = np.stack(normal(points[:, 0], points[:, 1]), axis=-1)
    pole = np.cross(n[1] - n[0], n[2] - n[0])
    angle = np.arccos(np.clip(n @ pole / np.linalg.norm(pole), -1, 1))
    assert np.ptp(angle) < 1e-9
    return min(angle[0], np.pi - angle[0])


def cone_points(vertex, axis, half_angle, n=9):
    return plane_to_point(*cone_planes(vertex, axis, half_angle, 2 * np.pi * np.arange(n) / n))


def conic_of(cones, k, n=9):
    """Return points of the planes of a found cone, and the centre of the circle below them."""
    points = cone_points(cones.vertex[k], cones.side[k] * cones.axis[k], cones.half_angle, n)
    return points, circle_centre(points)


CUBIC = F("xxx") * u**3 + 3 * F("xxy") * u**2 * v + 3 * F("xyy") * u * v**2 + F("yyy") * v**3
EQ10 = (F("x") * v - F("y") * u, F("x") * u + F("y") * v
        + F("xx") * v**2 - 2 * F("xy") * u * v + F("yy") * u**2)  # fmt: skip
EQ13 = p * ((t**2 - 1) ** 3 * F("xxx") - 6 * (t**2 - 1) ** 2 * t * F("xxy")
            + 12 * (t**2 - 1) * t**2 * F("xyy") - 8 * t**3 * F("yyy"))  # fmt: skip
EQ13 += (6 * (2 * (t**3 - t) * (F("xx") - F("yy")) + (t**4 - 6 * t**2 + 1) * F("xy"))
         * (t**2 * tan - t**2 * y - 2 * t * x + y + tan))  # fmt: skip
# Example 31 in polynomials: Eq. 11 is three linear forms over a power of x^2 + y^2.
EX31 = y**2 / (x**2 + y**2)


def eq22(z, a, b):
    """Return Eq. 22 as printed."""
    square, more, less = u**2 + v**2, a * v + b * u, b * v - a * u
    vertex = [
        (x**2 - y**2 - 1) * more + 2 * x * y * less - 2 * square * (u * z + x * z + a * y),
        (y**2 - x**2 - 1) * less + 2 * x * y * more - 2 * square * (v * z + y * z - a * x),
        2 * x * more + 2 * y * less - 2 * square * z,
    ]
    return [part / square / W for part in vertex]
