"""Surfaces by control points, weights and knots, and such surfaces through grids of points."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Rule, Whole, bounded_array, checked, near_points
from ..envelopes.functions import Varying
from ..envelopes.jet import Jet, compose, places
from ..kernels.exact import norm

LEAST_DEGREE, MOST_DEGREE = 3, 9
MOST_CONTROL = 200  # points each way


def _grid(name, value):
    points = near_points(name, value)
    if points.ndim != 3:
        raise ValueError(f"{name}: must be a grid (n, m, 3); got {points.shape}.")
    return points


def _row(name, value):
    array = bounded_array(name, value)
    if array.ndim != 1 or np.any(np.diff(array) < 0):
        raise ValueError(f"{name}: must be numbers in a row that don't fall; got {array.shape}.")
    return array


# What arguments may be, in this room and above it.
Grid = Annotated[ArrayLike, Rule("(n, m, 3) float", _grid, "m")]
Row = Annotated[ArrayLike, Rule("(k,) float", _row)]
Weights = Annotated[ArrayLike, Rule("(n, m) float", bounded_array)]


@dataclass(frozen=True, eq=False)
@checked
class Nurbs:
    """A rational tensor-product B-spline surface.

    Parameters
    ----------
    control : (n, m, 3) float
        Control points, in m.
    knots_s, knots_t : (k,) float
        Ascending; n and m of them and the degree and one more, which gives the degrees, 3 to 9.
    weights : (n, m) float, optional
        Of the control points, above zero; 1 unless given.

    Raises
    ------
    ValueError
        If a shape, a degree, a weight or the order of knots isn't such, or an inner knot is
        repeated so often that the surface may have a crease.

    Notes
    -----
    Contact of third order asks for third derivatives that are continuous, so for degree 4, and the
    verdict on gouging for fourth ones, so for degree 5, with simple inner knots. With less, the
    cones jump where a knot is crossed.

    Examples
    --------
    >>> line = np.linspace(0, 1, 4)
    >>> control = np.stack(np.broadcast_arrays(line[:, None], line, 0.0), axis=-1)
    >>> flat = Nurbs(control, [0] * 4 + [1] * 4, [0] * 4 + [1] * 4)
    >>> [float(c.round(3)) for c in flat.coordinates(0.25, 0.5)]
    [0.25, 0.5, 0.0]
    """

    control: Grid
    knots_s: Row
    knots_t: Row
    weights: Weights | None = None

    def __post_init__(self):
        if max(self.control.shape) > MOST_CONTROL:
            raise ValueError(
                f"control: must be at most {MOST_CONTROL} points each way; "
                f"got {self.control.shape[:2]}."
            )
        for name, count in zip(("knots_s", "knots_t"), self.control.shape[:2], strict=True):
            _check_knots(name, getattr(self, name), count)
        if self.weights is None:
            object.__setattr__(self, "weights", np.ones(self.control.shape[:2]))
        if self.weights.shape != self.control.shape[:2] or not np.all(self.weights > 0):
            raise ValueError(
                f"weights: must be above zero, one a control point {self.control.shape[:2]}; "
                f"got {self.weights.shape}."
            )

    @property
    def degrees(self):
        """Return the degrees by s and by t."""
        n, m, _ = self.control.shape
        return len(self.knots_s) - n - 1, len(self.knots_t) - m - 1

    @property
    def domain(self):
        """Return the least and the greatest s, and those of t, as two pairs."""
        knots = self.knots_s, self.knots_t
        return tuple(
            (float(k[d]), float(k[-d - 1])) for k, d in zip(knots, self.degrees, strict=True)
        )

    @checked
    def coordinates(self, s: Varying, t: Varying):
        """Return the coordinates of points, a surface for `hyperosculating_cones` in space.

        Parameters
        ----------
        s, t : (...) float or Jet
            Parameters, within the domain.

        Returns
        -------
        x, y, z : (...) float or Jet
            In m.
        """
        jets = isinstance(s, Jet) or isinstance(t, Jet)
        at = [part.value if isinstance(part, Jet) else np.asarray(part) for part in (s, t)]
        for name, value, (low, high) in zip("st", at, self.domain, strict=True):
            wrong = ~((value >= low) & (value <= high))
            if np.any(wrong):
                got = value[wrong].flat[0]
                raise ValueError(f"{name}: must lie from {low:g} to {high:g}; got {got:g}.")
        at = np.broadcast_arrays(*at)
        if not jets:
            x, y, z, w = self._derivative(*at, 0, 0)
            return [x / w, y / w, z / w]
        like = s if isinstance(s, Jet) else t
        s, t = (part if isinstance(part, Jet) else part + 0 * like for part in (s, t))
        order = places(s)
        c = np.zeros((4, len(order), *at[0].shape))
        taylor = self._taylor(*at, max(i for i, _ in order))
        for (i, j), place in order.items():
            c[:, place] = taylor[i, j]
        x, y, z, w = compose([Jet(part) for part in c], s - s.value, t - t.value)
        return [x / w, y / w, z / w]

    def _homogeneous(self):
        return np.concatenate([self.control * self.weights[..., None], self.weights[..., None]], -1)

    def _derivative(self, s, t, i, j):
        """Return a derivative of x w, y w, z w and w, an array (4, ...)."""
        by_s = _basis(self.knots_s, self.degrees[0], s.ravel(), i)
        by_t = _basis(self.knots_t, self.degrees[1], t.ravel(), j)
        values = np.einsum(
            "kpm,km->pk", np.tensordot(by_s, self._homogeneous(), 1).swapaxes(1, 2), by_t
        )
        return values.reshape(4, *s.shape)

    def _taylor(self, s, t, order):
        """Return the coefficients (4, ...) of h^i k^j, by i and j."""
        every = self._homogeneous()
        by_t = [_basis(self.knots_t, self.degrees[1], t.ravel(), j) for j in range(order + 1)]
        found = {}
        factor = np.cumprod([1.0, *range(1, order + 1)])
        for i in range(order + 1):
            by_s = _basis(self.knots_s, self.degrees[0], s.ravel(), i)
            rows = np.tensordot(by_s, every, 1)
            for j in range(order + 1 - i):
                values = np.einsum("kmp,km->pk", rows, by_t[j]) / (factor[i] * factor[j])
                found[i, j] = values.reshape(4, *s.shape)
        return found


def _check_knots(name, knots, count):
    """Raise ValueError where knots of `count` control points make no smooth surface."""
    degree = np.size(knots) - count - 1
    if not LEAST_DEGREE <= degree <= MOST_DEGREE or count <= degree:
        raise ValueError(
            f"{name}: must be for a degree from {LEAST_DEGREE} to {MOST_DEGREE}, below the number "
            f"of control points; got {np.size(knots)} knots for {count} points: degree {degree}."
        )
    low, high = knots[degree], knots[-degree - 1]
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        raise ValueError(f"{name}: must ascend; got {knots[0]:g} to {knots[-1]:g}.")
    inner = knots[(knots > low) & (knots < high)]
    if len(inner) and np.unique(inner, return_counts=True)[1].max() > degree - 1:
        raise ValueError(
            f"{name}: must not repeat an inner knot more than {degree - 1} times, for a surface "
            f"without creases; got one that is."
        )


def _basis(knots, degree, x, order):
    """Return derivatives of all B-splines (k, n) at places x (k,)."""
    from scipy.interpolate import BSpline

    count = len(knots) - degree - 1
    if order > degree:
        return np.zeros((len(x), count))
    return BSpline(knots, np.eye(count), degree)(x, nu=order)


@checked
def fit_nurbs(
    points: Grid,
    s: Row,
    t: Row,
    *,
    count: Whole(4, MOST_CONTROL) = 20,
    degree: Whole(LEAST_DEGREE, MOST_DEGREE) = 5,
):
    """Return a B-spline surface through a grid of points, by least squares, and its worst error.

    Parameters
    ----------
    points : (n, m, 3) float
        A grid, in m.
    s, t : (k,) float
        Its parameters (n,) and (m,), ascending.
    count : int
        Control points each way, more than the degree, at most as many as points.
    degree : int
        From 3 to 9.

    Returns
    -------
    fit : Nurbs
        With simple inner knots at equal steps.
    error : float
        The longest distance of a point from the surface's at its parameters, in m.

    Raises
    ------
    ValueError
        If the points are no grid, or its parameters don't ascend or are too few.

    Examples
    --------
    >>> s = np.linspace(0, 1, 30)
    >>> x, y = np.meshgrid(s, s, indexing="ij")
    >>> fit, error = fit_nurbs(np.stack([x, y, x * y], axis=-1), s, s, count=8)
    >>> fit.degrees, error < 1e-12
    ((5, 5), True)
    """
    from scipy.interpolate import make_lsq_spline

    if count <= degree:
        raise ValueError(f"count: must be above the degree {degree}; got {count}.")
    knots = []
    for name, x, n in zip("st", (s, t), points.shape, strict=False):
        if x.shape != (n,) or n < count or not np.all(np.diff(x) > 0):
            raise ValueError(
                f"{name}: must be {n} ascending parameters, {count} or more; got {x.shape}."
            )
        inner = np.linspace(x[0], x[-1], count - degree + 1)
        knots.append(np.r_[[x[0]] * degree, inner, [x[-1]] * degree])
    try:
        rows = make_lsq_spline(s, points, knots[0], degree).c
        control = make_lsq_spline(t, rows.swapaxes(0, 1), knots[1], degree).c.swapaxes(0, 1)
    except (ValueError, np.linalg.LinAlgError):
        raise ValueError(
            f"s, t: must have points between all of the {count - degree} knots; got none in some."
        ) from None
    fit = Nurbs(control, *knots)
    back = np.stack(fit.coordinates(*np.meshgrid(s, t, indexing="ij")), axis=-1)
    return fit, float(norm(back - points).max())
