"""Surfaces by control points, weights and knots."""

from dataclasses import dataclass
from math import factorial
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Rule, bounded_array, checked, near_points
from ..envelopes.functions import Varying
from ..envelopes.jet import Jet, compose, places

LEAST_DEGREE, MOST_DEGREE = 3, 9


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
        at = [part.value if isinstance(part, Jet) else np.asarray(part) for part in (s, t)]
        for name, value, (low, high) in zip("st", at, self.domain, strict=True):
            wrong = ~((value >= low) & (value <= high))
            if np.any(wrong):
                got = value[wrong].flat[0]
                raise ValueError(f"{name}: must lie from {low:g} to {high:g}; got {got:g}.")
        at = np.broadcast_arrays(*at)
        jet = next((part for part in (s, t) if isinstance(part, Jet)), None)
        order = [(0, 0)] if jet is None else list(places(jet))
        every = np.concatenate([self.control * self.weights[..., None], self.weights[..., None]], 2)
        by_s, by_t = (
            [_basis(knots, degree, x.ravel(), i) for i in range(1 + max(i for i, _ in order))]
            for knots, degree, x in zip((self.knots_s, self.knots_t), self.degrees, at, strict=True)
        )
        c = [np.einsum("ka,abp,kb->pk", by_s[i], every, by_t[j], optimize=True) for i, j in order]
        c = np.stack(c, axis=1).reshape(4, len(order), *at[0].shape)
        if jet is None:
            x, y, z, w = c[:, 0]
        else:
            s, t = (part if isinstance(part, Jet) else part + 0 * jet for part in (s, t))
            x, y, z, w = compose([Jet(part) for part in c], s - s.value, t - t.value)
        return [x / w, y / w, z / w]


def _check_knots(name, knots, count):
    """Raise ValueError where knots of `count` control points make no smooth surface."""
    degree = len(knots) - count - 1
    if not LEAST_DEGREE <= degree <= min(MOST_DEGREE, count - 1):
        raise ValueError(
            f"{name}: must be for a degree from {LEAST_DEGREE} to {MOST_DEGREE}, below the number "
            f"of control points; got {len(knots)} knots for {count} points: degree {degree}."
        )
    low, high = knots[degree], knots[-degree - 1]
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        raise ValueError(f"{name}: must ascend; got {knots[0]:g} to {knots[-1]:g}.")
    inner = knots[(knots > low) & (knots < high)]
    if np.any(inner[degree - 1 :] == inner[: 1 - degree]):
        raise ValueError(
            f"{name}: must not repeat an inner knot more than {degree - 1} times, for a surface "
            f"without creases; got one that is."
        )


def _basis(knots, degree, x, order):
    """Return the coefficients of h^order of all B-splines (k, n) at places x (k,) and h beside."""
    from scipy.interpolate import BSpline

    count = len(knots) - degree - 1
    if order > degree:
        return np.zeros((len(x), count))
    return BSpline(knots, np.eye(count), degree)(x, nu=order) / factorial(order)
