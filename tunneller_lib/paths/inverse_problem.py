"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics; the direct
problem, which follows a geodesic from its start, checks it. Ends come in a normal form; `answer` is
the whole way from two ends to numbers, for plain numbers and compiled loops; arrays take the same
steps for all pairs at once. Kinds and certificates are codes, places in `KINDS` and `CERTIFICATES`.
"""

import math
from dataclasses import dataclass
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from ..arguments import Positions, checked, none_outside
from ..kernels import compiled
from ..kernels.compiled import loop
from ..kernels.elementwise import NUMBERS, PLAIN, divided, larger, ratio, some, square_root, where
from ..kernels.exact import two_sum
from ..kernels.repeatable import arctangent, reduced
from ..surfaces import Torus
from .bounds import Count, check_ratio
from .direct_problem import followed
from .geodesic_root import (
    AGREES,
    NODES,
    NODES_OF_RING,
    NODES_OF_WORKING_SHEET,
    PI_REST,
    Radii,
    ends_at,
    find_root,
    half_angles,
    half_swing_by_the_node,
    inner,
    integrate,
    on_working_sheet,
    outer,
    peaked,
    rule,
    second,
    solve,
    start,
)

KINDS = np.array(["none", "point", "meridian", "outer", "inner"])
CERTIFICATES = np.array(["", "meridian", "only", "first"])
NONE, POINT, MERIDIAN, OUTER, INNER = range(len(KINDS))
OPEN = len(KINDS)  # plain numbers leave the pair to arrays

LEVEL = 1e-30  # of the way along it, ends nearer to the outer equator count as on it
NEAR = 1e-45  # of R, a shorter way is straight; products of four lengths would vanish
LARGE = 2.0**500  # times it, what is below NEAR keeps its digits, however small it is
WOUND = 17  # of the unknown of a ring's class, in its own unit: there c is r - R to fourteen digits
CLASSES = 8  # of `competing_geodesics`
FARTHEST = 10  # of the unknown of `second`, in its own unit: c is within 1e-8 of its least there
NEAREST = 1e-9  # of the same: at zero the outer equator would leave no quadrature
HALVINGS = 30
BLOCK = 8192  # pairs at a time: they need the same room however many there are
FEW = 12  # pairs, which plain numbers answer sooner than arrays
# s for a pair, on the working sheet and on a ring.
BY_ARRAYS = 8e-6, 35e-6
ONE_BY_ONE = 1e-4, 4e-4


@dataclass(frozen=True, eq=False)
class Geodesic:
    """Shortest geodesics between pairs of points: made by `geodesic_inverse`.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad.
    length : (...) float
        In m; NaN where there is no answer.
    azimuth1, azimuth2 : (...) float
        Directions at p and q, in rad; NaN where the ends coincide or there is no answer.
    clairaut : (...) float
        rho sin(azimuth), in m, the same all along.
    kind_code, certificate_code : (...) uint8
        What `kind` and `certificate` say in words.
    """

    torus: Torus
    p: np.ndarray
    q: np.ndarray
    length: np.ndarray
    azimuth1: np.ndarray
    azimuth2: np.ndarray
    clairaut: np.ndarray
    kind_code: np.ndarray
    certificate_code: np.ndarray

    @property
    def kind(self):
        """Return kinds as (...) str.

        "meridian", "outer", "inner" (over the inner equator of a ring torus, or through the node
        of a horn), "point" (the ends coincide), or "none" where an end isn't on the working sheet.
        """
        return KINDS[self.kind_code]

    @property
    def certificate(self):
        """Return why each is the shortest, as (...) str: see `geodesic_inverse`.

        "meridian", "only" or "first"; empty where there is no answer, and of rivals.
        """
        return CERTIFICATES[self.certificate_code]

    @property
    def converged(self):
        """Return where there is an answer, whose turned angle is met to 1e-9 rad, as (...) bool."""
        return self.kind_code != NONE

    @property
    def certified(self):
        """Return where it is proved that nothing is shorter, as (...) bool."""
        return self.certificate_code != 0

    @checked
    def points(self, n: Count):
        """Return points of each geodesic, equally spaced in arc.

        Parameters
        ----------
        n : int
            Number of points, both ends included, from 2 to a million, and at most 5 million of
            all geodesics together.

        Returns
        -------
        points : GeodesicPoints
            As by `geodesic_direct`; NaN where there is no answer. On a ring that is nearly a horn,
            or very wide, geodesics by the inner equator part so fast that the last point lies
            beside q: by 3e-7 m on Torus(1 + 1e-7, 1), by 0.01 m on r = 100 R. The length holds.
        """
        azimuth = np.where(self.kind_code == POINT, 0.0, self.azimuth1)
        way = followed(self.torus, self.p, azimuth, self.length, n, self.clairaut)
        if self.torus.r == self.torus.R:
            # Through the node of a horn, where the meridians of both ends meet.
            turn, phi, _ = turn_and_ends(self.p, self.q).T.reshape(3, *self.p.shape[:-1], 1)
            passed = way.s > self.torus.R * (np.pi - abs(phi))
            through = (self.kind_code == INNER)[..., None] & passed
            way.position[..., 0] += np.where(through, turn, 0.0)
        return way


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
        Length, azimuths, Clairaut's constant, kind, certificate. Where an end isn't on the working
        sheet, r + R cos(phi) > 0, the kind is "none", the certificate empty, and the numbers are
        NaN; all other ends have an answer.

    Notes
    -----
    That nothing on the sheet is shorter is proved (report, section on geodesics), for all ends.
    Let the end with the greater |phi| come first. Of the geodesics that come to the other
    end's parallel for the first time, and not round a ring's tube, exactly one turns by a given
    angle up to pi: their turned angle grows strictly from the descending meridian to beyond pi,
    because half a swing between the turning points,

        T(c) = 2R / (R + r) int_0^(pi/2) sqrt(1 + 2r / (rho + R - r)) dx,
        1 / rho^2 = cos^2(x) / c^2 + sin^2(x) / (R + r)^2,

    falls as c grows. Every later arrival at the same end is longer, and so is a way that leaves a
    node on the side where it entered, or one that turns by more than pi. Round a ring's tube one
    geodesic turns by that angle, the shortest of those ways; it is looked at where the ends lie in
    opposite halves. On a horn, r = R, both nodes are one point: there two arcs of meridians
    through it take that geodesic's place, kind "inner", R (2 pi - |phi1| - |phi2|) long. So there
    is one root to find, or two, and the shorter way is returned. As r falls to R the lengths tend
    to the horn's. As it grows to R they don't: on the outer sheet a spindle's nodes remain apart.

    The certificate says why: "meridian" for the arc between ends with the same theta; "only" up to
    turns of pi / sqrt(1 + r / R), within which no later arrival falls, since T(c) is longer (below
    pi; and no longer range will do, by the outer equator's conjugate point); "first" beyond, where
    later arrivals exist. Ends half a turn apart have a mirror image of the answer beside it, and
    so have ends with phi and -phi past their conjugate point.

    On a spindle's whole surface, its inner sheet included, the answer is the shortest where it is
    no longer than R (2 pi - |phi2 - phi1|), for no way through both nodes is shorter than that.

    Lengths are right to rounding. Where an end is within 0.1 rad of a node they are right to 3e-14
    of themselves, ways shorter than 0.01 R to 2e-15 R; and to 2e-13 R where a way all but touches
    a node or the axis, on what is nearly a sphere or a horn. See tests/references for a table of
    hard ones. Far angles are reduced as exactly as by `Torus.point`. Ends nearer than 1e-45 R are
    joined in the tangent plane; only ends that are the same are a point, without a direction.

    Examples
    --------
    >>> geodesic = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 0.4))
    >>> round(float(geodesic.length), 12), str(geodesic.kind)
    (0.63, 'meridian')
    >>> off = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 2))  # on the inner sheet
    >>> float(off.length), str(off.kind)
    (nan, 'none')
    """
    check_ratio(torus)
    if p.shape != q.shape:
        p, q = np.broadcast_arrays(p, q)
    shape = p.shape[:-1]
    ends = turn_and_ends(p, q)
    size, unit = radii(torus)
    answers = np.empty((6, len(ends)))
    each = ONE_BY_ONE if len(ends) <= FEW else BY_ARRAYS
    compiled.expect(each[size.r > size.R] * len(ends), "geodesics")

    def fill(block):
        answers[:, block] = _answers(size, ends[block])

    compiled.each_block(fill, len(ends), BLOCK, "geodesics")
    answers[0:4:3] *= unit  # length and Clairaut's constant
    fields = *answers[:4], *answers[4:].astype(np.uint8)
    return Geodesic(torus, p, q, *(one.reshape(shape)[()] for one in fields))


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
    - over the inner equator of a ring, on the side of the farther end: one geodesic; on a horn one
      way through the node, along two meridians, whichever way round. Between two
      places on the outer equator, past its first conjugate point, it gives way to the equator.

    That the second arrivals' turn has one least value was seen on all tori that were tried; the
    rest is proved. Left out are later arrivals, each of which swings across the outer equator once
    more, and ways that wind about the tube or the axis farther. Where both ways round turn by less
    than 2 pi / sqrt(1 + r / R), two half swings, no later arrivals exist: between ends that are
    more than 17 degrees of theta apart on the reference machine's torus.
    """
    check_ratio(torus)
    p, q = np.broadcast_arrays(p, q)
    size, unit = radii(torus)
    pair = normal_form(size, *turn_and_ends(p, q).T)
    least = _least_second(size, pair)
    long_way = pair._replace(angle=2 * np.pi - pair.angle, side=-pair.side)
    # Both at once, which takes a pair hardly longer than one.
    both = EndPair(*(np.concatenate(two, axis=-1) for two in zip(pair, long_way, strict=True)))
    later = _second_arrivals(size, both, np.tile(least, 2))
    classes = _near_side(size, both), *later, _inside(size, both)
    found = [(one.length, *azimuths(both, one), one.kind) for one in classes]
    *answers, kinds = (
        np.concatenate(np.split(np.stack(field), 2, axis=1)) for field in zip(*found, strict=True)
    )
    order = np.argsort(answers[0], axis=0)  # NaN comes last
    *answers, kinds = (np.take_along_axis(field, order, axis=0) for field in (*answers, kinds))
    certificates = np.zeros_like(kinds)
    certificates[0] = certificate(size, pair, kinds[0])
    answers = [answers[0] * unit, *answers[1:3], answers[3] * unit]
    shape = CLASSES, *p.shape[:-1]
    fields = (one.reshape(shape) for one in (*answers, kinds, certificates))
    return Geodesic(torus, *(np.broadcast_to(end, (*shape, 2)) for end in (p, q)), *fields)


# ---- ends, and ways that need no search --------------------------------------


class EndPair(NamedTuple):
    """Ends in normal form: from phi = a >= 0 to phi = b, |b| <= a, turning by an angle >= 0.

    What made them so: `mirror` is -1 where phi was mirrored, `side` -1 where theta was, `swap`
    tells where the ends were exchanged. `on_sheet` tells where both are on the working sheet,
    `halves` are the `half_angles` of both.
    """

    a: np.ndarray
    b: np.ndarray
    angle: np.ndarray
    mirror: np.ndarray
    side: np.ndarray
    swap: np.ndarray
    on_sheet: np.ndarray
    halves: tuple


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
    if not none_outside(found, -math.pi, math.pi):
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
    halves = half_angles(torus, a, b)
    # At a node itself there is no tangent plane: it isn't on the sheet.
    rho_a, _ = halves[4:]
    on_sheet = rho_a > 0
    return EndPair(a, b, angle, mirror, where(turn < 0, -1.0, 1.0), swap, on_sheet, halves)


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
        rho_a, _ = pair.halves[4:]
        across = where(near, rho_a * (LARGE * angle), 1.0)
        down = where(near, torus.R * (LARGE * (a - b)), 0.0)
        most = larger(across, down)  # over it, squares are neither too small nor too large
        part, rest = ratio(across, most), ratio(down, most)
        size = most * square_root(part * part + rest * rest)
        kind = where(near, OUTER, kind)
        length = where(near, size / LARGE, length)
        c = where(near, rho_a * ratio(across, size), c)
        cosine = where(near, -ratio(down, size), cosine)
    return Way(kind, length, c, cosine, 1.0 * cosine)  # arrays of their own


def through(torus, pair):
    """Return the way along two meridians, over phi = pi, the node of a horn."""
    # Twice pi less a and -b, to the last digit.
    span = ((math.pi - pair.a) + (math.pi + pair.b)) + 2 * PI_REST
    return Way(INNER, torus.R * span, 0.0, 1.0, 1.0)


def conjugate_turn(torus):
    """Return the turn to the first conjugate point on the outer equator, the least half swing."""
    return math.pi * math.sqrt(torus.R / (torus.r + torus.R))


def azimuths(pair, way):
    """Return the azimuths at the ends as they were given, and c."""
    # Where the ends were exchanged the way is gone backwards: that changes the sign of the cosine,
    # and of the sine twice, since the turn is reckoned from the other end, too.
    back = pair.mirror * where(pair.swap, -1.0, 1.0)
    c = pair.side * way.c
    rho_a, rho_b = pair.halves[4:]
    first = arctangent(ratio(c, rho_a), back * way.cos_a)
    last = arctangent(ratio(c, rho_b), back * way.cos_b)
    undirected = way.kind <= POINT
    first = where(undirected, math.nan, first)
    last = where(undirected, math.nan, last)
    return where(pair.swap, last, first), where(pair.swap, first, last), c


def certificate(torus, pair, kind):
    """Return the code of why a way of some kind is the shortest."""
    # Within half of the shortest swing there is no second arrival.
    only = (pair.angle <= conjugate_turn(torus)) & (pair.angle < math.pi)
    found = where((kind == MERIDIAN) | (kind == POINT), 1, where(only, 2, 3))
    return where(kind == NONE, 0, found)


# ---- the shortest way ---------------------------------------------------------


@cache
def padded(count):
    """Return shares and weights of a `rule`, some of no weight, eight at a time."""
    shares, weights = rule(count)
    rest = -len(shares) % 8
    return np.stack([np.pad(shares, (0, rest), mode="edge"), np.pad(weights, (0, rest))])


@cache
def listed(count):
    """Return shares and weights of a `rule` as lists, for plain Python."""
    return [row.tolist() for row in rule(count)]


@loop(inlined=("growth", "two_to_bits", "add_nodes"))
def find(torus, ends, few, many, rows, answers):
    """Write down the `answer` to each of some pairs of ends.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : (n, 3) float
        The turn between the ends and phi of both, in rad, from -pi to pi.
    few, many : tuple
        Quadratures, `padded` or `listed`, and how many of their nodes count: for the working sheet
        and elsewhere.
    rows : (3, m) float
        Room for what nodes add, m at least as many as there are.
    answers : (6, n) float
        Filled with what `answer` returns.
    """
    for i in range(len(ends)):
        found = answer(torus, ends[i][0], ends[i][1], ends[i][2], few, many, rows)
        for k in range(6):
            answers[k][i] = found[k]


def answer(torus, turn, phi1, phi2, few, many, rows):
    """Return the shortest way between two ends as numbers.

    Parameters
    ----------
    torus : Radii
        The surface.
    turn, phi1, phi2 : float
        The turn between the ends and phi of both, in rad, from -pi to pi.
    few, many, rows
        As of `find`.

    Returns
    -------
    length, azimuth1, azimuth2, clairaut : float
        In m and rad.
    kind, certificate : float
        Their codes; the kind is `OPEN` where arrays have to answer.
    """
    pair = normal_form(torus, turn, phi1, phi2)
    way = _shortest(torus, pair, few, many, rows)
    first, last, c = azimuths(pair, way)
    kind = way.kind + 0.0
    return way.length, first, last, c, kind, certificate(torus, pair, way.kind) + 0.0


def _shortest(torus, pair, few, many, rows):
    """Return the shortest `Way`; its kind is `OPEN` where that takes more than this."""
    a, b, angle = pair.a, pair.b, pair.angle
    way = level(torus, pair)
    if not pair.on_sheet:
        return way
    # Arrays look at the other way along a meridian, and at the inner equator.
    if torus.r >= torus.R and (angle == 0 or (a == math.pi and abs(b) == math.pi)):
        return Way(OPEN, *way[1:])
    if way.kind != NONE:
        return way
    ends = ends_at(torus, a, b, pair.halves)
    sheet = on_working_sheet(torus, a, angle)
    nodes = few if sheet else many
    begin = start(torus, ends, a, b, angle)
    hard = not sheet and peaked(torus, ends, b, angle)
    found = find_root(torus, ends, angle, begin, True, hard, nodes, rows)
    way = Way(OUTER if found[0] else OPEN, *found[1:])
    # Over the inner equator only between opposite halves: else the outside is shorter.
    if b < 0 and way.kind != OPEN:
        if torus.r > torus.R:
            found = find_root(torus, ends, angle, (0.5, 0.0, 0.0), False, False, nodes, rows)
            if not found[0] or found[1] < way.length:
                return Way(INNER if found[0] else OPEN, *found[1:])
        elif torus.r == torus.R:
            other = through(torus, pair)
            if other.length < way.length:
                return other
    return way


def _answers(size, ends):
    """Return what `answer` does, (6, n), of `turn_and_ends` (n, 3)."""
    ready = compiled.ready("geodesics")
    if not ready and len(ends) > FEW:
        return _answers_by_arrays(size, ends)
    many = NODES_OF_RING if size.r > size.R else NODES
    form = padded if ready else listed
    few, many = ((form(count), count // 2) for count in (NODES_OF_WORKING_SHEET, many))
    answers = np.empty((6, len(ends)))
    if ready:
        rows = np.empty((3, many[0].shape[1]))
        compiled.call(find, size, ends, few, many, rows, answers, **{**NUMBERS, "ratio": divided})
    else:
        rows = [[0.0] * many[1] for _ in range(3)]
        try:
            compiled.call_plain(find, size, ends, few, many, rows, answers, **PLAIN)
        except (ZeroDivisionError, ValueError):
            # A product of numbers below 1e-150, which arrays divide by, or a root of what rounding
            # left below zero, which is NaN there.
            return _answers_by_arrays(size, ends)
    open_ = [i for i, kind in enumerate(answers[4].tolist()) if kind == OPEN]
    if open_:
        answers[:, open_] = _answers_by_arrays(size, ends[open_])
    return answers


def _answers_by_arrays(size, ends):
    """Return what `_answers` does, all pairs at once."""
    pair = normal_form(size, *ends.T)
    outside = _near_side(size, pair)
    # Over the inner equator only between opposite halves: else the outside is shorter.
    inside = _inside(size, pair, pair.b < 0)
    nearer = inside.length < np.where(outside.kind == NONE, np.inf, outside.length)
    way = Way(*(np.where(nearer, *both) for both in zip(inside, outside, strict=True)))
    first, last, c = azimuths(pair, way)
    return way.length, first, last, c, way.kind, certificate(size, pair, way.kind)


def _settle(ways, where, kind, *values):
    """Write down geodesics of a kind where a mask says, each value a number or an array."""
    ways.kind[where] = kind
    for array, value in zip(ways[1:], values, strict=True):
        array[where] = value[where] if np.ndim(value) else value


def _nothing(pair):
    return Way(np.full(pair.a.size, NONE), *np.full((4, pair.a.size), np.nan))


def _near_side(torus, pair):
    """Return the ways over the side of the farther end, or down the outside of a meridian."""
    ways = level(torus, pair)
    # Half a swing is more than half a turn, but for rounding on what is nearly a sphere.
    turns = pair.angle <= max(half_swing_by_the_node(torus), np.pi)
    there = pair.on_sheet & (ways.kind == NONE) & turns
    _search(torus, outer, pair, there, ways)
    return ways


def _second_arrivals(torus, pair, least):
    """Return the ways that turn on the other side: before the least turned angle, and past it."""
    before, past = _nothing(pair), _nothing(pair)
    angle = pair.angle
    unknown, turned = least
    possible = pair.on_sheet & (angle > turned)
    for ways, sense, swings in ((before, -1, 1), (past, 1, 2)):
        there = possible & (angle < swings * half_swing_by_the_node(torus))
        _search(torus, partial(second, sense=sense), pair, there, ways, sense * unknown)
    return before, past


def _least_second(torus, pair):
    """Return the unknown of `second` with which the turned angle is least, and that angle."""
    index = np.flatnonzero(pair.on_sheet)
    a = pair.a[index]
    ends = ends_at(torus, a, pair.b[index], [value[index] for value in pair.halves])
    unit = np.cos(a / 2) if torus.r >= torus.R else np.sqrt((torus.r / torus.R + np.cos(a)) / 2)
    # Towards either end of the class the turned angle grows: its rate changes its sign once.
    low, high = -FARTHEST * unit, -NEAREST * unit
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        _, rate, _ = integrate(torus, second(torus, ends, middle), NODES)
        low = np.where(rate < 0, middle, low)
        high = np.where(rate < 0, high, middle)
    least = np.full((2, pair.a.size), np.nan)
    least[:, index] = high, integrate(torus, second(torus, ends, high), NODES)[0]
    return least


def _inside(torus, pair, allowed=True):
    """Return the ways over a ring's inner equator, or along either equator."""
    ways = _nothing(pair)
    a, b, angle = pair[:3]
    span = torus.r + torus.R
    narrow = torus.r - torus.R
    # Past its conjugate point the outer equator is a geodesic still, though no shortest one.
    past = (a == 0) & (angle > conjugate_turn(torus))
    _settle(ways, past, OUTER, span * angle, span, 0.0, 0.0)
    if narrow < 0:  # the working sheet of a spindle ends at its nodes
        return ways
    # Round the tube the other way, if there are two ends.
    meridian = pair.on_sheet & (angle == 0) & ((b < 0) | (a > b)) & allowed
    _settle(ways, meridian, MERIDIAN, through(torus, pair).length, 0.0, 1.0, 1.0)
    if narrow == 0:
        # Both nodes of a horn are one point: any way through it enters above and leaves below.
        node = pair.on_sheet & (angle > 0) & (angle <= np.pi) & ((b < 0) | (a > b)) & allowed
        _settle(ways, node, *through(torus, pair))
        return ways
    # Along the inner equator c = r - R, the class's other end.
    both = (a == np.pi) & (np.abs(b) == np.pi)
    _settle(ways, both, INNER, narrow * angle, narrow, 0.0, 0.0)
    _settle(ways, both & (angle == 0), POINT, 0.0, 0.0, np.nan, np.nan)
    _search(torus, inner, pair, (angle > 0) & (a > 0) & allowed & (ways.kind == NONE), ways)
    return ways


def _search(torus, family, pair, possible, ways, low=None):
    """Write down the ways of a class that reach their turned angle."""
    index = np.flatnonzero(possible)
    a, b, angle = (array[index] for array in pair[:3])
    ends = ends_at(torus, a, b, [value[index] for value in pair.halves])
    found = solve(family, torus, ends, a, b, angle, None if low is None else low[index])
    reached = np.abs(found[0] - angle) <= AGREES
    index = index[reached]
    ways.kind[index] = INNER if family is inner else OUTER
    for array, value in zip(ways[1:], found[1:], strict=True):
        array[index] = value[reached]
    if torus.r > torus.R and family in (outer, inner):
        index = np.flatnonzero(possible)[~reached]
        a, b, angle = (array[index] for array in pair[:3])
        far = WOUND * (np.cos(a / 2) if family is outer else np.ones_like(a))
        ends = ends_at(torus, a, b, half_angles(torus, a, b))
        wound = integrate(torus, family(torus, ends, far), NODES)[0] < angle
        _wind(torus, pair, family, index[wound], ways)


def _wind(torus, pair, family, index, ways):
    """Write down the ways of a ring that follow its inner equator to the last digit of c.

    In a given class length = c angle + int R sqrt(1 - c^2 / rho^2) dphi is stationary in c; so
    c = r - R will do.
    """
    c = torus.r - torus.R
    shares, weights = (np.append(half, half) for half in rule(NODES))
    shares[NODES // 2 :] = 1 - shares[NODES // 2 :]
    length = c * pair.angle[index]
    cosines = []
    for end in (pair.a[index], np.abs(pair.b[index]) if family is inner else pair.b[index]):
        # From the inner equator, z = 0, to the end: the nodes, and last the end itself.
        z = np.append((np.pi - end[:, None]) * shares, np.pi - end[:, None], axis=1)
        # rho^2 - c^2 = (rho - c)(rho + c), of which the first factor is 2 R sin^2(z/2).
        sine = np.sin(z / 2)
        rho = c + 2 * torus.R * sine**2
        cosine = sine * np.sqrt(2 * torus.R * (rho + c)) / rho
        length += torus.R * (np.pi - end) * (cosine[:, :-1] @ weights)
        cosines.append(cosine[:, -1])  # of the azimuth at the end
    ways.kind[index] = INNER if family is inner else OUTER
    ways.length[index] = length
    ways.c[index] = c
    ways.cos_a[index] = cosines[0]
    ways.cos_b[index] = cosines[1] if family is inner else -cosines[1]
