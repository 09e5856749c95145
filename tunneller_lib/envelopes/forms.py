"""Derivatives of a jet in turning directions, and where a trigonometric polynomial vanishes."""

from functools import cache
from itertools import pairwise

import numpy as np

SAME = 2e-5  # rad, roots nearer than this are one multiple root
_NEARLY_REAL = 1e-3
_ZERO = 1e-11  # of the coefficients' sum


def along(f, angle, e, w=0):
    """Return a jet's derivatives `e` times along e, `w` times along w, at direction angles.

    Parameters
    ----------
    f : Jet
        At n points.
    angle : (n or 1, m) float
        Angles of e = (cos, sin), in rad; w = (-sin, cos) is e turned by a right angle.
    e, w : int
        How often by each; at most 4 together.

    Returns
    -------
    derivative : (n, m) float
        A binary form in e of degree e + w.
    """
    c, s = np.cos(angle), np.sin(angle)
    degree = e + w
    form = [f.derivative(degree - k, k)[:, None] for k in range(degree + 1)]
    for x, y in [(c, s)] * e + [(-s, c)] * w:
        form = [x * first + y * second for first, second in pairwise(form)]
    return form[0]


def size(f, degree):
    """Return the Frobenius norms (n,) of a jet's tensors of derivatives of one degree."""
    form = [f.derivative(degree - k, k) for k in range(degree + 1)]
    weights = np.cumprod([1.0, *((degree - k) / (k + 1) for k in range(degree))])
    return np.sqrt(sum(weight * entry**2 for weight, entry in zip(weights, form, strict=True)))


def circle_roots(function, degree, *, unit):
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
    samples = 2 * np.pi * np.arange(n + 1)[None] / (n + 1)
    values = function(samples)
    harmonics = np.fft.fft(values, axis=-1) / (n + 1)  # harmonic k at place k modulo n + 1
    scale = np.sum(np.abs(harmonics), axis=-1, keepdims=True)
    vanishes = scale[:, 0] <= 1e-12 * unit
    at = np.take(samples[0], np.argmax(np.abs(values), axis=-1))[:, None] + np.pi
    orders = np.arange(-degree, degree + 1)
    line = ((harmonics[:, orders] * np.exp(1j * orders * at)) @ _line(degree)).real
    line[vanishes] = np.eye(n + 1)[-1]
    companion = np.zeros((len(line), n, n))
    companion[:, np.arange(1, n), np.arange(n - 1)] = 1.0
    companion[:, :, -1] = -line[:, :-1] / line[:, -1:]
    tangent = np.linalg.eigvals(companion)
    nearly = np.abs(tangent.imag) < _NEARLY_REAL * (1 + np.abs(tangent) ** 2)
    # Seen from `at`, where the polynomial is greatest, no zero lies near -pi or pi.
    angle = _polished(harmonics, orders, at + 2 * np.arctan(tangent.real))
    left = np.abs(_evaluate(harmonics, orders, angle)[0])
    found = nearly & (left <= _ZERO * scale) & ~vanishes[:, None]
    angle, multiplicity = _merged(np.where(found, angle - at, np.nan))
    angle = np.angle(np.exp(1j * (angle + at)))
    order = np.argsort(angle, axis=-1)
    return np.take_along_axis(angle, order, -1), np.take_along_axis(multiplicity, order, -1)


@cache
def _line(degree):
    """Return the coefficients of (1 + i x)^(d + k) (1 - i x)^(d - k), a row for each k."""
    rows = []
    for k in range(-degree, degree + 1):
        rows.append(np.poly1d([1.0]))
        for factor in [[1j, 1]] * (degree + k) + [[-1j, 1]] * (degree - k):
            rows[-1] = rows[-1] * np.poly1d(factor)
    return np.array([row.coeffs[::-1] for row in rows])


def _evaluate(harmonics, orders, angle):
    waves = harmonics[:, None, orders] * np.exp(1j * orders * angle[..., None])
    return waves.sum(axis=-1).real, (1j * orders * waves).sum(axis=-1).real


def _polished(harmonics, orders, angle):
    """Return angles after two Newton steps, none of which may lead to another zero."""
    for _ in range(2):
        value, slope = _evaluate(harmonics, orders, angle)
        with np.errstate(all="ignore"):
            step = value / slope
        angle = angle - np.where(np.abs(step) < 0.1 * SAME, step, 0.0)
    return angle


def _merged(angle):
    """Return sorted angles (n, m), those that are nearly the same put together, and how many."""
    angle = np.sort(angle, axis=-1)  # NaN comes last
    multiplicity = np.isfinite(angle).astype(int)
    for column in range(angle.shape[-1] - 1):
        near = angle[:, column + 1] - angle[:, column] < SAME
        count = multiplicity[:, column]
        # The mean, kept in the later column; what is put together leaves the earlier.
        mean = (count * angle[:, column] + angle[:, column + 1]) / (count + 1)
        angle[near, column + 1], angle[near, column] = mean[near], np.nan
        multiplicity[near, column + 1] += count[near]
        multiplicity[near, column] = 0
    return angle, multiplicity
