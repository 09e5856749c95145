"""What a surface's points say of a size of a tool: of one that is given, or of those they share.

At nearly every point of any surface some cylinder, sphere or cone has the contact asked for. On an
envelope its size is the same at all points, and stands still around each.
"""

import numpy as np

from .circle_roots import Waves
from .evidence import LEAST_POINTS, SHARP, Evidence, weigh
from .rough import RUNS, errors, scatter

APART = 1e-4  # share by which a size that is given may be off, and no point can tell
FAR = 1e-2  # share by which it is off where no size matters
NOTHING = 1e-10  # of the terms of order 4, an error that is small there as well
SAME_SIZE = 1e-11  # relative difference of sizes that count as one
SHARP_OVER_WINDOW = 1e-7  # relative bound over the normals' spread, above which none tells


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
    """Return the evidence for a size that is given, without points at which another one might be.

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

    A multiple zero may vanish with another size: there it's where the first turns.
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

    Parameters
    ----------
    kind : Envelope
        Of tools with a size.
    f : Jet
        In adapted frames, at n points.
    runs : Jet
        The same `RUNS` times over, each time rounded at random.
    window : float
        By how much the points' normals differ.
    size : float or None
        That of the least residual.

    Returns
    -------
    tried : list of Evidence
        The best first.
    size : float or None
        That the points share, if they do.
    others : list of float
        Sizes apart from that one which as many points agree with as must.
    """
    off = errors(runs)
    values, unsure, stays, complete, every = kind.sizes(f, off, runs)
    sharp = min(SHARP, SHARP_OVER_WINDOW * window)
    tried = []
    if not complete.any():
        # A sphere has cones of every half-angle, and other surfaces of a range of them: one that
        # was found will do. Else no point tells all its sizes.
        found = asked(kind, f, off, np.pi / 4 if size is None else size, 0.0, sharp)
        agrees = found.agrees & every.all()
        tried.append((found._replace(refutes=np.zeros_like(agrees), agrees=agrees), size))
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
            value, own = there[sharpest], known[sharpest]
        evidence = asked(kind, f, off, value, own, sharp)
        # The points agree only with one value. What they know best has more digits than bounds say.
        shared = np.median(there[known <= np.median(known[np.isfinite(known)])])
        again = asked(kind, f, off, shared, SAME_SIZE * abs(shared), sharp, floor=1e-3)
        # A point that sees the size stand still around it needs no window.
        agrees = again.agrees | (np.take_along_axis(stays, nearest, -1)[:, 0] & same)
        refutes = evidence.refutes | (complete & ~same)
        tried.append((again._replace(refutes=refutes, agrees=agrees), shared))
    if not tried:
        nothing = np.zeros(len(values), dtype=bool)
        none = np.zeros((len(values), 0))
        return [Evidence(~nothing, nothing, none, none, none.astype(bool))], size, []
    tried.sort(key=lambda found: (found[0].refutes.any(), -np.count_nonzero(found[0].agrees)))
    passed = []  # each once
    for found, one in tried:
        enough = np.count_nonzero(found.agrees) >= LEAST_POINTS and not found.refutes.any()
        if one is None or not enough or any(abs(one - p) <= APART * abs(p) for p in passed):
            continue
        passed.append(float(one))
    return [found for found, _ in tried], passed[0] if passed else size, passed[1:]
