"""Graphs that solve the document's equations, as power series from random data on a line.

They are what a reader would try who doubts the answers to Problems 15 and 30: nothing of the proofs
is put in. A series in two variables is an array of its coefficients of h^i k^j, those of a degree
above `DEGREE` being 0; h and k count from a place (x0, y0) of the model.
"""

import numpy as np

DEGREE = 8
_SIZE = DEGREE + 1
_ORDER = np.add.outer(np.arange(_SIZE), np.arange(_SIZE))


class Equations:
    """What the document asks of a graph f(x, y), a field of directions (1, m) and their conics.

    Parameters
    ----------
    f, m : (9, 9) float
        Series; f in m.
    place : (2,) float
        From which h and k count.
    """

    def __init__(self, f, m, place):
        self.f = f
        self.m = m
        self.place = place
        self.x = series(place[0], 1.0)
        self.y = series(place[1], 0.0, 1.0)
        self.p = series(1.0) + product(self.x, self.x) + product(self.y, self.y)
        self.square = series(1.0) + product(m, m)  # of the direction's length
        self.inverse = inverse_root(self.square)
        self.length = product(self.square, self.inverse)
        self.across = self.y - product(m, self.x)  # x.w, times the length

    def second(self):
        """Return f_ee, times the length squared."""
        two, one, none = (slope(self.f, i, 2 - i) for i in (2, 1, 0))
        return two + product(self.m, 2 * one + product(self.m, none))

    def third(self):
        """Return f_eee, times the length cubed."""
        three, two, one, none = (slope(self.f, i, 3 - i) for i in (3, 2, 1, 0))
        inner = 3 * one + product(self.m, none)
        return three + product(self.m, 3 * two + product(self.m, inner))

    def mixed(self):
        """Return f_ew, times the length squared."""
        turned = product(self.m, slope(self.f, 0, 2) - slope(self.f, 2, 0))
        return turned + product(2 * series(1.0) - self.square, slope(self.f, 1, 1))

    def hyperosculates(self, tau):
        """Return (11) with the rho of (9), times p/rho^3 and the length cubed."""
        inclined = tau * self.length - self.across
        return product(self.p, self.third()) + 6 * product(inclined, self.mixed())

    def hyperosculates_twice(self, tau):
        """Return the derivative of that by m."""
        two, one, none = (slope(self.f, i, 3 - i) for i in (2, 1, 0))
        third = 3 * (two + product(self.m, 2 * one + product(self.m, none)))
        inclined = tau * self.length - self.across
        bent = tau * product(self.m, self.inverse) + self.x
        mixed = slope(self.f, 0, 2) - slope(self.f, 2, 0)
        mixed = mixed - 2 * product(self.m, slope(self.f, 1, 1))
        rest = product(bent, self.mixed()) + product(inclined, mixed)
        return product(self.p, third) + 6 * rest

    def radius(self):
        """Return (24) for R = 0, times 1/rho^2 and the length squared."""
        height = self.f - product(self.x, slope(self.f, 1, 0))
        height = height - product(self.y, slope(self.f, 0, 1))
        return product(self.p, self.second()) + 2 * product(self.square, height)

    def offset(self, size):
        """Return the same on the surface at a distance, in m, that its normals point away from."""
        return Equations(self.f + size / 2 * self.p, self.m, self.place)

    def at(self, h, k, i=0, j=0):
        """Return values of f, or of a derivative of it, at (x0 + h, y0 + k)."""
        return np.polynomial.polynomial.polyval2d(h, k, slope(self.f, i, j))

    def angle(self, h, k):
        """Return the angle of the direction at (x0 + h, y0 + k)."""
        return np.arctan(np.polynomial.polynomial.polyval2d(h, k, self.m))


def solved(asked, free, changed, rng):
    """Return a random graph and field that solve two equations, to the series' degree.

    Parameters
    ----------
    asked : callable
        Of `Equations`: two series that shall vanish, of order `free` in h.
    free : int
        f and its derivatives by h of lower orders are random on the line h = 0.
    changed : pair of pairs
        Which two coefficients of f are changed so that the equations hold in the place itself, for
        the random direction there.
    rng : numpy.random.Generator
        Where the data, the place and the direction come from.

    Returns
    -------
    equations : Equations
        With the graph, the field and the place.
    """
    place = rng.uniform(-0.8, 0.8, 2)
    f = np.where(_ORDER <= DEGREE, rng.normal(size=_ORDER.shape) / 3.0**_ORDER, 0.0)
    f[free:] = 0.0
    m = series(rng.normal())

    def left(where, values, of_f, of_m):
        f[of_f] = values[: len(of_f[0])]
        m[of_m] = values[len(of_f[0]) :]
        return np.concatenate([part[where] for part in asked(Equations(f, m, place))])

    # The equations are linear in what is unknown of each degree.
    none = (np.array([], int),) * 2
    _solve(left, (np.array([0]),) * 2, tuple(np.transpose(changed)), none)
    for degree in range(1, DEGREE - free + 1):
        these = _of_degree(degree)
        of_f = tuple(c[: degree + 1] for c in _of_degree(degree + free))
        _solve(left, these, of_f, these)
    return Equations(f, m, place)


def _solve(left, where, of_f, of_m):
    count = len(of_f[0]) + len(of_m[0])
    rest = left(where, np.zeros(count), of_f, of_m)
    change = np.array([left(where, unit, of_f, of_m) - rest for unit in np.eye(count)]).T
    left(where, -np.linalg.solve(change, rest), of_f, of_m)


def _of_degree(degree):
    """Return the places of the coefficients of a degree, the highest power of h first."""
    return degree - np.arange(degree + 1), np.arange(degree + 1)


def series(*coefficients):
    """Return the series of c + c1 h + c2 k."""
    found = np.zeros((_SIZE, _SIZE))
    for place, c in zip(((0, 0), (1, 0), (0, 1)), coefficients, strict=False):
        found[place] = c
    return found


def product(a, b):
    """Return the product of two series."""
    # Here: importing scipy.signal takes a second, which workers of other tests are spared.
    from scipy.signal import convolve2d

    return np.where(_ORDER <= DEGREE, convolve2d(a, b)[:_SIZE, :_SIZE], 0.0)


def inverse_root(a):
    """Return 1/sqrt(a) for a series whose value is positive."""
    found = series(1 / np.sqrt(a[0, 0]))
    for _ in range(4):  # each step doubles the degree to which it is right
        found = product(found, 3 * series(1.0) - product(a, product(found, found))) / 2
    return found


def slope(f, i, j):
    """Return the derivative of a series, i times by h and j times by k."""
    for axis, times in ((0, i), (1, j)):
        for _ in range(times):
            f = np.moveaxis(f, axis, 0)
            f = np.concatenate([f[1:] * np.arange(1, _SIZE)[:, None], np.zeros((1, _SIZE))])
            f = np.moveaxis(f, 0, axis)
    return f
