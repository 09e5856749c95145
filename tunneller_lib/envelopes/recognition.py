"""Which moving tool envelops a surface: differential tests of six classes (Envelopes, 2 to 8)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments import Reals, checked
from .adapted import FLAT, adapted_frames, isotropic_jet, sound, tangent_graph
from .circle_roots import real_zeros
from .evidence import Evidence, Forms, spread_in_two, weigh, zeros
from .forms import derivative_along, frobenius
from .functions import Function, HalfAngle, Shift
from .hyperosculate import order_four, third_order
from .jet import HIGHEST, ORDER, derivative
from .rough import RUNS, errors, rough_frames, scatter
from .steady import SURE, eliminated, steadiness

LEAST_POINTS = 12
SHARP = 1e-6  # relative bound of a condition, above which a point doesn't tell
SAME_SIZE = 1e-11  # relative difference of sizes that count as one
SHARP_OVER_WINDOW = 1e-7  # and above which, over the normals' spread, none tells of an unknown size
TORSAL = 1e-10  # |K|/|II|^2, below which a point has a ruling without more ado
NEEDLE = 1e-4  # rad, a cone sharper than this, or as blunt, is not looked for
UMBILIC = 1e-9  # relative difference of principal radii, below which they count as equal
_SOME = np.pi * np.arange(12)[None] / 12  # directions
_MANY = np.pi * np.arange(180)[None] / 180
ROUND = 1e-3  # |K|/|II|^2, from which on a point may tell all half-angles that it allows
BENT = 0.1  # and from which on its evidence isn't asked to be sharper
TRIALS = 4  # points whose own solutions are tried as a common radius or angle


@dataclass(frozen=True)
class Recognition:
    """What `recognise` finds.

    Parameters
    ----------
    kind : str
        The class asked for.
    verdict : {"is", "is not", "cannot tell"}
        Whether at least 12 points, spread over the surface, agree as far as their errors let them
        and none refutes; whether one refutes; or neither.
    because : str
        The reason, in words.
    residual : float
        0 to 1: the worst point's.
    radius : float or None
        Radius given or found, in m: of the cylinder or the pipe, positive where the surface's
        normals point to the axis.
    half_angle : float or None
        Half-angle of the cone given or found, in rad.
    probability : float or None
        Of measured surfaces, where a verdict is given: at least this chance that their errors
        haven't made it.
    """

    kind: str
    verdict: str
    because: str
    residual: float
    radius: float | None = None
    half_angle: float | None = None
    probability: float | None = None


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

    Returns
    -------
    found : Recognition
        Verdict with its reason, residual, radius and half-angle.

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
    Envelopes of cones, Theorems 2, 4 and 16, Corollaries 25, 28 and 29 and their converses
    (Problem 30), in the adapted frame. What rounding does is found by rounding at random, see
    `rough`; what it makes of each condition is bounded from there, see `evidence`. A point near
    the parabolic curve, an umbilic or a multiple solution has wide bounds and doesn't tell. Where
    solutions for cones are multiple everywhere Eq. 12 holds by itself (Problem 15): those count
    only if f_ew = 0. At a point there is nearly always a cone of some half-angle that satisfies
    all: a radius or half-angle that isn't given must be the same at all points and have the
    gradient zero at each, see `steady`, so that the size of the window doesn't matter. The
    residual is the least over the directions that solve the
    lower-order conditions, over the size of its terms, so that it has no unit. A developable
    surface counts as ruled. A surface may be enveloped by cones of several angles, as those of
    revolution are: one that fits best is returned.

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
    belongs(kind, radius, half_angle)
    found = adapted_frames.unchecked(surface, s, t, model)
    if not found.smooth.all():
        i = np.argmin(found.smooth)
        raise ValueError(
            "surface: must be defined and smooth at every point; got one that isn't "
            f"at ({s.flat[i]}, {t.flat[i]})."
        )
    searched = kind == "cone" and half_angle is None
    order = HIGHEST if searched else ORDER
    rough = rough_frames(surface, s.ravel(), t.ravel(), model, order)
    return judged(found, rough, s, t, kind, radius, half_angle)


def belongs(kind, radius, half_angle):
    """Raise ValueError if a radius or a half-angle is given that a class doesn't have."""
    if radius is not None and kind not in ("cylinder", "pipe"):
        raise ValueError(f"radius: belongs to cylinder and pipe only; got it with {kind!r}.")
    if half_angle is not None and kind != "cone":
        raise ValueError(f"half_angle: belongs to cone only; got it with {kind!r}.")


def judged(found, rough, s, t, kind, radius, half_angle, sharp=SHARP):
    """Return the recognition by frames at n points.

    Parameters
    ----------
    found, rough : AdaptedFrames
        At the points, and there `RUNS` times over, with jets of order 5 if a half-angle is looked
        for; how these scatter is the error of those.
    s, t : (...) float
        The points.
    kind, radius, half_angle
        As for `recognise`.
    sharp : float
        Relative bound of a condition, above which a point doesn't tell.

    Returns
    -------
    found : Recognition
        As of `recognise`.
    """
    asked_size = half_angle if kind == "cone" else radius
    # A developable surface's normals lie on a curve by themselves.
    normals = None if kind in ("developable", "ruled") else found.axes[:, 2]
    spread = spread_in_two(s.ravel(), t.ravel(), normals)
    if kind == "developable":
        evidence = _flat(rough, sharp)
        return _judged(kind, [evidence], spread, float(found.curvature.max()))
    if kind == "ruled":
        # Where K = 0 there is a ruling without more ado, and no second asymptotic direction.
        curved = found.curvature > TORSAL
        g = tangent_graph(found, curved)
        _check_sound(g)
        evidence = _flat(rough, sharp)
        if curved.any():
            off = errors(tangent_graph(rough, np.tile(curved, RUNS)))
            of_curved = weigh(_forms("ruled", g, off), sharp)
            evidence = _with(evidence, curved, of_curved)
        return _judged(kind, [evidence], spread, _ruled(g))
    flat = found.curvature <= FLAT
    if np.count_nonzero(~flat) < LEAST_POINTS:
        i = np.argmin(found.curvature)
        raise ValueError(
            f"surface: must have a Gaussian curvature not 0 nor infinite for {kind}; "
            f"got one at ({s.flat[i]}, {t.flat[i]})."
        )
    f = isotropic_jet(found, ~flat)
    _check_sound(f)
    runs = isotropic_jet(rough, np.tile(~flat, RUNS))
    off = errors(runs)
    if kind == "cone":
        residual, half_angle = _cone(f, half_angle)
        size = {"half_angle": half_angle}
    else:
        residual, radius = _OF_RADIUS[kind](f, radius)
        size = {"radius": radius}
    given = asked_size is not None or kind == "channel"
    if given:
        tried = [_tried(kind, f, off, asked_size, 0.0, sharp)]
    else:
        window = np.linalg.norm(np.ptp(found.axes[:, 2], axis=0))
        tried, size = _searched(kind, f, off, runs, sharp, window, size)
    return _judged(kind, tried, spread, residual, **size)


def _check_sound(jet):
    if not sound(jet).all():
        raise ValueError(
            "surface: must have derivatives of at most 1e90 in size at every point; got more."
        )


def _judged(kind, tried, spread, residual, **size):
    """Return the recognition by the evidence for each size that was tried."""
    refuted = [evidence.refutes.any() for evidence in tried]
    if all(refuted):
        reason = "a point differs by more than its error, whatever the size of the tool"
        return Recognition(kind, "is not", f"{reason}.", residual, **size)
    evidence = tried[refuted.index(False)]
    if not spread:
        reason = "the points lie on one curve, or nearly, of the surface or of its normals"
        return Recognition(kind, "cannot tell", f"{reason}.", residual, **size)
    count = np.count_nonzero(evidence.agrees)
    if count >= LEAST_POINTS:
        reason = f"{count} points agree within their errors and none differs"
        return Recognition(kind, "is", f"{reason}.", residual, **size)
    if (
        kind == "cone"
        and _only_passing(evidence) >= LEAST_POINTS
        and sum(refuted) == len(tried) - 1
    ):
        reason = "cones fall together at every point, and those don't stay on the surface"
        return Recognition(kind, "is not", f"{reason}.", residual, **size)
    reason = (
        f"{count} points tell, and at least {LEAST_POINTS} must: the others' errors are too wide"
    )
    return Recognition(kind, "cannot tell", f"{reason}.", residual, **size)


def _only_passing(evidence):
    """Return at how many points all common solutions are multiple and don't stay."""
    return np.count_nonzero(~evidence.agrees & evidence.several.any(axis=-1))


def _flat(rough, sharp):
    """Return the evidence for a curvature 0."""
    every = rough.curvature.reshape(RUNS, -1)
    value = np.median(every, axis=0)
    off = 10 * np.abs(every - value).max(axis=0) + 1e-15
    none = np.zeros((len(value), 0))
    agrees = (value <= off) & (off <= sharp)
    return Evidence(value > off, agrees, none, none, none.astype(bool))


def _with(evidence, where, other):
    """Return evidence with that of some points put in; there none of the first counts."""
    refutes = np.zeros_like(evidence.refutes)
    agrees = np.ones_like(evidence.agrees)
    refutes[where] = other.refutes
    agrees[where] = other.agrees
    return evidence._replace(refutes=refutes, agrees=agrees)


def _forms(kind, f, off, size=0.0, unsure=0.0, floor=1.0):
    """Return a class' two conditions at n points, for a size that may be off by `unsure`.

    What order 4 is compared with is the sum of its terms, but a share `floor` of the jet at least.
    """
    two, three, four = (frobenius(off, k) for k in (2, 3, 4))

    def normal(a):
        return derivative_along(f, a, 2) - 2 * size

    def third(a):
        return derivative_along(f, a, 3)

    def mixed(a):
        return derivative_along(f, a, 1, 1)

    if kind == "cone":
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

        def size_4(a):
            return np.maximum(sum(np.abs(term) for term in terms(a)), floor * whole[:, None])

        whole = rho**2 * frobenius(f, 4) + 6 * rho * frobenius(f, 3) + 3 * frobenius(f, 2)
        off_3 = rho * three + 3 * two + unsure * frobenius(f, 3)
        off_4 = rho**2 * four + 6 * rho * three + 6 * two
        off_4 = off_4 + unsure * (2 * rho * frobenius(f, 4) + 6 * frobenius(f, 3))
        return Forms(order_3, order_4, 3, off_3, off_4, size_4)

    def whole(size):
        return lambda a: size[:, None] + 0 * a

    if kind in ("ruled", "cylinder"):
        beside = frobenius(f, 2) if kind == "cylinder" else frobenius(f, 2) ** 2
        return Forms(normal, third, 2, two + 2 * unsure, three, whole(frobenius(f, 3) + beside))
    if kind == "channel":
        return Forms(mixed, third, 2, two, three, whole(frobenius(f, 3) + frobenius(f, 2)))
    return Forms(mixed, normal, 2, two, two + 2 * unsure, whole(frobenius(f, 2) + 2 * abs(size)))


def _tried(kind, f, off, size, unsure, sharp, floor=1.0):
    """Return the evidence for a class and one size."""
    evidence = weigh(_forms(kind, f, off, size or 0.0, unsure, floor), sharp)
    if kind != "cone":
        return evidence
    # Multiple solutions stay if f_ew = 0; else Eq. 12 says nothing of them.
    few = np.abs(derivative_along(f, evidence.angle, 1, 1))
    bound = frobenius(off, 2)[:, None] + 4 * frobenius(f, 2)[:, None] * evidence.spread
    counts = ~np.isnan(evidence.angle) & ~(evidence.several & (few > bound))
    anything = evidence.agrees & np.isnan(evidence.angle).all(axis=-1)
    return evidence._replace(agrees=counts.any(axis=-1) | anything)


def _searched(kind, f, off, runs, sharp, window, size):
    """Return the evidence for each size that one point allows, and the size found."""
    values, unsure, stays, complete, every = _sizes(kind, f, off, runs, sharp)
    same_size = SAME_SIZE * sharp / SHARP
    sharp = min(sharp, SHARP_OVER_WINDOW * window * sharp / SHARP)
    [name] = size
    tried = []
    if not complete.any():
        # A sphere has cones of every half-angle, and other surfaces of a range of them: one that
        # was found will do. Else no point tells all its sizes.
        trial = np.pi / 4 if size[name] is None else size[name]
        found = _tried(kind, f, off, trial, 0.0, sharp)
        agrees = found.agrees & every.all()
        tried.append((found._replace(refutes=np.zeros_like(agrees), agrees=agrees), size[name]))
    # Each size of the point that knows its own best is tried, as well as any point knows it.
    width = np.where(np.isnan(values), 0.0, unsure / (np.abs(values) + (values == 0)))
    best = np.argmin(np.where(complete | ~complete.any(), width.max(axis=-1), np.inf))
    for value, own in zip(values[best], unsure[best], strict=True):
        if np.isnan(value):
            continue
        apart = np.where(np.isnan(values), np.inf, np.abs(values - value))
        nearest = np.argmin(apart, axis=-1)[:, None]
        there = np.take_along_axis(values, nearest, -1)[:, 0]
        known = np.take_along_axis(unsure, nearest, -1)[:, 0]
        same = np.abs(there - value) <= own + known
        known[~same] = np.inf
        sharpest = np.argmin(known)
        if known[sharpest] < own:
            evidence = _tried(kind, f, off, there[sharpest], known[sharpest], sharp)
        else:
            evidence = _tried(kind, f, off, value, own, sharp)
        # The points agree only with one value. What they know best has more digits than bounds say.
        shared = np.median(there[known <= np.median(known[np.isfinite(known)])])
        again = _tried(kind, f, off, shared, same_size * abs(shared), sharp, 1e-3)
        # A point that sees the size stand still around it needs no window.
        agrees = again.agrees | (np.take_along_axis(stays, nearest, -1)[:, 0] & same)
        refutes = evidence.refutes | (complete & ~same)
        tried.append((again._replace(refutes=refutes, agrees=agrees), shared))
    if not tried:
        nothing = np.zeros(len(values), dtype=bool)
        none = np.zeros((len(values), 0))
        return [Evidence(~nothing, nothing, none, none, none.astype(bool))], size
    tried.sort(key=lambda found: (found[0].refutes.any(), -np.count_nonzero(found[0].agrees)))
    if np.count_nonzero(tried[0][0].agrees) >= LEAST_POINTS and tried[0][1] is not None:
        size = {name: float(tried[0][1])}
    return [found[0] for found in tried], size


def _sizes(kind, f, off, runs, sharp):
    """Return the sizes that each point allows, how far they may be off, and whether that's all.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        Of which the radius or the half-angle is asked.
    f, off : Jet
        In adapted frames, at n points, and the errors of its coefficients.
    runs : Jet
        The same as f, each time rounded at random.
    sharp : float
        Relative error of a gradient above which it doesn't tell.

    Returns
    -------
    values, unsure : (n, m) float
        In m or rad; NaN-padded. Those that change over the surface are left out.
    stays : (n, m) bool
        Whether a size surely doesn't change.
    complete : (n,) bool
        Whether no other size is possible.
    every : (n,) bool
        Whether each size of a range is.
    """
    two, three = (frobenius(off, k)[:, None] for k in (2, 3))
    values = _principal_values(f) / 2
    exact = np.broadcast_to(two, values.shape)
    if kind == "pipe":
        certain = np.ones(len(values), dtype=bool)
        own = _principal(f)[2][:, None] + [0.0, np.pi / 2]
        steady = steadiness(kind, runs, own, sharp)
        values[steady.changes] = np.nan
        return values, exact, steady.stays, certain, ~certain
    if kind == "cylinder":
        angle, spread, _ = zeros(lambda a: derivative_along(f, a, 3), 3, three[:, 0])
        rate = np.abs(derivative_along(f, angle, 1, 1)) + frobenius(f, 2)[:, None] * spread
        found = derivative_along(f, angle, 2) / 2
        # Where f_eee vanishes altogether every direction has its own size.
        every = (frobenius(f, 3) <= 4 * three[:, 0]) & (np.ptp(values, axis=-1) > 4 * two[:, 0])
        steady = steadiness(kind, runs, angle, sharp)
        found[steady.changes] = np.nan
        values = np.hstack([found, values])
        stays = np.hstack([steady.stays, np.zeros(exact.shape, dtype=bool)])
        return values, np.hstack([two + 2 * rate * spread, exact]), stays, ~every, every
    slack = scatter(eliminated(runs, _SOME)).max(axis=-1, keepdims=True)
    angle, spread, _ = zeros(lambda b: eliminated(f, b / 2), 4, slack[:, 0])
    angle, spread = angle / 2, spread / 2
    # Where the form only turns it must be as near to zero as rounding takes it in that direction.
    turns = angle[:, 8:]
    near = scatter(eliminated(runs, np.tile(turns, (RUNS, 1))))
    turns[np.abs(eliminated(f, turns)) > SURE * near] = np.nan
    up = 3 * derivative_along(f, angle, 1, 1)
    down = derivative_along(f, angle, 3)
    off_up = 3 * two + 6 * frobenius(f, 2)[:, None] * spread
    off_down = three + 3 * frobenius(f, 3)[:, None] * spread
    # Of a channel's own circles both vanish, and the half-angle follows from Problem 15's answer:
    # rho f_eew + f_ww - f_ee = 0.
    _, _, turn = _principal(f)
    own = turn[:, None] + [0.0, np.pi / 2]
    mu = derivative_along(f, own, 2) - derivative_along(f, own, 0, 2)
    twist = derivative_along(f, own, 2, 1)
    turned = two / np.where(mu == 0, np.inf, np.abs(mu))
    circle = np.abs(derivative_along(f, own, 3)) <= three + 3 * frobenius(f, 3)[:, None] * turned
    of_circle = np.where(circle, np.arctan2(np.abs(twist), 2 * np.abs(mu)), np.nan)
    angles = np.hstack([np.arctan2(np.abs(down), 2 * np.abs(up)), of_circle])
    size = np.hstack([np.hypot(down, 2 * up), np.hypot(twist, 2 * mu)])
    off_twist = three + 3 * frobenius(f, 3)[:, None] * turned
    off_size = np.hstack([off_down + 2 * off_up, off_twist + 4 * two])
    with np.errstate(divide="ignore", invalid="ignore"):
        unsure = 2 * off_size / size
    # A zero of the eliminated form at such a circle has no half-angle of its own.
    passing = circle.any(axis=-1)[:, None] & (np.abs(up) <= off_up) & (np.abs(down) <= off_down)
    passing = np.hstack([passing, np.zeros_like(circle)])
    # Towards the parabolic curve derivatives grow, and what differs is small among their terms.
    bend = np.abs(_principal_values(f).prod(axis=-1)) / frobenius(f, 2) ** 2
    sharp = sharp * np.where(bend > ROUND, np.minimum(bend / BENT, 1.0) ** 2, 0.0)[:, None]
    steady = steadiness(kind, runs, angle, sharp)
    stays, changes = (np.hstack([part, np.zeros_like(circle)]) for part in steady[:2])
    # How far the runs are apart says more than bounds do.
    unsure[:, : angle.shape[1]] = np.fmin(unsure[:, : angle.shape[1]], steady.off)
    vague = ~np.isnan(angles) & ~(unsure <= 0.1) & ~changes
    every = np.abs(eliminated(f, _SOME)).max(axis=-1) <= 4 * slack[:, 0]
    # Near the parabolic curve the zeros crowd, and one may be lost; so may a pair between samples.
    signs = np.sign(eliminated(f, _MANY))
    crossings = np.count_nonzero(signs != np.roll(signs, 1, axis=-1), axis=-1)
    complete = ~(vague & ~passing).any(axis=-1) & ~every & (bend > ROUND)
    complete &= crossings <= np.count_nonzero(~np.isnan(angle), axis=-1)
    outside = (angles < NEEDLE) | (angles > np.pi / 2 - NEEDLE)
    angles[vague | passing | outside | changes] = np.nan
    return angles, np.where(np.isnan(angles), 0.0, unsure), stays, complete, every


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
