"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics, which
`geodesic_root` solves. The ends are brought to a normal form, an `EndPair`; each class answers with
a `Way`; the shortest of these is the answer. The direct problem, which follows a geodesic from its
start, checks it.

The functions below `Geodesic` take plain numbers, one pair of ends at a time. They run as they
stand or compiled, with the same bits. Kinds and certificates are codes, the places of words in
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
    FIFTHS,
    INSIDE,
    MOST_PAIRS,
    OUTSIDE,
    PAST,
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

LEVEL = 1e-30  # of the arc between them: ends nearer to the outer equator count as on it
NEAR = 1e-45  # of R: a shorter way counts as straight, lest products of four lengths vanish
LARGE = 2.0**500  # a factor that brings lengths below NEAR to where they have all digits
PI_REST = 1.2246467991473532e-16  # pi less math.pi
WOUND = 17  # in units of its class: for such an unknown c is r - R to fourteen digits
CLASSES = 8  # of `competing_geodesics`
FARTHEST = 10  # the unknown of `second`, in units of its class, where c is least to 1e-8
NEAREST = 1e-9  # the same next to zero, where the outer equator would leave no quadrature
HALVINGS = 30  # of the bracket between both, which is then 1e-8 wide: the turn is least to rounding
BLOCK = 8192  # pairs at a time, compiled: any number of pairs needs the same room
# Pairs at a time in plain Python. Where a number over- or underflows, all of them are asked again
# with numpy's numbers, which divide by zero but are ten times as slow.
PLAIN_BLOCK = 16
SECONDS = 1e-4, 4e-4  # that a pair takes in plain Python, on the working sheet and on a ring
SECONDS_OF_RIVALS = 8e-3


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
        """Return the kinds of the geodesics, as (...) str.

        They are "meridian", "outer", "inner" (over the inner equator of a ring, or through the node
        of a horn), "point" (the ends coincide), or "none" where there is no answer.
        """
        return KINDS[self.kind_code]

    @property
    def certificate(self):
        """Return why each geodesic is the shortest, as (...) str: see `geodesic_inverse`.

        The reasons are "meridian", "only" or "first"; rivals have none, nor do ends without an
        answer.
        """
        return CERTIFICATES[self.certificate_code]

    @property
    def converged(self):
        """Return where there is an answer, as (...) bool; its turned angle is met to 1e-9 rad."""
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
            # A way through the node of a horn goes on along the meridian of the other end.
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
        NaN; all other ends have an answer, but for a few on rings wider than r / R = 1e11.

    Notes
    -----
    The report's section on geodesics proves for all ends that nothing on the sheet is shorter.
    Let the end with the greater |phi| come first. Of the geodesics that come to the other
    end's parallel for the first time, and not round a ring's tube, exactly one turns by a given
    angle up to pi: their turned angle grows strictly from the descending meridian to beyond pi,
    because the turned angle of half a swing between the turning points,

        T(c) = 2R / (R + r) int_0^(pi/2) sqrt(1 + 2r / (rho + R - r)) dx,
        1 / rho^2 = cos^2(x) / c^2 + sin^2(x) / (R + r)^2,

    falls as c grows. Every later arrival at the same end is longer, and so is a way that leaves a
    node on the side where it entered, or one that turns by more than pi. Of the geodesics round a
    ring's tube exactly one turns by that angle, and it is the shortest of them; it can win only
    where the ends lie in opposite halves. On a horn, r = R, both nodes are one point, and two arcs
    of meridians through it take that geodesic's place, with kind "inner" and a length of
    R (2 pi - |phi1| - |phi2|). So there is one root to find, or two, and the shorter way is
    returned. As r falls to R, the lengths tend to the horn's. As r grows to R they don't, for on
    the outer sheet of a spindle the nodes remain apart.

    The certificate says why the answer is the shortest. It is "meridian" for the arc between ends
    with the same theta; "only" for turns up to pi / sqrt(1 + r / R), and below pi, where no later
    arrival exists, since T(c) is greater; "first" beyond. No greater limit than that would do, for
    it is the outer equator's conjugate point. Ends half a turn apart have a mirror image of the
    answer that is as short, and so have ends at phi and -phi past their conjugate point.

    On a spindle's whole surface, its inner sheet included, the answer is the shortest where it is
    no longer than R (2 pi - |phi2 - phi1|), for no way through both nodes is shorter than that.

    Lengths are right to rounding. With an end within 0.1 rad of a node they are right to 3e-14 of
    themselves, or to 2e-15 R if they are shorter than 0.01 R; and to 2e-13 R where a way all but
    touches a node or the axis, on what is nearly a sphere or a horn. `tests/references` has a table
    of hard ones. Far angles are reduced as exactly as by `Torus.point`. Ends nearer to each other
    than 1e-45 R are joined in the tangent plane; only ends that are the same have no direction.

    Examples
    --------
    >>> geodesic = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 0.4))
    >>> round(float(geodesic.length), 12), str(geodesic.kind)
    (0.63, 'meridian')
    >>> off = geodesic_inverse(Torus(0.1, 0.9), (0, -0.3), (0, 2))  # on the inner sheet
    >>> float(off.length), str(off.kind)
    (nan, 'none')
    """
    p, q = (p, q) if p.shape == q.shape else np.broadcast_arrays(p, q)
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
        Its arrays have one more axis in front, of length 8, with the shortest first and the kind
        "none" where there are fewer. Only the first has a certificate.

    Notes
    -----
    There are four classes, each for the short and for the long way round the axis, which together
    make one turn. Let the end with the greater |phi| come first, and look at the geodesics that
    come to the other's parallel

    - for the first time: there is one, or none where it would have to pass a node;
    - for the second time, after a turning point on the other side: below a least turn there is
      none, and beyond it there are two, which make two classes; either is missing where it would
      have to pass a node;
    - over the inner equator of a ring, on the side of the farther end: there is one; on a horn its
      place is taken by one way through the node, along two meridians, whichever way round. Between
      two places on the outer equator, past its first conjugate point, it gives way to the equator.

    That the second arrivals' turn has one least value was seen on all tori that were tried; the
    rest is proved. Later arrivals are left out, each of which swings across the outer equator once
    more, and so are ways that wind about the tube or the axis farther. No later arrivals exist
    where both ways round turn by less than two half swings, 2 pi / sqrt(1 + r / R): on the
    reference machine's torus that is between ends more than 17 degrees of theta apart.
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

    `mirror` is -1 if phi was mirrored for that, `side` is -1 if theta was, and `swap` tells whether
    the ends were exchanged. `on_sheet` tells whether both are on the working sheet.
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
        The code of its kind.
    length, c : float
        Its length and Clairaut's constant, in m.
    cos_a, cos_b : float
        The cosines of its azimuths at a and b.
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
        # Rounding the difference of far angles may lose more than pi: both parts are reduced.
        turn, rest = two_sum(q[:, 0], -p[:, 0])
        found[:, 0] = reduced(turn) + reduced(rest)
        found = reduced(found)
    return found


def normal_form(torus, turn, phi1, phi2):
    """Return the `EndPair` of ends on a torus at phi1 and phi2, a `turn` apart, in rad.

    All three are from -pi to pi.
    """
    angle = abs(turn)
    # The end farther from the outer equator comes first, mirrored to phi >= 0.
    swap = abs(phi2) > abs(phi1)
    a, b = (phi2, phi1) if swap else (phi1, phi2)
    mirror = -1.0 if a < 0 else 1.0
    a, b = a * mirror, b * mirror
    # The way between ends so near to the outer equator, for their turn, is the equator to the last
    # digit of its length and azimuths, while products of the ends' sines would vanish.
    if torus.R * a < LEVEL * ((torus.r + torus.R) * angle):
        a = b = 0.0
    ends = ends_at(torus, a, b)
    # At a node itself there is no tangent plane: it isn't on the sheet.
    return EndPair(a, b, angle, mirror, -1.0 if turn < 0 else 1.0, swap, ends.rho_a > 0, ends)


def nothing():
    """Return the `Way` of a class that has none."""
    return Way(NONE, math.nan, math.nan, math.nan, math.nan)


def level(torus, pair):
    """Return the `Way` of ends that need no search, or `nothing` for all others.

    Such are ends on one meridian, on the outer equator as far as its first conjugate point, or
    less than `NEAR` R apart.
    """
    a, b, angle = pair.a, pair.b, pair.angle
    span = torus.r + torus.R
    # The outer equator is shortest up to its conjugate point. It is u = 0 of `outer`, where k = 0:
    # sin(phi/2) = k cos(t) is zero all along, whatever t is, so that t has no limits.
    if angle > 0 and a == 0 and angle <= conjugate_turn(torus):
        return Way(OUTER, span * angle, span, 0.0, 0.0)
    if not pair.on_sheet:
        return nothing()
    # On one meridian c = 0, the end of a class, to which a search would only come near.
    if angle == 0:
        return Way(POINT if a == b else MERIDIAN, torus.R * (a - b), 0.0, -1.0, -1.0)
    if span * angle < NEAR * torus.R and a - b < NEAR:
        # Between ends so near to each other the surface is its tangent plane. LARGE keeps digits of
        # lengths that are next to the smallest floats.
        rho_a = pair.ends.rho_a
        across = rho_a * (LARGE * angle)
        down = torus.R * (LARGE * (a - b))
        most = larger(across, down)  # divided by it, numbers have squares within range
        part, rest = across / most, down / most
        size = most * square_root(part * part + rest * rest)
        return Way(OUTER, size / LARGE, rho_a * (across / size), -(down / size), -(down / size))
    return nothing()


def through(torus, pair):
    """Return the way along two meridians that meet at phi = pi, the node of a horn."""
    # 2 pi - a + b: near pi each difference is exact, and what pi lacks is added.
    span = ((math.pi - pair.a) + (math.pi + pair.b)) + 2 * PI_REST
    return Way(INNER, torus.R * span, 0.0, 1.0, 1.0)


def conjugate_turn(torus):
    """Return the turn from a place on the outer equator to its first conjugate point.

    It is also the least turned angle of half a swing.
    """
    return math.pi * math.sqrt(torus.R / (torus.r + torus.R))


def azimuths(pair, way):
    """Return the azimuths at the ends, in the order given, and c with its sign."""
    # If the ends were exchanged the way is followed backwards. That changes the sign of the cosine,
    # and of the sine twice, for the turn counts from the other end, too.
    back = -pair.mirror if pair.swap else pair.mirror
    c = pair.side * way.c
    if way.kind <= POINT:  # which has no direction
        return math.nan, math.nan, c
    first = arctangent(ratio(c, pair.ends.rho_a), back * way.cos_a)
    last = arctangent(ratio(c, pair.ends.rho_b), back * way.cos_b)
    return (last, first, c) if pair.swap else (first, last, c)


def certificate(torus, pair, kind):
    """Return the code of the reason why a way of some kind is the shortest."""
    if kind == NONE:
        return 0
    if kind == MERIDIAN or kind == POINT:
        return 1
    # Within half of the shortest swing there is no second arrival.
    return 2 if pair.angle <= conjugate_turn(torus) and pair.angle < math.pi else 3


# ---- ways that are searched ----------------------------------------------------


def near_side(torus, pair, rules, rows):
    """Return the way of `outer`, or the one that needs no search.

    Parameters
    ----------
    torus : Radii
        The surface.
    pair : EndPair
        The ends.
    rules : tuple
        The `quadratures`.
    rows : (3, m) float
        Room for what nodes add, m at least as many as there are.
    """
    way = level(torus, pair)
    # A way turns by less than half a swing by the node. On what is nearly a sphere rounding may
    # make this less than the half turn that it is on a sphere.
    most = larger(half_swing_by_the_node(torus), math.pi)
    if not pair.on_sheet or way.kind != NONE or pair.angle > most:
        return way
    begin = start(torus, pair.ends, pair.a, pair.b, pair.angle)
    return family_root(torus, pair, OUTSIDE, begin, rules, rows)


def far_side(torus, pair, rules, rows):
    """Return the way of `inner` on a ring, through the node of a horn, or along an equator.

    The way leaves a with growing phi and comes to b + 2 pi; there may be `nothing`. The arguments
    torus, pair, rules and rows are those of `near_side`.
    """
    a, b, angle = pair.a, pair.b, pair.angle
    span = torus.r + torus.R
    narrow = torus.r - torus.R
    if a == 0 and angle > conjugate_turn(torus):
        # Past its conjugate point the outer equator is still a geodesic, but not the shortest.
        # It takes the place of the way over the inner equator.
        return Way(OUTER, span * angle, span, 0.0, 0.0)
    if narrow < 0 or not pair.on_sheet:  # the working sheet of a spindle ends at its nodes
        return nothing()
    if a == math.pi and abs(b) == math.pi:
        # The inner equator, c = r - R, is the other end of the class.
        if angle == 0:
            return Way(POINT, 0.0, 0.0, 0.0, math.nan)
        return Way(INNER, narrow * angle, narrow, 0.0, 0.0)
    if angle == 0:
        # Round the tube the other way, unless both ends are one point.
        round_ = through(torus, pair)
        return Way(MERIDIAN, round_.length, 0.0, 1.0, 1.0) if a > b else nothing()
    if narrow == 0:
        # Both nodes of a horn are one point. A way through it comes from above and leaves below. It
        # fits any angle, 2 pi - angle too, with which `find_rivals` asks again: it is counted once.
        return through(torus, pair) if angle <= math.pi else nothing()
    begin = 0.5, 0.0, 0.0
    return family_root(torus, pair, INSIDE, begin, rules, rows)


def shortest(torus, pair, rules, rows):
    """Return the shortest `Way` between ends.

    The arguments torus, pair, rules and rows are those of `near_side`.
    """
    outside = near_side(torus, pair, rules, rows)
    # The way over the inner equator can be shorter only between opposite halves.
    on_inner = pair.a == math.pi and abs(pair.b) == math.pi
    if torus.r < torus.R or not (pair.b < 0 or on_inner):
        return outside
    inside = far_side(torus, pair, rules, rows)
    if inside.kind != NONE and (outside.kind == NONE or inside.length < outside.length):
        return inside
    return outside


def family_root(torus, pair, family, begin, rules, rows):
    """Return the way of a class that reaches the turned angle, or none.

    The class is `family`, and `begin` tells `find_root` where to begin; the other arguments, torus,
    pair, rules and rows, are those of `near_side`.
    """
    ends, angle = pair.ends, pair.angle
    found = find_root(torus, ends, pair.b, angle, begin, family, rules, rows)
    if found[0] or torus.r <= torus.R or family > INSIDE:
        kind = INNER if family == INSIDE else OUTER
        return Way(kind, *found[1:]) if found[0] else nothing()
    # A ring's way may follow the inner equator for so long that c = r - R to its last digit.
    far = WOUND * (ends.cosine_a if family == OUTSIDE else 1.0)
    far_way = way_of(family, torus, ends, far)
    turned, _, _ = integrate_way(torus, far_way, family, False, rules, rows)
    return _wound(torus, pair, family, rules) if turned < angle else nothing()


def _wound(torus, pair, family, rules):
    """Return the way of a class, `family`, for which c = r - R to its last digit.

    For ends a given angle apart length = c angle + int R sqrt(1 - c^2 / rho^2) dphi is stationary
    in c: so this c is near enough. It follows the inner equator of a ring for a while.
    """
    c = torus.r - torus.R
    first, cos_a = _from_inner_equator(torus, math.pi - pair.a, rules)
    end = abs(pair.b) if family == INSIDE else pair.b
    last, cos_b = _from_inner_equator(torus, math.pi - end, rules)
    length = c * pair.angle + torus.R * (first + last)
    # Over the inner equator phi goes on growing at b; round the outside it falls there.
    kind, sign = (INNER, 1.0) if family == INSIDE else (OUTER, -1.0)
    return Way(kind, length, c, cos_a, sign * cos_b)


def _from_inner_equator(torus, z, rules):
    """Return int sqrt(1 - c^2 / rho^2) dz from 0 to z, c = r - R, and the integrand at z.

    z counts from the inner equator of a ring, in rad.
    """
    shares, weights = rules[0][FIFTHS]
    total = 0.0
    for k in range(MOST_PAIRS):
        one, other = z * shares[k], z * (1 - shares[k])
        total += weights[k] * (_cosine_at(torus, one) + _cosine_at(torus, other))
    return z * total, _cosine_at(torus, z)


def _cosine_at(torus, z):
    """Return the cosine of the azimuth, sqrt(1 - c^2 / rho^2), at z from the inner equator."""
    # rho^2 - c^2 = (rho - c)(rho + c), of which the first factor is 2 R sin^2(z/2).
    c = torus.r - torus.R
    sine, _ = sine_cosine(z / 2)
    rho = c + 2 * torus.R * (sine * sine)
    return sine * square_root(2 * torus.R * (rho + c)) / rho


def second_arrivals(torus, pair, least, rules, rows):
    """Return the two ways of `second`, with unknowns before that of the least turn, and past it.

    `least` is what `least_second` returns; torus, pair, rules and rows are those of `near_side`.
    """
    unknown, turned = least
    before, past = nothing(), nothing()
    if pair.on_sheet and pair.angle > turned:
        swing = half_swing_by_the_node(torus)
        # To either side of its least value the turned angle grows. `find_root` wants one that grows
        # with the unknown: so before the least one it gets -u.
        if pair.angle < swing:
            begin = 0.25 - unknown, ROUNDING, -unknown
            before = family_root(torus, pair, BEFORE, begin, rules, rows)
        if pair.angle < 2 * swing:
            begin = 0.25 + unknown, ROUNDING, unknown
            past = family_root(torus, pair, PAST, begin, rules, rows)
    return before, past


def least_second(torus, pair, rules, rows):
    """Return the unknown of `second` with which the turned angle is least, and that angle.

    The arguments are a torus, a pair of ends, and rules and rows as of `integrate`.
    """
    if not pair.on_sheet:
        return math.nan, math.nan
    ends = pair.ends
    # Towards either end of the class the turned angle grows: so its rate changes its sign once,
    # where it is least.
    low, high = -FARTHEST * ends.room, -NEAREST * ends.room
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        way = way_of(PAST, torus, ends, middle)
        _, rate, _ = integrate_way(torus, way, PAST, False, rules, rows)
        if rate < 0:
            low = middle
        else:
            high = middle
    way = way_of(PAST, torus, ends, high)
    return high, integrate_way(torus, way, PAST, False, rules, rows)[0]


# ---- loops over pairs ----------------------------------------------------------

INLINED = "growth", "two_to_bits", "add_nodes"  # so that compiled code takes several nodes at once


@loop(inlined=INLINED)
def find(torus, ends, rules, rows, answers):
    """Fill in the shortest way between the ends of each pair.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : (n, 3) float
        The turn between the ends and phi of both, in rad, from -pi to pi.
    rules, rows
        As of `near_side`.
    answers : (6, n) float
        Filled with length, both azimuths and Clairaut's constant, in the unit of the torus and in
        rad, and with the codes of kind and certificate. The azimuths are those at the first and at
        the second end as given, not as in normal form.
    """
    for i in range(len(ends)):
        pair = normal_form(torus, ends[i][0], ends[i][1], ends[i][2])
        write(answers, 0, i, torus, pair, shortest(torus, pair, rules, rows))


@loop(inlined=INLINED)
def find_rivals(torus, ends, rules, rows, answers):
    """Fill in one way of each class between the ends of each pair.

    The arguments torus, ends, rules and rows are those of `find`; `answers` (48, n) has six rows
    for each of eight classes.
    """
    for i in range(len(ends)):
        pair = normal_form(torus, ends[i][0], ends[i][1], ends[i][2])
        a, b, angle, mirror, side, swap, on_sheet, there = pair
        least = least_second(torus, pair, rules, rows)
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
    """Fill in a way between a pair of ends of a torus: column i of answers, six rows from `row`."""
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
    # In a unit near R products of sizes stay within the floats; a power of two rounds nothing.
    unit = math.ldexp(1.0, math.frexp(torus.R)[1] - 1)
    size = Radii(float(torus.r / unit), float(torus.R / unit))
    ends = turn_and_ends(p, q)
    compiled.expect(seconds * len(ends), kind)
    ready = compiled.ready(kind)
    rules = quadratures(size.r > size.R, ready)
    answers = np.empty((6 * classes, len(ends)))

    def fill(block):
        given = ends[block]
        if ready:
            room, some = np.empty((3, MOST_PAIRS)), np.empty((6 * classes, len(given)))
            compiled.call(work, size, given, rules, room, some, **NUMBERS | {"ratio": divided})
        else:
            room = [[0.0] * MOST_PAIRS for _ in range(3)]
            some = [[0.0] * len(given) for _ in range(6 * classes)]
            try:
                compiled.call_plain(work, size, given.tolist(), rules, room, some, **PLAIN)
            except (ZeroDivisionError, ValueError):
                # A product of numbers below 1e-150 became zero and is divided by, or rounding left
                # less than zero under a root. Numpy's numbers go on with infinity or NaN.
                careful = Radii(*map(np.float64, size)), list(map(list, given))
                with np.errstate(all="ignore"):
                    compiled.call_plain(work, *careful, rules, room, some, **IEEE)
        answers[:, block] = some

    compiled.each_block(fill, len(ends), BLOCK if ready else PLAIN_BLOCK, kind)
    answers = answers.reshape(classes, 6, -1)
    answers[:, ::3] *= unit  # lengths and Clairaut's constants
    return answers
