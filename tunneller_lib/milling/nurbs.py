"""Surfaces by control points, weights and knots."""

from dataclasses import dataclass
from math import factorial

import numpy as np

from ..arguments import LEAST, Array, checked
from ..envelopes.functions import Varying
from ..envelopes.jet import Jet

LEAST_DEGREE, MOST_DEGREE = 3, 9
Knots = Array("(k,) float", also=("not fall", lambda knots: np.all(np.diff(knots) >= 0)))


@dataclass(frozen=True, eq=False)
@checked
class Nurbs:
    """A rational tensor-product B-spline surface.

    Parameters
    ----------
    control : (n, m, 3) float
        Control points, in m.
    knots_s, knots_t : (k,) float
        Ascending. Their numbers are n or m plus the degree plus one, with degrees from 3 to 9.
    weights : (n, m) float, optional
        Of the control points, from 1e-100 to 1e100; 1 unless given.

    Raises
    ------
    ValueError
        If a shape, a degree, a weight or the knots' order is wrong, or an inner knot is repeated
        so often that the surface may have a crease.

    Notes
    -----
    With simple inner knots contact of third order needs degree 4, for continuous third
    derivatives, and the verdict on gouging needs degree 5. With less, the cones jump where a knot
    is crossed.

    Examples
    --------
    >>> line = np.linspace(0, 1, 4)
    >>> control = np.stack(np.broadcast_arrays(line[:, None], line, 0.0), axis=-1)
    >>> flat = Nurbs(control, [0] * 4 + [1] * 4, [0] * 4 + [1] * 4)
    >>> [float(c.round(3)) for c in flat.coordinates(0.25, 0.5)]
    [0.25, 0.5, 0.0]
    """

    control: Array("(n, m, 3) float", "m", last="x, y, z")
    knots_s: Knots
    knots_t: Knots
    weights: Array("(n, m) float", low=LEAST) | None = None

    def __post_init__(self):
        for name, count in zip(("knots_s", "knots_t"), self.control.shape[:2], strict=True):
            _check_knots(name, getattr(self, name), count)
        if self.weights is None:
            object.__setattr__(self, "weights", np.ones(self.control.shape[:2]))
        if self.weights.shape != self.control.shape[:2]:
            raise ValueError(
                f"weights: must be one a control point, {self.control.shape[:2]}; "
                f"got {self.weights.shape}."
            )

    @property
    def degrees(self):
        """Return the degrees by s and by t."""
        n, m, _ = self.control.shape
        return len(self.knots_s) - n - 1, len(self.knots_t) - m - 1

    @checked
    def coordinates(self, s: Varying, t: Varying):
        """Return the coordinates of points.

        A surface for `hyperosculating_cones` with model="space".

        Parameters
        ----------
        s, t : (...) float or Jet
            Parameters, within the domain.

        Returns
        -------
        x, y, z : (...) float or Jet
            In m.
        """
        from scipy.interpolate import NdBSpline

        at = np.broadcast_arrays(*(x.value if isinstance(x, Jet) else x for x in (s, t)))
        knots = self.knots_s, self.knots_t
        for name, x, row, degree in zip("st", at, knots, self.degrees, strict=True):
            low, high = row[degree], row[-degree - 1]
            wrong = ~((x >= low) & (x <= high))
            if np.any(wrong):
                got = x[wrong].flat[0]
                raise ValueError(f"{name}: must lie from {low:g} to {high:g}; got {got:g}.")
        weights = self.weights[..., None]
        # Of weighted points and weights together, over which the quotient is taken at the end.
        spline = NdBSpline(
            knots, np.concatenate([self.control * weights, weights], 2), self.degrees
        )
        places = np.stack(at, -1)
        jets = [x for x in (s, t) if isinstance(x, Jet)]
        if jets:
            # The spline's own derivatives make its Taylor polynomial in h and k, for which the
            # jets of s and t are put in, less their values, by Horner's rule.
            h, k = ((x if isinstance(x, Jet) else x + 0 * jets[0]) for x in (s, t))
            h, k = (Jet((x - x.value).c[..., None]) for x in (h, k))
            four = 0.0
            for i in range(h.order, -1, -1):
                row = 0.0
                for j in range(h.order - i, -1, -1):
                    by_order = spline(places, nu=(i, j)) / (factorial(i) * factorial(j))
                    row = row * k + by_order
                four = four * h + row
            x, y, z, w = (Jet(part) for part in np.moveaxis(four.c, -1, 0))
        else:
            x, y, z, w = np.moveaxis(spline(places), -1, 0)
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
