"""A surface's graph in the isotropic model, seen from its own points: numbers or arrays.

The graph is given by its forms (`binary_forms`) in the adapted frame. `adapted` finds the same by
jets, to any order and for `recognise`; here nothing but sums, products, quotients and roots is
used, coefficient by coefficient, so that one point goes the same way as thousands, and so do
compiled loops.
"""

from ..kernels.compiled import root
from ..kernels.elementwise import ratio, where
from .binary_forms import (
    plus12,
    plus13,
    plus22,
    product11,
    replaced2,
    replaced3,
    replaced4,
    sum2,
    sum3,
)

NOISE = 1e-12  # of what second derivatives are made from, below which they are none


def normal(x, y):
    """Return the components of the unit normal of the planes over a place (Eq. 21)."""
    p = x * x + y * y + 1
    return 2 * x / p, 2 * y / p, 2 / p - 1


def contact_point(x, y, f, fx, fy):
    """Return the point where the plane over (x, y) touches the surface of f (Eq. 20).

    `f`, `fx`, `fy` are the function and its derivatives there; all lengths are in m.
    """
    p = x * x + y * y + 1
    # The third coordinate as printed; r1 and r2 by Eqs 18 and 19, which take fewer products.
    r3 = 2 * (x * fx + y * fy - f) / p
    return x * r3 - fx, y * r3 - fy, r3


def isotropic_derivatives(r, n):
    """Return x, y, f, fx, fy by points of a surface and unit normals there (Eqs 17 to 19)."""
    below = n[2] + 1
    x, y = n[0] / below, n[1] / below
    f = -(n[0] * r[0] + n[1] * r[1] + n[2] * r[2]) / below
    return x, y, f, x * r[2] - r[0], y * r[2] - r[1]


def space_forms(x, y, z):
    """Return the frame of a surface at a point, and the forms of its graph there.

    Parameters
    ----------
    x, y, z : sequences of 15 (...) float
        The Taylor coefficients of its coordinates, in the order of `Jet`, in m.

    Returns
    -------
    frame : tuple
        Three vectors: two unit tangents and the unit normal.
    known : (...) float
        The sine of the angle between the tangents along the two variables.
    curvature : (...) float
        |K|/|II|^2.
    forms : tuple of three forms
        Of degree 2, 3 and 4, in m.
    """
    h = (x[1], y[1], z[1])
    k = (x[2], y[2], z[2])
    across = _cross(h, k)
    area = _length(across)
    length = _length(h)
    first = _over(h, length)
    third = _over(across, area)
    second = _cross(third, first)
    near = _turned(first, x, y, z)
    beside = _turned(second, x, y, z)
    _, up2, up3 = _turned(third, x, y, z)
    up = (up2, up3, _turned4(third, x, y, z))
    g = regraphed(near, beside, up)
    curvature = _curvature(g[0], _size(up2), _size(near[1]) + _size(beside[1]))
    return (first, second, third), ratio(area, length * _length(k)), curvature, _of_planes(g)


def model_forms(x, y, f):
    """Return contact and frame of the planes over places of the model, and the forms there.

    Parameters
    ----------
    x, y : (...) float
        The places.
    f : sequence of 15 (...) float
        The Taylor coefficients of the graph, in the order of `Jet`, in m.

    Returns
    -------
    contact : tuple of three (...) float
        The point of the surface, in m.
    frame : tuple
        Three vectors: two unit tangents and the unit normal.
    curvature : (...) float
        |K|/|II|^2.
    forms : tuple of three forms
        Of degree 2, 3 and 4, in m.

    Notes
    -----
    The planes through the contact are a paraboloid (Eq. 7 with R = 0), which is taken away: no
    value and no slope is left. The turn of space that brings the normal over c = x + i y up takes
    c + d to d/(p + d conj(c)), where p = 1 + |c|^2, and divides heights by |p + d conj(c)|^2/p.
    """
    p = x * x + y * y + 1
    contact = contact_point(x, y, f[0], f[1], f[2])
    third = normal(x, y)
    first = (1 - x * third[0], -x * third[1], -third[0])
    second = (-y * third[0], 1 - y * third[1], -third[1])
    half = contact[2] / 2
    bend = (f[3] - half, f[4], f[5] - half)
    made_from = _size((f[3], f[4], f[5])) + abs(half) + _size(bend)
    # |p + d conj(c)|^2/p^2 = 1 + 2 l + l^2 + m^2, where (l + i m) p = d conj(c).
    less = (-2 * x / p, -2 * y / p)
    square = (1 - p) / (p * p)
    z2 = (bend[0] / p, bend[1] / p, bend[2] / p)
    z3 = plus12((f[6] / p, f[7] / p, f[8] / p, f[9] / p), less, z2)
    z4 = (f[10] / p, f[11] / p, f[12] / p, f[13] / p, f[14] / p)
    z4 = plus22(plus13(z4, less, z3), (square, 0.0 * square, square), z2)
    # d/(p + d conj(c)) = d/p - d^2 conj(c)/p^2 + d^3 conj(c)^2/p^3.
    one = 1 / p
    none = 0.0 * one
    a, b = x * one * one, y * one * one
    c, d = (x * x - y * y) * one * one * one, 2 * x * y * one * one * one
    near = (one, none), (-a, -2 * b, a), (c, 3 * d, -3 * c, -d)
    beside = (none, one), (b, -2 * a, -b), (-d, 3 * c, 3 * d, -c)
    forms = regraphed(near, beside, (z2, z3, z4))
    made_from = made_from + _size(z3)
    return contact, (first, second, third), _curvature(bend, _size(bend), made_from), forms


def regraphed(x, y, z):
    """Return the forms of degree 2 to 4 of the function g for which z = g(x, y).

    Parameters
    ----------
    x, y : tuples of three forms
        Of degree 1 to 3: functions of two variables.
    z : tuple of three forms
        Of degree 2 to 4, of the same variables.

    Returns
    -------
    g : tuple of three forms
        Of degree 2 to 4.
    """
    (x1, x2, x3), (y1, y2, y3) = x, y
    inverse = ratio(1.0, x1[0] * y1[1] - x1[1] * y1[0])
    h = (y1[1] * inverse, -x1[1] * inverse)  # the linear part undone
    k = (-y1[0] * inverse, x1[0] * inverse)
    # What bends, in the variables and with the other sign: degree by degree it's taken from z.
    a2, b2 = sum2(-h[0], x2, -h[1], y2), sum2(-k[0], x2, -k[1], y2)
    a3, b3 = sum3(-h[0], x3, -h[1], y3), sum3(-k[0], x3, -k[1], y3)
    z2, z3, z4 = z
    by_h = (2 * z2[0], z2[1])
    by_k = (z2[1], 2 * z2[2])
    z3 = plus12(plus12(z3, by_h, a2), by_k, b2)
    z4 = plus13(plus13(z4, by_h, a3), by_k, b3)
    # The form of degree 2 of what bends is halved between the two products.
    by_h = sum2(-z2[0], a2, -z2[1] / 2, b2)
    by_k = sum2(-z2[1] / 2, a2, -z2[2], b2)
    by_h = (3 * z3[0] + by_h[0], 2 * z3[1] + by_h[1], z3[2] + by_h[2])
    by_k = (z3[1] + by_k[0], 2 * z3[2] + by_k[1], 3 * z3[3] + by_k[2])
    z4 = plus22(plus22(z4, by_h, a2), by_k, b2)
    # And the variables by x and y.
    squares = (product11(h, h), product11(h, k), product11(k, k))
    g2 = replaced2(z2, squares)
    g3 = replaced3(z3, h, k, squares)
    return g2, g3, replaced4(z4, squares)


def _of_planes(g):
    """Return the forms in the model of the tangent planes of a graph z = g(x, y) over one of them.

    Over (x, y) lies the plane with the place -grad g/(1 + s) and the height (x g_x + y g_y - g)
    /(1 + s), where s^2 = 1 + |grad g|^2 (Eqs 17 to 19).
    """
    g2, g3, g4 = g
    x1 = (-g2[0], -g2[1] / 2)
    y1 = (-g2[1] / 2, -g2[2])
    x2 = (-3 * g3[0] / 2, -g3[1], -g3[2] / 2)
    y2 = (-g3[1] / 2, -g3[2], -3 * g3[3] / 2)
    xx, yy = product11(x1, x1), product11(y1, y1)
    # 1/(1 + s) is 1/2 less an eighth of the gradient's square: half of these squares' sum.
    less = (-xx[0] - yy[0], -xx[1] - yy[1], -xx[2] - yy[2])
    x3 = plus12((-2 * g4[0], -3 * g4[1] / 2, -g4[2], -g4[3] / 2), x1, less)
    y3 = plus12((-g4[1] / 2, -g4[2], -3 * g4[3] / 2, -2 * g4[4]), y1, less)
    z2 = (g2[0] / 2, g2[1] / 2, g2[2] / 2)
    z4 = (1.5 * g4[0], 1.5 * g4[1], 1.5 * g4[2], 1.5 * g4[3], 1.5 * g4[4])
    return regraphed((x1, x2, x3), (y1, y2, y3), (z2, g3, plus22(z4, z2, less)))


def _curvature(form, size, made_from):
    """Return |K|/|II|^2 by a form of degree 2, none if its size is rounding of what it's from."""
    determinant = 4 * form[0] * form[2] - form[1] * form[1]
    square = 4 * form[0] * form[0] + 2 * form[1] * form[1] + 4 * form[2] * form[2]
    none = (size <= NOISE * made_from) | (square == 0)
    return where(none, 0.0, abs(ratio(determinant, square)))


def _size(form):
    return abs(form[0]) + abs(form[1]) + abs(form[2])


# ---- vectors -----------------------------------------------------------------------------------


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _length(a):
    return root(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def _over(a, length):
    inverse = ratio(1.0, length)
    return (a[0] * inverse, a[1] * inverse, a[2] * inverse)


def _turned(axis, x, y, z):
    """Return the forms, of degree 1 to 3, of a surface's coordinate along an axis."""
    return (
        (_along(axis, x, y, z, 1), _along(axis, x, y, z, 2)),
        (_along(axis, x, y, z, 3), _along(axis, x, y, z, 4), _along(axis, x, y, z, 5)),
        (
            _along(axis, x, y, z, 6),
            _along(axis, x, y, z, 7),
            _along(axis, x, y, z, 8),
            _along(axis, x, y, z, 9),
        ),
    )


def _turned4(axis, x, y, z):
    """Return the form of degree 4 of a surface's coordinate along an axis."""
    return (
        _along(axis, x, y, z, 10),
        _along(axis, x, y, z, 11),
        _along(axis, x, y, z, 12),
        _along(axis, x, y, z, 13),
        _along(axis, x, y, z, 14),
    )


def _along(axis, x, y, z, i):
    return axis[0] * x[i] + axis[1] * y[i] + axis[2] * z[i]
