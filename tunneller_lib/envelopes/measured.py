"""Surfaces through measured points and normals of known noise.

Over the plane of the mean normal a surface is a polynomial z of two coordinates. A point says what
z is and a normal what its slopes are, so both together are one linear least-squares problem, whose
weights are the known errors.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ..arguments import Length0, NotNegative, Points, Reals, checked
from ..kernels.exact import norm
from .fit import mean_frame
from .functions import UnitVectors, Varying
from .jet import Jet, jet_variables

MOST_DEGREE = 16
LEAST_DEGREE = 4
MORE = 2  # degrees beyond those that noise lets be seen: what is left out is less than noise
FEWEST = 250  # planes, and the share, below which none are left out any more: what a polynomial
SHARE = 4  # follows near an edge of regression is too small a part to speak for the surface
SIDES = np.arange(8) * np.pi / 4  # rad, of the lines that part the points in halves
STEEP = 0.4  # cosine between a normal and the mean, below which a polynomial isn't tried
UNLIKELY = 5.0  # standard deviations of a sum of squares
ROUNDING = 1e-13  # of the patch, the least error of a point
BEYOND = 2.0  # times the patch, how far a polynomial is followed


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
        By which x and y are divided, in m: the greatest of them.
    degree : int
        Of the polynomial.
    c : (p,) float
        Coefficients of Chebyshev's products T_i(x) T_j(y), those of a degree together, in m.
    root : (p, p) float
        Upper triangular; the covariance of c is the inverse of its transpose times it.
    place : (k, 2) float
        x and y of the points that were kept, in m.
    misfit : float
        Root of the mean square of what is left, over its error: 1 if that is noise alone; infinite
        where a normal leans too far from the mean.
    fits : bool
        Whether it is, as far as noise can be told.
    """

    origin: np.ndarray
    axes: np.ndarray
    reach: float
    degree: int
    c: np.ndarray
    root: np.ndarray
    place: np.ndarray
    misfit: float
    fits: bool

    @checked
    def surface(self, x: Varying, y: Varying):
        """Return the fitted point as three coordinates, for `hyperosculating_cones` with
        model="space".

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
    def jet_errors(self, x: Reals, y: Reals):
        """Return standard errors of the Taylor coefficients of z(x, y), from the covariance.

        Parameters
        ----------
        x, y : (...) float
            Places in the frame, in m.

        Returns
        -------
        errors : (15, ...) float
            Of h^i k^j as a `Jet` has them, in m^(1 - i - j).
        """
        x, y = np.broadcast_arrays(x, y)
        turned = np.linalg.solve(self.root, np.eye(len(self.c)))  # its columns' squares add up
        across, along = (
            _chebyshev(part / self.reach, self.degree)
            for part in jet_variables(x.ravel(), y.ravel())
        )
        like = 0 * across[1]
        basis = [(like + across[i] * along[j]).c for i, j in _orders(self.degree)]
        errors = norm(np.einsum("pcn,pq->cnq", np.array(basis), turned))
        return errors.reshape(len(errors), *x.shape)


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
        Through all points, or through a half or a quarter of them that a polynomial can follow.

    Raises
    ------
    ValueError
        If there are fewer than 250 points.

    Notes
    -----
    Envelopes of cones, Example 32, which doesn't say how it fits. The least degree is taken to
    which no higher one adds more than noise would, and two more, so that what the polynomial leaves
    out is less than its errors. Where the highest leaves more than noise, as near an edge of
    regression, the outer half of the points is left out, and once more. Where that won't do, those
    on one side of a line through the middle are, in one of eight directions: the first half that a
    polynomial can follow is kept, or, if none, a half of the one that it follows best.

    Examples
    --------
    >>> from tunneller_lib.envelopes.families import cyclide
    >>> from tunneller_lib.envelopes.isotropic import normal, surface_points
    >>> x, y = np.random.default_rng(0).uniform(0.3, 0.6, (2, 800))
    >>> data = surface_points(cyclide, x, y), np.stack(normal(x, y), axis=-1)
    >>> found = fit_surface(*data, contact_error=1e-6, normal_error=1e-6)
    >>> found.fits, len(found.place)
    (True, 800)
    """
    contact, n = (part.reshape(-1, 3) for part in np.broadcast_arrays(contact, n))
    if len(contact) < FEWEST:
        raise ValueError(f"contact: must be at least {FEWEST} points; got {len(contact)}.")
    fewest = max(FEWEST, len(contact) // SHARE)
    for halves in (_inner_half, _halves):  # first the middle, which is farthest from all edges
        kept = contact, n
        found = _fitted(*kept, contact_error, normal_error)
        while not found.fits and len(kept[0]) >= 2 * fewest:
            tried = []
            for half in halves(found.place):
                part = kept[0][half], kept[1][half]
                tried.append((_fitted(*part, contact_error, normal_error), part))
                if tried[-1][0].fits:
                    break
            found, kept = min(tried, key=lambda one: one[0].misfit)
        if found.fits:
            break
    return found


def _inner_half(place):
    """Yield which of some places (n, 2) are in the inner half."""
    away = np.sum(((place - place.mean(axis=0)) / np.ptp(place, axis=0)) ** 2, axis=-1)
    yield away <= np.median(away)


def _halves(place):
    """Yield which of some places (n, 2) are in the inner half, then which on a side of a line."""
    yield from _inner_half(place)
    place = (place - place.mean(axis=0)) / np.ptp(place, axis=0)
    for side in SIDES:
        along = place @ [np.cos(side), np.sin(side)]
        yield along <= np.median(along)


def _fitted(contact, n, contact_error, normal_error):
    """Return the fit to all of some points and normals."""
    axes = mean_frame(n)
    origin = contact.mean(axis=0)
    local = (contact - origin) @ axes.T
    if np.ptp(local[:, :2], axis=0).min() == 0:
        raise ValueError("contact: must not lie on a line along the mean normal, or at one place.")
    n = n @ axes.T
    reach = np.abs(local[:, :2]).max()
    off = max(contact_error, ROUNDING * reach)
    matrix, right = _equations(local, n, reach, off, max(normal_error, ROUNDING))
    q, root = np.linalg.qr(matrix)
    image = q.T @ right  # its squares are by how much each coefficient lessens what is left
    left = np.sum((right - q @ image) ** 2)
    free = len(right) - len(image)
    # A sum of as many squares of noise is their number, give or take the root of twice that.
    steep = n[:, 2].min() <= STEEP
    fits = not steep and left < free + UNLIKELY * np.sqrt(2 * free)
    degree = _degree(image)
    count = _count(degree)
    root = root[:count, :count]
    c = np.linalg.solve(root, image[:count])
    misfit = np.inf if steep else np.sqrt(left / free)
    return Fit(origin, axes, reach, degree, c, root, local[:, :2], misfit, bool(fits))


def _equations(local, n, reach, contact_error, normal_error):
    """Return the matrix and the right side of z's equations, over their errors.

    A normal that turns by a small angle changes the slope along the gradient by that times
    1 + |gradient|^2, and the slope across by that times the root.
    """
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
    """Return the least degree that noise allows, and some more."""
    gain = np.cumsum(image[::-1] ** 2)[::-1]  # of all coefficients from each one on
    for degree in range(LEAST_DEGREE, MOST_DEGREE):
        first = _count(degree)
        more = len(image) - first
        if gain[first] < more + UNLIKELY * np.sqrt(2 * more):
            break
    return min(degree + MORE, MOST_DEGREE)


def _count(degree):
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
