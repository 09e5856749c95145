"""Whether the size of a tool that touches a surface stays over it, by derivatives at each point.

At a point some cone of some half-angle has contact of order 4 with nearly every surface. On an
envelope its half-angle is the same everywhere, so its gradient is zero: a condition on derivatives
of one order more, which a small window can show, too.
"""

from typing import NamedTuple

import numpy as np

from .evidence import Waves
from .forms import derivative_along, frobenius
from .jet import derivative
from .rough import RUNS, scatter

SURE = 10.0  # times its error, from which on a gradient isn't zero
SIMPLE = 1e-5  # of its terms, from which on the slope at a zero is that of a simple one


class Steadiness(NamedTuple):
    """Whether sizes stay over a surface.

    Parameters
    ----------
    stays, changes : (n, m) bool
        Neither where a gradient is known too little.
    off : (n, m) float
        By how much rounding may have moved the size itself, in m or rad.
    """

    stays: np.ndarray
    changes: np.ndarray
    off: np.ndarray


def steadiness(kind, runs, angle, sharp):
    """Return where the sizes that belong to directions stay over the surface, and where not.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        Of which the radius or the half-angle is asked.
    runs : Jet
        A surface in adapted frames at n points, `RUNS` times over, each time rounded at random; of
        order 5 for cones.
    angle : (n, m) float
        Of the directions, in rad, NaN where there is none: zeros of f_eee for cylinders, of
        `eliminated` for cones; for pipes the two principal ones.
    sharp : float or (n, 1) float
        Relative error of the gradient above which it doesn't tell.

    Returns
    -------
    steadiness : Steadiness
        Of each size.
    """
    stays = True
    changes = False
    with np.errstate(all="ignore"):
        again = _found_again(kind, runs, np.tile(angle, (RUNS, 1)))
        for value, terms in gradients(kind, runs, again):
            size = np.median(terms.reshape(RUNS, *angle.shape), axis=0)
            off = scatter(value)
            middle = np.abs(np.median(value.reshape(RUNS, *angle.shape), axis=0))
            stays = stays & (middle <= off) & (off <= sharp * size)
            changes = changes | (middle > SURE * off)
        if kind == "cone":  # where two cones fall together the determinant vanishes by itself
            stays = stays & _simple(runs, again)
        return Steadiness(stays, changes, scatter(_size(kind, runs, again)))


def eliminated(f, angle):
    """Return the form of degree 8 that vanishes where some half-angle gives contact of order 4.

    Parameters
    ----------
    f : Jet
        In adapted frames, at n points.
    angle : (n or 1, m) float
        Of directions e, in rad.

    Returns
    -------
    form : (n, m) float
        Order 3 gives rho by the direction; this is order 4 with it, times a square.
    """
    few = derivative_along(f, angle, 1, 1)
    feee = derivative_along(f, angle, 3)
    fourth = 3 * few**2 * derivative_along(f, angle, 4)
    fourth = fourth - 6 * few * derivative_along(f, angle, 2, 1) * feee
    return fourth + (derivative_along(f, angle, 0, 2) - derivative_along(f, angle, 2)) * feee**2


def gradients(kind, f, angle):
    """Return the derivatives of a size along e and across it, times a factor, and their terms.

    Parameters
    ----------
    kind : {"cylinder", "pipe", "cone"}
        As for `steadiness`.
    f : Jet
        In adapted frames, at n points.
    angle : (n, m) float
        Of directions e, in rad.

    Returns
    -------
    parts : list of two pairs of (n, m) float
        Value and what it is to be compared with, for each of the two ways.
    """
    return list(_GRADIENTS[kind](f, angle))


def _found_again(kind, runs, angle):
    """Return the directions (RUNS n, m) that each run has near those of their middle."""
    if kind == "pipe":
        twice = 2 * derivative(runs, 1, 1), derivative(runs, 2, 0) - derivative(runs, 0, 2)
        turn = np.arctan2(*twice)[:, None] / 2
        return turn + np.pi / 2 * np.round((angle - turn) / (np.pi / 2))
    if kind == "cylinder":
        waves = Waves(lambda a: derivative_along(runs, a, 3), 3)
        times = 1
    else:
        waves = Waves(lambda b: eliminated(runs, b / 2), 4)
        times = 2
    for _ in range(2):  # Newton's steps
        value, slope = (waves.derivative(times * angle, k) for k in (0, 1))
        angle = angle - value / slope / times
    return angle


def _simple(f, angle):
    """Tell whether cones are surely simple ones: of Eq. 11 the derivative by the angle isn't 0."""
    turn, terms = _turn(f, angle)
    middle, size = (np.median(c.reshape(RUNS, -1, angle.shape[1]), axis=0) for c in (turn, terms))
    return np.abs(middle) > np.maximum(SURE * scatter(turn), SIMPLE * size)


def _turn(f, angle):
    d = _Along(f, angle)
    first = 3 * d(2, 1)
    second = 6 * _slope(d) * (d(0, 2) - d(2))
    return first + second, np.abs(first) + np.abs(second)


def _slope(d):
    """Return tan(half-angle), which has contact of order 3 with the direction."""
    return -d(3) / (6 * d(1, 1))


def _size(kind, f, angle):
    """Return the radius or half-angle that belongs to a direction."""
    if kind != "cone":
        return derivative_along(f, angle, 2) / 2
    return np.arctan2(
        np.abs(derivative_along(f, angle, 3)), 6 * np.abs(derivative_along(f, angle, 1, 1))
    )


def _of_pipes(f, angle):
    """Return the derivatives of f_ee along e and across, e being principal, with their sizes."""
    size = (frobenius(f, 3) + frobenius(f, 2))[:, None] + 0 * angle
    for e, w in ((3, 0), (2, 1)):
        yield derivative_along(f, angle, e, w), size


def _of_cylinders(f, angle):
    """Return the derivatives of f_ee/2 where f_eee = 0, times a factor, with their sizes.

    Near the point Eq. 11 with 23 reads p f_eee - 6 (x.w) f_ew = 0. It gives how e turns.
    """
    along = _Along(f, angle)
    by_angle = 3 * along(2, 1)
    two, three, four = (frobenius(f, k)[:, None] for k in (2, 3, 4))
    size = np.abs(by_angle) * three + 2 * np.abs(along(1, 1)) * (four + 6 * two)
    for slope, change in ((along(3), along(4)), (along(2, 1), along(3, 1) - 6 * along(1, 1))):
        yield by_angle * slope - 2 * along(1, 1) * change, size


def _of_cones(f, angle):
    """Return the derivatives of tan(half-angle), times a factor, with their sizes.

    Near the point, with tau = tan(half-angle), p = 1 + |x|^2 and kappa = 2 (tau - x.w)/p, contact
    is of order 4 where q = p f_eee + 6 (tau - x.w) f_ew and s = D_e q + kappa q_a vanish. This is
    their derivatives' determinant with those by the angle a.
    """
    d = _Along(f, angle)
    tau = _slope(d)
    turned = d(0, 2) - d(2)
    q_a, _ = _turn(f, angle)
    q_aa = 6 * d(1, 2) - 3 * d(3) - 24 * tau * d(1, 1)
    # Along e ...
    q_e = [d(4), 6 * tau * d(2, 1)]
    q_ae = 3 * d(3, 1) + 6 * d(1, 1) + 6 * tau * (d(1, 2) - d(3))
    s_e = [2 * d(3), d(5), 6 * tau * d(3, 1), 2 * tau * q_ae]
    # ... and across.
    q_w = [d(3, 1), 6 * tau * d(1, 2), -6 * d(1, 1)]
    q_aw = 3 * d(2, 2) + 6 * tau * (d(0, 3) - d(2, 1)) - 6 * turned
    s_w = [d(4, 1), 6 * tau * d(2, 2), -6 * d(2, 1), -2 * q_a, 2 * tau * q_aw]
    s_a = sum(q_w) + q_ae + 2 * tau * q_aa
    for q, s in ((q_e, s_e), (q_w, s_w)):
        terms = np.abs(q_a) * sum(map(np.abs, s)) + np.abs(s_a) * sum(map(np.abs, q))
        yield q_a * sum(s) - s_a * sum(q), terms


class _Along:
    """A jet's derivatives along e and w, by how often along each."""

    def __init__(self, f, angle):
        self.f = f
        self.angle = angle

    def __call__(self, e, w=0):
        return derivative_along(self.f, self.angle, e, w)


_GRADIENTS = {"pipe": _of_pipes, "cylinder": _of_cylinders, "cone": _of_cones}
