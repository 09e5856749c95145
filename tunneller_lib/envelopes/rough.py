"""What rounding may do to a surface's derivatives, found by rounding at random.

The same jets are computed several times, with every operand of every operation of the caller's
function changed at random in its last digit. The results scatter as far as rounding can take them
(Vignes, Mathematics and Computers in Simulation 35, 1993, p. 233). Bounds by interval arithmetic
are a million times too wide here, since a jet's coefficients depend on each other.
"""

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from .adapted import frames_by
from .jet import Jet, jet_variables

UNIT = np.finfo(float).eps
RUNS = 8
SAFETY = 10.0  # of the largest deviation that was seen


class RoughJet(Jet):
    """A jet whose coefficients are changed in their last digits whenever they are used.

    Parameters
    ----------
    c : (15, ...) float
        Coefficients, as those of `Jet`.
    rng : numpy.random.Generator
        Draws the digits.
    """

    def __init__(self, c, rng):
        super().__init__(c)
        self.rng = rng

    # Operators go by way of numpy, as functions do: those of `Jet` would change nothing.
    __add__ = NDArrayOperatorsMixin.__add__
    __radd__ = NDArrayOperatorsMixin.__radd__
    __sub__ = NDArrayOperatorsMixin.__sub__
    __rsub__ = NDArrayOperatorsMixin.__rsub__
    __mul__ = NDArrayOperatorsMixin.__mul__
    __rmul__ = NDArrayOperatorsMixin.__rmul__
    __truediv__ = NDArrayOperatorsMixin.__truediv__
    __rtruediv__ = NDArrayOperatorsMixin.__rtruediv__

    def __array_ufunc__(self, ufunc, method, *arguments, **options):
        arguments = [self._turned(a) if isinstance(a, Jet) else a for a in arguments]
        result = super().__array_ufunc__(ufunc, method, *arguments, **options)
        return RoughJet(result.c, self.rng) if isinstance(result, Jet) else result

    def _turned(self, jet):
        return Jet(jet.c * (1 + UNIT * self.rng.uniform(-1, 1, jet.c.shape)))


def rough_frames(surface, s, t, model, order):
    """Return frames of a surface at n points, `RUNS` times over, each time rounded at random.

    Parameters
    ----------
    surface : callable
        As for `adapted_frames`.
    s, t : (n,) float
        Points.
    model : {"isotropic", "space"}
        As for `adapted_frames`.
    order : int
        Of the jets, 4 or 5.

    Returns
    -------
    frames : AdaptedFrames
        At `RUNS` n points, those of one run after another.
    """
    rng = np.random.default_rng(RUNS)
    jets = jet_variables(np.tile(s, RUNS), np.tile(t, RUNS), order=order)
    return frames_by(surface, *(RoughJet(jet.c, rng) for jet in jets), model)


def errors(jet):
    """Return a jet of the errors of coefficients that were found `RUNS` times over, n at a time."""
    every = jet.c.reshape(len(jet.c), RUNS, -1)
    middle = np.median(every, axis=1)
    away = np.abs(every - middle[:, None]).max(axis=1)
    return Jet(SAFETY * away + UNIT * np.abs(middle))


def scatter(values):
    """Return the errors (n, m) of values (RUNS n, m) that were found `RUNS` times over."""
    every = values.reshape(RUNS, -1, values.shape[-1])
    return SAFETY * np.abs(every - np.median(every, axis=0)).max(axis=0)
