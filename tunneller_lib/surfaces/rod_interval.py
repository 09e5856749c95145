"""A rod as seen along lines of one direction, where it is a rectangle between two ellipses."""

from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import larger, ratio, scaled, smaller, square_root, where, within
from ..kernels.exact import accurate_products, two_product, two_sum
from ..kernels.vectors import (
    differences,
    either,
    lengths,
    near_one,
    scalar_products,
    shares,
    sums,
    vector_products,
)

# A bound of the rounding errors here, in parts of the rod's size as the line sees it: s and m are
# sums of three products of numbers that carry at most six roundings each.
GUARD = 16 * float(np.finfo(float).eps)


class Frame(NamedTuple):
    """An axis as lines of one direction see it, in numbers and `vectors`.

    `start`, the origin, is the end of the axis that the lines pass first; `turned` tells whether
    that is the second one. The unit vectors `flat`, `across` and `along` are the document's f, the
    perpendicular to it, and z: the axis is run flat + rise along. The document has d for `run` and
    vz for `rise`. `length` is that of the axis, `speed` that of the direction.
    """

    start: tuple
    turned: np.ndarray
    flat: tuple
    across: tuple
    along: tuple
    run: np.ndarray
    rise: np.ndarray
    length: np.ndarray
    speed: np.ndarray


def frame(a, b, direction):
    """Return the `Frame` of axes from a to b for directions, none zero: vectors of three."""
    u, power = near_one(direction)
    turned = scalar_products(differences(b, a), u) < 0
    start = either(turned, b, a)
    end = either(turned, a, b)
    v, v_low = differences_and_rests(end, start)
    size, length = lengths(u), lengths(v)
    # For a line nearly parallel to the axis the product cancels: it is taken to its last digits,
    # with what rounding took off b - a.
    normal = sums(accurate_products(u, v), vector_products(u, v_low))
    area = lengths(normal)
    along = shares(u, size)
    across = shares(normal, where(area > 0, area, 1.0))
    return Frame(
        start,
        turned,
        vector_products(across, along),
        across,
        along,
        area / size,
        abs(scalar_products(along, v)),
        length,
        scaled(size, power),
    )


def differences_and_rests(a, b):
    """Return the differences of vectors, and exactly what rounding took off them."""
    x, x_low = two_sum(a[0], -b[0])
    y, y_low = two_sum(a[1], -b[1])
    z, z_low = two_sum(a[2], -b[2])
    return (x, y, z), (x_low, y_low, z_low)


def nearest_offset(start, along, speed, p, direction):
    """Return the vectors, in m, from `start` to the nearest points of lines, and their parameters.

    `p` are points of the lines, in m, `direction` their directions, with the unit vectors `along`
    and the lengths `speed`.
    """
    q, low = differences_and_rests(p, start)
    total = 0.0
    # From a point 1e16 sizes away the way back is off by a size: it is gone once more, from there.
    for _ in range(2):
        shift = -scalar_products(q, along) / speed
        x, x_low = _moved(q[0], low[0], shift, direction[0])
        y, y_low = _moved(q[1], low[1], shift, direction[1])
        z, z_low = _moved(q[2], low[2], shift, direction[2])
        q = (x, y, z)
        low = (x_low, y_low, z_low)
        total = total + shift
    return q, total


def _moved(here, rest, shift, way):
    """Return a coordinate and its rest, moved by shift * way."""
    step, step_rest = two_product(shift, way)
    there, rounded = two_sum(here, step)
    return two_sum(there, rounded + (step_rest + rest))


def nearest_point(axis, p, direction):
    """Return the points of lines nearest to the start of an axis: s, m, z in its `Frame`, and t.

    s counts across, m along `flat` and z along the line, all in m; t is the line's own parameter.
    `axis` is the `Frame`, and `p`, in m, and `direction` tell the lines.
    """
    q, shift = nearest_offset(axis.start, axis.along, axis.speed, p, direction)
    # An axis without a run has no plane with the line: s is the distance from it.
    s = where(axis.run > 0, scalar_products(q, axis.across), lengths(q))
    return s, scalar_products(q, axis.flat), scalar_products(q, axis.along), shift


def along_lines(axis, z, shift, hit, enter, leave):
    """Return `enter` and `leave` as parameters of lines, from an interval in m.

    `axis` is the `Frame` in which the lines lie, `z` and `shift` are the last two of
    `nearest_point`. A line that is no `hit` gets an empty interval, ``inf`` and ``-inf``.
    """
    enter = where(hit, shift + (enter - z) / axis.speed, np.inf)
    return enter, where(hit, shift + (leave - z) / axis.speed, -np.inf)


def flat_interval(run, rise, length, radius, s, m):
    """Return where lines are inside flat rods, in m along them.

    Counting begins at the plane across the line through the start of the axis.

    Parameters
    ----------
    run, rise, length : (...) float
        Of the axes, in m, as in `Frame`.
    radius : (...) float
        Of the rods, in m.
    s, m : (...) float
        Where the lines lie across the axes and along their run, in m, counted from the start.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the rod, decided in the plane across the line.
    enter, leave : (...) float
        In m; meaningless where the line misses.
    """
    solid = length > 0
    across = abs(s)
    guard, length, parallel, s = _sizes(run, length, radius, s, m)
    # With so small a run a rod as short is a disc, which may be tilted by any angle.
    parallel = parallel & (run * radius <= guard * length)
    s = where(parallel, s, across)
    # A line so nearly level with the discs that over their width it rises by less than the guard.
    level = where(parallel, False, rise * radius <= guard * length)
    # Along the line the rod's shadow is a rectangle, |s| <= r and 0 <= m <= run, with an ellipse
    # about either end, a disc seen aslant: its half width at s is k = rise/length sqrt(r^2 - s^2).
    wide = radius + guard
    k = rise / length * square_root(larger((wide - s) * (wide + s), 0.0))
    hit = (s <= wide) & (parallel | ((m >= -k - guard) & (m <= run + k + guard))) & solid
    # Lines that only the guard lets in are moved to the shadow's edge, where the formulas hold.
    m = where(parallel, m, within(m, -k, run + k))
    # The product keeps the digits that r^2 - s^2 would lose near a tangent.
    w = square_root(larger((radius - s) * (radius + s), 0.0))
    # The endless wall is entered and left at middle -+ half. A line along the axis doesn't meet it,
    # and the discs alone bound its interval.
    middle, half = ratio(m * rise, run), ratio(w * length, run)
    first = where(parallel, -np.inf, middle - half)
    last = where(parallel, np.inf, middle + half)
    # The rod is inside the wall and between the planes of its discs, where the place along the
    # axis, (run m + rise z) / length, is 0 and length. A level line stays between these planes.
    enter = where(level, first, larger(first, ratio(-run * m, rise)))
    leave = where(level, last, smaller(last, rise + ratio(run * (run - m), rise)))
    # At a touch disc and wall should give one place, and rounding may put `leave` before `enter`.
    # The place is taken from that of both which rounding moves less.
    slant = run / length
    disc = slant * slant * w <= rise / length * radius
    touch = where((enter > first) == disc, enter, leave)
    crossed = leave < enter
    return hit, where(crossed, touch, enter), where(crossed, touch, leave)


def round_interval(run, rise, length, radius, s, m):
    """Return where lines are inside capsules, as `flat_interval` does for flat rods.

    The arguments run, rise, length, radius, s and m are the same.
    """
    guard, length, parallel, s = _sizes(run, length, radius, s, m)
    wide = radius + guard
    k = square_root(larger((wide - s) * (wide + s), 0.0)) + guard
    hit = (s <= wide) & (parallel | ((m >= -k) & (m <= run + k)))
    m, run = where(parallel, 0.0, m), where(parallel, 0.0, run)
    enter, leave, _ = ball_sweep(run, rise, length, radius, s, m)
    return hit, enter, larger(enter, leave)


def ball_sweep(run, rise, length, radius, s, m):
    """Return where lines enter and leave what a ball sweeps along an axis, and their room in it.

    The arguments run, rise, length, radius, s and m are those of `flat_interval`, with a length
    above zero. The room is radius^2 less the squared distance of the line from the centre of the
    ball by which it enters, in m^2. It has no guard: it is negative where the line misses.
    """
    room = (radius - s) * (radius + s)
    k = rise / length * square_root(larger(room, 0.0))
    still = run == 0
    pace = where(still, 1.0, run)
    # The shares of the axis at which the balls are by which the line enters and leaves: where the
    # wall is crossed, or at an end of the axis if that is beyond it.
    first = where(still, 0.0, within((m - k) / pace, 0.0, 1.0))
    last = where(still, 1.0, within((m + k) / pace, 0.0, 1.0))
    behind, ahead = m - first * run, m - last * run
    before, after = room - behind * behind, room - ahead * ahead
    enter = first * rise - square_root(larger(before, 0.0))
    return enter, last * rise + square_root(larger(after, 0.0)), before


def _sizes(run, length, radius, s, m):
    """Return the guard, the lengths, which axes are parallel to their lines, and distances.

    A length of 0 comes back as 1. The distance is that of the line from the axis where both are
    parallel, and elsewhere |s|.
    """
    guard = GUARD * (radius + run)
    # So small a run moves the surface by less than the guard along the whole rod.
    parallel = run <= guard
    s = where(parallel, square_root(s * s + m * m), abs(s))
    return guard, where(length > 0, length, 1.0), parallel, s
