"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics; the direct
problem, which integrates the equations themselves, checks it.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from ..arguments import Positions, checked
from ..surfaces import Torus
from .bounds import check_ratio
from .geodesic import Geodesic, reduced
from .geodesic_classes import inner, outer, second
from .geodesic_root import integrate, solve

AGREES = 1e-9  # rad; a turned angle that is off by more is no answer
WOUND = 17  # of the unknown of a ring's class, in its own unit: there c is r - R to fourteen digits
CLASSES = 8  # of `competing_geodesics`
FARTHEST = 10  # of the unknown of `second`, in its own unit: c is within 1e-8 of its least there
NEAREST = 1e-9  # of the same: at zero the outer equator would leave no quadrature
HALVINGS = 30


class _Ends(NamedTuple):
    """Pairs of ends, flat, in normal form: from phi = a >= 0 to phi = b, |b| <= a.

    What made them so: `mirror` is -1 where phi was mirrored, `side` -1 where theta was, `swap`
    tells where the ends were exchanged.
    """

    a: np.ndarray
    b: np.ndarray
    angle: np.ndarray
    mirror: np.ndarray
    side: np.ndarray
    swap: np.ndarray
    on_sheet: np.ndarray


class _Ways(NamedTuple):
    """A geodesic of one class between each pair of ends, in normal form."""

    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray
    kind: np.ndarray

    def settle(self, where, kind, *values):
        """Write down geodesics of a kind where a mask says, each value a number or an array."""
        self.kind[where] = kind
        for array, value in zip(self[:-1], values, strict=True):
            array[where] = value[where] if np.ndim(value) else value


@checked
def geodesic_inverse(torus: Torus, p: Positions, q: Positions):
    """Return the shortest geodesics between joint positions.

    Parameters
    ----------
    torus : Torus
        The surface: a ring, a horn, or the outer sheet of a spindle, r / R from 1e-100 to 1e100.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    geodesic : Geodesic
        Length, azimuths, Clairaut's constant, kind, certificate.

    Notes
    -----
    That nothing on the sheet is shorter is proved (report, section on geodesics), for all ends.
    Let the end with the greater |phi| come first. Of the geodesics that come to the other
    end's parallel for the first time, and not round a ring's tube, exactly one turns by a given
    angle up to pi: their turned angle grows strictly from the descending meridian to beyond pi,
    because half a swing between the turning points,

        T(c) = 2R / (R + r) int_0^(pi/2) sqrt(1 + 2r / (rho + R - r)) dx,
        1 / rho^2 = cos^2(x) / c^2 + sin^2(x) / (R + r)^2,

    falls as c grows. Every later arrival at the same end is longer, and so is a way through a node,
    or one that turns by more than pi. Round a ring's tube one geodesic turns by that angle, the
    shortest of those ways; it is looked at where the ends lie in opposite halves. So there is one
    root to find, or two, and the shorter is returned.

    The certificate says why: "meridian" for the arc between ends with the same theta; "only" up to
    turns of pi / sqrt(1 + r / R), within which no later arrival falls, since T(c) is longer (below
    pi; and no longer range will do, by the outer equator's conjugate point); "first" beyond, where
    later arrivals exist. Ends half a turn apart have a mirror image of the answer beside it, and
    so have ends with phi and -phi past their conjugate point.

    On a spindle's whole surface, its inner sheet included, the answer is the shortest where it is
    no longer than R (2 pi - |phi2 - phi1|), for no way through both nodes is shorter than that.

    Lengths are right to rounding, to 3e-14 of themselves where an end is within 0.1 rad of a node:
    see tests/references for a table of hard ones.

    Examples
    --------
    >>> geodesic = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 0.4))
    >>> round(float(geodesic.length), 12), str(geodesic.kind)
    (0.63, 'meridian')
    """
    p, q, ends = _normal_form(torus, p, q)
    outside = _near_side(torus, ends)
    # Over the inner equator only between opposite halves: else the outside is shorter.
    inside = _inside(torus, ends, ends.b < 0)
    nearer = inside.length < np.where(outside.kind == "none", np.inf, outside.length)
    shortest = _Ways(*(np.where(nearer, *pair) for pair in zip(inside, outside, strict=True)))
    return _geodesic(torus, p, q, ends, shortest)


@checked
def competing_geodesics(torus: Torus, p: Positions, q: Positions):
    """Return the shortest geodesic between joint positions, and its rivals.

    Parameters
    ----------
    torus : Torus
        The surface: a ring, a horn, or the outer sheet of a spindle, r / R from 1e-100 to 1e100.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    geodesic : Geodesic
        With one more axis in front, of length 8, the shortest first; kind "none" where there are
        fewer. Only the first has a certificate.

    Notes
    -----
    Four classes, each for the short and for the long way round the axis, both less than a whole
    turn. Let the end with the greater |phi| come first, and look at the geodesics that come to the
    other's parallel

    - for the first time: one geodesic, or none where it would have to pass a node;
    - for the second time, after a turning point on the other side: none short of a least turn, one
      to either side of it beyond, the second of them past two turning points or none;
    - over the inner equator of a ring, on the side of the farther end: one geodesic. Between two
      places on the outer equator, past its first conjugate point, it gives way to the equator.

    That the second arrivals' turn has one least value was seen on all tori that were tried; the
    rest is proved. Left out are later arrivals, each of which swings across the outer equator once
    more, and ways that wind about the tube or the axis farther. Where both ways round turn by less
    than 2 pi / sqrt(1 + r / R), two half swings, no later arrivals exist: between ends that are
    more than 17 degrees of theta apart on the reference machine's torus.
    """
    p, q, ends = _normal_form(torus, p, q)
    least = _least_second(torus, ends)
    long_way = ends._replace(angle=2 * np.pi - ends.angle, side=-ends.side)
    ways = []
    for way in (ends, long_way):
        found = _near_side(torus, way), *_second_arrivals(torus, way, least), _inside(torus, way)
        ways += [_geodesic(torus, p, q, way, one) for one in found]
    fields = ["length", "azimuth1", "azimuth2", "clairaut", "kind", "converged", "certificate"]
    stacked = [np.stack([getattr(way, name) for way in ways]) for name in fields]
    order = np.argsort(stacked[0], axis=0)  # NaN comes last
    *ranked, certificate = (np.take_along_axis(field, order, axis=0) for field in stacked)
    certificate[1:] = ""
    p = np.broadcast_to(p, (CLASSES, *p.shape))
    q = np.broadcast_to(q, (CLASSES, *q.shape))
    return Geodesic(torus, p, q, *ranked, certificate)


def _normal_form(torus, p, q):
    """Return the ends, broadcast, and the same as `_Ends`."""
    check_ratio(torus)
    p, q = np.broadcast_arrays(p, q)
    start = p.reshape(-1, 2)
    stop = q.reshape(-1, 2)
    phi1 = reduced(start[:, 1])
    phi2 = reduced(stop[:, 1])
    turn = reduced(stop[:, 0] - start[:, 0])
    # The end farther from the outer equator comes first, mirrored to phi >= 0.
    swap = np.abs(phi2) > np.abs(phi1)
    a, b = np.where(swap, (phi2, phi1), (phi1, phi2))
    mirror = np.where(a < 0, -1.0, 1.0)
    # At a node itself there is no tangent plane: it isn't on the sheet.
    on_sheet = torus.r + torus.R * np.minimum(np.cos(a), np.cos(b)) > 0
    side = np.where(turn < 0, -1.0, 1.0)
    return p, q, _Ends(a * mirror, b * mirror, np.abs(turn), mirror, side, swap, on_sheet)


def _nothing(ends):
    return _Ways(*np.full((4, ends.a.size), np.nan), np.full(ends.a.size, "none", dtype="<U8"))


def _near_side(torus, ends):
    """Return the ways over the side of the farther end, or down the outside of a meridian."""
    ways = _nothing(ends)
    a, b, angle = ends[:3]
    # On one meridian c = 0, the end of the class, which a search would only near.
    meridian = ends.on_sheet & (angle == 0)
    ways.settle(meridian, "meridian", torus.R * (a - b), 0.0, -1.0, -1.0)
    ways.settle(meridian & (a == b), "point", 0.0, 0.0, np.nan, np.nan)
    # The outer equator is shortest up to its conjugate point. In the class it is u = 0, where
    # sin(phi/2) vanishes all along and leaves no quadrature.
    equator = (angle > 0) & (a == 0) & (angle <= _conjugate_turn(torus))
    span = torus.r + torus.R
    ways.settle(equator, "outer", span * angle, span, 0.0, 0.0)
    there = ends.on_sheet & (ways.kind == "none") & (angle < _half_swing_by_the_node(torus))
    _search(torus, outer, ends, there, ways)
    return ways


def _second_arrivals(torus, ends, least):
    """Return the ways that turn on the other side: before the least turned angle, and past it."""
    before, past = _nothing(ends), _nothing(ends)
    angle = ends.angle
    unknown, turned = least
    possible = ends.on_sheet & (angle > turned)
    for ways, sense, swings in ((before, -1, 1), (past, 1, 2)):
        there = possible & (angle < swings * _half_swing_by_the_node(torus))
        _search(torus, partial(second, sense=sense), ends, there, ways, sense * unknown)
    return before, past


def _least_second(torus, ends):
    """Return the unknown of `second` with which the turned angle is least, and that angle."""
    index = np.flatnonzero(ends.on_sheet)
    a, b = ends.a[index], ends.b[index]
    unit = np.cos(a / 2) if torus.r >= torus.R else np.sqrt((torus.r / torus.R + np.cos(a)) / 2)
    # Towards either end of the class the turned angle grows: its rate changes its sign once.
    low = -FARTHEST * unit
    high = -NEAREST * unit
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        falling = integrate(torus, second(torus, a, b, middle), 96)[1] < 0
        low = np.where(falling, middle, low)
        high = np.where(falling, high, middle)
    least = np.full((2, ends.a.size), np.nan)
    least[:, index] = high, integrate(torus, second(torus, a, b, high), 96)[0]
    return least


def _half_swing_by_the_node(torus):
    """Return the turned angle of half a swing that just misses the node, in rad."""
    if torus.r >= torus.R:
        return np.inf
    return np.pi / np.sqrt((1 - torus.r / torus.R) * (1 + torus.r / torus.R))


def _inside(torus, ends, allowed=True):
    """Return the ways over a ring's inner equator, or along either equator."""
    ways = _nothing(ends)
    a, b, angle = ends[:3]
    span = torus.r + torus.R
    narrow = torus.r - torus.R
    # Past its conjugate point the outer equator is a geodesic still, though no shortest one.
    ways.settle((a == 0) & (angle > _conjugate_turn(torus)), "outer", span * angle, span, 0.0, 0.0)
    if narrow <= 0:  # the working sheet of a horn or a spindle has no inner equator
        return ways
    # Round the tube the other way, if there are two ends.
    meridian = (angle == 0) & ((b < 0) | (a > b)) & allowed
    ways.settle(meridian, "meridian", torus.R * (2 * np.pi - (a - b)), 0.0, 1.0, 1.0)
    # Along the inner equator c = r - R, the class's other end.
    both = (a == np.pi) & (np.abs(b) == np.pi)
    ways.settle(both, "inner", narrow * angle, narrow, 0.0, 0.0)
    ways.settle(both & (angle == 0), "point", 0.0, 0.0, np.nan, np.nan)
    _search(torus, inner, ends, (angle > 0) & (a > 0) & allowed & (ways.kind == "none"), ways)
    return ways


def _conjugate_turn(torus):
    """Return the turn to the first conjugate point on the outer equator, the least half swing."""
    return np.pi * np.sqrt(torus.R / (torus.r + torus.R))


def _search(torus, family, ends, possible, ways, low=None):
    """Write down the ways of a class that reach their turned angle."""
    index = np.flatnonzero(possible)
    a, b, angle = (array[index] for array in ends[:3])
    found = solve(family, torus, a, b, angle, None if low is None else low[index])
    reached = np.abs(found.turned - angle) <= AGREES
    index = index[reached]
    ways.kind[index] = "inner" if family is inner else "outer"
    for array, value in zip(ways[:-1], found[1:], strict=True):
        array[index] = value[reached]
    if torus.r > torus.R and family in (outer, inner):
        index = np.flatnonzero(possible)[~reached]
        a, b, angle = (array[index] for array in ends[:3])
        far = WOUND * (np.cos(a / 2) if family is outer else np.ones_like(a))
        wound = integrate(torus, family(torus, a, b, far), 96)[0] < angle
        _wind(torus, ends, family, index[wound], ways)


def _wind(torus, ends, family, index, ways):
    """Write down the ways of a ring that follow its inner equator to the last digit of c.

    In a given class length = c angle + int R sqrt(1 - c^2 / rho^2) dphi is stationary in c; so
    c = r - R will do.
    """
    c = torus.r - torus.R
    nodes, weights = np.polynomial.legendre.leggauss(96)
    length = c * ends.angle[index]
    cosines = []
    for end in (ends.a[index], np.abs(ends.b[index]) if family is inner else ends.b[index]):
        # From the inner equator, z = 0, to the end: the nodes, and last the end itself.
        z = np.append((np.pi - end[:, None]) * (1 + nodes) / 2, np.pi - end[:, None], axis=1)
        # rho^2 - c^2 = (rho - c)(rho + c), of which the first factor is 2 R sin^2(z/2).
        sine = np.sin(z / 2)
        rho = c + 2 * torus.R * sine**2
        cosine = sine * np.sqrt(2 * torus.R * (rho + c)) / rho
        length += torus.R * (np.pi - end) / 2 * (cosine[:, :-1] @ weights)
        cosines.append(cosine[:, -1])  # of the azimuth at the end
    kind = "inner" if family is inner else "outer"
    ways.kind[index] = kind
    ways.length[index] = length
    ways.c[index] = c
    ways.cos_a[index] = cosines[0]
    ways.cos_b[index] = cosines[1] if family is inner else -cosines[1]


def _geodesic(torus, p, q, ends, ways):
    """Return ways as a `Geodesic` between the ends as they were given."""
    # Where the ends were exchanged the way is gone backwards: that changes the sign of the cosine,
    # and of the sine twice, since the turn is reckoned from the other end, too.
    back = ends.mirror * np.where(ends.swap, -1.0, 1.0)
    rho = torus.r + torus.R * np.cos([ends.a, ends.b])
    azimuth = np.arctan2(ends.side * ways.c / rho, back * [ways.cos_a, ways.cos_b])
    first, last = np.where(ends.swap, azimuth[::-1], azimuth)
    # Within half of the shortest swing there is no second arrival.
    only = (ends.angle <= _conjugate_turn(torus)) & (ends.angle < np.pi)
    certificate = np.select(
        [ways.kind == "none", np.isin(ways.kind, ["meridian", "point"]), only],
        ["", "meridian", "only"], "first",
    )  # fmt: skip
    answers = ways.length, first, last, ends.side * ways.c, ways.kind, ways.kind != "none"
    shape = p.shape[:-1]
    return Geodesic(torus, p, q, *(v.reshape(shape)[()] for v in (*answers, certificate)))
