"""Where trigonometric polynomials vanish: all real zeros on the circle, by eigenvalues."""

from functools import cache

import numpy as np

SAME = 2e-5  # rad, roots nearer than this are one multiple root
_NEARLY_REAL = 1e-3
_ZERO = 1e-11  # of the coefficients' sum


class Waves:
    """Trigonometric polynomials of a degree, (n,) of them, by their harmonics.

    Parameters
    ----------
    function : callable
        As for `real_zeros`.
    degree : int
        Of the polynomials.
    """

    def __init__(self, function, degree):
        count = 2 * degree + 1
        self.places = 2 * np.pi * np.arange(count) / count
        self.samples = function(self.places[None])
        self.orders = np.arange(-degree, degree + 1)  # harmonic k is at place k modulo the count
        self.c = (np.fft.fft(self.samples, axis=-1) / count)[:, self.orders]

    def derivative(self, angle, k):
        """Return the k-th derivatives (n, m) at angles (n, m)."""
        factor = self.c * (1j * self.orders) ** k
        return np.real(np.sum(factor[:, None] * np.exp(1j * self.orders * angle[..., None]), -1))

    def most(self, k):
        """Return a bound (n, 1) of the k-th derivatives."""
        return np.sum(np.abs(self.c) * np.abs(self.orders) ** k, axis=-1)[:, None]


def real_zeros(function, degree, *, unit):
    """Return all real zeros of trigonometric polynomials, with their multiplicities.

    Parameters
    ----------
    function : callable
        Maps angles (1, m) or (n, m) to the values (n, m) of n trigonometric polynomials.
    degree : int
        Their degree d.
    unit : (n,) float
        What their values are to be compared with: one below 1e-12 of it vanishes everywhere.

    Returns
    -------
    angle : (n, 2 d) float
        The zeros from -pi to pi, ascending, NaN-padded; none where a polynomial vanishes
        everywhere.
    multiplicity : (n, 2 d) int
        How many zeros fell together, 0 in the padding.

    Notes
    -----
    The circle is mapped onto a line by the tangent of the half angle, from the angle at which
    the polynomial is greatest: that becomes the leading coefficient, so that no zero is lost at
    infinity. A fixed angle, as in the document's Eq. 13, loses the zero that it hits. A pair of
    zeros is taken for a double one where it is nearer than `SAME`, or where the polynomial
    doesn't leave 1e-11 of its coefficients between the two.
    """
    n = 2 * degree
    waves = Waves(function, degree)
    scale = waves.most(0)
    vanishes = scale[:, 0] <= 1e-12 * unit
    # `at` lies opposite the greatest sample, which the half angle's tangent sends to infinity.
    greatest = np.argmax(np.abs(waves.samples), axis=-1)
    at = np.take(waves.places, greatest)[:, None] + np.pi
    line = ((waves.c * np.exp(1j * waves.orders * at)) @ _line(degree)).real
    line[vanishes] = np.eye(n + 1)[-1]  # any polynomial that divides soundly: no zero is kept
    companion = np.zeros((len(line), n, n))
    companion[:, np.arange(1, n), np.arange(n - 1)] = 1.0
    companion[:, :, -1] = -line[:, :-1] / line[:, -1:]
    tangent = np.linalg.eigvals(companion)
    # Rounding may turn a double zero into a complex pair, off the axis by the root of a rounding.
    nearly = np.abs(tangent.imag) < _NEARLY_REAL * (1 + np.abs(tangent) ** 2)
    # Angles are counted from `at`: there no zero lies near -pi or pi, where the polynomial is
    # greatest, so that none is torn apart when they are sorted.
    angle = _polished(waves, at + 2 * np.arctan(tangent.real), 0.1 * SAME)
    left = np.abs(waves.derivative(angle, 0))
    # That bound also lets pairs pass that miss the axis: there the polynomial keeps off zero.
    found = nearly & (left <= _ZERO * scale) & ~vanishes[:, None]
    angle, multiplicity = _merged(np.where(found, angle - at, np.nan))
    # Zeros that fell together are known to a root of rounding only; in their middle the derivative
    # of one order less than they are has a simple zero.
    for m in np.unique(multiplicity[multiplicity > 1]):
        middle = _polished(waves, angle + at, SAME, m - 1) - at
        angle = np.where(multiplicity == m, middle, angle)
    angle = np.angle(np.exp(1j * (angle + at)))
    order = np.argsort(angle, axis=-1)
    return np.take_along_axis(angle, order, -1), np.take_along_axis(multiplicity, order, -1)


@cache
def _line(degree):
    """Return the coefficients of (1 + i x)^(d + k) (1 - i x)^(d - k), a row for each k."""
    rows = []
    for k in range(-degree, degree + 1):
        row = np.poly1d([1.0])
        for factor in [[1j, 1]] * (degree + k) + [[-1j, 1]] * (degree - k):
            row = row * np.poly1d(factor)
        rows.append(row.coeffs[::-1])
    return np.array(rows)


def _polished(waves, angle, most, order=0):
    """Return angles after two Newton steps to zeros of a derivative, none of `most` or longer.

    Examples
    --------
    >>> near = np.array([[0.01, 3.14]])
    >>> _polished(Waves(np.sin, 1), near, 0.1).round(6) + 0.0
    array([[0.      , 3.141593]])
    """
    for _ in range(2):
        value, slope = (waves.derivative(angle, k) for k in (order, order + 1))
        with np.errstate(all="ignore"):
            step = value / slope
        # A longer step would lead to another zero.
        angle = angle - np.where(np.abs(step) < most, step, 0.0)
    return angle


def _merged(angle):
    """Return sorted angles (n, m), those that are nearly the same put together, and how many."""
    angle = np.sort(angle, axis=-1)  # NaN comes last
    multiplicity = np.isfinite(angle).astype(int)
    for column in range(angle.shape[-1] - 1):
        near = angle[:, column + 1] - angle[:, column] < SAME
        count = multiplicity[:, column]
        # The mean, kept in the later column, where a third may join; the earlier is left empty.
        mean = (count * angle[:, column] + angle[:, column + 1]) / (count + 1)
        angle[near, column + 1] = mean[near]
        angle[near, column] = np.nan
        multiplicity[near, column + 1] += count[near]
        multiplicity[near, column] = 0
    return angle, multiplicity
