"""Which size of a tool all points of a surface share, where it isn't given.

At nearly every point of any surface some cylinder, sphere or cone has the contact asked for. On an
envelope its size is the same at all points, and stands still around each.
"""

import numpy as np

from .conditions import APART, asked
from .evidence import LEAST_POINTS, SHARP, Evidence, zeros
from .forms import derivative_along, frobenius, principal, principal_values
from .residuals import NEEDLE
from .rough import RUNS, scatter
from .steady import SURE, eliminated, steadiness

SAME_SIZE = 1e-11  # relative difference of sizes that count as one
# Relative bound over the normals' spread, above which a point doesn't tell.
SHARP_OVER_WINDOW = 1e-7
ROUND = 1e-3  # |K|/|II|^2, from which on a point may tell all half-angles that it allows
BENT = 0.1  # and from which on its evidence isn't asked to be sharper
_SOME = np.pi * np.arange(12)[None] / 12  # directions
_MANY = np.pi * np.arange(180)[None] / 180


def searched(kind, f, off, runs, window, size):
    """Return the evidence for each size that one point allows, and the size found.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        Of which the radius or the half-angle is asked.
    f, off : Jet
        In adapted frames, at n points, and the errors of its coefficients.
    runs : Jet
        The same as f, each time with its errors at random.
    window : float
        By how much the points' normals differ.
    size : dict of str to float or None
        "radius" or "half_angle" of the least residual.

    Returns
    -------
    tried : list of Evidence
        The best first.
    size : dict
        With the size that the points share, if they do.
    others : list of float
        Sizes apart from that one which as many points agree with as must.
    """
    values, unsure, stays, complete, every = _sizes(kind, f, off, runs)
    sharp = min(SHARP, SHARP_OVER_WINDOW * window)
    [name] = size
    tried = []
    if not complete.any():
        # A sphere has cones of every half-angle, and other surfaces of a range of them: one that
        # was found will do. Else no point tells all its sizes.
        trial = np.pi / 4 if size[name] is None else size[name]
        found = asked(kind, f, off, trial, 0.0, sharp)
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
            evidence = asked(kind, f, off, there[sharpest], known[sharpest], sharp)
        else:
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
    evidence, shared = zip(*tried, strict=True)
    passed = []  # each once
    for found, one in zip(evidence, shared, strict=True):
        enough = np.count_nonzero(found.agrees) >= LEAST_POINTS and not found.refutes.any()
        if one is None or not enough or any(abs(one - p) <= APART * abs(p) for p in passed):
            continue
        passed.append(float(one))
    if passed:
        size = {name: passed[0]}
    return list(evidence), size, passed[1:]


def _sizes(kind, f, off, runs):
    """Return the sizes that each point allows, how far they may be off, and whether that's all.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        Of which the radius or the half-angle is asked.
    f, off : Jet
        In adapted frames, at n points, and the errors of its coefficients.
    runs : Jet
        The same as f, each time rounded at random.

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
    # By how much second and third derivatives along any direction may be off.
    two, three = (frobenius(off, k)[:, None] for k in (2, 3))
    # The radius of a ball or cylinder that touches along e is f_ee/2, see `two_conditions`.
    values = principal_values(f) / 2
    exact = np.broadcast_to(two, values.shape)
    # A pipe's ball touches along a whole circle, across which f_ee is a principal value.
    if kind == "pipe":
        certain = np.ones(len(values), dtype=bool)
        own = principal(f)[2][:, None] + [0.0, np.pi / 2]
        steady = steadiness(kind, runs, own, SHARP)
        values[steady.changes] = np.nan
        return values, exact, steady.stays, certain, ~certain
    # A cylinder's direction is a zero of f_eee, at most three at a point; f_ee there is its size.
    if kind == "cylinder":
        angle, spread, _ = zeros(lambda a: derivative_along(f, a, 3), 3, three[:, 0])
        rate = np.abs(derivative_along(f, angle, 1, 1)) + frobenius(f, 2)[:, None] * spread
        found = derivative_along(f, angle, 2) / 2
        # Where f_eee vanishes altogether every direction has its own size.
        every = (frobenius(f, 3) <= 4 * three[:, 0]) & (np.ptp(values, axis=-1) > 4 * two[:, 0])
        steady = steadiness(kind, runs, angle, SHARP)
        found[steady.changes] = np.nan
        values = np.hstack([found, values])
        stays = np.hstack([steady.stays, np.zeros(exact.shape, dtype=bool)])
        return values, np.hstack([two + 2 * rate * spread, exact]), stays, ~every, every
    # For a cone both conditions hold the half-angle. Without it they are one form, of degree 8 in
    # the direction and the same for its opposite: hence `b / 2`. Each zero has its own half-angle.
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
    _, _, turn = principal(f)
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
    bend = np.abs(principal_values(f).prod(axis=-1)) / frobenius(f, 2) ** 2
    sharp = SHARP * np.where(bend > ROUND, np.minimum(bend / BENT, 1.0) ** 2, 0.0)[:, None]
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
