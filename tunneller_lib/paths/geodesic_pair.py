"""One pair of ends of a geodesic: its normal form, answers without a search, azimuths, certificate.

All is element by element, for arrays or plain numbers; `find` is the loop over pairs for
`compiled.call`. Kinds and certificates are codes here, places in `KINDS` and `CERTIFICATES`.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..compiled import loop
from ..elementwise import larger, ratio, some, square_root, where
from ..exact import two_sum
from ..repeatable import arctangent, reduced, sine_cosine
from .geodesic_classes import (
    add_nodes,
    distance,
    ends_of,
    folded,
    in_legs,
    inner,
    moving,
    outer,
    peaked,
)
from .geodesic_root import (
    AGREES,
    ROUNDS,
    newton,
    on_working_sheet,
    rule,
    start,
)

KINDS = np.array(["none", "point", "meridian", "outer", "inner"])
CERTIFICATES = np.array(["", "meridian", "only", "first"])
NONE, POINT, MERIDIAN, OUTER, INNER = range(len(KINDS))
OPEN = len(KINDS)  # the loop leaves the pair to arrays

LEVEL = 1e-30  # of the way along it, ends nearer to the outer equator count as on it
NEAR = 1e-45  # of R, a shorter way is straight; products of four lengths would vanish
LARGE = 2.0**500  # times it, what is below NEAR keeps its digits, however small it is
PI_REST = 1.2246467991473532e-16  # what pi is more than the double next to it


class Radii(NamedTuple):
    """r and R of a torus, in a power of two of m, so that R is from 1 to 2."""

    r: float
    R: float


class EndPair(NamedTuple):
    """Ends in normal form: from phi = a >= 0 to phi = b, |b| <= a, turning by an angle >= 0.

    What made them so: `mirror` is -1 where phi was mirrored, `side` -1 where theta was, `swap`
    tells where the ends were exchanged. `on_sheet` tells where both are on the working sheet.
    """

    a: np.ndarray
    b: np.ndarray
    angle: np.ndarray
    mirror: np.ndarray
    side: np.ndarray
    swap: np.ndarray
    on_sheet: np.ndarray


class Way(NamedTuple):
    """A geodesic between ends in normal form.

    Parameters
    ----------
    kind : (...) int
        Its code.
    length, c : (...) float
        Its length and Clairaut's constant, in m.
    cos_a, cos_b : (...) float
        Cosines of its azimuths.
    """

    kind: np.ndarray
    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


def radii(torus):
    """Return the `Radii` of a torus, and their unit in m."""
    unit = math.ldexp(1.0, math.frexp(torus.R)[1] - 1)
    return Radii(float(torus.r / unit), float(torus.R / unit)), unit


def turn_and_ends(p, q):
    """Return the turns from p to q (..., 2), and phi of both (n, 3), in rad, from -pi to pi."""
    p, q = p.reshape(-1, 2), q.reshape(-1, 2)
    found = np.empty((len(p), 3))
    found[:, 0] = q[:, 0] - p[:, 0]
    found[:, 1] = p[:, 1]
    found[:, 2] = q[:, 1]
    if not (np.abs(found) <= math.pi).all():
        # What the difference of far angles loses may be more than pi.
        turn, rest = two_sum(q[:, 0], -p[:, 0])
        found[:, 0] = reduced(turn) + reduced(rest)
        found = reduced(found)
    return found


def normal_form(torus, turn, phi1, phi2):
    """Return ends on a torus, phi1 and phi2, and the turn between, as an `EndPair`.

    All are in rad, from -pi to pi.
    """
    angle = abs(turn)
    # The end farther from the outer equator comes first, mirrored to phi >= 0.
    swap = abs(phi2) > abs(phi1)
    a = where(swap, phi2, phi1)
    b = where(swap, phi1, phi2)
    mirror = where(a < 0, -1.0, 1.0)
    a = a * mirror
    b = b * mirror
    # So near the outer equator, for their turn, ends are on it to the last digit of the way between
    # them and of its azimuths, and products of their sines would vanish.
    flat = torus.R * a < LEVEL * ((torus.r + torus.R) * angle)
    a = where(flat, 0.0, a)
    b = where(flat, 0.0, b)
    # At a node itself there is no tangent plane: it isn't on the sheet.
    on_sheet = rho(torus, a) > 0
    return EndPair(a, b, angle, mirror, where(turn < 0, -1.0, 1.0), swap, on_sheet)


def rho(torus, phi):
    """Return how far from the axis phi is, in rad from -pi to pi; zero at the node of a horn."""
    _, cosine = sine_cosine(phi / 2)
    return where((torus.r == torus.R) & (phi == math.pi), 0.0, distance(torus, phi, cosine))


def level(torus, pair):
    """Return as a `Way` what needs no search: a meridian, the outer equator, ends all but one."""
    a, b, angle = pair.a, pair.b, pair.angle
    # On one meridian c = 0, the end of the class, which a search would only near.
    meridian = pair.on_sheet & (angle == 0)
    # The outer equator is shortest up to its conjugate point. In the class it is u = 0, where
    # sin(phi/2) vanishes all along and leaves no quadrature.
    equator = (angle > 0) & (a == 0) & (angle <= conjugate_turn(torus))
    span = torus.r + torus.R
    kind = where(equator, OUTER, where(meridian, where(a == b, POINT, MERIDIAN), NONE))
    length = where(equator, span * angle, where(meridian, torus.R * (a - b), math.nan))
    c = where(equator, span, where(meridian, 0.0, math.nan))
    cosine = where(equator, 0.0, where(meridian, -1.0, math.nan))
    near = pair.on_sheet & (kind == NONE) & (span * angle < NEAR * torus.R) & (a - b < NEAR)
    if some(near):
        at = rho(torus, a)
        across = where(near, at * (LARGE * angle), 1.0)
        down = where(near, torus.R * (LARGE * (a - b)), 0.0)
        most = larger(across, down)  # over it, squares are neither too small nor too large
        part, rest = ratio(across, most), ratio(down, most)
        size = most * square_root(part * part + rest * rest)
        kind = where(near, OUTER, kind)
        length = where(near, size / LARGE, length)
        c = where(near, at * ratio(across, size), c)
        cosine = where(near, -ratio(down, size), cosine)
    return Way(kind, length, c, cosine, 1.0 * cosine)  # arrays of their own


def through(torus, pair):
    """Return the way along two meridians, over phi = pi, the node of a horn."""
    # Twice pi less a and -b, to the last digit.
    span = ((math.pi - pair.a) + (math.pi + pair.b)) + 2 * PI_REST
    return Way(INNER, torus.R * span, 0.0, 1.0, 1.0)


def conjugate_turn(torus):
    """Return the turn to the first conjugate point on the outer equator, the least half swing."""
    return np.pi * math.sqrt(torus.R / (torus.r + torus.R))


def azimuths(torus, pair, way):
    """Return the azimuths at the ends as they were given, and c."""
    # Where the ends were exchanged the way is gone backwards: that changes the sign of the cosine,
    # and of the sine twice, since the turn is reckoned from the other end, too.
    back = pair.mirror * where(pair.swap, -1.0, 1.0)
    c = pair.side * way.c
    first = arctangent(ratio(c, rho(torus, pair.a)), back * way.cos_a)
    last = arctangent(ratio(c, rho(torus, pair.b)), back * way.cos_b)
    undirected = way.kind <= POINT
    first = where(undirected, math.nan, first)
    last = where(undirected, math.nan, last)
    return where(pair.swap, last, first), where(pair.swap, first, last), c


def certificate(torus, pair, kind):
    """Return the code of why a way of some kind is the shortest."""
    # Within half of the shortest swing there is no second arrival.
    only = (pair.angle <= conjugate_turn(torus)) & (pair.angle < np.pi)
    found = where((kind == MERIDIAN) | (kind == POINT), 1, where(only, 2, 3))
    return where(kind == NONE, 0, found)


@cache
def padded(count):
    """Return shares and weights of a `rule`, some of no weight, eight at a time."""
    shares, weights = rule(count)
    rest = -len(shares) % 8
    return np.stack([np.pad(shares, (0, rest), mode="edge"), np.pad(weights, (0, rest))])


@loop(inlined=("growth", "two_to_bits", "add_nodes"))
def find(torus, ends, few, many, counts, rows, answers, codes):
    """Write down the shortest geodesics between pairs of ends.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : (n, 3) float
        The turn between the ends and phi of both, in rad, from -pi to pi.
    few, many : (2, k) and (2, l) float
        Quadratures: shares and weights of `padded`, for the working sheet and elsewhere.
    counts : (int, int)
        How many of them count.
    rows : (3, m) float
        Room for what nodes add, m at least k and l.
    answers : (4, n) float
        Filled with length and Clairaut's constant, in m, and both azimuths, in rad.
    codes : (2, n) int
        Filled with kinds and certificates; the kind is `OPEN` where arrays have to answer.
    """
    for i in range(len(ends)):
        pair = normal_form(torus, ends[i][0], ends[i][1], ends[i][2])
        way = _shortest(torus, pair, few, many, counts, rows)
        first, last, c = azimuths(torus, pair, way)
        answers[0][i] = way.length
        answers[1][i] = first
        answers[2][i] = last
        answers[3][i] = c
        codes[0][i] = way.kind
        codes[1][i] = certificate(torus, pair, way.kind)


def _shortest(torus, pair, few, many, counts, rows):
    """Return the shortest `Way`; its kind is `OPEN` where that takes more than this."""
    a, b, angle = pair.a, pair.b, pair.angle
    way = level(torus, pair)
    ring = torus.r > torus.R
    if not pair.on_sheet:
        return way
    # Arrays look at the other way along a meridian, and at the inner equator.
    if torus.r >= torus.R and (angle == 0 or (a == math.pi and abs(b) == math.pi)):
        return _open(way)
    if way.kind != NONE:
        return way
    ends = ends_of(torus, a, b)
    sheet = on_working_sheet(torus, a, angle)
    nodes = few if sheet else many
    count = counts[0] if sheet else counts[1]
    begin = start(torus, ends, a, b, angle)
    hard = not sheet and peaked(torus, ends, b, angle)
    way = _search(torus, ends, angle, begin, True, hard, nodes, count, rows)
    # Over the inner equator only between opposite halves: else the outside is shorter.
    if ring and b < 0 and way.kind != OPEN:
        other = _search(torus, ends, angle, (0.5, 0.0, 0.0), False, False, nodes, count, rows)
        if other.kind == OPEN or other.length < way.length:
            return other
    if torus.r == torus.R and b < 0 and way.kind != OPEN:
        other = through(torus, pair)
        if other.length < way.length:
            return other
    return way


def _search(torus, ends, angle, begin, outside, hard, nodes, count, rows):
    """Return the way of `outer`, or else of `inner`, that turns by an angle in rad."""
    u, scale, low = begin
    high = math.inf
    before = 0.0
    total = math.nan
    done = False
    for _ in range(ROUNDS):
        way = outer(torus, ends, u) if outside else inner(torus, ends, u)
        if done:
            kind = OUTER if outside else INNER
            return Way(kind, total, way.c, way.cosines[0], way.cosines[1])
        if hard:
            one, two, three = in_legs(way)
            first = _summed(torus, one, nodes, count, rows)
            second = _summed(torus, two, nodes, count, rows)
            third = _summed(torus, three, nodes, count, rows)
            turned = first[0] + second[0] + third[0]
            rate = first[1] + second[1] + third[1]
            length = first[2] + second[2] + third[2]
        else:
            turned, rate, length = _summed(torus, way, nodes, count, rows)
        miss = angle - turned
        low, high, before, step, u, done = newton(u, miss, rate, scale, low, high, before)
        # For a given angle the length is stationary in c: what u lacked hardly matters.
        total = length + way.c * miss
        reached = turned + where(step == 0, 0.0, rate * step)
        if done and not abs(reached - angle) <= AGREES:
            break
    return Way(OPEN, math.nan, math.nan, math.nan, math.nan)


def _open(way):
    return Way(OPEN, way.length, way.c, way.cos_a, way.cos_b)


def _summed(torus, way, nodes, count, rows):
    """Return what `integrate` does, by the nodes of a rule, of which so many count."""
    add_nodes(torus, way, nodes, rows)
    rate = folded(rows[1], count) + moving(torus, way)
    return folded(rows[0], count), rate, folded(rows[2], count)
