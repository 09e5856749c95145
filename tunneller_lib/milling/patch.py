"""A patch of a surface that is to be milled, with the side from which the tool comes."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, NotNegative, Reals, Sign, Whole, checked
from ..envelopes.functions import Function

Range = Array("(2,) float", also=("ascend", lambda ends: ends[0] < ends[1]))


@dataclass(frozen=True)
@checked
class Patch:
    """A surface over a rectangle of its parameters.

    Parameters
    ----------
    surface : callable
        Of two variables, for `hyperosculating_cones` with model="space": three coordinates, in m.
        What it raises itself passes through.
    s, t : (2,) float
        Least and greatest parameters.
    side : {1, -1}
        1 where the tool comes from the side to which the surface's normal r_s x r_t points.

    Examples
    --------
    >>> patch = Patch(lambda s, t: [s, t, s * t], (-1, 1), (-1, 1))
    >>> patch.mesh(3).shape
    (3, 3, 3)
    """

    surface: Function(2)
    s: Range
    t: Range
    side: Sign = 1

    @checked
    def parameters(self, n: Whole(1, 500), *, margin: NotNegative = 0.0):
        """Return a grid n by n of parameters.

        Parameters
        ----------
        n : int
            From 1 to 500.
        margin : float
            Share of the width that is left free at each border.

        Returns
        -------
        s, t : (n, n) float
            Parameters.
        """
        if margin >= 0.5:
            raise ValueError(f"margin: must be below 0.5; got {margin:g}.")
        where = np.linspace(margin, 1 - margin, n)
        (a, b), (c, d) = self.s, self.t
        # Rounding mustn't lead beyond the ends, where a surface may refuse to answer.
        s = np.clip(a + (b - a) * where, a, b)
        t = np.clip(c + (d - c) * where, c, d)
        return np.meshgrid(s, t, indexing="ij")

    @checked
    def points(self, s: Reals, t: Reals):
        """Return points (..., 3), in m, at parameters s, t (...)."""
        s, t = np.broadcast_arrays(s, t)
        parts = self.surface(s, t)
        return np.stack([np.broadcast_to(part, s.shape) for part in parts], axis=-1).astype(float)

    @checked
    def mesh(self, n: Whole(2, 500) = 121):
        """Return a grid (n, n, 3) of points, in m."""
        return self.points(*self.parameters(n))
