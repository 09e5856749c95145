"""Which moving tool envelops a surface: differential tests of six classes (Envelopes, 2 to 8)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments import Finite, Reals, checked
from .adapted import FLAT, adapted_frames, isotropic_jet, sound, tangent_graph
from .circle_roots import real_zeros
from .forms import derivative_along, frobenius
from .functions import Function, HalfAngle, Shift
from .hyperosculate import order_four, third_order
from .jet import derivative

LEAST_POINTS = 12
IS_NOT = 1e-3  # a residual above it
TORSAL = 1e-10  # |K|/|II|^2, below which a point has a ruling without more ado
NEEDLE = 1e-4  # rad, a cone sharper than this, or as blunt, is not looked for
UMBILIC = 1e-9  # relative difference of principal radii, below which they count as equal
TRIALS = 4  # points whose own solutions are tried as a common radius or angle


@dataclass(frozen=True)
class Recognition:
    """What `recognise` finds.

    Parameters
    ----------
    kind : str
        The class asked for.
    verdict : {"is", "is not", "undecided"}
        The residual below the tolerance, above 1e-3, or between.
    residual : float
        0 to 1: the worst point's.
    radius : float or None
        Radius given or found, in m: of the cylinder or the pipe, positive where the surface's
        normals point to the axis.
    half_angle : float or None
        Half-angle of the cone given or found, in rad.
    """

    kind: str
    verdict: str
    residual: float
    radius: float | None = None
    half_angle: float | None = None


@checked
def recognise(
    surface: Function(2),
    s: Reals,
    t: Reals,
    kind: Literal["developable", "ruled", "cylinder", "channel", "pipe", "cone"],
    *,
    radius: Shift | None = None,
    half_angle: HalfAngle | None = None,
    model: Literal["isotropic", "space"] = "isotropic",
    tolerance: Finite = 1e-8,
):
    """Return whether a surface belongs to a class of envelopes, judged by its derivatives.

    Parameters
    ----------
    surface : callable
        A function of two variables, built from ordinary arithmetic and numpy's functions. What
        it raises itself passes through.
    s, t : (...) float
        At least 12 different points, values of these two variables.
    kind : {"developable", "ruled", "cylinder", "channel", "pipe", "cone"}
        Envelope of planes; union of lines; envelope of congruent cylinders of revolution,
        of spheres, of congruent spheres, of congruent cones of revolution.
    radius : float, optional
        Of the cylinders or spheres, in m, positive where the normals point to the axis; looked
        for unless given.
    half_angle : float, optional
        Of the cones, in rad, between 0 and pi/2; looked for from 1e-4 on unless given.
    model : {"isotropic", "space"}
        As for `hyperosculating_cones`.
    tolerance : float
        Residual below which the verdict is "is": 1e-8 for exact functions, 1e-4 for fits.

    Returns
    -------
    found : Recognition
        Verdict, residual, radius and half-angle.

    Raises
    ------
    ValueError
        If `surface` is no function of two variables or returns something else; if there are
        fewer points, one where the surface isn't defined and smooth, or, for all
        kinds but the first two, one of Gaussian curvature 0 or infinite, where planes are no model
        of it, or with derivatives above 1e90; or if an option doesn't belong to the kind or is out
        of range.

    Notes
    -----
    Envelopes of cones, Theorems 2, 4 and 16, Corollaries 25, 28 and 29, in the adapted frame. The
    residual of a point is the least over the directions that solve the lower-order conditions;
    terms are compared with their own sizes, so that it has no unit. For cylinders and cones it
    is what the corollaries ask, which for cylinders and channels they prove in one direction only
    (Problem 30). A developable surface counts as ruled. A surface may be enveloped by cones of
    several angles, as those of revolution are: one that fits best is returned.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.meshgrid([0.3, 0.5, 0.7], [0.2, 0.4, 0.6, 0.8])
    >>> found = recognise(lambda x, y: y**2 / (x**2 + y**2), x, y, "cone", half_angle=0.5)
    >>> found.verdict
    'is'
    """
    s, t = np.broadcast_arrays(s, t)
    different = len({*zip(s.flat, t.flat, strict=True)})
    if different < LEAST_POINTS:  # one residual of zero proves nothing
        raise ValueError(
            f"s, t: must hold at least {LEAST_POINTS} different points; got {different}."
        )
    if not 0 < tolerance <= IS_NOT:
        raise ValueError(f"tolerance: must be above 0, at most {IS_NOT}; got {tolerance!r}.")
    if radius is not None and kind not in ("cylinder", "pipe"):
        raise ValueError(f"radius: belongs to cylinder and pipe only; got it with {kind!r}.")
    if half_angle is not None and kind != "cone":
        raise ValueError(f"half_angle: belongs to cone only; got it with {kind!r}.")
    found = adapted_frames.unchecked(surface, s, t, model)
    if not found.smooth.all():
        i = np.argmin(found.smooth)
        raise ValueError(
            "surface: must be defined and smooth at every point; got one that isn't "
            f"at ({s.flat[i]}, {t.flat[i]})."
        )
    if kind == "developable":
        return _recognition(kind, float(found.curvature.max()), tolerance)
    if kind == "ruled":
        # Where K = 0 there is a ruling without more ado, and no second asymptotic direction.
        g = tangent_graph(found, found.curvature > TORSAL)
        _check_sound(g)
        return _recognition(kind, _ruled(g), tolerance)
    if (found.curvature <= FLAT).any():
        i = np.argmin(found.curvature)
        raise ValueError(
            f"surface: must have a Gaussian curvature not 0 nor infinite for {kind}; "
            f"got one at ({s.flat[i]}, {t.flat[i]})."
        )
    f = isotropic_jet(found, slice(None))
    _check_sound(f)
    if kind == "cone":
        residual, half_angle = _cone(f, half_angle)
        return _recognition(kind, residual, tolerance, half_angle=half_angle)
    residual, radius = _OF_RADIUS[kind](f, radius)
    return _recognition(kind, residual, tolerance, radius=radius)


def _check_sound(jet):
    if not sound(jet).all():
        raise ValueError(
            "surface: must have derivatives of at most 1e90 in size at every point; got more."
        )


def _recognition(kind, residual, tolerance, **found):
    if residual < tolerance:
        verdict = "is"
    elif residual > IS_NOT:
        verdict = "is not"
    else:
        verdict = "undecided"
    return Recognition(kind, verdict, residual, **found)


def _ruled(g):
    """Theorem 4 on the graphs over the tangent planes: g_ee = g_eee = 0."""
    return float(_line_contact(g, 0.0, frobenius(g, 2) ** 2).max(initial=0.0))


def _line_contact(f, value, beside):
    """Return the least residual of f_ee = value, f_eee = 0 over directions e, at each point."""
    low, high, turn = _principal(f)
    # f_ee = low cos^2 + high sin^2; where `value` is out of reach, the nearest that is within.
    square = np.clip((value - low) / _nonzero(high - low), 0, 1)
    half = np.arcsin(np.sqrt(square))
    # Where the two directions nearly fall together they are known to the root of rounding only;
    # the eigenvector is their limit.
    limit = np.where(square < 0.5, 0.0, np.pi / 2)
    angle = turn[:, None] + np.stack([half, -half, limit], axis=-1)
    # Each condition over what it could be at most, so that a direction fails by the worse of them.
    most = frobenius(f, 2) + 2 * abs(value)
    second = np.abs(derivative_along(f, angle, 2) - value) / _nonzero(most)[:, None]
    most = frobenius(f, 3) + beside
    third = np.abs(derivative_along(f, angle, 3)) / _nonzero(most)[:, None]
    return np.min(np.maximum(second, third), axis=-1)


def _cylinder(f, radius):
    """Eqs 23, 24 and 11: f_ee = 2 R and f_eee = 0."""

    def residual(radius):
        return float(np.max(_line_contact(f, 2 * radius, frobenius(f, 2))))

    if radius is not None:
        return residual(radius), radius
    # A common radius is f_ee/2 at one of the zeros of f_eee, at most six a point. Where f_eee
    # vanishes altogether every direction is one, and the extremes are tried.
    unit = frobenius(f, 2) + frobenius(f, 3)
    angle, _ = real_zeros(lambda a: derivative_along(f, a, 3), 3, unit=unit)
    twice = np.hstack([derivative_along(f, angle, 2), _principal_values(f)])
    return _common(twice / 2, residual)


def _channel(f, _):
    """Corollary 28: f_ew = f_eee = 0."""
    low, high, turn = _principal(f)
    # f_ew = 0 in the principal directions alone: of the two, the better one counts.
    angle = turn[:, None] + [0.0, np.pi / 2]
    left = np.abs(derivative_along(f, angle, 3)).min(-1) / (frobenius(f, 3) + frobenius(f, 2))
    # In an umbilic every direction is principal, and in some of them f_eee vanishes.
    differ = high - low > UMBILIC * frobenius(f, 2)
    return float(np.max(np.where(differ, left, 0.0))), None


def _pipe(f, radius):
    """Corollary 29: f_ee = 2 R in a principal direction."""
    values = _principal_values(f)

    def residual(radius):
        scale = np.abs(values).sum(axis=-1) + 2 * abs(radius)
        return float(np.max(np.abs(values - 2 * radius).min(axis=-1) / scale))

    if radius is not None:
        return residual(radius), radius
    return _common(values / 2, residual)


def _cone(f, half_angle):
    """Theorem 16: rho f_eee + 3 f_ew = 0 and contact of order 4."""

    def residual(half_angle):
        rho = 0.5 / np.tan(half_angle)
        angle, _ = third_order(f, rho)
        left = np.abs(order_four(f, angle, rho)[1])
        left[np.isnan(left).all(axis=-1)] = 0.0  # spherical points: every cone that touches
        return float(np.nanmin(left, axis=-1).max())

    if half_angle is not None:
        return residual(half_angle), half_angle
    # Order 3 gives rho by the direction, which put into order 4 leaves a form of degree 8, even in
    # e: in the doubled angle a trigonometric polynomial of degree 4.
    angle, _ = real_zeros(lambda b: _eliminated(f, b / 2), 4, unit=_eliminated_size(f))
    angle = angle / 2
    feee = derivative_along(f, angle, 3)
    few = derivative_along(f, angle, 1, 1)
    # e and -e are one zero here, and have rho of either sign: of the two one is a cone.
    found = np.arctan2(np.abs(feee), 6 * np.abs(few))
    found[(found < NEEDLE) | (found > np.pi / 2 - NEEDLE)] = np.nan
    if np.isnan(found).all():  # a sphere fits every angle, and what fits none fits not this one
        return residual(np.pi / 4), None
    return _common(found, residual)


def _eliminated(f, angle):
    """Return the form of degree 8 that vanishes where some half-angle gives order 4."""
    few = derivative_along(f, angle, 1, 1)
    feee = derivative_along(f, angle, 3)
    fourth = 3 * few**2 * derivative_along(f, angle, 4)
    fourth = fourth - 6 * few * derivative_along(f, angle, 2, 1) * feee
    return fourth + (derivative_along(f, angle, 0, 2) - derivative_along(f, angle, 2)) * feee**2


def _eliminated_size(f):
    two = frobenius(f, 2)
    three = frobenius(f, 3)
    four = frobenius(f, 4)
    return two**2 * (three + four) + two * three**2 + two**3


def _common(candidates, residual):
    """Return the least residual, and for which value, of values that the points may share."""
    best = (1.0, None)
    # The value that all points share is among the candidates of each: those of a few points do.
    for row in candidates[:: max(1, len(candidates) // TRIALS)]:
        for value in np.unique(row[np.isfinite(row)]):
            # The median of the points' own nearest candidates is less noisy than one point's.
            distance = np.where(np.isnan(candidates), np.inf, np.abs(candidates - value))
            nearest = np.take_along_axis(candidates, distance.argmin(axis=-1)[:, None], axis=-1)
            shared = float(np.nanmedian(nearest))
            best = min(best, (residual(shared), shared), key=lambda pair: pair[0])
    return best


def _principal(f):
    """Return the Hessian's eigenvalues, low and high, and the angle of the low one's direction."""
    a = derivative(f, 2, 0)
    b = derivative(f, 1, 1)
    c = derivative(f, 0, 2)
    mean = (a + c) / 2
    half = np.hypot((a - c) / 2, b)
    # Half of arctan2(2 b, a - c) is the direction of the high one.
    return mean - half, mean + half, np.arctan2(2 * b, a - c) / 2 + np.pi / 2


def _principal_values(f):
    return np.stack(_principal(f)[:2], axis=-1)


def _nonzero(x):
    return x + (x == 0)


_OF_RADIUS = {"cylinder": _cylinder, "channel": _channel, "pipe": _pipe}
