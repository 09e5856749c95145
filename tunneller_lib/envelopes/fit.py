"""Functions of two variables from measured tangent planes (Envelopes of cones, Example 32)."""

import numpy as np

from ..arguments import points, positive, whole
from ..exact import dot, norm
from .isotropic import plane_to_point

ROUNDS = 4  # of reweighting
_HUBER = 1.345 * 1.4826  # of the median: its efficiency is 95 % for normal errors


def tilted(n, turn, rng):
    """Return unit normals (..., 3), turned each in a random direction as Example 32 turns them.

    Parameters
    ----------
    n : (..., 3) float
        Unit normals.
    turn : float
        The document's r, the tangent of the angle.
    rng : numpy.random.Generator
        Where the directions come from.
    """
    n = points("n", n)
    aside = np.cross(rng.normal(size=n.shape), n)  # of a uniform direction
    n = n + turn * aside / norm(aside)[..., None]
    return n / norm(n)[..., None]


def mean_frame(n):
    """Return three unit vectors (3, 3), in rows, the third along the mean of normals (..., 3)."""
    third = points("n", n).reshape(-1, 3).mean(axis=0)
    third = third / norm(third)
    first = np.cross(np.eye(3)[np.argmin(np.abs(third))], third)
    first = first / norm(first)
    return np.array([first, np.cross(third, first), third])


def fit_planes(contact, n, *, scale, degree=6):
    """Return a polynomial f(x, y) through the points of tangent planes, for the isotropic model.

    Parameters
    ----------
    contact, n : (m, 3) float
        A point of each plane in m, and its normal, none near (0, 0, -1): see `mean_frame`.
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
        If there are fewer planes than coefficients, or an argument is out of shape.

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
    contact, n, scale = points("contact", contact), points("n", n), positive("scale", scale)
    degree = int(whole("degree", degree, 1, 20))
    planes = plane_to_point(n, -dot(n, contact))
    orders = [(i, k - i) for k in range(degree + 1) for i in range(k + 1)]
    if len(planes) < len(orders):
        raise ValueError(f"n: must hold at least {len(orders)} planes; got {len(planes)}.")
    px, py = (np.vander(c / scale, degree + 1, increasing=True).T for c in planes[:, :2].T)
    basis, z = np.stack([px[i] * py[j] for i, j in orders], axis=-1), planes[:, 2]
    weight = np.ones(len(z))
    for _ in range(ROUNDS):
        root = np.sqrt(weight)
        c = np.linalg.lstsq(root[:, None] * basis, root * z, rcond=None)[0]
        left = np.abs(basis @ c - z)
        weight = 1 / np.maximum(1, left / (_HUBER * np.median(left) + np.finfo(float).tiny))

    def f(x, y):
        return sum(
            a * (x / scale) ** i * (y / scale) ** j for a, (i, j) in zip(c, orders, strict=True)
        )

    return f, planes
