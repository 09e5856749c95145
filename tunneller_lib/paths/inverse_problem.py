"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics (`geodesic_root`);
the direct problem, which follows a geodesic from its start, checks it. Ends come in a normal form,
and each class answers with a `Way`. The functions take plain numbers, one pair of ends at a time,
and run as they stand or compiled, with the same bits. Kinds and certificates are codes, places in
`KINDS` and `CERTIFICATES`.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Positions, checked, none_outside
from ..kernels import compiled
from ..kernels.compiled import loop
from ..kernels.elementwise import IEEE, NUMBERS, PLAIN, divided, larger, ratio, square_root
from ..kernels.exact import two_sum
from ..kernels.repeatable import arctangent, reduced, sine_cosine
from ..surfaces import Torus
from .bounds import Count, check_ratio
from .direct_problem import followed
from .geodesic_root import (
    BEFORE,
    INSIDE,
    OUTSIDE,
    PAST,
    PI_REST,
    ROUNDING,
    Ends,
    Radii,
    ends_at,
    find_root,
    half_swing_by_the_node,
    integrate_way,
    quadratures,
    start,
    way_of,
)

KINDS = np.array(["none", "point", "meridian", "outer", "inner"])
CERTIFICATES = np.array(["", "meridian", "only", "first"])
NONE, POINT, MERIDIAN, OUTER, INNER = range(len(KINDS))

LEVEL = 1e-30  # of the way along it, ends nearer to the outer equator count as on it
NEAR = 1e-45  # of R, a shorter way is straight; products of four lengths would vanish
LARGE = 2.0**500  # times it, what is below NEAR keeps its digits, however small it is
WOUND = 17  # of the unknown of a ring's class, in its own unit: there c is r - R to fourteen digits
CLASSES = 8  # of `competing_geodesics`
FARTHEST = 10  # of the unknown of `second`, in its own unit: c is within 1e-8 of its least there
NEAREST = 1e-9  # of the same: at zero the outer equator would leave no quadrature
HALVINGS = 30
BLOCK = 8192  # pairs at a time, compiled: they need the same room however many there are
PLAIN_BLOCK = 16  # pairs at a time in plain Python, which are asked again where numbers over- or
# underflow, by numbers that divide by zero and are ten times as slow
SECONDS = 1e-4, 4e-4  # for a pair in plain Python, on the working sheet and on a ring
SECONDS_OF_RIVALS = 3e-2


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
    p, q = np.broadcast_arrays(p, q)
    seconds = SECONDS[torus.r > torus.R]
    (found,) = _answers(find, "geodesics", 1, seconds, torus, p, q)
    return _geodesic(torus, p, q, found)


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
    p, q = np.broadcast_arrays(p, q)
    found = _answers(find_rivals, "rival geodesics", CLASSES, SECONDS_OF_RIVALS, torus, p, q)
    order = np.argsort(found[:, :1], axis=0)  # NaN comes last
    found = np.take_along_axis(found, order, axis=0)
    found[1:, 5] = 0
    p, q = (np.broadcast_to(end, (CLASSES, *end.shape)) for end in (p, q))
    return _geodesic(torus, p, q, np.moveaxis(found, 1, 0))


def _geodesic(torus, p, q, found):
    """Return the `Geodesic` from p to q (..., 2) by what a loop over pairs has found, six rows."""
    *numbers, kind, why = found.reshape(6, *p.shape[:-1])
    return Geodesic(torus, p, q, *numbers, kind.astype(np.uint8), why.astype(np.uint8))


# ---- ends, and ways that need no search --------------------------------------


class EndPair(NamedTuple):
    """Ends in normal form: from phi = a >= 0 to phi = b, |b| <= a, turning by an angle >= 0.

    `mirror` is -1 where phi was mirrored to make them so, `side` is -1 where theta was, and `swap`
    tells whether the ends were exchanged. `on_sheet` tells whether both are on the working sheet.
    """

    a: float
    b: float
    angle: float
    mirror: float
    side: float
    swap: bool
    on_sheet: bool
    ends: Ends


class Way(NamedTuple):
    """A geodesic between ends in normal form.

    Parameters
    ----------
    kind : int
        Its code.
    length, c : float
        Its length and Clairaut's constant, in m.
    cos_a, cos_b : float
        Cosines of its azimuths.
    """

    kind: int
    length: float
    c: float
    cos_a: float
    cos_b: float


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
    a, b = (phi2, phi1) if swap else (phi1, phi2)
    mirror = -1.0 if a < 0 else 1.0
    a = a * mirror
    b = b * mirror
    # So near the outer equator, for their turn, ends are on it to the last digit of the way between
    # them and of its azimuths, and products of their sines would vanish.
    if torus.R * a < LEVEL * ((torus.r + torus.R) * angle):
        a = b = 0.0
    ends = ends_at(torus, a, b)
    # At a node itself there is no tangent plane: it isn't on the sheet.
    on_sheet = ends.rho_a > 0
    return EndPair(a, b, angle, mirror, -1.0 if turn < 0 else 1.0, swap, on_sheet, ends)


def nothing():
    """Return the `Way` that says that there is none."""
    return Way(NONE, math.nan, math.nan, math.nan, math.nan)


def level(torus, pair):
    """Return as a `Way` what needs no search: a meridian, the outer equator, ends all but one."""
    a, b, angle = pair.a, pair.b, pair.angle
    span = torus.r + torus.R
    # The outer equator is shortest up to its conjugate point. In the class it is u = 0, where
    # sin(phi/2) vanishes all along and leaves no quadrature.
    if angle > 0 and a == 0 and angle <= conjugate_turn(torus):
        return Way(OUTER, span * angle, span, 0.0, 0.0)
    if not pair.on_sheet:
        return nothing()
    # On one meridian c = 0, the end of the class, which a search would only near.
    if angle == 0:
        return Way(POINT if a == b else MERIDIAN, torus.R * (a - b), 0.0, -1.0, -1.0)
    if span * angle < NEAR * torus.R and a - b < NEAR:
        # So near to each other that the surface is the tangent plane between them.
        rho_a = pair.ends.rho_a
        across = rho_a * (LARGE * angle)
        down = torus.R * (LARGE * (a - b))
        most = larger(across, down)  # over it, squares are neither too small nor too large
        part, rest = across / most, down / most
        size = most * square_root(part * part + rest * rest)
        return Way(OUTER, size / LARGE, rho_a * (across / size), -(down / size), -(down / size))
    return nothing()


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
    back = -pair.mirror if pair.swap else pair.mirror
    c = pair.side * way.c
    if way.kind <= POINT:  # which has no direction
        return math.nan, math.nan, c
    first = arctangent(ratio(c, pair.ends.rho_a), back * way.cos_a)
    last = arctangent(ratio(c, pair.ends.rho_b), back * way.cos_b)
    return (last, first, c) if pair.swap else (first, last, c)


def certificate(torus, pair, kind):
    """Return the code of why a way of some kind is the shortest."""
    if kind == NONE:
        return 0
    if kind == MERIDIAN or kind == POINT:
        return 1
    # Within half of the shortest swing there is no second arrival.
    return 2 if pair.angle <= conjugate_turn(torus) and pair.angle < math.pi else 3


# ---- ways that are searched ----------------------------------------------------


def near_side(torus, pair, rules, rows):
    """Return the way over the side of the farther end, or down the outside of a meridian.

    Parameters
    ----------
    torus : Radii
        The surface.
    pair : EndPair
        The ends.
    rules : tuple
        Three quadratures: for the working sheet, for what nears a node or the inner equator, and
        the finest; each `padded` or `listed`, and how many of its nodes count.
    rows : (3, m) float
        Room for what nodes add, m at least as many as there are.
    """
    way = level(torus, pair)
    # Half a swing is more than half a turn, but for rounding on what is nearly a sphere.
    most = larger(half_swing_by_the_node(torus), math.pi)
    if not pair.on_sheet or way.kind != NONE or pair.angle > most:
        return way
    begin = start(torus, pair.ends, pair.a, pair.b, pair.angle)
    return family_root(torus, pair, OUTSIDE, begin, rules, rows)


def far_side(torus, pair, rules, rows):
    """Return the way over a ring's inner equator or a horn's node, or along either equator.

    The arguments torus, pair, rules and rows are those of `near_side`.
    """
    a, b, angle = pair.a, pair.b, pair.angle
    span = torus.r + torus.R
    narrow = torus.r - torus.R
    if a == 0 and angle > conjugate_turn(torus):
        # Past its conjugate point the outer equator is a geodesic still, though no shortest one.
        return Way(OUTER, span * angle, span, 0.0, 0.0)
    if narrow < 0 or not pair.on_sheet:  # the working sheet of a spindle ends at its nodes
        return nothing()
    if a == math.pi and abs(b) == math.pi:
        # Along the inner equator c = r - R, the class's other end.
        if angle == 0:
            return Way(POINT, 0.0, 0.0, 0.0, math.nan)
        return Way(INNER, narrow * angle, narrow, 0.0, 0.0)
    two_ends = b < 0 or a > b
    if angle == 0:
        # Round the tube the other way.
        round_ = through(torus, pair)
        return Way(MERIDIAN, round_.length, 0.0, 1.0, 1.0) if two_ends else nothing()
    if narrow == 0:
        # Both nodes of a horn are one point: any way through it enters above and leaves below.
        return through(torus, pair) if two_ends and angle <= math.pi else nothing()
    begin = 0.5, 0.0, 0.0
    return family_root(torus, pair, INSIDE, begin, rules, rows) if a > 0 else nothing()


def shortest(torus, pair, rules, rows):
    """Return the shortest `Way` between ends.

    The arguments torus, pair, rules and rows are those of `near_side`.
    """
    outside = near_side(torus, pair, rules, rows)
    # Over the inner equator only between opposite halves: else the outside is shorter.
    on_inner = pair.a == math.pi and abs(pair.b) == math.pi
    if torus.r < torus.R or not (pair.b < 0 or on_inner):
        return outside
    inside = far_side(torus, pair, rules, rows)
    if inside.kind != NONE and (outside.kind == NONE or inside.length < outside.length):
        return inside
    return outside


def family_root(torus, pair, family, begin, rules, rows):
    """Return the way of a class that reaches the turned angle, or none.

    The class is `family`; `begin` is as of `find_root`, and the others, torus, pair, rules and
    rows, are those of `near_side`.
    """
    a, b, angle = pair.a, pair.b, pair.angle
    ends = pair.ends
    found = find_root(torus, ends, a, b, angle, begin, family, rules, rows)
    if found[0] or torus.r <= torus.R or family > INSIDE:
        kind = INNER if family == INSIDE else OUTER
        return Way(kind, *found[1:]) if found[0] else nothing()
    # A ring's way may turn so often that c can't tell it from the inner equator.
    far = WOUND * (ends.cosine_a if family == OUTSIDE else 1.0)
    far_way = way_of(family, torus, ends, far)
    turned, _, _ = integrate_way(torus, far_way, family, False, rules[2], rows)
    return _wound(torus, pair, family, rules[2]) if turned < angle else nothing()


def _wound(torus, pair, family, nodes):
    """Return the way of a ring that follows its inner equator to the last digit of c.

    In a given class length = c angle + int R sqrt(1 - c^2 / rho^2) dphi is stationary in c; so
    c = r - R will do.
    """
    c = torus.r - torus.R
    first, cos_a = _from_inner_equator(torus, math.pi - pair.a, nodes)
    end = abs(pair.b) if family == INSIDE else pair.b
    last, cos_b = _from_inner_equator(torus, math.pi - end, nodes)
    length = c * pair.angle + torus.R * (first + last)
    if family == INSIDE:
        return Way(INNER, length, c, cos_a, cos_b)
    return Way(OUTER, length, c, cos_a, -cos_b)


def _from_inner_equator(torus, z, nodes):
    """Return int sqrt(1 - c^2 / rho^2) dz from 0 to z, c = r - R, and the integrand at z.

    z, in rad, counts from the inner equator of a ring.
    """
    shares, count = nodes
    total = 0.0
    for k in range(count):
        one, other = z * shares[0][k], z * (1 - shares[0][k])
        total += shares[1][k] * (_cosine_at(torus, one) + _cosine_at(torus, other))
    return z * total, _cosine_at(torus, z)


def _cosine_at(torus, z):
    """Return the cosine of the azimuth, sqrt(1 - c^2 / rho^2), at z from the inner equator."""
    # rho^2 - c^2 = (rho - c)(rho + c), of which the first factor is 2 R sin^2(z/2).
    c = torus.r - torus.R
    sine, _ = sine_cosine(z / 2)
    rho = c + 2 * torus.R * (sine * sine)
    return sine * square_root(2 * torus.R * (rho + c)) / rho


def second_arrivals(torus, pair, least, rules, rows):
    """Return the ways that turn on the other side: before the least turned angle, and past it.

    `least` is what `least_second` returns; torus, pair, rules and rows are those of `near_side`.
    """
    unknown, turned = least
    before, past = nothing(), nothing()
    if pair.on_sheet and pair.angle > turned:
        swing = half_swing_by_the_node(torus)
        # The turned angle grows to either side of its least: below it, -u is the unknown.
        if pair.angle < swing:
            begin = 0.25 - unknown, ROUNDING, -unknown
            before = family_root(torus, pair, BEFORE, begin, rules, rows)
        if pair.angle < 2 * swing:
            begin = 0.25 + unknown, ROUNDING, unknown
            past = family_root(torus, pair, PAST, begin, rules, rows)
    return before, past


def least_second(torus, pair, nodes, rows):
    """Return the unknown of `second` with which the turned angle is least, and that angle.

    The arguments are a torus, a pair of ends, and nodes and rows as of `integrate`.
    """
    if not pair.on_sheet:
        return math.nan, math.nan
    ends = pair.ends
    # Towards either end of the class the turned angle grows: its rate changes its sign once.
    low, high = -FARTHEST * ends.room, -NEAREST * ends.room
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        way = way_of(PAST, torus, ends, middle)
        _, rate, _ = integrate_way(torus, way, PAST, False, nodes, rows)
        if rate < 0:
            low = middle
        else:
            high = middle
    way = way_of(PAST, torus, ends, high)
    return high, integrate_way(torus, way, PAST, False, nodes, rows)[0]


# ---- loops over pairs ----------------------------------------------------------

INLINED = "growth", "two_to_bits", "add_nodes"  # compiled, so that several nodes go at once


@loop(inlined=INLINED)
def find(torus, ends, rules, rows, answers):
    """Write down the shortest way between each of some pairs of ends.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : (n, 3) float
        The turn between the ends and phi of both, in rad, from -pi to pi.
    rules, rows
        As of `near_side`.
    answers : (6, n) float
        Filled with length, both azimuths and Clairaut's constant, in m and rad, and with the codes
        of kind and certificate.
    """
    for i in range(len(ends)):
        pair = normal_form(torus, ends[i][0], ends[i][1], ends[i][2])
        write(answers, 0, i, torus, pair, shortest(torus, pair, rules, rows))


@loop(inlined=INLINED)
def find_rivals(torus, ends, rules, rows, answers):
    """Write down one way of each class between each of some pairs of ends.

    The arguments torus, ends, rules and rows are those of `find`; `answers` (48, n) has six rows
    for each of eight classes.
    """
    for i in range(len(ends)):
        pair = normal_form(torus, ends[i][0], ends[i][1], ends[i][2])
        a, b, angle, mirror, side, swap, on_sheet, there = pair
        least = least_second(torus, pair, rules[2], rows)
        row = 0
        for one in (pair, EndPair(a, b, 2 * math.pi - angle, mirror, -side, swap, on_sheet, there)):
            before, past = second_arrivals(torus, one, least, rules, rows)
            for way in (
                near_side(torus, one, rules, rows),
                before,
                past,
                far_side(torus, one, rules, rows),
            ):
                write(answers, row, i, torus, one, way)
                row += 6


def write(answers, row, i, torus, pair, way):
    """Write down a way between a pair of ends of a torus, in column i of answers from a row on."""
    first, last, c = azimuths(pair, way)
    answers[row][i] = way.length
    answers[row + 1][i] = first
    answers[row + 2][i] = last
    answers[row + 3][i] = c
    answers[row + 4][i] = way.kind
    answers[row + 5][i] = certificate(torus, pair, way.kind)


def _answers(work, kind, classes, seconds, torus, p, q):
    """Return what a loop over pairs answers for ends p and q (..., 2): (classes, 6, n), in m.

    Parameters
    ----------
    work : function
        The loop.
    kind : str
        Of its work, for `compiled`.
    classes : int
        How many ways it finds for a pair.
    seconds : float
        How long it takes for a pair in plain Python.
    torus, p, q
        As of `geodesic_inverse`.
    """
    check_ratio(torus)
    # In a unit near R no product of sizes leaves the floats, and a power of two rounds nothing.
    unit = math.ldexp(1.0, math.frexp(torus.R)[1] - 1)
    size = Radii(float(torus.r / unit), float(torus.R / unit))
    ends = turn_and_ends(p, q)
    compiled.expect(seconds * len(ends), kind)
    ready = compiled.ready(kind)
    rules = quadratures(size.r > size.R, ready)
    answers = np.empty((6 * classes, len(ends)))

    def fill(block):
        some = np.empty((6 * classes, len(ends[block])))
        if ready:
            room = np.empty((3, rules[2][1]))
            parts = {**NUMBERS, "ratio": divided}
            compiled.call(work, size, ends[block], rules, room, some, **parts)
        else:
            room = [[0.0] * (rules[2][1]) for _ in range(3)]
            try:
                compiled.call_plain(work, size, ends[block], rules, room, some, **PLAIN)
            except (ZeroDivisionError, ValueError):
                # A product of numbers below 1e-150 is divided by, or a root is taken of what
                # rounding left below zero. Numpy's numbers go on with infinity or NaN.
                careful = Radii(*map(np.float64, size)), list(map(list, ends[block]))
                with np.errstate(all="ignore"):
                    compiled.call_plain(work, *careful, rules, room, some, **IEEE)
        answers[:, block] = some

    compiled.each_block(fill, len(ends), BLOCK if ready else PLAIN_BLOCK, kind)
    answers = answers.reshape(classes, 6, -1)
    answers[:, 0] *= unit
    answers[:, 3] *= unit
    return answers
