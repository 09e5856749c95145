"""Measured surfaces: polynomials through points and normals with noise, as in Example 32.

Over the plane of the mean normal a surface is a polynomial z of two coordinates. A point says what
z is and a normal what its slopes are, so both together are one linear least-squares problem, whose
weights are the known errors.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ..arguments import LEAST, Directions, Length0, NotNegative, Points, checked
from ..kernels.exact import norm
from .functions import UnitVectors, Varying
from .jet import Jet

MOST_DEGREE = 16
LEAST_DEGREE = 4
MORE = 2  # degrees above the least that noise allows: what is left out is then less than noise
FEWEST = 250  # points, the least number that is fitted
STEEP = 0.4  # cosine between a normal and the mean, below which a polynomial isn't tried
UNLIKELY = 5.0  # standard deviations that a sum of squares of noise isn't above its mean
ROUNDING = 1e-13  # of the patch, the least error of a point
BEYOND = 2.0  # times the patch, how far a polynomial is followed


@checked
def mean_frame(n: Directions):
    """Return a right-handed frame whose third axis is the mean of normals.

    Parameters
    ----------
    n : (..., 3) float
        Normals.

    Returns
    -------
    axes : (3, 3) float
        Three unit vectors in rows.

    Raises
    ------
    ValueError
        If there is no normal, or their mean is zero.
    """
    rows = n.reshape(-1, 3)
    if not len(rows):
        raise ValueError("n: must hold at least one normal; got none.")
    third = rows.mean(axis=0)
    if not np.abs(third).max() >= LEAST:
        raise ValueError("n: the normals' mean must not be zero; got one that is.")
    third = third / norm(third)
    first = np.cross(np.eye(3)[np.argmin(np.abs(third))], third)
    first = first / norm(first)
    return np.array([first, np.cross(third, first), third])


@dataclass(frozen=True, eq=False)
class Fit:
    """A polynomial z(x, y) through measured points and normals, in a frame of its own.

    Parameters
    ----------
    origin : (3,) float
        The middle of the points that were kept, in m.
    axes : (3, 3) float
        Rows: unit vectors along x, y, z; z is the mean normal.
    reach : float
        The greatest x or y of these points, by which both are divided, in m.
    degree : int
        Of the polynomial.
    c : (p,) float
        Coefficients of Chebyshev's products T_i(x) T_j(y), those of a degree together, in m.
    fits : bool
        Whether what is left of the points and normals is noise of the errors that were given.
    """

    origin: np.ndarray
    axes: np.ndarray
    reach: float
    degree: int
    c: np.ndarray
    fits: bool

    @checked
    def surface(self, x: Varying, y: Varying):
        """Return the fitted point, as `hyperosculating_cones` wants it with model="space".

        Parameters
        ----------
        x, y : (...) float or Jet
            Place in the frame, in m.

        Returns
        -------
        r : list of three
            Coordinates in m.

        Raises
        ------
        ValueError
            If a place is beyond twice the patch, where a polynomial says nothing.
        """
        for name, part in (("x", x), ("y", y)):
            size = np.abs(part.value if isinstance(part, Jet) else part)
            if np.any(size > BEYOND * self.reach):
                raise ValueError(
                    f"{name}: must be at most {BEYOND * self.reach:g} m in size, {BEYOND:g} times "
                    f"the patch's; got {np.max(size):g}."
                )
        across, along = (_chebyshev(part / self.reach, self.degree) for part in (x, y))
        rows = [0.0] * (self.degree + 1)
        for coefficient, (i, j) in zip(self.c, _orders(self.degree), strict=True):
            rows[i] = rows[i] + coefficient * along[j]
        z = sum(row * factor for row, factor in zip(rows, across, strict=True))
        frame = zip(self.origin, *self.axes, strict=True)
        return [middle + x * a + y * b + z * n for middle, a, b, n in frame]


@checked
def fit_surface(
    contact: Points, n: UnitVectors, *, contact_error: Length0, normal_error: NotNegative
):
    """Return a polynomial surface through measured points with normals.

    Parameters
    ----------
    contact : (..., 3) float
        Points of a surface, in m.
    n : (..., 3) float
        Its unit normals there.
    contact_error : float
        Standard error of a point along the normal, in m; 0 for points that are exact.
    normal_error : float
        Standard error of a normal in each of two directions, in rad.

    Returns
    -------
    fit : Fit
        Through all points, or through the inner half, quarter and so on that a polynomial follows.

    Raises
    ------
    ValueError
        If there are fewer than 250 points.

    Notes
    -----
    Envelopes of cones, Example 32, which doesn't say how it fits. The degree is two above the
    least to which no higher one adds more than noise would, so that what the polynomial leaves out
    is less than its errors. Where even degree 16 leaves more than noise, the outer half of the
    points is left out, as long as 250 remain.

    Examples
    --------
    >>> n = np.random.default_rng(0).uniform(0.3, 0.9, (300, 3))
    >>> n /= norm(n)[:, None]  # of a ball, which are its points as well
    >>> fit_surface(n, n, contact_error=0.0, normal_error=1e-6).fits
    True
    >>> upright = np.tile([0.0, 0.0, 1.0], (300, 1))
    >>> fit_surface(n[:, 2:] * upright, upright, contact_error=0.0, normal_error=1e-6)
    Traceback (most recent call last):
    ValueError: contact: must not lie on a line along the mean normal, or at one place.
    """
    contact, n = (part.reshape(-1, 3) for part in np.broadcast_arrays(contact, n))
    if len(contact) < FEWEST:
        raise ValueError(f"contact: must be at least {FEWEST} points; got {len(contact)}.")
    fit, place = _fitted(contact, n, contact_error, normal_error)
    while not fit.fits and len(contact) >= 2 * FEWEST:
        away = np.sum(((place - place.mean(axis=0)) / np.ptp(place, axis=0)) ** 2, axis=-1)
        inner = away <= np.median(away)
        contact, n = contact[inner], n[inner]
        fit, place = _fitted(contact, n, contact_error, normal_error)
    return fit


def _fitted(contact, n, contact_error, normal_error):
    """Return the fit to all of some points and normals, and the points' places (k, 2) in it."""
    axes = mean_frame(n)
    origin = contact.mean(axis=0)
    local = (contact - origin) @ axes.T
    if np.ptp(local[:, :2], axis=0).min() == 0:
        raise ValueError("contact: must not lie on a line along the mean normal, or at one place.")
    n = n @ axes.T
    reach = np.abs(local[:, :2]).max()
    off = max(contact_error, ROUNDING * reach)
    matrix, right = _equations(local, n, reach, off, max(normal_error, ROUNDING))
    # The last column of the triangle is the right side, turned as the matrix was. It has a number
    # for each coefficient, in the order of degrees, whose square is by how much that coefficient
    # lessens the sum of squares, and at its end the root of the sum that is left.
    triangle = np.linalg.qr(np.column_stack([matrix, right]), mode="r")
    root, image = triangle[:-1, :-1], triangle[:-1, -1]
    left = triangle[-1, -1] ** 2
    free = len(right) - len(image)
    # The sum of as many squares of noise is about their number, give or take the root of twice it.
    fits = n[:, 2].min() > STEEP and left < free + UNLIKELY * np.sqrt(2 * free)
    degree = _degree(image)
    count = _count(degree)
    c = np.linalg.solve(root[:count, :count], image[:count])
    return Fit(origin, axes, reach, degree, c, bool(fits)), local[:, :2]


def _equations(local, n, reach, contact_error, normal_error):
    """Return the matrix and the right side of the polynomial's equations, over their errors.

    A normal that turns by a small angle changes the slope along the gradient by that times
    1 + |gradient|^2, and the slope across by that times the root.
    """
    # A point gives an equation for the height, a normal two for the slopes: uphill and across.
    # Chebyshev polynomials keep the columns apart; powers of a high degree would be alike.
    x, y, z = local.T
    slope = -n[:, :2] / n[:, 2:]
    steep = 1 / n[:, 2]  # root of 1 + |gradient|^2
    size = norm(slope)
    uphill = np.where(size[:, None] > 0, slope / np.where(size > 0, size, 1)[:, None], [1.0, 0.0])
    across = np.stack([-uphill[:, 1], uphill[:, 0]], axis=-1)
    i, j = np.array(_orders(MOST_DEGREE)).T
    derivatives = chebyshev.chebder(np.eye(MOST_DEGREE + 1)) / reach
    tx, ty = (chebyshev.chebvander(c / reach, MOST_DEGREE) for c in (x, y))
    by_x = (tx[:, :-1] @ derivatives)[:, i] * ty[:, j]
    by_y = tx[:, i] * (ty[:, :-1] @ derivatives)[:, j]
    rows = [tx[:, i] * ty[:, j]]
    rows += [way[:, :1] * by_x + way[:, 1:] * by_y for way in (uphill, across)]
    right = [z, size, 0 * size]
    errors = contact_error * steep, normal_error * steep**2, normal_error * steep
    scaled = [row / error[:, None] for row, error in zip(rows, errors, strict=True)]
    return np.vstack(scaled), np.concatenate([b / e for b, e in zip(right, errors, strict=True)])


def _degree(image):
    """Return the least degree beyond which coefficients are noise, plus `MORE`."""
    # If all coefficients from a degree on are noise, the sum of their squares is about their
    # number.
    gain = np.cumsum(image[::-1] ** 2)[::-1]  # of all coefficients from each one on
    for degree in range(LEAST_DEGREE, MOST_DEGREE):
        first = _count(degree)
        more = len(image) - first
        if gain[first] < more + UNLIKELY * np.sqrt(2 * more):
            break
    return min(degree + MORE, MOST_DEGREE)


def _count(degree):
    """Return how many coefficients a polynomial of a degree has."""
    return (degree + 1) * (degree + 2) // 2


def _orders(degree):
    """Return all pairs (i, j) of a degree or less, the lower degrees first."""
    return [(i, k - i) for k in range(degree + 1) for i in range(k + 1)]


def _chebyshev(x, degree):
    """Return Chebyshev's polynomials of a number, array or jet up to a degree."""
    every = [1 + 0 * x, x]
    for _ in range(degree - 1):
        every.append(2 * x * every[-1] - every[-2])
    return every
