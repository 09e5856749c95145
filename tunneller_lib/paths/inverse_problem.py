"""The inverse problem: the shortest geodesic between two positions on a torus, and its rivals.

Clairaut's first integral turns it into one equation for each class of geodesics; the direct
problem, which integrates the equations themselves, checks it.
"""

from functools import partial

import numpy as np

from ..arguments import Positions, checked
from ..kernels import compiled
from ..kernels.elementwise import NUMBERS, divided
from ..surfaces import Torus
from .bounds import check_ratio
from .geodesic import Geodesic
from .geodesic_classes import Ends, ends_of, half_swing_by_the_node, inner, outer, second
from .geodesic_pair import (
    INNER,
    MERIDIAN,
    NONE,
    OPEN,
    OUTER,
    POINT,
    EndPair,
    Way,
    azimuths,
    certificate,
    conjugate_turn,
    find,
    level,
    normal_form,
    padded,
    radii,
    through,
    turn_and_ends,
)
from .geodesic_root import (
    AGREES,
    NODES,
    NODES_OF_RING,
    NODES_OF_WORKING_SHEET,
    integrate,
    rule,
    solve,
)

WOUND = 17  # of the unknown of a ring's class, in its own unit: there c is r - R to fourteen digits
CLASSES = 8  # of `competing_geodesics`
FARTHEST = 10  # of the unknown of `second`, in its own unit: c is within 1e-8 of its least there
NEAREST = 1e-9  # of the same: at zero the outer equator would leave no quadrature
HALVINGS = 30
AHEAD = 5  # of them, looked at once
BLOCK = 8192  # pairs at a time: they need the same room however many there are
FEW = 12  # pairs, which plain numbers answer sooner than arrays
# s for a pair, on the working sheet and on a ring.
BY_ARRAYS = 8e-6, 35e-6
ONE_BY_ONE = 2e-4, 7e-4


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
    p, q = np.broadcast_arrays(p, q)
    shape = p.shape[:-1]
    ends = turn_and_ends(p, q)
    size, unit = radii(torus)
    answers = np.empty((4, len(ends)))
    codes = np.empty((2, len(ends)), np.uint8)
    each = ONE_BY_ONE if len(ends) <= FEW else BY_ARRAYS
    compiled.expect(each[size.r > size.R] * len(ends), "geodesics")

    def answer(block):
        answers[:, block], codes[:, block] = _shortest(size, ends[block])

    compiled.each_block(answer, len(ends), BLOCK, "geodesics")
    answers[::3] *= unit  # length and Clairaut's constant
    return Geodesic(torus, p, q, *(one.reshape(shape)[()] for one in (*answers, *codes)))


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
    both = EndPair(*map(np.append, pair, long_way))
    later = _second_arrivals(size, both, np.tile(least, 2))
    classes = _near_side(size, both), *later, _inside(size, both)
    found = [(*_finished(size, both, one), one.kind) for one in classes]
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


def _shortest(size, ends):
    """Return length, azimuths and c (4, n), and codes (2, n), of `turn_and_ends` (n, 3)."""
    ready = compiled.ready("geodesics")
    if not ready and len(ends) > FEW:
        return _shortest_by_arrays(size, ends)
    answers = np.empty((4, len(ends)))
    codes = np.empty((2, len(ends)), np.uint8)
    many = NODES_OF_RING if size.r > size.R else NODES
    rules = padded(NODES_OF_WORKING_SHEET), padded(many)
    counts = NODES_OF_WORKING_SHEET // 2, many // 2
    rows = np.empty((3, max(one.shape[1] for one in rules)))
    arguments = size, ends, *rules, counts, rows, answers, codes
    if ready:
        compiled.call(find, *arguments, **{**NUMBERS, "ratio": divided})
    else:
        try:
            compiled.call_plain(find, *arguments)
        except ZeroDivisionError:  # a product of numbers below 1e-150, which arrays divide by
            return _shortest_by_arrays(size, ends)
    open_ = np.flatnonzero(codes[0] == OPEN)
    if open_.size:
        answers[:, open_], codes[:, open_] = _shortest_by_arrays(size, ends[open_])
    return answers, codes


def _shortest_by_arrays(size, ends):
    """Return the same."""
    pair = normal_form(size, *ends.T)
    outside = _near_side(size, pair)
    # Over the inner equator only between opposite halves: else the outside is shorter.
    inside = _inside(size, pair, pair.b < 0)
    nearer = inside.length < np.where(outside.kind == NONE, np.inf, outside.length)
    shortest = Way(*(np.where(nearer, *both) for both in zip(inside, outside, strict=True)))
    codes = shortest.kind, certificate(size, pair, shortest.kind)
    return _finished(size, pair, shortest), codes


def _finished(size, pair, way):
    """Return length, azimuths and c of ways between the ends as they were given."""
    first, last, c = azimuths(size, pair, way)
    return way.length, first, last, c


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
    ends = ends_of(torus, a, pair.b[index])
    unit = np.cos(a / 2) if torus.r >= torus.R else np.sqrt((torus.r / torus.R + np.cos(a)) / 2)
    # Towards either end of the class the turned angle grows: its rate changes its sign once.
    bracket = np.stack([-FARTHEST * unit, -NEAREST * unit])
    # Arrays are slow to begin: of few pairs all outcomes of the next halvings are looked at once.
    ahead = AHEAD if index.size <= FEW else 1
    for _ in range(HALVINGS // ahead):
        bracket = _halved(torus, ends, bracket, ahead)
    high = bracket[1]
    least = np.full((2, pair.a.size), np.nan)
    least[:, index] = high, integrate(torus, second(torus, ends, high), NODES)[0]
    return least


def _halved(torus, ends, bracket, ahead):
    """Return a bracket (2, n) about the least turned angle, so many times halved."""
    edges = bracket
    for _ in range(ahead):
        middles = (edges[:-1] + edges[1:]) / 2
        edges = np.insert(edges, range(1, len(edges)), middles, axis=0)
    tried = edges[1:-1]
    each = Ends(*(np.tile(value, len(tried)) for value in ends))
    rate = integrate(torus, second(torus, each, tried.ravel()), NODES)[1]
    falling = rate.reshape(tried.shape) < 0
    place = np.arange(bracket.shape[1])
    first = np.zeros_like(place)
    for step in 2 ** np.arange(ahead)[::-1]:
        first += step * falling[first + step - 1, place]
    return np.stack([edges[first, place], edges[first + 1, place]])


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
    ends = ends_of(torus, a, b)
    found = solve(family, torus, ends, a, b, angle, None if low is None else low[index])
    reached = np.abs(found.turned - angle) <= AGREES
    index = index[reached]
    ways.kind[index] = INNER if family is inner else OUTER
    for array, value in zip(ways[1:], found[1:], strict=True):
        array[index] = value[reached]
    if torus.r > torus.R and family in (outer, inner):
        index = np.flatnonzero(possible)[~reached]
        a, b, angle = (array[index] for array in pair[:3])
        far = WOUND * (np.cos(a / 2) if family is outer else np.ones_like(a))
        ends = ends_of(torus, a, b)
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
