"""All cones in contact of order 3 with a surface at a point, of numbers or arrays, and loops.

The loops go from point to point and can be compiled (`compiled.call`); with arrays the formulas
take all points at once, with the same bits.
"""

from ..kernels.compiled import root
from ..kernels.elementwise import where
from .cone_directions import circle_zeros
from .graph_forms import model_forms, space_forms

VANISHES = 1e-12  # of its terms, below which the form of contact is 0 in every direction
SHAPE = 26  # numbers that `shape_in_space` returns


def shape_in_space(x, y, z):
    """Return a point of a surface, its frame and its forms.

    Parameters
    ----------
    x, y, z : sequences of 15 (...) float
        The Taylor coefficients of its coordinates, in the order of `Jet`, in m.

    Returns
    -------
    shape : tuple of 26 (...) float
        The contact, in m; two unit tangents and the normal; the sine of the angle between the
        tangents along the variables; |K|/|II|^2; and the coefficients of the graph's forms of
        degree 2, 3 and 4, in m.
    """
    frame, known, curvature, forms = space_forms(x, y, z)
    return _in_a_row((x[0], y[0], z[0]), frame, known, curvature, forms)


def shape_in_the_model(x, y, f):
    """Return what `shape_in_space` does, of a graph in the isotropic model.

    Parameters
    ----------
    x, y : (...) float
        The place in the model.
    f : sequence of 15 (...) float
        The graph's Taylor coefficients, in the order of `Jet`, in m.
    """
    contact, frame, curvature, forms = model_forms(x, y, f)
    return _in_a_row(contact, frame, 1.0, curvature, forms)


def _in_a_row(contact, frame, known, curvature, forms):
    first, second, third = frame
    f2, f3, f4 = forms
    return (*contact, *first, *second, *third, known, curvature, *f2, *f3, *f4)


def cones_of(shape, rho):
    """Return the cones at a point.

    Parameters
    ----------
    shape : sequence of 26 (...) float
        As of `shape_in_space`.
    rho : float
        cot(half_angle)/2.

    Returns
    -------
    cones : tuple of six tuples of five (...) float
        For each direction e of a cone its two components along the tangents; how many cones fall
        together there, 0 where there is none; f_ee, in m; and the residual of Eq. 12, -1 to 1.
    """
    f2 = (shape[14], shape[15], shape[16])
    f3 = (shape[17], shape[18], shape[19], shape[20])
    f4 = (shape[21], shape[22], shape[23], shape[24], shape[25])
    cubic = (6 * rho * f3[0], 6 * rho * f3[1], 6 * rho * f3[2], 6 * rho * f3[3])
    across = (3 * f2[1], 6 * (f2[2] - f2[0]), -3 * f2[1])  # 3 f_ew
    three = rho * _norm3(f3)
    two = 3 * norm2(f2)
    directions, multiplicity, greatest = circle_zeros(cubic, across)
    vanishes = greatest <= VANISHES * (three + two)
    # All terms of Eq. 12 may vanish together: then what rounding leaves is compared with a
    # thousandth of the forms as a whole.
    floor = 1e-3 * (rho * rho * _norm4(f4) + 6 * three + two)
    forms = (f2, f3, f4)
    return (
        _cone(forms, rho, floor, directions[0], where(vanishes, 0.0, multiplicity[0])),
        _cone(forms, rho, floor, directions[1], where(vanishes, 0.0, multiplicity[1])),
        _cone(forms, rho, floor, directions[2], where(vanishes, 0.0, multiplicity[2])),
        _cone(forms, rho, floor, directions[3], where(vanishes, 0.0, multiplicity[3])),
        _cone(forms, rho, floor, directions[4], where(vanishes, 0.0, multiplicity[4])),
        _cone(forms, rho, floor, directions[5], where(vanishes, 0.0, multiplicity[5])),
    )


def fill_space(x, y, z, shapes):
    """Fill rows with what `shape_in_space` returns of points.

    Parameters
    ----------
    x, y, z : (n, 15) float
        The Taylor coefficients, in m.
    shapes : (n, 26) float
        To be filled.
    """
    for i in range(len(shapes)):
        shapes[i][:] = shape_in_space(x[i], y[i], z[i])


def fill_model(x, y, f, shapes):
    """Fill rows with what `shape_in_the_model` returns of points.

    Parameters
    ----------
    x, y : (n,) float
        Places of the model.
    f : (n, 15) float
        The graph's Taylor coefficients, in m.
    shapes : (n, 26) float
        To be filled.
    """
    for i in range(len(shapes)):
        shapes[i][:] = shape_in_the_model(x[i], y[i], f[i])


def fill_cones(shapes, rho, cones):
    """Fill rows with what `cones_of` returns of points.

    Parameters
    ----------
    shapes : (n, 26) float
        As of `shape_in_space`.
    rho : float
        cot(half_angle)/2.
    cones : (n, 6, 5) float
        To be filled.
    """
    for i in range(len(shapes)):
        found = cones_of(shapes[i], rho)
        for j in range(6):
            for k in range(5):
                cones[i][j][k] = found[j][k]


def _cone(forms, rho, floor, direction, multiplicity):
    c, s = direction
    fee, residual = order_four_along(forms, rho, floor, c, s)
    return c, s, multiplicity, fee, residual


def order_four_along(forms, rho, floor, c, s):
    """Return f_ee and the residual of Eq. 12 over the sum of its terms, for e = (c, s).

    Parameters
    ----------
    forms : tuple of three forms
        Of degree 2 to 4, in m.
    rho, floor : (...) float
        cot(half_angle)/2, and the least that the sum of the terms is counted as.
    c, s : (...) float
        The direction.
    """
    f2, f3, f4 = forms
    fee = 2 * ((f2[0] * c + f2[1] * s) * c + f2[2] * s * s)
    fww = 2 * ((f2[0] * s - f2[1] * c) * s + f2[2] * c * c)
    # Along w = (-s, c) the form of degree 3 changes by its gradient.
    by_c = (3 * f3[0] * c + 2 * f3[1] * s) * c + f3[2] * s * s
    by_s = (f3[1] * c + 2 * f3[2] * s) * c + 3 * f3[3] * s * s
    feew = 2 * (c * by_s - s * by_c)
    feeee = 24 * (
        (((f4[0] * c + f4[1] * s) * c + f4[2] * s * s) * c + f4[3] * s * s * s) * c
        + f4[4] * s * s * s * s
    )
    four = rho * rho * feeee
    three = 6 * rho * feew
    two = 3 * (fww - fee)
    total = abs(four) + abs(three) + abs(two)
    total = where(total > floor, total, floor)
    return fee, (four + three + two) / (total + (total == 0))


def norm2(f2):
    """Return the Frobenius norm of second derivatives."""
    return root(4 * f2[0] * f2[0] + 2 * f2[1] * f2[1] + 4 * f2[2] * f2[2])


def _norm3(f3):
    """Return the Frobenius norm of third derivatives."""
    ends = 36 * (f3[0] * f3[0] + f3[3] * f3[3])
    return root(ends + 12 * (f3[1] * f3[1] + f3[2] * f3[2]))


def _norm4(f4):
    """Return the Frobenius norm of fourth derivatives."""
    ends = 576 * (f4[0] * f4[0] + f4[4] * f4[4])
    return root(ends + 144 * (f4[1] * f4[1] + f4[3] * f4[3]) + 96 * f4[2] * f4[2])
