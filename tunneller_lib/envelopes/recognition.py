"""Which moving tool envelops a surface: differential tests of six classes (Envelopes, 2 to 8)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments import Coordinate, HalfAngle, Reals, checked
from .adapted import FLAT, adapted_frames, isotropic_jet, sound, tangent_graph
from .circle_roots import Waves
from .evidence import (
    LEAST_POINTS,
    RUNS,
    SHARP,
    Evidence,
    errors,
    rough_frames,
    scatter,
    spread_in_two,
    weigh,
)
from .functions import Function
from .jet import HIGHEST, ORDER
from .kinds import KINDS

APART = 1e-4  # relative change of a given size that a point must notice, or it doesn't count
FAR = 1e-2  # relative change that isn't noticed where every size fits
NOTHING = 1e-10  # share of the terms of order 4 below which their error must lie there
SAME_SIZE = 1e-11  # relative difference of sizes that count as one
SHARP_OVER_WINDOW = 1e-7  # relative bound over the normals' spread above which no point tells
TORSAL = 1e-10  # |K|/|II|^2, up to which a point counts as one with a ruling


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
    """

    kind: str
    verdict: str
    because: str
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
    radius: Coordinate | None = None,
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
        Of the cones, in rad, between 0 and pi/2; looked for from 1e-4 on unless given. A size that
        is given is asked as it stands: one that is off by more than a ten-thousandth of it (of a
        half-angle's tangent) isn't confirmed, whatever the window.
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
        fewer points, one where the surface isn't defined and smooth, or one with derivatives above
        1e90; for all kinds but the first two if at fewer than 12 points the Gaussian curvature is
        neither 0 nor infinite, where planes are no model of the surface; or if an option doesn't
        belong to the kind or is out of range.

    Notes
    -----
    Envelopes of cones, Theorems 2, 4 and 16, Corollaries 25, 28 and 29 and their converses (Problem
    30), in the adapted frame. Repeated runs, each rounded at random, show what rounding does, and
    so bound the error of each condition, see `evidence`. A point near the parabolic curve, an
    umbilic or a multiple solution has wide bounds and doesn't tell. Where solutions for cones are
    multiple everywhere Eq. 12 holds by itself (Problem 15): those count only if f_ew = 0. At a
    point there is nearly always a cone of some half-angle that satisfies all: a radius or
    half-angle that isn't given must be the same at all points and have the gradient zero at each,
    see `Envelope.steadiness`; for one that is given see `given`. The residual is the least over the
    directions that solve the lower-order conditions, over the size of its terms, so that it has no
    unit. A developable surface counts as ruled. A surface may be enveloped by cones of several
    angles, as those of revolution are, and in a small window two angles near each other may both
    pass: the one that fits best is returned, and the reason names the others.

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
    if radius is not None and kind not in ("cylinder", "pipe"):
        raise ValueError(f"radius: belongs to cylinder and pipe only; got it with {kind!r}.")
    if half_angle is not None and kind != "cone":
        raise ValueError(f"half_angle: belongs to cone only; got it with {kind!r}.")
    found = adapted_frames(surface, s, t, model)
    if not found.smooth.all():
        i = np.argmin(found.smooth)
        raise ValueError(
            "surface: must be defined and smooth at every point; got one that isn't "
            f"at ({s.flat[i]}, {t.flat[i]})."
        )
    size = half_angle if kind == "cone" else radius
    order = HIGHEST if kind == "cone" and size is None else ORDER
    rough = rough_frames(surface, s.ravel(), t.ravel(), model, order)
    # A developable surface's normals lie on a curve by themselves.
    normals = None if kind in ("developable", "ruled") else found.axes[:, 2]
    spread = spread_in_two(s.ravel(), t.ravel(), normals)
    if kind == "developable":
        return _judged(kind, [_flat(rough)], spread, float(found.curvature.max()))
    if kind == "ruled":
        # Where K = 0 there is always a ruling, and no second asymptotic direction to look for.
        curved = found.curvature > TORSAL
        g = tangent_graph(found, curved)
        _check_sound(g)
        evidence = _flat(rough)
        if curved.any():
            off = errors(tangent_graph(rough, np.tile(curved, RUNS)))
            of_curved = weigh(KINDS[kind].conditions(g, off), SHARP)
            evidence = _with(evidence, curved, of_curved)
        return _judged(kind, [evidence], spread, KINDS[kind].residual(g, None)[0])
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
    left, best = KINDS[kind].residual(f, size)
    others = []
    if kind == "channel":
        tried = [asked(KINDS[kind], f, errors(runs), None, 0.0, SHARP)]
        return _judged(kind, tried, spread, left)
    if size is not None:
        tried = [given(KINDS[kind], f, runs, size)]
    else:
        window = np.linalg.norm(np.ptp(found.axes[:, 2], axis=0))
        tried, best, others = searched(KINDS[kind], f, runs, window, best)
    return _judged(kind, tried, spread, left, others, **{KINDS[kind].measure: best})


def _check_sound(jet):
    if not sound(jet).all():
        raise ValueError(
            "surface: must have derivatives of at most 1e90 in size at every point; got more."
        )


def _judged(kind, tried, spread, residual, others=(), **size):
    """Return the recognition by the evidence for each size that was tried, the best first.

    `others` are sizes that pass as well as the one that is found.
    """
    refuted = [evidence.refutes.any() for evidence in tried]
    if all(refuted):
        reason = "a point differs by more than its error, whatever the size of the tool"
        return Recognition(kind, "is not", f"{reason}.", residual, **size)
    evidence = tried[refuted.index(False)]  # of the best size that no point refutes
    if not spread:
        reason = "the points lie on one curve, or nearly, of the surface or of its normals"
        return Recognition(kind, "cannot tell", f"{reason}.", residual, **size)
    count = np.count_nonzero(evidence.agrees)
    if count >= LEAST_POINTS:
        reason = f"{count} points agree within their errors and none differs"
        if others:  # as of surfaces of revolution, or where a window is too small to tell them
            reason += f"; so they do with {', '.join(f'{other:.6g}' for other in others)}"
        return Recognition(kind, "is", f"{reason}.", residual, **size)
    # Points at which all common solutions are multiple and don't stay: only cones have such.
    passing = np.count_nonzero(~evidence.agrees & evidence.several.any(axis=-1))
    if kind == "cone" and passing >= LEAST_POINTS and sum(refuted) == len(tried) - 1:
        reason = "cones fall together at every point, and those don't stay on the surface"
        return Recognition(kind, "is not", f"{reason}.", residual, **size)
    reason = (
        f"{count} points tell, and at least {LEAST_POINTS} must: the others' errors are too wide"
    )
    return Recognition(kind, "cannot tell", f"{reason}.", residual, **size)


def _flat(rough):
    """Return the points' evidence for a Gaussian curvature 0."""
    # The error is ten times the greatest deviation of the runs, plus a few roundings.
    every = rough.curvature.reshape(RUNS, -1)
    value = np.median(every, axis=0)
    off = 10 * np.abs(every - value).max(axis=0) + 1e-15
    none = np.zeros((len(value), 0))
    agrees = (value <= off) & (off <= SHARP)
    return Evidence(value > off, agrees, none, none, none.astype(bool))


def _with(evidence, where, other):
    """Return the `other` evidence for the points `where` it belongs; all other points agree."""
    refutes = np.zeros_like(evidence.refutes)
    agrees = np.ones_like(evidence.agrees)
    refutes[where] = other.refutes
    agrees[where] = other.agrees
    return evidence._replace(refutes=refutes, agrees=agrees)


# ---- sizes of tools: one that is given, or those that the points share ---------------------------


def asked(kind, f, off, size, unsure, sharp, floor=1.0):
    """Return the evidence for a class of envelopes and one size of its tool.

    Parameters
    ----------
    kind : Envelope
        Which class.
    f, off, size, unsure
        As for `Envelope.conditions`.
    sharp : float
        Relative bound of the second condition, above which a point doesn't tell.
    floor : float
        As for `Envelope.conditions`.

    Returns
    -------
    evidence : Evidence
        Of each point.
    """
    return kind.counted(f, off, weigh(kind.conditions(f, off, size, unsure, floor), sharp))


def given(kind, f, runs, size):
    """Return the evidence for a given size; points that fit another size as well don't count.

    Parameters
    ----------
    kind : Envelope
        Of tools with a size.
    f : Jet
        In adapted frames, at n points.
    runs : Jet
        The same `RUNS` times over, each time rounded at random.
    size : float
        The radius in m or the half-angle in rad.

    Returns
    -------
    evidence : Evidence
        Points agree where at a common zero both conditions hold, as near as rounding lets them,
        and don't for tools that are `APART` greater or smaller; or where they hardly depend on
        the size, as where cones of every half-angle envelop the surface.
    """
    evidence = asked(kind, f, errors(runs), size, 0.0, SHARP)
    several = np.tile(evidence.several, (RUNS, 1))
    angle = np.tile(evidence.angle, (RUNS, 1))
    with np.errstate(all="ignore"):
        here, less, more, far = (
            _at_own_zeros(kind, runs, angle, several, kind.scaled(size, share))
            for share in (0.0, -APART, APART, FAR)
        )
        # The bounds of `weigh` are those of all directions. Near the parabolic curve derivatives
        # across a ruling are a million times those along it, and another size is within them.
        off = [scatter(values) for values in here]
        own = _within(here, off)
        differs = ~_within(less, off) & ~_within(more, off)
        terms = _middle(kind.conditions(runs, runs, size, floor=0.0).size(angle))
        any_size = _within(far, map(scatter, far)) & (off[1] <= NOTHING * terms)
    everywhere = np.isnan(evidence.angle).all(axis=-1)
    tells = everywhere | (own & (differs | any_size)).any(axis=-1)
    several = evidence.several & ~evidence.agrees[:, None]
    return evidence._replace(agrees=evidence.agrees & tells, several=several)


def _at_own_zeros(kind, runs, angle, several, size):
    """Return both conditions (RUNS n, m) at each run's own zeros of the first.

    With another size a multiple zero may disappear: the place where the first condition turns
    stands for it.
    """
    forms = kind.conditions(runs, runs, size)
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


def searched(kind, f, runs, window, size):
    """Return the evidence for each size that one point allows, and the size found.

    The candidates are the sizes of one point, the one that knows its own best. Each is compared
    with the nearest size of every point. The point that knows its own most sharply gives the value
    and the error by which points refute; the median of those known best is the size on which they
    agree.

    Parameters
    ----------
    kind, f, runs : Envelope, Jet, Jet
        As of `given`.
    window : float
        By how much the unit normals of the points differ.
    size : float or None
        The one with the least residual, in m or rad; None where there is none, as on a sphere.

    Returns
    -------
    tried : list of Evidence
        For each candidate, the best first.
    size : float or None
        The one that the points share; as given if they share none.
    others : list of float
        Other sizes that the points share as well.
    """
    off = errors(runs)
    values, unsure, stays, complete, every = kind.sizes(f, off, runs)
    sharp = min(SHARP, SHARP_OVER_WINDOW * window)
    tried = []
    if not complete.any():
        # No point lists all the sizes that it allows, so the candidates can't refute the surface,
        # and this entry refutes nothing. Where all points allow a whole range of sizes, as those of
        # a sphere allow every half-angle, any size of the range will do for them to agree.
        found = asked(kind, f, off, np.pi / 4 if size is None else size, 0.0, sharp)
        agrees = found.agrees & every.all()
        tried.append((found._replace(refutes=np.zeros_like(agrees), agrees=agrees), size))
    # The candidates' point is the one whose worst known size has the least relative error, if
    # possible among those that list all their sizes.
    width = np.where(np.isnan(values), 0.0, unsure / (np.abs(values) + (values == 0)))
    best = np.argmin(np.where(complete | ~complete.any(), width.max(axis=-1), np.inf))
    for value, error in zip(values[best], unsure[best], strict=True):
        if np.isnan(value):
            continue
        # Of each point the size nearest to this one, its error, and whether both may be equal.
        apart = np.where(np.isnan(values), np.inf, np.abs(values - value))
        nearest = np.argmin(apart, axis=-1)[:, None]
        theirs = np.take_along_axis(values, nearest, -1)[:, 0]
        their_errors = np.take_along_axis(unsure, nearest, -1)[:, 0]
        same = np.abs(theirs - value) <= error + their_errors
        their_errors[~same] = np.inf
        sharpest = np.argmin(their_errors)
        if their_errors[sharpest] < error:
            value = theirs[sharpest]
            error = their_errors[sharpest]
        evidence = asked(kind, f, off, value, error, sharp)
        # All points must agree with one and the same size. The median of those known best is one
        # that has more digits than their error bounds promise.
        half = np.median(their_errors[np.isfinite(their_errors)])
        shared = np.median(theirs[their_errors <= half])
        again = asked(kind, f, off, shared, SAME_SIZE * abs(shared), sharp, floor=1e-3)
        # A point whose derivatives show that its size doesn't change around it agrees, however
        # small the window is.
        agrees = again.agrees | (np.take_along_axis(stays, nearest, -1)[:, 0] & same)
        tried.append((again._replace(refutes=evidence.refutes, agrees=agrees), shared))
    if not tried:  # the point lists all the sizes that it allows, and allows none
        nothing = np.zeros(len(values), dtype=bool)
        none = np.zeros((len(values), 0))
        return [Evidence(~nothing, nothing, none, none, none.astype(bool))], size, []
    tried.sort(key=lambda found: (found[0].refutes.any(), -np.count_nonzero(found[0].agrees)))
    passed = []  # sizes on which enough points agree; those within `APART` count once
    for found, one in tried:
        enough = np.count_nonzero(found.agrees) >= LEAST_POINTS and not found.refutes.any()
        if one is None or not enough or any(abs(one - p) <= APART * abs(p) for p in passed):
            continue
        passed.append(float(one))
    return [found for found, _ in tried], passed[0] if passed else size, passed[1:]
