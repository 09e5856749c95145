"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics; the direct
problem, which integrates the equations themselves, checks it.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import Positions, checked
from ..surfaces import Torus
from .geodesic import Geodesic, reduced
from .geodesic_classes import inner, outer
from .geodesic_root import integrate, solve

AGREES = 1e-9  # rad; a turned angle that is off by more is no answer
MOST_RATIO = 1e100  # of r and R, either way
FEW = 16  # pairs whose turned angles are looked at together, within what a cache holds


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
    A shortest geodesic turns by at most pi in theta and crosses each of the circles phi = 0 and
    phi = pi at most once. That leaves two classes, and in each the turned angle grows with one
    unknown (found numerically, not proved): a root each, and the shorter one is returned.

    It needs no such trust where the certificate is "curvature". The Gaussian curvature is at most
    1 / (R (r + R)), and on the unrolled torus no geodesic closes, since theta grows all along; so
    two geodesics shorter than pi sqrt(R (r + R)) between the same ends can't be drawn into each
    other (Klingenberg). A way that turns by more than pi in theta can be reflected in a meridian
    plane, piece by piece, to one that turns by less; one round the tube the other way is longer
    than that way along a meridian; and a shortest way doesn't pass a node, where there is less
    than a full turn of surface. "meridian" is the arc between ends with the same
    theta, "compared" the shorter root only. Ends half a turn apart have a mirror image of the
    answer beside it.

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
    """Return the geodesics between joint positions that may be the shortest, and are nearly so.

    Parameters
    ----------
    torus : Torus
        The surface: a ring, a horn, or the outer sheet of a spindle, r / R from 1e-100 to 1e100.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    geodesic : Geodesic
        With one more axis in front, of length 6, the shortest first; kind "none" where there are
        fewer. Only the first has a certificate.

    Notes
    -----
    Three classes, each for the short and for the long way round the axis: over the side of the
    farther end, over the other side behind the first conjugate point, and over the inner equator
    of a ring, on the side of the farther end. On the outer equator, past that point, the equator
    itself takes the place of the third. There are others, which swing over the outer equator
    more than once or wind about the tube or the axis farther; they may be shorter than the last
    of these, not than the first.
    """
    p, q, ends = _normal_form(torus, p, q)
    ways = []
    long_way = ends._replace(angle=2 * np.pi - ends.angle, side=-ends.side)
    for way in (ends, long_way):
        for find in (_near_side, _far_side, _inside):
            ways.append(_geodesic(torus, p, q, way, find(torus, way)))
    fields = ["length", "azimuth1", "azimuth2", "clairaut", "kind", "converged", "certificate"]
    stacked = [np.stack([getattr(way, name) for way in ways]) for name in fields]
    order = np.argsort(stacked[0], axis=0)  # NaN comes last
    *ranked, certificate = (np.take_along_axis(field, order, axis=0) for field in stacked)
    certificate[1:] = ""
    p = np.broadcast_to(p, (6, *p.shape))
    q = np.broadcast_to(q, (6, *q.shape))
    return Geodesic(torus, p, q, *ranked, certificate)


def _normal_form(torus, p, q):
    """Return the ends, broadcast, and the same as `_Ends`."""
    if not 1 / MOST_RATIO <= torus.r / torus.R <= MOST_RATIO:
        raise ValueError(
            f"torus: r / R must be from {1 / MOST_RATIO:g} to {MOST_RATIO:g}, so that nothing "
            f"overflows; got {torus.r / torus.R:g}."
        )
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
    equator = (angle > 0) & (a == 0) & ~_past_conjugate(torus, ends)
    span = torus.r + torus.R
    ways.settle(equator, "outer", span * angle, span, 0.0, 0.0)
    _search(torus, outer, ends, ends.on_sheet & (ways.kind == "none"), ways)
    return ways


def _far_side(torus, ends):
    """Return the ways over the side opposite to the farther end, past the conjugate point."""
    ways = _nothing(ends)
    possible = ends.on_sheet & (ends.angle > 0)
    possible &= (ends.a > 0) | _past_conjugate(torus, ends)
    index = np.flatnonzero(possible)
    # Mirrored, they rise from -a over the outer equator and come down to -b: the same class.
    a = -ends.a[index]
    b = -ends.b[index]
    # Beyond its least, at the conjugate point, the turned angle grows again. No formula tells where
    # that is: the least of 81 values is where the search begins.
    u = np.geomspace(1e-3, 10, 81)
    low = np.full(ends.a.size, np.nan)
    for k in range(0, index.size, FEW):
        tried = outer(torus, *np.broadcast_arrays(a[k : k + FEW], b[k : k + FEW], u[:, None]))
        low[index[k : k + FEW]] = u[np.argmin(integrate(torus, tried, 96)[0], axis=0)]
    mirrored = ends._replace(a=-ends.a, b=-ends.b)
    _search(torus, outer, mirrored, possible, ways, low)
    return ways._replace(cos_a=-ways.cos_a, cos_b=-ways.cos_b)


def _inside(torus, ends, allowed=True):
    """Return the ways over a ring's inner equator, or along either equator."""
    ways = _nothing(ends)
    a, b, angle = ends[:3]
    span = torus.r + torus.R
    narrow = torus.r - torus.R
    # Past its conjugate point the outer equator is a geodesic still, though no shortest one.
    ways.settle((a == 0) & _past_conjugate(torus, ends), "outer", span * angle, span, 0.0, 0.0)
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


def _past_conjugate(torus, ends):
    """Return where the turned angle is past the first conjugate point of the outer equator."""
    return ends.angle > np.pi * np.sqrt(torus.R / (torus.r + torus.R))


def _search(torus, family, ends, possible, ways, low=None):
    """Write down the ways of a class that reach their turned angle."""
    index = np.flatnonzero(possible)
    a, b, angle = (array[index] for array in ends[:3])
    found = solve(family, torus, a, b, angle, None if low is None else low[index])
    reached = np.abs(found.turned - angle) <= AGREES
    index = index[reached]
    ways.kind[index] = family.__name__
    for array, value in zip(ways[:-1], found[1:], strict=True):
        array[index] = value[reached]


def _geodesic(torus, p, q, ends, ways):
    """Return ways as a `Geodesic` between the ends as they were given."""
    # Where the ends were exchanged the way is gone backwards: that changes the sign of the cosine,
    # and of the sine twice, since the turn is reckoned from the other end, too.
    back = ends.mirror * np.where(ends.swap, -1.0, 1.0)
    rho = torus.r + torus.R * np.cos([ends.a, ends.b])
    azimuth = np.arctan2(ends.side * ways.c / rho, back * [ways.cos_a, ways.cos_b])
    first, last = np.where(ends.swap, azimuth[::-1], azimuth)
    # Below the bound of the curvature no other way can be drawn into this one. One that can't be
    # goes round the tube the other way and is longer than that way along a meridian, or turns by
    # more than pi; of a way that does so itself nothing is claimed.
    drop = ends.a - ends.b
    other = np.where(ways.kind == "inner", drop, 2 * np.pi - drop) if torus.r > torus.R else np.inf
    lone = ways.length < np.pi * np.sqrt(torus.R * (torus.r + torus.R))
    lone &= (ways.length <= torus.R * other) & (ends.angle <= np.pi)
    certificate = np.select(
        [ways.kind == "none", ways.kind == "meridian", lone],
        ["", "meridian", "curvature"], "compared",
    )  # fmt: skip
    answers = ways.length, first, last, ends.side * ways.c, ways.kind, ways.kind != "none"
    shape = p.shape[:-1]
    return Geodesic(torus, p, q, *(v.reshape(shape)[()] for v in (*answers, certificate)))
