"""How far a surface is from a class of envelopes: its worst point, the best direction there.

A residual is what a class' condition of the highest order leaves over the size of its terms, where
those of lower order are solved; so it has no unit.
"""

import numpy as np

from .circle_roots import real_zeros
from .conditions import two_conditions
from .forms import derivative_along, frobenius, principal, principal_values
from .steady import eliminated

NEEDLE = 1e-4  # rad, a cone sharper than this, or as blunt, is not looked for
UMBILIC = 1e-9  # relative difference of principal radii, below which they count as equal
TRIALS = 4  # points whose own solutions are tried as a common radius or angle


def residual(kind, f, size):
    """Return the residual of a class, and for which size of its tool.

    Parameters
    ----------
    kind : {"cylinder", "channel", "pipe", "cone"}
        Which class.
    f : Jet
        In adapted frames, at n points.
    size : float or None
        The radius in m or half-angle in rad; the best one is looked for unless given.

    Returns
    -------
    residual : float
        0 to 1.
    size : float or None
        As given, or found; None of channels, and of spheres, which fit every half-angle.
    """
    return _RESIDUALS[kind](f, size)


def ruled_residual(g):
    """Theorem 4 on the graphs over the tangent planes: g_ee = g_eee = 0."""
    return float(_line_contact(g, 0.0, frobenius(g, 2) ** 2).max(initial=0.0))


def _line_contact(f, value, beside):
    """Return the least residual of f_ee = value, f_eee = 0 over directions e, at each point."""
    low, high, turn = principal(f)
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
    twice = np.hstack([derivative_along(f, angle, 2), principal_values(f)])
    return _common(twice / 2, residual)


def _channel(f, _):
    """Corollary 28: f_ew = f_eee = 0."""
    low, high, turn = principal(f)
    # f_ew = 0 in the principal directions alone: of the two, the better one counts.
    angle = turn[:, None] + [0.0, np.pi / 2]
    left = np.abs(derivative_along(f, angle, 3)).min(-1) / (frobenius(f, 3) + frobenius(f, 2))
    # In an umbilic every direction is principal, and in some of them f_eee vanishes.
    differ = high - low > UMBILIC * frobenius(f, 2)
    return float(np.max(np.where(differ, left, 0.0))), None


def _pipe(f, radius):
    """Corollary 29: f_ee = 2 R in a principal direction."""
    values = principal_values(f)

    def residual(radius):
        scale = np.abs(values).sum(axis=-1) + 2 * abs(radius)
        return float(np.max(np.abs(values - 2 * radius).min(axis=-1) / scale))

    if radius is not None:
        return residual(radius), radius
    return _common(values / 2, residual)


def _cone(f, half_angle):
    """Theorem 16: rho f_eee + 3 f_ew = 0 and contact of order 4."""

    def residual(half_angle):
        forms = two_conditions("cone", f, f, half_angle, floor=1e-3)
        angle, _ = real_zeros(forms.first, forms.degree, unit=forms.off_first)
        left = np.abs(forms.second(angle)) / _nonzero(forms.size(angle))
        left[np.isnan(left).all(axis=-1)] = 0.0  # spherical points: every cone that touches
        return float(np.nanmin(left, axis=-1).max())

    if half_angle is not None:
        return residual(half_angle), half_angle
    # Order 3 gives rho by the direction, which put into order 4 leaves a form of degree 8, even in
    # e: in the doubled angle a trigonometric polynomial of degree 4.
    angle, _ = real_zeros(lambda b: eliminated(f, b / 2), 4, unit=_eliminated_size(f))
    angle = angle / 2
    feee = derivative_along(f, angle, 3)
    few = derivative_along(f, angle, 1, 1)
    # e and -e are one zero here, and have rho of either sign: of the two one is a cone.
    found = np.arctan2(np.abs(feee), 6 * np.abs(few))
    found[(found < NEEDLE) | (found > np.pi / 2 - NEEDLE)] = np.nan
    if np.isnan(found).all():  # a sphere fits every angle, and what fits none fits not this one
        return residual(np.pi / 4), None
    return _common(found, residual)


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


def _nonzero(x):
    return x + (x == 0)


_RESIDUALS = {"cylinder": _cylinder, "channel": _channel, "pipe": _pipe, "cone": _cone}
