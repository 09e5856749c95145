"""The geodesic of a class between two given ends: a quadrature and Newton's method.

What is between the loops is element by element, so that arrays, plain numbers and compiled loops
(`geodesic_pair`) give the same bits.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, smaller, square_root, where
from ..kernels.repeatable import area_sine, sine_cosine
from .geodesic_classes import (
    STEEP,
    Ends,
    add_nodes,
    folded,
    in_legs,
    inner,
    moving,
    outer,
    peaked,
    steepest,
    wide,
)
from .quadrature import gauss_rule

NODES_OF_WORKING_SHEET = 20  # of the quadrature, where no geodesic comes near a node of the torus
NODES = 96
NODES_OF_RING = 64

BLOCK = 2048  # pairs at a time, so that the quadrature's arrays stay in the cache
ROUNDS = 100  # Newton's method takes about four; halving a bracket takes sixty
NEAR = 1e-5  # rad
AGREES = 1e-9  # rad; a turned angle that is off by more is no answer
STEP = 1e-8  # relative; what a last step of this size leaves is of the order of its square
ROUNDING = 1e-7  # a scale: steps of STEP times this, 1e-15, are made of rounding


class Root(NamedTuple):
    """Geodesics of a class, (n,) each.

    `turned` is the turned angle in rad, `length` in m, `c` Clairaut's constant in m; `cos_a` and
    `cos_b` are the cosines of the azimuths at a and b.
    """

    turned: np.ndarray
    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


@cache
def rule(count):
    """Return shares of the way, and weights, of Gauss and Legendre's quadrature (count / 2,).

    The other half has the same shares from the end.
    """
    nodes, weights = gauss_rule(count)
    return (1 + nodes[: count // 2]) / 2, weights[: count // 2] / 2


def on_working_sheet(torus, a, angle):
    """Return where few nodes do, found by doubling them until nothing changed."""
    return (torus.r <= torus.R / 4) & (a <= 1) & (angle <= 2)


def search(torus, ends, angle, begin, outside, hard, nodes, rows):
    """Return the way of `outer`, or else of `inner`, that turns by an angle, of plain numbers.

    Parameters
    ----------
    torus : Radii
        The surface.
    ends : Ends
        The ends.
    angle : float
        The turned angle, in rad.
    begin : (u, scale, low)
        As by `start`.
    outside, hard : bool
        Whether it is of `outer`, and one that takes three legs.
    nodes : (shares and weights, count)
        A quadrature's, of which so many count.
    rows : (3, m) float
        Room for what nodes add.

    Returns
    -------
    settled : bool
        Whether Newton's method came to an end.
    length, c, cos_a, cos_b : float
        Length and Clairaut's constant, in m, and the cosines of both azimuths; else NaN.
    """
    u, scale, low = begin
    high = math.inf
    before = 0.0
    total = math.nan
    done = False
    for _ in range(ROUNDS):
        way = outer(torus, ends, u) if outside else inner(torus, ends, u)
        if done:
            return True, total, way.c, way.cosines[0], way.cosines[1]
        if hard:
            one, two, three = in_legs(way)
            first = _summed(torus, one, nodes, rows)
            second = _summed(torus, two, nodes, rows)
            third = _summed(torus, three, nodes, rows)
            turned = first[0] + second[0] + third[0]
            rate = first[1] + second[1] + third[1]
            length = first[2] + second[2] + third[2]
        else:
            turned, rate, length = _summed(torus, way, nodes, rows)
        miss = angle - turned
        low, high, before, step, u, done = newton(u, miss, rate, scale, low, high, before)
        # For a given angle the length is stationary in c: what u lacked hardly matters.
        total = length + way.c * miss
        reached = turned + where(step == 0, 0.0, rate * step)
        if done and not abs(reached - angle) <= AGREES:
            break
    return False, math.nan, math.nan, math.nan, math.nan


def _summed(torus, way, nodes, rows):
    """Return what `integrate` does, by the nodes of a rule, of which so many count."""
    shares, count = nodes
    add_nodes(torus, way, shares, rows)
    turned, rate, length = folded(rows, count)
    return turned, rate + moving(torus, way), length


@np.errstate(divide="ignore", invalid="ignore")
def solve(family, torus, ends, a, b, angle, low=None):
    """Return the geodesics of a class whose turned angle is the given one.

    Parameters
    ----------
    family : callable
        `outer`, `inner` or `second`: a function of torus, ends and the unknown.
    torus : Torus
        The surface.
    ends : Ends
        Of the geodesics.
    a, b : (n,) float
        Angles phi of the ends, in rad, |b| <= a.
    angle : (n,) float
        Turned angles, in rad, above zero.
    low : (n,) float, optional
        Where the unknown starts from if not from the class's least.

    Returns
    -------
    root : Root
        With the turned angle that was reached, to be compared with the given one; NaN where
        Newton's method doesn't settle.
    """
    found = np.full((5, a.size), np.nan)
    if low is not None:
        begin = low + 0.25, np.full_like(low, ROUNDING), low
    elif family is outer:
        begin = start(torus, ends, a, b, angle)
    else:
        begin = np.full_like(a, 0.5), np.zeros_like(a), np.zeros_like(a)
    few = on_working_sheet(torus, a, angle)
    many = NODES_OF_RING if torus.r > torus.R else NODES
    hard = ~few & peaked(torus, ends, b, angle) if family is outer else np.zeros_like(few)
    for count, form, which in (
        (NODES_OF_WORKING_SHEET, family, few),
        (many, family, ~few & ~hard),
        (many, _outer_in_legs, hard),
    ):
        index = np.flatnonzero(which)
        for first in range(0, index.size, BLOCK):
            block = index[first : first + BLOCK]
            some = (Ends(*(value[block] for value in ends)), angle[block])
            found[:, block] = _newton(form, torus, *some, *(v[block] for v in begin), count)
    return Root(*found)


def integrate(torus, way, count):
    """Return the turned angle of geodesics, its rate by the unknown, and the length.

    Parameters
    ----------
    torus : Torus
        The surface.
    way : Integrand or list of Integrand
        Constants and limits of n geodesics, or of the legs of each.
    count : int
        Number of nodes of a Gauss-Legendre quadrature.

    Returns
    -------
    turned, rate, length : (n,) float
        In rad, rad and m.
    """
    if isinstance(way, list):
        turned, rate, length = zip(*(integrate(torus, leg, count) for leg in way), strict=True)
        return sum(turned), sum(rate), sum(length)
    columns = [[row[:, None]] for row in rule(count)]
    rows = [[None], [None], [None]]
    add_nodes(torus, way, columns, rows)
    turned, rate, length = folded([values for (values,) in rows], count // 2)
    return turned, rate + moving(torus, way), length


def _outer_in_legs(torus, ends, u):
    """Return `outer` as a list of legs."""
    return list(in_legs(outer(torus, ends, u)))


def newton(u, miss, rate, scale, low, high, before):
    """Return a new bracket low, high, how far u goes, a step, the next u, and whether it was last.

    `miss` is by how much the angle that is turned with the unknown u is too small, `rate` what it
    gains with u, both in rad; u came `before` far to where it is, and is of some `scale`.
    """
    # The turned angle grows with u: the sign of the miss says on which side the root is.
    low = where(miss > 0, u, low)
    high = where(miss < 0, u, high)
    # Beyond the end of a class nothing changes, and the end may be the answer.
    step = where((miss == 0) | (rate == 0), 0.0, ratio(miss, rate))
    onward = (rate != 0) | (abs(miss) <= AGREES)
    # A step that leaves the bracket, or isn't a number, gives way to halving it, and so does one
    # that goes back nearly as far as u came, lest two swing to and fro for ever; while nothing was
    # too far yet, u doubles at most, for a rate near zero would throw it where none comes back.
    onward &= (before == 0) | ((step > 0) == (before > 0)) | (abs(step) <= 0.9 * abs(before))
    endless = high == np.inf
    most = where(endless, 2 * abs(u) + 0.5, high)
    sound = (low <= u + step) & (u + step <= most) & onward
    halved = where(endless, most, (low + high) / 2)
    # The second condition: where nothing turns so far, u grows until any step is small.
    done = sound & (abs(step) <= STEP * (abs(u) + scale)) & (abs(miss) < NEAR)
    new = where(sound, u + step, halved)
    return low, high, new - u, step, new, done


def _newton(family, torus, ends, angle, u, scale, low, count):
    """Return the rows of a `Root`, each sought from u and within a bracket."""
    high = np.full_like(u, np.inf)
    before = np.zeros_like(u)
    left = np.arange(u.size)
    found = np.full((5, u.size), np.nan)
    for _ in range(2 * ROUNDS):  # the last hundred for unknowns of 1e-30
        way = family(torus, ends, u)
        turned, rate, length = integrate(torus, way, count)
        miss = angle - turned
        low, high, before, step, u, done = newton(u, miss, rate, scale, low, high, before)
        if np.any(done):
            last = _only(ends, done)
            end = family(torus, last, u[done])
            now, end = (one[-1] if isinstance(one, list) else one for one in (way, end))
            # For a given angle the length is stationary in c: what u lacked hardly matters.
            reached = turned + where(step == 0, 0.0, rate * step)  # with a level start no rate
            total = length + now.c * miss
            found[:, left[done]] = reached[done], total[done], end.c, *end.cosines
            if np.all(done):
                return found
        # The others go on without those that are done.
        ends = _only(ends, ~done)
        angle, u, scale, low, high, before, left = (
            array[~done] for array in (angle, u, scale, low, high, before, left)
        )
    # On what is nearly a sphere all ways of a class may turn by the same to the last digit: then
    # any u will do, however far the last step was.
    way = family(torus, ends, u)
    turned, _, length = integrate(torus, way, count)
    end = way[-1] if isinstance(way, list) else way
    near = np.abs(turned - angle) * max(torus.r / torus.R, 1) <= AGREES
    turned = np.where(near, turned, np.nan)
    found[:, left] = turned, length + end.c * (angle - turned), end.c, *end.cosines
    return found


def _only(ends, which):
    return Ends(*(value[which] for value in ends))


def start(torus, ends, a, b, angle):
    """Return a first guess for `outer`, the scale of the unknown near zero, and its least value.

    On a `torus`, between `ends` at phi = a and b, for ways that turn by an `angle`, in rad.
    """
    R = torus.R
    rho_a = ends.rho_a
    half, other = sine_cosine(angle / 2)
    # The chord's elevation in the tangent plane at a, which is the answer on a sphere. Its part
    # towards growing phi is the meridian's, and what the parallel bends inwards meanwhile.
    sine_a = 2 * ends.sine_a * ends.cosine_a
    up = 2 * (ends.rho_b * half * half * sine_a - R * ends.sine * ends.cosine)
    along = 2 * ends.rho_b * abs(half * other)
    size = square_root(up * up + along * along)
    sine = up / size
    # x of that azimuth: rho_a - c = 2R x^2 with c = rho_a cos(tilt), 1 - cos as sin^2 / (1 + cos).
    x = sine * rho_a / square_root(2 * R * rho_a * (1 + along / size))
    X = ends.room
    # From x to u, kept off both ends of the class.
    share = smaller(larger(x / X, 0.0), 0.95)
    risen = X * area_sine(share / square_root((1 - share) * (1 + share)))
    guess = where(x > 0, risen, 0.99 * x)
    # Near the meridian u counts by its logarithm what x lacks of it: c / 2R over their sum.
    if wide(torus):
        L = ends.meridian
        rest = rho_a * (along / size) / (2 * R) / (L * (L - x))
        times = square_root((1 - STEEP) / larger(smaller(rest, 1 - STEEP), 1e-299))
        far = 2 * area_sine((times - 1 / times) / 2)
        guess = where(x < -STEEP * L, -L * (STEEP + (1 - STEEP) * far), guess)
    guess = where(a > 0, guess, X / 2)  # from the outer equator it has to rise somehow
    # Steps are judged against |u| and this scale, lest a root near zero be sought for ever. With
    # b > 0 so large a scale would let them end too early near the inner equator, where roots are
    # small themselves; one that asks for steps of rounding size doesn't.
    # By a node the whole class is no longer than X.
    scale = smaller(where(b <= 0, ends.sine_a, ROUNDING), X)
    return guess, scale, steepest(torus, ends)
