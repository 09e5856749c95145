"""What the points of a surface say for or against a tool, when all numbers have errors.

A tool envelops a surface if two forms of a direction, `first` and `second`, have a common zero at
each point. Their errors leave a zero of `first` uncertain by an angle, and so the value of `second`
there by a bound. A point refutes the tool where that value exceeds the bound at every zero. It
agrees where at some zero the value is within the bound and the bound is small. Else it doesn't
tell.
"""

from typing import NamedTuple

import numpy as np

from .adapted import frames_by
from .circle_roots import Waves, real_zeros
from .jet import Jet, jet_variables

LEAST_POINTS = 12  # so many must agree
SHARP = 1e-6  # relative bound of a condition above which a point doesn't tell
UNIT = np.finfo(float).eps
RUNS = 8
SAFETY = 10.0  # errors are so many times the largest deviation that was seen
_AROUND = 2 * np.pi * np.arange(24)[None] / 24


class Forms(NamedTuple):
    """Two conditions on a direction, at n points.

    Parameters
    ----------
    first, second : callable
        Of angles (n, m), in rad: values (n, m) of trigonometric polynomials, in m.
    degree : int
        Of the first; the second's is at most 8.
    off_first, off_second : (n,) float
        By how much they may be off, in m.
    size : callable
        Of angles (n, m): what the second is compared with there (n, m), in m.
    """

    first: object
    second: object
    degree: int
    off_first: np.ndarray
    off_second: np.ndarray
    size: object


class Evidence(NamedTuple):
    """What n points say about a pair of forms.

    Parameters
    ----------
    refutes, agrees : (n,) bool
        Whether a point does; neither if it doesn't tell.
    angle, spread : (n, m) float
        Common zeros and how far they may be off, in rad; NaN where there is none.
    several : (n, m) bool
        Whether more zeros of the first form may have fallen together there.
    """

    refutes: np.ndarray
    agrees: np.ndarray
    angle: np.ndarray
    spread: np.ndarray
    several: np.ndarray


def zeros(function, degree, off):
    """Return where polynomials with errors may vanish, and how far these zeros may be off.

    Parameters
    ----------
    function : callable
        As for `real_zeros`.
    degree : int
        Their degree d.
    off : (n,) float
        By how much their values may be off.

    Returns
    -------
    angle, spread : (n, 4 d) float
        In rad, NaN where there is none.
    several : (n, 4 d) bool
        Whether the zero may be a multiple one.
    """
    waves = Waves(function, degree)
    off = off[:, None]
    unit = waves.most(0)[:, 0]
    angle, _ = real_zeros(function, degree, unit=unit)
    # Where rounding has taken a pair off the real line the polynomial nearly touches zero.
    turning, _ = real_zeros(lambda a: waves.derivative(a + 0 * unit[:, None], 1), degree, unit=unit)
    near = np.abs(waves.derivative(turning, 0)) <= 2 * off
    angle = np.hstack([angle, np.where(near, turning, np.nan)])
    value, slope, bend, third = (np.abs(waves.derivative(angle, k)) for k in range(4))
    off = off + value  # two zeros that nearly fall together come as one amid them, which is none
    # A polynomial that is off by e has its zero off by e/slope if it is simple, by the square root
    # of 2 e/bend if it is double, by the cube root of 6 e/third if it is triple. The factors leave
    # room for what the next derivative does on that way.
    with np.errstate(divide="ignore", invalid="ignore"):
        simple = 4 * off / slope
        double = 2 * np.sqrt(8 * off / bend) + 4 * slope / bend
        triple = 2 * np.cbrt(24 * off / third) + 4 * np.sqrt(2 * slope / third) + 4 * bend / third
        # 0 times infinity is NaN, for which no comparison holds: then the next case is taken.
        single = bend * simple + third * simple**2 <= slope
        spread = np.where(single, simple, np.where(third * double <= bend, double, triple))
    spread = np.where(np.isfinite(spread), np.minimum(spread, np.pi), np.pi)
    return angle, np.where(np.isnan(angle), np.nan, spread), ~single & ~np.isnan(angle)


def weigh(forms, sharp):
    """Return what each point says about a pair of forms.

    Parameters
    ----------
    forms : Forms
        At n points.
    sharp : float
        Relative bound of the second form above which a point doesn't tell.

    Returns
    -------
    evidence : Evidence
        Of each point.
    """
    angle, spread, several = zeros(forms.first, forms.degree, forms.off_first)
    second = Waves(forms.second, 8)
    value = np.abs(second.derivative(angle, 0))
    bound = forms.off_second[:, None] + 2 * np.abs(second.derivative(angle, 1)) * spread
    bound = bound + second.most(2) * spread**2
    known = ~np.isnan(angle)
    common = known & (value <= bound)
    size = forms.size(angle)
    agrees = common & (bound <= sharp * size)
    # Where the first form vanishes altogether any direction would do: the point agrees where the
    # second does as well, as on a sphere, and else doesn't tell.
    whole = np.abs(forms.first(_AROUND)).max(axis=-1) <= 4 * forms.off_first
    rest = np.abs(forms.second(_AROUND)).max(axis=-1)
    everywhere = (rest <= 4 * forms.off_second) & (
        forms.off_second <= sharp * forms.size(_AROUND).max(axis=-1)
    )
    return Evidence(
        ~whole & ~common.any(axis=-1),
        np.where(whole, everywhere, agrees.any(axis=-1)),
        np.where(agrees, angle, np.nan),
        np.where(agrees, spread, np.nan),
        several & agrees,
    )


def spread_in_two(s, t, n):
    """Tell whether points are spread over a surface and don't lie on one curve.

    Parameters
    ----------
    s, t : (k,) float
        Values of the surface's two variables.
    n : (k, 3) float or None
        The unit normals, if they should turn in two directions.

    Returns
    -------
    spread : bool
        Whether neither the points (s, t) lie on a conic nor the normals on a circle, as they do
        along an orbit of a motion.
    """
    return not (_on_a_conic(s, t) or (n is not None and _on_a_circle(n)))


def _on_a_conic(s, t):
    """Tell whether places lie on a conic or a line: then a form of degree 2 vanishes on them."""
    s, t = ((c - c.mean()) / (np.ptp(c) or 1.0) for c in (s, t))
    forms = np.stack([np.ones_like(s), s, t, s * s, s * t, t * t], axis=-1)
    values = np.linalg.svd(forms, compute_uv=False)
    return bool(values[-1] < 1e-3 * values[0])


def _on_a_circle(n):
    """Tell whether normals lie in one plane, as they do along an orbit of a motion.

    Over a patch they leave each plane by about the square of its size.
    """
    values = np.linalg.svd(n - n.mean(axis=0), compute_uv=False) / np.sqrt(len(n))
    return bool(values[0] > 1e-6 and values[2] < 1e-3 * values[0] ** 2)


# ---- what rounding may do, found by rounding at random ------------------------------------------


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
