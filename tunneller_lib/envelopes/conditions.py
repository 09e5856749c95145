"""What a class of envelopes asks of a direction at each point: two conditions, and their errors."""

import numpy as np

from .evidence import Forms, Waves, weigh
from .forms import derivative_along, frobenius, frobenius_along
from .rough import RUNS, scatter

APART = 1e-4  # share by which a size that is given may be off, and no point can tell
FAR = 1e-2  # share by which it is off where no size matters
NOTHING = 1e-10  # of the terms of order 4, an error that is small there as well


def two_conditions(kind, f, off, size=0.0, unsure=0.0, floor=1.0):
    """Return a class' two conditions on a direction.

    Parameters
    ----------
    kind : {"ruled", "cylinder", "channel", "pipe", "cone"}
        Which class.
    f, off : Jet
        A surface at n points and the errors of its coefficients: in adapted frames, or for ruled
        surfaces as graphs over their tangent planes.
    size, unsure : float
        The radius in m or half-angle in rad, and by how much it may be off.
    floor : float
        What order 4 is compared with is the sum of its terms, but this share of the jet at least.

    Returns
    -------
    conditions : Forms
        Theorem 4; Corollary 25; Corollary 28; Corollary 29; Eqs 11 and 12 in adapted frames.
    """
    two, three, four = (frobenius(off, k) for k in (2, 3, 4))

    # In the adapted frame, with e along the angle a and w across it, these are f_ee - 2 size, f_eee
    # and f_ew. At a simple zero of the first condition that the class asks for, the second decides.
    def normal(a):
        return derivative_along(f, a, 2) - 2 * size

    def third(a):
        return derivative_along(f, a, 3)

    def mixed(a):
        return derivative_along(f, a, 1, 1)

    if kind == "cone":
        # Eqs 11 and 12, where rho = cot(half-angle)/2 is the circle's radius, and its own error.
        rho = 0.5 / np.tan(size)
        unsure = unsure * 0.5 / np.sin(size) ** 2

        def order_3(a):
            return rho * third(a) + 3 * mixed(a)

        def order_4(a):
            return sum(terms(a))

        def terms(a):
            last = derivative_along(f, a, 0, 2) - derivative_along(f, a, 2)
            fourth = rho**2 * derivative_along(f, a, 4)
            return [fourth, 6 * rho * derivative_along(f, a, 2, 1), 3 * last]

        # Terms that cancel to nearly nothing must not pass for a condition of no size.
        def size_4(a):
            return np.maximum(sum(np.abs(term) for term in terms(a)), floor * whole[:, None])

        whole = rho**2 * frobenius(f, 4) + 6 * rho * frobenius(f, 3) + 3 * frobenius(f, 2)
        off_3 = rho * three + 3 * two + unsure * frobenius(f, 3)
        off_4 = rho**2 * four + 6 * rho * three + 6 * two
        off_4 = off_4 + unsure * (2 * rho * frobenius(f, 4) + 6 * frobenius(f, 3))
        return Forms(order_3, order_4, 3, off_3, off_4, size_4)

    def whole(size):
        return lambda a: size[:, None] + 0 * a

    # Contact along a line: no curvature, less the radius, and none in the next order. The sizes of
    # both terms have one unit: of a graph over its plane 1/m^2, in an adapted frame m.
    if kind == "ruled":
        # Near an edge of regression the asymptotic directions nearly coincide, and derivatives
        # across them are huge. A small f_eee beside those is no sign of a line, so the size counts
        # lengths across e only as far as the other asymptotic direction leans.
        def size_of_lines(a):
            turn = np.abs(derivative_along(f, a, 0, 2))
            angle = np.arctan2(2 * np.abs(mixed(a)), turn)
            width = np.minimum(np.tan(angle), 1.0)
            return frobenius_along(f, a, width, 3) + frobenius_along(f, a, width, 2) ** 2

        return Forms(normal, third, 2, two, three, size_of_lines)
    if kind == "cylinder":
        of_jet = frobenius(f, 3) + frobenius(f, 2)
        return Forms(normal, third, 2, two + 2 * unsure, three, whole(of_jet))
    # A sphere along its circle: a principal direction, of which the curvature doesn't change.
    if kind == "channel":
        return Forms(mixed, third, 2, two, three, whole(frobenius(f, 3) + frobenius(f, 2)))
    # A pipe: a principal direction, of which the curvature is that of the radius.
    return Forms(mixed, normal, 2, two, two + 2 * unsure, whole(frobenius(f, 2) + 2 * abs(size)))


def asked(kind, f, off, size, unsure, sharp, **floor):
    """Return the evidence for a class and one size.

    Parameters
    ----------
    kind, f, off, size, unsure
        As for `two_conditions`; `size` is None for channels.
    sharp : float
        Relative bound of the second condition, above which a point doesn't tell.
    floor
        As for `two_conditions`, where it isn't the usual one.

    Returns
    -------
    evidence : Evidence
        Of each point.
    """
    evidence = weigh(two_conditions(kind, f, off, size or 0.0, unsure, **floor), sharp)
    if kind != "cone":
        return evidence
    # Multiple solutions stay if f_ew = 0; else Eq. 12 says nothing of them.
    few = np.abs(derivative_along(f, evidence.angle, 1, 1))
    bound = frobenius(off, 2)[:, None] + 4 * frobenius(f, 2)[:, None] * evidence.spread
    counts = ~np.isnan(evidence.angle) & ~(evidence.several & (few > bound))
    anything = evidence.agrees & np.isnan(evidence.angle).all(axis=-1)
    return evidence._replace(agrees=counts.any(axis=-1) | anything)


def tells(kind, runs, evidence, size):
    """Tell at which points a size that is given can't be another one.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        Which class.
    runs : Jet
        A surface in adapted frames at n points, `RUNS` times over, each time rounded at random.
    evidence : Evidence
        Of `asked`.
    size : float
        The radius in m or the half-angle in rad.

    Returns
    -------
    tells : (n,) bool
        Whether at a common zero both conditions hold, as near as rounding lets them, and don't for
        tools that are `APART` greater or smaller; or whether they hardly depend on the size, as
        where cones of every half-angle envelop the surface, or any direction will do.
    """
    several = np.tile(evidence.several, (RUNS, 1))
    angle = np.tile(evidence.angle, (RUNS, 1))
    with np.errstate(all="ignore"):
        here, less, more, far = (
            _at_own_zeros(kind, runs, angle, several, _larger(kind, size, share))
            for share in (0.0, -APART, APART, FAR)
        )
        # The bounds of `weigh` are those of all directions. Near the parabolic curve derivatives
        # across a ruling are a million times those along it, and another size is within them.
        off = [scatter(values) for values in here]
        own = _within(here, off)
        differs = ~_within(less, off) & ~_within(more, off)
        terms = _middle(two_conditions(kind, runs, runs, size, floor=0.0).size(angle))
        any_size = _within(far, map(scatter, far)) & (off[1] <= NOTHING * terms)
    everywhere = np.isnan(evidence.angle).all(axis=-1)
    return everywhere | (own & (differs | any_size)).any(axis=-1)


def _larger(kind, size, share):
    """Return the size that is larger by a share, of a half-angle by that of its tangent."""
    return np.arctan((1 + share) * np.tan(size)) if kind == "cone" else (1 + share) * size


def _at_own_zeros(kind, runs, angle, several, size):
    """Return both conditions (RUNS n, m) at each run's own zeros of the first.

    A multiple zero may vanish with another size: there it's where the first turns.
    """
    forms = two_conditions(kind, runs, runs, size)
    waves = Waves(forms.first, forms.degree)
    for _ in range(3):  # Newton's steps
        value, slope, bend = (waves.derivative(angle, k) for k in range(3))
        angle = angle - np.where(several, slope / bend, value / slope)
    return np.where(several, waves.derivative(angle, 0), 0.0), forms.second(angle)


def _within(conditions, off):
    """Tell where conditions, found `RUNS` times over, are zero within their errors (n, m)."""
    return np.all([_middle(v) <= e for v, e in zip(conditions, off, strict=True)], axis=0)


def _middle(values):
    """Return the sizes (n, m) of values (RUNS n, m) that were found `RUNS` times over."""
    return np.abs(np.median(values.reshape(RUNS, -1, values.shape[-1]), axis=0))
