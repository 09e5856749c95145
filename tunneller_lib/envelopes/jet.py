"""Truncated Taylor series in two variables, at many points at once, and their directions.

A function built from ordinary arithmetic and numpy's elementary functions, called with two `Jet`
arguments, returns its Taylor polynomial: all derivatives to order 4 or 5, without differences.
The last part has derivatives along directions that turn: binary forms in the direction.
"""

from functools import cached_property
from itertools import pairwise, product
from math import comb, factorial

import numpy as np

from ..arguments import Reals, Whole, checked

ORDER = 4
HIGHEST = 5
# Exponents (i, j) of h^i k^j, by degree: 1, h, k, h^2, hk, k^2, ..., k^5.
_ALL = tuple((d - j, j) for d in range(HIGHEST + 1) for j in range(d + 1))
_PLACE = {exponents: place for place, exponents in enumerate(_ALL)}
_COUNT = {order: (order + 1) * (order + 2) // 2 for order in range(HIGHEST + 1)}
_ORDER = {count: order for order, count in _COUNT.items()}
_MANY = 300  # points; from here on it is faster to multiply one pair of rows after another


def exponents(order):
    """Return the exponents (i, j) of h^i k^j, in the order of a jet's coefficients."""
    return _ALL[: _COUNT[order]]


def _pairs(order):
    """Return which pairs of coefficients make those of a product, and where each one's begin."""
    # A product's coefficient of one place is the sum over all pairs whose exponents add up to it.
    every = exponents(order)
    pairs = sorted(
        (_PLACE[i + k, j + m], _PLACE[i, j], _PLACE[k, m])
        for (i, j), (k, m) in product(every, every)
        if i + j + k + m <= order
    )
    target, left, right = np.array(pairs).T
    return left, right, np.searchsorted(target, np.arange(len(every)))


def _above(order):
    """Return which coefficients make a derivative's by h, and by k, and times which exponents."""
    by_h = [(i + 1, j) for i, j in exponents(order - 1)]
    by_k = [(i, j + 1) for i, j in exponents(order - 1)]
    factors = [np.array([pair[axis] for pair in way]) for axis, way in enumerate((by_h, by_k))]
    return [([_PLACE[p] for p in way], f) for way, f in zip((by_h, by_k), factors, strict=True)]


_PAIRS = {count: _pairs(order) for order, count in _COUNT.items()}
_ABOVE = {count: _above(order) for count, order in _ORDER.items() if order}


class Jet(np.lib.mixins.NDArrayOperatorsMixin):
    """The Taylor polynomial of a function of two variables, at an array of points.

    Parameters
    ----------
    c : (1, 3, 6, 10, 15 or 21, ...) float
        Coefficients of h^i k^j by degree, those of k highest last, to an order from 0 to 5; one
        polynomial a point.

    Notes
    -----
    Jets go with numbers, with arrays of one value a point, with + - * / ** and with the numpy
    functions of `_FUNCTIONS`. Of two jets the lower order is that of the result. Where a function
    isn't smooth the coefficients are NaN or infinite.

    Examples
    --------
    >>> x, y = jet_variables(2.0, 3.0)
    >>> (x**2 * y).derivative(1, 1)
    np.float64(4.0)
    """

    def __init__(self, c):
        self.c = c

    @property
    def shape(self):
        """Return the shape of the array of points."""
        return self.c.shape[1:]

    @property
    def value(self):
        """Return the function's values (...), the coefficients of order 0."""
        return self.c[0]

    @property
    def order(self):
        """Return the polynomial's order."""
        return _ORDER[len(self.c)]

    @cached_property
    def reciprocal(self):
        """Return 1 over the jet, kept for the next division by it."""
        return series(self, _reciprocal(self.value))

    @checked
    def derivative(self, i: Whole(0, HIGHEST), j: Whole(0, HIGHEST)):
        """Return a derivative's values.

        Parameters
        ----------
        i, j : int
            How often by the first and by the second variable, together at most the order.

        Returns
        -------
        values : (...) float
            One a point.
        """
        if i + j > self.order:
            raise ValueError(f"i, j: must be at most {self.order} together; got {i} and {j}.")
        return derivative(self, i, j)

    def __array_ufunc__(self, ufunc, method, *arguments, **options):
        function = _FUNCTIONS.get(ufunc)
        if function is None or method != "__call__" or options:
            name = ufunc.__name__ if method == "__call__" else f"{ufunc.__name__}.{method}"
            given = "".join(f" with {option}=" for option in options)  # out= for array += jet
            raise ValueError(
                f"surface: must be built from + - * / ** and {', '.join(_names())}; "
                f"got {name}{given}."
            )
        with np.errstate(all="ignore"):
            return function(*arguments)

    # A jet is a value: `jet += 1` makes another one, since a caller may still hold the first.
    __iadd__ = np.lib.mixins.NDArrayOperatorsMixin.__add__
    __isub__ = np.lib.mixins.NDArrayOperatorsMixin.__sub__
    __imul__ = np.lib.mixins.NDArrayOperatorsMixin.__mul__
    __itruediv__ = np.lib.mixins.NDArrayOperatorsMixin.__truediv__
    __ipow__ = np.lib.mixins.NDArrayOperatorsMixin.__pow__


def derivative(f, i, j):
    """Return the values of a derivative as `Jet.derivative` does, unchecked, for inner loops."""
    return factorial(i) * factorial(j) * f.c[_PLACE[i, j]]


def differentiated(f, axis):
    """Return the jet of a derivative by the first (0) or second (1) variable, an order lower."""
    rows, factors = _ABOVE[len(f.c)][axis]
    return Jet((factors * f.c[rows].T).T)


@checked
def jet_variables(s: Reals, t: Reals, *, order: Whole(ORDER, HIGHEST) = ORDER):
    """Return the two variables (h + s, k + t) as jets at points.

    Parameters
    ----------
    s, t : (...) float
        The points.
    order : int
        Of the jets, 4 or 5.

    Returns
    -------
    s, t : Jet
        At points of the common shape.

    Examples
    --------
    >>> x, y = jet_variables(0.3, [1.0, 2.0])
    >>> np.exp(x * y).derivative(1, 0).round(3)
    array([1.35 , 3.644])
    """
    s, t = np.broadcast_arrays(s, t)
    jets = []
    for place, value in ((1, s), (2, t)):
        c = np.zeros((_COUNT[order], *value.shape))
        c[0], c[place] = value, 1.0
        jets.append(Jet(c))
    return tuple(jets)


def by_slopes(x, y, fx, fy):
    """Return a function's jet in two other variables, by its slopes in them.

    Parameters
    ----------
    x, y : Jet
        The other variables, as functions of the jets' own.
    fx, fy : Jet
        The derivatives of the function by x and by y, as functions of the jets' own variables.

    Returns
    -------
    f : Jet
        In powers of (x - x0) and (y - y0), of value 0 and one order more than the slopes; not
        finite where the Jacobian of x and y vanishes.
    """
    with np.errstate(all="ignore"):
        (xh, xk), (yh, yk) = ((differentiated(c, 0), differentiated(c, 1)) for c in (x, y))
        # The chain rule: d/dx = h_x d/dh + k_x d/dk, by the inverse of the Jacobian.
        over = (xh * yk - xk * yh).reciprocal
        by_x = yk * over, -yh * over
        by_y = -xk * over, xh * over
        row = [fx, fy]  # all derivatives of one degree, the last one by y alone
        c = [np.zeros_like(fx.value)]
        for degree in range(1, HIGHEST + 1):
            c += [d.value / (factorial(degree - j) * factorial(j)) for j, d in enumerate(row)]
            if min(one.order for one in row) == 0:
                break
            last = row[-1]
            row = [_along(one, by_x) for one in row] + [_along(last, by_y)]
    return Jet(np.array(c))


def _along(f, way):
    """Return the derivative of a jet in a direction whose components are jets as well."""
    return way[0] * differentiated(f, 0) + way[1] * differentiated(f, 1)


def _constant(value, like):
    """Return a number, or an array of one a point, as a jet of the order of another."""
    points = np.broadcast_shapes(np.shape(value), like.c.shape[1:])
    c = np.zeros((len(like.c), *points))
    c[0] = value
    return Jet(c)


def _both(a, b):
    """Return two operands, at least one a jet, as jets of one order at points of as many axes."""
    a = a if isinstance(a, Jet) else _constant(a, b)
    b = b if isinstance(b, Jet) else _constant(b, a)
    count = min(len(a.c), len(b.c))
    ndim = max(a.c.ndim, b.c.ndim) - 1
    return Jet(_widened(a.c[:count], ndim)), Jet(_widened(b.c[:count], ndim))


def _widened(c, ndim):
    """Return coefficients with axes put in until they are of points of `ndim` axes or more.

    Points broadcast as arrays do, by their last axes; the axis of coefficients stays the first.
    """
    missing = ndim + 1 - c.ndim
    return c.reshape(c.shape[0], *[1] * missing, *c.shape[1:]) if missing > 0 else c


def _add(a, b):
    a, b = _both(a, b)
    return Jet(a.c + b.c)


def _subtract(a, b):
    return _add(a, Jet(-b.c) if isinstance(b, Jet) else -b)


def _multiply(a, b):
    """Return a product, of two jets by Cauchy's rule to the lower of their orders."""
    if not isinstance(b, Jet):
        return Jet(_widened(a.c, np.ndim(b)) * b)
    if not isinstance(a, Jet):
        return Jet(a * _widened(b.c, np.ndim(a)))
    if a.c.ndim != b.c.ndim or len(a.c) != len(b.c):
        a, b = _both(a, b)
    left, right, starts = _PAIRS[len(a.c)]
    if max(a.c[0].size, b.c[0].size) < _MANY:
        # All pairs at once: with few points the time goes into calls, not into numbers.
        pairs = a.c.take(left, axis=0) * b.c.take(right, axis=0)
        return Jet(np.add.reduceat(pairs, starts, axis=0))
    c = np.empty(np.broadcast_shapes(a.c.shape, b.c.shape))
    term = np.empty_like(c[0])
    for row, start, stop in zip(c, starts, [*starts[1:], len(left)], strict=True):
        np.multiply(a.c[left[start]], b.c[right[start]], out=row)
        for first, second in zip(left[start + 1 : stop], right[start + 1 : stop], strict=True):
            row += np.multiply(a.c[first], b.c[second], out=term)
    return Jet(c)


def _divide(a, b):
    if isinstance(b, Jet):
        return _multiply(a, b.reciprocal)
    return Jet(_widened(a.c, np.ndim(b)) / b)


def _power(a, p):
    """Return a power whose base or exponent is a jet, or both."""
    if isinstance(p, Jet):
        return np.exp(p * np.log(a))
    if np.ndim(p) == 0 and 0 <= p == int(p):  # whole powers are smooth at zero, too
        result = _constant(1.0, a)
        for bit in bin(int(p))[2:]:
            result = _multiply(result, result)
            result = _multiply(result, a) if bit == "1" else result
        return result
    # The Taylor coefficients of x^p are those of the binomial series, times x^(p - k).
    binomial = [1.0]
    for k in range(HIGHEST):
        binomial.append(binomial[-1] * (p - k) / (k + 1))
    return series(a, [b * a.value ** (p - k) for k, b in enumerate(binomial)])


def series(a, coefficients):
    """Return the sum of coefficients[n] (a - a0)^n to the order of the jet a, by Horner's rule."""
    coefficients = coefficients[: a.order + 1]
    step = Jet(a.c.copy())
    step.c[0] = 0.0
    result = Jet(step.c * coefficients[-1])
    for coefficient in coefficients[-2:0:-1]:
        result.c[0] += coefficient
        result = _multiply(result, step)
    result.c[0] += coefficients[0]
    return result


# ---- Taylor coefficients of functions of one variable, to order 5 ---------------------------


def _reciprocal(x):
    return [(-1) ** n / x ** (n + 1) for n in range(HIGHEST + 1)]


def _log(x):
    return [np.log(x), *((-1) ** (n - 1) / (n * x**n) for n in range(1, HIGHEST + 1))]


def _arctan(x):
    c = 1 / (1 + x * x)
    last = (x**4 - 2 * x * x + 1 / 5) * c**5
    return [np.arctan(x), c, -x * c**2, (x * x - 1 / 3) * c**3, (x - x**3) * c**4, last]


def _repeated(*derivatives):
    """Return the Taylor coefficients of a function whose derivatives repeat in a cycle."""
    return [derivatives[n % len(derivatives)] / factorial(n) for n in range(HIGHEST + 1)]


_FUNCTIONS = {
    np.add: _add,
    np.subtract: _subtract,
    np.multiply: _multiply,
    np.divide: _divide,
    np.power: _power,
    np.negative: lambda a: Jet(-a.c),
    np.positive: lambda a: a,
    np.square: lambda a: _multiply(a, a),
    np.sqrt: lambda a: _power(a, 0.5),
    np.hypot: lambda a, b: np.sqrt(a * a + b * b),
    np.reciprocal: lambda a: a.reciprocal,
    np.log: lambda a: series(a, _log(a.value)),
    np.exp: lambda a: series(a, _repeated(np.exp(a.value))),
    np.sin: lambda a: series(a, _repeated(*_turns(a.value))),
    np.cos: lambda a: series(a, _repeated(*_turns(a.value)[1:], np.sin(a.value))),
    np.arctan: lambda a: series(a, _arctan(a.value)),
}


def _turns(x):
    """Return the sine and its first three derivatives."""
    return np.sin(x), np.cos(x), -np.sin(x), -np.cos(x)


def _names():
    """Return the names of the functions that jets go with, operators left out."""
    operators = {"add", "subtract", "multiply", "divide", "power", "negative", "positive"}
    return sorted({f.__name__ for f in _FUNCTIONS} - operators)


# ---- derivatives along directions that turn ------------------------------------------------------


def derivative_along(f, angle, e, w=0):
    """Return a jet's derivatives `e` times along e, `w` times along w, at direction angles.

    Parameters
    ----------
    f : Jet
        At n points.
    angle : (n or 1, m) float
        Angles of e = (cos, sin), in rad; w = (-sin, cos) is e turned by a right angle.
    e, w : int
        How often by each; together at most the order of the jet.

    Returns
    -------
    derivative : (n, m) float
        A binary form in e of degree e + w.
    """
    c, s = np.cos(angle), np.sin(angle)
    degree = e + w
    form = [derivative(f, degree - k, k)[:, None] for k in range(degree + 1)]
    # Each way takes one index of the symmetric tensor of derivatives: a degree less is left.
    for x, y in [(c, s)] * e + [(-s, c)] * w:
        form = [x * first + y * second for first, second in pairwise(form)]
    return form[0]


def frobenius(f, degree):
    """Return the Frobenius norms (n,) of a jet's tensors of derivatives of one degree."""
    form = [derivative(f, degree - k, k) for k in range(degree + 1)]
    # As often as a derivative is an entry of the tensor: binomial coefficients.
    weights = np.cumprod([1.0, *((degree - k) / (k + 1) for k in range(degree))])
    return np.sqrt(sum(weight * entry**2 for weight, entry in zip(weights, form, strict=True)))


def frobenius_along(f, angle, width, degree):
    """Return Frobenius norms (n, m) of derivatives by e and by w as long as a width.

    Parameters
    ----------
    f, angle
        As for `derivative_along`.
    width : (n, m) float
        The length of w; with 1 the norm is `frobenius`.
    degree : int
        Of the derivatives, at most the order of the jet.

    Returns
    -------
    norm : (n, m) float
        In the unit of the derivatives.
    """
    terms = (
        comb(degree, k) * (width**k * derivative_along(f, angle, degree - k, k)) ** 2
        for k in range(degree + 1)
    )
    return np.sqrt(sum(terms))


def principal(f):
    """Return a Hessian's eigenvalues (n,), low and high, and the low one's direction, 0 to pi."""
    a = derivative(f, 2, 0)
    b = derivative(f, 1, 1)
    c = derivative(f, 0, 2)
    mean = (a + c) / 2
    half = np.hypot((a - c) / 2, b)
    # Half of arctan2(2 b, a - c) is the direction of the high one.
    return mean - half, mean + half, np.arctan2(2 * b, a - c) / 2 + np.pi / 2


def principal_values(f):
    """Return the Hessian's eigenvalues (n, 2), the low one first."""
    return np.stack(principal(f)[:2], axis=-1)


# ---- vectors as lists of three coordinates, each a number, an array or a jet ---------------------


def cross_product(a, b):
    """Return the vector product of two vectors."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def dot_product(a, b):
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(first, *others):
    """Return the sum of vectors, the first and the others."""
    for other in others:
        first = [a + b for a, b in zip(first, other, strict=True)]
    return first


def times(c, a):
    """Return the multiple c of a vector a."""
    return [c * part for part in a]


def unit_vector(a):
    """Return a vector a, scaled to length 1."""
    return times(1 / np.sqrt(dot_product(a, a)), a)
