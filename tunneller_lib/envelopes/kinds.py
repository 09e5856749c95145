"""Classes of envelopes: which directions and sizes of a tool agree with a surface at its points.

A tool envelops a surface if two forms of a direction e have a common zero at each point, see
`evidence`. In the adapted frame, with w across e, the forms are made of f_ee, f_ew, f_eee and so
on. `KINDS` holds one member for each class. What makes no sense for a class, as the sizes of
channels, raises NotImplementedError.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from .circle_roots import Waves, real_zeros
from .evidence import RUNS, SHARP, Forms, scatter, zeros
from .jet import (
    derivative,
    derivative_along,
    frobenius,
    frobenius_along,
    principal,
    principal_values,
)

NEEDLE = 1e-4  # rad; half-angles nearer than this to 0 or pi/2 are not looked for
UMBILIC = 1e-9  # relative difference of principal radii, up to which they count as equal
TRIALS = 4  # points whose own solutions are tried as a common radius or angle
SURE = 10.0  # a gradient above so many times its error isn't zero
SIMPLE = 1e-5  # a zero is simple if the slope there is above this share of its terms
ROUND = 1e-3  # |K|/|II|^2; above it a point can tell all half-angles that it allows
BENT = 0.1  # |K|/|II|^2; below it the evidence must be sharper
_SOME = np.pi * np.arange(12)[None] / 12  # directions
_MANY = np.pi * np.arange(180)[None] / 180


class AllowedSizes(NamedTuple):
    """The sizes of a tool that each of n points allows.

    Parameters
    ----------
    values, unsure : (n, m) float
        Sizes and how far they may be off, in m or rad; NaN-padded. Those that change over the
        surface are left out.
    stays : (n, m) bool
        Whether a size surely doesn't change.
    complete : (n,) bool
        Whether no other size is possible.
    every : (n,) bool
        Whether each size of a range is possible.
    """

    values: np.ndarray
    unsure: np.ndarray
    stays: np.ndarray
    complete: np.ndarray
    every: np.ndarray


class Steadiness(NamedTuple):
    """Whether sizes stay the same over a surface.

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


class Envelope:
    """A class of envelopes by tools of a `measure`, "radius" or "half_angle", if they have one."""

    measure = None

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        """Return the class' two conditions on a direction.

        Parameters
        ----------
        f, off : Jet
            A surface at n points and the errors of its coefficients: in adapted frames, or for
            ruled surfaces as graphs over their tangent planes.
        size, unsure : float
            The radius in m or half-angle in rad, and by how much it may be off.
        floor : float
            Order 4 is compared with the sum of its terms, or with this share of the size of the
            jet if that is more.

        Returns
        -------
        conditions : Forms
            By Theorem 4 for ruled surfaces, Corollaries 25, 28 and 29 for cylinders, channels and
            pipes, Eqs 11 and 12 for cones.
        """
        raise NotImplementedError

    def residual(self, f, size):
        """Return the residual of the worst point, 0 to 1, and the size of the tool for it.

        Parameters
        ----------
        f : Jet
            In adapted frames, at n points.
        size : float or None
            The radius in m or half-angle in rad; the best one is looked for unless given.

        Returns
        -------
        residual : float
            What the condition of the highest order leaves where those of lower order hold, over
            the size of its terms; it has no unit.
        size : float or None
            As given, or found; None of channels, and of spheres, which fit every half-angle.
        """
        raise NotImplementedError

    def sizes(self, f, off, runs):
        """Return the `AllowedSizes` of points, by jets as for `conditions` and `steadiness`."""
        raise NotImplementedError

    def found_again(self, runs, angle):
        """Return the directions (RUNS n, m) of each run near given ones, `angle` (RUNS n, m)."""
        raise NotImplementedError

    def gradients(self, f, angle):
        """Return derivatives of the size along e and across it, times a factor, with their terms.

        These are two pairs of (n, m): the derivative, and the sum of the sizes of its terms. The
        jet f is one in adapted frames, and `angle` (n, m) that of e.
        """
        raise NotImplementedError

    def size_at(self, f, angle):
        """Return the sizes (n, m) that belong to directions at angles (n, m), for a jet f."""
        return derivative_along(f, angle, 2) / 2

    def simple(self, runs, angle):
        """Tell where solutions are surely simple, by the angles `found_again` in the runs."""
        return True

    def scaled(self, size, share):
        """Return a size that is larger by a share."""
        return (1 + share) * size

    def counted(self, f, off, evidence):
        """Return evidence, by f and its errors `off`, without solutions that prove nothing."""
        return evidence

    def steadiness(self, runs, angle, sharp):
        """Return where the sizes that belong to directions stay the same over the surface.

        At a point some cone of some half-angle has contact of order 4 with nearly every surface.
        On an envelope its half-angle is the same everywhere, so its gradient is zero: a condition
        on derivatives of one order more, which a small window can show, too.

        Parameters
        ----------
        runs : Jet
            A surface in adapted frames at n points, `RUNS` times over, each time rounded at
            random; of order 5 for cones.
        angle : (n, m) float
            Of the directions, in rad, NaN where there is none: zeros of f_eee for cylinders, of
            `eliminated` for cones; for pipes the two principal ones.
        sharp : float or (n, 1) float
            Relative error above which a gradient doesn't tell.

        Returns
        -------
        steadiness : Steadiness
            Of each size.
        """
        stays = True
        changes = False
        with np.errstate(all="ignore"):
            again = self.found_again(runs, np.tile(angle, (RUNS, 1)))
            for value, terms in self.gradients(runs, again):
                size = np.median(terms.reshape(RUNS, *angle.shape), axis=0)
                off = scatter(value)
                middle = np.abs(np.median(value.reshape(RUNS, *angle.shape), axis=0))
                stays = stays & (middle <= off) & (off <= sharp * size)
                changes = changes | (middle > SURE * off)
            stays = stays & self.simple(runs, again)
            return Steadiness(stays, changes, scatter(self.size_at(runs, again)))


class _Ruled(Envelope):
    """Theorem 4, on graphs over the tangent planes: f_ee = f_eee = 0."""

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        # Near an edge of regression the asymptotic directions nearly coincide, and derivatives
        # across them are huge. A small f_eee beside those is no sign of a line, so the size counts
        # lengths across e only as far as the other asymptotic direction leans.
        def size_of_lines(a):
            turn = np.abs(derivative_along(f, a, 0, 2))
            angle = np.arctan2(2 * np.abs(derivative_along(f, a, 1, 1)), turn)
            width = np.minimum(np.tan(angle), 1.0)
            return frobenius_along(f, a, width, 3) + frobenius_along(f, a, width, 2) ** 2

        first, third = _along(f, 2), _along(f, 3)
        return Forms(first, third, 2, frobenius(off, 2), frobenius(off, 3), size_of_lines)

    def residual(self, f, size):
        return float(_line_contact(f, 0.0, frobenius(f, 2) ** 2).max(initial=0.0)), None


class _Cylinder(Envelope):
    """Corollary 25 in adapted frames: f_ee = 2 R and f_eee = 0."""

    measure = "radius"

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        off_first = frobenius(off, 2) + 2 * unsure
        whole = _constant(frobenius(f, 3) + frobenius(f, 2))
        third = _along(f, 3)
        return Forms(_along(f, 2, less=2 * size), third, 2, off_first, frobenius(off, 3), whole)

    def residual(self, f, size):
        def of(radius):
            return float(np.max(_line_contact(f, 2 * radius, frobenius(f, 2))))

        if size is not None:
            return of(size), size
        # A common radius is f_ee/2 at one of the zeros of f_eee, at most six a point. Where f_eee
        # vanishes altogether every direction is one, and the extremes are tried.
        unit = frobenius(f, 2) + frobenius(f, 3)
        angle, _ = real_zeros(_along(f, 3), 3, unit=unit)
        twice = np.hstack([derivative_along(f, angle, 2), principal_values(f)])
        return _common(twice / 2, of)

    def sizes(self, f, off, runs):
        # A cylinder's direction is a zero of f_eee, at most three at a point; f_ee there is twice
        # its radius.
        two, three = (frobenius(off, k)[:, None] for k in (2, 3))
        extremes = principal_values(f) / 2
        exact = np.broadcast_to(two, extremes.shape)
        angle, spread, _ = zeros(_along(f, 3), 3, three[:, 0])
        rate = np.abs(derivative_along(f, angle, 1, 1)) + frobenius(f, 2)[:, None] * spread
        found = derivative_along(f, angle, 2) / 2
        # Where f_eee vanishes altogether every direction has its own size.
        every = (frobenius(f, 3) <= 4 * three[:, 0]) & (np.ptp(extremes, axis=-1) > 4 * two[:, 0])
        steady = self.steadiness(runs, angle, SHARP)
        found[steady.changes] = np.nan
        values = np.hstack([found, extremes])
        stays = np.hstack([steady.stays, np.zeros(exact.shape, dtype=bool)])
        return AllowedSizes(
            values, np.hstack([two + 2 * rate * spread, exact]), stays, ~every, every
        )

    def found_again(self, runs, angle):
        return _newton(Waves(_along(runs, 3), 3), angle, 1)

    def gradients(self, f, angle):
        """Return the derivatives of f_ee/2 where f_eee = 0, times a factor, with their sizes.

        Near the point Eq. 11 with 23 reads p f_eee - 6 (x.w) f_ew = 0. It gives how e turns.
        """
        along = partial(derivative_along, f, angle)
        by_angle = 3 * along(2, 1)
        two, three, four = (frobenius(f, k)[:, None] for k in (2, 3, 4))
        size = np.abs(by_angle) * three + 2 * np.abs(along(1, 1)) * (four + 6 * two)
        ways = (along(3), along(4)), (along(2, 1), along(3, 1) - 6 * along(1, 1))
        return [(by_angle * slope - 2 * along(1, 1) * change, size) for slope, change in ways]


class _Channel(Envelope):
    """Corollary 28: f_ew = f_eee = 0, a principal direction whose curvature doesn't change."""

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        whole = _constant(frobenius(f, 3) + frobenius(f, 2))
        third = _along(f, 3)
        return Forms(_along(f, 1, 1), third, 2, frobenius(off, 2), frobenius(off, 3), whole)

    def residual(self, f, size):
        """Return how far f_eee is from 0 in the principal directions, as a share; and no size.

        Examples
        --------
        Radii that differ by a ten-millionth tell the principal directions, equal ones don't:

        >>> from .jet import jet_variables
        >>> x, y = jet_variables([0.0], [0.0])
        >>> uneven = (x**3 + y**3) / 6
        >>> nearly, equal = (((1 + part) * x * x + y * y) / 2 + uneven for part in (1e-7, 0.0))
        >>> channel = KINDS["channel"]
        >>> round(channel.residual(nearly, None)[0], 3), channel.residual(equal, None)[0]
        (0.354, 0.0)
        """
        low, high, _ = principal(f)
        # f_ew = 0 in the principal directions alone: of the two, the better one counts.
        left = np.abs(derivative_along(f, _principal_ways(f), 3)).min(axis=-1)
        left = left / (frobenius(f, 3) + frobenius(f, 2))
        # In an umbilic every direction is principal, and in some of them f_eee vanishes.
        differ = high - low > UMBILIC * frobenius(f, 2)
        return float(np.max(np.where(differ, left, 0.0))), None


class _Pipe(Envelope):
    """Corollary 29: f_ew = 0 and f_ee = 2 R, a principal direction of the radius' curvature."""

    measure = "radius"

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        two = frobenius(off, 2)
        whole = _constant(frobenius(f, 2) + 2 * abs(size))
        first = _along(f, 1, 1)
        return Forms(first, _along(f, 2, less=2 * size), 2, two, two + 2 * unsure, whole)

    def residual(self, f, size):
        values = principal_values(f)

        def of(radius):
            scale = np.abs(values).sum(axis=-1) + 2 * abs(radius)
            return float(np.max(np.abs(values - 2 * radius).min(axis=-1) / scale))

        return (of(size), size) if size is not None else _common(values / 2, of)

    def sizes(self, f, off, runs):
        # A pipe's ball touches along a whole circle, across which f_ee is a principal value.
        values = principal_values(f) / 2
        steady = self.steadiness(runs, _principal_ways(f), SHARP)
        values[steady.changes] = np.nan
        certain = np.ones(len(values), dtype=bool)
        exact = np.broadcast_to(frobenius(off, 2)[:, None], values.shape)
        return AllowedSizes(values, exact, steady.stays, certain, ~certain)

    def found_again(self, runs, angle):
        twice = 2 * derivative(runs, 1, 1), derivative(runs, 2, 0) - derivative(runs, 0, 2)
        turn = np.arctan2(*twice)[:, None] / 2
        return turn + np.pi / 2 * np.round((angle - turn) / (np.pi / 2))

    def gradients(self, f, angle):
        # Of f_ee, whose direction e is principal: no turn of e changes it to first order.
        size = (frobenius(f, 3) + frobenius(f, 2))[:, None] + 0 * angle
        return [(derivative_along(f, angle, e, w), size) for e, w in ((3, 0), (2, 1))]


class _Cone(Envelope):
    """Theorem 16, by Eqs 11 and 12: rho f_eee + 3 f_ew = 0 and contact of order 4."""

    measure = "half_angle"

    def conditions(self, f, off, size=None, unsure=0.0, floor=1.0):
        rho = 0.5 / np.tan(size)  # radius of the circle over which the cone's planes lie
        unsure = unsure * 0.5 / np.sin(size) ** 2  # and its own error
        third, mixed = _along(f, 3), _along(f, 1, 1)

        def terms(a):
            last = derivative_along(f, a, 0, 2) - derivative_along(f, a, 2)
            fourth = rho**2 * derivative_along(f, a, 4)
            return [fourth, 6 * rho * derivative_along(f, a, 2, 1), 3 * last]

        # Terms that cancel to nearly nothing must not pass for a condition of no size.
        def size_4(a):
            return np.maximum(sum(np.abs(term) for term in terms(a)), floor * whole[:, None])

        whole = rho**2 * frobenius(f, 4) + 6 * rho * frobenius(f, 3) + 3 * frobenius(f, 2)
        two, three, four = (frobenius(off, k) for k in (2, 3, 4))
        off_3 = rho * three + 3 * two + unsure * frobenius(f, 3)
        off_4 = rho**2 * four + 6 * rho * three + 6 * two
        off_4 = off_4 + unsure * (2 * rho * frobenius(f, 4) + 6 * frobenius(f, 3))
        first = lambda a: rho * third(a) + 3 * mixed(a)  # noqa: E731
        return Forms(first, lambda a: sum(terms(a)), 3, off_3, off_4, size_4)

    def residual(self, f, size):
        def of(half_angle):
            forms = self.conditions(f, f, half_angle, floor=1e-3)
            angle, _ = real_zeros(forms.first, forms.degree, unit=forms.off_first)
            left = np.abs(forms.second(angle)) / _nonzero(forms.size(angle))
            left[np.isnan(left).all(axis=-1)] = 0.0  # spherical points: every cone that touches
            return float(np.nanmin(left, axis=-1).max())

        if size is not None:
            return of(size), size
        # Order 3 gives rho by the direction, which put into order 4 leaves a form of degree 8,
        # even in e: in the doubled angle a trigonometric polynomial of degree 4.
        two, three, four = (frobenius(f, k) for k in (2, 3, 4))
        unit = two**2 * (three + four) + two * three**2 + two**3
        angle, _ = real_zeros(lambda b: eliminated(f, b / 2), 4, unit=unit)
        # e and -e are one zero here, and have rho of either sign: of the two one is a cone.
        found = self.size_at(f, angle / 2)
        found[(found < NEEDLE) | (found > np.pi / 2 - NEEDLE)] = np.nan
        # A sphere fits every angle; a surface that no angle fits doesn't fit this one either.
        if np.isnan(found).all():
            return of(np.pi / 4), None
        return _common(found, of)

    def sizes(self, f, off, runs):
        """Return the half-angles that each point allows.

        Zeros of the eliminated form are directions of cones, and each direction gives a half-angle
        with its error. The circles of a channel's own spheres give others. Left out are half-angles
        that are vague, out of range, or change over the surface, and zeros without one of their
        own. A point's list is complete if it lacks none that isn't known well.
        """
        # Both conditions hold the half-angle. Without it they are one form, of degree 8 in the
        # direction and the same for its opposite: hence `b / 2`. Each zero has its own half-angle.
        two, three = (frobenius(off, k)[:, None] for k in (2, 3))
        slack = scatter(eliminated(runs, _SOME)).max(axis=-1, keepdims=True)  # the form's error
        angle, spread, _ = zeros(lambda b: eliminated(f, b / 2), 4, slack[:, 0])
        angle, spread = angle / 2, spread / 2
        # The last eight of `zeros` are places where the form only turns. There it must be as near
        # to zero as rounding takes it in that direction.
        turns = angle[:, 8:]
        near = scatter(eliminated(runs, np.tile(turns, (RUNS, 1))))
        turns[np.abs(eliminated(f, turns)) > SURE * near] = np.nan
        # tan(half-angle) is a quotient of two derivatives: down/(2 up).
        up = 3 * derivative_along(f, angle, 1, 1)
        down = derivative_along(f, angle, 3)
        off_up = 3 * two + 6 * frobenius(f, 2)[:, None] * spread
        off_down = three + 3 * frobenius(f, 3)[:, None] * spread
        angles = np.arctan2(np.abs(down), 2 * np.abs(up))
        with np.errstate(divide="ignore", invalid="ignore"):
            unsure = 2 * (off_down + 2 * off_up) / np.hypot(down, 2 * up)
        # How far the runs are apart says more than bounds do. Towards the parabolic curve
        # derivatives grow, and what differs between sizes is small among their terms.
        bend = np.abs(principal_values(f).prod(axis=-1)) / frobenius(f, 2) ** 2
        sharp = SHARP * np.where(bend > ROUND, np.minimum(bend / BENT, 1.0) ** 2, 0.0)[:, None]
        steady = self.steadiness(runs, angle, sharp)
        unsure = np.fmin(unsure, steady.off)
        # The circles of a channel's own spheres have sizes besides.
        of_circle, off_circle = _own_circles(f, two, three)
        circle = ~np.isnan(of_circle)
        none = np.zeros_like(circle)
        # A zero of the eliminated form at such a circle, where both derivatives vanish, has no
        # half-angle of its own: 0/0.
        passing = circle.any(axis=-1)[:, None] & (np.abs(up) <= off_up) & (np.abs(down) <= off_down)
        passing, stays, changes = (
            np.hstack([part, none]) for part in (passing, steady.stays, steady.changes)
        )
        angles = np.hstack([angles, of_circle])
        unsure = np.hstack([unsure, off_circle])
        vague = ~np.isnan(angles) & ~(unsure <= 0.1) & ~changes
        every = np.abs(eliminated(f, _SOME)).max(axis=-1) <= 4 * slack[:, 0]
        # Near the parabolic curve zeros crowd, and one may be lost; so may a pair between samples.
        signs = np.sign(eliminated(f, _MANY))
        crossings = np.count_nonzero(signs != np.roll(signs, 1, axis=-1), axis=-1)
        complete = ~(vague & ~passing).any(axis=-1) & ~every & (bend > ROUND)
        complete &= crossings <= np.count_nonzero(~np.isnan(angle), axis=-1)
        outside = (angles < NEEDLE) | (angles > np.pi / 2 - NEEDLE)
        angles[vague | passing | outside | changes] = np.nan
        return AllowedSizes(angles, np.where(np.isnan(angles), 0.0, unsure), stays, complete, every)

    def found_again(self, runs, angle):
        return _newton(Waves(lambda b: eliminated(runs, b / 2), 4), angle, 2)

    def gradients(self, f, angle):
        """Return the derivatives of tan(half-angle), times a factor, with their sizes.

        Near the point, with tau = tan(half-angle), p = 1 + |x|^2 and kappa = 2 (tau - x.w)/p,
        contact is of order 4 where q = p f_eee + 6 (tau - x.w) f_ew and s = D_e q + kappa q_a
        vanish. This is their derivatives' determinant with those by the angle a.
        """
        d = partial(derivative_along, f, angle)
        tau = _tangent(d)
        turned = d(0, 2) - d(2)
        q_a, _ = turn_of_eq11(f, angle)
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
        found = []
        for q, s in ((q_e, s_e), (q_w, s_w)):
            terms = np.abs(q_a) * sum(map(np.abs, s)) + np.abs(s_a) * sum(map(np.abs, q))
            found.append((q_a * sum(s) - s_a * sum(q), terms))
        return found

    def size_at(self, f, angle):
        few, feee = derivative_along(f, angle, 1, 1), derivative_along(f, angle, 3)
        return np.arctan2(np.abs(feee), 6 * np.abs(few))

    def simple(self, runs, angle):
        # Where two cones fall together the determinant of `gradients` vanishes by itself.
        turn, terms = turn_of_eq11(runs, angle)
        middle, size = (np.median(c.reshape(RUNS, -1, angle.shape[1]), 0) for c in (turn, terms))
        return np.abs(middle) > np.maximum(SURE * scatter(turn), SIMPLE * size)

    def scaled(self, size, share):
        return np.arctan((1 + share) * np.tan(size))  # the tangent is larger by the share

    def counted(self, f, off, evidence):
        # Multiple solutions stay if f_ew = 0; else Eq. 12 says nothing of them (Problem 15).
        few = np.abs(derivative_along(f, evidence.angle, 1, 1))
        bound = frobenius(off, 2)[:, None] + 4 * frobenius(f, 2)[:, None] * evidence.spread
        counts = ~np.isnan(evidence.angle) & ~(evidence.several & (few > bound))
        anything = evidence.agrees & np.isnan(evidence.angle).all(axis=-1)
        return evidence._replace(agrees=counts.any(axis=-1) | anything)


KINDS = {
    "ruled": _Ruled(),
    "cylinder": _Cylinder(),
    "channel": _Channel(),
    "pipe": _Pipe(),
    "cone": _Cone(),
}


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


def _own_circles(f, two, three):
    """Return the half-angles that a channel's own circles allow, NaN elsewhere, and their errors.

    On such a circle f_ew = f_eee = 0, and rho f_eew + f_ww - f_ee = 0 by Problem 15's answer.
    `two` and `three` are the errors of second and third derivatives (n, 1).
    """
    own = _principal_ways(f)
    mu = derivative_along(f, own, 2) - derivative_along(f, own, 0, 2)
    twist = derivative_along(f, own, 2, 1)
    turned = two / np.where(mu == 0, np.inf, np.abs(mu))  # of the principal directions, in rad
    off_twist = three + 3 * frobenius(f, 3)[:, None] * turned
    circle = np.abs(derivative_along(f, own, 3)) <= off_twist
    with np.errstate(divide="ignore", invalid="ignore"):
        unsure = 2 * (off_twist + 4 * two) / np.hypot(twist, 2 * mu)
    return np.where(circle, np.arctan2(np.abs(twist), 2 * np.abs(mu)), np.nan), unsure


def turn_of_eq11(f, angle):
    """Return the derivative of Eq. 11 by the angle where it holds, and the sum of its terms."""
    d = partial(derivative_along, f, angle)
    first = 3 * d(2, 1)
    second = 6 * _tangent(d) * (d(0, 2) - d(2))
    return first + second, np.abs(first) + np.abs(second)


def _tangent(d):
    """Return tan(half-angle) of the cone with contact of order 3 along a direction."""
    return -d(3) / (6 * d(1, 1))


def _along(f, e, w=0, *, less=0.0):
    """Return a function of angles: a derivative along directions, less a number."""
    return lambda a: derivative_along(f, a, e, w) - less


def _principal_ways(f):
    """Return the angles (n, 2) of both principal directions, in rad."""
    return principal(f)[2][:, None] + [0.0, np.pi / 2]


def _constant(size):
    """Return a function of angles (n, m) whose values are the numbers of `size` (n,)."""
    return lambda a: size[:, None] + 0 * a


def _newton(waves, angle, times):
    """Return zeros of polynomials in a multiple of the angle, by Newton steps from near them."""
    for _ in range(2):
        value, slope = (waves.derivative(times * angle, k) for k in (0, 1))
        angle = angle - value / slope / times
    return angle


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


def _common(candidates, residual):
    """Return the least residual and its value, among candidates (n, m) that the points share."""
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
