"""Truncated Taylor series of order 4 or 5 in two variables, at many points at once.

A function built from ordinary arithmetic and numpy's elementary functions, called with two `Jet`
arguments, returns its Taylor polynomial: all derivatives to that order, without differences.
"""

from functools import cached_property
from itertools import product
from math import factorial

import numpy as np

from ..arguments import Reals, Whole, checked

ORDER = 4
HIGHEST = 5
# Exponents (i, j) of h^i k^j, by degree: 1, h, k, h^2, hk, k^2, ..., k^5.
_ALL = tuple((d - j, j) for d in range(HIGHEST + 1) for j in range(d + 1))
_PLACE = {exponents: place for place, exponents in enumerate(_ALL)}
_COUNT = {order: (order + 1) * (order + 2) // 2 for order in (ORDER, HIGHEST)}
_ORDER = {count: order for order, count in _COUNT.items()}
EXPONENTS = _ALL[: _COUNT[ORDER]]


def _pairs(order):
    """Return which pairs of coefficients belong to a product's, and where each one's begin."""
    # A product's coefficient of one place is the sum over all pairs whose exponents add up to it.
    every = _ALL[: _COUNT[order]]
    pairs = sorted(
        (_PLACE[i + k, j + m], _PLACE[i, j], _PLACE[k, m])
        for (i, j), (k, m) in product(every, every)
        if i + j + k + m <= order
    )
    target, left, right = np.array(pairs).T
    return left, right, np.searchsorted(target, np.arange(len(every)))


_PAIRS = {count: _pairs(order) for order, count in _COUNT.items()}
_MANY = 300  # points, from which on numpy is faster with one pair of rows after the other
_PLAIN = (float, int)


class Jet(np.lib.mixins.NDArrayOperatorsMixin):
    """The Taylor polynomial of a function of two variables, at an array of points.

    Parameters
    ----------
    c : (15 or 21, ...) float
        Coefficients of h^i k^j by degree, those of k highest last, to order 4 or 5; one polynomial
        a point.

    Notes
    -----
    Jets go with numbers, with arrays of one value a point, with + - * / ** and with the numpy
    functions of `_FUNCTIONS`. Where a function isn't smooth the coefficients are NaN or infinite.

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

    # The same as by `__array_ufunc__`, without numpy's way there, which takes as long as the work.

    def __add__(self, other):
        with np.errstate(all="ignore"):
            return _add(self, other)

    __radd__ = __add__

    def __sub__(self, other):
        with np.errstate(all="ignore"):
            return _subtract(self, other)

    def __rsub__(self, other):
        with np.errstate(all="ignore"):
            return _subtract(other, self)

    def __mul__(self, other):
        with np.errstate(all="ignore"):
            return _multiply(self, other)

    def __rmul__(self, other):
        with np.errstate(all="ignore"):
            return _multiply(other, self)

    def __truediv__(self, other):
        with np.errstate(all="ignore"):
            return _divide(self, other)

    def __rtruediv__(self, other):
        with np.errstate(all="ignore"):
            return _divide(other, self)

    # A jet is a value: `jet += 1` makes another one, since a caller may still hold the first.
    __iadd__ = __add__
    __isub__ = __sub__
    __imul__ = __mul__
    __itruediv__ = __truediv__
    __ipow__ = np.lib.mixins.NDArrayOperatorsMixin.__pow__


def derivative(f, i, j):
    """Return what `Jet.derivative` does, unchecked: for inner loops."""
    return factorial(i) * factorial(j) * f.c[_PLACE[i, j]]


def places(f):
    """Return the place in a jet's coefficients of each pair of exponents."""
    return {exponents: _PLACE[exponents] for exponents in _ALL[: len(f.c)]}


def differentiated(f, axis):
    """Return the jet of a derivative by the first (0) or second (1) variable, an order lower."""
    c = np.zeros_like(f.c)
    for place, exponents in enumerate(_ALL[: len(f.c)]):
        if exponents[axis]:
            lower = (exponents[0] - (axis == 0), exponents[1] - (axis == 1))
            c[_PLACE[lower]] = exponents[axis] * f.c[place]
    return Jet(c)


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


def compose(jets, s, t):
    """Return jets of functions of (h, k), with the jets `s` and `t`, of value 0, put for h and k.

    Parameters
    ----------
    jets : sequence of Jet
        Functions of (h, k).
    s, t : Jet
        Functions of two new variables, of value 0.

    Returns
    -------
    composed : list of Jet
        Functions of the new variables, to the order that all of them have.
    """
    # All products s^i t^j, each from one before; the values are added last, as s and t have none.
    powers = {(0, 0): 1.0, (1, 0): s, (0, 1): t}
    every = _ALL[: len(s.c)]
    with np.errstate(all="ignore"):
        for i, j in every[3:]:
            powers[i, j] = _multiply(s, powers[i - 1, j]) if i else _multiply(t, powers[0, j - 1])
        terms = [powers[exponents].c for exponents in every[1:]]
        composed = [sum(term * c for term, c in zip(terms, jet.c[1:], strict=True)) for jet in jets]
    return [Jet(c) + jet.value for c, jet in zip(composed, jets, strict=True)]


def inverse(x, y):
    """Return the variables as functions of two jets, where these have a regular Jacobian.

    Parameters
    ----------
    x, y : Jet
        Functions of (h, k); their values don't matter.

    Returns
    -------
    h, k : Jet
        Functions of (x - x0, y - y0), of value 0; not finite where the Jacobian vanishes.
    """
    origin = np.zeros_like(x.value)
    h, k = jet_variables(origin, origin, order=x.order)
    (_, xh, xk), (_, yh, yk) = x.c[:3], y.c[:3]
    with np.errstate(all="ignore"):
        determinant = xh * yk - xk * yh
        xh, xk, yh, yk = (entry / determinant for entry in (xh, xk, yh, yk))
    # x = xh h + xk k + bent(h, k): the linear part is undone exactly, what bends by substitution.
    bent = [Jet(np.concatenate([np.zeros_like(j.c[:3]), j.c[3:]])) for j in (x, y)]
    with np.errstate(all="ignore"):
        s = Jet(yk * h.c - xk * k.c)
        t = Jet(xh * k.c - yh * h.c)
        for _ in range(x.order - 1):  # each round makes one more order right
            x_left, y_left = (
                start.c - part.c for start, part in zip((h, k), compose(bent, s, t), strict=True)
            )
            s = Jet(yk * x_left - xk * y_left)
            t = Jet(xh * y_left - yh * x_left)
    return s, t


def _constant(value, like):
    points = np.broadcast_shapes(np.shape(value), like.c.shape[1:])
    c = np.zeros((len(like.c), *points))
    c[0] = value
    return Jet(c)


def _raised(a, value):
    """Return a jet plus a number, or an array with one at each of its points."""
    c = a.c.copy()
    c[0] += value
    return Jet(c)


def _both(a, b):
    """Return two operands, of which at least one is a jet, as jets at points of as many axes."""
    a = a if isinstance(a, Jet) else _constant(a, b)
    b = b if isinstance(b, Jet) else _constant(b, a)
    if a.c.ndim != b.c.ndim:
        return Jet(_widened(a.c, b.c.ndim - 1)), Jet(_widened(b.c, a.c.ndim - 1))
    return a, b


def _widened(c, ndim):
    """Return coefficients with axes put in until they are of points of `ndim` axes or more.

    Points broadcast as arrays do, by their last axes; the axis of coefficients stays the first.
    """
    missing = ndim + 1 - c.ndim
    return c.reshape(c.shape[0], *[1] * missing, *c.shape[1:]) if missing > 0 else c


def _add(a, b):
    if not isinstance(a, Jet):
        a, b = b, a
    # Most of what isn't a jet is a number, or has the points' shape.
    if type(b) in _PLAIN or (getattr(b, "shape", None) == a.c.shape[1:] and not isinstance(b, Jet)):
        return _raised(a, b)
    a, b = _both(a, b)
    return Jet(a.c + b.c)


def _subtract(a, b):
    return _add(a, Jet(-b.c) if isinstance(b, Jet) else -b)


def _multiply(a, b):
    if not isinstance(b, Jet):
        return Jet(a.c * b) if type(b) in _PLAIN else Jet(_widened(a.c, np.ndim(b)) * b)
    if not isinstance(a, Jet):
        return Jet(a * b.c) if type(a) in _PLAIN else Jet(a * _widened(b.c, np.ndim(a)))
    if a.c.ndim != b.c.ndim:
        a, b = _both(a, b)
    left, right, starts = _PAIRS[len(a.c)]
    if max(a.c[0].size, b.c[0].size) < _MANY:
        # Of few points `take` takes half the time of an index.
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
    """Return the coefficients of a function whose derivatives come round again."""
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
    return np.sin(x), np.cos(x), -np.sin(x), -np.cos(x)


def _names():
    operators = {"add", "subtract", "multiply", "divide", "power", "negative", "positive"}
    return sorted({f.__name__ for f in _FUNCTIONS} - operators)
