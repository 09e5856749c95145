"""Functions of two variables from measured tangent planes (Envelopes of cones, Example 32)."""

import numpy as np

from ..arguments import LEAST, MOST, Directions, Number, Points, Positive, Whole, checked
from ..kernels.exact import dot, norm
from .functions import Centre, Function, UnitVectors
from .isotropic import normal, plane_to_point, surface_points

ROUNDS = 4  # of reweighting
Slope = Number(-MOST, MOST)
_HUBER = 1.345 * 1.4826  # of the median: its efficiency is 95 % for normal errors


@checked
def tilted(n: UnitVectors, turn: Slope, rng: np.random.Generator):
    """Return unit normals (..., 3), turned each in a random direction as Example 32 turns them.

    Parameters
    ----------
    n : (..., 3) float
        Unit normals.
    turn : float
        The document's r, the tangent of the angle.
    rng : numpy.random.Generator
        Where the directions come from.

    Returns
    -------
    tilted : (..., 3) float
        Unit normals.
    """
    aside = np.cross(rng.normal(size=n.shape), n)  # of a uniform direction
    n = n + turn * aside / norm(aside)[..., None]
    return n / norm(n)[..., None]


@checked
def noisy_planes(
    f: Function(2),
    place: Centre,
    rng: np.random.Generator,
    *,
    turn: Slope,
    count: Whole(1, 100_000),
    reach: Positive,
):
    """Return planes of a graph about a place of the model, as points and turned normals.

    Parameters
    ----------
    f : callable
        Of x and y, in m. What it raises itself passes through.
    place : (2,) float
        The middle of the disk over which they lie.
    rng : numpy.random.Generator
        Draws places and turns.
    turn : float
        Of each normal, as for `tilted`.
    count : int
        How many.
    reach : float
        Radius of the disk.

    Returns
    -------
    contact : (count, 3) float
        Where the planes touch the surface before they turn, in m.
    n : (count, 3) float
        Unit normals.
    """
    angle = 2 * np.pi * rng.random(count)
    away = reach * np.sqrt(rng.random(count))
    x, y = np.array(place)[:, None] + away * np.array([np.cos(angle), np.sin(angle)])
    n = np.stack(normal(x, y), axis=-1)
    return surface_points(f, x, y), tilted(n, turn, rng)


@checked
def mean_frame(n: Directions):
    """Return a frame that stands on the mean of normals.

    Parameters
    ----------
    n : (..., 3) float
        Normals.

    Returns
    -------
    axes : (3, 3) float
        Three unit vectors in rows, the third along the mean.

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


@checked
def fit_planes(contact: Points, n: Directions, *, scale: Positive, degree: Whole(1, 20) = 6):
    """Return a polynomial f(x, y) through the points of tangent planes, for the isotropic model.

    Parameters
    ----------
    contact, n : (..., 3) float
        A point of each plane in m, and its normal, none near (0, 0, -1): see `mean_frame`. There
        are m planes.
    scale : float
        Size of the patch in the model, by which x and y are divided.
    degree : int
        Of the polynomial, from 1 to 20.

    Returns
    -------
    f : callable
        Of two numbers, arrays or jets; values in m.
    planes : (m, 3) float
        The planes' points.

    Raises
    ------
    ValueError
        If there are fewer planes than coefficients, one of them has no point in the model, or
        the patch reaches farther than a hundred times the scale.

    Notes
    -----
    Least squares of the heights alone, weighted anew `ROUNDS` times by Huber's rule: a plane that
    turns about its point of contact by r moves along the graph by r, and off it by r^2.

    Examples
    --------
    >>> n = np.array([[i, j, 2.0] for i in range(3) for j in range(3)])
    >>> f, _ = fit_planes(np.full((9, 3), 2.0), n, scale=1.0, degree=2)  # through one point
    >>> bool(np.isclose(f(0.0, 0.0), -1))
    True
    """
    planes = plane_to_point(n, -dot(n, contact)).reshape(-1, 3)
    # All products x^i y^j of the degree or less, the lower degrees first.
    orders = [(i, k - i) for k in range(degree + 1) for i in range(k + 1)]
    if len(planes) < len(orders):
        raise ValueError(f"n: must hold at least {len(orders)} planes; got {len(planes)}.")
    place = planes[:, :2]
    reach = np.abs(place).max()
    if reach > 100 * scale:  # whose powers of the degree 20 would drown all others
        raise ValueError(
            f"scale: must be at least a hundredth of the patch's reach {reach:g}; got {scale:g}."
        )
    px, py = (np.vander(c / scale, degree + 1, increasing=True).T for c in place.T)
    basis = np.stack([px[i] * py[j] for i, j in orders], axis=-1)
    z = planes[:, 2]
    weight = np.ones(len(z))
    for _ in range(ROUNDS):
        # Weighted squares are the squares of rows scaled by the weights' roots.
        root = np.sqrt(weight)
        c = np.linalg.lstsq(root[:, None] * basis, root * z, rcond=None)[0]
        left = np.abs(basis @ c - z)
        # Huber's rule: full weight up to a bound, beyond it a weight by which the plane counts as
        # its distance, no more as the square. Where most planes fit exactly the bound is nothing.
        bound = _HUBER * np.median(left) + np.finfo(float).tiny
        with np.errstate(over="ignore"):
            weight = 1 / np.maximum(1, left / bound)

    def f(x, y):
        return sum(
            a * (x / scale) ** i * (y / scale) ** j for a, (i, j) in zip(c, orders, strict=True)
        )

    return f, planes
